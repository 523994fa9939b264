"""The verbs on objects: what the readers give goes in, arrays and objects in SI come out, no file is read or written.

`resolve` is the middle of `post`, `fit` of `calibrate`, `correct` of `compensate`, `explain` of `diagnose`, `run` of `simulate`,
`placements` of `place`. None releases a program: the gate and the witness judge files, and stand in `post` and `verify` alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibrate import CalibrationFit, fit_cell
from camrob.calibration.calibration import Calibration
from camrob.calibration.compensate import compensate_postures
from camrob.calibration.measurements import measurements_of
from camrob.cell.cell import Cell
from camrob.cell.setup import Setup
from camrob.controller.simulate import CYCLE, Simulation, simulate
from camrob.errors import JobError, LogError
from camrob.frozen import locked
from camrob.gap.diagnose import diagnose
from camrob.gap.diagnosis import Diagnosis
from camrob.jobs.files.inputs import inputs_of
from camrob.jobs.solving.resolved_job import METHODS, check_method, resolve_job
from camrob.kinematics.frames import base_T_tool
from camrob.measurement.log import MeasurementLog
from camrob.program.program_text import ProgramText
from camrob.progress import Progress, stage_of
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.placement import Placements, place_stretches
from camrob.redundancy.solution import Solution
from camrob.toolpath.toolpath import Toolpath

__all__ = ["Resolved", "correct", "explain", "fit", "placements", "resolve", "run"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Resolved:
    """A toolpath in a cell: the cell with the job's (first) tool, the path in `base`, its postures, and what forward
    kinematics says that they leave: (N,) m of position and (N,) rad of the tool's axis.
    """

    cell: Cell
    path: ToolPathInBase
    solution: Solution
    position_error: Array
    axis_error: Array

    def __post_init__(self) -> None:
        for name in ("position_error", "axis_error"):
            object.__setattr__(self, name, locked(getattr(self, name)))


def resolve(
    toolpath: Toolpath, cell: Cell, setup: Setup, *, method: str = "vjm", progress: Progress | None = None
) -> Resolved:
    """Postures of a cell along a toolpath, with the moves through air from HOME and back.

    What `post` does before it writes: collisions are not checked, and no program is released.

    Args:
        toolpath: regions of frames in the part.
        cell: the machine, with or without a tool.
        setup: where the part lies, and the tools.
        method: "vjm", the published method, or "planned".
        progress: called with a stage and the share of it that is done, 0 to 1.

    Returns:
        The path in `base` (m, rad), and its postures, rad and m.

    Raises:
        InputError and its kin: a method or a tool that there isn't.
        JobError and its kin: the path can't be followed; the error says where.

    Example:
        >>> cell = camrob.read_cell(Path("cells/kr15_track_table"))
        >>> setup = camrob.read_setup(Path("toolpaths/engraving/setup.toml"), cell)
        >>> toolpath = camrob.read_toolpath(Path("toolpaths/engraving/engraving.cls"))
        >>> found = camrob.resolve(toolpath, cell, setup)
        >>> found.solution.q.shape == (len(found.path), len(cell)), bool(found.position_error.max() < 1e-9)
        (True, True)
    """
    check_method(method)
    first = next(iter(METHODS[method]))
    inputs = inputs_of(toolpath, cell, setup)
    try:
        done = resolve_job(inputs, method, first, stage_of(progress, "resolve"))
    except JobError as error:
        from camrob.jobs.solving.elsewhere import with_a_place  # tries plans and placements

        raise with_a_place(error, inputs, planned=method == "planned") from None
    return Resolved(done.inputs.cell, done.inputs.path, done.solution, *done.residual)


def fit(
    logs: Sequence[MeasurementLog],
    cell: Cell,
    *,
    withheld: Sequence[MeasurementLog] = (),
    parameters: Sequence[str] = (),
    share: float = 0.2,
) -> CalibrationFit:
    """Error parameters of a cell, fitted to logs of measured poses.

    Args:
        logs: of axis values and measured poses.
        cell: the nominal cell.
        withheld: logs that take no part, to judge by.
        parameters: names to fit, all of them or none; without, the standard ones, as far as the poses tell them.
        share: the share of the poses that is withheld where no logs are, 0 to below 1.

    Returns:
        The calibration (SI), and what it rests on.

    Raises:
        LogError: poses that can't be used.
        SingularError, JobError: a fit that can't be had honestly.

    Example:
        >>> cell = camrob.read_cell(Path("cells/kr15_track_table"))
        >>> study = camrob.fit([camrob.read_log(Path("out/log.csv"))], cell)
        >>> study.calibration.cell_name
        'kr15_track_table'
    """
    if not logs:
        raise LogError("no log was given", hint="give at least one")
    others = [measurements_of(log, cell) for log in withheld]
    names = tuple(dict.fromkeys(parameters)) or None
    return fit_cell(
        cell, [measurements_of(log, cell) for log in logs], names=names, withheld=others or None, share=share
    )


def correct(q: Array, cell: Cell, calibration: Calibration) -> Array:
    """Postures in which the calibrated robot puts the tool where the nominal one would in `q`.

    Args:
        q: postures (N, n) of the nominal robot, rad and m. The arm's axes are corrected, the others stay.
        cell: the nominal cell, with the tool.
        calibration: what was fitted to this cell's robot.

    Returns:
        Postures (N, n). Limits are the caller's to check.

    Raises:
        StaleInputError: the calibration is of another robot.
        SingularError: a posture, `value`, can't be corrected, for the arm is singular there.

    Example:
        >>> cell = camrob.read_cell(Path("cells/kr15_track_table"))
        >>> study = camrob.fit([camrob.read_log(Path("out/log.csv"))], cell)
        >>> q = cell.q_reference[None]
        >>> bool(abs(camrob.correct(q, cell, study.calibration) - q).max() < 0.01)
        True
    """
    model, values = calibration.model(cell, in_base=True)
    postures = np.atleast_2d(np.asarray(q, float))
    return np.asarray(compensate_postures(model, values, postures, base_T_tool(cell, postures)).q)


def explain(
    logs: Sequence[MeasurementLog],
    cell: Cell,
    *,
    withheld: Sequence[MeasurementLog] = (),
    programs: Sequence[ProgramText | None] = (),
    without: Sequence[str] = (),
    progress: Progress | None = None,
) -> Diagnosis:
    """Where the gap between simulation and measurement lies, which effects cause it, and how far it shrinks with them.

    Args:
        logs: runs of one cell.
        cell: the nominal cell.
        withheld: logs that take no part in choosing or fitting.
        programs: one a log, None where there is none.
        without: effects to leave out of the library.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Returns:
        The diagnosis; its `summary` is what `diagnosis.json` holds.

    Raises:
        LogError: logs that can't be diagnosed.
        InputError: an effect that is not in the library.

    Example:
        >>> cell = camrob.read_cell(Path("cells/kr15_track_table"))
        >>> camrob.explain([camrob.read_log(Path("out/log.csv"))], cell).claimed
        ()
    """
    return diagnose(logs, cell, withheld=withheld, programs=programs, without=without, progress=progress)


def run(program: ProgramText, cell: Cell, *, cycle: float = CYCLE, progress: Progress | None = None) -> Simulation:
    """A program on the ideal controller: every motion at its speed, within the axes' limits, corners rounded as programmed.

    Args:
        program: as it was read.
        cell: the machine; tools and frames are the program's own.
        cycle: s from row to row of the log.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Returns:
        The run (SI): its log, its duration in s, what held it back, and findings.

    Raises:
        ProgramError: settings that no controller takes, or a motion without a speed.
        UnreachableError: a motion, `line`, that can't be followed.
        ValueError: a cycle that is no positive number.

    Example:
        >>> cell = camrob.read_cell(Path("cells/kr15_track_table"))
        >>> simulation = camrob.run(camrob.read_program(Path("out/engraving.src")), cell, cycle=1.0)
        >>> len(simulation.log) >= simulation.duration
        True
    """
    return simulate(program, cell, cycle=cycle, progress=stage_of(progress, "simulate"))


def placements(
    toolpath: Toolpath, cell: Cell, setup: Setup, *, shifts: Array, progress: Progress | None = None
) -> Placements:
    """How well a part could be worked elsewhere: the best conditioning that postures at its poses can have, by placement.

    What `place` does before its trials: neither the table's edge nor bodies are asked.

    Args:
        toolpath: regions of frames in the part.
        cell: the machine.
        setup: where the part lies now, and its tool.
        shifts: (S, 3) m from there, in `base`.
        progress: called with a stage and the share of it that is done, 0 to 1.

    Returns:
        The placements, the present one first, with the mean and the least of 1/k_F over the path.

    Raises:
        InputError: a set-up with several clampings.
        UnreachableError: none of them has the whole path in reach.

    Example:
        >>> cell = camrob.read_cell(Path("cells/kr15_track_table"))
        >>> setup = camrob.read_setup(Path("toolpaths/engraving/setup.toml"), cell)
        >>> toolpath = camrob.read_toolpath(Path("toolpaths/engraving/engraving.cls"))
        >>> found = camrob.placements(toolpath, cell, setup, shifts=[[0.1, 0.0, 0.0]])
        >>> found.base_T_part.shape, bool(found.mean.min() > 0.5)
        ((2, 4, 4), True)
    """
    inputs = inputs_of(toolpath, cell, setup)
    moved = np.asarray(shifts, float).reshape(-1, 3)
    now = np.asarray(inputs.setup.base_T_part)
    return place_stretches(inputs.by_stretch(), now, moved, progress=stage_of(progress, "place"))
