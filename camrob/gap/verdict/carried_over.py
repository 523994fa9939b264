"""Names that take from named withheld logs, whose postures lie far off, what they should: no likeness does."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from camrob.gap.evidence.far_off import distance_of
from camrob.gap.evidence.model import Model, members_of
from camrob.gap.evidence.shrink import Trial, settled, shrinkage

__all__ = ["carried_over"]

_FAR = 0.5  # rad to the nearest fitted posture (median), from which what only looked alike no longer does
# of the energy by which a name moves the tool there, that it has to take at the least, and may at the most: a cause takes all of
# it, and what takes far more is fitted too small, or not alone
_DELIVERED, _MOST = 0.8, 1.6
_DRAWS, _SURE = 400, 0.05  # of blocks, for bounds; quantile of the lower one


def carried_over(model: Model, trial: Trial, names: Collection[str]) -> frozenset[str]:
    """Those of some effects of the best set that surely take from withheld samples, when they are taken away last, nearly all the
    energy by which they move the tool there; none where no logs are named, or their postures were fitted or lie near those.

    What only looked like a cause where it was fitted moves the tool otherwise elsewhere: of the energy by which it does, what it
    takes is 2 r - 1 where r is the share of the cause that it still shows.
    """
    if not names or not trial.named or distance_of(model, trial) < _FAR:
        return frozenset()
    whole = shrinkage(model, trial, model.best.members)
    blocks, found = np.unique(whole.block), []
    draws = np.random.default_rng(0).integers(0, len(blocks), (_DRAWS, len(blocks)))
    for name in names:
        own = members_of(model, name)
        last = shrinkage(model, trial, model.best.members, model.best.members - own)
        values = model.values(own, model.best)
        moved = np.concatenate(
            [settled(model, trial.panels[k], rows, trial.panels[k].moves(values, rows)) for k, rows, _ in trial.asked]
        )
        taken, moves = (
            np.array([float(e[whole.block == b].sum()) for b in blocks])[draws].sum(axis=1)
            for e in (np.sum(last.after**2 - whole.after**2, axis=1), np.sum(moved**2, axis=1))
        )
        low, high = np.quantile(taken / np.maximum(moves, 1e-30), [_SURE, 1.0 - _SURE])
        if _DELIVERED < low and high < _MOST:
            found.append(name)
    return frozenset(found)
