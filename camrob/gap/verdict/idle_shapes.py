"""Shapes of the unknown that the names do without: fitted beside them, they take a share of what a name does, or cancel it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camrob.gap.evidence.model import Model
from camrob.gap.evidence.shrink import Trial, shrinkage
from camrob.gap.verdict.belief import BELIEF

__all__ = ["without_idle_shapes"]


def without_idle_shapes(model: Model, trial: Trial) -> Model:
    """The model without shapes of the unknown in its best set, where the named effects alone take far more from withheld samples
    than the shapes take beside them. What then stays is told by where it is found, not by a shape.
    """
    shapes = frozenset(i for i in model.best.members if model.units[i].effect == "unknown")
    named = model.best.members - shapes
    if not shapes or not model.evidence.effects_of(named):
        return model
    whole, bare = (shrinkage(model, trial, m, m) for m in (model.best.members, named))
    by_shapes = float(np.sqrt(max(bare.rms_after**2 - whole.rms_after**2, 0.0)))
    by_names = float(np.sqrt(max(bare.rms_before**2 - bare.rms_after**2, 0.0)))
    return replace(model, best=model.evidence.fit(named)) if by_names >= BELIEF.far_more * by_shapes else model
