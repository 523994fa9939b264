"""Whether a measured pose can be the tool's: one that moves when the tool does, and no farther than it can.

Nothing here needs to know the robot. What it was commanded (its "way", set-points and corrections) bounds what it can have done.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError
from camrob.loop.rsi.setpoints import SetpointHistory, Way, rkorr_error, turn_between
from camrob.loop.tracker_error import base_pose, quaternion_rotation, reading_of
from camrob.se3 import inverse

__all__ = ["FROZEN_REFUSALS", "JumpBound", "StillPose", "likely_cause"]

Array = NDArray[np.float64]

_FROZEN = "a measurement's pose stands still though the robot is moved"
_TOO_STILL = "a measurement's place stands still to the last digit"
FROZEN_REFUSALS = frozenset({_FROZEN, _TOO_STILL})

_REPEATS = 3  # equal samples in a row from which on there is something to ask; two may be chance of the digits
# What the robot is moved, m and rad, before an unmoved pose is a fault: far more than an instrument's last digit, far less than
# what matters to a part. Friction may hold a joint back for longer, but not the noise that moves the digits all the while.
_MOVED = Way(5e-5, 2e-4)
_CATCHING_UP_S = 0.1  # by how much a robot runs behind its commands: 70 ms of lag and some cycles


class _Still:
    """How often one part of the poses, place or orientation, came in a row, and the way commanded when it first did."""

    def __init__(self) -> None:
        self.count = 0
        self._value: Array | None = None
        self._since = 0.0

    def moved(self, value: Array, way: float) -> float:
        """The way since a value came first."""
        if self._value is None or (value != self._value).any():
            self._value, self._since, self.count = value, way, 0
        self.count += 1
        return way - self._since


class StillPose:
    """Poses in a row that are equal to the last digit, in place or orientation: an instrument that repeats itself.

    `noisy`: its noise is known, so that no two places are equal even where the robot rests.
    """

    def __init__(self, *, noisy: bool) -> None:
        self._noisy = noisy
        self._place, self._turn = _Still(), _Still()

    def check(self, pose: Array, way: Way) -> None:
        """Take note of a pose as it was sent; `way` is what the robot has been commanded until it was measured.

        Raises InputError for a frozen one. A quaternion and its negative are the same orientation.
        """
        moved, turned = self._place.moved(pose[:3, 3], way.length), self._turn.moved(pose[:3, :3], way.angle)
        hint = "check that the instrument still sees its target, and that what sends its data still gets new ones"
        frozen = self._place.count >= _REPEATS and moved > _MOVED.length
        if frozen or (self._turn.count >= _REPEATS and turned > _MOVED.angle):
            raise InputError(_FROZEN, hint=hint)
        if self._noisy and self._place.count >= _REPEATS:
            raise InputError(_TOO_STILL, hint=hint)


class _Believed(NamedTuple):
    at_s: float
    base_T_tcp: Array


class JumpBound:
    """Between two measurements the tool can't have moved farther than it was commanded to, and `length`, `angle` beyond (m, rad).

    What was commanded shortly before the first of the two counts as well, since a robot runs behind its commands.
    """

    def __init__(self, length: float, angle: float) -> None:
        self._length, self._angle = length, angle
        self._last: _Believed | None = None

    def too_far(self, at_s: float, base_T_tcp: Array, history: SetpointHistory) -> bool:
        """Whether a pose measured at `at_s` is out of reach from the last one that was believed."""
        if self._last is None:
            return False
        before, now = history.commanded(self._last.at_s - _CATCHING_UP_S), history.commanded(at_s)
        last = self._last.base_T_tcp
        moved = float(np.linalg.norm(base_T_tcp[:3, 3] - last[:3, 3]))
        turned = turn_between(last[:3, :3], base_T_tcp[:3, :3])
        return moved > self._length + now.length - before.length or turned > self._angle + now.angle - before.angle

    def believe(self, at_s: float, base_T_tcp: Array) -> None:
        """The next pose is compared with this one."""
        self._last = _Believed(at_s, base_T_tcp)


def likely_cause(base_T_tracker: Array, tracker_T_tcp: Array, setpoint: Array, bounds: tuple[float, float]) -> str:
    """What one mistake would explain a pose that is too far from the set-point (6,): a phrase, or "" where none does.

    `bounds`: how near a pose has to be to be believed, m and rad. The frames are (4, 4).
    """
    for text, frame, pose in _mistakes(base_T_tracker, tracker_T_tcp):
        error, _eq3 = rkorr_error(setpoint, base_pose(frame, pose))
        if np.abs(error[:3]).max() <= bounds[0] and np.abs(error[3:]).max() <= bounds[1]:
            return text
    return ""


def _mistakes(base_T_tracker: Array, tracker_T_tcp: Array) -> Iterator[tuple[str, Array, Array]]:
    """Each mistake that people make, undone: what it is called, and the two frames as they should have been."""
    for factor, text in (
        (1000.0, "its lengths are in metres"),
        (25.4, "its lengths are in inches"),
        (1e-3, "its lengths are in micrometres"),
    ):
        scaled = tracker_T_tcp.copy()
        scaled[:3, 3] *= factor
        yield text + ", not mm", base_T_tracker, scaled
    q = reading_of(tracker_T_tcp).quaternion
    for text, order in (
        ("its quaternion's real part comes last, not first", (3, 0, 1, 2)),
        ("its quaternion's sense of turning is the opposite one", None),
    ):
        turned = tracker_T_tcp.copy()
        turned[:3, :3] = tracker_T_tcp[:3, :3].T if order is None else quaternion_rotation(*q[list(order)].tolist())
        yield text, base_T_tracker, turned
    yield "the instrument's frame is given the wrong way round, base in tracker", inverse(base_T_tracker), tracker_T_tcp
    yield "the instrument's frame isn't applied, its poses are in the base already", np.eye(4), tracker_T_tcp
