"""A loop's machine, where JOB.toml has it simulated: as another diagnosis has it, seen with noise."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from camrob.calibration.calibration_file import read_calibration
from camrob.cell.cell import Cell
from camrob.jobs.closing.diagnosed_machine import DiagnosedMachine
from camrob.jobs.closing.loop_file import LoopJob, Rehearsal
from camrob.jobs.files.diagnosed import diagnosed
from camrob.jobs.files.output import staged_output
from camrob.languages import language_of_file
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo, MeasuredFrame
from camrob.measurement.write_log import write_log
from camrob.units import m_to_mm, mm_to_m

__all__ = ["rehearse", "rehearsed_machine"]

_EVERY = 5  # rows of the simulated run: a tracker tells every 20 ms


def rehearsed_machine(job: LoopJob, cell: Cell) -> DiagnosedMachine | None:
    """The machine that JOB.toml has simulated, None without one. Raises InputError for files of it that are missing or wrong,
    before the first program is made.
    """
    rehearsal = job.rehearsal
    if rehearsal is None:
        return None
    constants = None if rehearsal.calibration is None else read_calibration(rehearsal.calibration, cell)
    units, rest = diagnosed(rehearsal.diagnosis, constants, job.cell, cell)
    return DiagnosedMachine(cell, constants, units, rest, "rehearsal")


def rehearse(rehearsal: Rehearsal, machine: DiagnosedMachine, program: Path, file: Path, turn: int) -> None:
    """Write the log of a program's run on the simulated machine, seen in `base` with noise."""
    cell = machine.cell
    ran = machine.run(language_of_file(program).read(program, cell.controller_section))
    rows = slice(None, None, _EVERY)
    rng = np.random.default_rng([rehearsal.seed, turn, len(file.stem)])
    true = np.asarray(ran.path.true)[rows]
    xyz = m_to_mm(true[:, :3, 3]) + rng.normal(0.0, rehearsal.noise_mm, (len(true), 3))
    names = cell.axis_names
    columns = {name: np.asarray(ran.log.columns[name])[rows] for name in ("t", "line")}
    columns |= dict(zip("xyz", xyz.T, strict=True))
    columns |= {f"c{a}": v for a, v in zip(names, ran.log.setpoints(names)[rows].T, strict=True)}
    info = LogInfo(measured_frame=MeasuredFrame.BASE, sigma_position=mm_to_m(rehearsal.noise_mm), program=program.name)
    with staged_output(file.parent) as folder:
        write_log(MeasurementLog(columns, info), folder / file.name)
