"""A program that visits the poses to measure next, checked for limits and collisions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.measurements import Measurements
from camrob.calibration.next_poses import candidate_postures, select_poses
from camrob.cell.cell import Cell
from camrob.checks.collisions import check_collisions
from camrob.errors import CollisionError
from camrob.jobs.files.cell_for import language_of
from camrob.kinematics.frames import base_T_tool
from camrob.program.builder import build_program, printed_frames
from camrob.program.motion import Motion
from camrob.program.program import ProgramEvent, ProgramEventKind
from camrob.summaries.calibration_summary import MeasuringCollisions, MeasuringFigures
from camrob.units import m_to_mm

__all__ = ["MeasuringPlan", "plan_measuring"]

Array = NDArray[np.float64]

_CANDIDATES = 600  # postures to choose from: what a selection that compares all takes seconds for
_ROUNDS = 12  # of leaving out what touches something on the way
_REST = 2.0  # s to settle before the instrument reads


@dataclass(frozen=True, slots=True)
class MeasuringPlan:
    """files: name to content of the program. q (k, n): the poses in the order of visiting."""

    files: Mapping[str, bytes]
    figures: MeasuringFigures
    q: Array


def plan_measuring(
    cell: Cell, data: Measurements, names: tuple[str, ...], path: Array, count: int, name: str
) -> MeasuringPlan:
    """Choose `count` poses beyond those measured, for the accuracy on the path q (M, n), and write the program `name`.

    The program goes from HOME to each pose by PTP, rests for two seconds, and returns. Poses that touch anything, on
    the way too, are exchanged. Raises CollisionError where none that are free are found.
    """
    candidates = candidate_postures(cell, _CANDIDATES)
    candidates = cell.to_q(_rounded(cell, candidates))
    home = np.asarray(cell.to_q(_rounded(cell, cell.q_home[None])))
    sigma_p = data.sigma_position if data.sigma_position > 0.0 else 5e-5
    sigma_a = (data.sigma_angle if data.sigma_angle > 0.0 else 1e-4) if data.oriented else None
    exchanged = 0
    for _ in range(_ROUNDS):
        if len(candidates) < count:
            break
        choice = select_poses(
            cell,
            names,
            candidates,
            path,
            count,
            measured=np.asarray(data.q),
            sigma_position=sigma_p,
            sigma_angle=sigma_a,
            in_base=data.in_base,
        )
        order = _tour(cell, home[0], candidates[choice.chosen])
        tour = np.concatenate([home, candidates[choice.chosen][order], home])
        report = check_collisions(cell, tour)
        if not report.hit.any():
            return _plan(cell, tour, choice.expected, report.checked, exchanged, name)
        # the way to a point was touched: that point or the one before has to go; the return to HOME blames the last
        touched = np.clip(np.flatnonzero(report.hit) - 1, 0, count - 1)
        goes = choice.chosen[order][np.unique(touched)]
        exchanged += len(goes)
        candidates = np.delete(candidates, goes, axis=0)
    raise CollisionError(f"no {count} poses were found that can be visited without touching anything; ask for fewer")


def _rounded(cell: Cell, q: Array) -> Array:
    """Axis values (N, axes) as they are printed."""
    values, rounding = cell.to_axis_values(q), language_of(cell).round
    return np.concatenate([rounding.axes(values[:, :6]), rounding.external(values[:, 6:])], axis=1)


def _tour(cell: Cell, start: Array, q: Array) -> NDArray[np.int64]:
    """An order of visiting: always the pose that is reached soonest."""
    speed = np.where(np.isfinite(cell.limits_of("speed")), cell.limits_of("speed"), np.inf)
    left, here, order = list(range(len(q))), start, []
    while left:
        time = [float(np.max(np.abs(q[k] - here) / speed)) for k in left]
        nearest = left.pop(int(np.argmin(time)))
        order.append(nearest)
        here = q[nearest]
    return np.array(order, np.int64)


def _plan(cell: Cell, tour: Array, expected: Array, checked: bool, exchanged: int, name: str) -> MeasuringPlan:
    count, language = len(tour), language_of(cell)
    values = _rounded(cell, tour)
    tips = printed_frames(base_T_tool(cell, tour))[1:-1, :3]
    rest = tuple(ProgramEvent(k + 1, ProgramEventKind.DWELL, value=_REST) for k in range(1, count - 1))
    program = build_program(
        name,
        cell,
        language.round,
        kind=np.full(count, Motion.PTP_AXES),
        axis_values=values,
        events=rest,
        comment=(f"{count - 2} poses to measure, at rest for {_REST:g} s each",),
    )
    return MeasuringPlan(
        files=dict(language.write(program, cell.controller, max_lines=None)),
        figures=MeasuringFigures(
            poses=count - 2,
            expected_before_mm=m_to_mm(float(expected[0])),
            expected_after_mm=m_to_mm(float(expected[-1])),
            collisions=MeasuringCollisions(checked=checked, count=0, exchanged=exchanged),
            axis_values=tuple(tuple(round(float(v), 4) for v in row) for row in values[1:-1]),
            tip_mm=tuple(tuple(round(float(v), 3) for v in row) for row in tips),
        ),
        q=tour[1:-1],
    )
