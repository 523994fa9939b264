"""`camrob verify`: what does a program do, whoever wrote it, and is that what its CL file asks for?

The witness judges, as it does for `post`; the replay and the collision check, which `post` goes through as well, stand beside it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np

from camrob.cell.cell import Cell
from camrob.checks.collision_report import CollisionReport, joined_collisions
from camrob.checks.collisions import check_collisions
from camrob.controller.against import Coverage
from camrob.controller.judge import Judgement, judge
from camrob.controller.replay import Replay, replay
from camrob.controller.simulate import approximation, blocks_of
from camrob.controller.trace import posture_trace
from camrob.errors import InputError, JobError, ProgramError
from camrob.findings import Finding, Severity, collapse, first_error
from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.inputs import JobInputs, read_inputs
from camrob.jobs.files.takes_paths import takes_paths
from camrob.jobs.release.as_corrected import hold_to_original
from camrob.jobs.release.beside import manifest_findings, reason_for_slower
from camrob.jobs.release.opinion import of_program
from camrob.jobs.release.release import ReadBack, cover_toolpath, hold_to_tool, path_collisions
from camrob.jobs.simulate import approximated
from camrob.jobs.solving.short_motions import block_figures
from camrob.languages import language_of_file
from camrob.program.program_text import ProgramText
from camrob.progress import Progress, Share, stage_of
from camrob.summaries.remarks import AxisLimits, JudgedRemark
from camrob.summaries.verify_summary import (
    Against,
    Judged,
    LeastConditioning,
    ProgramEvents,
    ReplayFigures,
    VerifySummary,
)
from camrob.units import m_to_mm, rad_to_deg
from camrob.witness.judge import Verdict
from camrob.witness.judge import judge as witness_judge

__all__ = ["VerifyResult", "verify"]

_T = TypeVar("_T")

_SECOND_HAND = frozenset({"call-unknown", "not-understood", "tool-unknown", "base-unknown"})
"""Findings of the replay's reader on what the witness has its own word for."""

_BY_SET_UP = Finding(
    "setup-in-part",
    "of the set-up the tools' frames and masses are looked at; its part and stock, and the part's place, are with --against "
    "CLFILE, which says what cuts",
)


@dataclass(frozen=True, slots=True)
class VerifyResult:
    """`ok`: True where nothing stands against the program, False where something does, None where not all could be judged."""

    ok: bool | None
    summary: VerifySummary
    findings: tuple[Finding, ...]


@dataclass(frozen=True, slots=True)
class _Replayed:
    """The program as it was replayed, held to its CL points where there are any."""

    text: ProgramText
    replayed: Replay
    judgement: Judgement
    coverage: Coverage | None
    collisions: CollisionReport | None
    findings: tuple[Finding, ...]


