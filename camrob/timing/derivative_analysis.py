"""Derivatives of the machine coordinates along the total displacement of the axes, and the feeds that they admit.

Section III of Samak and others (papers/000): s is the length of the path in the space of the axes. q(s) is resampled evenly
and differentiated three times (eq. 10 to 19); divided by the axes' bounds the derivatives are constraints on the rate
ds/dt and its derivatives (eq. 20 to 26), and each bound by itself admits a rate (eq. 21, 27, 28). The paper's linear
interpolation makes of every point a corner, so that second and third derivative grow with the number of samples, without
end; the smoothing spline stays within the coordinates' printed resolution and has no more bend than they show.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camrob.cell.cell import Cell
from camrob.frozen import locked
from camrob.timing.path_spline import MotionBounds
from camrob.timing.smooth_curves import smooth_curves

__all__ = ["DerivativeAnalysis", "Interpolation", "LimitViolation", "analyse_derivatives", "machine_length"]

Array = NDArray[np.float64]

PARTS = 2900  # as many samples as the paper's figures have
RESOLUTION = 1e-6  # rad or m: coordinates straight from a solver


class Interpolation(StrEnum):
    """How coordinates between points are found."""

    LINEAR = "linear"  # as published
    SMOOTH = "smooth"  # smoothing spline within the resolution


class LimitViolation(NamedTuple):
    """A stretch of s (rad) where an axis passes a bound; `quantity` speed, acceleration or jerk; worst: times the bound."""

    axis: str
    quantity: str
    begins: float
    ends: float
    worst_at: float
    line: int
    worst: float


@dataclass(frozen=True, slots=True)
class DerivativeAnalysis:
    """Coordinates over s (M,) and their derivatives q_s, q_ss, q_sss (M, n); `axes` names the n columns.

    s is in rad, metres of a linear axis being divided by the cell's characteristic length. rate_speed, rate_acceleration,
    rate_jerk: (M,) ds/dt that eq. 21, 27 and 28 admit. line: (M,) source line. bounds: those of the axes.
    """

    axes: tuple[str, ...]
    s: Array
    q: Array
    q_s: Array
    q_ss: Array
    q_sss: Array
    rate_speed: Array
    rate_acceleration: Array
    rate_jerk: Array
    line: NDArray[np.int64]
    bounds: MotionBounds

    def __post_init__(self) -> None:
        count, n = len(self.s), len(self.axes)
        for name in ("q", "q_s", "q_ss", "q_sss"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(count, n), name=name))
        for name in ("s", "rate_speed", "rate_acceleration", "rate_jerk"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(count,), name=name))

    def constraints(self, rate: float = 1.0) -> dict[str, Array]:
        """The normalised derivatives (M, n) of eq. 20 and 22 to 26 at a constant `rate` of ds/dt, rad/s; 1 is the bound.

        The rate's own derivatives are taken as 1 rad/s2 and 1 rad/s3, as the paper's constraints on q_s imply.
        """
        v, a, j = self.bounds.speed, self.bounds.acceleration, self.bounds.jerk
        return {
            "q_s / v (20)": np.asarray(self.q_s * rate / v),
            "q_s / a (22)": np.asarray(self.q_s / a),
            "q_s / j (23)": np.asarray(self.q_s / j),
            "q_ss / a (24)": np.asarray(self.q_ss * rate**2 / a),
            "q_ss / j (25)": np.asarray(self.q_ss * rate / j),
            "q_sss / j (26)": np.asarray(self.q_sss * rate**3 / j),
        }

    def violations(self, rate: float = 1.0) -> tuple[LimitViolation, ...]:
        """Where speed, acceleration or jerk of an axis pass their bound at a constant `rate` of ds/dt, rad/s."""
        named = zip(("speed", "acceleration", "jerk"), ("q_s / v (20)", "q_ss / a (24)", "q_sss / j (26)"), strict=True)
        table = self.constraints(rate)
        out: list[LimitViolation] = []
        for quantity, key in named:
            for k, axis in enumerate(self.axes):
                use = np.abs(table[key][:, k])
                over = np.flatnonzero(use > 1.0)
                for run in np.split(over, np.flatnonzero(np.diff(over) > 1) + 1) if len(over) else []:
                    worst = int(run[np.argmax(use[run])])
                    ends = float(self.s[run[0]]), float(self.s[run[-1]])
                    place = float(self.s[worst]), int(self.line[worst])
                    out.append(LimitViolation(axis, quantity, *ends, *place, float(use[worst])))
        return tuple(out)


def machine_length(cell: Cell, q: Array) -> Array:
    """Total displacement of the axes (N,), rad, up to each of postures q (N, n); the virtual roll does not count."""
    columns = np.flatnonzero(np.isfinite(cell.limits_of("speed")))
    scale = np.array([cell.condition_length if cell.joints[c].prismatic else 1.0 for c in columns])
    steps = np.diff(q[:, columns] / scale, axis=0)
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps, axis=1))])


def analyse_derivatives(
    cell: Cell,
    q: Array,
    *,
    line: ArrayLike | None = None,
    parts: int = PARTS,
    interpolation: Interpolation = Interpolation.LINEAR,
    resolution: float = RESOLUTION,
) -> DerivativeAnalysis:
    """Analyse postures q (N, n) of a path or program. line: (N,) source lines. parts: even parts of s.

    resolution: rad (m) that the coordinates are known to, e.g. a printed program's; the smooth curve may leave the points
    by its standard deviation, resolution / sqrt(12). Raises ValueError for fewer than 8 distinct postures.
    """
    q = np.asarray(q, float)
    s = machine_length(cell, q)
    moving = np.concatenate([[True], np.diff(s) > 1e-12])
    if q.shape != (len(s), len(cell)) or np.count_nonzero(moving) < 8:
        raise ValueError(f"q must hold at least 8 different postures of {len(cell)} joints")
    columns = np.flatnonzero(np.isfinite(cell.limits_of("speed")))
    lines = np.zeros(len(s), np.int64) if line is None else np.asarray(line, np.int64)
    known, values, lines = s[moving], q[moving][:, columns], lines[moving]
    grid = np.linspace(0.0, known[-1], parts + 1)
    if interpolation is Interpolation.LINEAR:
        curves = [np.column_stack([np.interp(grid, known, v) for v in values.T])]
        for _order in range(3):
            curves.append(np.gradient(curves[-1], grid, axis=0))
    else:
        curves = smooth_curves(known, values, parts, resolution)
    bounds = MotionBounds(
        np.inf, np.inf, np.inf, *(cell.limits_of(name)[columns] for name in ("speed", "acceleration", "jerk"))
    )
    with np.errstate(divide="ignore"):
        rates = [
            (1.0 / np.max(np.abs(curve) / bound, axis=1)) ** (1.0 / order)
            for order, (curve, bound) in enumerate(
                zip(curves[1:], (bounds.speed, bounds.acceleration, bounds.jerk), strict=True), start=1
            )
        ]
    at = np.clip(np.searchsorted(known, grid, side="left"), 0, len(known) - 1)
    names = tuple(cell.names[c] for c in columns)
    q0, q1, q2, q3 = curves
    return DerivativeAnalysis(names, grid, q0, q1, q2, q3, rates[0], rates[1], rates[2], lines[at], bounds)
