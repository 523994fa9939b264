"""`camrob compensate`: a program with which the calibrated robot meets the poses that another one asks for."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import Calibration
from camrob.calibration.calibration_file import read_calibration
from camrob.calibration.compensate import Compensated, compensate_postures, difference_sizes, pose_difference
from camrob.calibration.error_model import ErrorModel
from camrob.cell.cell import Cell
from camrob.controller.judge import Judgement, judge
from camrob.controller.replay import Replay, base_offsets, replay
from camrob.errors import InputError, ProgramError, SingularError, UnreachableError, VerificationError
from camrob.findings import Finding, Severity
from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.files import staged_output
from camrob.jobs.files.solution_program import check_feed, is_solution, program_of_solution, save_solution
from camrob.jobs.files.takes_paths import takes_paths
from camrob.jobs.release.compensation import (
    analyses_before_after,
    compensation_summary,
    error_between,
    rates_and_violations,
)
from camrob.kinematics.frames import base_T_tool, seen_by_program
from camrob.languages import language_of_file
from camrob.program.builder import printed_frames
from camrob.program.language import Language, NewTarget
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.progress import Progress, Share, stage_of
from camrob.report.compensation.page import PathErrors, compensation_report
from camrob.se3 import inverse
from camrob.summaries.compensate_summary import CompensateSummary, MarginsBeforeAfter

__all__ = ["CompensateResult", "compensate"]

Array = NDArray[np.float64]

_GUARD = 2e-6  # rad to a limit: what rounding the printed pose may move an axis by


@dataclass(frozen=True, slots=True)
class CompensateResult:
    """The summary; error_before, error_after (N, 2): m and rad at the motions' ends."""

    summary: CompensateSummary
    error_before: Array
    error_after: Array


@takes_paths
def compensate(
    program: Path,
    *,
    cell: Path,
    calibration: Path,
    out: Path,
    feed: float | None = None,
    progress: Progress | None = None,
) -> CompensateResult:
    """Rewrite the targets of a program, everything else left byte for byte, and check the result by replay.

    Written are the program, the parts and data lists that it needs, NAME.path.npz (the compensated postures), the report
    NAME.html and NAME.json. A correction that would carry an axis beyond its limit is shrunk to what the limit leaves, and said.

    Args:
        program: a robot program, or a solution, NAME.path.npz, which becomes a program of one LIN a point.
        cell: the cell's folder.
        calibration: the CALIBRATION.toml of the cell.
        out: the folder to write into, not the program's own.
        feed: mm/min, for a solution only.
        progress: is told a stage and the share of it that is done, 0 to 1.

    Returns:
        The summary, and the errors before and after (N, 2) in m and rad, a row a motion (of a CIRC's auxiliary points
        they say nothing).

    Raises:
        ProgramError, LogError, CellError, StaleInputError, InputError: input that is wrong.
        UnreachableError, SingularError: a pose can't be met.
        VerificationError: the written program, read back, does not do it.

    Example:
        >>> cell, fitted = Path("cells/kr15_track_table"), Path("out/calibration.toml")
        >>> program = Path("out/engraving.src")
        >>> result = camrob.compensate(program, cell=cell, calibration=fitted, out=Path("out/compensated"))
        >>> result.summary.error_after.max_mm < 1e-3
        True
    """
    start = time.perf_counter()
    program, out = Path(program), Path(out)
    if out.is_dir() and out.resolve() == program.resolve().parent:
        raise InputError("is the program's own folder", hint="choose another --out: the original must stay", path=out)
    machine = cell_for("compensate", cell)
    found = read_calibration(calibration, machine)
    check_feed(program, feed)
    with TemporaryDirectory() as scratch:
        source = program_of_solution(program, machine, feed, Path(scratch)) if is_solution(program) else program
        made = _Work(source, found, language_of_file(source), machine, progress)
        with staged_output(out, name=source.stem) as folder:
            summary, after = _written(made, program.name, Path(calibration).name, folder)
            files = sorted([*(f.name for f in folder.iterdir()), f"{source.stem}.json"])
            summary = replace(summary, files=tuple(files), seconds=time.perf_counter() - start)
            text = json.dumps(summary.to_json(), indent=2, allow_nan=False)
            (folder / f"{source.stem}.json").write_text(text, encoding="utf-8")
    return CompensateResult(summary, np.asarray(made.result.before), after)


