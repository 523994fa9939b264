"""What course friction's error takes at a drive, found in its axis's log: it stands or dies away, falls with speed or not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.common import found_once
from camrob.gap.effects.digital_filter import filtered
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import first_order, play
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["CHOICES", "Course", "friction_course", "settled"]

Array = NDArray[np.float64]

_LENGTH = mm_to_m(10.0) / deg_to_rad(1.0)  # m of a sliding axis that slows down as a rad of a turning one does
_SLOW = tuple(
    deg_to_rad(v) for v in (0.01, 0.03, 0.1, 0.2, 0.35, 0.6, 1.0, 1.8, 3.0)
)  # a second: counts as turning round
_HELD = tuple(deg_to_rad(w) for w in (0.003, 0.01, 0.03, 0.1))  # way after which an axis that rested has turned round
_QUICK = (0.01, 0.02, 0.04, 0.08, 0.15, 0.25, 0.4)  # s that a loop takes to give way
_APART = 0.7  # of the decay, at most: what is no quicker than that is the decay itself
_DECAYS = (0.03, 0.06, 0.1, 0.15, 0.25, 0.4, 0.7, 1.2)  # s in which an integral part overcomes a reversal
_PEAK = 0.15  # s of those where no decay shows
_FALLS = tuple(deg_to_rad(v) for v in (0.2, 0.5, 1.0, 2.0, 4.0, 8.0))  # speed at which Stribeck's excess has gone
# of the speed that an axis reaches (95 %), at the most: friction is dry; what turns over slower is any smooth function of speed
_DRY = 0.25
# times the scatter of what stays, and share of what the rest takes, that a further part has to take to be one
_CLEAR, _PART = 40.0, 0.01
_TINY = 1e-12
CHOICES = len(_SLOW) * len(_DECAYS)
"""Courses that could have been picked."""


@dataclass(frozen=True, slots=True)
class Course:
    """rest: speed below which an axis counts as turning round, or, where it is 0, held: the way after which one that holds its
    error at rest does; both where a part is held, and the rest is lost. decay: s in which a peak dies away; quick: s that the
    loop takes to give way, 0 where it does at once (the course of such a loop is that of two peaks, which differ); falls: speed
    at which Stribeck's excess has gone, 0 for none; full: Nm at which the part that grows with the load is whole, 0 for none.
    """

    rest: float
    held: float = 0.0
    decay: float = _PEAK
    quick: float = 0.0
    falls: float = 0.0
    full: float = 0.0

    @classmethod
    def of(cls, key: str) -> Course:
        """What `key` says."""
        return cls(*map(float, key.split()))

    @property
    def key(self) -> str:
        """In a unit's key."""
        return " ".join(f"{x:.6g}" for x in astuple(self))

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the columns."""
        second = ["second_peak"] if self.quick else []
        held = ["held"] if self.rest and self.held else []
        return (
            "constant",
            "peak",
            *second,
            *held,
            *(["stribeck"] if self.falls else []),
            *(["loaded"] if self.full else []),
        )

    def columns(self, scene: Scene, axis: str) -> Array:
        """(N, parts) by which friction keeps a drive back, a unit of each part."""
        k = scene.index(axis)
        command = scene.command[:, [k]]
        v = scene.velocity(command)
        holding = play(command[:, 0], scene.t, scene.pieces, self.held)[:, None] if self.held else v
        side = np.tanh(v / self.rest) if self.rest else holding
        columns = [side, *(side - settled(scene, side, tau) for tau in (self.decay, self.quick) if tau)]
        if self.rest and self.held:
            columns.append(holding)
        if self.falls:
            columns.append(side * np.exp(-((v / self.falls) ** 2)))
        if self.full:
            columns.append(side * np.abs(scene.torque[:, [k]]) / self.full)
        return np.concatenate(columns, axis=1)


def settled(scene: Scene, side: Array, tau: float) -> Array:
    """A side (N, k) behind a lag that had settled when a run began: a slope there is that of the side's turn, not of a ramp."""
    return first_order(side, scene.t, scene.pieces, tau, known=side)


def friction_course(scenes: Sequence[Scene], axis: str) -> Course:
    """The course that explains most of a drive's error beside its lag, of logs that show both ends of it."""
    return found_once(scenes, ("course", axis), lambda: _Search(scenes, axis).course())


