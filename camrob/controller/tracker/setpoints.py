"""What the measured pose is compared with: the controller's set-points of the last moments, and the error in RKorr's terms.

Eq. 3 of paper 001 takes differences of XYZ extrinsic angles, which its NC adds to the angles of its set-point. KUKA's POSCORR
doesn't add angles: RKorr's A, B, C turn the set-point about the Z, Y and X axes of the correction's reference frame (here
`$BASE`). The order of the three is the same (A yaw, B pitch, C roll) and so is the sign (positive RKorr moves the tool towards
positive), but the axes only agree where the tool frame's A and B are 0: with A at 90 degrees, a difference in B is a turn about
-X of the base, and sent as it is, it would turn the tool about the wrong axis. `rkorr_error` gives the turn that leads from the
measured to the wanted orientation, R(p + e) R(p)^T with eq. 3's e, as A, B, C. For a tool frame parallel to the base both are
the same.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from camrob.controller.tracker.measurement import setpoint_error
from camrob.se3 import abc_to_rotation, rotation_to_abc, slerp, xyzabc_from_frame

__all__ = ["SetpointHistory", "rkorr_error", "without_correction"]

Array = NDArray[np.float64]

_KEPT = 256  # cycles: longer than any delay of an instrument that is good for this


class SetpointHistory:
    """Set-points (6,), m and rad, by the time at which they arrived, s."""

    def __init__(self) -> None:
        self._entries: deque[tuple[float, Array]] = deque(maxlen=_KEPT)

    def add(self, at_s: float, setpoint: Array) -> None:
        """The set-point of a frame that arrived at `at_s`; times that don't grow replace what came later."""
        while self._entries and self._entries[-1][0] >= at_s:
            self._entries.pop()
        self._entries.append((at_s, setpoint))

    def at(self, time_s: float) -> Array:
        """The set-point (6,) at a time between two frames; the nearest one's outside. Raises IndexError where there is none."""
        entries = self._entries
        if time_s >= entries[-1][0]:
            return entries[-1][1]
        after = entries[-1]
        for before in reversed(entries):
            if before[0] <= time_s:
                share = (time_s - before[0]) / (after[0] - before[0])
                return _between(before[1], after[1], share)
            after = before
        return entries[0][1]


def rkorr_error(setpoint: Array, base_T_tcp: Array) -> tuple[Array, Array]:
    """The error in RKorr's terms, and eq. 3's own, each (6,), m and rad, of a measured pose against a set-point (6,)."""
    measured = xyzabc_from_frame(base_T_tcp)
    e = setpoint_error(setpoint, measured)
    wanted = abc_to_rotation(measured[3:] + e[3:])
    turn = wanted @ base_T_tcp[:3, :3].T
    return np.concatenate([e[:3], rotation_to_abc(turn)]), e


def without_correction(setpoint: Array, total: Array) -> Array:
    """The programmed pose (6,) behind a set-point that already holds the correction `total` (6,), m and rad."""
    programmed = abc_to_rotation(total[3:]).T @ abc_to_rotation(setpoint[3:])
    return np.concatenate([setpoint[:3] - total[:3], rotation_to_abc(programmed)])


def _between(before: Array, after: Array, share: float) -> Array:
    place = before[:3] + share * (after[:3] - before[:3])
    if (before[3:] == after[3:]).all():
        return np.concatenate([place, after[3:]])
    R = slerp(abc_to_rotation(before[3:]), abc_to_rotation(after[3:]), share)
    return np.concatenate([place, rotation_to_abc(R)])
