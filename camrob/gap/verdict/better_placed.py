"""Names that are not sure, held to one place without a name: where it foretells far more of the gap, they are its likenesses.

A tool that is loose on its flange is compliance and a payload, a screw that warms up is an instrument that drifts and has another
scale: each takes some of the gap, and leaves far more of it than one part that moves as nobody has described.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from camrob.gap.effects.common import arm_axes
from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import Model, whole_gap
from camrob.gap.evidence.shrink import Trial
from camrob.gap.evidence.unknown import LOAD
from camrob.gap.locate.likely_part import likely_part
from camrob.gap.verdict.belief import BELIEF
from camrob.gap.verdict.remains import ARM, claims, left_everywhere, stage_of

__all__ = ["better_placed"]

_FAR_LESS = 0.75  # of the energy that the names leave, that the place may leave of samples that it was not fitted to
_BEYOND = 1.0  # times the noise's energy, that the names have to leave for a place to be asked


def better_placed(
    model: Model, trial: Trial, probability: Mapping[str, float], drives: Collection[str]
) -> tuple[str, ...]:
    """Claims that are likely and no more, and of which one place without a name foretells far more than they take, fitted as they
    are: of what those leave that are sure. drives: effects between set-point and encoder, which stand in logs and are not held.
    """
    unsure = [n for n, p in probability.items() if 0.5 <= p <= BELIEF.likely]
    if not unsure or set(unsure) & set(drives):
        return ()
    kept = claims(model, {n: p for n, p in probability.items() if p > BELIEF.likely})
    before, after = (left_everywhere(model, m, trial) for m in (kept, claims(model, probability)))
    if stage_of(before, model) != ARM:
        return ()
    left, noise = _energy(after, model.noise), _energy(before, 0.0) - _energy(before, model.noise)
    if left < _BEYOND * noise:
        return ()
    # any function of postures is broader than a name that follows the load
    part = likely_part(before, model.noise, but="position")
    # what tips the first axis by its load is the foot, which has its names
    foot = arm_axes(model.scenes[0].cell)[:1]
    if part is None or (part.follows == LOAD and part.moves in foot):
        return ()
    if 1.0 - part.share > _FAR_LESS * left / _energy(before, model.noise):
        return ()
    return tuple(unsure)


def _energy(panels: Sequence[Panel], noise: float) -> float:
    """m2 of a gap about its mean, beyond the noise."""
    gap = np.concatenate([whole_gap(p)[p.w_tcp[:, 0] > 0.0] for p in panels])
    return float(np.sum((gap - gap.mean(axis=0)) ** 2)) - len(gap) * noise**2
