"""Every combination of values of several axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = ["product_grid"]


def product_grid(axes: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """(M, k) combinations of the values of k axes, the last one turning fastest; (1, 0) of no axes.

    >>> product_grid([np.array([1.0, 2.0]), np.array([5.0])]).tolist()
    [[1.0, 5.0], [2.0, 5.0]]
    """
    if not axes:
        return np.zeros((1, 0))
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
