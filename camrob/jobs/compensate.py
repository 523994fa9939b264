"""`camrob compensate`: a program with which the calibrated robot meets the poses that another one asks for."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import Calibration, calibrated_chain
from camrob.calibration.calibration_file import read_calibration
from camrob.calibration.compensate import Compensated, compensate_postures, difference_sizes, pose_difference
from camrob.calibration.error_model import ErrorModel
from camrob.cell.cell import Cell
from camrob.controller.judge import Judgement, judge
from camrob.controller.programmed_path import programmed_path
from camrob.controller.replay import Replay, replay
from camrob.errors import InputError, SingularError, UnreachableError, VerificationError
from camrob.findings import Finding, Severity
from camrob.jobs.closing.added_targets import lines_added, places_to_add, with_targets_added
from camrob.jobs.closing.diagnosed_machine import DiagnosedMachine, MachineRun, off_path_size, shifted
from camrob.jobs.closing.rewrite import rewritten
from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.diagnosed import diagnosed
from camrob.jobs.files.files import staged_output
from camrob.jobs.files.solution_program import check_feed, is_solution, program_of_solution, save_solution
from camrob.jobs.files.takes_paths import takes_paths
from camrob.jobs.release.compensation import (
    analyses_before_after,
    compensation_summary,
    error_between,
    rates_and_violations,
)
from camrob.languages import language_of_file
from camrob.prediction.read_force import read_force
from camrob.program.language import Language
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.progress import Progress, Share, stage_of
from camrob.report.compensation.page import PathErrors, compensation_report
from camrob.summaries.compensate_summary import (
    CalibrationUsed,
    CompensateSummary,
    MarginsBeforeAfter,
    OnDiagnosedMachine,
)
from camrob.units import m_to_mm

__all__ = ["CompensateResult", "compensate"]

Array = NDArray[np.float64]

_ROUNDS = 2  # corrections on the machine as diagnosed: the second takes what the first has changed
_BETTER = 0.98  # of the mean square off the path: a round that takes less than that off is not worth another program
_SLACK = 1.1  # by so much 95 % of the way may be farther off where the mean square is less
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
    out: Path,
    calibration: Path | None = None,
    diagnosis: Path | None = None,
    force: Path | None = None,
    feed: float | None = None,
    progress: Progress | None = None,
) -> CompensateResult:
    """Rewrite the targets of a program, everything else left byte for byte, and check the result by replay.

    With a diagnosis the program is run on the machine as diagnosed, and what is off there at the end of each motion beyond the
    calibrated chain (play on its side, friction, ripple, what follows the load) is taken off the targets too, as long as that
    brings the tool nearer to the path.

    Written are the program, the parts and data lists that it needs, NAME.path.npz (the compensated postures), the report
    NAME.html and NAME.json. A correction that would carry an axis beyond its limit is shrunk to what the limit leaves, and said.

    Args:
        program: a robot program, or a solution, NAME.path.npz, which becomes a program of one LIN a point.
        cell: the cell's folder.
        out: the folder to write into, not the program's own.
        calibration: the CALIBRATION.toml of the cell; None: a diagnosis found no constants.
        diagnosis: the folder of the diagnosis that wrote the calibration.
        force: FORCE.toml, what pushes on the tool while it cuts; what yields under it is taken off too.
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
    found = None if calibration is None else read_calibration(calibration, machine)
    known = _machine(found, diagnosis, force, Path(cell), machine)
    check_feed(program, feed)
    with TemporaryDirectory() as scratch:
        source = program_of_solution(program, machine, feed, Path(scratch)) if is_solution(program) else program
        made = _Work(source, found, language_of_file(source), machine, progress)
        if known is not None:
            made = _on_machine(made, known, Path(scratch) / "divided")
        used = None if found is None else _used(found, calibration)
        with staged_output(out, name=source.stem) as folder:
            summary, after = _written(made, program.name, used, folder)
            files = sorted([*(f.name for f in folder.iterdir()), f"{source.stem}.json"])
            summary = replace(summary, files=tuple(files), seconds=time.perf_counter() - start)
            text = json.dumps(summary.to_json(), indent=2, allow_nan=False)
            (folder / f"{source.stem}.json").write_text(text, encoding="utf-8")
    return CompensateResult(summary, np.asarray(made.result.before), after)


