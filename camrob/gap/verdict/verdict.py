"""The verdict on effects: probabilities, sizes, shrinkage on withheld samples, what stays, and what to do next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.aliases import alias_lists
from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.fitting import with_fitting
from camrob.gap.evidence.model import Model, effect_rms
from camrob.gap.evidence.predicted import foretold
from camrob.gap.evidence.regimes_withheld import regimes_withheld
from camrob.gap.evidence.shrink import Shrinkage, Trial, doubt_of_shrinkage, figures, shrinkage, trial_of
from camrob.gap.handover import Handover, hand_over
from camrob.gap.observation.two_encoders import motors_follow
from camrob.gap.pose_sets import frozen_frames
from camrob.gap.verdict.alike.own_course import off_course
from camrob.gap.verdict.alike.part_of_cycle import partly_seen
from camrob.gap.verdict.alike.partners import no_surer_than_partners
from camrob.gap.verdict.alike.simpler_kin import shown_by_simpler
from camrob.gap.verdict.alike.unsteady import unsteady
from camrob.gap.verdict.alike.wider import shown_by_wider
from camrob.gap.verdict.alternatives import alternatives
from camrob.gap.verdict.at_drives import (
    any_course,
    at_drives,
    behind_encoders,
    behind_motors,
    misread,
    not_told_apart,
    shaped_at_drives,
    without_drives_rest,
)
from camrob.gap.verdict.belief import BELIEF
from camrob.gap.verdict.beside_more import beside_more
from camrob.gap.verdict.better_placed import better_placed
from camrob.gap.verdict.delivers import held_to_delivery, restored
from camrob.gap.verdict.effects_found import effects_found
from camrob.gap.verdict.idle_shapes import without_idle_shapes
from camrob.gap.verdict.in_company import without_company
from camrob.gap.verdict.plausible import doubted_unless_clear, held_to_values, implausible, unknown_shapes
from camrob.gap.verdict.remains import (
    at_drive,
    beyond_noise,
    claims,
    left_everywhere,
    of_changing,
    remains,
    removed_share,
    residual_regimes,
)
from camrob.gap.verdict.withdrawn import (
    held_to_prediction,
    take_nothing,
    without_harmful,
    without_implausible,
    worse,
    worse_together,
)
from camrob.gap.verdict.within import BEYOND, Stage, drives_beyond, stages_within
from camrob.summaries.diagnosis_summary import Alternative, EffectFound, RegimeLeft, Residual, Together, Unknown
from camrob.units import m_to_mm

__all__ = ["Verdict", "judge_effects"]

Set = frozenset[int]

_DOUBTS = 3.0  # standard errors of the prediction that structure on withheld samples must exceed


@dataclass(frozen=True)
class Verdict:
    """model: without what is implausible or harms; claimed: effects with a probability of 0.5 or more; members: their units;
    shrunk: the gap on withheld samples without and with all of them; handed: what of them can be corrected; stages: what
    each is within; panels: the logs without what is claimed; the others as in the summary of a diagnosis.
    """

    model: Model
    claimed: tuple[str, ...]
    members: Set
    shrunk: Shrinkage
    handed: Handover
    status: str
    stages: Mapping[str, Stage]
    effects: tuple[EffectFound, ...]
    together: Together
    alternatives: tuple[Alternative, ...]
    unknown: Unknown
    aliases: tuple[tuple[str, ...], ...]
    residual: Residual
    panels: tuple[Panel, ...]


def judge_effects(model: Model, trial: Trial, library: Sequence[Effect], *, in_world: bool) -> Verdict:
    """All that is said of effects. in_world: the table's turning doesn't part the instrument's frame from the robot's."""
    blocks = frozen_frames(model, trial_of(model, ())) if trial.named else trial
    model = without_harmful(without_idle_shapes(with_fitting(without_implausible(model), blocks), blocks), blocks)
    if trial.named:
        model = without_harmful(model, trial)
    reasons = implausible(model)
    probability = {e.name: BELIEF.effect(p, impossible=e.name in reasons) for e, p in _evidence(model, library)}
    probability |= {n: probability[n] * BELIEF.part_seen for n in _likely_at_most(model, library)}
    believed = frozenset(n for n, p in probability.items() if p >= 0.5)
    model = without_company(with_fitting(_holding(model, believed), blocks), blocks, believed)
    drives = at_drives(model, library)
    contradicted = worse(model, trial, sorted(believed), drives)
    probability |= {n: probability[n] * BELIEF.impossible for n in contradicted}
    probability = held_to_prediction(model, trial, probability, library)
    behind = believed <= behind_encoders(model)
    together_worse = worse_together(model, without_drives_rest(model, trial) if behind else trial, probability)
    contradicted += together_worse
    probability |= {n: probability[n] * BELIEF.impossible for n in together_worse}
    members = claims(model, probability)
    together = shrinkage(model, trial, model.best.members, members)
    if members:
        probability = beside_more(model, trial, together, probability, library)
    trials = (trial, blocks) if trial.named else (trial,)
    held = held_to_delivery(model, trials, probability, drives)
    probability = doubted_unless_clear(model, restored(model, trials, held, [*reasons, *contradicted], drives))
    against = any_course(model, drives.intersection(n for n, p in probability.items() if p >= 0.5))
    probability |= {n: min(probability[n], BELIEF.unclear) for n in against}
    motors = {e.name for e in library if e.regimes != ("direction",)}
    not_drives = behind_motors(model, drives & motors, motors_follow(model.scenes))
    wrong = not_drives | misread(model, trial, together, drives)
    probability |= {n: probability[n] * BELIEF.impossible for n in wrong if n in probability}
    nothing = take_nothing(model, trial, probability, drives)
    probability |= {n: probability[n] * BELIEF.impossible for n in nothing}
    named = [n for n, p in probability.items() if p >= 0.5]
    if claims(model, probability) != members:
        # what was believed and is no more may have cancelled a part of what is
        model, members, together = _claimed_anew(model, trial, blocks, probability)
    wider = _classes(model, library, named)
    probability |= {n: min(probability[n], BELIEF.likely) for n in wider}
    changing = unsteady(model, library, named, drives)
    probability |= {n: min(probability[n], BELIEF.takes_else) for n in changing}
    probability = no_surer_than_partners(model, held_to_values(model, probability))
    if beaten := better_placed(model, trial, probability, drives):
        probability |= dict.fromkeys(beaten, BELIEF.unclear)
        model, members, together = _claimed_anew(model, trial, blocks, probability)
    return _said(
        model,
        trial,
        library,
        members,
        together,
        probability,
        reasons,
        wider,
        changing,
        in_world=in_world,
        placed=bool(beaten),
    )


def _claimed_anew(
    model: Model, trial: Trial, blocks: Trial, probability: Mapping[str, float]
) -> tuple[Model, Set, Shrinkage]:
    """The model fitted without the company of what is claimed; the units that are; the withheld gap without and with them."""
    model = without_company(model, blocks, frozenset(n for n, p in probability.items() if p >= 0.5))
    members = claims(model, probability)
    return model, members, shrinkage(model, trial, model.best.members, members)


def _said(
    model: Model,
    trial: Trial,
    library: Sequence[Effect],
    members: Set,
    together: Shrinkage,
    probability: Mapping[str, float],
    reasons: Mapping[str, str],
    wider: Mapping[str, Sequence[str]],
    changing: Mapping[str, str],
    *,
    in_world: bool,
    placed: bool,
) -> Verdict:
    """The verdict on what is believed: units claimed, how far they shrink the gap, what stays; placed: a place beats names."""
    structure, unknown, rest = _something_stays(model, trial, reasons)
    entries = effects_found(model, trial, library, probability, reasons, in_world, wider)
    claimed = tuple(e.effect for e in entries if e.claimed)
    regimes = residual_regimes(model, left := left_everywhere(model, members, trial))
    sets = alternatives(model.sets, probability)
    stages = stages_within(model.scenes, together, model.noise)
    within = {name: s.within for name, s in stages.items()}
    drive, words = drives_beyond(model.scenes, model.noise) if not claimed else ("", "")
    if claimed:
        unknown = _beside_claims(model, together, rest, sets, claimed)
    elif drive:
        unknown = max(unknown, BELIEF.read_off)
    else:
        unknown = _without_claims(model, together, unknown, sets, beyond=BEYOND in within.values())
    # a shape in the best set alone, while the sets beside it do without, is no finding
    shapes = unknown_shapes(model) if (unknown := max(unknown, 1.0 - BELIEF.unclear if placed else 0.0)) >= 0.5 else []
    unsure = [e for e in entries if e.claimed and e.probability <= BELIEF.likely]
    stays = remains(model, left, together, unknown, shapes, regimes, reasons, unsure)
    if claimed and stays.where.stage == "setpoint_to_encoder" and not at_drives(model, library).intersection(claimed):
        drive, words = drives_beyond(model.scenes, model.noise)
    if drive:
        stays = at_drive(stays, model, left, drive, words)
    elif unknown >= 0.5:
        stays = of_changing(stays, entries, changing)
    handed = hand_over(model, trial, claimed, members)
    return Verdict(
        model=model,
        claimed=claimed,
        members=members,
        shrunk=together,
        handed=handed,
        status=_status(within, claimed, stays),
        stages=stages,
        effects=entries,
        together=_together(model, trial, members, together, handed),
        alternatives=tuple(sets),
        unknown=stays,
        aliases=alias_lists(model.design, library, in_world),
        residual=_residual(model, together, structure, regimes),
        panels=tuple(left),
    )


def _residual(model: Model, together: Shrinkage, structure: float, regimes: Sequence[RegimeLeft]) -> Residual:
    """What stays beside all claims, in mm. structure: m of it that hangs together."""
    return Residual(
        rms_mm=m_to_mm(together.rms_after),
        noise_mm=m_to_mm(model.noise),
        structured_mm=m_to_mm(structure),
        discrepancy_mm=m_to_mm(model.discrepancy),
        structure=tuple(regimes),
    )


def _classes(model: Model, library: Sequence[Effect], named: Sequence[str]) -> dict[str, list[str]]:
    """Claimed effects, and those that these logs can't tell from each: a wider one first."""
    alike = shown_by_simpler(model, library, named)
    instead = not_told_apart(model, library, named)
    for effect in library:
        if effect.name in named and (others := [*effect.likewise(model.scenes), *instead.get(effect.name, ())]):
            alike[effect.name] = [*alike.get(effect.name, ()), *others]
    wider = {**dict.fromkeys(alike, ()), **shown_by_wider(model, library, named)}
    return {n: [*more, *alike.get(n, ())] for n, more in wider.items()}


