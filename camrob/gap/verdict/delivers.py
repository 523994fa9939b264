"""Of what a name moves the tool by on samples that took no part, the share that it takes there.

A true cause, rightly described, takes all of the energy by which it moves the tool there, when it is taken away last. A likeness
takes 2 r - 1 of it, where r is the share of what is at work that it still shows: little of it or less than none where it moves
the tool otherwise. What takes far more than it moves is fitted too small, or something like it works beside it. So this asks the
same of every machine, however an effect is described on it, and whatever the evidence where it was fitted.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from camrob.gap.evidence.evidence import COUNTS_FROM
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.shrink import Shrinkage, Trial, settled_rms, shrinkage
from camrob.gap.verdict.at_drives import behind_encoders, without_drives_rest
from camrob.gap.verdict.belief import BELIEF

__all__ = ["delivered", "held_to_delivery", "restored", "taken", "taken_last"]


def taken(last: Shrinkage) -> float:
    """Share of the energy by which what is taken away moves the tool on withheld samples, that it takes there: about 1 of true
    causes.
    """
    before, after, moved = (float(np.sum(e**2)) for e in (last.before, last.after, last.before - last.after))
    return (before - after) / max(moved, 1e-30)


def taken_last(
    model: Model, trial: Trial, names: Collection[str], drives: Collection[str] = ()
) -> dict[str, Shrinkage]:
    """Of each of these effects that is in the best set, withheld samples before and after it is taken away, all others before it.
    drives: those that are judged between the ends of the drives, which the logs tell; what works behind the encoders alone is
    judged without what nothing explains there.
    """
    members, found = model.best.members, dict[str, Shrinkage]()
    asked = model.evidence.effects_of(members).intersection(names)
    there, behind = asked.intersection(drives), asked.intersection(behind_encoders(model))
    for own, on in ((asked - there - behind, trial), (there, trial), (behind, without_drives_rest(model, trial))):
        if not own:
            continue
        whole = shrinkage(model, on, members, at_drives=own is there)
        for name in own:
            others = frozenset(i for i in members if model.units[i].effect != name)
            last = shrinkage(model, on, members, others, at_drives=own is there)
            found[name] = Shrinkage(last.after, whole.after, whole.block)
    return found


def delivered(model: Model, trial: Trial, names: Collection[str], drives: Collection[str] = ()) -> dict[str, float]:
    """Of each of these effects that is in the best set, what it takes of what it moves, all others taken away before it."""
    return {n: taken(last) for n, last in taken_last(model, trial, names, drives).items()}


def held_to_delivery(
    model: Model, trials: Sequence[Trial], probability: Mapping[str, float], drives: Collection[str] = ()
) -> dict[str, float]:
    """Probabilities of effects, none surer than by what each takes of what it moves on every trial; and in doubt where it moves
    the tool by no more than an effect does that counts as absent.
    """
    claims = [n for n, p in probability.items() if p >= 0.5]
    shares = [delivered(model, trial, claims, drives) for trial in trials]
    held = dict(probability)
    for name in claims:
        held[name] = min([held[name], *(BELIEF.delivers(s[name]) for s in shares if name in s)])
        if settled_rms(model, model.panels, [name]) < COUNTS_FROM * model.noise:
            held[name] *= BELIEF.doubtful
    return held


def restored(
    model: Model,
    trials: Sequence[Trial],
    probability: Mapping[str, float],
    ruled_out: Collection[str],
    drives: Collection[str] = (),
) -> dict[str, float]:
    """Probabilities of effects, of which those that are doubted, beside a shape of the unknown or as more stays than was
    predicted, are likely again where each takes what a true cause does on named withheld logs and on blocks: a likeness does
    not. Not those that are ruled out.
    """
    inside = model.evidence.effects_of(model.best.members)
    found = {n: sum(p for names, p in model.sets.items() if n in names) for n in inside.intersection(probability)}
    asked = [n for n, p in found.items() if probability[n] < 0.5 <= BELIEF.effect(p) and n not in ruled_out]
    if not asked or not any(trial.named for trial in trials):
        return dict(probability)
    shares = [delivered(model, trial, asked, drives) for trial in trials]
    sure = [n for n in asked if min(BELIEF.delivers(s[n]) for s in shares) == BELIEF.surest]
    return {**probability, **{n: min(BELIEF.likely, BELIEF.effect(found[n])) for n in sure}}
