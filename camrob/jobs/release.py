"""The gate: a program is released only if its text, read back and replayed, does what was meant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.check.collision_report import CollisionReport
from camrob.check.collisions import check_collisions
from camrob.check.margins import MarginReport, check_margins
from camrob.controller.against import Coverage, cover
from camrob.controller.intended import hold_to_intended
from camrob.controller.judge import Judgement, judge
from camrob.controller.replay import Replay, replay
from camrob.controller.trace import posture_trace
from camrob.errors import CollisionError, JobError, KrlError, VerificationError
from camrob.issues import Finding, Severity, collapse
from camrob.jobs.inputs import JobInputs
from camrob.jobs.solved import hold_to_solution
from camrob.post.krl_program import KrlProgram
from camrob.post.krl_reader import read_krl
from camrob.post.program import Program
from camrob.resolve.solution import Solution
from camrob.units import m_to_mm

__all__ = [
    "ReadBack",
    "check_release",
    "cover_toolpath",
    "hold_to_tool",
    "named_region",
    "path_collisions",
    "path_margins",
    "read_back",
]

Array = NDArray[np.float64]

TOOL_TOLERANCE = 1e-6  # m, and elements of the rotation: a frame is printed to 5 decimals, two hundred times finer


@dataclass(frozen=True, slots=True)
class ReadBack:
    """A program as its text tells it, replayed, held to the CL points, and judged."""

    text: KrlProgram
    replayed: Replay
    coverage: Coverage
    judgement: Judgement


def cover_toolpath(text: KrlProgram, replayed: Replay, inputs: JobInputs) -> tuple[Coverage, Array]:
    """How a program covers the job's CL points, and their feeds (N,), m/s, NaN in air."""
    path = inputs.path
    own = path.of_toolpath
    coverage = cover(
        np.asarray(path.base_T_tip)[own], path.line[own], np.asarray(path.region[own], np.int64),
        np.asarray(replayed.base_T_tool), np.asarray(text.kind), chord_tolerance=inputs.setup.decimate,
    )  # fmt: skip
    return coverage, np.where(path.cutting[own], path.feed[own], np.nan)


def hold_to_tool(replayed: Replay, inputs: JobInputs) -> list[Finding]:
    """An error where the text's `$TOOL` is not the set-up's tool: the arm would stand elsewhere, or the tip would."""
    off = float(np.abs(np.asarray(replayed.cell.flange_T_tool) - np.asarray(inputs.cell.flange_T_tool)).max())
    if off <= TOOL_TOLERANCE:
        return []
    text = f"the program's $TOOL is not the set-up's (they differ by {m_to_mm(off):.4f} mm or the like)"
    return [Finding("tool-differs", text, Severity.ERROR)]


def read_back(
    source: Path, program: Program, inputs: JobInputs, solution: Solution, progress: Callable[[float], None]
) -> ReadBack:
    """Read a written program back, replay it, and hold it to the CL points, to what was meant, and to what was solved.

    Raises VerificationError for the first thing that stands against it.
    """
    try:
        text = read_krl(source)
        replayed = replay(text, inputs.cell, progress=progress)
    except KrlError as error:
        raise VerificationError(f"the program was not released: it reads back wrong: {error.what}") from None
    coverage, feed = cover_toolpath(text, replayed, inputs)
    judgement = judge(text, replayed, coverage, feed)
    against = [*judgement.findings, *hold_to_tool(replayed, inputs)]
    against += hold_to_intended(text, replayed, program, inputs.cell.controller)
    if all(f.severity is not Severity.ERROR for f in against):
        against += hold_to_solution(text, replayed, coverage, inputs.path, solution)
    first = next((f for f in against if f.severity is Severity.ERROR), None)
    if first is not None:
        raise VerificationError(
            f"the program was not released: {first.text}" + (f" ({first.count} times)" if first.count > 1 else ""),
            line=first.line, axis=first.axis, value=first.value, limit=first.limit, unit=first.unit,
        )  # fmt: skip
    return ReadBack(text, replayed, coverage, judgement)


def path_collisions(back: ReadBack, inputs: JobInputs, progress: Callable[[float], None]) -> CollisionReport:
    """Collisions along the replayed program, void motions included."""
    postures, rows = posture_trace(back.text, back.replayed)
    line = np.zeros(len(back.text), np.int64)
    cutting = np.zeros(len(back.text), bool)
    region = np.full(len(back.text), -1, np.int64)
    own = inputs.path.of_toolpath
    met = back.coverage.motion
    line[met], cutting[met], region[met] = inputs.path.line[own], inputs.path.cutting[own], inputs.path.region[own]
    return check_collisions(
        back.replayed.cell, postures, cutting=cutting[rows], line=line[rows], region=region[rows],
        part_mesh=inputs.part, stock_mesh=inputs.stock, base_T_part=np.asarray(inputs.setup.base_T_part),
        tool=inputs.tool, progress=lambda done, of: progress(done / of),
    )  # fmt: skip


def path_margins(inputs: JobInputs, solution: Solution) -> MarginReport:
    """Margins, jumps and external travel of the solution itself."""
    path = inputs.path
    return check_margins(
        inputs.cell, np.asarray(solution.q), inv_kf=solution.inv_kf, cutting=path.cutting, line=path.line,
        region=path.region,
    )  # fmt: skip


def check_release(
    back: ReadBack,
    inputs: JobInputs,
    solution: Solution,
    margins: MarginReport,
    written: list[Finding],
    progress: Callable[[float], None],
) -> tuple[CollisionReport, list[Finding]]:
    """Collisions, and all findings of the job. Raises CollisionError or VerificationError where one stops the release."""
    collisions = path_collisions(back, inputs, progress)
    if collisions.count:
        first = next(f for f in collisions.findings if f.severity is Severity.ERROR)
        error = CollisionError(f"{first.text} ({collisions.count} points)", line=first.line, region=str(first.region))
        raise named_region(error, inputs)
    findings = collapse(
        [
            *inputs.toolpath.findings,
            *inputs.findings,
            *solution.findings,
            *margins.findings,
            *back.judgement.findings,
            *collisions.findings,
            *written,
        ]
    )
    stopped = next((f for f in findings if f.severity is Severity.ERROR), None)
    if stopped is not None:
        raise VerificationError(stopped.text, line=stopped.line)
    return collisions, findings


def named_region(error: JobError, inputs: JobInputs) -> JobError:
    """The same error with the region's name instead of its index."""
    regions = [r for r in inputs.toolpath.regions if len(r)]
    if not error.region.isdigit() or int(error.region) >= len(regions):
        return error
    return type(error)(
        error.what, line=error.line, region=regions[int(error.region)].name, axis=error.axis, value=error.value,
        limit=error.limit, unit=error.unit, reasons=error.reasons,
    )  # fmt: skip
