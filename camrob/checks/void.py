"""Postures on the way of a motion that runs straight in the joints (PTP)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["interpolate_void"]

Array = NDArray[np.float64]


def interpolate_void(q0: ArrayLike, q1: ArrayLike, step: float) -> Array:
    """Postures (K, n) from q0 to q1 (n,), both included, no joint moving by more than `step` (rad or m) between two.

    Raises ValueError where step is not above 0 or the postures are not finite.
    """
    start, stop = np.asarray(q0, float), np.asarray(q1, float)
    if not step > 0.0 or not np.all(np.isfinite(start)) or not np.all(np.isfinite(stop)):
        raise ValueError("interpolate_void needs finite postures and a step above 0")
    pieces = max(1, int(np.ceil(np.max(np.abs(stop - start), initial=0.0) / step - 1e-9)))
    part = np.linspace(0.0, 1.0, pieces + 1)[:, None]
    return np.asarray((1.0 - part) * start + part * stop)
