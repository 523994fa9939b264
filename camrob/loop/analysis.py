"""The tracker loop by analysis: poles, margins, noise, and the gain that suits a recorded error.

At one posture the loop falls into six separate ones, one a joint: the gain is the same number in all directions, so the Jacobian
that leads to the joints and back cancels around it. With z the shift by one cycle, the joint follows its command by
G = a z^-(d+1) / (1 - (1-a) z^-1), a = 1 - exp(-T/lag); the measurement is m cycles old; the law accumulates: C = K / (1 - z^-1).
The loop is L = C G z^-m, what remains of an error is S = 1 / (1 + L), and the characteristic polynomial is

    (1 - z^-1) (1 - (1-a) z^-1) + K a z^-(d+1+m)

Without lag and delay this leaves the pole 1 - K: a ramp of speed v leaves the error v T / K, and white noise of the measurement
moves the robot with K / (2 - K) of its variance.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

__all__ = ["JointLoop", "Margins"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_FREQUENCIES = 4000  # evenly over the decades: five hundred or more in each
_TAIL = 1e-9  # how far an impulse response is followed down


class Margins(NamedTuple):
    """`gain`: by what factor K may grow; `phase`, rad; `delay`: cycles of further latency until the loop is unstable; `peak`:
    the greatest |S|; `bandwidth`: where |S| first reaches 0.7, Hz; `noise`: variance of the robot's motion over that of the
    measurement's noise.
    """

    gain: float
    phase: float
    delay: float
    peak: float
    bandwidth: float
    noise: float


@dataclass(frozen=True, slots=True)
class JointLoop:
    """One joint's loop: `lag`, s; `delay` and `latency`, cycles; `cycle`, s. A lag of 0 follows within a cycle."""

    lag: float
    delay: int
    latency: int
    cycle: float

    @property
    def share(self) -> float:
        """a: what of a command's step a cycle brings."""
        return 1.0 if self.lag <= 0.0 else float(-np.expm1(-self.cycle / self.lag))

    def polynomial(self, gain: float) -> Array:
        """The characteristic polynomial's coefficients in z, highest power first."""
        a, n = self.share, self.delay + self.latency + 1
        size = max(n, 2)
        out = np.zeros(size + 1)
        out[:3] = [1.0, -(2.0 - a), 1.0 - a]
        out[n] += gain * a
        return out

    def poles(self, gain: float) -> Complex:
        """Its roots."""
        return np.asarray(np.roots(self.polynomial(gain)), complex)

    def stable(self, gain: float) -> bool:
        """True where all poles lie within the unit circle."""
        return bool(np.abs(self.poles(gain)).max() < 1.0)

    def limit(self) -> float:
        """The gain at which the loop becomes unstable, to 1e-12."""
        low, high = 0.0, 4.0
        for _halving in range(45):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.stable(middle) else (low, middle)
        return low

    def open_loop(self, gain: float, omega: Array) -> Complex:
        """L at angular frequencies, rad/s."""
        z = np.exp(1j * omega * self.cycle)
        a = self.share
        follow = a * z ** -(self.delay + 1.0) / (1.0 - (1.0 - a) / z)
        return np.asarray(gain / (1.0 - 1.0 / z) * follow * z ** -float(self.latency), complex)

    def remaining(self, gain: float, error: Array) -> Array:
        """S applied to an error (N, ...) recorded without correction: the error that the loop would have seen."""
        a, n = self.share, self.delay + self.latency + 1
        top = np.zeros(max(n, 2) + 1)
        top[:3] = [1.0, -(2.0 - a), 1.0 - a]
        return np.asarray(lfilter(top, self.polynomial(gain), error, axis=0))

    def motion(self, gain: float, error: Array) -> Array:
        """What the corrections do to the robot, C G S applied to a recorded error (N, ...)."""
        top = np.zeros(self.delay + 2)
        top[-1] = gain * self.share
        return np.asarray(lfilter(top, self.polynomial(gain), error, axis=0))

    def noise(self, gain: float) -> float:
        """Variance of the robot's motion over that of white noise in the measurement."""
        worst = float(np.abs(self.poles(gain)).max())
        if worst >= 1.0:
            return float("inf")
        cycles = int(min(np.log(_TAIL) / np.log(worst), 2e6)) + self.delay + self.latency + 10 if worst > 0.0 else 50
        impulse = np.zeros(cycles)
        impulse[0] = 1.0
        return float(np.sum(self.motion(gain, impulse) ** 2))

    def peak(self, gain: float) -> float:
        """The greatest |S|."""
        omega = np.geomspace(1e-3, np.pi / self.cycle, _FREQUENCIES)
        return float(np.abs(1.0 / (1.0 + self.open_loop(gain, omega))).max())

    def margins(self, gain: float) -> Margins:
        """How far the loop is from trouble. A stable gain is asked for; an unstable one has margins below 1 and 0."""
        omega = np.geomspace(1e-3, np.pi / self.cycle, _FREQUENCIES)
        L = self.open_loop(gain, omega)
        S = np.abs(1.0 / (1.0 + L))
        size, angle = np.abs(L), np.unwrap(np.angle(L))
        at = int(np.argmax(size < 1.0)) if np.any(size < 1.0) else len(omega) - 1
        phase = float(np.interp(0.0, [np.log(size[at]), np.log(size[at - 1])], [angle[at], angle[at - 1]])) + np.pi
        reached = omega[int(np.argmax(np.sqrt(0.5) <= S))]
        return Margins(
            self.limit() / gain,
            phase,
            phase / float(omega[at]) / self.cycle,
            float(S.max()),
            float(reached / (2.0 * np.pi)),
            self.noise(gain),
        )
