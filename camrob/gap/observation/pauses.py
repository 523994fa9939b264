"""Where in a log the robot rests: stretches in which no set-point moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.gap.observation.scene import Scene

__all__ = ["Rest", "rests_of"]

_LEAST = 0.15  # s: what is shorter may be a corner passed slowly
_STILL = 4e-6  # rad and m that an axis at rest moves within that time: what its set-points are printed to


@dataclass(frozen=True, slots=True)
class Rest:
    """first, last: samples between which nothing moves; seconds: how long; grain: s by which that is uncertain."""

    first: int
    last: int
    seconds: float
    grain: float


def rests_of(scene: Scene) -> tuple[Rest, ...]:
    """The rests of a log, in order; a stretch that ends or begins at a hole in time ends or begins there."""
    t, values = scene.t, scene.command
    found: list[Rest] = []
    for run in scene.pieces:
        own, u = t[run], values[run]
        if len(own) < 3:
            continue
        grain = float(np.median(np.diff(own)))
        ahead = np.searchsorted(own, own + max(_LEAST, 1.5 * grain) - 1e-9)
        whole = ahead < len(own)
        still = whole & (np.abs(u[np.minimum(ahead, len(own) - 1)] - u).max(axis=1) <= _STILL)
        found += _joined(np.flatnonzero(still), ahead, own, grain, run.start)
    return tuple(found)


def _joined(
    begins: NDArray[np.int64], ahead: NDArray[np.int64], t: NDArray[np.float64], grain: float, shift: int
) -> list[Rest]:
    """Rests of windows [i, ahead[i]] that overlap."""
    out: list[Rest] = []
    if not len(begins):
        return out
    cuts = np.flatnonzero(begins[1:] > ahead[begins[:-1]]) + 1
    for part in np.split(begins, cuts):
        a, b = int(part[0]), int(ahead[part[-1]])
        out.append(Rest(a + shift, b + shift, float(t[b] - t[a]), grain))
    return out
