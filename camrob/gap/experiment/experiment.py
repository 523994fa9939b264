"""The next experiment: the motion that would separate the closest rivals best, with how far it would set them apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.unknown import UNKNOWN
from camrob.gap.experiment.motions import TrialMotion, single_axis, standing_still, trial_motions
from camrob.gap.experiment.separation import Rivals, Separation, rivals_of, separation, unknown_on
from camrob.summaries.diagnosis_summary import ConsideredMotion, ExperimentFigures
from camrob.units import m_to_mm

__all__ = ["Experiment", "next_experiment", "plan_experiment"]

_CLEAR = 5.0  # sigmas: a motion that tells less is not worth its time
_ENOUGH = 100.0  # sigmas: more of them say no more
_STILL = 1e-3  # rad or m: an axis that the run moved by less can't be asked by moving it through its range
_BETTER = 1.5  # times what the same again would tell: then it tells something new


@dataclass(frozen=True)
class Experiment:
    """motions: those worth running, the best first; figures: the motion and what it tells apart."""

    motions: tuple[TrialMotion, ...]
    text: str
    figures: ExperimentFigures


def next_experiment(
    claimed: Sequence[str],
    rivals: Mapping[str, float],
    sizes_mm: Mapping[str, float],
    library: Sequence[Effect],
    unknown: Sequence[str] | None,
) -> str:
    """What to run next where no motion was reckoned. rivals: probability of the effects that are considered; unknown: the axes
    at which something unexplained sits, none where it is no axis, None where nothing is unexplained.
    """
    by_name = {e.name: e for e in library}
    if unknown is not None:
        one = unknown[0] if len(unknown) == 1 else ", then ".join(unknown) or "each axis in turn"
        return (
            f"Isolate what is unexplained: move {one} alone through the whole range, the others at rest, and measure."
        )
    order = sorted((n for n in rivals if n in by_name and n not in claimed), key=lambda n: -rivals[n])
    pair = [*(n for n in claimed if n in by_name), *order][:2]
    if not pair or (not claimed and rivals[pair[0]] < 0.02):
        return "None needed: the gap is within its noise, or what is tolerated. A larger work space would test more."
    first = by_name[max(pair, key=lambda n: sizes_mm.get(n, 0.0))]
    return f"To confirm {_named([first.name])}: {first.experiment}."


def plan_experiment(
    model: Model,
    claimed: Sequence[str],
    suspects: Sequence[str],
    *,
    unknown: bool,
    by_time: bool = False,
    returning: float = 0.0,
) -> Experiment | None:
    """The motions that would tell most, reckoned on the fitted model; None where there is nothing to tell apart.

    unknown: something unexplained is likely; suspects: axes at which it sits or that it follows; by_time: it follows the time;
    returning: m (rms), what of it comes back with a period of the time, or of the first suspect's position.
    """
    longest = max(model.scenes, key=len)
    if unknown and not longest.poses and (suspects or by_time or not claimed):
        axes = suspects or ([] if by_time else longest.axes)
        motions = [single_axis(longest, a) for a in axes if np.ptp(longest.command[:, longest.index(a)]) > _STILL]
        if by_time:
            motions.insert(0, standing_still(longest))
        shown = [(max(unknown_on(model, m), returning if k == 0 else 0.0), m) for k, m in enumerate(motions)]
        return _isolating(model, shown)
    if unknown and not claimed:
        return None  # no two names are worth telling apart while neither explains the gap
    rivals = rivals_of(model, claimed)
    if rivals is None:
        return None
    again, *trials = [separation(model, rivals, m) for m in trial_motions(longest)]
    trials.sort(key=lambda s: -s.sigmas)
    clear = [s for s in trials if s.sigmas >= _CLEAR]
    if not clear:
        return None
    return Experiment(tuple(s.motion for s in clear), _words(rivals, clear[0], again), _figures(rivals, trials, again))


def _isolating(model: Model, shown: Sequence[tuple[float, TrialMotion]]) -> Experiment | None:
    """The motion on which most of what is unexplained (m, rms) stands alone, with the answer that is expected of it; None where
    none would show it above the noise.
    """
    ranked = sorted(shown, key=lambda x: -x[0])
    if not ranked or ranked[0][0] < model.noise:
        return None
    size, noise = m_to_mm(ranked[0][0]), m_to_mm(model.noise)
    best = ranked[0][1]
    answer = f"{size:.3f} mm rms about its mean if it sits there, the noise ({noise:.3f} mm) if it does not"
    text = f"Isolate what is unexplained: {'run' if best.axis else 'hold'} {best.text}, and measure: expected at least {answer}."
    considered = [
        ConsideredMotion(
            motion=f"{m.key} {m.axis}".rstrip(),
            text=m.text,
            separation_mm=m_to_mm(rms),
            separation_sigmas=rms / model.noise * float(np.sqrt(len(m.scene))),
        )
        for rms, m in ranked
    ]
    figures = ExperimentFigures(
        motion=best.key,
        rivals=((UNKNOWN.name,), ()),
        separation_mm=size,
        expected_mm=(size, noise),
        considered=tuple(considered),
    )
    return Experiment(tuple(m for _, m in ranked if m.axis), text, figures)


def _words(rivals: Rivals, best: Separation, again: Separation) -> str:
    first, second = map(_named, (rivals.first, rivals.second))
    run, advice = best.motion.text, best.motion.advice
    if advice:
        run = f"{run[:-1]}; {advice})" if run.endswith(")") else f"{run} ({advice})"
    expected = (
        f"{m_to_mm(best.rms):.3f} mm rms, {_sigmas(best)} sigmas on {len(best.motion.scene)} samples (the same again: "
        f"{_sigmas(again)})."
    )
    if first and second and again.sigmas >= _CLEAR and best.sigmas < _BETTER * again.sigmas:
        return (
            f"These logs tell {first} from its closest rival, {second}, already; to confirm it run {run}: "
            f"expected to set them apart by {expected} {_answers(rivals, best)}"
        )
    aim = f"tell {first} from {second}" if first and second else f"see whether {first or second} is at work too"
    return f"To {aim}, run {run}: expected to set the answers apart by {expected} {_answers(rivals, best)}"


def _named(names: Sequence[str]) -> str:
    """Effects in words."""
    return " with ".join(names).replace("_", " ")


def _answers(rivals: Rivals, on: Separation) -> str:
    """The gap that each rival expects on a motion, in words."""
    first, second = map(_named, (rivals.first, rivals.second))
    cases = (first or f"it is not {second}", second or f"it is not {first}")
    answers = (f"{m_to_mm(rms):.3f} mm rms if {who}" for rms, who in zip(on.answers, cases, strict=True))
    return f"Expected there: {', '.join(answers)}."


def _sigmas(apart: Separation) -> str:
    """Sigmas in words: beyond a hundred there is nothing more to tell."""
    return f"{apart.sigmas:.0f}" if apart.sigmas <= _ENOUGH else f"over {_ENOUGH:.0f}"


def _figures(rivals: Rivals, trials: Sequence[Separation], again: Separation) -> ExperimentFigures:
    return ExperimentFigures(
        motion=trials[0].motion.key,
        rivals=(tuple(rivals.first), tuple(rivals.second)),
        separation_mm=m_to_mm(trials[0].rms),
        separation_sigmas=trials[0].sigmas,
        again_sigmas=again.sigmas,
        expected_mm=tuple(m_to_mm(rms) for rms in trials[0].answers),
        considered=tuple(
            ConsideredMotion(
                motion=s.motion.key,
                text=s.motion.text,
                separation_mm=m_to_mm(s.rms),
                separation_sigmas=s.sigmas,
            )
            for s in trials
        ),
    )
