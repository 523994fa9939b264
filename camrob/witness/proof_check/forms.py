"""Affine forms of many boxes at once, arrays (.., 7): the middle, what five symbols of [-1, 1] change it by, and what is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "LEFT",
    "PAD",
    "bounds",
    "constant",
    "cross",
    "curved",
    "dot",
    "inverse",
    "minus",
    "plus",
    "root",
    "scaled",
    "shifted",
    "spread",
    "times",
    "turned",
]

Array = NDArray[np.float64]
Vector = Sequence[Array]

LEFT = 6
"""Where the remainder stands."""
PAD = 1e-9
"""By which bounds are lowered for rounding."""
_TINY, _EPS = 1e-300, 1e-14  # a divisor at least; of a chord's rounding


def constant(c: Array) -> Array:
    """Forms of plain numbers."""
    out = np.zeros((*np.shape(c), 7))
    out[..., 0] = c
    return out


def spread(x: Array) -> Array:
    """How far a form goes from its middle."""
    return np.asarray(np.abs(x[..., 1:]).sum(-1))


def scaled(x: Array, k: Array | float) -> Array:
    """k times x."""
    out: Array = x * np.asarray(k)[..., None]
    out[..., LEFT] = np.abs(out[..., LEFT])
    return out


def shifted(x: Array, k: Array | float) -> Array:
    """x and k."""
    out: Array = x.copy()
    out[..., 0] += k
    return out


def plus(x: Array, y: Array) -> Array:
    """Their sum."""
    return x + y


def minus(x: Array, y: Array) -> Array:
    """Their difference."""
    return plus(x, scaled(y, -1.0))


def times(x: Array, y: Array) -> Array:
    """Their product."""
    q = x[..., 1:LEFT, None] * y[..., None, 1:LEFT]
    q = 0.5 * (q + np.swapaxes(q, -1, -2))
    own = np.einsum("...ii->...i", q)
    out = x[..., :1] * y + y[..., :1] * x
    out[..., 0] = x[..., 0] * y[..., 0] + 0.5 * own.sum(-1)
    left = np.abs(q).sum((-1, -2)) - 0.5 * np.abs(own).sum(-1)
    a, b = np.abs(x[..., :LEFT]).sum(-1), np.abs(y[..., :LEFT]).sum(-1)
    out[..., LEFT] = left + a * y[..., LEFT] + b * x[..., LEFT] + x[..., LEFT] * y[..., LEFT]
    return out


def dot(a: Vector, b: Vector) -> Array:
    """Of two vectors."""
    return sum((times(x, y) for x, y in zip(a[1:], b[1:], strict=True)), start=times(a[0], b[0]))


def cross(a: Vector, b: Vector) -> list[Array]:
    """Of two vectors."""
    return [minus(times(a[i - 2], b[i - 1]), times(a[i - 1], b[i - 2])) for i in range(3)]


def curved(
    x: Array, f: Callable[[Array], Array], slope: Callable[[Array], Array], low: Array, high: Array, bulge: float
) -> Array:
    """f(x) between low and high, f above (bulge < 0) or below its chord: the chord, shifted by half of what f is off by at most.

    slope: where f is as steep as its chord.
    """
    steep = (f(high) - f(low)) / np.where(high > low, high - low, 1.0)
    steep = np.where(high > low, steep, 0.0)
    at = np.clip(slope(np.where(steep == 0.0, 1.0, steep)), low, high)
    off = 0.5 * np.abs(f(low) + steep * (at - low) - f(at))
    out = scaled(x, steep)
    out[..., 0] += f(low) - steep * low - bulge * off
    out[..., LEFT] += off + _EPS * np.abs(f(low))
    return out


def root(x: Array, low: Array, high: Array) -> Array:
    """Its square root, between low and high."""
    return curved(x, np.sqrt, lambda s: 0.25 / (s * s), low, high, -1.0)


def inverse(x: Array, low: Array, high: Array) -> Array:
    """One over it, between low and high."""
    return curved(x, lambda v: 1.0 / v, lambda s: 1.0 / np.sqrt(np.maximum(-s, _TINY)), low, high, 1.0)


def bounds(x: Array) -> tuple[Array, Array]:
    """The lowest and the highest."""
    return x[..., 0] - spread(x), x[..., 0] + spread(x)


def turned(x: Array) -> tuple[Array, Array]:
    """Cosine and sine of an angle's form."""
    c, s, r = np.cos(x[..., 0]), np.sin(x[..., 0]), spread(x)
    one, two = scaled(x, -s), scaled(x, c)
    one[..., 0], two[..., 0] = c * (1.0 - 0.25 * r * r), s * (1.0 - 0.25 * r * r)
    one[..., LEFT] += np.abs(c) * 0.25 * r * r + r**3 / 6.0
    two[..., LEFT] += np.abs(s) * 0.25 * r * r + r**3 / 6.0
    return one, two
