"""Values of claims that stand beside names which are not claimed: fitted beside such a name, and taken away without it, a claim
that cancels it leaves more than it should.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from camrob.gap.evidence.fitting import leaves_less, with_fitting
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.shrink import Trial, shrinkage

__all__ = ["without_company"]


def without_company(model: Model, blocks: Trial, claimed: Collection[str]) -> Model:
    """The model with its best set one of the claims alone, where these, fitted so, surely leave less of the blocks that a fit
    left out than fitted beside names that are not claimed and stay. Which of two names is at work may be open, and neither
    claimed: the values of the others then have to stand without either.
    """
    inside = model.evidence.effects_of(model.best.members)
    if not claimed or inside <= set(claimed):
        return model
    own = frozenset(i for i in model.best.members if model.units[i].effect in claimed)
    met = [m for m in model.scores if model.evidence.effects_of(m) == inside & set(claimed)]
    bare = max(met, key=lambda m: model.scores[m]) if met else own | model.evidence.always
    alone = with_fitting(replace(model, best=model.fit(bare)), blocks)
    beside = shrinkage(model, blocks, model.best.members, own)
    return alone if leaves_less(shrinkage(alone, blocks, bare, bare), beside) else model
