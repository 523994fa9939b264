"""What closed-form inverses of arms are made of: rotations about axes, and the two angles of a cone (Paden and Kahan)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import inlined

__all__ = ["cone", "dot", "nearest_turn", "rotate", "triple", "turn_between"]

Array = NDArray[np.float64]

_REACH_SLACK = 1e-12  # rounding allowed to put a cosine beyond 1


@inlined
def rotate(h: Array, c: float, s: float, x: Array, out: Array) -> None:
    """out <- rotation of x about the unit axis h by the angle of cosine c and sine s."""
    k = (h[0] * x[0] + h[1] * x[1] + h[2] * x[2]) * (1.0 - c)
    out0 = c * x[0] + s * (h[1] * x[2] - h[2] * x[1]) + k * h[0]
    out1 = c * x[1] + s * (h[2] * x[0] - h[0] * x[2]) + k * h[1]
    out[2] = c * x[2] + s * (h[0] * x[1] - h[1] * x[0]) + k * h[2]
    out[0] = out0
    out[1] = out1


@inlined
def dot(a: Array, b: Array) -> float:
    """a . b."""
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@inlined
def triple(h: Array, x: Array, y: Array) -> float:
    """h . (x x y)."""
    return float(
        h[0] * (x[1] * y[2] - x[2] * y[1]) + h[1] * (x[2] * y[0] - x[0] * y[2]) + h[2] * (x[0] * y[1] - x[1] * y[0])
    )


@inlined
def cone(a: float, b: float, c: float, out: Array) -> bool:
    """The two angles with a cos + b sin = c into out; False where there is none."""
    r = np.sqrt(a * a + b * b)
    if r == 0.0 or abs(c) > r * (1.0 + _REACH_SLACK):
        return False
    base = np.arctan2(b, a)
    half = np.arccos(min(1.0, max(-1.0, c / r)))
    out[0] = base + half
    out[1] = base - half
    return True


@inlined
def turn_between(h: Array, x: Array, y: Array) -> float:
    """The angle about h that takes x's direction across h to y's."""
    hx, hy = dot(h, x), dot(h, y)
    return float(np.arctan2(triple(h, x, y), dot(x, y) - hx * hy))


@inlined
def nearest_turn(angle: float, near: float) -> float:
    """The angle plus whole turns that lies nearest to `near`."""
    return float(angle + 2.0 * np.pi * np.round((near - angle) / (2.0 * np.pi)))
