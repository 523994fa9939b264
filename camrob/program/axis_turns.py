"""Which turns of the axes a PTP to a pose means: the ways in which languages count them.

Beside it stands the branch of the arm (`status`), three bits: 1 the wrist's centre lies behind axis 1, 2 A3 is past the value at
which the arm is stretched, 4 A5 is negative.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camrob.cell.status_turn import StatusTurn
from camrob.program.motion import Turning

__all__ = ["QUARTERED", "quarters_of", "turn_fits", "turn_of", "turn_text"]

Array = NDArray[np.float64]

QUARTERED = (0, 3, 5)
"""The axes whose quarter turns are reported: 1, 4 and 6 (ABB's cf1, cf4, cf6); the branch tells the rest."""
_QUARTER = 90.0  # degrees
_HALF_RANGE = 8  # quarters, -8 to 7, that four bits hold: two turns to either side, more than any arm's wrist makes
_BORDER = 1e-3  # degrees: what rounding a pose can move an axis over the border of its quarter


def turn_of(turning: Turning, axes_deg: ArrayLike) -> NDArray[np.int16]:
    """`turn` (N,) of axis values (N, 6), degrees. Raises ValueError for an axis more than two turns from 0, in quarters."""
    axes = np.asarray(axes_deg, np.float64)
    if turning is Turning.SIGNS:
        return StatusTurn.turn(axes)
    quarters = np.floor(axes[..., QUARTERED] / _QUARTER)
    if np.any(np.abs(quarters + 0.5) > _HALF_RANGE):
        raise ValueError("an axis is more than two turns from 0")
    return np.asarray((quarters + _HALF_RANGE) @ np.array([256, 16, 1]), np.int16)  # four bits each


def quarters_of(turn: ArrayLike) -> NDArray[np.int64]:
    """The quarters (..., 3) of axes 1, 4 and 6 that a `turn` (...) in quarters holds."""
    packed = np.asarray(turn, np.int64)[..., None]
    return np.asarray((packed >> np.array([8, 4, 0]) & 15) - _HALF_RANGE)


def turn_fits(turning: Turning, turn: int, axes_deg: Array) -> NDArray[np.bool_]:
    """(N,) whether axis values (N, 6), degrees, are where `turn` says; any are where it is absent (below 0)."""
    if turn < 0:
        return np.ones(len(axes_deg), np.bool_)
    if turning is Turning.SIGNS:
        return np.asarray(turn_of(turning, axes_deg) == turn)
    past = axes_deg[:, QUARTERED] - _QUARTER * quarters_of(turn)
    return np.asarray(np.all((past >= -_BORDER) & (past <= _QUARTER + _BORDER), axis=1))


def turn_text(turning: Turning, status: int, turn: int) -> str:
    """Branch and turn for people."""
    if turning is Turning.SIGNS:
        return f"S {status}, T {turn}"
    quarters = ", ".join(str(k) for k in quarters_of(turn).tolist())
    return f"branch {status}, quarters {quarters} of axes 1, 4 and 6"
