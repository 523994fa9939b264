"""Names of which nothing shows but what comes with them: a track that is nowhere bent, only elsewhere."""

from __future__ import annotations

import numpy as np

from camrob.gap.evidence.model import Model

__all__ = ["only_companions"]

_OWN = 0.05  # share of its energy that a name has to show of its own
_CHANCE = 2.0  # squares of a standard error a direction, that chance alone brings about half as often as not
_RANK = 1e-6  # of the largest energy: a direction that moves the tool by less is none


def only_companions(model: Model) -> dict[str, str]:
    """Effects of the best set, and the reason, whose pattern but for a share of its energy is that of parameters that only come
    with the others: these are other causes' as well. So is what shows beside these and stands no farther out than chance: of the
    slopes of a rail, which open frames take up, nothing is known, and nothing is to be concluded.
    """
    found = {}
    inside = np.isin(model.design.owner, sorted(model.best.members))
    for name in model.evidence.effects_of(model.best.members):
        mine = inside & np.array([model.units[o].effect == name for o in model.design.owner])
        own = np.flatnonzero(mine)
        beside = np.array([model.design.parameters[k].beside for k in own])
        if not beside.any():
            continue
        M, v = model.design.moves, model.best.mean[own]
        others = np.concatenate([own[beside], np.flatnonzero(inside & ~mine)])
        shown = np.linalg.lstsq(M[np.ix_(others, others)], M[np.ix_(others, own)], rcond=_RANK)[0]
        rest = M[np.ix_(own, own)] - M[np.ix_(own, others)] @ shown  # of what those don't show
        energies, ways = np.linalg.eigh(0.5 * (rest + rest.T))
        clear = energies > _RANK * max(float(energies[-1]), 1e-300)
        ways = ways[:, clear] * np.sqrt(energies[clear])
        z, cov = ways.T @ v, ways.T @ model.best.spread.block(own) @ ways
        squares = float(z @ np.linalg.lstsq(cov, z, rcond=_RANK)[0])
        least = _OWN * float(v @ M[np.ix_(own, own)] @ v)
        if float(z @ z) < least or squares < _CHANCE * len(z):
            found[name] = "all that shows of it is constant, as of other causes"
    return found