def _machine(
    found: Calibration | None, diagnosis: Path | None, force: Path | None, folder: Path, cell: Cell
) -> DiagnosedMachine | None:
    """The machine as diagnosed, under a force; None where a calibration alone is to be met.

    Raises InputError where nobody says what is wrong with it, and for a force that the removal would have to tell.
    """
    if diagnosis is None and force is None and found is not None:
        return None
    alone = diagnosis is None and (found is not None or force is not None)
    units, rest = (None, 0.0) if alone else diagnosed(diagnosis, found, folder, cell)
    pushes = None if force is None else read_force(force)
    if pushes is not None and pushes.asks_removal:
        raise InputError("leaves depth or width to the removal", hint="give depth_mm and width_mm", path=force)
    return DiagnosedMachine(cell, found, units, rest, "" if diagnosis is None else Path(diagnosis).name, pushes)


def _used(found: Calibration, file: Path | None) -> CalibrationUsed:
    return CalibrationUsed(file="" if file is None else Path(file).name, logs=tuple(name for name, _ in found.logs))


class _Work:
    """A program on its way: read, replayed, judged and compensated. targets: (N, 4, 4) what the calibrated chain is to meet.

    more: whether these hold more than the chain's constants.
    """

    def __init__(
        self,
        source: Path,
        found: Calibration | None,
        language: Language,
        machine: Cell,
        progress: Progress | None,
    ) -> None:
        self.source, self.found, self.language, self.machine = source, found, language, machine
        self.text = text = language.read(source)
        self.progress = progress
        self.planned = replay(text, machine, progress=self.tell("replay"))
        self.judged = judge(text, self.planned)
        _followed(self.planned)
        self.model, self.values = calibrated_chain(found, self.planned.one_tool(text))
        self.q = _postures(text, self.planned)
        self.targets = np.asarray(self.planned.base_T_tool)
        self.result, self.left = self._compensated(self.targets)
        self.on_machine: OnDiagnosedMachine | None = None
        self.off_path, self.more = np.zeros(0), False

    def tell(self, stage: str) -> Share:
        """What one stage tells."""
        return stage_of(self.progress, stage)

    def _compensated(self, targets: Array) -> tuple[Compensated, list[Finding]]:
        tell = self.tell("compensate")
        return _compensated(self.model, self.values, self.planned, self.q, targets, self.text, tell)

    def rewritten(self, q: Array, folder: Path) -> tuple[ProgramText, list[Finding]]:
        """The program whose targets postures q (N, n) reach, written into a folder and read back; what was left as it is."""
        return rewritten(self.source, self.language, self.text, self.planned, q, folder)

    def run_on(self, known: DiagnosedMachine, progress: Share | None = None) -> MachineRun:
        """The program as it stands, with this work's corrections, on the machine as diagnosed."""
        with TemporaryDirectory() as scratch:
            program = self.rewritten(np.asarray(self.result.q), Path(scratch))[0]
            return known.run(program, progress=progress)

    def meet_on(self, known: DiagnosedMachine) -> Array:
        """Take off the targets what the machine as diagnosed does beyond the calibrated chain, while that brings the tool nearer
        to the path: most of it is taken at once, as errors are smooth beside corrections.

        Returns (K,) m off the path with the chain's constants corrected; what stays is `off_path`.
        """
        intended = programmed_path(self.text, self.planned)
        told = self.tell("run on the machine as diagnosed")

        def run(turn: int) -> tuple[MachineRun, Array]:
            now = self.run_on(known, lambda share: told((turn + share) / (_ROUNDS + 1)))
            return now, now.off_path(intended)

        now, self.off_path = run(0)
        constants, meant = self.off_path, self.targets
        for turn in range(1, _ROUNDS + 1):
            was = self.result, self.left
            targets = shifted(meant, now.beyond_at_ends())
            self.result, self.left = self._compensated(targets)
            now, off = run(turn)
            if not _worth(off, self.off_path):
                self.result, self.left = was
                break
            self.targets, self.off_path, self.more = targets, off, True
        return constants