def _beside_claims(
    model: Model, together: Shrinkage, rest: Shrinkage, sets: Sequence[Alternative], claimed: Sequence[str]
) -> float:
    """Probability that what stays beside the claims (`together`) is something unknown, but for what further names of `sets` may
    explain of it; rest: the gap with the likeliest of them taken away, too.
    """
    more = sum(a.probability for a in sets if set(claimed) < set(a.effects))
    by_claims, by_all = (BELIEF.matters(*beyond_noise(s, model.noise), model.noise) for s in (together, rest))
    return (1.0 - more) * by_claims + more * min(by_claims, by_all)


def _without_claims(
    model: Model, together: Shrinkage, unknown: float, sets: Sequence[Alternative], *, beyond: bool
) -> float:
    """Probability of something unknown where nothing is claimed, from that of the sets: where a stage is beyond its noise, what
    is believed of no name is believed of it; else it is that only as far as what stays matters.
    """
    if not beyond:
        return min(unknown, BELIEF.matters(*beyond_noise(together, model.noise), model.noise))
    inside = sum(p for names, p in model.sets.items() if names and "unknown" not in names)
    nothing_else = BELIEF.nothing_else if inside < 0.5 else 0.0
    return max(unknown, nothing_else, *(a.probability for a in sets if not a.effects))


