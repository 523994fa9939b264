"""Where a path repeats itself: laps, found by the way that the axes have gone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.gap.observation.scene import Scene

__all__ = ["laps_of"]

Array = NDArray[np.float64]

_PLACES = 1200  # that the way is divided in
_SHORTEST, _LONGEST = 0.04, 0.5  # of the way, for a lap
_SAME = 0.02  # of the axes' spread (rms): two places are the same
_WHOLE = 0.8  # of a lap, for the last one to count


def laps_of(scene: Scene) -> list[NDArray[np.bool_]]:
    """(N,) a lap, of a log whose path repeats at least twice; [] where it doesn't. Laps may be run at different speeds."""
    u = scene.command
    span = np.ptp(u, axis=0)
    if scene.poses or len(u) < 100 or span.max() <= 0.0:
        return []
    u = u[:, span > 1e-4] / np.maximum(span[span > 1e-4], 1e-3)
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(u, axis=0), axis=1))])
    s = np.linspace(0.0, way[-1], _PLACES)
    x = np.stack([np.interp(s, way, u[:, k]) for k in range(u.shape[1])], axis=1)
    lag = _period(x)
    if lag == 0:
        return []
    number = np.floor(way / s[lag] + 1e-9).astype(np.int64)
    count = int(np.floor(way[-1] / s[lag] + (1.0 - _WHOLE)))
    return [number == n if n < count - 1 else number >= n for n in range(count)] if count > 1 else []


def _period(x: Array) -> int:
    """The shortest lag by which a path (P, d), by its way, comes back to itself throughout; 0 for none."""
    spread = float(np.mean(np.sum((x - x.mean(axis=0)) ** 2, axis=1)))
    lags = np.arange(int(_SHORTEST * len(x)), int(_LONGEST * len(x)) + 2)
    off = np.array([np.mean(np.sum((x[n:] - x[:-n]) ** 2, axis=1)) for n in lags])
    grain = float(np.mean(np.sum(np.diff(x, axis=0) ** 2, axis=1)))  # between the places looked at
    same = np.flatnonzero(off < _SAME**2 * spread + grain)
    if not len(same):
        return 0
    # the least of the first valley, not its edge
    first = same[: int(np.argmax(np.diff(same, append=same[-1] + 2) > 1)) + 1]
    return int(lags[first[int(np.argmin(off[first]))]])
