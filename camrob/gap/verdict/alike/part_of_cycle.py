"""Effects of whose pattern the logs show a part, which may be any smooth function, and what such a one leaves in doubt."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.model import Model, effect_rms, members_of
from camrob.gap.verdict.belief import BELIEF

__all__ = ["energy_of", "partly_seen"]

Set = frozenset[int]

_SMOOTH = frozenset({"position", "load"})  # regimes of what changes with posture as a part of a cycle does


def partly_seen(model: Model, library: Sequence[Effect]) -> list[str]:
    """Effects of the best set of whose pattern these logs show a part, in most of what they move the tool by; and those beside
    them that follow position and move it less, or load and don't move it far more: a part of a cycle is any smooth function, and
    what one name and such a function explain together may be another's.
    """
    found = []
    for effect in library:
        own = members_of(model, effect.name)
        parts = frozenset(i for i in own if not effect.whole(model.scenes, model.units[i], model.states[effect.name]))
        energy = [energy_of(model, members) for members in (parts, own - parts)]
        if parts and energy[0] > energy[1]:
            found.append(effect.name)
    part = max((effect_rms(model, model.panels, n) for n in found), default=0.0)
    # gravity's pull is a part of a cycle itself
    enough = {
        e.name: BELIEF.far_more * part if "load" in e.regimes else part for e in library if _SMOOTH & {*e.regimes}
    }
    return found + [n for n, m in enough.items() if n not in found and 0.0 < effect_rms(model, model.panels, n) < m]


def energy_of(model: Model, members: Set) -> float:
    """m2, summed over all samples, by which some units move the TCP."""
    return sum(float(np.sum(p.moves(model.values(members, model.best)) ** 2)) for p in model.panels)
