"""Names of which nothing shows but what comes with them: a track that is nowhere bent, only elsewhere."""

from __future__ import annotations

import numpy as np

from camrob.gap.evidence.model import Model

__all__ = ["only_companions"]

_OWN = 0.05  # share of its energy that a name has to show of its own
_CHANCE = 2.0  # times the energy that the fit leaves open, from which it shows


def only_companions(model: Model) -> dict[str, str]:
    """Effects of the best set, and the reason, whose pattern but for a share of its energy is that of parameters that only come
    with the others: these are other causes' as well.
    """
    found = {}
    for name in model.evidence.effects_of(model.best.members):
        own = np.flatnonzero(
            [model.units[o].effect == name and int(o) in model.best.members for o in model.design.owner]
        )
        beside = np.array([model.design.parameters[k].beside for k in own])
        if not beside.any():
            continue
        G, v = model.design.moves[np.ix_(own, own)], model.best.mean[own]
        shown = np.linalg.lstsq(G[np.ix_(beside, beside)], G[beside], rcond=None)[0]
        rest = G - G[:, beside] @ shown  # of what those don't show
        spread = float(np.trace(rest @ model.best.spread.block(own)))
        if v @ rest @ v < max(_OWN * float(v @ G @ v), _CHANCE * spread):
            found[name] = "all that shows of it is constant, as of other causes"
    return found
