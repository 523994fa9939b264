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
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.loop.tracker_error import setpoint_error
from camrob.se3 import abc_to_rotation, rotation_to_abc, slerp, xyzabc_from_frame

__all__ = ["HISTORY_CYCLES", "SetpointHistory", "Way", "rkorr_error", "turn_between", "without_correction"]

Array = NDArray[np.float64]

HISTORY_CYCLES = 256
"""How many frames are kept: longer than any delay of an instrument that is good for this."""


class Way(NamedTuple):
    """How far something has gone since the session's start, there and back counted twice: m and rad."""

    length: float
    angle: float


class _Entry(NamedTuple):
    at_s: float
    setpoint: Array
    total: Array
    R: Array
    programmed: Way
    commanded: Way  # programmed, and the changes of the correction


class SetpointHistory:
    """Set-points and corrections (6,), m and rad, by the time at which they arrived, s."""

    def __init__(self) -> None:
        self._entries: deque[_Entry] = deque(maxlen=HISTORY_CYCLES)

    def add(self, at_s: float, setpoint: Array, total: Array | None = None) -> None:
        """The set-point of a frame that arrived at `at_s`, and the correction in force then (none: zero). Times that don't
        grow replace what came later.
        """
        while self._entries and self._entries[-1].at_s >= at_s:
            self._entries.pop()
        total = np.zeros(6) if total is None else total
        if not self._entries:
            start = Way(0.0, 0.0)
            self._entries.append(_Entry(at_s, setpoint, total, abc_to_rotation(setpoint[3:]), start, start))
            return
        last = self._entries[-1]
        R = last.R if (setpoint[3:] == last.setpoint[3:]).all() else abc_to_rotation(setpoint[3:])
        length, angle = _norm(setpoint[:3] - last.setpoint[:3]), 0.0 if R is last.R else turn_between(last.R, R)
        change = total - last.total
        programmed, commanded = last.programmed, last.commanded
        self._entries.append(
            _Entry(
                at_s,
                setpoint,
                total,
                R,
                Way(programmed.length + length, programmed.angle + angle),
                Way(commanded.length + length + _norm(change[:3]), commanded.angle + angle + _norm(change[3:])),
            )
        )

    @property
    def programmed(self) -> Way:
        """The set-points' way until the last frame."""
        return self._entries[-1].programmed if self._entries else Way(0.0, 0.0)

    def at(self, time_s: float) -> Array:
        """The set-point (6,) at a time between two frames; the nearest one's outside. Raises IndexError where there is none."""
        before, after, share = self._around(time_s)
        return before.setpoint if share == 0.0 else _between(before.setpoint, after.setpoint, share)

    def commanded(self, time_s: float) -> Way:
        """The way of set-points and corrections until a time, likewise; none where there is no frame yet."""
        if not self._entries:
            return Way(0.0, 0.0)
        before, after, share = self._around(time_s)
        lengths, angles = zip(before.commanded, after.commanded, strict=True)
        return Way(lengths[0] + share * (lengths[1] - lengths[0]), angles[0] + share * (angles[1] - angles[0]))

    def _around(self, time_s: float) -> tuple[_Entry, _Entry, float]:
        """The frames before and after a time, and where between them it lies, from 0 to 1; outside, one frame twice and 0."""
        entries = self._entries
        after = entries[-1]
        if time_s >= after.at_s:
            return after, after, 0.0
        for before in reversed(entries):
            if before.at_s <= time_s:
                return before, after, (time_s - before.at_s) / (after.at_s - before.at_s)
            after = before
        return after, after, 0.0


def turn_between(R: Array, other: Array) -> float:
    """The angle, rad, of the turn that leads from one orientation (3, 3) to another; exact for small ones."""
    chord = float(np.linalg.norm(other - R)) / (2.0 * np.sqrt(2.0))
    return 2.0 * float(np.arcsin(min(chord, 1.0)))


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


def _norm(vector: Array) -> float:
    return float(np.sqrt(vector @ vector))
