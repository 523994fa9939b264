"""The ripple of a motor's commutation, looked for in an axis's log: its order, and the loop that it went through."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from camrob.gap.effects.common import found_once
from camrob.gap.effects.commutation_loop import LOOPS, Ripple
from camrob.gap.observation.scene import Scene

__all__ = ["CHOICES", "commutation"]

Array = NDArray[np.float64]
Waves = NDArray[np.complex128]
Rows = NDArray[np.int64]

_LOWEST, _HIGHEST = 3.0, 2000.0  # cycles within the travel: fewer, and anything smooth looks like it
_MOST_A_TURN, _MOST_A_METRE = 2000.0, 5000.0  # a gear of 200 and 5 pole pairs, twice; a screw of 2 mm and 5, once
_STEPS = 3.0  # samples a cycle at the least, where the axis is slow: where it is fast, the loop hardly gives way
_SLOW = 0.2  # share of the samples in motion that count as slow
_RESTS = 0.02  # of the farthest step: an axis that makes less stands
_CLASSES = 3  # of speed, in each direction: within one, the loop turns the ripple by nearly one angle
_PADDED, _BESIDE = 4, 151  # of a spectrum: length of its padding, orders beside a peak
_STANDS_OUT = 4.0  # times the median of the orders beside it, over all classes: what is worth a look
_PEAKS, _APART = 6, 8  # how many are looked at, and steps of the spectrum between two
_ROWS = 1500  # of a first look
_COARSE = tuple(
    loop
    for loop in LOOPS
    if loop[0] in (0.0, 20.0, 80.0, 320.0) and loop[1] in (0.0, 1 / 5, 1 / 12) and loop[2] != 1 / 10
)
# cycles within the travel, beside a peak: of a first look, of a second and of a last one
_AROUND, _NEAR, _FINE = np.linspace(-1.0, 1.0, 9), np.linspace(-0.375, 0.375, 7), np.linspace(-0.12, 0.12, 7)
_FINER = (0.4, 0.2)  # by what share a loop is changed, time after time
_SHORT = 5  # loops that are tried in time
_OFF = (-19.0, -13.0, -8.0, -4.5, 4.5, 8.0, 13.0, 19.0)  # ... that are another order's
_SHARP = 12.0  # times what orders beside it explain: a ripple has one order, what is smooth over the angle has many
_TIMES = (1.0, 2.0, 0.5)  # of the order that stands out: an offset of the current ripples once, a gain twice
# times the scatter of what stays, and share of what the rest takes, that a part has to take to be one
_CLEAR, _PART, _MOST_PARTS = 40.0, 0.05, 4
_TINY = 1e-12
CHOICES = 50
"""Orders that could have been picked."""


def commutation(scenes: Sequence[Scene], axis: str) -> Ripple | None:
    """The ripple of an axis's motor in logs that show both ends of its drive; None without a clear one."""
    return found_once(scenes, ("commutation", axis), lambda: _Search(scenes, axis).ripple())