@takes_paths
def verify(
    program: Path,
    *,
    cell: Path,
    against: Path | None = None,
    setup: Path | None = None,
    begin: int = 0,
    clamping: str | None = None,
    collisions: bool = True,
    manifest: bool = True,
    original: Path | None = None,
    calibration: Path | None = None,
    out: Path | None = None,
    progress: Progress | None = None,
) -> VerifyResult:
    """Judge a program, whoever wrote it: frames, all its motions, axis limits, collisions; with `against`, its CL file too.

    Args:
        program: the program's main file, in any robot language that is known.
        cell: the cell's folder.
        against: the CL file that the program was made from; None: path and process are not held to one.
        setup: setup.toml; None: the one beside the CL file, where there is one. Without `against` the program's loads are held
            to it by the tools' frames, and no more.
        begin: the CL file's line from which on the program does what it asks for, of a program that is entered again at an
            operation; 0: all of it.
        clamping: of a part that is worked from several sides, the set-up's [[clamping]] that the program is for.
        collisions: whether bodies are followed along the whole program.
        manifest: whether the files have to be those that the NAME.json beside the program names.
        original: of a program that `compensate` has made, the one that it was made of: that one is judged, held to `against`, and
            the program to it: all but the targets of motions alike, and the calibrated robot on the original's poses.
        calibration: the CALIBRATION.toml that it was corrected for; needed with `original`.
        out: the folder that receives verify.json and verify.html, a page with pictures of places; None: none.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Returns:
        `ok`: True where nothing stands against the program, False where something does, None where not all could be judged;
        `findings` say what and where.

    Raises:
        ProgramError, CellError, SetupError, ToolpathError: input that can't be read.

    Example:
        >>> engraving = Path("toolpaths/engraving/engraving.cls")
        >>> result = camrob.verify(Path("out/engraving.src"), cell=Path("cells/kr15_track_table"), against=engraving)
        >>> result.ok, result.summary.errors
        (True, ())
    """
    start = time.perf_counter()
    share = partial(stage_of, progress)
    machine = cell_for("verify", cell)
    _of_no_file(against, begin, clamping)
    if original or calibration:
        asked = partial(verify, cell=cell, against=against, setup=setup, begin=begin, clamping=clamping)
        given = program, (original, calibration), asked, machine, (collisions, manifest)
        return _told(*_of_corrected(*given, share), out, share)
    inputs: JobInputs | None = None
    if against is not None:
        inputs = read_inputs(against, machine, setup, begin=begin, clamping=clamping, progress=share("read"))
        machine, setup = inputs.cell, inputs.setup.path
    share("witness")(0.0)
    kept = manifest_findings(program, cell, against, setup) if manifest else []
    slower = "" if not manifest or first_error(kept) else reason_for_slower(program)
    verdict = witness_judge(
        program, cell, clfile=against, setup=setup, slower_allowed=slower, begin=begin, clamping=clamping
    )
    not_judged = list(verdict.unjudged)
    found = [*kept, *of_program(verdict), *([] if setup is None or against is not None else [_BY_SET_UP])]
    second: _Replayed | None = None
    try:
        second = _replayed(program, machine, inputs, collisions, share)
    except (ProgramError, JobError) as error:
        not_judged.append(f"replay and collisions: {error}")
    first, last = ((), ()) if inputs is None else (_of_file(inputs.urgent), _of_file(inputs.toolpath.findings))
    found = collapse([*first, *found, *_further(found, second), *last])
    errors = [f for f in found if f.severity is Severity.ERROR]
    ok = None if not_judged and not errors else not errors
    summary = VerifySummary(
        program=program.stem,
        cell=machine.name,
        ok=ok,
        judged=_judged(verdict, second, collisions),
        not_judged=tuple(not_judged),
        errors=tuple(JudgedRemark.of(f) for f in errors),
        warnings=tuple(JudgedRemark.of(f) for f in found if f.severity is Severity.WARNING),
        process=ProgramEvents.from_json(verdict.process),
        files=(program.name,) if second is None else tuple(Path(f).name for f in second.text.files),
        motions=None if second is None else len(second.text),
        replay=None if second is None else _figures(second),
        against=None if inputs is None or second is None else _against(second.coverage, inputs),
        seconds=round(time.perf_counter() - start, 3),
    )
    return _told(summary, second, found, out, share)


def _told(
    summary: VerifySummary,
    second: _Replayed | None,
    found: Sequence[Finding],
    out: Path | None,
    share: Callable[[str], Share],
) -> VerifyResult:
    """The result, with its page where one is asked for."""
    if out is not None:
        from camrob.jobs.release.verify_page import write_page

        share("report")(0.0)
        write_page(out, summary, None if second is None else (second.text, second.replayed))
    return VerifyResult(summary.ok, summary, tuple(found))


def _of_corrected(
    program: Path,
    pair: tuple[Path | None, Path | None],
    asked: Callable[..., VerifyResult],
    machine: Cell,
    checks: tuple[bool, bool],
    share: Callable[[str], Share],
) -> tuple[VerifySummary, _Replayed, list[Finding]]:
    """A program that `compensate` has made: its original as it is `asked` for, and itself beside that."""
    original, calibration = pair
    if original is None or calibration is None:
        raise InputError("a compensated program is held to its original by what it was corrected for", hint="give both")
    start = time.perf_counter()
    collisions, manifest = checks
    kept = manifest_findings(program, machine.folder, None, None) if manifest else []
    first = asked(original, collisions=collisions, manifest=manifest)
    second = _replayed(program, machine, None, collisions, share)
    text = language_of_file(original).read(original, machine.controller_section)
    runs = (second.text, second.replayed), (text, replay(text, machine))
    figures, off = hold_to_original(*runs, original, calibration, machine)
    own = [*kept, *off, *_further([], second)]
    found = collapse([*(replace(f, text=f"of the original: {f.text}") for f in first.findings), *own])
    errors = [f for f in found if f.severity is Severity.ERROR]
    summary = replace(
        first.summary,
        program=program.stem,
        ok=False if errors else first.ok,
        errors=tuple(JudgedRemark.of(f) for f in errors),
        warnings=tuple(JudgedRemark.of(f) for f in found if f.severity is Severity.WARNING),
        files=tuple(Path(f).name for f in second.text.files),
        motions=len(second.text),
        replay=_figures(second),
        corrected=figures,
        seconds=round(time.perf_counter() - start, 3),
    )
    return summary, second, found


