"""Clamped B-spline curves as points within a chord and an angle tolerance."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from camrob.errors import ToolpathError

__all__ = ["clamped_spline", "sample_spline"]

_DOUBLINGS = 12  # of the points on a span: 4096 times as many
_HIGHEST_DEGREE = 9  # CAM systems write 3, some 5


def clamped_spline(control: NDArray[np.float64], knots: NDArray[np.float64]) -> BSpline:
    """The curve of control points (N, 3) over `knots`: the interior ones (in 0..1), or the whole clamped vector.

    The degree follows from the two counts. Raises ToolpathError where they don't fit each other.
    """
    n, k = len(control), len(knots)
    if n < 2 or np.any(np.diff(knots) < 0.0) or (k and not (knots[0] >= 0.0 and knots[-1] <= 1.0)):
        raise ToolpathError("a NURBS has knots out of order or too few control points", cure="output it as points")
    whole = k > n and bool(knots[0] == knots[1] and knots[-1] == knots[-2])
    degree = k - n - 1 if whole else n - k - 1
    if not 1 <= degree <= _HIGHEST_DEGREE:
        raise ToolpathError(f"a NURBS of {n} control points does not fit its {k} knots", cure="output it as points")
    vector = knots if whole else np.concatenate([np.zeros(degree + 1), knots, np.ones(degree + 1)])
    return BSpline(vector, control, degree)


def sample_spline(curve: BSpline, chord_tolerance: float, angle_tolerance: float) -> NDArray[np.float64]:
    """Points (N, 3) along the curve, its start left out, its end exact; every knot is one of them.

    Each knot span is cut evenly, ever finer, until no chord leaves the curve by more than `chord_tolerance` (m, seen
    at its quarters) and no two neighbours within a span turn by more than `angle_tolerance` (rad).
    """
    knots = np.unique(curve.t[curve.k : len(curve.t) - curve.k])
    pieces = [_span(curve, a, b, chord_tolerance, angle_tolerance) for a, b in pairwise(knots)]
    points: NDArray[np.float64] = np.concatenate(pieces)
    points[-1] = curve.c[-1]
    return points


def _span(curve: BSpline, a: float, b: float, chord: float, angle: float) -> NDArray[np.float64]:
    n = 1
    for _ in range(_DOUBLINGS):
        fine = curve(np.linspace(a, b, 4 * n + 1))
        ends = fine[::4]
        along = np.diff(ends, axis=0)
        worst = 0.0
        for quarter in (1, 2, 3):
            off = fine[quarter::4][:n] - ends[:-1]
            length2 = np.maximum(np.sum(along**2, axis=1), 1e-30)
            foot = along * (np.sum(off * along, axis=1) / length2)[:, None]
            worst = max(worst, float(np.max(np.linalg.norm(off - foot, axis=1))))
        if worst <= chord and (_turn(np.diff(fine, axis=0)) <= angle if n == 1 else _turn(along) <= angle):
            break
        n *= 2
    result: NDArray[np.float64] = curve(np.linspace(a, b, n + 1)[1:])
    return result


def _turn(steps: NDArray[np.float64]) -> float:
    """Largest angle between neighbouring steps (N, 3)."""
    length = np.linalg.norm(steps, axis=1)
    unit = steps[length > 1e-12] / length[length > 1e-12, None]
    if len(unit) < 2:
        return 0.0
    return float(np.max(np.arccos(np.clip(np.sum(unit[1:] * unit[:-1], axis=1), -1.0, 1.0))))
