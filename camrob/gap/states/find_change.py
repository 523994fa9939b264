"""What may have changed between logs, or at a moment of one: each change of each effect, by the comparison's own evidence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import Effect, Unit
from camrob.gap.effects.measurement_drift import APART, JUMP, SLIP
from camrob.gap.effects.measurement_drift import EFFECT as DRIFT
from camrob.gap.evidence.comparison import unit_name
from camrob.gap.evidence.evidence import Evidence, Fitted
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.search import explore
from camrob.gap.evidence.unknown import UNKNOWN
from camrob.gap.nuisances import NUISANCE
from camrob.gap.observation.scene import Scene
from camrob.gap.states.change import Change
from camrob.gap.states.later_effect import base_name, name_since
from camrob.gap.states.later_rows import Stretches, stretches_of, with_later

__all__ = ["FRAME", "TARGET", "Lead", "find_change"]

Array = NDArray[np.float64]

FRAME, TARGET = "frame_elsewhere", "target_elsewhere"
"""What is called so while moments are looked for: the instrument, or the robot's foot, elsewhere; the tool, or its target."""

_SIDES = {"left": FRAME, "right": TARGET}
_WORTH = 6.0  # log units, by which a set with a change has to be better than the best without
_NEAR = 6.0  # log units, within which another set is nearly as good
_MOMENTS = 100  # of a log, at which something may become another
_CUTS = 24  # moments, that are tried at the most before the best is looked at closely
_LOOKED = 3  # changes between logs, that are looked at closely
_STAYS = 0.5  # of the noise: where less stays, and nothing nameless explains it, no log is looked through for moments


@dataclass(frozen=True)
class Lead:
    """A change, the effects that came with it, each with its axis, those of sets that are nearly as good, and what is at work
    beside it (names of units); how many changes could have been picked, and the log units that it is better by.
    """

    change: Change
    came: frozenset[tuple[str, str]]
    rivals: frozenset[str]
    beside: frozenset[str]
    choices: int
    gain: float


def find_change(model: Model, effects: Sequence[Effect]) -> Lead | None:
    """The change that explains the logs best by far, None where none does. effects: those that may change."""
    looked = _Looked(model, effects)
    leads = [looked.lead(change, choices) for change, choices in looked.changes()]
    best = max(leads, key=lambda lead: lead.gain, default=None)
    return best if best is not None and best.gain > _WORTH and best.came else None


def _between_logs(model: Model) -> tuple[Change, ...]:
    """Changes that may have come between logs, which stand in the order in which they were made: from one on, or in one alone.
    Where LOG.toml names states, only where these change.
    """
    scenes = model.scenes
    names, told = [s.name for s in scenes], [s.log.info.state for s in scenes]
    if any(told):
        at = [k for k in range(1, len(names)) if told[k] != told[k - 1]]
        return tuple(_since(scenes, k, frozenset(told[k:]) - frozenset(told[:k])) for k in at)
    alone = [
        Change(n, frozenset(), frozenset(names) - {n}, before=before, now=False) for before, n in pairwise(names[:-1])
    ]
    return (*(_since(scenes, k, frozenset()) for k in range(1, len(names))), *alone)


def _since(scenes: Sequence[Scene], first: int, states: frozenset[str]) -> Change:
    names, day = [s.name for s in scenes], scenes[first].log.info.recorded
    later, earlier, before = frozenset(names[first + 1 :]), frozenset(names[:first]), names[first - 1]
    return Change(names[first], later, earlier, states=states, before=before, recorded=day)


class _Glance(NamedTuple):
    """A change, the evidence with what it may have brought, the best set there without that, the unit that adds most to it (-1
    for none), and by how many log units that is better.
    """

    gain: float
    change: Change
    evidence: Evidence
    fitted: Fitted
    unit: int


