"""Shapes of the unknown that the names do without: fitted beside them, they take a share of what a name does, or cancel it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camrob.gap.evidence.model import Model, members_of
from camrob.gap.evidence.shrink import Trial, shrinkage
from camrob.gap.verdict.belief import BELIEF

__all__ = ["without_idle_shapes"]


def without_idle_shapes(model: Model, trial: Trial) -> Model:
    """The model without shapes of the unknown in its best set, where the names take far more from withheld samples beside the
    shapes than the shapes beside the names. What then stays is described by where it is found, not by a shape.
    """
    shapes = members_of(model, "unknown")
    bare = model.best.members - shapes
    effects = model.evidence.effects_of(bare)
    if not shapes or not effects:
        return model
    unnamed = frozenset(i for i in model.best.members if model.units[i].effect not in effects)
    whole, by_names, by_shapes = (shrinkage(model, trial, m, m).rms_after for m in (model.best.members, bare, unnamed))
    shapes_take, names_take = (float(np.sqrt(max(rms**2 - whole**2, 0.0))) for rms in (by_names, by_shapes))
    return replace(model, best=model.fit(bare)) if names_take >= BELIEF.idle * shapes_take else model