class _Work:
    """A program on its way: read, replayed, judged and compensated."""

    def __init__(
        self,
        source: Path,
        found: Calibration,
        language: Language,
        machine: Cell,
        progress: Progress | None,
    ) -> None:
        self.source, self.found, self.language = source, found, language
        self.text = text = language.read(source)
        self.progress = progress
        self.planned = replay(text, machine, progress=self.tell("replay"))
        self.judged = judge(text, self.planned)
        _followed(self.planned)
        self.model, self.values = found.model(self.planned.one_tool(text), in_base=True)
        self.q = _postures(text, self.planned)
        self.result, self.left = _compensated(
            self.model, self.values, self.planned, self.q, text, self.tell("compensate")
        )

    def tell(self, stage: str) -> Share:
        """What one stage tells."""
        return stage_of(self.progress, stage)


def _written(work: _Work, source: str, calibration: str, folder: Path) -> tuple[CompensateSummary, Array]:
    """Write the compensated program into a staged folder, read it back, and check it: its summary and errors (N, 2).

    source, calibration: names of what was given.
    """
    text, planned, model, values = work.text, work.planned, work.model, work.values
    sources, warnings = _patched(work.source.parent, work.language, text, planned, np.asarray(work.result.q))
    _write(folder, work.source.parent, work.language, text, sources)
    again = work.language.read(folder / work.source.name)
    replayed = replay(again, planned.cell, progress=work.tell("check"))
    after = _checked(model, values, np.asarray(planned.base_T_tool), replayed, again)
    judged_after = judge(again, replayed)
    _no_new_fault(work.judged, judged_after)
    correction = np.asarray(work.result.q) - work.q
    analyses = analyses_before_after(planned.cell, text, np.asarray(planned.q), np.asarray(replayed.q))
    summary = compensation_summary(
        text,
        work.found,
        work.result,
        correction,
        planned,
        after,
        source=source,
        calibration=calibration,
        limits=MarginsBeforeAfter(margin_min=judged_after.margin, margin_min_before=work.judged.margin),
        between=error_between(model, values, text, planned, replayed),
        rates=rates_and_violations(analyses, text, planned),
        findings=[*warnings, *work.left],
    )
    save_solution(folder / f"{work.source.stem}.path.npz", planned.cell, np.asarray(replayed.q), text)
    page = compensation_report(
        summary,
        PathErrors(
            line=np.asarray(text.line),
            axes=tuple(j.name for j in planned.cell.joints[planned.cell.arm_slice]),
            before=np.asarray(work.result.before),
            after=after,
            correction=correction[:, planned.cell.arm_slice],
            shown=np.asarray(text.kind) != Motion.CIRC_VIA,
        ),
        analyses,
    )
    (folder / f"{work.source.stem}.html").write_text(page, encoding="utf-8")
    return summary, after


def _followed(planned: Replay) -> None:
    """The original can be replayed. Raises UnreachableError."""
    stopped = [f for f in planned.findings if f.severity is Severity.ERROR]
    if stopped:
        raise UnreachableError(f"the program can't be followed as it is: {stopped[0].text}", line=stopped[0].line)


def _postures(text: ProgramText, planned: Replay) -> Array:
    """The motions' postures (N, n); at a CIRC's auxiliary point the other axes are half-way, the arm meets the point."""
    q = np.array(planned.q)
    via = np.flatnonzero(np.asarray(text.kind) == Motion.CIRC_VIA)
    if len(via):
        half_way = 0.5 * (q[np.maximum(via - 1, 0)] + q[via + 1])
        nominal = ErrorModel.of(planned.cell, (), in_base=True)
        targets = np.asarray(planned.base_T_tool)[via]
        q[via] = compensate_postures(nominal, np.zeros(0), half_way, targets, farthest=np.pi).q
    return q


def _compensated(
    model: ErrorModel, values: Array, planned: Replay, q: Array, text: ProgramText, progress: Share
) -> tuple[Compensated, list[Finding]]:
    """Compensated postures within the axes' limits, and what was left because of them."""
    cell, targets = planned.cell, np.asarray(planned.base_T_tool)
    try:
        result = compensate_postures(model, values, q, targets, progress=progress)
    except SingularError as error:
        row = int(error.value or 0.0)
        what = "the pose can't be compensated: the arm is singular there"
        raise SingularError(what, line=int(text.line[row])) from None
    return _within_limits(cell, q, result, text)


