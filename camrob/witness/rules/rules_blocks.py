"""Many motions of both stories at once, where they are of one kind: the same ones, the chords of an arc, points left out.

Each answers how many of the rows from here on are in order; what stops a block is judged a motion at a time.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from camrob.witness.rules.rules_along import MOVED, Tolerance
from camrob.witness.rules.rules_geometry import AXIS, POSITION, Motion, Track, sampled, squares

__all__ = ["alike", "chords", "curve_chords", "thinned"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
_LONGER = 1.6  # than its chord, half a circle is no longer


def _first_wrong(good: Flags) -> int:
    """How many hold before the first that doesn't."""
    return len(good) if good.all() else int(np.argmin(good))


def alike(file: Track, i: int, prog: Track, j: int, n: int, open_to: Flags, plain: Flags, near: Array) -> int:
    """How many of n rows are the same motion in both, given that they begin in one place.

    open_to: (N,) of the file, a motion whose start is known; plain: (M,) of the program, no point-to-point motion; near: (N,) m.
    """
    rows, others = slice(i, i + n), slice(j, j + n)
    same = squares(prog.tip[others] - file.tip[rows]) <= near[rows] ** 2
    same &= squares(prog.axis[others] - file.axis[rows]) <= AXIS**2
    angles = file.angle[rows], prog.angle[others]
    same &= open_to[rows] & plain[others] & ((angles[0] > 0.0) == (angles[1] > 0.0))
    arcs = np.flatnonzero(same & (angles[0] > 0.0))
    if len(arcs):
        same[arcs] &= np.abs(angles[0][arcs] - angles[1][arcs]) < 0.5
        for k in range(1, 8):
            apart = sampled(file, i + arcs, k / 8) - sampled(prog, j + arcs, k / 8)
            same[arcs] &= squares(apart) <= POSITION**2
    return _first_wrong(same)


def chords(arc: Motion, u: float, prog: Track, j: int, n: int, plain: Flags, tol: Tolerance) -> Array:
    """The fractions of an arc that straight motions from row j on reach, one after the other, from the fraction u on; as many
    of n as lie on it, short of its end.
    """
    rows = slice(j, j + n)
    arm = prog.tip[rows] - np.array(arc.center)
    across, normal = np.array(arc.across), np.array(arc.normal)
    x, y, height = arm @ across[0], arm @ across[1], arm @ normal
    angle = np.arctan2(y, x)
    turn = np.diff(angle, prepend=u * arc.angle) % (2.0 * math.pi)
    reached = u + np.cumsum(turn) / arc.angle
    r, h = (a + reached * (b - a) for a, b in (arc.radii, arc.heights))
    good = plain[rows] & (prog.angle[rows] == 0.0) & (turn > 0.0) & (turn <= math.pi)
    good &= (np.hypot(x, y) - r) ** 2 + (height - h) ** 2 <= tol.place**2
    good &= max(arc.radii) * (1.0 - np.cos(0.5 * turn)) <= tol.place + tol.chord
    good &= squares(prog.axis[rows] - _axes(arc, reached)) <= tol.axis**2
    good &= (1.0 - reached) * arc.length > tol.place + 2.0 * MOVED
    return reached[: _first_wrong(good)]


