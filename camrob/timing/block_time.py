"""The time that a controller takes for one motion at the least: motions that are shorter are run slower than programmed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.timing.straight_pieces import PathRates
from camrob.units import ms_to_s

__all__ = ["BLOCK_TIME", "block_ceilings", "motion_lengths"]

Array = NDArray[np.float64]

BLOCK_TIME = "block time"
"""What holds the tool back where motions are shorter than the controller takes for one."""


def block_ceilings(cell: Cell, rates: PathRates, motion_ends: NDArray[np.bool_] | None = None) -> Array:
    """Speeds (M,) of the pieces, m/s (`PathRates.length` a second), at which no motion takes less than the cell's `block_ms`.

    motion_ends: (N,) True at the points where a motion of the program ends, by default everywhere. Infinite where the cell says
    nothing.
    """
    block = ms_to_s(cell.controller.block_ms)
    if block <= 0.0:
        return np.full(len(rates.length), np.inf)
    return motion_lengths(rates, motion_ends) / block


def motion_lengths(rates: PathRates, motion_ends: NDArray[np.bool_] | None = None) -> Array:
    """(M,) m: the whole length of the motion that each piece belongs to."""
    if motion_ends is None:
        return np.array(rates.length)
    motion = np.searchsorted(np.flatnonzero(motion_ends), rates.end)
    return np.asarray(np.bincount(motion, rates.length, minlength=1)[motion])
