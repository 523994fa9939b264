"""The derivative analysis of a path in machine space: may compensation make an axis hurry?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked

__all__ = ["DerivativeAnalysis", "analyse_derivatives"]

Array = NDArray[np.float64]

SAMPLES = 2900  # of the paper


@dataclass(frozen=True, slots=True)
class DerivativeAnalysis:
    """s (K,): total displacement of the axes. first, second, third (K, n): derivatives of the axes by s.

    allowed (K, 3): the largest ds/dt that speeds (eq. 21), accelerations (eq. 27) and jerks (eq. 28) of the axes allow.
    """

    s: Array
    q: Array
    first: Array
    second: Array
    third: Array
    allowed: Array

    def __post_init__(self) -> None:
        for name in ("s", "q", "first", "second", "third", "allowed"):
            object.__setattr__(self, name, locked(getattr(self, name), name=name))

    @property
    def slowest(self) -> tuple[float, float, float]:
        """The least ds/dt that each of the three limits allows anywhere."""
        least = np.min(self.allowed, axis=0)
        return float(least[0]), float(least[1]), float(least[2])


def analyse_derivatives(
    q: Array, speed: Array, acceleration: Array, jerk: Array, *, samples: int = SAMPLES
) -> DerivativeAnalysis:
    """Derivatives of a path q (N, n) by its length in machine space, and what they allow (section III, eq. 10 to 28).

    As in the paper: the length is divided evenly, the axes are interpolated linearly (eq. 10), and derivatives are
    central differences. The paper prints first derivatives in eq. 22 to 23 as well; what limits the feed are eq. 20,
    24 and 26. speed, acceleration, jerk (n,): the axes' limits, inf where there is none. Raises ValueError for a path
    that stands still.
    """
    q = np.asarray(q, float)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1))])
    if not length[-1] > 0.0:
        raise ValueError("the path stands still")
    s = np.linspace(0.0, length[-1], samples)
    moving = np.concatenate([[True], np.diff(length) > 0.0])
    even = np.stack([np.interp(s, length[moving], q[moving, i]) for i in range(q.shape[1])], axis=1)
    first = np.gradient(even, s, axis=0)
    second = np.gradient(first, s, axis=0)
    third = np.gradient(second, s, axis=0)
    allowed = np.full((samples, 3), np.inf)
    for k, (derivative, limit) in enumerate(((first, speed), (second, acceleration), (third, jerk))):
        share = np.max(np.abs(derivative) / limit, axis=1)
        with np.errstate(divide="ignore"):
            allowed[:, k] = (1.0 / share) ** (1.0 / (k + 1))
    return DerivativeAnalysis(s, even, first, second, third, allowed)
