"""Masses that gravity pulls at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked

__all__ = ["PointMass"]


@dataclass(frozen=True, slots=True)
class PointMass:
    """A mass, kg; its centre (3,), m, is fixed in the frame where the Denavit-Hartenberg row of joint `after` ends."""

    name: str
    after: str
    mass: float
    center: NDArray[np.float64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", locked(self.center, shape=(3,), name="center"))