class _Search:
    """An axis's error in all logs, less what follows its motion."""

    def __init__(self, scenes: Sequence[Scene], axis: str) -> None:
        self.scenes, self.axis = scenes, axis
        k = scenes[0].index(axis)
        speeds, self.beside = [], []
        for s in scenes:
            v, a = (s.velocity(s.command[:, [k]], n)[:, 0] for n in (1, 2))
            X = np.stack([np.ones(len(s)), v, a, np.sign(v)], axis=1)
            self.beside.append(np.linalg.qr(X / np.maximum(np.linalg.norm(X, axis=0), _TINY))[0])
            speeds.append(v)
        self.v, self.u = np.concatenate(speeds), np.concatenate([s.link[:, k] for s in scenes])
        self.y = self.apart(np.concatenate([s.servo_gap[:, k] for s in scenes if s.servo_gap is not None]))
        self.load = np.concatenate([s.torque[:, k] for s in scenes])
        self.full = float(np.abs(self.load).max(initial=0.0))
        self.weights = ("even", "loaded" if float(np.ptp(self.load)) > _PART * self.full else "sided")
        self.span = float(np.ptp(self.u))
        linear = scenes[0].cell.joints[scenes[0].cell.index(axis)].prismatic
        self.most = _MOST_A_METRE if linear else _MOST_A_TURN / (2.0 * np.pi)

    def apart(self, x: Array) -> Array:
        """(..., N) less what follows the motion, log by log."""
        out, first = np.array(x), 0
        for Q in self.beside:
            own = slice(first, first + len(Q))
            out[..., own] -= (x[..., own] @ Q) @ Q.T
            first = own.stop
        return out

    def ripple(self) -> Ripple | None:
        """First by what each loop would make of each speed, then as it goes through the loop in time."""
        peaks = self._peaks()
        if not peaks:
            return None
        _, order, weight, _ = max(self._look(p, weight, _COARSE, _AROUND) for p in peaks for weight in self.weights)
        kind = 1.0, weight
        _, order, _, short = self._look(order, weight, LOOPS, _NEAR)
        loops = [Ripple(order, *LOOPS[n], 1.0, max(self.full, _TINY)) for n in short]
        loop = max(loops, key=lambda r: self._gain(self._waves(r, [kind])[0]))
        loop = self._settled(replace(loop, parts=(kind,)))
        wave = self._waves(loop, [kind])[0]
        gain = self._gain(wave)
        beside = [replace(loop, order=loop.order + d / self.span) for d in _OFF]
        others = [self._gain(self._waves(r, [kind])[0]) for r in beside if r.order > 0.0]
        clear = max(_CLEAR * self._scatter(gain), _SHARP * float(np.median(others)))
        if gain < clear or loop.order * self.span < _LOWEST:
            return None
        loop = self._settled(self._tuned(self._with_more(loop, kind)))
        (first, *_), size = loop.parts, 1.0
        size = float(np.sqrt(np.mean(np.abs(self._waves(loop, [first])[0]) ** 2)))
        return replace(loop, size=max(size, _TINY))

    def _settled(self, loop: Ripple) -> Ripple:
        """With the order at the top of a parabola through what its neighbours explain: other logs may go on where these end."""
        orders = loop.order + _FINE / self.span
        gains = np.array([self._explained(replace(loop, order=float(o))) for o in orders])
        n = min(max(int(np.argmax(gains)), 1), len(orders) - 2)
        before, top, behind = gains[n - 1 : n + 2]
        bend = before - 2.0 * top + behind
        off = 0.5 * (before - behind) / bend if bend < 0.0 else 0.0
        return replace(loop, order=float(orders[n] + min(max(off, -1.0), 1.0) * (orders[1] - orders[0])))

    def _look(
        self, order: float, weight: str, loops: Sequence[tuple[float, float, float]], around: Array
    ) -> tuple[float, float, str, tuple[int, ...]]:
        """What is explained the most near an order by drives that are in step with each of their speeds, the order, and the loops
        that explain most, best first.
        """
        rows = np.arange(0, len(self.u), max(1, len(self.u) // _ROWS))
        u, v, y = self.u[rows], self.v[rows], self.y[rows]
        size = (
            self.load[rows] / max(self.full, _TINY) if weight == "loaded" else np.sign(v) if weight == "sided" else 1.0
        )
        # a little beside it, a loop answers the same
        passed = np.stack([Ripple(order, *loop, 1.0, 1.0).at_once(order, v) for loop in loops]) * size
        best: tuple[float, float, str, tuple[int, ...]] = (-1.0, order, weight, ())
        for near in (order + d / self.span for d in around):
            Z = passed * np.exp(2j * np.pi * near * u)
            # b' G^-1 b, where G is 2 x 2
            cc, ss, cs = (np.sum(x, axis=1) for x in (Z.real**2, Z.imag**2, Z.real * Z.imag))
            bc, bs = Z.real @ y, Z.imag @ y
            gain = (ss * bc**2 - 2 * cs * bc * bs + cc * bs**2) / np.maximum(cc * ss - cs**2, _TINY * cc * ss + 1e-300)
            ranked = np.argsort(-gain)[:_SHORT]
            best = max(best, (float(gain[ranked[0]]), near, weight, tuple(ranked.tolist())))
        return best

    def _waves(self, loop: Ripple, parts: Sequence[tuple[float, str]]) -> Waves:
        return np.concatenate([loop.waves(s, self.axis, parts) for s in self.scenes], axis=1)

    def _gain(self, wave: Waves, own: Array | None = None) -> float:
        """What a wave's two phases take beside columns `own` (N, c), orthonormal."""
        X = self.apart(np.stack([wave.real, wave.imag]))
        if own is not None:
            X = X - (X @ own) @ own.T
        G, b = X @ X.T, X @ self.y
        G[np.diag_indices(2)] += _TINY * np.trace(G) + 1e-300
        return float(b @ np.linalg.solve(G, b))

    def _scatter(self, explained: float) -> float:
        return max(float(self.y @ self.y) - explained, 0.0) / len(self.y)

    def _tuned(self, loop: Ripple) -> Ripple:
        """With the loop between those that were tried: faster or slower, or held more or less, as explains more of all parts."""
        best = self._explained(loop)
        for share in _FINER if loop.band else ():
            for what in ("band", "hold", "integral"):
                for factor in (1.0 + share, 1.0 / (1.0 + share)):
                    tried = replace(loop, **{what: getattr(loop, what) * factor})
                    gain = self._explained(tried) if tried != loop else best
                    if gain > best:
                        loop, best = tried, gain
                        break
        return loop

    def _explained(self, loop: Ripple) -> float:
        """What all parts of a loop take together."""
        Z = self._waves(loop, loop.parts)
        Q = np.linalg.qr(self.apart(np.concatenate([Z.real, Z.imag])).T)[0]
        taken = Q.T @ self.y
        return float(taken @ taken)

    def _with_more(self, loop: Ripple, kind: tuple[float, str]) -> Ripple:
        """With what ripples half or twice as often, or by the load, where it is clear."""
        low = _LOWEST / (loop.order * self.span)
        tried = [(times, weight) for times in _TIMES if times >= min(low, 1.0) for weight in self.weights]
        waves = dict(zip(tried, self._waves(loop, tried), strict=True))
        parts = [kind]
        while len(parts) < _MOST_PARTS:
            X = self.apart(np.concatenate([[waves[p].real, waves[p].imag] for p in parts]))
            own = np.linalg.qr(X.T)[0]
            taken = own.T @ self.y
            explained = float(taken @ taken)
            gains = {p: self._gain(z, own) for p, z in waves.items() if p not in parts}
            best = max(gains, key=lambda p: gains[p])
            if gains[best] < max(_CLEAR * self._scatter(explained + gains[best]), _PART * explained):
                break
            parts.append(best)
        return replace(loop, parts=tuple(sorted(parts)))

    def _peaks(self) -> list[float]:
        """Cycles a rad (a m) with which the error may repeat, in either direction and at any speed; the clearest first."""
        k, y = self.scenes[0].index(self.axis), self.y
        travelled = np.abs(np.concatenate([np.diff(s.command[:, k]) for s in self.scenes]))
        moving = travelled[travelled > _RESTS * travelled.max(initial=0.0)]
        if len(moving) == 0:
            return []
        near = float(np.quantile(moving, _SLOW))
        highest = min(1.0 / (_STEPS * near), _HIGHEST / self.span, self.most)
        width = 1.0 / (2.0 * _STEPS * highest)
        at = ((self.u - self.u.min()) / width).astype(np.int64)
        length = 1 << int(np.ceil(np.log2(_PADDED * (int(at.max()) + 1))))
        orders = np.arange(length // 2 + 1) / (length * width)
        used = (orders > _LOWEST / self.span) & (orders < highest)
        if np.count_nonzero(used) < _BESIDE // 2:
            return []
        power = np.zeros(len(orders))
        for rows in self._classes():
            # an axis that rests counts once
            count = np.bincount(at[rows], minlength=length)
            mean = np.bincount(at[rows], y[rows], length) / np.maximum(count, 1)
            mean[count > 0] -= mean[count > 0].mean()
            power += np.abs(np.fft.rfft(mean, length)) ** 2
        # what follows no angle is smooth over orders: a peak stands out from those beside it
        clear = np.where(used, power / np.maximum(median_filter(power, _BESIDE), 1e-300), 0.0)
        found: list[float] = []
        while len(found) < _PEAKS and clear.max() > _STANDS_OUT:
            best = int(np.argmax(clear))
            found.append(float(orders[best]))
            clear[max(0, best - _APART) : best + _APART + 1] = 0.0
        return found

    def _classes(self) -> list[Rows]:
        """Rows by direction and speed."""
        fast = np.abs(self.v)
        cuts = np.quantile(fast, [n / _CLASSES for n in range(1, _CLASSES)])
        rank = np.searchsorted(cuts, fast)
        found = [np.flatnonzero((rank == n) & (self.v * side > 0.0)) for n in range(_CLASSES) for side in (1, -1)]
        return [rows for rows in found if len(rows)]
