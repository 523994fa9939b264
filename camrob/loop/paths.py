"""The paper's two tests as the NC interpolator gives them: a square from rest to rest side by side, and a circle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import LimitError, SingularError, UnreachableError
from camrob.frozen import locked
from camrob.kinematics.arm import FOLLOW_LIMIT, FOLLOWED, Arm
from camrob.kinematics.kernels import chain_arrays, inverse_kf_many
from camrob.loop.case import TrackerCase
from camrob.se3 import frame_from_xyzabc

__all__ = ["TestPath", "circle_path", "square_path", "start_posture", "travelled"]

Array = NDArray[np.float64]
Whole = NDArray[np.int64]

_STEP = 0.1  # rad a joint may move in a cycle, before it counts as a jump
_SINGULAR = 0.02  # least 1/k_F on the way


@dataclass(frozen=True, slots=True)
class TestPath:
    """Set-points of a test, one a cycle: `wanted` (N, 6) as x, y, z, A, B, C, m and rad; `q` (N, 6) the nominal posture.

    `time` (N,), s; `moving` (N,) where the feed isn't 0; `corners`: cycles at which a side ends. `center` (3,) and `radius` (m, 0
    for a square): what the deviation in the plane is measured from. `side` (N,): the side of a square that is being run.
    """

    name: str
    wanted: Array
    q: Array
    time: Array
    moving: NDArray[np.bool_]
    corners: NDArray[np.int64]
    side: NDArray[np.int64]
    center: Array
    radius: float

    __test__ = False  # no test of pytest's, whatever its name

    def __post_init__(self) -> None:
        for name, kind in (("wanted", float), ("q", float), ("time", float), ("center", float)):
            object.__setattr__(self, name, locked(getattr(self, name), dtype=kind))
        for name, whole in (("moving", np.bool_), ("corners", np.int64), ("side", np.int64)):
            object.__setattr__(self, name, locked(getattr(self, name), dtype=whole))

    def __len__(self) -> int:
        return len(self.wanted)


def travelled(length: float, feed: float, acceleration: float, cycle: float) -> Array:
    """Way along a line from rest to rest, one value a cycle, the first 0 and the last `length`; the speed follows a cosine.

    `acceleration` is the ramps' greatest. The feed is lowered a little so that the motion fills whole cycles; a line too
    short for it gets a lower one.
    """
    feed = min(feed, float(np.sqrt(2.0 * acceleration * length / np.pi)))
    ramp = 0.5 * np.pi * feed / acceleration
    cycles = int(np.ceil((length / feed + ramp) / cycle))
    feed = length / (cycles * cycle - ramp)
    t = np.asarray(cycle * np.arange(cycles + 1), float)
    whole = float(t[-1])

    def ramped(x: Array) -> Array:
        x = np.clip(x, 0.0, ramp)
        return np.asarray(0.5 * feed * (x - ramp / np.pi * np.sin(np.pi * x / ramp)))

    steady = feed * np.clip(t - ramp, 0.0, whole - 2.0 * ramp)
    out = ramped(t) + steady + (0.5 * feed * ramp - ramped(whole - t))
    return np.asarray(np.minimum(out, length))


def square_path(cell: Cell, case: TrackerCase) -> TestPath:
    """The square in the plane XY: along X, Y, -X, -Y. Raises UnreachableError, LimitError or SingularError."""
    cycle = case.law.cycle_s
    way = travelled(case.side, case.feed, case.acceleration, cycle)
    corners = case.corner + case.side * np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]], float)
    rest = round(case.rest / cycle)
    points, side, ends = [np.repeat(corners[:1], rest, axis=0)], [np.zeros(rest, int)], [rest - 1]
    for k in range(4):
        direction = (corners[k + 1] - corners[k]) / case.side
        points.append(corners[k] + way[1:, None] * direction)
        side.append(np.full(len(way) - 1, k))
        ends.append(ends[-1] + len(way) - 1)
    points.append(np.repeat(corners[-1:], rest, axis=0))
    side.append(np.full(rest, 3))
    middle = case.corner + 0.5 * case.side * np.array([1.0, 1.0, 0.0])
    return _path(cell, case, "square", np.vstack(points), np.concatenate(side), np.array(ends), middle, 0.0)


def circle_path(cell: Cell, case: TrackerCase) -> TestPath:
    """The circle in the plane XY, against the clock from +X. Raises UnreachableError, LimitError or SingularError."""
    cycle = case.law.cycle_s
    angle = travelled(2.0 * np.pi * case.radius, case.feed, case.acceleration, cycle) / case.radius
    rest = round(case.rest / cycle)
    angle = np.concatenate([np.zeros(rest), angle[1:], np.full(rest, angle[-1])])
    points = case.center + case.radius * np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    ends = np.array([rest - 1, len(angle) - rest - 1])
    return _path(cell, case, "circle", points, np.zeros(len(angle), int), ends, np.asarray(case.center), case.radius)


def _path(
    cell: Cell, case: TrackerCase, name: str, points: Array, side: Whole, ends: Whole, center: Array, radius: float
) -> TestPath:
    wanted = np.hstack([points, np.zeros((len(points), 3))])
    moved = np.linalg.norm(np.diff(points, axis=0, prepend=points[:1]), axis=1) > 1e-12
    q = _postures(cell, wanted, name)
    time = np.asarray(case.law.cycle_s * np.arange(len(points)), float)
    return TestPath(name, wanted, q, time, moved, ends, side, center, radius)


def start_posture(cell: Cell, wanted: Array, name: str) -> Array:
    """The posture (6,) nearest to HOME at a set-point (6,), x, y, z, A, B, C. Raises UnreachableError."""
    arm, home = Arm.of(cell), cell.q_home[cell.arm_slice]
    foot_T_tool = arm.foot_T_tool(frame_from_xyzabc(wanted), cell.q_home)
    starts = arm.branches(foot_T_tool, home)
    if not starts:
        raise UnreachableError(f"the {name}'s start is out of reach", reasons=arm.reasons(foot_T_tool, home))
    return min(starts, key=lambda q: float(np.max(np.abs(q - home))))


def _postures(cell: Cell, wanted: Array, name: str) -> Array:
    """The nominal arm's postures along set-points, from the branch nearest to HOME."""
    arm = Arm.of(cell)
    q_all = np.broadcast_to(cell.q_home, (len(wanted), len(cell)))
    foot_T_tool = arm.foot_T_tool(frame_from_xyzabc(wanted), q_all)
    start = start_posture(cell, wanted[0], name)
    q, code, count = arm.follow(foot_T_tool, start, step=_STEP)
    if code != FOLLOWED:
        kind = LimitError if code == FOLLOW_LIMIT else UnreachableError
        raise kind(f"the arm can't follow the {name} beyond {100.0 * count / len(wanted):.0f} % of it")
    kf = inverse_kf_many(chain_arrays(cell), q)
    if float(kf.min()) < _SINGULAR:
        raise SingularError(
            f"the {name} runs through a singular posture: its errors can't be corrected in all six directions",
            value=float(kf.min()),
            limit=_SINGULAR,
            unit="1/k_F",
        )
    return np.asarray(q)
