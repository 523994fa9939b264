"""Runs of rows that have one value."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["runs_of"]


def runs_of(values: ArrayLike) -> tuple[slice, ...]:
    """From where to where values (N,) stay the same, in their order; none of no values."""
    rows = np.asarray(values)
    edges = [0, *(np.flatnonzero(np.diff(rows)) + 1).tolist(), len(rows)]
    return tuple(slice(a, b) for a, b in pairwise(edges) if b > a)
