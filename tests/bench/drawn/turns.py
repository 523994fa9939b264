"""Turns about the axes of a frame."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = ["about"]


def about(axis: int, angle: float) -> NDArray[np.float64]:
    """(3, 3): right-handed about X (0), Y (1) or Z (2), rad."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[j, j] = turn[k, k] = math.cos(angle)
    turn[k, j], turn[j, k] = math.sin(angle), -math.sin(angle)
    return turn
