"""The welding robot's study: published feed scheme and true optimum on its seam, torques, and what the paper states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from camrob.cell.cell import Cell
from camrob.cell.load import PointMass
from camrob.dynamics.torques import JointTorques, joint_torques
from camrob.studies.published_feed import (
    PublishedFeed,
    constant_feed_bound,
    marched_feed,
    motion_along,
    profile_excess,
    raised_feed,
)
from camrob.studies.seam import Seam, SeamMotion, seam_motion
from camrob.timing.path_spline import MotionBounds, interpolated
from camrob.timing.profile import FineGrid, fastest_profile, fine_grid, worst_use

__all__ = ["LoadCase", "Scheme", "SeamOptimum", "ToolCase", "WeldStudy", "study_weld"]

Array = NDArray[np.float64]

_FINE = 500  # parts of u for derivatives and optima; the paper's own step is the seam's
_SPANS = 1000
_LOADS = (
    ("as assumed", 1.0, 1.0),
    ("centres a tenth of the length nearer to the base", 1.2, 1.0),
    ("centres a tenth of the length nearer to the tip", 0.8, 1.0),
    ("without the rods' own inertia", 1.0, 0.0),
)
_TIPS = (  # the tip off the sixth frame's origin, m, in that frame: a torch is bent, and its wire sticks out
    ("as assumed", (0.0, 0.0, 0.0)),
    ("50 mm farther out", (0.0, 0.0, 0.05)),
    ("50 mm nearer to the wrist", (0.0, 0.0, -0.05)),
    ("50 mm to the side", (0.05, 0.0, 0.0)),
    ("50 mm to the other side", (-0.05, 0.0, 0.0)),
)


class SeamOptimum(NamedTuple):
    """The fastest profile on a 10 times finer grid, and the joints' motion (F, n) on it; use: share of the bounds (3,)."""

    grid: FineGrid
    use: Array
    speed: Array
    acceleration: Array
    jerk: Array
    q: Array


class Scheme(NamedTuple):
    """The published scheme for one top feed at the paper's points, its time, how far it uses the bounds with its own df/dt
    (3,), and the optima with moving ends and from rest to rest. marched, marched_at, marched_use: the same of the scheme
    read as a march, a step a point.
    """

    top: float
    published: PublishedFeed
    at: Array
    use: Array
    moving: SeamOptimum
    resting: SeamOptimum
    marched: Array
    marched_at: Array
    marched_use: Array


class LoadCase(NamedTuple):
    """Largest torques (n,), Nm, for one assumption about the masses."""

    name: str
    largest: Array


class ToolCase(NamedTuple):
    """One assumption about the torch: the least constant feed that the limits admit, m/s, and the largest torques (n,), Nm."""

    name: str
    feed: float
    largest: Array


@dataclass(frozen=True, slots=True)
class WeldStudy:
    """All that the report shows. points: at the paper's step; fine: at a fifth of it. bound: (N, 3) constant feeds, m/s, that
    speed, acceleration and jerk admit at the fine points. slip: by what share of their size the printed second and third
    derivatives, and the seam's second one in eq. 15, miss the true ones at most. numeric: ours against differences.
    """

    seam: Seam
    points: SeamMotion
    fine: SeamMotion
    bounds: MotionBounds
    bound: Array
    schemes: tuple[Scheme, ...]
    torques: JointTorques
    loads: tuple[LoadCase, ...]
    tools: tuple[ToolCase, ...]
    slip: tuple[float, float, float]
    numeric: tuple[float, float]


def study_weld(cell: Cell, seam: Seam) -> WeldStudy:
    """Run the study. Raises SingularError where the arm can't follow the seam."""
    points = seam_motion(cell, seam, round(1.0 / seam.step_u))
    fine = seam_motion(cell, seam, _FINE)
    bounds = MotionBounds(np.inf, np.inf, np.inf, *(cell.limits_of(name) for name in ("speed", "acceleration", "jerk")))
    joints = fine.joints
    bound = constant_feed_bound(joints.d1, joints.d2, joints.d3, bounds)
    schemes = tuple(_scheme(seam, points, fine, bounds, top) for top in seam.feed_tops)
    motion = schemes[0].resting
    cases = [
        joint_torques(
            cell, motion.q, motion.speed, motion.acceleration, masses=_moved(cell, near, spread), gravity=seam.gravity
        )
        for _name, near, spread in _LOADS
    ]
    loads = tuple(
        LoadCase(name, np.abs(case.total).max(axis=0)) for (name, _n, _s), case in zip(_LOADS, cases, strict=True)
    )
    tools = tuple(_tool(cell, seam, bounds, name, offset) for name, offset in _TIPS)
    return WeldStudy(seam, points, fine, bounds, bound, schemes, cases[0], loads, tools, _slip(fine), _numeric(fine))


