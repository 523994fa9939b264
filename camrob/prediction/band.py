"""Within which distance 95 % of a deviation's values lie, where the size of a part of it is itself in doubt.

A normal deviation whose standard deviation is only known to a factor has more of its values far out: within 1.96 of the standard
deviations that were estimated there are fewer than 95 % of them. The factor's logarithm is taken as normal.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from camrob.gap.unexplained import SIZE_DOUBT

__all__ = ["band_within", "field_sizes"]

Array = NDArray[np.float64]

_WITHIN = 0.95  # what a band is said to hold
_NODES = 15  # of Gauss and Hermite's rule: the table is right to 1e-5 of itself
_SHARES = 101  # of the variance, between which the table is straight
_NARROWEST, _WIDEST, _HALVINGS = 1.0, 6.0, 40  # standard deviations, between which the band is looked for


def band_within(variance: Array, unsized: Array) -> Array:
    """(P,) m within which 95 % of deviations of a variance (P,) m2 lie, either way; unsized: (P,) m2, the part of that whose size
    is in doubt by `SIZE_DOUBT`.
    """
    share = np.divide(unsized, variance, out=np.zeros_like(variance), where=variance > 0.0)
    shares, wide = _table()
    return np.asarray(np.sqrt(variance) * np.interp(share, shares, wide))


def field_sizes(rng: np.random.Generator, count: int) -> Array:
    """(count,) factors by which fields may be larger than they were estimated."""
    return np.exp(SIZE_DOUBT * rng.standard_normal(count))


@cache
def _table() -> tuple[Array, Array]:
    """Shares of the variance whose size is in doubt, and by how many standard deviations 95 % are held then."""
    x, weight = np.polynomial.hermite_e.hermegauss(_NODES)
    weight = weight / weight.sum()
    share = np.linspace(0.0, 1.0, _SHARES)
    size = np.sqrt(1.0 + share[:, None] * (np.exp(2.0 * SIZE_DOUBT * x) - 1.0))
    low, high = np.full(_SHARES, _NARROWEST), np.full(_SHARES, _WIDEST)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        held = (2.0 * ndtr(middle[:, None] / size) - 1.0) @ weight >= _WITHIN
        low, high = np.where(held, low, middle), np.where(held, middle, high)
    return share, high
