"""What to run next, and about what: one statement on what these logs tell apart, from the verdict alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from camrob.cell.joint import Role
from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.unknown import FORCE, UNKNOWN
from camrob.gap.experiment.experiment import Doubt, Experiment, named, plan_experiment
from camrob.gap.experiment.isolating import looks_like, run_for_unknown
from camrob.gap.experiment.motions import TrialMotion
from camrob.gap.locate.localise import axes_of
from camrob.gap.locate.sits_at import suspects
from camrob.gap.verdict.verdict import Verdict
from camrob.summaries.diagnosis_summary import ExperimentFigures
from camrob.units import mm_to_m

__all__ = ["NextRun", "next_run", "without_motions"]

_ARM = 6  # axes of an arm whose motions can be followed
_WORTH = 0.02  # probability below which no name is worth an experiment
_EVEN, _RIVAL = 0.5, 0.1  # probability of two names together from which they are asked first, and of the second of them
_LOADS = (
    "with and without the load at the tool, say which in payload_kg of each LOG.toml, and diagnose both together: where joints "
    "are soft the gap changes with the load, what a mass does that nobody counted stays, as zeros and geometry do"
)


@dataclass(frozen=True)
class NextRun:
    """text: what to run; about: the effects that it would tell from others, or "unknown"; for_unknown: what to run for what is
    unexplained, "" where that is not likely; motions, figures: as reckoned on the model, none where that can't be.
    """

    text: str
    about: tuple[str, ...]
    for_unknown: str
    motions: tuple[TrialMotion, ...] = ()
    figures: ExperimentFigures | None = None


def next_run(model: Model, verdict: Verdict, library: Sequence[Effect]) -> NextRun:
    """What to run next after a verdict on a model."""
    stays, likely = verdict.unknown, verdict.unknown.likely
    by_force = stays.where.regimes[:1] == (FORCE,)  # no run of an axis by itself has a cutting force in it
    axes = () if by_force else suspects(model, stays)
    for_unknown = ""
    if likely:
        shares = axes_of(verdict.panels)
        order = sorted(shares, key=lambda a: -shares[a].value)
        for_unknown = run_for_unknown(stays, axes, order, max(model.scenes, key=len))
    doubt = _doubt(verdict)
    between = _between_names(model, verdict, library)
    if between is not None:
        return NextRun(*between, for_unknown)
    planned = None if by_force and not verdict.claimed else _planned(model, verdict, axes, for_unknown, doubt)
    if planned is not None:
        return NextRun(planned.text, planned.about, for_unknown, planned.motions, planned.figures)
    rivals = {} if verdict.status == "no gap" else {e.effect: e.probability for e in verdict.effects}
    isolated = for_unknown if axes or not verdict.claimed else ""
    text, about = without_motions(verdict.claimed, rivals, library, isolated, doubt)
    return NextRun(text, about, for_unknown)


def _doubt(verdict: Verdict) -> Doubt | None:
    """The largest claim that may be another; None where each stands."""
    found = sorted((e for e in verdict.effects if e.claimed and e.like_others), key=lambda e: -e.moves_mm)
    return Doubt(found[0].effect, found[0].indistinguishable_from, found[0].isolated_by) if found else None


def _between_names(model: Model, verdict: Verdict, library: Sequence[Effect]) -> tuple[str, tuple[str, ...]] | None:
    """What to run where nothing is claimed as two names may be it, which together are likelier than all else, and about which:
    what follows the load is asked by the load, whatever else the rest may follow on these logs. Else None.
    """
    nothing = sum(a.probability for a in verdict.alternatives if not a.effects)
    if verdict.claimed or verdict.status == "no gap" or nothing >= _EVEN:
        return None
    by_name = {e.name: e for e in library}
    able = [e for e in verdict.effects if e.effect in by_name and not e.implausible]
    two = sorted(able, key=lambda e: -e.probability)[:2]
    if len(two) < 2 or sum(e.probability for e in two) < _EVEN or two[1].probability < _RIVAL:
        return None
    both = (two[0].effect, two[1].effect)
    by_load = all(by_name[n].regimes[:1] == ("load",) for n in both)
    again = "measure the same poses" if any(s.poses for s in model.scenes) else "run the same path"
    run = f"{again} {_LOADS}" if by_load else by_name[both[0]].experiment
    return f"To tell {named(both[:1])} from {named(both[1:])}: {run}.", both


def _planned(
    model: Model, verdict: Verdict, axes: Sequence[str], for_unknown: str, doubt: Doubt | None
) -> Experiment | None:
    if len(model.scenes[0].cell.indices(Role.ARM)) != _ARM or not all(s.tracked for s in model.scenes):
        return None  # no motion of such an arm can be reckoned, or none would be measured
    if verdict.status == "no gap":
        return None
    stays = verdict.unknown
    return plan_experiment(
        model,
        verdict.claimed,
        axes,
        unknown=stays.likely,
        by_time=stays.where.regimes[:1] == ("time",),
        returning=mm_to_m(stays.rms_mm) if stays.where.comes_back else 0.0,
        looks=looks_like(stays),
        isolated_by=for_unknown,
        doubt=doubt,
    )


def without_motions(
    claimed: Sequence[str],
    rivals: Mapping[str, float],
    library: Sequence[Effect],
    for_unknown: str,
    doubt: Doubt | None,
) -> tuple[str, tuple[str, ...]]:
    """What to run next where no motion was reckoned, and about what. rivals: probability of the effects that are considered;
    for_unknown: what to run for what is unexplained, "" where nothing is.
    """
    if for_unknown:
        return f"Isolate what is unexplained: {for_unknown}.", (UNKNOWN.name,)
    if doubt is not None:
        return f"{doubt.text()}: {doubt.isolated_by}.", (doubt.effect,)
    by_name = {e.name: e for e in library}
    order = sorted((n for n in rivals if n in by_name and n not in claimed), key=lambda n: -rivals[n])
    first = next(iter([*(n for n in claimed if n in by_name), *order]), None)
    if first is None or (not claimed and rivals[first] < _WORTH):
        return (
            "None needed: the gap is within its noise, or what is tolerated. A larger work space would test more.",
            (),
        )
    return f"To confirm {named([first])}: {by_name[first].experiment}.", (first,)
