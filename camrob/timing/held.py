"""Speeds that the controller's own ramps keep to the limits: what is written, run by the model, and lowered where it isn't held.

A plan's smooth dips can't be written: a program has one speed a motion, and the controller ramps between them with all the
acceleration it has. So the written speeds are run by the model, laid on the smooth curve and lowered where a limit is passed,
until none is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.redundancy.path import ToolPathInBase
from camrob.timing.as_it_stands import ramped_squares, span_uses
from camrob.timing.block_time import block_ceilings
from camrob.timing.smooth_runs import SmoothRun, least_between, piece_feeds, run_bounds, run_pieces, smooth_run
from camrob.timing.straight_pieces import path_rates
from camrob.timing.timing import exact_stops, program_time

__all__ = ["held_speeds"]

Array = NDArray[np.float64]

_ROUNDS = 12  # of slowing where a limit is passed: an end for a stretch that does not settle
_OVER = 1.0 + 1e-6  # a use of 1 is the limit itself; what lies beyond by rounding is none
_HARDEST = 0.7  # of a speed is the least that one round leaves of it
_SLOWEST = 1e-3  # m/s: what is passed below it is the ramp's own, which no lower speed would remove
_STAIR = 1.02  # lowered speeds are powers of it, so that neighbours share one
_PRINTED = 1e-5  # m/s


def held_speeds(
    cell: Cell,
    path: ToolPathInBase,
    q: Array,
    speed: Array,
    programmed: Array,
    motion_ends: NDArray[np.bool_] | None = None,
) -> Array:
    """Speeds (N,), m/s, no higher than `speed`, at which the model of the controller runs the cutting within all limits.

    q: (N, n) postures. programmed: (N,) m/s of the CL file, which the curve is smoothed for, as the plan's is. Lowered are
    only the moves on which, in the model, a limit on speed, acceleration or jerk is passed; few places may be left after
    the last round (`program_as_it_stands` says which). motion_ends: (N,) True where a
    motion of the program ends, by default everywhere. Raises ValueError for arrays that don't fit. Cost: linear.
    """
    rates = path_rates(cell, path, q)
    bounds, bounded = run_bounds(rates)
    out = np.array(speed, dtype=np.float64)
    meant = piece_feeds(rates, programmed)
    runs = [smooth_run(rates, k, bounded, meant[k]) for k in run_pieces(rates, path, exact_stops(path))]
    block = block_ceilings(cell, rates, motion_ends)
    for _ in range(_ROUNDS):
        timing = program_time(cell, path, q, speed=out, motion_ends=motion_ends)
        feed = np.minimum(piece_feeds(rates, out), block)
        still = []
        for run in runs:
            square, _knots = ramped_squares(rates, run, timing.speed, feed)
            ends = rates.end[run.pieces]
            most = np.minimum(out[ends], _held(run, square, span_uses(run, square, bounds)[0]))
            if np.any(most < out[ends]):
                out[ends] = most
                still.append(run)
        if not still:
            break
        runs = still  # a run lies between exact stops, so that no other one's speeds reach it
    return out


def _held(run: SmoothRun, square: Array, use: Array) -> Array:
    """Speed (P,) of a run's pieces at which what its spans take, `use` (K, 3), would be within the limits."""
    share = 1.0 / np.maximum(np.maximum(use[:, 0], np.sqrt(use[:, 1])), np.maximum(np.cbrt(use[:, 2]), 1e-9))
    most = np.sqrt(np.maximum(square[1:], square[:-1])) * np.clip(share, _HARDEST, 1.0)
    stairs = _STAIR ** np.floor(np.log(np.maximum(most, _SLOWEST)) / np.log(_STAIR))
    printed = np.floor(np.maximum(stairs, _SLOWEST) / _PRINTED) * _PRINTED
    return least_between(np.where(use.max(axis=1) > _OVER, printed, np.inf), run.first, run.last)
