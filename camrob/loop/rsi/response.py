"""Whether the error answers to the correction: the sign that the loop is closed, and closed the right way round.

Pushed by c, a sound robot's error falls by c, up to what else changed it meanwhile. If the error *grows* while the correction
pushes against it, something has the wrong sign or frame: the instrument's, or that of the controller's own correction. If it
*doesn't shrink* however far it is pushed, the instrument doesn't see what the controller moves.

What else changes an error is the motion, and so it is allowed for by what was commanded: a share of the way (geometry differs
from place to place), and the robot's lag times every change of velocity. Where that allowance is larger than the push, nothing
can be said, and the bounds of the total are what is left. The noise is measured as it comes.

Errors and totals are averaged over blocks of a quarter of the law's time constant, 1/gain cycles, so that two numbers suffice:
growth is looked for over one time constant, in which a sound loop brings the error down by 63 %, and a dead one over eight.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.loop.rsi.setpoints import Way
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["ResponseWatch"]

Array = NDArray[np.float64]

_PER_CONSTANT, _DEAD_CONSTANTS = 4, 8  # blocks a time constant; time constants without an answer
_LEAST_BLOCK_S = 0.1  # of a block: a robot takes that long to follow, and before it has, its error says nothing
_BEFORE = 2  # blocks before a span whose changes of velocity still show in it
_SHARE = 0.5  # of the push that an error has to grow by, or fail to shrink by, beyond what is allowed for
_LATE_S = 0.15  # of lag that a change of velocity may turn into error: twice what the RX160's joints were fitted with
_SIGMAS = 4.0


@dataclass(frozen=True, slots=True)
class _Part:
    """Positions or angles: which components; how far they have to be pushed before growth and a dead loop are judged (the
    latter above what friction and lost motion swallow); the error that is nobody's fault; the share of the way, of the length
    (a metre or a radian, each a metre) and the angle, that may turn into error; how a person reads it.
    """

    at: slice
    least_growth: float
    least_dead: float
    nobody: float
    of_length: float
    of_angle: float
    unit: str


# a hundredth of the way: the worst of the arms measured here is off by 2 mm over 1 m, a tool's lever is less than a metre
_PARTS = (
    _Part(slice(0, 3), 5e-5, 3e-4, 2e-5, 0.01, 0.01, "mm"),
    _Part(slice(3, 6), 1e-4, 1e-3, 5e-5, 0.02, 0.01, "degrees"),
)


class _Block(NamedTuple):
    """Means over some cycles: `error`, `total` (6,) and the errors' standard deviation; at its end, the set-points' `way` so far,
    their `velocity` (3,) and its `turning`, rad/s, over it.
    """

    error: Array
    total: Array
    deviation: Array
    way: Way
    velocity: Array
    turning: float


class ResponseWatch:
    """Watches errors (6,) and totals (6,) of answered cycles for growth under correction, and for no answer at all."""

    def __init__(self, gain: float, cycle_s: float) -> None:
        self._length = max(math.ceil(_LEAST_BLOCK_S / cycle_s), math.ceil(1.0 / (_PER_CONSTANT * gain)))
        self._blocks: deque[_Block] = deque(maxlen=_BEFORE + _PER_CONSTANT * _DEAD_CONSTANTS + 1)
        self._errors: list[Array] = []
        self._totals: list[Array] = []
        self._begin: tuple[float, Array, Way] | None = None

    def add(self, at_s: float, error: Array, total: Array, setpoint: Array, way: Way) -> str:
        """One cycle whose measurement was used: why the loop can't go on, or "".

        `error` (6,), in RKorr's terms, was seen at `at_s` under `total` (6,); `setpoint` (6,) is that cycle's, `way` that of all
        set-points until then.
        """
        if self._begin is None:
            self._begin = (at_s, setpoint, way)
        self._errors.append(error)
        self._totals.append(total)
        if len(self._errors) < self._length:
            return ""
        errors, (begin_s, start, start_way) = np.array(self._errors), self._begin
        elapsed = max(at_s - begin_s, 1e-6)
        self._blocks.append(
            _Block(
                errors.mean(axis=0),
                np.mean(self._totals, axis=0),
                errors.std(axis=0),
                way,
                (setpoint[:3] - start[:3]) / elapsed,
                (way.angle - start_way.angle) / elapsed,
            )
        )
        self._errors, self._totals, self._begin = [], [], (at_s, setpoint, way)
        return self._judged()

    def _judged(self) -> str:
        blocks = list(self._blocks)
        for part in _PARTS:
            reason = self._grows(part, blocks) or self._dead(part, blocks)
            if reason:
                return reason
        return ""

    def _grows(self, part: _Part, blocks: Sequence[_Block]) -> str:
        if len(blocks) <= _PER_CONSTANT:
            return ""
        push, before, after = _along(part, blocks[-1 - _PER_CONSTANT], blocks[-1])
        least = _SHARE * push + self._allowed(part, blocks, _PER_CONSTANT)
        if push < part.least_growth or before <= 0.0 or after - before < least:
            return ""
        return (
            f"the error grew from {_shown(part, before)} to {_shown(part, after)} {part.unit} while the correction pushed "
            f"against it by {_shown(part, push)}: a wrong sign or a wrong frame, the instrument's or that of the "
            "controller's correction (RefCorrSys has to be Base)"
        )

    def _dead(self, part: _Part, blocks: Sequence[_Block]) -> str:
        span = _PER_CONSTANT * _DEAD_CONSTANTS
        if len(blocks) <= span:
            return ""
        push, before, after = _along(part, blocks[-1 - span], blocks[-1])
        least = -_SHARE * push + self._allowed(part, blocks, span)
        shrunk = before <= 0.0 or after < _SHARE * before or after - before < least
        if push < part.least_dead or shrunk:
            return ""
        return (
            f"the error didn't shrink, {_shown(part, before)} to {_shown(part, after)} {part.unit}, while the correction "
            f"pushed against it by {_shown(part, push)}: the instrument doesn't see what the controller moves, the controller "
            "doesn't apply the correction, or its set-points hold it already (--corrected)"
        )

    def _allowed(self, part: _Part, blocks: Sequence[_Block], span: int) -> float:
        """By how much an error may have changed over the last `span` blocks without the correction's doing."""
        first, last = blocks[-1 - span], blocks[-1]
        bends = list(pairwise(blocks[-1 - span - _BEFORE :] if len(blocks) > span + _BEFORE else blocks))
        late = sum(float(np.linalg.norm(b.velocity - a.velocity)) + abs(b.turning - a.turning) for a, b in bends)
        noise = np.linalg.norm(first.deviation[part.at]) + np.linalg.norm(last.deviation[part.at])
        geometry = part.of_length * (last.way.length - first.way.length) + part.of_angle * (
            last.way.angle - first.way.angle
        )
        return part.nobody + geometry + _LATE_S * late + _SIGMAS * float(noise) / math.sqrt(self._length)


def _along(part: _Part, first: _Block, last: _Block) -> tuple[float, float, float]:
    """How far the total moved from one block to another, and both blocks' errors along that direction."""
    pushed = (last.total - first.total)[part.at]
    push = float(np.linalg.norm(pushed))
    if push == 0.0:
        return 0.0, 0.0, 0.0
    u = pushed / push
    return push, float(first.error[part.at] @ u), float(last.error[part.at] @ u)


def _shown(part: _Part, value: float) -> str:
    return f"{m_to_mm(value) if part.unit == 'mm' else rad_to_deg(value):.3f}"
