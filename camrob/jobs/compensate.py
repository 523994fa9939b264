"""`camrob compensate`: a program with which the calibrated robot meets the poses that another one asks for."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import Calibration
from camrob.calibration.calibration_file import read_calibration
from camrob.calibration.compensate import difference_sizes, pose_difference
from camrob.cell.cell import Cell
from camrob.controller.judge import Judgement, judge
from camrob.controller.replay import Replay, replay
from camrob.errors import InputError, VerificationError
from camrob.findings import Severity, first_error
from camrob.jobs.closing.corrected_head import corrected_head
from camrob.jobs.closing.correction import Correction, met_on_machine
from camrob.jobs.closing.diagnosed_machine import DiagnosedMachine
from camrob.jobs.closing.tool_chains import ToolChains, tool_poses
from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.diagnosed import diagnosed
from camrob.jobs.files.output import staged_output
from camrob.jobs.files.solution_program import check_feed, program_of_solution
from camrob.jobs.files.solved_path import is_solution, save_solution
from camrob.jobs.files.summary_file import write_summary
from camrob.jobs.files.takes_paths import takes_paths
from camrob.jobs.predicting.program_tools import pushed_in
from camrob.jobs.predicting.removal import beside_program
from camrob.jobs.predicting.removed_by_run import removal_of
from camrob.jobs.release.beside import compensated_manifest, fastest_that_cuts, said_to_be_compensated
from camrob.jobs.release.compensation import (
    analyses_before_after,
    compensation_summary,
    error_between,
    rates_and_violations,
)
from camrob.jobs.solving.sought import Sought
from camrob.kinematics.kernels import chain_arrays, inverse_kf_many
from camrob.languages import language_of_file
from camrob.prediction.read_force import read_forces
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.progress import Progress
from camrob.report.compensation.page import PathErrors, compensation_report
from camrob.summaries.compensate_summary import (
    CalibrationUsed,
    CompensateSummary,
    MarginsBeforeAfter,
    OnDiagnosedMachine,
)

__all__ = ["CompensateResult", "compensate"]

Array = NDArray[np.float64]


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
    setup: Path | None = None,
    feed: float | None = None,
    progress: Progress | None = None,
) -> CompensateResult:
    """Rewrite the targets of a program, everything else left byte for byte, and check the result by replay.

    HOME and where tools are changed stay, as they ask for axis values and no pose. Lines of comment at the head say of which
    program it was made and for which machine.

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
        setup: the set-up with stock and cutter, for a force that leaves its engagement to the removal or goes by the numbers of
            tools; None: setup.toml beside the program.
        feed: mm/min, for a solution only.
        progress: called with a stage and the share of it that is done, 0 to 1.

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
    if already := said_to_be_compensated(program):
        hint = "give the program that it was made from: its error would be taken off twice"
        raise InputError(f"is compensated already, as {already} beside it says", hint=hint, path=program)
    machine = cell_for("compensate", cell)
    found = None if calibration is None else read_calibration(calibration, machine)
    check_feed(program, feed)
    with TemporaryDirectory() as scratch:
        source = program_of_solution(program, machine, feed, Path(scratch)) if is_solution(program) else program
        language = language_of_file(source)
        text = language.read(source, machine.controller_section)
        known = _machine(found, diagnosis, force, setup, Path(cell), machine, program, text)
        made = Correction(source, found, language, machine, progress)
        if known is not None:
            made = met_on_machine(made, known, Path(scratch) / "divided")
        used = None if found is None else _used(found, calibration)
        with staged_output(out, name=source.stem) as folder:
            went_by = Sought(Path(cell), calibration, diagnosis, force).files()
            summary, after = _written(made, program, used, folder, corrected_head(program, went_by))
            manifest = compensated_manifest(folder, Path(cell), program, went_by)
            files = sorted([*(f.name for f in folder.iterdir()), f"{source.stem}.json"])
            summary = replace(summary, files=tuple(files), manifest=manifest, seconds=time.perf_counter() - start)
            write_summary(folder / f"{source.stem}.json", summary)
    return CompensateResult(summary, np.asarray(made.result.before), after)


def _machine(
    found: Calibration | None,
    diagnosis: Path | None,
    force: Path | None,
    setup: Path | None,
    folder: Path,
    cell: Cell,
    program: Path,
    text: ProgramText,
) -> DiagnosedMachine | None:
    """The machine as diagnosed, under a force, for a program; None where a calibration alone is to be met.

    Raises InputError where nobody says what is wrong with it, and for a force that the removal has to tell, and no set-up does,
    or that is of other tools than the program's.
    """
    if diagnosis is None and force is None and found is not None:
        return None
    alone = diagnosis is None and (found is not None or force is not None)
    units, rest = (None, 0.0) if alone else diagnosed(diagnosis, found, folder, cell)
    pushes = None if force is None else read_forces(force)
    if setup is not None and (pushes is None or not pushes.asks_setup):
        hint = "leave it out, or give a --force of numbered tools, or whose depth_mm or width_mm is left to the removal"
        raise InputError("is not needed: nothing asks what is cut", hint=hint, path=setup)
    removal = None
    if pushes is not None and pushes.asks_removal:
        if setup is None and not beside_program(program).is_file():
            hint = "give depth_mm and width_mm, or stock and cutter by --setup"
            raise InputError("leaves depth or width to the removal", hint=hint, path=force)
        removal = removal_of(program, text, setup, cell)
    name = "" if diagnosis is None else Path(diagnosis).name
    forces = () if pushes is None else pushed_in(pushes, program, text, cell, setup)
    return DiagnosedMachine(cell, found, units, rest, name, forces, fastest_that_cuts(program, pushes), removal)


