"""Arcs and helices as points within a chord and an angle tolerance."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camrob.errors import ToolpathError

__all__ = ["ANGLE_TOLERANCE", "CHORD_TOLERANCE", "arc_angle", "arc_radius", "sample_arc"]

CHORD_TOLERANCE = 10e-6  # m: what an arc's chord may leave of the arc unless the caller says otherwise
ANGLE_TOLERANCE = math.pi / 36.0  # rad: how far the direction may turn from one chord to the next (5 degrees)

_CLOSED = 1e-9  # m: start and end nearer than this are one point, so the arc is a full circle
_MOST_POINTS = 1_000_000  # of one arc: a helix with more turns than this is a slip of the pen, not a path


def _in_plane(point: ArrayLike, center: NDArray[np.float64], axis: NDArray[np.float64]) -> NDArray[np.float64]:
    """The part of point - center that is normal to the axis."""
    radial: NDArray[np.float64] = np.asarray(point, dtype=np.float64) - center
    return radial - axis * float(radial @ axis)


def _cross(u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """The cross product of two vectors, without numpy's overhead for single ones."""
    (a, b, c), (x, y, z) = u.tolist(), v.tolist()
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


def arc_radius(start: ArrayLike, center: ArrayLike, axis: ArrayLike) -> float:
    """Distance (m) of `start` from the line through `center` along the unit `axis`."""
    return float(np.linalg.norm(_in_plane(start, np.asarray(center, np.float64), np.asarray(axis, np.float64))))


def arc_angle(start: ArrayLike, end: ArrayLike, center: ArrayLike, axis: ArrayLike, turns: int = 0) -> float:
    """Angle (rad, > 0) from `start` to `end`, right-handed about the unit `axis` through `center`.

    Start and end that coincide (seen along the axis) make a full circle. `turns` adds as many further full turns.
    Raises ToolpathError when one of them lies on the axis.
    """
    c, a = np.asarray(center, np.float64), np.asarray(axis, np.float64)
    u, v = _in_plane(start, c, a), _in_plane(end, c, a)
    if min(np.linalg.norm(u), np.linalg.norm(v)) < _CLOSED:
        raise ToolpathError("an arc starts or ends at its own centre", hint="check the arc's centre in the CAM system")
    if float(np.linalg.norm(v - u)) < _CLOSED:
        return math.tau * (1 + turns)
    angle = math.atan2(float(_cross(u, v) @ a), float(u @ v))
    return (angle if angle > 0.0 else angle + math.tau) + math.tau * turns


def sample_arc(
    start: ArrayLike,
    end: ArrayLike,
    center: ArrayLike,
    axis: ArrayLike,
    rise: float,
    turns: int,
    chord_tolerance: float = CHORD_TOLERANCE,
    angle_tolerance: float = ANGLE_TOLERANCE,
) -> NDArray[np.float64]:
    """Points (N, 3) along an arc or helix: `start` is left out, the last one is exactly `end`.

    The motion turns right-handedly about the unit `axis` through `center` by `arc_angle` of the same arguments while
    it rises by `rise` (m, along the axis) from start to end; a left-handed arc is one about the reversed axis.
    Chords leave the arc by at most `chord_tolerance` (m) and turn by at most `angle_tolerance` (rad) from one to
    the next, in equal steps. Start and end may lie on slightly different radii (files are rounded): the radius
    runs linearly between them. Raises ToolpathError for a degenerate arc or one with more than a million points.
    """
    p, q = np.asarray(start, np.float64), np.asarray(end, np.float64)
    c, a = np.asarray(center, np.float64), np.asarray(axis, np.float64)
    angle = arc_angle(p, q, c, a, turns)
    u, v = _in_plane(p, c, a), _in_plane(q, c, a)
    r0, r1 = float(np.linalg.norm(u)), float(np.linalg.norm(v))
    sagitta = min(chord_tolerance / max(r0, r1), 1.0)
    step = min(angle_tolerance, 2.0 * math.acos(1.0 - sagitta))
    if not step > 0.0 or angle / step > _MOST_POINTS:
        raise ToolpathError(
            f"an arc of {angle / math.tau:.1f} turns would need more than {_MOST_POINTS} points",
            hint="check its number of turns, or choose a coarser chord tolerance",
        )
    n = max(1, math.ceil(angle / step - 1e-9))
    share = np.arange(1, n + 1, dtype=np.float64) / n
    turned = share * angle
    e1 = u / r0
    e2 = _cross(a, e1)
    radius = r0 + (r1 - r0) * share
    plane = c + a * float((p - c) @ a)  # the centre, lifted into the plane of the start
    points: NDArray[np.float64] = (
        plane
        + (radius * np.cos(turned))[:, None] * e1
        + (radius * np.sin(turned))[:, None] * e2
        + (rise * share)[:, None] * a
    )
    points[-1] = q
    return points
