"""Names and sets that withheld samples, or what a machine can have, speak against: they are withdrawn, or in doubt."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.model import Model, effect_rms, members_of
from camrob.gap.evidence.predicted import expected, stays_where_fitted
from camrob.gap.evidence.shrink import Shrinkage, Trial, doubt_of_shrinkage, shrinkage
from camrob.gap.verdict.at_drives import at_drives, behind_encoders, without_drives_rest
from camrob.gap.verdict.belief import BELIEF
from camrob.gap.verdict.beside_more import SMOOTH, gains
from camrob.gap.verdict.carried_over import carried_over
from camrob.gap.verdict.plausible import implausible
from camrob.gap.verdict.remains import claims

__all__ = ["held_to_prediction", "take_nothing", "without_harmful", "without_implausible", "worse", "worse_together"]

_TRIES = 3  # times that sets without what is implausible are fitted anew
_LIKELY = 0.02  # of the sets' probability that must be left for that
_NO_HARM = 0.1  # of the noise's energy, by which withheld samples may be worse where another name shows nearly the same
_TOO_SMALL = 1e-3  # share of an energy below which a part of it doesn't matter
_LEAST_TAKEN = 0.03  # of withheld samples' rms, that all claims together have to take


def without_implausible(model: Model) -> Model:
    """The model without sets whose best fit has values that no machine has, where a likely enough set does without them."""
    for _ in range(_TRIES):
        bad = set(implausible(model))
        rest = {names: p for names, p in model.sets.items() if not names & bad}
        total = sum(rest.values())
        if not bad or total < _LIKELY:
            return model
        left = {m: s for m, s in model.scores.items() if not model.evidence.effects_of(m) & bad}
        best = model.fit(max(left, key=lambda m: left[m]))
        model = replace(model, best=best, sets={names: p / total for names, p in rest.items()})
    return model


def without_harmful(model: Model, trial: Trial) -> Model:
    """The model with effects taken out that make the prediction of withheld samples worse than it is without them."""
    behind, quiet = behind_encoders(model), without_drives_rest(model, trial)
    for name in sorted(model.evidence.effects_of(model.best.members) - {"unknown"}):
        own, on = members_of(model, name), quiet if name in behind else trial
        rest = model.best.members - own
        with_it, without = (shrinkage(model, on, m, m) for m in (model.best.members, rest))
        gains = np.array(
            [
                float(np.sum(without.after[without.block == b] ** 2) - np.sum(with_it.after[with_it.block == b] ** 2))
                for b in np.unique(with_it.block)
            ]
        )
        error = float(gains.std()) * np.sqrt(len(gains))
        small = _NO_HARM * model.noise**2 * len(without.after)
        if gains.sum() < -max(error, small, _TOO_SMALL * float(np.sum(without.after**2))):
            sets: dict[frozenset[str], float] = {}
            for names, p in model.sets.items():
                kept = names - {name}
                sets[kept] = sets.get(kept, 0.0) + p
            model = replace(model, best=model.fit(rest), sets=sets)
    return model


def held_to_prediction(
    model: Model, trial: Trial, probability: Mapping[str, float], library: Sequence[Effect]
) -> dict[str, float]:
    """Probabilities held to named withheld logs: where far more stays there than the claims and the discrepancy predict, a name
    has not shown that it is more than a likeness; but for one that moves the tool there by far more than that, and those of the
    drives, where the logs hold both ends. Beside what stays beyond all that was predicted, of far postures too, a name is likely
    and no more where it moves the tool by less than ten times as much, whatever the fit leaves open: of play and a drive's
    friction whose encoder nobody logged, the one leaves of the other no more than that. What follows posture and carries
    over to far ones is no likeness.
    """
    members = claims(model, probability)
    if not members or not trial.named:
        return dict(probability)
    trial = without_drives_rest(model, trial)
    reached = shrinkage(model, trial, model.best.members, members)
    # what encoders scatter is in no gap, and still no surprise
    stays = max(model.noise**2 + model.excess**2, stays_where_fitted(model))
    near, beyond = (
        reached.rms_after**2 - expected(model, trial, members, far=far, stays=stays)[1] ** 2 for far in (False, True)
    )
    sure = at_drives(model, library)
    moved = {n: effect_rms(model, trial.panels, n) for n in probability if n not in sure}
    likely: frozenset[str] = frozenset()
    doubtful: frozenset[str] = frozenset()
    if BELIEF.surprised(near, model.noise, model.discrepancy, doubt_of_shrinkage(model, trial, members)):
        doubtful = frozenset(n for n, rms in moved.items() if rms < BELIEF.far_more * np.sqrt(near))
    if BELIEF.surprised(beyond, model.noise, model.discrepancy, 0.0):
        small = frozenset(n for n, rms in moved.items() if 0.0 < rms < BELIEF.farther * np.sqrt(beyond))
        smooth = {e.name for e in library if SMOOTH.issuperset(e.regimes)}
        likely = small - carried_over(model, trial, small & smooth)
    return {
        n: p * (BELIEF.doubtful if n in doubtful else BELIEF.part_seen if n in likely else 1.0)
        for n, p in probability.items()
    }


def worse(model: Model, trial: Trial, names: Sequence[str], drives: Collection[str]) -> list[str]:
    """Those effects that, taken away last, surely make withheld samples worse: claims to be withdrawn."""
    return [name for name, (_, most) in gains(model, trial, names, drives).items() if most < 0.0]


def worse_together(model: Model, trial: Trial, probability: Mapping[str, float]) -> list[str]:
    """Claims to be withdrawn, those first that help most by it, as long as all claims together surely make withheld samples
    worse: such as one that another, which is not claimed, cancels.
    """
    held, shrunk = dict(probability), partial(shrinkage, model, trial, model.best.members)
    withdrawn: list[str] = []
    while members := claims(model, held):
        together = shrunk(members)
        if together.interval()[1] >= 0.0:
            break
        withdrawn.append(_least_missed(model, members, _named(model, members), shrunk))
        held[withdrawn[-1]] = 0.0
    return withdrawn


def take_nothing(model: Model, trial: Trial, probability: Mapping[str, float], drives: Collection[str]) -> list[str]:
    """Claims to be withdrawn, those first of which least is missed, as long as all claims together take next to nothing from
    withheld samples: whatever they move, and however far their values stand out, it is seen nowhere but where they were fitted,
    or only beside names that are not claimed. drives: names that are judged between the drives' ends, once no others are left.
    """
    held, quiet = dict(probability), without_drives_rest(model, trial)
    withdrawn: list[str] = []
    while members := claims(model, held):
        names = _named(model, members)
        there = set(names) <= set(drives)
        shrunk = partial(shrinkage, model, trial if there else quiet, model.best.members, at_drives=there)
        together = shrunk(members)
        if together.rms_after < (1.0 - _LEAST_TAKEN) * together.rms_before:
            break
        judged = [n for n in names if there or n not in drives]
        withdrawn.append(_least_missed(model, members, judged, shrunk))
        held[withdrawn[-1]] = 0.0
    return withdrawn


def _named(model: Model, members: frozenset[int]) -> list[str]:
    """The effects of units."""
    return sorted({model.units[i].effect for i in members})


def _least_missed(
    model: Model, members: frozenset[int], names: Sequence[str], shrunk: Callable[[frozenset[int]], Shrinkage]
) -> str:
    """Of effects the one without which the units that are claimed leave least of withheld samples."""
    after = {name: shrunk(members - members_of(model, name)).rms_after for name in names}
    return min(after, key=lambda n: after[n])
