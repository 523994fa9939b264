"""Signals over time: runs without holes, derivatives, filters, the play of a gear."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from camrob.compiled import kernel

__all__ = ["delayed", "derivative", "first_order", "pieces_of", "play", "play_at_rest", "robust_sigma"]

Array = NDArray[np.float64]

_FINE = 5  # steps that a sample is cut into where samples are too coarse
_HOLE = 5.0  # times the ordinary step: more is a hole in time


def pieces_of(t: Array) -> tuple[slice, ...]:
    """Runs of samples without a hole in time."""
    step = np.diff(t)
    if len(step) == 0:
        return (slice(0, len(t)),)
    cuts = np.flatnonzero(step > _HOLE * np.median(step)) + 1
    edges = [0, *cuts.tolist(), len(t)]
    return tuple(slice(a, b) for a, b in pairwise(edges))


def derivative(values: Array, t: Array, pieces: tuple[slice, ...], order: int = 1) -> Array:
    """Time derivative of (N, k) of a cubic spline through each run; 0 where a run has too few samples."""
    out = np.zeros_like(values)
    for run in pieces:
        if run.stop - run.start > 3:
            out[run] = CubicSpline(t[run], values[run], axis=0)(t[run], order)
    return out


def first_order(
    values: Array,
    t: Array,
    pieces: tuple[slice, ...],
    tau: float,
    cycle: float = 0.0,
    known: Array | None = None,
) -> Array:
    """(N, k) behind a first-order lag of `tau` seconds.

    cycle: 0 for a continuous filter (exact for straight stretches between splined samples), else the drive's own cycle, s:
    y += (cycle / tau) (u - y) once a cycle. Each run starts where the filter stands by `known` (N, k), or else in the steady
    state of its first slope.
    """
    if tau <= cycle or tau <= 0.0:
        return values.copy()
    out = np.empty_like(values)
    for run in pieces:
        u, own = values[run], t[run]
        if len(u) < 4:
            out[run] = u
            continue
        step = cycle if cycle > 0.0 else float(np.median(np.diff(own))) / _FINE
        fine = np.arange(own[0], own[-1] + step, step)
        dense = CubicSpline(own, u, axis=0)(np.minimum(fine, own[-1]))
        slope = (dense[1] - dense[0]) / step
        begin = u[0] - (tau - cycle) * slope if known is None else known[run.start]
        late = _lag(np.ascontiguousarray(dense), np.ascontiguousarray(begin), step, tau, cycle > 0.0)
        for k in range(u.shape[1]):
            out[run, k] = np.interp(own, fine, late[:, k])
    return out


@kernel
def _lag(u: Array, begin: Array, h: float, tau: float, cyclic: bool) -> Array:
    out = np.empty_like(u)
    count, width = u.shape
    share = h / tau if cyclic else np.exp(-h / tau)
    for k in range(width):
        out[0, k] = begin[k]
        behind = begin[k] - u[0, k]
        for i in range(1, count):
            if cyclic:
                out[i, k] = out[i - 1, k] + share * (u[i, k] - out[i - 1, k])
            else:
                slope = (u[i, k] - u[i - 1, k]) / h
                behind = -tau * slope + (behind + tau * slope) * share
                out[i, k] = u[i, k] + behind
    return out


def delayed(values: Array, t: Array, pieces: tuple[slice, ...], delay: float) -> Array:
    """(N, k) as they were `delay` seconds before, by a spline through each run, continued straight at its ends."""
    out = values.copy()
    for run in pieces:
        own = t[run]
        if len(own) < 4:
            continue
        spline = CubicSpline(own, values[run], axis=0)
        at = own - delay
        inside = np.clip(at, own[0], own[-1])
        out[run] = spline(inside) + spline(inside, 1) * (at - inside)[:, None]
    return out


def play(values: Array, t: Array, pieces: tuple[slice, ...], width: float) -> Array:
    """State (N,) in [-1, 1] of a gear's play: the link lags its encoder by width / 2 times the state.

    The play operator, run on a spline through the samples, as reversals lie between them: the link rests until the play
    is taken up. A run starts on the side that it first moves to.
    """
    out = np.zeros(len(values))
    for run in pieces:
        u, own = values[run], t[run]
        if len(u) < 4:
            continue
        fine = np.interp(np.arange((len(u) - 1) * _FINE + 1) / _FINE, np.arange(len(u)), own)
        dense = CubicSpline(own, u)(fine)
        out[run] = _play(np.ascontiguousarray(dense), max(width, 1e-12))[::_FINE]
    return out


@kernel
def _play(u: Array, width: float) -> Array:
    half = 0.5 * width
    first = 0.0
    for i in range(1, len(u)):
        if abs(u[i] - u[0]) > half:
            first = 1.0 if u[i] > u[0] else -1.0
            break
    link = u[0] - first * half
    out = np.empty(len(u))
    for i in range(len(u)):
        link = min(max(link, u[i] - half), u[i] + half)
        out[i] = (u[i] - link) / half
    return out


def play_at_rest(values: Array, width: float) -> Array:
    """State (N,) in [-1, 1] of a gear's play at single poses, taken in order, the way between two of them straight."""
    return np.asarray(_play(np.ascontiguousarray(values), max(width, 1e-12)))


def robust_sigma(values: Array, pieces: tuple[slice, ...]) -> Array:
    """(k,) noise of (N, k) from second differences, whose smooth part cancels; 0 for runs too short."""
    parts = [np.diff(values[run], 2, axis=0) for run in pieces if run.stop - run.start > 4]
    if not parts:
        return np.zeros(values.shape[1])
    return np.asarray(np.median(np.abs(np.concatenate(parts)), axis=0) / (0.6745 * np.sqrt(6.0)))