def _worth(off: Array, best: Array) -> bool:
    """Whether distances off the path, m, are worth another program than the one with the `best` so far."""
    return bool(
        np.mean(off**2) < _BETTER * np.mean(best**2) and np.quantile(off, 0.95) <= _SLACK * np.quantile(best, 0.95)
    )


def _on_machine(made: _Work, known: DiagnosedMachine, scratch: Path) -> _Work:
    """The work on the machine as diagnosed: with targets added to the program where that brings the tool nearer to its path."""
    as_it_was = known.run(made.text, progress=made.tell("run as it is on the machine as diagnosed"))
    before = as_it_was.off_path(programmed_path(made.text, made.planned))
    constants, added = made.meet_on(known), dict[str, tuple[int, ...]]()
    places = places_to_add(as_it_was, made.language, made.source.parent)
    if places:
        scratch.mkdir()
        divided = with_targets_added(made.source, made.language, made.text, made.planned, places, scratch)
        finer = _Work(divided, made.found, made.language, made.machine, made.progress)
        finer.judged = made.judged  # nothing may stand against the new program that did not stand against the one given
        finer.meet_on(known)
        if _worth(finer.off_path, made.off_path):
            added, made = lines_added(made.text, places), finer
    made.on_machine = OnDiagnosedMachine(
        diagnosis=known.name,
        causes=as_it_was.further_causes() if made.more else (),
        not_reckoned=as_it_was.path.not_reckoned,
        rest_mm=float(m_to_mm(known.rest * np.sqrt(3.0))),
        targets_added=added,
        before=off_path_size(before),
        constants=off_path_size(constants),
        after=off_path_size(made.off_path),
    )
    return made


def _written(
    work: _Work, source: str, calibration: CalibrationUsed | None, folder: Path
) -> tuple[CompensateSummary, Array]:
    """Write the compensated program into a staged folder, read it back, and check it: its summary and errors (N, 2).

    source: the name of what was given.
    """
    text, planned, model, values = work.text, work.planned, work.model, work.values
    again, warnings = work.rewritten(np.asarray(work.result.q), folder)
    replayed = replay(again, planned.cell, progress=work.tell("check"))
    after = _checked(model, values, work.targets, replayed, again)
    judged_after = judge(again, replayed)
    _no_new_fault(work.judged, judged_after)
    correction = np.asarray(work.result.q) - work.q
    analyses = analyses_before_after(planned.cell, text, np.asarray(planned.q), np.asarray(replayed.q))
    # beside targets that were moved for more than the chain, the chain's own error between them says nothing
    shifted_too = work.on_machine is not None and bool(work.on_machine.causes)
    summary = compensation_summary(
        text,
        None if work.found is None else work.found.errors.get("calibrated/withheld"),
        work.result,
        correction,
        planned,
        after,
        source=source,
        calibration=calibration,
        limits=MarginsBeforeAfter(margin_min=judged_after.margin, margin_min_before=work.judged.margin),
        between=None if shifted_too else error_between(model, values, text, planned, replayed),
        rates=rates_and_violations(analyses, text, planned),
        findings=[*warnings, *work.left],
        machine=work.on_machine,
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
    model: ErrorModel,
    values: Array,
    planned: Replay,
    q: Array,
    targets: Array,
    text: ProgramText,
    progress: Share,
) -> tuple[Compensated, list[Finding]]:
    """Compensated postures within the axes' limits, and what was left because of them."""
    cell = planned.cell
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