def _within_limits(cell: Cell, q: Array, result: Compensated, text: ProgramText) -> tuple[Compensated, list[Finding]]:
    """Corrections shrunk, point by point, to what the limits leave of them; so they fade where an axis nears its limit."""
    part = cell.arm_slice
    wanted = (np.asarray(result.q) - q)[:, part]
    room = np.where(wanted > 0.0, cell.q_upper[part] - q[:, part], q[:, part] - cell.q_lower[part])
    room = np.maximum(room - _GUARD, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(np.abs(wanted) > room, room / np.abs(wanted), 1.0)
    least = np.min(share, axis=1)
    short = np.flatnonzero(least < 1.0)
    if not len(short):
        return result, []
    kept = np.array(result.q)
    kept[:, part] = q[:, part] + least[:, None] * wanted
    findings = []
    for axis in np.unique(np.argmin(share[short], axis=1)):
        rows = short[np.argmin(share[short], axis=1) == axis]
        joint = cell.joints[part.start + int(axis)]
        count = f"{len(rows)} points are" if len(rows) > 1 else "1 point is"
        what = f"{count} corrected in part only: {joint.name} is at its limit"
        findings.append(Finding("limit", what, line=int(text.line[rows[0]]), axis=joint.name, count=len(rows)))
    return replace(result, q=kept), findings


def _printed_poses(text: ProgramText, cell: Cell, q: Array) -> Array:
    """X .. C (N, 6), mm and degrees in the program's base, of the nominal robot in postures q (N, n)."""
    return printed_frames(inverse(base_offsets(text)) @ seen_by_program(cell, q, base_T_tool(cell, q)))


def _patched(
    folder: Path, language: Language, text: ProgramText, planned: Replay, q: Array
) -> tuple[dict[str, str], list[Finding]]:
    """The files' new texts (latin-1), and what was left as it is."""
    poses = _printed_poses(text, planned.cell, q)
    axes = planned.cell.to_axis_values(q)[:, :6]
    sources = {name: (folder / name).read_bytes().decode("latin-1") for name in text.files}
    lines = {name: source.split("\n") for name, source in sources.items()}
    wanted: dict[str, dict[int, list[NewTarget]]] = {name: {} for name in sources}
    warnings: list[Finding] = []
    table_of = {True: axes.tolist(), False: poses.tolist()}
    row = 0
    while row < len(text):
        count = 2 if text.kind[row] == Motion.CIRC_VIA else 1
        name, line = text.files[text.file[row]], int(text.line[row])
        by_axes = text.kind[row] == Motion.PTP_AXES
        if by_axes and language.targets(lines[name][line - 1]) == 0:
            warnings.append(Finding("left", "a PTP to a named posture is left as it is", line=line))
        else:
            table = table_of[bool(by_axes)]
            new = [NewTarget(tuple(table[row + k]), bool(by_axes)) for k in range(count)]
            old = wanted[name].setdefault(line, new)
            if _apart(old, new):
                what = "the motion runs several times and needs another correction each time"
                raise ProgramError(what, hint="write the loop out", path=folder / name, line=line)
        row += count
    for name, source in sources.items():
        try:
            sources[name] = language.patch(source, wanted[name])
        except ProgramError as error:
            raise error.at(folder / name) from None
    return sources, warnings


def _apart(old: list[NewTarget], new: list[NewTarget]) -> bool:
    """Whether two passes of one line ask for different targets."""
    both = zip(old, new, strict=True)
    return any(float(np.max(np.abs(np.subtract(a.values, b.values)))) > 1e-6 for a, b in both)


def _write(folder: Path, origin: Path, language: Language, text: ProgramText, sources: Mapping[str, str]) -> None:
    """The program's files; data lists go along unchanged."""
    for name, source in sources.items():
        (folder / name).write_bytes(source.encode("latin-1"))
    stems = {Path(name).stem.lower() for name in text.files}
    for file in origin.iterdir():
        if file.suffix.lower() in language.suffixes[1:] and file.stem.lower() in stems and file.is_file():
            (folder / file.name).write_bytes(file.read_bytes())


def _checked(model: ErrorModel, values: Array, targets: Array, replayed: Replay, again: ProgramText) -> Array:
    """Errors (N, 2) of the calibrated robot in the written program. Raises VerificationError where it deviates."""
    if len(replayed.q) != len(targets) or any(f.severity is Severity.ERROR for f in replayed.findings):
        stopped = next((f for f in replayed.findings if f.severity is Severity.ERROR), None)
        what = stopped.text if stopped else "it holds another number of motions"
        raise VerificationError(
            f"the compensated program can't be followed: {what}", line=stopped.line if stopped else 0
        )
    return difference_sizes(pose_difference(targets, model.poses(values, np.asarray(replayed.q))))


def _no_new_fault(before: Judgement, after: Judgement) -> None:
    """Nothing stands against the new program that did not stand against the old one. Raises VerificationError."""
    known = {(f.code, f.axis) for f in before.findings if f.severity is Severity.ERROR}
    for finding in after.findings:
        if finding.severity is Severity.ERROR and (finding.code, finding.axis) not in known:
            raise VerificationError(f"compensation would bring a new fault: {finding.text}", line=finding.line)
