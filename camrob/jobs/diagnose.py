"""`camrob diagnose`: from logs to diagnosis.json and diagnosis.html."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from camrob.calibration.calibration_file import calibration_text
from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.errors import InputError, JobError, LogError
from camrob.gap.cell_effects import cell_effects
from camrob.gap.diagnose import diagnose as run_diagnosis
from camrob.gap.diagnosis import Diagnosis
from camrob.jobs.experiment import check_experiment_name, write_experiment
from camrob.jobs.files.output import check_file_name, check_folder, staged_output
from camrob.jobs.files.summary_file import write_summary
from camrob.jobs.files.takes_paths import takes_paths
from camrob.jobs.release.beside import player_beside
from camrob.languages import language_of_file
from camrob.measurement.log import MeasurementLog
from camrob.measurement.read_log import read_log
from camrob.program.program_text import ProgramText
from camrob.progress import Progress
from camrob.report.diagnosis.page import diagnosis_report
from camrob.summaries.diagnosis_summary import Compensable, DiagnosisSummary

__all__ = ["DiagnoseResult", "diagnose"]


@dataclass(frozen=True, slots=True)
class DiagnoseResult:
    """The diagnosis and its summary."""

    diagnosis: Diagnosis
    summary: DiagnosisSummary


@takes_paths
def diagnose(
    *,
    cell: Path,
    log: Sequence[Path],
    withheld: Sequence[Path] = (),
    program: Path | None = None,
    without: Sequence[str] = (),
    out: Path,
    experiment: Path | None = None,
    calibration: Path | None = None,
    progress: Progress | None = None,
) -> DiagnoseResult:
    """Diagnose logs of the real cell: diagnosis.json and diagnosis.html appear in `out`.

    Args:
        cell: the cell's folder.
        log: the logs.
        withheld: logs that take no part, by which the effects found are judged.
        program: what ran; None: the program that each log's LOG.toml names, where it lies beside the log.
        without: names of effects that are left out.
        out: the folder to write into.
        experiment: a file, where the next experiment is written as a checked program.
        calibration: FILE.toml, where the fitted effects that `compensate` can correct are written for it.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Returns:
        The diagnosis and its summary.

    Raises:
        LogError, CellError, ProgramError, InputError: what can't be read; nothing is written then.
        JobError, VerificationError: no experiment is needed, or none can be run, or no effect can be handed over: the
            diagnosis is written, the file is not.

    Example:
        >>> logs = [Path("out/log.csv")]
        >>> result = camrob.diagnose(cell=Path("cells/kr15_track_table"), log=logs, out=Path("out/diagnosis"))
        >>> result.summary.status, [found.effect for found in result.summary.effects]
        ('explained', ['corner_rounding'])
    """
    check_folder(out)
    if experiment is not None:
        check_experiment_name(experiment)
    if calibration is not None:
        check_file_name(calibration.name)
        if calibration.suffix.lower() != ".toml":
            raise InputError(
                f"--calibration {calibration.name!r} is not a calibration's name", hint="end it with .toml"
            )
    machine = read_cell(cell)
    logs = [read_log(path) for path in log]
    kept_out = [read_log(path) for path in withheld]
    _given_once(logs, kept_out)
    programs = [_program(one, program, machine) for one in logs]
    players = {one.path.name: player_beside(_ran(one, program), out) for one in logs if one.path is not None}
    withheld_programs = [_program(one, program, machine) for one in kept_out]
    _check_sections(machine, [*programs, *withheld_programs], experiment)
    found = run_diagnosis(
        logs,
        machine,
        withheld=kept_out,
        programs=programs,
        without=tuple(without),
        progress=progress,
        extra=cell_effects(cell, machine),
        withheld_programs=withheld_programs,
    )
    summary = found.summary
    refused: JobError | None = None
    if experiment is not None:
        try:
            written = write_experiment(experiment, found.motions, cell)
            if summary.experiment is not None:
                summary = replace(summary, experiment=replace(summary.experiment, written=written))
        except JobError as error:
            refused = error
    if calibration is not None:
        try:
            _hand_over(found, summary.compensable, calibration)
            summary = replace(summary, compensable=replace(summary.compensable, written=calibration.name))
        except JobError as error:
            refused = error
    with staged_output(out) as staging:
        write_summary(staging / "diagnosis.json", summary)
        (staging / "diagnosis.html").write_text(diagnosis_report(summary, found.paths, players), encoding="utf-8")
    if refused is not None:
        raise refused
    return DiagnoseResult(found, summary)


def _given_once(logs: Sequence[MeasurementLog], withheld: Sequence[MeasurementLog]) -> None:
    """Refuse rows that are given twice, under any name: they would count as new evidence, or not be withheld at all."""
    seen: dict[str, tuple[MeasurementLog, bool]] = {}
    for log, kept_out in [*((one, False) for one in logs), *((one, True) for one in withheld)]:
        first, before = seen.setdefault(log.digest, (log, kept_out))
        if first is log:
            continue
        hint = (
            "give it once"
            if first.path == log.path
            else f"it has the rows of {first.path.name if first.path else 'another'}"
        )
        what = "is given twice" if kept_out is before else "is both diagnosed and withheld"
        raise LogError(what, hint=hint, path=log.path)


def _hand_over(found: Diagnosis, compensable: Compensable, file: Path) -> None:
    """Write the calibration. Raises JobError where nothing that was found can be corrected by `compensate`."""
    if found.calibration is None:
        why = "that alone would not shrink the gap: " if compensable.effects else ""
        left = ", ".join([*compensable.effects, *compensable.left]) or "no effect was found"
        what = f"there is nothing that compensate could correct ({why}{left}), so no {file.name} was written"
        raise JobError(f"{what}; leave the option out, and read the diagnosis for what to do at the machine")
    with staged_output(file.parent) as staging:
        (staging / file.name).write_text(calibration_text(found.calibration), encoding="utf-8")


def _check_sections(machine: Cell, programs: Sequence[ProgramText | None], experiment: Path | None) -> None:
    """Raise CellError where the cell lacks what replaying a program, or writing one, needs."""
    machine.checked_for("camrob diagnose with a program", controller=any(p is not None for p in programs))
    machine.checked_for("camrob diagnose --write-experiment", controller=experiment is not None)


def _program(log: MeasurementLog, given: Path | None, machine: Cell) -> ProgramText | None:
    """The text of a log's program, where there is one."""
    file = _ran(log, given)
    return None if file is None else language_of_file(file).read(file, machine.controller_section)


def _ran(log: MeasurementLog, given: Path | None) -> Path | None:
    """The program of a log: the one given, or the one that its LOG.toml names, where it lies beside it."""
    if given is not None:
        return given
    if not log.info.program or log.path is None:
        return None
    try:
        name = check_file_name(log.info.program)
    except InputError:  # a path: what lies elsewhere is given by hand
        return None
    beside = log.path.parent / name
    within = beside.is_file() and beside.resolve().parent == log.path.parent.resolve()
    return beside if within else None