class _Search:
    """An axis's error in all logs, less what follows its speed and acceleration."""

    def __init__(self, scenes: Sequence[Scene], axis: str) -> None:
        self.scenes, self.axis = scenes, axis
        joint = scenes[0].cell.joints[scenes[0].cell.index(axis)]
        self.scale = _LENGTH if joint.prismatic else 1.0
        k = scenes[0].index(axis)
        commands = [s.command[:, [k]] for s in scenes]
        self.v = np.concatenate([s.velocity(c) for s, c in zip(scenes, commands, strict=True)])
        self.dry = _DRY * float(np.percentile(np.abs(self.v), 95))
        a = np.concatenate([s.velocity(c, 2) for s, c in zip(scenes, commands, strict=True)])
        beside = np.concatenate([np.ones_like(a), self.v, a], axis=1)
        self.beside = np.linalg.qr(beside / np.maximum(np.linalg.norm(beside, axis=0), _TINY))[0]
        error = [s.servo_gap[:, [k]] for s in scenes if s.servo_gap is not None]
        self.y = self.apart(np.concatenate(error))[:, 0]
        firsts = np.cumsum([0, *(len(s) for s in scenes)])
        self.runs = [
            (slice(n + run.start, n + run.stop), float(np.median(np.diff(s.t[run]))))
            for n, s in zip(firsts, scenes, strict=False)
            for run in s.pieces
            if run.stop > run.start + 1
        ]
        self.torque = np.abs(np.concatenate([s.torque[:, [k]] for s in scenes]))

    def apart(self, X: Array) -> Array:
        """Columns (N, k) less what speed and acceleration show of them."""
        return np.asarray(X - self.beside @ (self.beside.T @ X))

    def late(self, X: Array, tau: float) -> Array:
        """Columns (N, k) behind a lag, run by run: nearly as `settled`, between samples straight."""
        out = X.copy()
        for run, step in self.runs:
            kept = np.exp(-step / tau)
            c = tau * (1.0 - kept) / step
            first = X[run][:1]
            out[run] = first + filtered(np.array([1.0 - c, c - kept]), np.array([1.0, -kept]), X[run] - first)
        return out

    def course(self) -> Course:
        """The side first, with the decay; then what comes beside. An axis at which no side shows has any."""
        dry = [r for r in _SLOW if r * self.scale <= self.dry]
        rests = [Course(r * self.scale) for r in dry or _SLOW[:1]]
        sides = [np.tanh(self.v / c.rest) for c in rests]
        gain, which, _ = self._best(np.concatenate(sides, axis=1))
        if gain < _CLEAR * self._scatter(gain):
            return rests[which]
        helds = [Course(0.0, w * self.scale) for w in _HELD]
        k = self.scenes[0].index(self.axis)
        held = [
            np.concatenate([play(s.command[:, k], s.t, s.pieces, c.held)[:, None] for s in self.scenes]) for c in helds
        ]
        _, which, decay = self._best(np.concatenate([*sides, *held], axis=1))
        chosen = [*rests, *helds][which]
        partly = [(c.held, side) for c, side in zip(helds, held, strict=True)] if chosen.rest else []
        return self._with_more(Course(chosen.rest, chosen.held, decay), [*sides, *held][which], partly)

    def _best(self, sides: Array) -> tuple[float, int, float]:
        """Of sides (N, k), each alone and with a peak of each decay: what is explained, which, and the decay."""
        S = self.apart(sides)
        ss, sy = np.maximum(np.sum(S**2, axis=0), _TINY), S.T @ self.y
        best = (float(np.max(sy**2 / ss)), int(np.argmax(sy**2 / ss)), _PEAK)
        for tau in _DECAYS:
            P = S - self.apart(self.late(sides, tau))
            pp, sp, py = np.sum(P**2, axis=0), np.sum(S * P, axis=0), P.T @ self.y
            # beside the side itself
            rest = np.maximum(pp - sp**2 / ss, _TINY * pp + 1e-300)
            gain = sy**2 / ss + (py - sp * sy / ss) ** 2 / rest
            at = int(np.argmax(gain))
            if gain[at] > best[0] + _CLEAR * self._scatter(gain[at]):
                best = float(gain[at]), at, tau
        return best

    def _scatter(self, explained: float) -> float:
        """Mean square of what stays."""
        return max(float(self.y @ self.y) - explained, 0.0) / len(self.y)

    def _with_more(self, course: Course, side: Array, helds: Sequence[tuple[float, Array]]) -> Course:
        """With a loop that takes its time, a part that is held, Stribeck's excess and a part that grows with the load, where they
        are clear.
        """
        own = [side, side - self.late(side, course.decay)]
        quick, column = self._further(
            own, [(q, side - self.late(side, q)) for q in _QUICK if q < _APART * course.decay]
        )
        own += [] if column is None else [column]
        held, column = self._further(own, helds)
        own += [] if column is None else [column]
        falls = [w * self.scale for w in _FALLS if w * self.scale > course.rest]
        more = [(f, side * np.exp(-((self.v / f) ** 2))) for f in falls]
        fall, column = self._further(own, more)
        own += [] if column is None else [column]
        full = float(self.torque.max(initial=0.0))
        loads = [(full, side * self.torque / full)] if np.ptp(self.torque) > _PART * full else []
        load, _ = self._further(own, loads)
        return Course(course.rest, course.held or held, course.decay, quick, fall, load)

    def _further(self, own: Sequence[Array], more: Sequence[tuple[float, Array]]) -> tuple[float, Array | None]:
        """The one of further columns that explains most beside some, and its name; 0 and None where none clearly does."""
        Q = np.linalg.qr(self.apart(np.concatenate(own, axis=1)))[0]
        taken = Q.T @ self.y
        explained = float(taken @ taken)
        best: tuple[float, float, Array | None] = (0.0, 0.0, None)
        for name, column in more:
            z = self.apart(column)[:, 0]
            z = z - Q @ (Q.T @ z)
            gain = float(z @ self.y) ** 2 / max(float(z @ z), _TINY * float(np.sum(column**2)) + 1e-300)
            if gain > best[0]:
                best = gain, name, column
        clear = best[0] > max(_CLEAR * self._scatter(explained + best[0]), _PART * explained)
        return (best[1], best[2]) if clear else (0.0, None)
