"""Smoothing splines of many columns at once, as stiff as the resolution of the data admits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["smooth_curves"]

Array = NDArray[np.float64]

_FOURTH = np.array([1.0, -4.0, 6.0, -4.0, 1.0])  # fourth difference: binomials of alternating sign
_LOOSEST, _STIFFEST, _HALVINGS = -3.0, 12.0, 20  # looser ones swing beside a corner
_PER_POINT, _FEWEST = 1, 32  # spans for each point: finer ones bear no more than the points tell


def smooth_curves(known: Array, values: Array, parts: int, resolution: float) -> list[Array]:
    """Values and three derivatives, each (parts + 1, D), of splines near `values` (N, D) at rising places `known` (N,).

    The curves are sampled at `parts` + 1 even places. They are cubic B-splines on even spans, each column with the
    greatest weight on its fourth differences that leaves a root mean square distance to the data of at most the standard
    deviation of rounding, resolution / sqrt(12) (Morozov's principle); what is rougher than that allows is followed as
    closely as the spans can. Where neighbours are farther apart than a span, as in travel, the way between them counts
    as straight. Linear in N and parts.
    """
    length = float(known[-1] - known[0])
    spans = min(parts, max(_PER_POINT * len(known), _FEWEST))
    h = length / spans
    known, values = _filled(known, values, h)
    place = (known - known[0]) / h
    span = np.clip(place.astype(np.int64), 0, spans - 1)
    basis = _basis(place - span)
    n = spans + 3
    data = np.zeros((5, n))
    right = np.zeros((n, values.shape[1]))
    for a in range(4):
        np.add.at(right, span + a, basis[:, a, None] * values)
        for b in range(a, 4):
            np.add.at(data[b - a], span + a, basis[:, a] * basis[:, b])
    stiff = np.zeros((5, n))
    for a in range(5):
        for b in range(a, 5):
            stiff[b - a, a : n - 4 + a] += _FOURTH[a] * _FOURTH[b]
    room = resolution / np.sqrt(12.0)
    control = np.empty((n, values.shape[1]))
    for d in range(values.shape[1]):
        low, high = _LOOSEST, _STIFFEST
        for _ in range(_HALVINGS):
            power = 0.5 * (low + high)
            c = _fit(data, stiff, 10.0**power, right[:, d])
            left = values[:, d] - np.einsum("na,na->n", basis, c[span[:, None] + np.arange(4)])
            if np.sqrt(np.mean(left**2)) <= room:
                low = power
            else:
                high = power
        control[:, d] = _fit(data, stiff, 10.0**low, right[:, d])
    from scipy.interpolate import BSpline

    knots = known[0] + h * np.arange(-3, spans + 4)
    curve = BSpline(knots, control, 3)
    grid = np.linspace(known[0], known[-1], parts + 1)
    return [np.asarray(curve(grid, nu=order)) for order in range(4)]


def _filled(known: Array, values: Array, h: float) -> tuple[Array, Array]:
    """Places and values with points put in evenly where neighbours are more than `h` apart: an empty span tells nothing."""
    more = np.floor(np.diff(known) / h * (1.0 + 1e-9)).astype(np.int64)
    if not np.any(more > 1):
        return known, values
    parts = np.maximum(more, 1)
    begins = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(begins)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[begins]
    places = np.append(known[begins] + share * np.diff(known)[begins], known[-1])
    between = values[begins] + share[:, None] * np.diff(values, axis=0)[begins]
    return places, np.vstack([between, values[-1:]])


def _fit(data: Array, stiff: Array, weight: float, right: Array) -> Array:
    """Control values of the normal equations, a matrix of nine diagonals; a trace of stiffness fills empty spans."""
    from scipy.linalg import solveh_banded

    band = data + weight * stiff
    band[0] += 1e-14
    lower = np.zeros_like(band)
    for k in range(5):
        lower[k, : band.shape[1] - k] = band[k, : band.shape[1] - k]
    return np.asarray(solveh_banded(lower, right, lower=True, check_finite=False))


def _basis(w: Array) -> Array:
    """The four cubic B-splines (N, 4) at shares w (N,) of a span."""
    return np.stack([(1 - w) ** 3, 3 * w**3 - 6 * w**2 + 4, -3 * w**3 + 3 * w**2 + 3 * w + 1, w**3], axis=1) / 6.0
