"""`camrob diagnose`: from logs to diagnosis.json and diagnosis.html."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from camrob.calibrate.calibration_file import calibration_text
from camrob.cell.read_cell import read_cell
from camrob.errors import InputError, JobError, LogError
from camrob.gap.cell_effects import cell_effects
from camrob.gap.diagnose import diagnose as run_diagnosis
from camrob.gap.diagnosis import Diagnosis
from camrob.jobs.experiment import check_experiment_name, write_experiment
from camrob.jobs.files import check_file_name, staged_output
from camrob.measure.log import MeasurementLog
from camrob.measure.read_log import read_log
from camrob.post.krl_program import KrlProgram
from camrob.post.krl_reader import read_krl
from camrob.report.diagnosis_report import diagnosis_report

__all__ = ["DiagnoseResult", "diagnose"]


@dataclass(frozen=True, slots=True)
class DiagnoseResult:
    """The diagnosis and its JSON object."""

    diagnosis: Diagnosis
    summary: Mapping[str, Any]


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
    progress: Callable[[str, float], None] | None = None,
) -> DiagnoseResult:
    """Diagnose logs and write diagnosis.json and diagnosis.html into `out`.

    experiment: FILE.src, where the next experiment is written as a checked program. calibration: FILE.toml, where the fitted
    effects that `compensate` can correct are written for it. Raises LogError, CellError, KrlError and
    InputError for what can't be read; nothing is written then. Raises JobError and VerificationError where no experiment is
    needed, or none can be run, and JobError where no effect can be handed over: the diagnosis is written, the file is not.
    """
    if experiment is not None:
        check_experiment_name(experiment)
    if calibration is not None:
        check_file_name(calibration.name)
        if calibration.suffix.lower() != ".toml":
            raise InputError(f"--calibration {calibration.name!r} is no calibration's name", cure="end it with .toml")
    machine = read_cell(cell)
    logs = [read_log(path) for path in log]
    kept_out = [read_log(path) for path in withheld]
    _told_once(logs, kept_out)
    programs = [_program(one, program) for one in logs]
    found = run_diagnosis(
        logs, machine, withheld=kept_out, programs=programs, without=tuple(without), progress=progress,
        extra=cell_effects(cell, machine),
        withheld_programs=[_program(one, program) for one in kept_out],
    )  # fmt: skip
    summary = {"cell": machine.name, "without": list(without), **found.summary}
    refused: JobError | None = None
    if experiment is not None:
        try:
            summary["experiment"] = {
                **summary.get("experiment", {}),
                "written": write_experiment(experiment, found.motions, cell),
            }
        except JobError as error:
            refused = error
    if calibration is not None:
        try:
            _hand_over(found, calibration)
            summary["compensable"] = {**summary["compensable"], "written": calibration.name}
        except JobError as error:
            refused = error
    with staged_output(out) as staging:
        text = json.dumps(summary, indent=2, allow_nan=False)
        (staging / "diagnosis.json").write_text(text + "\n", encoding="utf-8")
        (staging / "diagnosis.html").write_text(diagnosis_report(summary, found.paths), encoding="utf-8")
    if refused is not None:
        raise refused
    return DiagnoseResult(found, summary)


def _told_once(logs: Sequence[MeasurementLog], withheld: Sequence[MeasurementLog]) -> None:
    """Refuse rows that are given twice, under any name: they would count as new evidence, or not be withheld at all."""
    seen: dict[str, tuple[MeasurementLog, bool]] = {}
    for log, kept_out in [*((one, False) for one in logs), *((one, True) for one in withheld)]:
        first, before = seen.setdefault(log.digest, (log, kept_out))
        if first is log:
            continue
        cure = (
            "give it once"
            if first.path == log.path
            else f"it has the rows of {first.path.name if first.path else 'another'}"
        )
        what = "is given twice" if kept_out is before else "is both diagnosed and withheld"
        raise LogError(what, cure=cure, path=log.path)


def _hand_over(found: Diagnosis, file: Path) -> None:
    """Write the calibration. Raises JobError where nothing that was found can be corrected by `compensate`."""
    if found.calibration is None:
        told = found.summary["compensable"]
        why = "by itself it would not shrink the gap: " if told["effects"] else ""
        left = ", ".join([*told["effects"], *told["left"]]) or "no effect was found"
        raise JobError(f"there is nothing that compensate could correct ({why}{left}), so no {file.name} was written")
    with staged_output(file.parent) as staging:
        (staging / file.name).write_text(calibration_text(found.calibration), encoding="utf-8")


def _program(log: MeasurementLog, given: Path | None) -> KrlProgram | None:
    """The program of a log: the one given, or the one that its LOG.toml names, where it lies beside it."""
    if given is not None:
        return read_krl(given)
    if not log.info.program or log.path is None:
        return None
    try:
        name = check_file_name(log.info.program)
    except InputError:  # a path: what lies elsewhere is given by hand
        return None
    beside = log.path.parent / name
    within = beside.is_file() and beside.resolve().parent == log.path.parent.resolve()
    return read_krl(beside) if within else None