def _used(found: Calibration, file: Path | None) -> CalibrationUsed:
    return CalibrationUsed(file="" if file is None else Path(file).name, logs=tuple(name for name, _ in found.logs))


def _written(
    work: Correction, source: Path, calibration: CalibrationUsed | None, folder: Path, head: Sequence[str]
) -> tuple[CompensateSummary, Array]:
    """Write the compensated program into a staged folder, read it back, and check it: its summary and errors (N, 2).

    source: what was given. head: lines of comment at the program's head.
    """
    text, planned, chains = work.text, work.planned, work.chains
    again, warnings = work.rewritten(np.asarray(work.result.q), folder, head)
    replayed = replay(again, planned.cell, progress=work.tell("check"))
    after = _checked(chains, work.targets, replayed, again)
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
        kept=work.kept,
        source=source.name,
        calibration=calibration,
        limits=MarginsBeforeAfter(margin_min=judged_after.margin, margin_min_before=work.judged.margin),
        between=None if shifted_too else error_between(chains, text, planned, replayed),
        rates=rates_and_violations(analyses, text, planned),
        findings=[*warnings, *work.left],
        machine=_below_head(work.on_machine, work.source.name, text, again),
    )
    _save_path(folder / f"{work.source.stem}.path.npz", replayed, text)
    page = compensation_report(
        summary,
        PathErrors(
            line=np.asarray(text.line),
            axes=tuple(j.name for j in planned.cell.joints[planned.cell.arm_slice]),
            before=np.asarray(work.result.before),
            after=after,
            correction=correction[:, planned.cell.arm_slice],
            shown=(np.asarray(text.kind) != Motion.CIRC_VIA) & ~work.kept,
        ),
        analyses,
    )
    (folder / f"{work.source.stem}.html").write_text(page, encoding="utf-8")
    return summary, after


def _below_head(
    machine: OnDiagnosedMachine | None, file: str, text: ProgramText, again: ProgramText
) -> OnDiagnosedMachine | None:
    """The machine's figures with the lines of the targets that were added to `file` as they are below its new head."""
    here = np.array([name == file for name in text.files])[np.asarray(text.file)]
    if machine is None or file not in machine.targets_added or not here.any():
        return machine
    row = int(np.flatnonzero(here)[0])
    shift = int(again.line[row]) - int(text.line[row])
    lines = tuple(line + shift for line in machine.targets_added[file])
    return replace(machine, targets_added={**machine.targets_added, file: lines})


def _save_path(file: Path, run: Replay, text: ProgramText) -> None:
    """Write NAME.path.npz of the postures at the ends of a replayed program's motions."""
    q = np.asarray(run.q)
    places = tool_poses(run, q)[:, :3, 3]
    step = np.linalg.norm(np.diff(places, axis=0), axis=1)
    save_solution(
        file,
        run.cell,
        q,
        line=np.asarray(text.line),
        region=np.zeros(len(q), np.int32),
        inv_kf=inverse_kf_many(chain_arrays(run.cell), np.array(q)),
        length=np.concatenate([[0.0], np.cumsum(step)]),
    )


def _checked(chains: ToolChains, targets: Array, replayed: Replay, again: ProgramText) -> Array:
    """Errors (N, 2) of the calibrated robot in the written program. Raises VerificationError where it deviates."""
    stopped = first_error(replayed.findings)
    if len(replayed.q) != len(targets) or stopped is not None:
        what = stopped.text if stopped else "it holds a different number of motions"
        raise VerificationError(
            f"the compensated program can't be followed: {what}; compensate less (fewer constants), or move the part",
            line=stopped.line if stopped else 0,
            of_program=True,
        )
    return difference_sizes(pose_difference(targets, chains.poses(np.asarray(replayed.q))))


def _no_new_fault(before: Judgement, after: Judgement) -> None:
    """Nothing stands against the new program that did not stand against the old one. Raises VerificationError."""
    known = {(f.code, f.axis) for f in before.findings if f.severity is Severity.ERROR}
    for finding in after.findings:
        if finding.severity is Severity.ERROR and (finding.code, finding.axis) not in known:
            raise VerificationError(
                f"compensation would bring a new fault: {finding.text}; compensate less (fewer constants), or move the part",
                line=finding.line,
                of_program=True,
            )
