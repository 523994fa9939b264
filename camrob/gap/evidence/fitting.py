"""Which values are reported: those fitted beside the discrepancy, or those fitted without it.

Who is at work is asked beside the discrepancy, as nothing else keeps a cause from taking the place of what the library lacks. A
value that is to be taken away elsewhere is another question: where the discrepancy holds a part of what a true cause does, the
cause comes out too small, and the discrepancy, which takes no credit, is left behind (Liu, Bayarri and Berger, Bayesian Analysis
4, 2009, 119, on keeping modules of a model apart). Neighbourhoods of posture that took no part say which of the two takes more
away.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camrob.gap.evidence.model import Model
from camrob.gap.evidence.shrink import Shrinkage, Trial, shrinkage
from camrob.gap.evidence.temperature import temperatures

__all__ = ["leaves_less", "with_fitting"]

# standard errors: at one, the lean of a simulated case with a field moved away from the true one (its gain is 1.8); a UR10's gain
# is 2.9 to 5
_ERRORS = 2.0
_TURNS = 3  # in which values and the temperature that they leave are found in turn


def with_fitting(model: Model, blocks: Trial) -> Model:
    """The model with the values of its best set fitted with the discrepancy, or without it where that surely leaves less of the
    blocks that a fit left out, by the error of the difference among them.
    """
    beside = _holding_best(replace(model, heat_alone=None))
    if model.evidence.field is None or model.evidence.sizes is None or not model.evidence.sizes.any():
        return beside
    alone = _alone(beside)
    held, free = (shrinkage(m, blocks, m.best.members) for m in (beside, alone))
    return alone if leaves_less(free, held) else beside


def leaves_less(one: Shrinkage, other: Shrinkage) -> bool:
    """True where one way to fit surely leaves less of the same withheld samples than another, by the error of the difference
    among their blocks.
    """
    gains = np.array(
        [
            np.sum(other.after[other.block == b] ** 2) - np.sum(one.after[one.block == b] ** 2)
            for b in np.unique(one.block)
        ]
    )
    return float(gains.sum()) > _ERRORS * float(gains.std() * np.sqrt(len(gains)))


def _alone(model: Model) -> Model:
    """The model with values fitted without the discrepancy, at the temperature that the rest, which now holds it, has."""
    nothing = np.zeros((len(model.basis.part), 6))
    for _ in range(_TURNS):
        heat = temperatures(model.panels, model.best.mean, nothing)[0]
        model = _holding_best(replace(model, heat_alone=max(heat, model.evidence.temperature)))
    return model


def _holding_best(model: Model) -> Model:
    return replace(model, best=model.fit(model.best.members))
