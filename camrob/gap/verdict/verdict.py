"""The verdict on effects: probabilities, sizes, shrinkage on withheld samples, what stays, and what to do next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.aliases import alias_groups, covered_by
from camrob.gap.evidence.model import Model, effect_rms
from camrob.gap.evidence.regimes_withheld import regimes_withheld
from camrob.gap.evidence.shrink import Shrinkage, Trial, figures, predicted_shrink, shrinkage, trial_of
from camrob.gap.experiment.experiment import next_experiment
from camrob.gap.locate.localise import regimes_of
from camrob.gap.verdict.plausible import implausible, unknown_shapes, unknown_text
from camrob.units import m_to_mm

__all__ = ["Verdict", "judge_effects"]

Set = frozenset[int]

_WORTH_A_LINE = 0.02
_REPORTED = 0.97  # of the probability: the likeliest sets that hold as much are told
_CROWDED = 0.05
_TRIES, _LIKELY = 3, 0.02
_SURE = 0.975  # share of right names among those that the evidence leaves no doubt about, on simulated cells
_DOUBTS = 3.0  # standard errors of the prediction that structure on withheld samples must exceed
_CAUTIOUS = 0.6  # what no single name is given where something unexplained stays, and has no shape
_FAR_MORE, _BESIDE = (
    4.0,
    0.78,
)  # times the unknown's shape that an effect moves the tool by to stand beside it; then at most so sure
_CROWD = 4  # effects: more than these together rather mimic what is unknown
_SOMETHING = 0.55  # probability of the unknown where nothing else is left to say
_ZEROS = 3  # axes whose zeros are lost at once; more beside other effects rather mimic wrong lengths
_LEFT = 0.45  # of the noise: structure that stays and is more than the nuisances of all that is absent
_TWINS = {"frame_base": ("measurement_frame", 0.85)}  # alike where measured in `world`; share of the first
_OWN_PART = 0.05  # of the energy of what all axes have alike: an axis's own part beside it is a word worth
_TOO_SMALL = 1e-3  # share of an energy below which a part of it doesn't matter


@dataclass(frozen=True)
class Verdict:
    """model: without what is implausible or harms; claimed: effects with a probability of 0.5 or more; members: their units;
    summary: the part of the JSON object.
    """

    model: Model
    claimed: tuple[str, ...]
    members: Set
    summary: dict[str, Any]


def judge_effects(model: Model, trial: Trial, library: Sequence[Effect], *, in_world: bool) -> Verdict:
    """All that is said of effects. in_world: the table's turning doesn't part the instrument's frame from the robot's."""
    blocks = trial_of(model, ())
    model = _without_harmful(_without_implausible(model), blocks)
    sets = {tuple(sorted(names)): p for names, p in model.sets.items()}
    reasons = implausible(model)
    top = max(model.sets, key=lambda names: model.sets[names])
    members = frozenset(i for i in model.best.members if model.units[i].effect in top - {"unknown"})
    whole = shrinkage(model, trial, model.best.members, members)
    structure = _structure(whole)
    unknown = sum(p for names, p in model.sets.items() if "unknown" in names)
    beyond = max(model.excess, np.sqrt(max(0.0, structure**2 - (_DOUBTS * whole.doubt) ** 2)))
    left_over = _left_over(float(beyond) / model.noise, whole.rms_after / max(whole.rms_before, 1e-12))
    crowd = 0.6 if _crowded(model, top) else 0.0
    unknown = max(unknown, left_over, _SOMETHING if reasons and not unknown else 0.0, crowd)
    probability = _probabilities(model, top, unknown, reasons, library)
    claimed_first = tuple(n for n, p in probability.items() if p >= 0.5)
    entries, claimed = _entries(model, trial, library, probability, reasons, in_world)
    members = frozenset(i for i in model.best.members if model.units[i].effect in claimed_first)
    together = shrinkage(model, trial, model.best.members, members)
    inside = sum(p for names, p in model.sets.items() if names and "unknown" not in names)
    status = _status(together, model.noise, claimed, unknown, inside)
    if status == "unexplained":
        unknown = max(unknown, _SOMETHING)
    sizes = {n: m_to_mm(effect_rms(model, model.panels, n)) for n in claimed}
    # a shape in the best set alone, while the sets beside it do without, is no finding
    shapes = unknown_shapes(model) if unknown >= 0.5 else []
    text = unknown_text(model, shapes)
    return Verdict(model, claimed, members, {
        "status": status,
        "effects": entries,
        "together": {
            **figures(together), "withheld": trial.name, "left_aside": trial.aside,
            "predicted_shrink": predicted_shrink(model, trial, blocks, members),
            "removable_removed": _removed(together, model.noise),
            "compensable_mm": m_to_mm(_compensable(model, trial, library, claimed)),
            "regimes_withheld": regimes_withheld(model, members),
        },
        "alternatives": _alternatives(sets, unknown),
        "unknown": {"probability": unknown, "where": text, "shapes": shapes, "implausible": reasons},
        "aliases": _alias_lists(model, in_world),
        "residual": {
            "rms_mm": m_to_mm(together.rms_after), "noise_mm": m_to_mm(model.noise), "structured_mm": m_to_mm(structure),
            "structure": _residual_regimes(model, members),
        },
        "next_experiment": next_experiment(
            claimed, probability, sizes, library, _suspects(model, shapes) if shapes or (unknown >= 0.5 and not claimed) else None
        ),
    })  # fmt: skip


def _suspects(model: Model, shapes: Sequence[Mapping[str, Any]]) -> list[str]:
    """Axes that something unexplained moves, or that it follows where it sits in the foot."""
    told = (str(s["follows"]).rpartition(" ")[2] if "foot" in s["moves"] else str(s["moves"]) for s in shapes)
    return list(dict.fromkeys(name for name in told if name in model.scenes[0].axes))


def _probabilities(
    model: Model, top: frozenset[str], unknown: float, reasons: Mapping[str, str], library: Sequence[Effect]
) -> dict[str, float]:
    """Of every effect: that of the sets that hold it, with the caution that something unknown and implausible values ask for."""
    # beside something unknown a name or two may stand that explain far more than it; others rather mimic it
    few = len(top - {"unknown"}) <= 2
    shape = effect_rms(model, model.panels, "unknown") if "unknown" in top else 0.0
    stands = {n for n in top if few and effect_rms(model, model.panels, n) >= _FAR_MORE * shape}
    standing = _BESIDE if shape > 0.0 else _CAUTIOUS

    def most(name: str) -> float:
        if name in reasons:
            return _CROWDED
        return 1.0 - (1.0 - (standing if name in stands else _CROWDED)) * min(1.0, 2.0 * unknown)

    found = {e.name: sum(p for names, p in model.sets.items() if e.name in names) for e in library}
    return {n: _SURE * min(p, most(n)) for n, p in found.items()}


def _crowded(model: Model, top: frozenset[str]) -> bool:
    """True where the best set rather mimics something unknown: too many effects, or the zeros of most axes beside others."""
    zeros = sum(model.units[i].effect == "joint_offset" for i in model.best.members)
    others = top - {"unknown", "joint_offset"}
    return len(top - {"unknown"}) > _CROWD or ("joint_offset" in top and zeros > _ZEROS and len(others) >= 2)


def _without_implausible(model: Model) -> Model:
    """The model without sets whose best fit has values that no machine has, where a likely enough set does without them."""
    for _ in range(_TRIES):
        bad = set(implausible(model))
        rest = {names: p for names, p in model.sets.items() if not names & bad}
        total = sum(rest.values())
        if not bad or total < _LIKELY:
            return model
        left = {m: s for m, s in model.scores.items() if not model.evidence.effects_of(m) & bad}
        best = model.evidence.fit(max(left, key=lambda m: left[m]))
        model = replace(model, best=best, sets={names: p / total for names, p in rest.items()})
    return model


def _without_harmful(model: Model, trial: Trial) -> Model:
    """The model with effects taken out that make the prediction of withheld samples worse than it is without them."""
    for name in sorted(model.evidence.effects_of(model.best.members) - {"unknown"}):
        own = frozenset(i for i in model.best.members if model.units[i].effect == name)
        rest = model.best.members - own
        with_it, without = (shrinkage(model, trial, m, m) for m in (model.best.members, rest))
        gains = np.array([
            float(np.sum(without.after[without.block == b] ** 2) - np.sum(with_it.after[with_it.block == b] ** 2))
            for b in np.unique(with_it.block)
        ])  # fmt: skip
        error = float(gains.std()) * np.sqrt(len(gains))
        if gains.sum() < -max(error, _TOO_SMALL * float(np.sum(without.after**2))):
            sets: dict[frozenset[str], float] = {}
            for names, p in model.sets.items():
                kept = names - {name}
                sets[kept] = sets.get(kept, 0.0) + p
            model = replace(model, best=model.evidence.fit(rest), sets=sets)
    return model


def _alias_lists(model: Model, in_world: bool) -> list[list[str]]:
    groups = [list(g) for g in alias_groups(model.design, model.design.A.sum(axis=0))]
    return groups + ([["frame_base", "measurement_frame"]] if in_world else [])


def _structure(shrunk: Shrinkage) -> float:
    """m: rms of what hangs together in the error that is left, block by block; of single poses, what is more than their noise."""
    parts = []
    for b in np.unique(shrunk.block):
        at = shrunk.block == b
        r, floor = shrunk.after[at], float("nan") if shrunk.floor is None else float(shrunk.floor[at][0])
        if np.isfinite(floor):
            parts.append(np.sum(r**2, axis=1) - floor)
        else:
            parts += [np.sum(r[k:] * r[:-k], axis=1) for k in (1, 2, 3) if len(r) > 3 * k]
    return float(np.sqrt(max(0.0, float(np.mean(np.concatenate(parts)))))) if parts else 0.0


def _left_over(structure: float, share: float) -> float:
    """Probability that something unknown stays, from the structure left over the noise and the share of the gap it is."""
    size = min(structure / _LEFT, share / 0.02)
    return float(1.0 / (1.0 + np.exp(-6.0 * (size - 1.3))))


def _removed(shrunk: Shrinkage, noise: float) -> float | None:
    """Share of the removable gap (before less noise) that is removed; None where nothing is removable."""
    removable = shrunk.rms_before - noise
    return (
        None
        if removable < 0.2 * noise
        else float(np.clip((shrunk.rms_before - shrunk.rms_after) / removable, -9.0, 1.0))
    )


def _status(shrunk: Shrinkage, noise: float, claimed: Sequence[str], unknown: float, inside: float) -> str:
    """In a word. shrunk: by what is claimed; inside: probability of the sets of effects without anything unknown."""
    if claimed:
        return "partly explained" if unknown >= 0.5 else "explained"
    quiet = shrunk.rms_before < 1.25 * noise or _structure(shrunk) < _LEFT * noise
    if quiet and unknown < 0.5:
        return "no gap"
    # one of several that can't be told apart, so that none is claimed
    return "explained" if inside * (1.0 - unknown) >= 0.5 else "unexplained"


def _alternatives(sets: Mapping[tuple[str, ...], float], unknown: float) -> list[dict[str, Any]]:
    """The likeliest sets of effects with their probabilities, the unknown among them; they sum to 1."""
    inside = sum(p for names, p in sets.items() if "unknown" in names)
    scale_in = unknown / inside if inside > 0.0 else 0.0
    scale_out = (1.0 - (unknown if inside > 0.0 else 0.0)) / max(1.0 - inside, 1e-12) if inside < 1.0 else 0.0
    out: list[dict[str, Any]] = [
        {"effects": list(names), "probability": p * (scale_in if "unknown" in names else scale_out)}
        for names, p in sets.items()
    ]
    if inside <= 0.0 and unknown > 0.0:
        out = [{**o, "probability": o["probability"] * (1.0 - unknown)} for o in out]
        out.append({"effects": ["unknown"], "probability": unknown})
    out.sort(key=lambda o: -float(str(o["probability"])))
    whole = np.cumsum([float(str(o["probability"])) for o in out])
    kept = out[: int(np.searchsorted(whole, _REPORTED * whole[-1])) + 1]
    total = sum(float(str(o["probability"])) for o in kept)
    return [{**o, "probability": float(str(o["probability"])) / max(total, 1e-12)} for o in kept]


def _entries(
    model: Model, trial: Trial, library: Sequence[Effect], probability: Mapping[str, float],
    reasons: Mapping[str, str], in_world: bool,
) -> tuple[list[dict[str, Any]], tuple[str, ...]]:  # fmt: skip
    """One entry an effect worth a line, by probability and shrink."""
    entries = []
    total = model.design.A.sum(axis=0)
    for effect in library:
        p = probability[effect.name]
        if p < _WORTH_A_LINE:
            continue
        own = frozenset(i for i in model.best.members if model.units[i].effect == effect.name)
        if not own:
            # not in the best set: judged by what it would be on top of it
            units = [i for i, u in enumerate(model.units) if u.effect == effect.name]
            own = frozenset(units)
        rest = model.best.members | own
        joint = shrinkage(model, trial, rest, own)
        alone = shrinkage(model, trial, own)
        last = shrinkage(model, trial, rest, rest - own)
        everything = shrinkage(model, trial, rest, rest)
        twins = list(covered_by(model.design, total, model.values(own, model.best), effect.name))
        if in_world and effect.name in _TWINS:
            twins.append(_TWINS[effect.name][0])
            p *= _TWINS[effect.name][1]
        added = Shrinkage(last.after, everything.after, everything.block)
        entries.append({
            "effect": effect.name, "axes": _axes(model, own), "probability": p, "parameters": _parameters(model, own),
            **figures(joint), "alone": figures(alone), "added_last": figures(added),
            "moves_mm": m_to_mm(effect_rms(model, model.panels, effect.name)),
            "indistinguishable_from": twins, "implausible": reasons.get(effect.name, ""), "compensable": effect.compensable,
            "rungs": list(effect.rungs),
        })  # fmt: skip
    entries.sort(key=lambda e: (-float(str(e["probability"])), -float(str(e["shrink"]))))
    return entries, tuple(str(e["effect"]) for e in entries if float(str(e["probability"])) >= 0.5)


def _axes(model: Model, own: Set) -> list[str]:
    """Axes of an effect's units, those that move most first; without what is too small beside what most or all of them do."""
    moved: dict[str, float] = {}
    for i in own:
        axis = model.units[i].axis
        values = model.values(frozenset([i]), model.best)
        energy = sum(float(np.sum(p.moves(values) ** 2)) for p in model.panels)
        turned = sum(float(np.sum((p.tcp[:, 3:] @ values) ** 2)) for p in model.panels)
        moved[axis] = moved.get(axis, 0.0) + energy + 0.25 * turned
    alike = moved.pop("", 0.0)
    least = max(_TOO_SMALL * max(moved.values(), default=0.0), _OWN_PART * alike)
    return [a for a, e in sorted(moved.items(), key=lambda x: -x[1]) if e > least]


