"""One entry an effect: how likely it is at work, where, with which values, and what it takes off withheld samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.aliases import covered_by
from camrob.gap.evidence.model import Model, members_of, seen_rms
from camrob.gap.evidence.shrink import Shrinkage, Trial, figures, shrinkage
from camrob.gap.locate.which_axis import NO_AXIS, fitted_values, which_axis
from camrob.gap.verdict.alike.part_of_cycle import energy_of
from camrob.gap.verdict.belief import BELIEF
from camrob.gap.verdict.plausible import unusual
from camrob.summaries.diagnosis_summary import EffectFound
from camrob.units import m_to_mm

__all__ = ["effects_found"]

Set = frozenset[int]

_WORTH_A_LINE = 0.02  # of probability
_OWN_PART = 0.05  # of the energy of what all axes have alike: an axis's own part beside it is a word worth
_TOO_SMALL = 1e-3  # share of an energy below which a part of it doesn't matter
_CLAIMED = 0.5  # of probability, from which it is said which axis does it


def effects_found(
    model: Model,
    trial: Trial,
    library: Sequence[Effect],
    probability: Mapping[str, float],
    reasons: Mapping[str, str],
    in_world: bool,
    wider: Mapping[str, Sequence[str]],
) -> tuple[EffectFound, ...]:
    """One entry an effect worth a line, by probability and shrink."""
    entries = []
    total, seldom = model.design.A.sum(axis=0), unusual(model)
    for effect in library:
        p = probability[effect.name]
        if p < _WORTH_A_LINE:
            continue
        own = members_of(model, effect.name)
        if not own:
            # not in the best set: judged by what it would be on top of it
            own = frozenset(i for i, u in enumerate(model.units) if u.effect == effect.name)
        rest = model.best.members | own
        joint, everything, last = (shrinkage(model, trial, rest, one) for one in (own, rest, rest - own))
        twins = list(covered_by(model.design, total, model.values(own, model.best), effect.name))
        twins += [n for n in wider.get(effect.name, ()) if n not in twins]
        if in_world and effect.twin_in_world:
            twins.append(effect.twin_in_world)
            p *= BELIEF.first_of_twins
        alike = {effect.name, *twins}
        evidence, of_class = (
            sum(q for names, q in model.sets.items() if names & wanted) for wanted in (frozenset([effect.name]), alike)
        )
        which = which_axis(model, own) if p >= _CLAIMED else NO_AXIS
        entries.append(
            EffectFound(
                effect=effect.name,
                axes=(axes := _axes(model, own)),
                probability=p,
                parameters=fitted_values(model, own),
                **figures(joint).to_json(),
                alone=figures(shrinkage(model, trial, own)),
                added_last=figures(Shrinkage(last.after, everything.after, everything.block)),
                moves_mm=m_to_mm(seen_rms(model, model.panels, effect.name)),
                indistinguishable_from=tuple(twins),
                alike=tuple(sorted(alike)),
                class_probability=max(p, BELIEF.effect(of_class)),
                evidence=evidence,
                implausible=reasons.get(effect.name, ""),
                compensable=effect.compensable,
                stages=effect.stages,
                regimes=effect.regimes,
                unusual=seldom.get(effect.name, ""),
                remedy=which.remedy(effect),
                isolated_by=_of_axis(effect.experiment, axes),
                of_machine=effect.of_machine,
                physics=effect.physics,
                axis_moves_mm=which.moves_mm,
                stands_out=which.stands_out,
                since=effect.came([model.units[i].key for i in sorted(own)]),
            )
        )
    return tuple(sorted(entries, key=lambda e: (-e.probability, -e.shrink)))


def _of_axis(experiment: str, axes: Sequence[str]) -> str:
    """What isolates an effect, with the axis that it moves most named where one axis is moved alone."""
    return experiment.replace("the axis alone", f"{axes[0]} alone") if axes else experiment


def _axes(model: Model, own: Set) -> tuple[str, ...]:
    """Axes of an effect's units, those that move most first, by all units of one together; without what is too small beside what
    most or all of them do.
    """
    by_axis: dict[str, list[int]] = {}
    for i in sorted(own):
        by_axis.setdefault(model.units[i].axis, []).append(i)
    moved: dict[str, float] = {}
    for axis, units in by_axis.items():
        values = model.values(frozenset(units), model.best)
        turned = sum(float(np.sum(p.twists(values)[:, 3:] ** 2)) for p in model.panels)
        moved[axis] = energy_of(model, frozenset(units)) + 0.25 * turned
    alike = moved.pop("", 0.0)
    least = max(_TOO_SMALL * max(moved.values(), default=0.0), _OWN_PART * alike)
    return tuple(a for a, e in sorted(moved.items(), key=lambda x: -x[1]) if e > least)