def _together(model: Model, trial: Trial, members: Set, shrunk: Shrinkage, handed: Handover) -> Together:
    """All claims together: by how much the gap on withheld samples shrinks, and by how much it should."""
    blocks = frozen_frames(model, trial_of(model, ())) if trial.named else trial
    before, after = foretold(model, trial, blocks, members)
    return Together(
        **figures(shrunk).to_json(),
        withheld=trial.name,
        left_aside=trial.aside,
        predicted_shrink=1.0 - after / max(before, 1e-12),
        expected_after_mm=m_to_mm(after),
        removable_removed=removed_share(shrunk, model.noise),
        compensable_mm=handed.said.rms_before_mm - handed.said.rms_after_mm,
        regimes_withheld=tuple(regimes_withheld(model, members)),
    )


def _evidence(model: Model, library: Sequence[Effect]) -> list[tuple[Effect, float]]:
    """Effects and the probability of the sets that hold them. Beside a shape of the unknown, which has a place and may be what a
    name mimics, only one that moves the tool far more counts; of a shape, what is more than the discrepancy beside it.
    """
    shape = float(np.sqrt(max(effect_rms(model, model.panels, "unknown") ** 2 - model.discrepancy**2, 0.0)))
    apart = frozenset() if shaped_at_drives(model) else at_drives(model, library)
    found = []
    for effect in library:
        far = effect.name in apart or effect_rms(model, model.panels, effect.name) >= BELIEF.far_more * shape
        own = ((names, p) for names, p in model.sets.items() if effect.name in names)
        found.append((effect, sum(p for names, p in own if far or "unknown" not in names)))
    return found