def curve_chords(file: Track, i: int, count: int, u: float, prog: Track, j: int, plain: Flags, tol: Tolerance) -> Array:
    """How many of the `count` pieces of a curve from motion i on, of which the fraction u of the first is done, are done after
    each straight motion from row j on, as long as they are the curve's chords: both ends on it, what lies between within the
    chord tolerance, and never backwards.
    """
    corners = np.vstack([file.start[i], file.tip[i : i + count]])
    way = np.diff(corners, axis=0)
    lengths = np.sqrt(squares(way))
    s = np.concatenate([[0.0], np.cumsum(lengths)])
    at, reached = u * lengths[0], list[float]()
    for k in range(j, len(prog)):
        start, tip = prog.start[k], prog.tip[k]
        leg, turned = (float(np.linalg.norm(v)) for v in (tip - start, prog.axis[k] - file.axis[i]))
        if not plain[k] or prog.angle[k] or at >= s[-1] or turned > tol.axis:
            break
        most = at + _LONGER * leg + 4.0 * (tol.place + tol.chord)
        low, high = (int(np.searchsorted(s, p, side="right")) for p in (at, most))
        near = slice(low - 1, min(high, count))  # pieces that it may end on
        f = np.einsum("ij,ij->i", tip - corners[near], way[near]) / lengths[near] ** 2
        f = np.clip(f, np.clip((at - s[near]) / lengths[near], 0.0, 1.0), 1.0)
        off = squares(corners[near] + f[:, None] * way[near] - tip)
        best = int(np.argmin(off))
        to, piece = float(s[near][best] + f[best] * lengths[near][best]), near.start + best
        over = _off_line(corners[low : piece + 1], start, tip)
        if off[best] > tol.place**2 or over > tol.place + tol.chord or (to <= at and leg > 2.0 * MOVED):
            break
        at = s[-1] if s[-1] - to <= 2.0 * MOVED else to
        reached.append(float(count) if at == s[-1] else piece + float(f[best]))
    return np.array(reached)


def _off_line(points: Array, start: Array, end: Array) -> float:
    """How far the farthest of points (n, 3) lies from the straight way between two places."""
    way = end - start
    f = np.clip((points - start) @ way / max(float(way @ way), 1e-300), 0.0, 1.0)
    return math.sqrt(float(squares(start + f[:, None] * way - points).max(initial=0.0)))


def _axes(motion: Motion, f: Array) -> Array:
    """The tool's axis at fractions of a motion: (n, 3)."""
    start, end = np.array(motion.axis_start), np.array(motion.axis_end)
    turn = math.acos(min(1.0, max(-1.0, float(start @ end))))
    if turn < 1e-7:
        return np.broadcast_to(end, (len(f), 3))
    weights = np.stack([np.sin((1.0 - f) * turn), np.sin(f * turn)], axis=1) / math.sin(turn)
    return np.asarray(weights @ np.stack([start, end]))


def thinned(
    file: Track, i: int, prog: Track, j: int, n: int, open_to: Flags, plain: Flags, tol: Tolerance
) -> NDArray[np.int64]:
    """How far straight motions from row j on get in the file, where some of its points are left out: after each of them, how
    many of the file's motions from i on are done; as many of n as end on a point of the file and keep to the points between.
    """
    ends = _ends(file.tip[i : i + 8 * n], prog.tip[j : j + n])
    count = len(ends)
    if not count:
        return ends
    legs = np.repeat(np.arange(count), np.diff(ends, prepend=0))  # of each motion of the file, the program's
    rows, others = slice(i, i + len(legs)), j + legs
    start, way = prog.start[others], prog.tip[others] - prog.start[others]
    size = np.maximum(squares(way), 1e-300)
    f = np.clip(np.einsum("ij,ij->i", file.tip[rows] - start, way) / size, 0.0, 1.0)
    good = squares(start + f[:, None] * way - file.tip[rows]) <= tol.place**2
    axis = (1.0 - f)[:, None] * prog.axis_start[others] + f[:, None] * prog.axis[others]
    axis /= np.maximum(np.sqrt(squares(axis)), 1e-300)[:, None]  # nearly the great arc: points left out turn little
    good &= squares(axis - file.axis[rows]) <= tol.axis**2
    good[1:] &= (np.diff(f) >= -POSITION / np.sqrt(size[1:])) | (np.diff(legs) > 0)
    good &= (file.angle[rows] == 0.0) & open_to[rows] & plain[others] & (prog.angle[others] == 0.0)
    done = _first_wrong(good)
    return ends[ends <= done]


def _ends(points: Array, tips: Array) -> NDArray[np.int64]:
    """After each tip the number of points up to the one that it is, in order; as many tips as are points."""
    found, k = [], 0
    listed = points.tolist()
    for x, y, z in tips.tolist():
        for m in range(k, min(k + 64, len(listed))):
            p = listed[m]
            if abs(p[0] - x) + abs(p[1] - y) + abs(p[2] - z) <= 3.0 * MOVED:
                break
        else:
            break
        k = m + 1
        found.append(k)
    return np.array(found, dtype=np.int64)
