"""How drives follow their set-points where logs hold both ends: each axis's lag, and how late its set-points come to it.

On a steady motion both show the same, their sum times the speed. Where an axis speeds up they part: a delay d and a time constant
T leave (d^2 / 2 + d T + T^2) of the acceleration, least where all of the sum is delay and most where all is lag. So the sum is
read off the speed, and its share of delay is the one that leaves least, wherever that leaves clearly less than a lag alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.common import found_once, moved
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import delayed, derivative, first_order, robust_sigma

__all__ = ["Following", "beyond_bounds", "following"]

Array = NDArray[np.float64]

_ROWS, _LOGS = 12000, 3  # of them are enough
_SHARES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)  # of the sum that may be delay, looked at first; then finer beside the best
_FINER = 0.05
_TURNS = 3  # in which the sum is found beside a share
_LEAST, _MOST = 2e-4, 0.4  # s, of a sum that is worth parting
_OF_A_ROW = 0.5  # of the time between rows: of a shorter sum, what is straight or bent between rows shows as much
_CLEAR = 2.0  # times as many squares a lag alone has to leave
_EXPLAINED, _PART = 4.0, 0.01  # times the noise, or of the gap (rms), that the two may leave: else more is at work
_SETTLED = 5.0  # times the sum, from the start of a run, in which nobody knows what set-points were before
_ALIKE, _SAME = 0.15, 0.0015  # share of a common delay, and s, within which an axis's own is the common one
_MANY = 0.6  # share of the axes that move, which a common delay takes
_REST = 0.02  # of an axis's ordinary speed
_ROOM, _ROOM_S = 1.3, 0.002  # times what an axis trails by, and s, that a part of it may be


@dataclass(frozen=True, slots=True)
class Following:
    """lag, delay: s by axis, of axes that move and of which both ends are logged; delay 0 where the logs don't part it from a
    lag. explained: axes where the two leave little beyond the noise; bent: those of them where a lag and an error by
    acceleration would leave hardly more.
    """

    lag: Mapping[str, float]
    delay: Mapping[str, float]
    explained: frozenset[str] = frozenset()
    bent: frozenset[str] = frozenset()

    @property
    def sum(self) -> float:
        """s by which most axes trail a steady motion; 0 where none tells."""
        return float(np.median([self.lag[a] + self.delay[a] for a in self.lag])) if self.lag else 0.0

    @property
    def common_lag(self) -> float:
        """s, of most axes."""
        return float(np.median(list(self.lag.values()))) if self.lag else 0.0

    def as_others(self, axis: str) -> bool:
        """Whether a lag of its own, on set-points as late as most axes', explains an axis as well as any delay."""
        return axis in self.explained and abs(self.delay[axis] - self.common_delay) < max(
            _SAME, _ALIKE * self.common_delay
        )

    @property
    def common_delay(self) -> float:
        """s that most axes have alike; 0 for none."""
        found = [d for d in self.delay.values() if d > 0.0]
        if not found or len(found) < _MANY * len(self.delay):
            return 0.0
        usual = float(np.median(found))
        alike = [d for d in found if abs(d - usual) < max(_SAME, _ALIKE * usual)]
        return float(np.median(alike)) if len(alike) >= _MANY * len(self.delay) else 0.0


def following(scenes: Sequence[Scene]) -> Following:
    """What logs with both ends of the drives tell of how each axis follows; nothing where one of them lacks an end."""
    if any(s.poses or s.servo_gap is None or s.setpoint is None for s in scenes):
        return Following({}, {})
    return found_once(scenes, ("following",), lambda: _search(scenes))


def beyond_bounds(scenes: Sequence[Scene], axis: str, most: float) -> tuple[float, float]:
    """Between which an axis may lag, or be late, otherwise than all others, s: nothing is in time before its set-points are, and
    no part of what an axis trails by is longer than that. Within `most` to both sides where logs don't tell.
    """
    found = following(scenes)
    if not found.lag:
        return -most, most
    own = found.lag.get(axis, 0.0) + found.delay.get(axis, 0.0)
    lower = -(_ROOM * found.sum + _ROOM_S)
    return max(lower, -most), min(_ROOM * own + _ROOM_S, most) if own > 0.0 else most


def _search(scenes: Sequence[Scene]) -> Following:
    found = {}
    for axis in scenes[0].axes:
        if moved(scenes, axis):
            parts = [_Part.of(s, axis) for s in scenes[:_LOGS]]
            found[axis] = _one([p for p in parts if p is not None])
    return Following(
        {a: f.lag for a, f in found.items()},
        {a: f.delay for a, f in found.items()},
        frozenset(a for a, f in found.items() if f.explained),
        frozenset(a for a, f in found.items() if f.bent),
    )


class _Found(NamedTuple):
    """As in `Following`, of one axis."""

    lag: float
    delay: float = 0.0
    explained: bool = False
    bent: bool = False