def _likely_at_most(model: Model, library: Sequence[Effect]) -> set[str]:
    """Effects of whose pattern, or of whose course, these logs show that another's is as good."""
    return {*partly_seen(model, library), *off_course(model, library)}


def _something_stays(model: Model, trial: Trial, reasons: Mapping[str, str]) -> tuple[float, float, Shrinkage]:
    """m that hang together on withheld samples beyond the likeliest set of effects, the discrepancy switched off; the probability
    that something unknown is at work beside it; and the gap on withheld samples without and with that set.
    """
    top = max(model.sets, key=lambda names: model.sets[names])
    members = frozenset(i for i in model.best.members if model.units[i].effect in top - {"unknown"})
    whole = shrinkage(model, trial, model.best.members, members)
    structure, doubt = whole.structure(), doubt_of_shrinkage(model, trial, members)
    beyond = max(model.excess, model.discrepancy, float(np.sqrt(max(0.0, structure**2 - (_DOUBTS * doubt) ** 2))))
    stays = BELIEF.unknown(beyond / model.noise, whole.rms_after / max(whole.rms_before, 1e-12))
    shaped = sum(p for names, p in model.sets.items() if "unknown" in names)
    return structure, max(stays, shaped, BELIEF.nothing_else if reasons and not shaped else 0.0), whole


def _holding(model: Model, claimed: frozenset[str]) -> Model:
    """The model with the best set that holds all that is claimed, where one was met; without shapes of the unknown where the best
    set has none, as these were found idle.
    """
    inside = model.evidence.effects_of(model.best.members)
    if claimed <= inside:
        return model
    effects = {m: model.evidence.effects_of(m) for m in model.scores}
    held = [m for m, names in effects.items() if claimed <= names and not {"unknown"} & names - inside]
    return replace(model, best=model.fit(max(held, key=lambda m: model.scores[m]))) if held else model


def _status(within: Mapping[str, str], claimed: Sequence[str], stays: Unknown) -> str:
    """In a word. within: by stage, what the gap is within; stays: what is unknown, which beside claims is likely only where it
    matters.
    """
    unknown = stays.probability >= 0.5
    if claimed:
        return "partly explained" if unknown else "explained"
    if unknown:
        cares = BEYOND in within.values() or "tolerance" not in within.values()
        return "unexplained" if cares else "no gap"
    # one of several that can't be told apart, so that none is claimed
    return "explained" if BEYOND in within.values() else "no gap"
