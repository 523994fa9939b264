"""Whole turns that a logger adds to an axis's angle or takes off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.units import deg_to_rad

__all__ = ["without_turns"]

Array = NDArray[np.float64]

_WRAP = deg_to_rad(300.0)  # that no axis turns from row to row: its angle was wrapped


def without_turns(
    encoder: Array | None, setpoint: Array | None, turning: NDArray[np.bool_], *, poses: bool
) -> tuple[Array | None, Array | None]:
    """Axis values without the whole turns that a logger adds or takes off: a run goes on from row to row, and an encoder stands
    in the turn of its set-point.
    """

    def going_on(values: Array) -> Array:
        return np.where(turning, np.unwrap(values, discont=_WRAP, axis=0), values)

    if not poses:
        encoder, setpoint = (None if v is None else going_on(v) for v in (encoder, setpoint))
    if encoder is not None and setpoint is not None:
        encoder = encoder - 2.0 * np.pi * np.round((encoder - setpoint) / (2.0 * np.pi)) * turning
    return encoder, setpoint
