"""`camrob verify`: read a KRL program back, replay it, and check it, whoever wrote it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.controller.against import Coverage
from camrob.controller.judge import Judgement, judge
from camrob.controller.replay import Replay, replay
from camrob.controller.simulate import approximation
from camrob.errors import JobError, KrlError
from camrob.issues import Finding, Severity, collapse
from camrob.jobs.inputs import JobInputs, read_inputs
from camrob.jobs.release import cover_toolpath, hold_to_tool
from camrob.jobs.simulate import approximation_entry
from camrob.post.krl_program import KrlProgram
from camrob.post.krl_reader import read_krl
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["VerifyResult", "verify"]

_BLOCKING = {
    "call-unknown": "the program calls what is not there to be read",
    "not-understood": "the program holds statements that camrob does not understand",
    "tool-unknown": "the program does not say its $TOOL",
    "base-unknown": "the program does not say its $BASE",
}
"""Findings of the reader that leave open what the program does: with a CL file to hold it to, they are errors."""


@dataclass(frozen=True, slots=True)
class VerifyResult:
    """`ok` where nothing stands against the program; the summary as JSON."""

    ok: bool
    summary: Mapping[str, Any]
    findings: tuple[Finding, ...]


def verify(
    program: Path,
    *,
    cell: Path,
    against: Path | None = None,
    setup: Path | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> VerifyResult:
    """Check a program: reach, axis limits, singular postures, jumps; with `against`, every CL point met in order.

    Raises KrlError, CellError, SetupError and ToolpathError for input that can't be read.
    """
    start = time.perf_counter()

    def share(stage: str) -> Callable[[float], None]:
        return lambda done: progress(stage, done) if progress is not None else None

    text = read_krl(Path(program))
    inputs: JobInputs | None = None
    if against is not None:
        inputs = read_inputs(Path(against), cell, setup, progress=share("read"))
    machine = read_cell(cell) if inputs is None else inputs.cell
    replayed = replay(text, machine, progress=share("replay"))
    extra: list[Finding] = list(text.findings)
    coverage, feed = None, None
    if inputs is not None:
        coverage, feed = cover_toolpath(text, replayed, inputs)
        extra += hold_to_tool(replayed, inputs)
        extra += inputs.toolpath.findings
    judgement = judge(text, replayed, coverage, feed)
    findings = collapse([*extra, *judgement.findings])
    errors = [f for f in findings if f.severity is Severity.ERROR]
    if inputs is not None:
        unclear = (f for f in findings if f.code in _BLOCKING and not _vouched(f, machine))
        errors += [Finding("unclear", _BLOCKING[f.code], Severity.ERROR, line=f.line) for f in unclear]
    summary = {
        "program": Path(program).stem,
        "cell": machine.name,
        "ok": not errors,
        **_figures(text, replayed, judgement),
        "errors": [_entry(f) for f in errors],
        "warnings": [_entry(f) for f in findings if f.severity is Severity.WARNING],
        "against": None if coverage is None or inputs is None else _against(coverage, inputs),
        "seconds": round(time.perf_counter() - start, 3),
    }
    return VerifyResult(not errors, summary, tuple(findings))


def _vouched(finding: Finding, machine: Cell) -> bool:
    """Whether an unknown call is one that the cell's own hooks write, so that the cell's owner answers for it."""
    called = finding.text.partition("(")[0].upper()
    lines = (line for name in machine.controller.hooks for line in machine.controller.hook_lines(name))
    return finding.code == "call-unknown" and any(line.partition("(")[0].strip().upper() == called for line in lines)


def _figures(text: KrlProgram, replayed: Replay, judgement: Judgement) -> dict[str, Any]:
    """What the replay measured."""
    inv_kf = np.asarray(replayed.inv_kf)
    finite = inv_kf[np.isfinite(inv_kf)]
    return {
        "files": [Path(f).name for f in text.files],
        "motions": len(text),
        "samples": replayed.samples,
        "limits": {
            "margin_min": judgement.margin,
            "violations": sum(f.count for f in judgement.findings if f.code == "axis-limit"),
        },
        "singular": judgement.singular,
        "conditioning": {"inv_kf_min": float(finite.min()) if len(finite) else None},
        "jump_deg_max": rad_to_deg(float(np.max(replayed.jump, initial=0.0))),
        "second_library_error_mm_max": m_to_mm(judgement.second_library_error),
        "approximation": _approximation(text, replayed),
    }


def _against(coverage: Coverage, inputs: JobInputs) -> dict[str, Any]:
    met = coverage.motion >= 0
    return {
        "file": inputs.toolpath.source,
        "points": len(met),
        "met": int(met.sum()),
        "position_error_mm_max": m_to_mm(float(coverage.position_error.max(initial=0.0))),
        "axis_error_deg_max": rad_to_deg(float(coverage.axis_error.max(initial=0.0))),
        "stray_mm_max": m_to_mm(coverage.stray),
    }


def _approximation(program: KrlProgram, replayed: Replay) -> dict[str, Any] | None:
    """What approximate positioning takes off corners; None for a program that the ideal controller would not run."""
    try:
        return approximation_entry(approximation(program, replayed))
    except (KrlError, JobError):
        return None


def _entry(finding: Finding) -> dict[str, Any]:
    return {
        "line": finding.line, "code": finding.code, "text": finding.text, "axis": finding.axis,
        "value": finding.value, "limit": finding.limit, "unit": finding.unit, "count": finding.count,
    }  # fmt: skip
