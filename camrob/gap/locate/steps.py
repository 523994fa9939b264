"""What sits elsewhere from a moment on and is no axis: a tool or an instrument that was bumped, a foot that slipped."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = ["steps"]

Array = NDArray[np.float64]

_MOMENTS, _EDGE = 16, 0.1  # of a log that are tried, and the share of its rows at either end in which a step is none


def steps(t: Array, log: NDArray[np.int64], gain: Callable[[Array], float]) -> Iterator[Array]:
    """Shapes (N, 1 + k): a constant, and what is there from a moment of one log on, or of each; the moments with the most `gain`
    of a shape. t: (N,) s; log: (N,) its number.
    """
    best = [max(_of_log(t, log == k), key=lambda step: gain(_beside_constant([step]))) for k in np.unique(log)]
    yield max((_beside_constant([step]) for step in best), key=gain)
    if len(best) > 1:
        yield _beside_constant(best)


def _of_log(t: Array, own: NDArray[np.bool_]) -> Iterator[Array]:
    for moment in np.unique(np.quantile(t[own], np.linspace(_EDGE, 1.0 - _EDGE, _MOMENTS))):
        yield (own & (t > moment)).astype(np.float64)


def _beside_constant(columns: Sequence[Array]) -> Array:
    return np.stack([np.ones(len(columns[0])), *columns], axis=1)
