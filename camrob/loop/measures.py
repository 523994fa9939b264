"""What a run's errors come to: per axis, at the tool, across the path, and in peaks at corners and reversals."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError
from camrob.frozen import locked
from camrob.loop.loop import LoopLog
from camrob.loop.paths import TestPath

__all__ = ["Reversal", "RunMeasure", "Size", "across", "measure_run", "off_path", "reversals"]

Array = NDArray[np.float64]

_STILL = 1e-7  # rad/s below which a joint counts as at rest
# s about a reversal: where its peak is counted from, and where it is looked for
_BEFORE, _AFTER = (-0.6, -0.3), (-0.3, 1.5)
_CORNER = (-0.2, 1.5)  # s about a corner
_TOGETHER = 0.5  # s within which joints turn round at one place
_APART = 2.0  # s that a reversal must be away from corners to count as one of its own


class Reversal(NamedTuple):
    """Joints `axes` (0 to 5) turn round about cycle `cycle`."""

    axes: tuple[int, ...]
    cycle: int


class Size(NamedTuple):
    """Of absolute values: mean, root mean square, 95th percentile, largest."""

    mean: float
    rms: float
    p95: float
    most: float

    @classmethod
    def of(cls, values: Array) -> Size:
        """Of some values, whatever their signs. Raises InputError where there are none or one is no number."""
        v = np.abs(np.asarray(values, float))
        if v.size == 0 or not np.isfinite(v).all():
            raise InputError("there are no errors to measure, or one is not a number", hint="check the run")
        return cls(float(v.mean()), float(np.sqrt(np.mean(v**2))), float(np.percentile(v, 95)), float(v.max()))


@dataclass(frozen=True, slots=True)
class RunMeasure:
    """Over the moving part of a run from `begin` s on; m and rad.

    axes: six, of x, y, z, A, B, C. tool: from the set-point to the tool. path: from the programmed line or circle, in its plane.
    Those with `seen_` are the tracker's view, noise and latency included; the others where the tool really was. corners: largest
    distance to the set-point about each; peaks: greatest change across the path at each of `reversals`. static: the error at
    rest before the start, or with the correction on, at the end of it. late_cuts: share of cycles, from 3 s after the
    correction began, in which an increment was cut.
    """

    begin: float
    axes: tuple[Size, ...]
    seen_axes: tuple[Size, ...]
    tool: Size
    seen_tool: Size
    path: Size
    seen_path: Size
    corners: Array
    reversals: tuple[Reversal, ...]
    peaks: Array
    static: Array
    late_cuts: float

    def __post_init__(self) -> None:
        for name in ("corners", "peaks", "static"):
            object.__setattr__(self, name, locked(getattr(self, name), name=name))


def reversals(path: TestPath) -> tuple[Reversal, ...]:
    """Where the programmed path turns joints round under way, corners and ends left aside, in the order of time."""
    cycle = float(path.time[1])
    speed = np.diff(np.asarray(path.q), axis=0) / cycle
    found: list[tuple[int, int]] = []
    for axis in range(6):
        moves = np.flatnonzero(np.abs(speed[:, axis]) > _STILL)
        turns = moves[1:][np.sign(speed[moves[1:], axis]) != np.sign(speed[moves[:-1], axis])]
        for k in turns:
            if np.abs(path.corners - k).min() * cycle > _APART:
                found.append((int(k), axis))
    out: list[Reversal] = []
    for k, axis in sorted(found):
        if out and (k - out[-1].cycle) * cycle < _TOGETHER:
            out[-1] = Reversal((*out[-1].axes, axis), out[-1].cycle)
        else:
            out.append(Reversal((axis,), k))
    return tuple(out)


def across(path: TestPath, error: Array) -> Array:
    """Deviation (N,), m, of the tool from the side being run or from the circle, in the plane; outwards counts up."""
    place = np.asarray(path.wanted)[:, :2] - error[:, :2]
    if path.radius > 0.0:
        return np.asarray(np.linalg.norm(place - path.center[:2], axis=1) - path.radius)
    outward = np.array([[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])[path.side]
    return -np.asarray(np.sum(outward * error[:, :2], axis=1))


def off_path(path: TestPath, error: Array) -> Array:
    """Distance (N,), m, in the plane from the nearest point of the whole square or circle."""
    if path.radius > 0.0:
        return np.abs(across(path, error))
    place = np.asarray(path.wanted)[:, :2] - error[:, :2]
    corners = np.asarray(path.wanted)[path.corners, :2]
    distance = []
    for a, b in pairwise(corners):
        t = np.clip((place - a) @ (b - a) / float((b - a) @ (b - a)), 0.0, 1.0)
        distance.append(np.linalg.norm(place - a - t[:, None] * (b - a), axis=1))
    return np.asarray(np.min(distance, axis=0))


def measure_run(log: LoopLog, begin: float) -> RunMeasure:
    """The measure of a run, from `begin` s on. Raises InputError where the run has ended before."""
    path, error, seen = log.run.path, np.asarray(log.error), np.asarray(log.seen)
    cycle = float(path.time[1])
    part = path.moving & (path.time >= begin)
    turned = tuple(r for r in reversals(path) if r.cycle * cycle >= begin)
    off = np.column_stack([across(path, error), error[:, 2]])

    def window(at: int, span: tuple[float, float]) -> slice:
        return slice(max(at + round(span[0] / cycle), 0), at + round(span[1] / cycle))

    peaks = [
        np.linalg.norm(off[window(r.cycle, _AFTER)] - off[window(r.cycle, _BEFORE)].mean(axis=0), axis=1).max()
        for r in turned
    ]
    distance = np.linalg.norm(error[:, :3], axis=1)
    corners = [distance[window(int(k), _CORNER)].max() for k in path.corners if k * cycle >= begin]
    rest = int(path.corners[0])
    settled = np.flatnonzero(path.time >= log.run.begin * cycle + 3.0)
    return RunMeasure(
        begin,
        tuple(Size.of(error[part, k]) for k in range(6)),
        tuple(Size.of(seen[part, k]) for k in range(6)),
        Size.of(distance[part]),
        Size.of(np.linalg.norm(seen[part, :3], axis=1)),
        Size.of(off_path(path, error)[part]),
        Size.of(off_path(path, seen)[part]),
        np.array(corners),
        turned,
        np.array(peaks),
        error[rest // 2 : rest].mean(axis=0),
        float(log.saturated[settled].mean()) if len(settled) else 0.0,
    )
