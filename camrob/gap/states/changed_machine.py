"""The comparison with what may have changed: one machine for all logs, or one that became another between or within them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from camrob.gap.effects.effect import Effect
from camrob.gap.effects.measurement_drift import EFFECT as DRIFT
from camrob.gap.effects.measurement_drift import JUMP, SLIP, at_moment, moment_key
from camrob.gap.evidence.comparison import compare, unit_name
from camrob.gap.evidence.model import Model
from camrob.gap.observation.scene import Scene
from camrob.gap.states.find_change import FRAME, TARGET, Lead, find_change
from camrob.gap.states.later_effect import base_name, can_change, since

__all__ = ["shown_in", "with_change"]

_LIKELY = 0.5  # probability of all sets that hold what came, from which a change stands
_KINDS = {FRAME: JUMP, TARGET: SLIP}


def with_change(model: Model, library: Sequence[Effect]) -> tuple[Model, list[Effect]]:
    """The comparison with the change that explains these logs best, and all effects with what came by it; itself and the library
    where one machine for all rows is as good.
    """
    lead = find_change(model, [e for e in library if can_change(e)])
    if lead is None:
        return model, list(library)
    more = tuple(since(e, lead.change, model.states[e.name], lead.choices) for e in _with_rivals(library, lead))
    effects, moments = _with_moments(library, lead)
    begun = frozenset(
        unit_name(u)
        for e in more
        for u in e.units(model.scenes, {**e.start, **e.begin(model.scenes)})
        if (base_name(e.name), u.axis) in lead.came
    )
    other = compare(model.scenes, [*effects, *more], begun | moments | lead.beside)
    new = {e.name for e in more}
    likely = sum(p for names, p in other.sets.items() if names & new or (moments and DRIFT.name in names))
    inside = {unit_name(other.units[i]) for i in other.best.members}
    if likely < _LIKELY or not (moments & inside or new & other.evidence.effects_of(other.best.members)):
        return model, list(library)
    return other, [*effects, *more]


def _with_rivals(library: Sequence[Effect], lead: Lead) -> list[Effect]:
    """The effects that came, those of nearly as good sets, and those that follow the same at the same stage: which of them it is,
    is seen when each has its own values.
    """
    came = [e for e in library if e.name in {name for name, _ in lead.came}]
    # what follows position is linear in its values, and was compared with all else
    kinds = {(e.stages, e.regimes) for e in came if "position" not in e.regimes}
    return [
        e for e in library if e in came or e.name in lead.rivals or (can_change(e) and (e.stages, e.regimes) in kinds)
    ]


def shown_in(scenes: Sequence[Scene], effects: Sequence[Effect]) -> bool:
    """Whether logs hold anything of the state that a change among these effects made; True without one. Logs of the state before
    it say nothing of it.
    """
    came = [e.since for e in effects if e.since is not None]
    return not came or any(c.shown_in(scenes) for c in came)


def _with_moments(library: Sequence[Effect], lead: Lead) -> tuple[list[Effect], frozenset[str]]:
    """The library whose instrument knows the moment at which it, or its target, moved, and names of units for that."""
    change, kinds = lead.change, [kind for name, kind in _KINDS.items() if (name, "") in lead.came]
    if change.at is None or not kinds:
        return list(library), frozenset()
    state: dict[str, float] = {}
    for kind in kinds:
        state |= at_moment(kind, change.at, change.row - 1, change.log, change.earlier)
    keys = [moment_key(kind, change.at, change.row - 1, change.log) for kind in kinds]
    effects = [replace(e, start={**e.start, **state}) if e.name == DRIFT.name else e for e in library]
    return effects, frozenset(f"{DRIFT.name}//{key}" for key in keys)
