"""Clamped B-spline curves as points within a chord and an angle tolerance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError

if TYPE_CHECKING:  # SciPy is loaded where a curve is: most files hold none, and it takes a third of a second
    from scipy.interpolate import BSpline

__all__ = ["clamped_spline", "sample_spline"]

_HALVINGS = 30  # of a piece between two knots: the tolerances end it long before
_FINE = 0.05  # of the chord tolerance goes into the points, the rest into leaving most of them out
_HIGHEST_DEGREE = 9  # CAM systems write 3, some 5


def clamped_spline(control: NDArray[np.float64], knots: NDArray[np.float64]) -> BSpline:
    """The curve of control points (N, 3) over `knots`: the interior ones (between 0 and 1), with or without the last one, 1,
    which NX says, or the whole clamped vector.

    The degree follows from the two counts. Raises ToolpathError where they don't fit each other.
    """
    n, k = len(control), len(knots)
    whole = k > n and bool(knots[0] == knots[1] and knots[-1] == knots[-2])
    if not whole and k and knots[-1] == 1.0:
        knots = knots[:-1]
    k = len(knots)
    within = (knots >= 0.0) & (knots <= 1.0) if whole else (knots > 0.0) & (knots < 1.0)
    if n < 2 or np.any(np.diff(knots) < 0.0) or not within.all():
        raise ToolpathError("a NURBS has knots out of order or too few control points", hint="output it as points")
    degree = k - n - 1 if whole else n - k - 1
    if not 1 <= degree <= _HIGHEST_DEGREE:
        raise ToolpathError(f"a NURBS of {n} control points does not fit its {k} knots", hint="output it as points")
    from scipy.interpolate import BSpline

    vector = knots if whole else np.concatenate([np.zeros(degree + 1), knots, np.ones(degree + 1)])
    return BSpline(vector, control, degree)


def sample_spline(curve: BSpline, chord_tolerance: float, angle_tolerance: float) -> NDArray[np.float64]:
    """Points (N, 3) along the curve, its start left out, its end exact.

    No chord leaves the curve by more than `chord_tolerance` (m), and along none does the curve turn by more than
    `angle_tolerance` (rad), but where it turns on the spot: pieces are halved where they need it, however dense the knots,
    then as many of them as may go with one chord.
    """
    fine = _refined(curve, _FINE * chord_tolerance, angle_tolerance)
    points: NDArray[np.float64] = fine[_vertices(fine, (1.0 - _FINE) * chord_tolerance, angle_tolerance)]
    points[-1] = curve.c[-1]
    return points


def _refined(curve: BSpline, chord: float, angle: float) -> NDArray[np.float64]:
    """Points (N, 3) from the curve's start to its end, near enough for chords between neighbours. One that is shorter than
    `chord` is near enough, whatever the curve does along it.
    """
    grid = np.unique(curve.t[curve.k : len(curve.t) - curve.k])
    open_ = np.ones(len(grid) - 1, dtype=bool)
    for _ in range(_HALVINGS):
        left, right = grid[:-1][open_], grid[1:][open_]
        fine = curve(left + np.linspace(0.0, 1.0, 5)[:, None] * (right - left))  # (5, pieces, 3)
        along = fine[-1] - fine[0]
        length2 = np.maximum(np.sum(along**2, axis=-1), 1e-30)
        off = fine[1:-1] - fine[0]
        foot = along * (np.sum(off * along, axis=-1) / length2)[..., None]
        steps = np.diff(fine, axis=0)
        far = np.linalg.norm(off - foot, axis=-1).max(axis=0) > chord
        rough = far | ((_turns(steps).sum(axis=0) > angle) & (np.linalg.norm(steps, axis=-1).sum(axis=0) > chord))
        at = np.flatnonzero(open_)[rough]
        if not len(at):
            break
        grid = np.insert(grid, at + 1, 0.5 * (left + right)[rough])
        halved = np.zeros(len(grid) - 1, dtype=bool)
        first = at + np.arange(len(at))
        halved[first] = halved[first + 1] = True
        open_ = halved
    result: NDArray[np.float64] = curve(grid)
    return result


def _vertices(points: NDArray[np.float64], chord: float, angle: float) -> list[int]:
    """Which of `points` (N, 3) a polyline needs, the first left out: the chord to each is as long as it may be."""
    steps = np.diff(points, axis=0)
    turned = np.concatenate([[0.0], np.cumsum(_turns(steps))])  # by which the path has turned before step k
    last = len(points) - 1
    vertices, here = list[int](), 0
    while here < last:
        furthest = int(np.searchsorted(turned, turned[max(here - 1, 0)] + angle, side="right"))
        furthest -= furthest < last  # the corners at both ends of the chord count
        low, high, size = here + 1, max(furthest, here + 1), 1
        while low < high:  # galloping, then halving
            there = min(low + size, high)
            if _straight(points[here : there + 1], chord):
                low, size = there, 2 * size
            elif size == 1:
                break
            else:
                high, size = there - 1, max((there - low) // 2, 1)
        vertices.append(low)
        here = low
    return vertices


def _straight(points: NDArray[np.float64], chord: float) -> bool:
    """Whether all points (N, 3) lie by the chord from the first to the last."""
    along, off = points[-1] - points[0], points[1:-1] - points[0]
    share = np.clip(off @ along / max(float(along @ along), 1e-30), 0.0, 1.0)
    return bool((np.linalg.norm(off - share[:, None] * along, axis=1) <= chord).all())


def _turns(steps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles (N - 1, ...) between neighbouring steps (N, ..., 3), 0 at a step that leads nowhere."""
    a, b = steps[:-1], steps[1:]
    across = np.linalg.norm(np.cross(a, b), axis=-1)
    turns: NDArray[np.float64] = np.arctan2(across, np.sum(a * b, axis=-1))
    return turns