def _parameters(model: Model, own: Set) -> dict[str, dict[str, float]]:
    deviations = np.sqrt(np.maximum(np.diag(model.best.cov), 0.0))
    return {
        parameter.name: {
            "value": parameter.at_edge(float(model.best.mean[k])), "std": parameter.at_edge(float(deviations[k])),
        }
        for k, (parameter, owner) in enumerate(zip(model.design.parameters, model.design.owner, strict=True))
        if int(owner) in own
    }  # fmt: skip


def _compensable(model: Model, trial: Trial, library: Sequence[Effect], claimed: Sequence[str]) -> float:
    """m: by how much the rms falls when only what a postprocessor can correct is taken away."""
    able = {e.name for e in library if e.compensable} & set(claimed)
    members = frozenset(i for i in model.best.members if model.units[i].effect in able)
    shrunk = shrinkage(model, trial, model.best.members, members)
    return shrunk.rms_before - shrunk.rms_after


def _residual_regimes(model: Model, members: Set) -> list[dict[str, Any]]:
    """What the residual still depends on."""
    values = model.values(members | model.evidence.always, model.best)
    left = []
    for p in model.panels:
        y_servo = None if p.y_servo is None or p.servo is None else p.y_servo - p.servo @ values[p.servo_columns]
        known = ~p.unknown_rows(np.flatnonzero(values))
        left.append(replace(p, y_tcp=p.y_tcp - p.tcp @ values, y_servo=y_servo, w_tcp=p.w_tcp * known[:, None]))
    found = regimes_of(left, model.noise)
    return [{"regime": k, "p_value": v["p_value"], "share": v["share"]} for k, v in found.items()]
