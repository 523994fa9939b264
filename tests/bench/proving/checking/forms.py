"""Affine forms of many boxes at once, arrays (.., 7): the middle, what five symbols of [-1, 1] change it by, and what is left."""

from __future__ import annotations

import numpy as np

LEFT = 6  # where the remainder stands
PAD = 1e-9  # by which bounds are lowered for rounding


def constant(c):
    out = np.zeros((*np.shape(c), 7))
    out[..., 0] = c
    return out


def spread(x):
    return np.abs(x[..., 1:]).sum(-1)


def scaled(x, k):
    out = x * np.asarray(k)[..., None]
    out[..., LEFT] = np.abs(out[..., LEFT])
    return out


def shifted(x, k):
    out = x.copy()
    out[..., 0] += k
    return out


def plus(x, y):
    return x + y


def minus(x, y):
    return plus(x, scaled(y, -1.0))


def times(x, y):
    q = x[..., 1:LEFT, None] * y[..., None, 1:LEFT]
    q = 0.5 * (q + np.swapaxes(q, -1, -2))
    own = np.einsum("...ii->...i", q)
    out = x[..., :1] * y + y[..., :1] * x
    out[..., 0] = x[..., 0] * y[..., 0] + 0.5 * own.sum(-1)
    left = np.abs(q).sum((-1, -2)) - 0.5 * np.abs(own).sum(-1)
    a, b = np.abs(x[..., :LEFT]).sum(-1), np.abs(y[..., :LEFT]).sum(-1)
    out[..., LEFT] = left + a * y[..., LEFT] + b * x[..., LEFT] + x[..., LEFT] * y[..., LEFT]
    return out


def dot(a, b):
    return sum((times(x, y) for x, y in zip(a[1:], b[1:], strict=True)), times(a[0], b[0]))


def cross(a, b):
    return [minus(times(a[i - 2], b[i - 1]), times(a[i - 1], b[i - 2])) for i in range(3)]


def curved(x, f, slope, low, high, bulge):
    """f(x) between low and high, f above (bulge < 0) or below its chord: the chord, shifted by half of what f is off by at most.

    slope: where f is as steep as its chord.
    """
    steep = (f(high) - f(low)) / np.where(high > low, high - low, 1.0)
    steep = np.where(high > low, steep, 0.0)
    at = np.clip(slope(np.where(steep == 0.0, 1.0, steep)), low, high)
    off = 0.5 * np.abs(f(low) + steep * (at - low) - f(at))
    out = scaled(x, steep)
    out[..., 0] += f(low) - steep * low - bulge * off
    out[..., LEFT] += off + 1e-14 * np.abs(f(low))
    return out


def root(x, low, high):
    return curved(x, np.sqrt, lambda s: 0.25 / (s * s), low, high, -1.0)


def inverse(x, low, high):
    return curved(x, lambda v: 1.0 / v, lambda s: 1.0 / np.sqrt(np.maximum(-s, 1e-300)), low, high, 1.0)


def bounds(x):
    return x[..., 0] - spread(x), x[..., 0] + spread(x)


def turned(x):
    """Cosine and sine of an angle's form."""
    c, s, r = np.cos(x[..., 0]), np.sin(x[..., 0]), spread(x)
    one, two = scaled(x, -s), scaled(x, c)
    one[..., 0], two[..., 0] = c * (1.0 - 0.25 * r * r), s * (1.0 - 0.25 * r * r)
    one[..., LEFT] += np.abs(c) * 0.25 * r * r + r**3 / 6.0
    two[..., LEFT] += np.abs(s) * 0.25 * r * r + r**3 / 6.0
    return one, two