def _tool(cell: Cell, seam: Seam, bounds: MotionBounds, name: str, offset: tuple[float, float, float]) -> ToolCase:
    """The seam followed with another torch, at the published top feed."""
    moved = np.eye(4)
    moved[:3, 3] = offset
    other = replace(cell, flange_T_tool=cell.flange_T_tool @ moved)
    joints = seam_motion(other, seam, _FINE).joints
    feed = np.full(len(joints.q), min(seam.feed_tops))
    zero = np.zeros_like(feed)
    speed, acceleration, _jerk = motion_along(joints.d1, joints.d2, joints.d3, feed, zero, zero)
    torques = joint_torques(other, joints.q, speed, acceleration, gravity=seam.gravity)
    least = float(constant_feed_bound(joints.d1, joints.d2, joints.d3, bounds).min())
    return ToolCase(name, least, np.abs(torques.total).max(axis=0))


def _scheme(seam: Seam, points: SeamMotion, fine: SeamMotion, bounds: MotionBounds, top: float) -> Scheme:
    j = points.joints
    published = raised_feed(j.d1, j.d2, j.d3, bounds, first=seam.feed_first, step=seam.feed_step, top=top)
    use, at = profile_excess(points.s, published.feed, j.d1, j.d2, j.d3, bounds)
    moving, resting = (_optimum(fine, bounds, top, rests=rests) for rests in (False, True))
    marched = marched_feed(points.s, j.d1, j.d2, j.d3, bounds, first=seam.feed_first, step=seam.feed_step, top=top)
    marched_use, marched_at = profile_excess(points.s, marched, j.d1, j.d2, j.d3, bounds)
    use = use.max(axis=0)
    return Scheme(top, published, at, use, moving, resting, marched, marched_at, marched_use.max(axis=0))


def _optimum(fine: SeamMotion, bounds: MotionBounds, top: float, *, rests: bool) -> SeamOptimum:
    """The fastest profile on a spline through the postures; tool and rotation have no bounds in the paper."""
    whole = float(fine.s[-1])
    even = np.linspace(0.0, whole, _SPANS + 1)
    q = CubicSpline(fine.s, fine.joints.q)(even)
    control = interpolated(np.hstack([np.zeros((len(even), 6)), q]), whole / _SPANS)
    feed = np.full(_SPANS, top)
    profile = fastest_profile(control, whole / _SPANS, feed, bounds, start=rests, end=rests)
    grid = fine_grid(profile, 10)
    use = worst_use(control, profile, bounds, feed, 10)[0].max(axis=0)
    d1, d2, d3 = (CubicSpline(fine.s, d)(grid.s) for d in fine.joints[1:])
    motion = motion_along(d1, d2, d3, grid.v, grid.u, grid.jerk)
    return SeamOptimum(grid, use, *motion, CubicSpline(fine.s, fine.joints.q)(grid.s))


def _moved(cell: Cell, near: float, spread: float) -> tuple[PointMass, ...]:
    """The cell's masses with each link's centre at `near` times its distance from the link's far end, halves `spread` apart."""
    out: list[PointMass] = []
    for joint in cell.names:
        of_link = [m for m in cell.masses if m.after == joint]
        total = sum(m.mass for m in of_link)
        if total > 0.0:
            middle = sum((m.mass * m.center for m in of_link), np.zeros(3)) / total
            out += [replace(m, center=near * middle + spread * (m.center - middle)) for m in of_link]
    return tuple(out)


def _share(found: Array, true: Array) -> float:
    """The largest distance, as a share of the column's largest value."""
    scale = np.maximum(np.abs(true).max(axis=0), 1e-12)
    moves = np.abs(true).max(axis=0) > 1e-9
    return float(np.max((np.abs(found - true).max(axis=0) / scale)[moves]))


def _slip(fine: SeamMotion) -> tuple[float, float, float]:
    def most(found: Array, true: Array) -> float:
        return float(np.max(np.linalg.norm(found - true, axis=1) / np.linalg.norm(true, axis=1)))

    true, printed = fine.joints, fine.printed
    return most(printed.d2, true.d2), most(printed.d3, true.d3), most(fine.printed_x2, fine.x2)


def _numeric(fine: SeamMotion) -> tuple[float, float]:
    inner: Sequence[slice] = (slice(3, -3),)
    second = np.gradient(fine.joints.d1, fine.s, axis=0)
    third = np.gradient(fine.joints.d2, fine.s, axis=0)
    return (
        _share(second[inner[0]], fine.joints.d2[inner[0]]),
        _share(third[inner[0]], fine.joints.d3[inner[0]]),
    )