def _replayed(
    program: Path,
    machine: Cell,
    inputs: JobInputs | None,
    collisions: bool,
    share: Callable[[str], Share],
) -> _Replayed:
    """The program through the reader, the replay and the collision check of `post`. Raises ProgramError, JobError."""
    text = language_of_file(program).read(program, machine.controller_section)
    replayed = replay(text, machine, progress=share("replay"))
    coverage, feed, findings = None, None, list(text.findings)
    if inputs is not None:
        coverage, feed = cover_toolpath(text, replayed, inputs)
        findings += hold_to_tool(replayed, inputs, coverage)
    judgement = judge(text, replayed, coverage, feed)
    missed = () if coverage is None else coverage.findings
    findings += [*_of_file(missed), *(_placed(f, text) for f in judgement.findings if f not in missed)]
    report = None
    if collisions and judgement.good:
        if inputs is not None and coverage is not None:
            report = path_collisions(ReadBack(text, replayed, coverage, judgement), inputs, share("collisions"))
            findings += [_placed(replace(f, cl_line=f.line), text) for f in report.findings]
        else:
            report = _cell_collisions(text, replayed, share("collisions"))
            findings += report.findings
    return _Replayed(text, replayed, judgement, coverage, report, tuple(findings))


def _of_no_file(against: Path | None, begin: int, clamping: str | None) -> None:
    """Raise InputError where a CL file that is not there is asked something of."""
    if against is None and (begin or clamping is not None):
        option = "--begin" if begin else "--clamping"
        raise InputError(
            f"{option} says what of a CL file the program does, and none is given", hint="add --against CLFILE"
        )


def _of_file(findings: Sequence[Finding]) -> list[Finding]:
    """Findings on the CL file: their lines are its."""
    return [replace(f, line=0, cl_line=f.line) for f in findings]


def _placed(f: Finding, text: ProgramText) -> Finding:
    """A finding on a motion of the program, by the line and the file that it stands in."""
    if f.point < 0:
        return f
    file = int(text.file[f.point])
    return replace(f, line=int(text.line[f.point]), file=Path(text.files[file]).name if file else "")


def _cell_collisions(text: ProgramText, replayed: Replay, progress: Share) -> CollisionReport:
    """Collisions of the cell's own bodies along a program whose part nobody knows, with each of its tools."""
    postures, owner = posture_trace(text, replayed)
    reports = []
    for k, cell in enumerate(replayed.cells):
        here = np.asarray(replayed.mounted)[owner] == k
        line = np.asarray(text.line)[owner[here]]
        reports.append(check_collisions(cell, postures[here], line=line, progress=progress))
    return reports[0] if len(reports) == 1 else joined_collisions(reports)


def _further(found: Sequence[Finding], second: _Replayed | None) -> list[Finding]:
    """What the replay found where the witness has nothing to say of the same line."""
    if second is None:
        return []
    errors = {f.line for f in found if f.severity is Severity.ERROR}
    return [
        f
        for f in second.findings
        if f.code not in _SECOND_HAND and not (f.severity is Severity.ERROR and f.line in errors)
    ]


def _judged(verdict: Verdict, second: _Replayed | None, asked: bool) -> Judged:
    """The witness's judgement of the areas, with the collisions and the limits of the replay."""
    judged = dict(verdict.judged)
    report = None if second is None else second.collisions
    judged["collisions"] = None if report is None or not asked or not report.checked else report.count == 0
    if second is None and judged["limits"]:
        judged["limits"] = None  # axis values that nobody replayed
    elif second is not None and any(f.code == "axis-limit" for f in second.judgement.findings):
        judged["limits"] = False
    return Judged.from_json(judged)


def _figures(second: _Replayed) -> ReplayFigures:
    """What the replay measured."""
    text, replayed, judgement = second.text, second.replayed, second.judgement
    inv_kf = np.asarray(replayed.inv_kf)
    finite = inv_kf[np.isfinite(inv_kf)]
    return ReplayFigures(
        samples=replayed.samples,
        limits=AxisLimits(
            margin_min=judgement.margin,
            violations=sum(f.count for f in judgement.findings if f.code == "axis-limit"),
        ),
        singular=judgement.singular,
        conditioning=LeastConditioning(inv_kf_min=float(finite.min()) if len(finite) else None),
        jump_deg_max=rad_to_deg(float(np.max(replayed.jump, initial=0.0))),
        second_library_error_mm_max=m_to_mm(judgement.second_library_error),
        approximation=_run_ideally(text, replayed, lambda t, r: approximated(approximation(t, r))),
        blocks=_run_ideally(text, replayed, lambda t, r: block_figures(blocks_of(t, r))),
    )


def _against(coverage: Coverage | None, inputs: JobInputs) -> Against | None:
    if coverage is None:
        return None
    met = coverage.motion >= 0
    return Against(
        file=inputs.toolpath.source,
        points=len(met),
        met=int(met.sum()),
        position_error_mm_max=m_to_mm(float(coverage.position_error.max(initial=0.0))),
        axis_error_deg_max=rad_to_deg(float(coverage.axis_error.max(initial=0.0))),
        deviation_mm_max=m_to_mm(coverage.deviation),
    )


def _run_ideally(program: ProgramText, replayed: Replay, ask: Callable[[ProgramText, Replay], _T]) -> _T | None:
    """What is asked of a run on the ideal controller; None for a program that it would not run."""
    try:
        return ask(program, replayed)
    except (ProgramError, JobError):
        return None
