"""How a drive's loop passes on the ripple of its motor's torque: it damps and turns it by how fast it comes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.digital_filter import filtered, sampled
from camrob.gap.observation.scene import Scene

__all__ = ["LOOPS", "Ripple"]

Array = NDArray[np.float64]
Waves = NDArray[np.complex128]

# of a cascade, rad/s: the speed loop's band; what the position loop and the integral part have of it, from soft to tight
_BANDS = (20.0, 40.0, 80.0, 160.0, 320.0, 640.0)
_TUNED = ((1 / 15, 0.0), (1 / 5, 0.0), (1 / 2, 0.0), (1 / 12, 1 / 10), (1 / 12, 1 / 3), (1 / 4, 1 / 10), (1 / 4, 1 / 3))
LOOPS = ((0.0, 0.0, 0.0), *((w, hold, integral) for w in _BANDS for hold, integral in _TUNED))
"""Loops that are tried: band, and what position loop and integral part have of it; the first gives way at once."""
_STEP, _MOST_STEPS = 0.002, 120_000  # s of the loop's reckoning; how many there are at the most
_BEFORE = 5.0  # time constants of the slowest part of a loop for which an axis had gone on as it does at a run's begin


@dataclass(frozen=True, slots=True)
class Ripple:
    """order: cycles a rad (a m); band: rad/s of the speed loop, 0 for a drive that gives way at once; hold, integral: what
    position loop and integral part have of it; size: of a wave of 1 behind the loop, in the logs where it was found; full: Nm
    that count as a whole load; parts: (times the order, weight).
    """

    order: float
    band: float
    hold: float
    integral: float
    size: float
    full: float
    parts: tuple[tuple[float, str], ...] = ()

    @classmethod
    def of(cls, key: str) -> Ripple:
        """What `key` says."""
        numbers, _, parts = key.partition("|")
        found = tuple((float(times), weight) for times, _, weight in (p.partition(" ") for p in parts.split("|")))
        order, band, hold, integral, size, full = map(float, numbers.split())
        return cls(order, band, hold, integral, size, full, found)

    @property
    def key(self) -> str:
        """In a unit's key."""
        numbers = " ".join(f"{x:.9g}" for x in (self.order, self.band, self.hold, self.integral, self.size, self.full))
        return "|".join([numbers, *(f"{times:g} {weight}" for times, weight in self.parts)])

    def waves(self, scene: Scene, axis: str, parts: Iterable[tuple[float, str]]) -> Waves:
        """(P, N) of each part, what the loop leaves of it: the real part of a cosine, the imaginary one of a sine."""
        k = scene.index(axis)
        parts = list(parts)
        out = np.zeros((len(parts), len(scene)), np.complex128)
        weighed = {weight: self._weight(scene, k, weight) for _, weight in parts}
        for run in scene.pieces:
            for number, (times, weight) in enumerate(parts):
                angle = 2.0 * np.pi * times * self.order * scene.link[run, k]
                out[number, run] = self._behind(angle, weighed[weight][run], scene.t[run])
        return out / self.size

    def _weight(self, scene: Scene, k: int, weight: str) -> Array:
        if weight == "loaded":
            return np.asarray(scene.torque[:, k] / self.full)
        if weight == "sided":
            return np.sign(scene.velocity(scene.command[:, [k]])[:, 0])
        return np.ones(len(scene))

    def _behind(self, angle: Array, weight: Array, t: Array) -> Waves:
        """(N,) the wave of a run behind the loop, on a clock of its own, of which each step takes the mean wave on its way."""
        if self.band == 0.0 or len(t) < 3:
            return np.asarray(weight * np.exp(1j * angle))
        top, bottom = self.loop
        span = float(t[-1] - t[0])
        before = min(_BEFORE / max(1e-9, float(np.min(np.abs(np.roots(bottom))))), span)
        step = max(_STEP, (span + before) / _MOST_STEPS)
        fine = np.arange(t[0] - before, t[-1] + 2.0 * step, step)
        turned = np.interp(fine, t, angle)
        # as fast as in its first step
        early = fine < t[0]
        turned[early] += (angle[1] - angle[0]) / (t[1] - t[0]) * (fine[early] - t[0])
        way = np.diff(turned)
        mean = np.exp(1j * (turned[:-1] + 0.5 * way)) * np.sinc(way / (2.0 * np.pi))
        mean *= np.interp(fine[:-1], t, weight)
        late = filtered(*sampled(top, bottom, step), mean)
        # what acts in a step shows at its end
        return np.asarray(np.interp(t, fine[:-1], late.real) + 1j * np.interp(t, fine[:-1], late.imag))

    def at_once(self, order: float, speed: Array) -> Waves:
        """(N,) by what a wave that went on at one speed (N,) would be multiplied behind the loop."""
        if self.band == 0.0:
            return np.ones(len(speed), np.complex128)
        s = 2j * np.pi * order * speed
        return np.asarray(np.polyval(self.loop[0], s) / np.polyval(self.loop[1], s))

    @property
    def loop(self) -> tuple[list[float], list[float]]:
        """Numerator and denominator in s of how far a torque T moves the axis, by
        J x = s T / (s^3 + w (s + hold w) (s + integral w)), without the integral part J x = T / (s^2 + w (s + hold w)); J = w^2.
        """
        w, hold, integral = self.band, self.hold * self.band, self.integral * self.band
        if integral == 0.0:
            return [w * w], [1.0, w, w * hold]
        return [w * w, 0.0], [1.0, w, w * (hold + integral), w * hold * integral]
