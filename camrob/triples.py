"""Products of three components each, for compiled code, of arrays and tuples alike.

NumPy's own, and sums and slices of arrays, are compiled as whole loops with errors of their own to word: a second each, where
these take a tenth of that.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import bare

__all__ = ["Three", "between", "copy3", "cross", "dot", "gap2"]

Three = tuple[float, float, float] | NDArray[np.float64]


@bare
def dot(a: Three, b: Three) -> float:
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@bare
def cross(a: Three, b: Three) -> tuple[float, float, float]:
    """a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@bare
def between(a: Three, b: Three) -> tuple[float, float, float]:
    """b - a."""
    return b[0] - a[0], b[1] - a[1], b[2] - a[2]


@bare
def gap2(a: Three, b: Three) -> float:
    """|b - a|^2."""
    return (b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]) + (b[2] - a[2]) * (b[2] - a[2])


@bare
def copy3(source: Three, out: NDArray[np.float64]) -> None:
    """out <- source."""
    out[0], out[1], out[2] = source[0], source[1], source[2]
