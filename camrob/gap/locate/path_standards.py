"""Figures of the standards, where a run is a line or a circle: ISO 9283 path accuracy, ISO 230-4 circular deviation.

ISO 9283: AT is the largest distance, over the planes across the commanded line, from it to the mean of the attained paths; RT
the largest mean distance of the attained paths from their mean plus three standard deviations. One direction at a time.
ISO 230-4: G is the radial range of the actual path about its own least-squares circle, one direction at a time; G(b) that of
both together; H the largest radial difference between them; F the largest and least radial departure from the commanded circle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.summaries.diagnosis_places import CircleDeviation, OneTurn, OneWay, RunStandard, Standard
from camrob.units import deg_to_rad, m_to_mm, mm_to_m

__all__ = ["Circle", "Line", "path_standards", "shape_of"]

Array = NDArray[np.float64]

_TRUE = mm_to_m(0.03)  # m that the commanded path may keep from a line or circle
_SHARE = 0.7  # of the samples that lie on it
_LEAST_LENGTH, _LEAST_RADIUS, _MOST_RADIUS = mm_to_m(20.0), mm_to_m(5.0), 5.0
_FULL = deg_to_rad(350.0)
_PLANES = 50  # across a line, that its figures are taken over
_BINS = 120  # of a circle
_MARGIN = 0.05  # of a line, at both ends, where it speeds up and turns round
_MOVING = 0.2  # of the ordinary speed: slower samples are no motion in a direction


@dataclass(frozen=True, slots=True)
class Line:
    """start (3,), along (3,) of length 1, length m; rows: samples that lie on it."""

    start: Array
    along: Array
    length: float
    rows: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Circle:
    """centre (3,), u, v (3,) in its plane, counter-clockwise, radius m; rows: samples that lie on it."""

    centre: Array
    u: Array
    v: Array
    radius: float
    rows: NDArray[np.int64]


def shape_of(commanded: Array) -> Line | Circle | None:
    """The line or the full circle that most of a commanded path (N, 3) is; None for any other."""
    if len(commanded) < 3 * _PLANES:
        return None
    middle = commanded[len(commanded) // 5 : -len(commanded) // 5]
    mean = middle.mean(axis=0)
    _, size, axes = np.linalg.svd(middle - mean, full_matrices=False)
    if size[0] <= 0.0:
        return None
    along = axes[0]
    s = (commanded - mean) @ along
    off = np.linalg.norm(commanded - mean - s[:, None] * along, axis=1)
    rows = np.flatnonzero(off < _TRUE)
    if len(rows) > _SHARE * len(commanded) and np.ptp(s[rows]) > _LEAST_LENGTH:
        low = float(s[rows].min())
        return Line(mean + low * along, along, float(np.ptp(s[rows])), rows)
    return _circle(commanded, middle, mean, axes)


def _circle(commanded: Array, middle: Array, mean: Array, axes: Array) -> Circle | None:
    u, v = axes[0], axes[1]
    if np.abs((middle - mean) @ axes[2]).max() > _TRUE:
        return None
    x, y = (middle - mean) @ u, (middle - mean) @ v
    A = np.stack([2.0 * x, 2.0 * y, np.ones_like(x)], axis=1)
    cx, cy, c = np.linalg.lstsq(A, x**2 + y**2, rcond=None)[0]
    radius = float(np.sqrt(max(c + cx**2 + cy**2, 0.0)))
    if not _LEAST_RADIUS < radius < _MOST_RADIUS:
        return None
    centre = mean + cx * u + cy * v
    out = commanded - centre
    off = np.hypot(np.hypot(out @ u, out @ v) - radius, out @ axes[2])
    rows = np.flatnonzero(off < _TRUE)
    if len(rows) < _SHARE * len(commanded):
        return None
    angle = np.unwrap(np.arctan2(out[rows] @ v, out[rows] @ u))
    return Circle(centre, u, v, radius, rows) if np.ptp(angle) > _FULL else None


def path_standards(log: str, commanded: Array, before: Array, after: Array) -> Standard | None:
    """The figures of a run, whose log is `log`, mm; None where it is neither line nor circle, or no line is gone
    from end to end.

    commanded: (N, 3) m in the frame in which the path is one; before, after: (N, 3) m, what was measured less that, as it is
    and without the effects found.
    """
    shape = shape_of(commanded)
    if shape is None:
        return None
    at, was, now = commanded[shape.rows], before[shape.rows], after[shape.rows]
    if isinstance(shape, Line):
        run = _on_line(shape, at, was)
        if run.forward is None and run.back is None:
            return None  # never from end to end: its figures are of whole ways
        return Standard(
            log=log,
            shape="line",
            standard="ISO 9283",
            length_mm=m_to_mm(shape.length),
            before=run,
            after=_on_line(shape, at, now),
        )
    return Standard(
        log=log,
        shape="circle",
        standard="ISO 230-4",
        radius_mm=m_to_mm(shape.radius),
        before=_on_circle(shape, at, was),
        after=_on_circle(shape, at, now),
    )


def _runs(place: Array) -> list[tuple[int, NDArray[np.int64]]]:
    """Stretches of one direction of a place along the path (N,), each with its sign."""
    speed = np.gradient(place)
    usual = float(np.median(np.abs(speed)))
    sign = np.where(np.abs(speed) > _MOVING * usual, np.sign(speed), 0.0)
    cuts = np.flatnonzero(np.diff(sign)) + 1
    parts = np.split(np.arange(len(place)), cuts)
    return [(int(sign[p[0]]), p) for p in parts if sign[p[0]] != 0.0]


def _on_line(line: Line, at: Array, error: Array) -> RunStandard:
    s = (at - line.start) @ line.along
    across = error - np.outer(error @ line.along, line.along)
    planes = np.linspace(_MARGIN, 1.0 - _MARGIN, _PLANES) * line.length
    cycles: dict[int, list[Array]] = {}
    for sign, rows in _runs(s):
        order = rows[np.argsort(s[rows])]
        if s[order[0]] <= planes[0] and s[order[-1]] >= planes[-1]:
            cycles.setdefault(sign, []).append(
                np.stack([np.interp(planes, s[order], across[order, k]) for k in range(3)], axis=1)
            )
    forward, back = (_one_way(np.stack(cycles[sign])) if sign in cycles else None for sign in (1, -1))
    return RunStandard(forward=forward, back=back)


def _one_way(paths: Array) -> OneWay:
    """Of the attained paths (C, P, 3) of one direction, across the line, at the same planes."""
    mean = paths.mean(axis=0)
    apart = np.linalg.norm(paths - mean, axis=2)
    spread = apart.mean(axis=0) + 3.0 * apart.std(axis=0, ddof=1) if len(paths) > 1 else None
    return OneWay(
        cycles=len(paths),
        AT_mm=m_to_mm(float(np.linalg.norm(mean, axis=1).max())),
        RT_mm=None if spread is None else m_to_mm(float(spread.max())),
    )


def _on_circle(circle: Circle, at: Array, error: Array) -> RunStandard:
    out = at - circle.centre
    angle = np.unwrap(np.arctan2(out @ circle.v, out @ circle.u))
    measured = at + error - circle.centre
    x, y = measured @ circle.u, measured @ circle.v
    polar = {
        name: _binned(angle[rows], x[rows], y[rows])
        for name, sign in (("ccw", 1), ("cw", -1))
        if len(rows := np.concatenate([np.zeros(0, np.int64), *(p for s, p in _runs(angle) if s == sign)])) > _BINS
    }
    if not polar:
        return RunStandard()
    turns = {name: OneTurn(G_mm=m_to_mm(float(np.ptp(_radii(points))))) for name, points in polar.items()}
    every = np.concatenate(list(polar.values()))
    radial = np.hypot(every[:, 0], every[:, 1]) - circle.radius
    both = apart = None
    if len(polar) == 2:
        both = m_to_mm(float(np.ptp(_radii(every))))
        there, back = (np.hypot(p[:, 0], p[:, 1]) for p in polar.values())
        if len(there) == len(back) == _BINS:
            apart = m_to_mm(float(np.abs(there - back).max()))
    deviation = CircleDeviation(
        F_max_mm=m_to_mm(float(radial.max())), F_min_mm=m_to_mm(float(radial.min())), G_b_mm=both, H_mm=apart
    )
    return RunStandard(ccw=turns.get("ccw"), cw=turns.get("cw"), circle=deviation)


def _binned(angle: Array, x: Array, y: Array) -> Array:
    """(M, 2) points by angle, radius and direction the mean of each slot's, so that the instrument's noise counts little."""
    slot = np.floor(np.mod(angle, 2.0 * np.pi) / (2.0 * np.pi) * _BINS).astype(np.int64) % _BINS
    count = np.bincount(slot, minlength=_BINS)
    used = count > 0
    radius, mx, my = (np.bincount(slot, weights=w, minlength=_BINS)[used] / count[used] for w in (np.hypot(x, y), x, y))
    return np.asarray(np.stack([mx, my], axis=1) * (radius / np.hypot(mx, my))[:, None])


def _radii(points: Array) -> Array:
    """Radii (M,) about the least-squares circle's centre of points (M, 2)."""
    A = np.concatenate([2.0 * points, np.ones((len(points), 1))], axis=1)
    centre = np.linalg.lstsq(A, np.sum(points**2, axis=1), rcond=None)[0][:2]
    return np.asarray(np.linalg.norm(points - centre, axis=1))
