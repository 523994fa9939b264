"""The correction law of the tracker loop: proportional gain, accumulated each cycle, bounded (paper 001, section II.B).

Vectors of six are (x, y, z, A, B, C) in m and rad: A the yaw about Z, B the pitch about Y, C the roll about X. This is
the order of the paper's eq. 3 (x, y, z, phi, theta, psi) and of KUKA's frames; R = Rz(A) Ry(B) Rx(C) is the XYZ extrinsic
convention. The law itself works component by component and doesn't mix them.

The paper bounds the increment, K e, just after the gain (`step_m`, `step_rad`). The accumulated total is bounded as well
(`limit_m`, `limit_rad`): what is clipped there isn't remembered, so that nothing winds up behind the bound.

In mode `absolute` the receiver adds what it is sent to its set-point, so the total is sent. In mode `relative` the
receiver sums what it is sent, so the change of the total is sent. Either way the sum is made once, and the totals agree.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camrob.errors import InputError
from camrob.frozen import locked

__all__ = ["CorrectionLaw", "LawState", "LawStep", "accumulate", "hold", "step"]

Array = NDArray[np.float64]
Mode = Literal["absolute", "relative"]


@dataclass(frozen=True, slots=True)
class CorrectionLaw:
    """What turns an error into a correction.

    `gain` K (no unit, a cycle's share of the error, more than 0 and at most 1); `limit_m`, `limit_rad` bound each
    component of the total, `step_m`, `step_rad` each component of a cycle's increment (infinite: unbounded). A measurement
    older than `stale_after_cycles` cycles isn't used; after `stop_after_cycles` cycles in a row without a usable one the
    loop stops answering for good. `cycle_s` is the controller's cycle. Raises InputError for a value that makes no sense.
    """

    gain: float
    limit_m: float
    limit_rad: float
    mode: Mode = "absolute"
    stale_after_cycles: int = 2
    stop_after_cycles: int = 25
    cycle_s: float = 0.004
    step_m: float = math.inf
    step_rad: float = math.inf

    def __post_init__(self) -> None:
        if not 0.0 < self.gain <= 1.0:
            raise InputError(f"the gain is {self.gain}", hint="give more than 0 and at most 1; the paper's is 0.01")
        for name in ("limit_m", "limit_rad", "cycle_s"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(f"the law's {name} is {getattr(self, name)}", hint="give a positive number")
        for name in ("step_m", "step_rad"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"the law's {name} is {getattr(self, name)}", hint="give a positive number")
        if self.mode not in ("absolute", "relative"):
            raise InputError(f"the law's mode is {self.mode!r}", hint="give absolute or relative")
        if self.stale_after_cycles < 1 or self.stop_after_cycles < 1:
            raise InputError("the law's counts of cycles are below 1", hint="give whole numbers from 1 on")

    def is_stale(self, age_s: float) -> bool:
        """True for a measurement too old to be used: older than `stale_after_cycles` cycles, or of no known age."""
        return not 0.0 <= age_s <= self.stale_after_cycles * self.cycle_s

    @property
    def limit(self) -> Array:
        """Bound of each component of the total (6,), m and rad."""
        return _six(self.limit_m, self.limit_rad)

    @property
    def step_limit(self) -> Array:
        """Bound of each component of an increment (6,), m and rad."""
        return _six(self.step_m, self.step_rad)


@dataclass(frozen=True, slots=True)
class LawState:
    """What the law remembers: the `total` (6,), the cycles in a row without a usable measurement, whether it stopped."""

    total: Array = field(default_factory=lambda: np.zeros(6))
    stale_cycles: int = 0
    stopped: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "total", locked(self.total, shape=(6,), name="total"))


@dataclass(frozen=True, slots=True)
class LawStep:
    """One cycle's outcome: the next `state`, what is `sent` (6,) where it `answers`, which components were `saturated` (6,)."""

    state: LawState
    sent: Array
    answers: bool
    saturated: NDArray[np.bool_]


def accumulate(law: CorrectionLaw, total: Array, error: Array) -> tuple[Array, Array]:
    """The bare law, for simulations too: next total and its change, each (..., 6), from a total and an error p* - p (..., 6)."""
    limit, step_limit = law.limit, law.step_limit
    increment = np.clip(law.gain * np.asarray(error, float), -step_limit, step_limit)
    after = np.clip(total + increment, -limit, limit)
    return after, after - total


def hold(law: CorrectionLaw, state: LawState) -> Array:
    """What leaves the correction as it is (6,): the total in mode `absolute`, zero in mode `relative`."""
    return np.zeros(6) if law.mode == "relative" else np.array(state.total)


def step(law: CorrectionLaw, state: LawState, error: ArrayLike | None) -> LawStep:
    """One cycle of the law; `error` (6,) is p* - p, or None where there is no usable measurement.

    Without one, `absolute` sends the last total and `relative` zero, and nothing is accumulated; the cycle that makes the
    row longer than `stop_after_cycles` isn't answered, nor is any after it. Raises InputError for an error that isn't six
    finite numbers.
    """
    none = np.zeros(6, dtype=bool)
    if state.stopped:
        return LawStep(state, np.zeros(6), False, none)
    if error is None:
        stale = state.stale_cycles + 1
        stopped = stale > law.stop_after_cycles
        held = LawState(state.total, stale, stopped)
        return LawStep(held, np.zeros(6) if stopped else hold(law, state), not stopped, none)
    e = np.asarray(error, dtype=float)
    if e.shape != (6,) or not np.isfinite(e).all():
        raise InputError(
            "an error of the tracker loop isn't six finite numbers", hint="check the measurement and the set-point"
        )
    total, change = accumulate(law, state.total, e)
    # the change is compared, not the clip's own tests: one rounding of the sum apart is no saturation
    saturated = np.abs(change - law.gain * e) > 1e-12 + 1e-9 * np.abs(law.gain * e)
    return LawStep(LawState(total), total if law.mode == "absolute" else change, True, saturated)


def _six(length: float, angle: float) -> Array:
    return np.array([length] * 3 + [angle] * 3)