class _Looked:
    """A comparison whose effects are asked one change after the other."""

    def __init__(self, model: Model, effects: Sequence[Effect]) -> None:
        self.model = model
        # these are found again, each at its best moment
        self.nameless = frozenset(
            i
            for i, u in enumerate(model.units)
            if u.effect == UNKNOWN.name or u.key.startswith((f"{JUMP} ", f"{SLIP} "))
        )
        self.members = model.best.members - self.nameless
        names = {e.name for e in effects}
        self._sides = {e.name: _SIDES[e.side] for e in effects if e.side}
        self._at_moment = [i for i, u in enumerate(model.units) if u.effect in names or _of_frame(u)]
        # an instrument that stood elsewhere on one log is a unit of its own
        apart = any(u.key.startswith(APART) for u in model.units)
        frames = {n for n, side in self._sides.items() if side == FRAME} if apart else set()
        self._between = [
            i for i in self._at_moment if not _of_frame(model.units[i]) and model.units[i].effect not in frames
        ]
        self.stretches: Stretches = stretches_of(model)

    def changes(self) -> list[tuple[Change, int]]:
        """What may have changed, each with how many of effects and moments could have been picked."""
        between = _between_logs(self.model)
        choices = 1 if any(s.log.info.state for s in self.model.scenes) else len(between)
        if len(between) > _LOOKED:
            between = tuple(sorted(between, key=lambda c: -self._glance(c, choices).gain)[:_LOOKED])
        found = [(c, choices) for c in between]
        moment = self._moment()
        return found if moment is None else [*found, (moment, _MOMENTS)]

    def lead(self, change: Change, choices: int) -> Lead:
        """What a change explains, with the effects of the best set that holds it."""
        evidence, named = self._wide(change, self._later(change), choices)
        found = explore(evidence, (self.members,))
        first = len(self.model.units)
        # a name for what changed is held to other names: what has none, may be this
        scores = {m: score for m, score in found.scores.items() if not self.nameless & m}
        without = max(score for members, score in scores.items() if all(i < first for i in members))
        best = max(scores, key=lambda m: scores[m])
        own = [named[i - first] for i in best if i >= first]
        near = {i for m, score in scores.items() if score > scores[best] - _NEAR for i in m if i >= first}
        old = (i for i in best - self.model.evidence.always if i < first)
        return Lead(
            change,
            frozenset((base_name(u.effect), u.axis) for u in own),
            frozenset(base_name(named[i - first].effect) for i in near),
            frozenset(unit_name(self.model.units[i]) for i in old),
            choices,
            scores[best] - without,
        )

    def _later(self, change: Change) -> NDArray[np.bool_]:
        """(B,) stretches of the later state."""
        courses = [change.course(s) for s in self.model.scenes]
        s = self.stretches
        return np.array([bool(courses[k][f]) for k, f in zip(s.log, s.first, strict=True)])

    def _wide(self, change: Change, later: NDArray[np.bool_], choices: int) -> tuple[Evidence, list[Unit]]:
        """The evidence with what a change may have brought, and that."""
        units = self._units(change)
        named = [
            Unit(self._named(u, change), u.axis, u.parameters, u.choices * choices, u.key)
            for u in (self.model.units[i] for i in units)
        ]
        return replace(self.model.evidence, design=with_later(self.stretches, later, units, named)), named

    def _named(self, unit: Unit, change: Change) -> str:
        """What a unit is called that came by a change: at a moment it is all one which of two things that show the same moved."""
        name = unit.effect
        if name == NUISANCE:
            name = _SIDES["left" if unit.key.startswith("left") else "right"]
        elif change.at is not None:
            name = self._sides.get(name, name)
        return name_since(name, change)

    def _moment(self) -> Change | None:
        """The moment of a log from which on one effect explains most that else stays, None where nothing stays."""
        model, s = self.model, self.stretches
        drifts = any(model.units[i].effect == DRIFT.name for i in model.best.members)
        stays = (
            drifts
            or self.members < model.best.members
            or float(np.hypot(model.discrepancy, model.excess)) > _STAYS * model.noise
        )
        cuts = [b for b in range(1, len(s.log)) if s.log[b] == s.log[b - 1]] if stays else []
        cuts = cuts[:: max(1, -(-len(cuts) // _CUTS))]
        glances = [self._glance(self._from(int(s.log[b]), int(s.first[b])), _MOMENTS) for b in cuts]
        best = max(glances, key=lambda g: g.gain, default=None)
        return None if best is None or best.unit < 0 else self._refined(best)

    def _glance(self, change: Change, choices: int) -> _Glance:
        """What one unit that a change brought adds to the best set."""
        evidence, _ = self._wide(change, self._later(change), choices)
        fitted = evidence.fit(self.members)
        units, scores, _ = evidence.changes(fitted)
        new = np.flatnonzero(units >= len(self.model.units))
        if not len(new):
            return _Glance(-np.inf, change, evidence, fitted, -1)
        first = new[np.argmax(scores[new])]
        return _Glance(float(scores[first]) - fitted.score, change, evidence, fitted, int(units[first]))

    def _from(self, log: int, row: int) -> Change:
        """The change before a row (from 0) of a log: all logs behind it are of the later state."""
        scenes = self.model.scenes
        names, t = [s.name for s in scenes], scenes[log].t
        at = float(0.5 * (t[row - 1] + t[row]))
        later, earlier, day = frozenset(names[log + 1 :]), frozenset(names[:log]), scenes[log].log.info.recorded
        return Change(names[log], later, earlier, at=at, row=row + 1, recorded=day)

    def _refined(self, glance: _Glance) -> Change:
        """The row, within a stretch of the moment, before which what came explains least and behind which most."""
        model, s, change, evidence, unit = self.model, self.stretches, glance.change, glance.evidence, glance.unit
        log = [x.name for x in model.scenes].index(change.log)
        whole = evidence.fit(glance.fitted.members | {unit})
        first = len(model.units)
        old = whole.mean[: len(model.design.owner)]
        new = np.zeros_like(old)
        new[model.design.owner == self._units(change)[unit - first]] = whole.mean[evidence.design.owner == unit]
        p = model.panels[log]
        field, sizes = evidence.field, evidence.sizes
        smooth = (
            0.0 if field is None or sizes is None or p.smooth is None else p.smooth @ field.fitted(whole.mean, sizes)
        )
        without = p.y_tcp - p.twists(old) - smooth
        energy = _squares(without * p.w_tcp) - _squares((without - p.twists(new)) * p.w_tcp)
        if p.servo is not None and p.y_servo is not None and p.w_servo is not None:
            drives = p.y_servo - p.errors(old)
            energy += _squares(drives * p.w_servo) - _squares((drives - p.errors(new)) * p.w_servo)
        at = int(np.searchsorted(s.first[s.log == log], change.row - 1))
        firsts = [*s.first[s.log == log].tolist(), len(p.scene)]
        low, high = max(firsts[max(at - 1, 0)], 1), firsts[min(at + 1, len(firsts) - 1)]
        gained = np.cumsum(energy[::-1])[::-1]  # by all rows from one on
        return self._from(log, low + int(np.argmax(gained[low:high])))

    def _units(self, change: Change) -> list[int]:
        return self._between if change.at is None else self._at_moment


def _of_frame(unit: Unit) -> bool:
    return unit.effect == NUISANCE and unit.key.startswith(("left", "right"))


def _squares(x: Array) -> Array:
    return np.asarray(np.sum(np.nan_to_num(x) ** 2, axis=1))
