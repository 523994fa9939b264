"""Affine forms: enclosures of what depends on a few symbols, compiled, rounding counted in.

A form (c, a0, .., a4, e) holds every value c + a0 s0 + .. + a4 s4 + d with symbols s of [-1, 1] and |d| <= e (Comba and Stolfi's
affine arithmetic). What a function bends away from its linear part goes into e, so that a form of a box of half the size is
four times nearer to the function. Rounding: every step is off by half a unit in the last
place of what it adds or multiplies at most, and SLACK times the sizes that went into an operation covers all of its steps.
Square roots are rounded correctly (IEEE 754); sines and cosines of the library are trusted to a few units in the last place.
"""

from __future__ import annotations

import numpy as np

from camrob.compiled import bare, part

__all__ = [
    "Form",
    "cosine_sine",
    "highest",
    "inverse",
    "lowest",
    "minus",
    "mixed",
    "plus",
    "root",
    "scaled",
    "shifted",
    "spread",
    "square",
    "times",
]

Form = tuple[float, float, float, float, float, float, float]

SLACK = 5e-15  # 45 units of 2^-53: the sums of remainders have 30 terms at most, each other step a few


@bare
def spread(x: Form) -> float:
    """How far the values lie from the middle at most."""
    return abs(x[1]) + abs(x[2]) + abs(x[3]) + abs(x[4]) + abs(x[5]) + x[6]


@bare
def lowest(x: Form) -> float:
    """No value is lower."""
    r = spread(x)
    return float(x[0] - r - SLACK * (abs(x[0]) + r))


@bare
def highest(x: Form) -> float:
    """No value is higher."""
    r = spread(x)
    return float(x[0] + r + SLACK * (abs(x[0]) + r))


@bare
def plus(x: Form, y: Form) -> Form:
    """x + y."""
    e = x[6] + y[6] + SLACK * (abs(x[0]) + spread(x) + abs(y[0]) + spread(y))
    return x[0] + y[0], x[1] + y[1], x[2] + y[2], x[3] + y[3], x[4] + y[4], x[5] + y[5], e


@bare
def minus(x: Form, y: Form) -> Form:
    """x - y."""
    e = x[6] + y[6] + SLACK * (abs(x[0]) + spread(x) + abs(y[0]) + spread(y))
    return x[0] - y[0], x[1] - y[1], x[2] - y[2], x[3] - y[3], x[4] - y[4], x[5] - y[5], e


@bare
def shifted(x: Form, k: float) -> Form:
    """x + k."""
    return x[0] + k, x[1], x[2], x[3], x[4], x[5], x[6] + SLACK * (abs(x[0]) + spread(x) + abs(k))


@bare
def scaled(x: Form, k: float) -> Form:
    """k x."""
    e = abs(k) * x[6] + SLACK * abs(k) * (abs(x[0]) + spread(x))
    return k * x[0], k * x[1], k * x[2], k * x[3], k * x[4], k * x[5], e


@bare
def mixed(a: float, x: Form, b: float, y: Form, c: float, z: Form, k: float) -> Form:
    """a x + b y + c z + k."""
    size = (
        abs(a) * (abs(x[0]) + spread(x)) + abs(b) * (abs(y[0]) + spread(y)) + abs(c) * (abs(z[0]) + spread(z)) + abs(k)
    )
    return (
        a * x[0] + b * y[0] + c * z[0] + k,
        a * x[1] + b * y[1] + c * z[1],
        a * x[2] + b * y[2] + c * z[2],
        a * x[3] + b * y[3] + c * z[3],
        a * x[4] + b * y[4] + c * z[4],
        a * x[5] + b * y[5] + c * z[5],
        abs(a) * x[6] + abs(b) * y[6] + abs(c) * z[6] + SLACK * size,
    )


@part
def times(x: Form, y: Form) -> Form:
    """x y: squares of a symbol lie in [0, 1], products of two in [-1, 1]."""
    a, x0, x1, x2, x3, x4, ex = x
    b, y0, y1, y2, y3, y4, ey = y
    d0, d1, d2, d3, d4 = x0 * y0, x1 * y1, x2 * y2, x3 * y3, x4 * y4
    cross = abs(x0 * y1 + x1 * y0) + abs(x0 * y2 + x2 * y0) + abs(x0 * y3 + x3 * y0) + abs(x0 * y4 + x4 * y0)
    cross += abs(x1 * y2 + x2 * y1) + abs(x1 * y3 + x3 * y1) + abs(x1 * y4 + x4 * y1)
    cross += abs(x2 * y3 + x3 * y2) + abs(x2 * y4 + x4 * y2) + abs(x3 * y4 + x4 * y3)
    rx = abs(a) + abs(x0) + abs(x1) + abs(x2) + abs(x3) + abs(x4)
    ry = abs(b) + abs(y0) + abs(y1) + abs(y2) + abs(y3) + abs(y4)
    e = cross + 0.5 * (abs(d0) + abs(d1) + abs(d2) + abs(d3) + abs(d4))
    e += rx * ey + ry * ex + ex * ey + SLACK * (rx + ex) * (ry + ey)
    return (
        a * b + 0.5 * (d0 + d1 + d2 + d3 + d4),
        a * y0 + b * x0,
        a * y1 + b * x1,
        a * y2 + b * x2,
        a * y3 + b * x3,
        a * y4 + b * x4,
        e,
    )


@part
def square(x: Form) -> Form:
    """x x."""
    whole: Form = times(x, x)
    return whole


@bare
def _line(x: Form, slope: float, middle: float, off: float) -> Form:
    """slope x + middle, off by `off` at most."""
    e = abs(slope) * x[6] + off + SLACK * (abs(slope) * (abs(x[0]) + spread(x)) + abs(middle) + off)
    return slope * x[0] + middle, slope * x[1], slope * x[2], slope * x[3], slope * x[4], slope * x[5], e


@part
def inverse(x: Form, low: float, high: float) -> Form:
    """1 / x for values in [low, high], low > 0: the line that is off as much at both ends as between them."""
    ends, between = 1.0 / low + 1.0 / high, 2.0 / np.sqrt(low * high)
    whole: Form = _line(x, -1.0 / (low * high), 0.5 * (ends + between), 0.5 * (ends - between) + SLACK * ends)
    return whole


@part
def root(x: Form, low: float, high: float) -> Form:
    """The square root of x for values in [low, high], low >= 0."""
    a, b = np.sqrt(low), np.sqrt(high)
    total = a + b
    ends, between = a * b / total, 0.25 * total
    whole: Form = _line(x, 1.0 / total, 0.5 * (ends + between), 0.5 * (between - ends) + SLACK * total)
    return whole


@part
def cosine_sine(x: Form) -> tuple[Form, Form]:
    """Cosine and sine of an angle."""
    c, s = np.cos(x[0]), np.sin(x[0])
    r = spread(x)
    slack = SLACK * (1.0 + abs(x[0]))
    if r > 1.5:
        return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    flat = 0.25 * r * r  # 1 - cos lies in [0, r^2 / 2]
    bent = r * r * r / 6.0 + x[6]  # |sin x - x|
    k = 1.0 - flat
    ec, es = abs(c) * flat + abs(s) * bent + slack, abs(s) * flat + abs(c) * bent + slack
    return (
        (c * k, -s * x[1], -s * x[2], -s * x[3], -s * x[4], -s * x[5], ec),
        (s * k, c * x[1], c * x[2], c * x[3], c * x[4], c * x[5], es),
    )
