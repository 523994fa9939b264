"""A frame carried along a chain, step by step, for compiled code: the one place where a joint turns or shifts it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import bare

__all__ = ["compose", "move_joint"]

Array = NDArray[np.float64]


@bare
def compose(R: Array, p: Array, fixed: Array) -> None:
    """R, p <- (R, p) * fixed, in place."""
    for r in range(3):
        a, b, c = R[r, 0], R[r, 1], R[r, 2]
        p[r] += a * fixed[0, 3] + b * fixed[1, 3] + c * fixed[2, 3]
        R[r, 0] = a * fixed[0, 0] + b * fixed[1, 0] + c * fixed[2, 0]
        R[r, 1] = a * fixed[0, 1] + b * fixed[1, 1] + c * fixed[2, 1]
        R[r, 2] = a * fixed[0, 2] + b * fixed[1, 2] + c * fixed[2, 2]


@bare
def move_joint(R: Array, p: Array, prismatic: bool, q: float) -> None:
    """R, p <- (R, p) moved by a joint along or about its z, in place."""
    if prismatic:
        for r in range(3):
            p[r] += R[r, 2] * q
    else:
        co, si = np.cos(q), np.sin(q)
        for r in range(3):
            a, b = R[r, 0], R[r, 1]
            R[r, 0] = a * co + b * si
            R[r, 1] = b * co - a * si