@dataclass(frozen=True, slots=True)
class _Part:
    """One axis on one log: times, set-points (N, 1), encoder beyond set-point (N,), speed (N,), what else may be there (N, d),
    the encoder's noise.
    """

    t: Array
    pieces: tuple[slice, ...]
    u: Array
    gap: Array
    v: Array
    beside: Array
    noise: float

    @classmethod
    def of(cls, scene: Scene, axis: str) -> _Part | None:
        """Of a log's first rows; None where they are too few."""
        k, count = scene.index(axis), min(len(scene), _ROWS)
        pieces = tuple(slice(p.start, min(p.stop, count)) for p in scene.pieces if p.start < count)
        u, gap = scene.command[:count, [k]], scene.servo_gap
        if count < 50 or gap is None:
            return None
        v = scene.velocity(scene.command[:, [k]])[:count, 0]
        moving = np.abs(v[np.abs(v) > 1e-9])
        rest = _REST * float(np.median(moving)) if len(moving) else 1.0
        beside = np.stack([np.ones(count), np.tanh(v / max(rest, 1e-12))], axis=1)
        own = gap[:count, k]
        return cls(scene.t[:count], pieces, u, own, v, beside, float(robust_sigma(own[:, None], pieces)[0]))

    def beside_acceleration(self, lag: float) -> float:
        """Squares that a lag leaves beside an error by speed and acceleration."""
        acceleration = derivative(self.u, self.t, self.pieces, 2)[:, 0]
        X, rest = np.stack([self.v, acceleration], axis=1), self.left(lag, 0.0)
        left = rest - X @ np.linalg.lstsq(X, rest)[0]
        return float(left @ left)

    def left(self, lag: float, delay: float) -> Array:
        """(N,) of the gap beside a lag on late set-points, a constant and what turns with the direction."""
        late = first_order(self.u, self.t, self.pieces, lag) if lag > 0.0 else self.u
        rest = self.gap - (delayed(late, self.t, self.pieces, delay)[:, 0] - self.u[:, 0])
        known = np.ones(len(rest), bool)
        for run in self.pieces:
            known[run] = self.t[run] - self.t[run.start] > _SETTLED * (lag + delay)
        X = self.beside * known[:, None]
        return np.asarray(known * rest - X @ np.linalg.lstsq(X, known * rest)[0])


def _one(parts: Sequence[_Part]) -> _Found:
    """Of one axis; no lag and no delay where it doesn't trail."""
    power = sum(float(p.v @ p.v) for p in parts)
    if power <= 0.0:
        return _Found(0.0)
    start = -sum(float(p.v @ p.gap) for p in parts) / power
    shortest = max(_LEAST, _OF_A_ROW * max(float(np.median(np.diff(p.t))) for p in parts))
    if not shortest < start < _MOST:
        return _Found(max(start, 0.0) if start < _MOST else 0.0)
    tried = {s: _with_share(parts, s, start, power) for s in _SHARES}
    best = min(tried, key=lambda s: tried[s][0])
    for step in (0.1, _FINER):
        for s in (best - step, best + step):
            if 0.0 <= s <= 1.0 and s not in tried:
                tried[s] = _with_share(parts, s, start, power)
        best = min(tried, key=lambda s: tried[s][0])
    share = _vertex(tried, best)
    least, whole = min(_with_share(parts, share, start, power), tried[best])
    rows = sum(len(p.t) for p in parts)
    noise = sum(len(p.t) * p.noise**2 for p in parts) / max(rows, 1)
    energy = sum(float(p.gap @ p.gap) for p in parts)
    explained = least < max(_EXPLAINED**2 * noise * rows, _PART**2 * energy)
    if not explained or tried[0.0][0] <= _CLEAR * least or share * whole < 0.5 * shortest:
        return _Found(tried[0.0][1], 0.0, explained)
    bent = sum(p.beside_acceleration(tried[0.0][1]) for p in parts) <= _CLEAR * least
    if (1.0 - share) * whole < 0.5 * shortest:
        return _Found(0.0, tried[1.0][1], True, bent)
    return _Found((1.0 - share) * whole, share * whole, True, bent)


def _vertex(tried: Mapping[float, tuple[float, float]], best: float) -> float:
    """The share at the least of a parabola through the best and its neighbours."""
    known = sorted(tried)
    at = known.index(best)
    if not 0 < at < len(known) - 1:
        return best
    x = np.array(known[at - 1 : at + 2])
    a, b, _ = np.polyfit(x, [tried[s][0] for s in x], 2)
    return float(np.clip(-b / (2.0 * a), x[0], x[2])) if a > 0.0 else best


def _with_share(parts: Sequence[_Part], share: float, start: float, power: float) -> tuple[float, float]:
    """Squares that are left, and the sum, s, found beside a share of it that is delay."""
    whole, found = start, np.inf
    for _ in range(_TURNS):
        rests = [p.left((1.0 - share) * whole, share * whole) for p in parts]
        squares = sum(float(r @ r) for r in rests)
        if squares >= found:
            break
        found, kept = squares, whole
        whole = whole - sum(float(p.v @ r) for p, r in zip(parts, rests, strict=True)) / power
        if not 0.0 < whole < _MOST:
            break
    return found, kept
