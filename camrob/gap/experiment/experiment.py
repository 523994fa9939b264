"""The next experiment: the motion that would separate the closest rivals best, with how far it would set them apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camrob.gap.evidence.model import Model
from camrob.gap.evidence.unknown import UNKNOWN
from camrob.gap.experiment.isolating import axes_alone, moving
from camrob.gap.experiment.motions import TrialMotion, single_axis, standing_still, trial_motions
from camrob.gap.experiment.separation import Rivals, Separation, rivals_of, separation, unknown_on
from camrob.summaries.diagnosis_summary import CLEAR_SIGMAS, ConsideredMotion, ExperimentFigures, worth_running
from camrob.units import m_to_mm

__all__ = ["Doubt", "Experiment", "named", "plan_experiment"]

_ENOUGH = 100.0  # sigmas: more of them say no more
_RIVALS = 3  # names that may be it as well, that are worth being read


@dataclass(frozen=True)
class Experiment:
    """motions: those worth running, the best first; figures: the motion and what it tells apart; about: the effects
    that it would tell from others, or "unknown".
    """

    motions: tuple[TrialMotion, ...]
    text: str
    figures: ExperimentFigures
    about: tuple[str, ...]


@dataclass(frozen=True)
class Doubt:
    """A claim that these logs can't tell from others, and the run that would show it alone."""

    effect: str
    others: tuple[str, ...]
    isolated_by: str

    def text(self, more: str = "") -> str:
        """What can't be told, in words, and what more is to be said of that, ahead of what to run."""
        others = [named([n]) for n in self.others]
        rest = f" and {len(others) - _RIVALS} more" if len(others) > _RIVALS else ""
        return f"These logs can't tell {named([self.effect])} from {' or '.join(others[:_RIVALS])}{rest}{more}. To tell"


def plan_experiment(
    model: Model,
    claimed: Sequence[str],
    suspects: Sequence[str],
    *,
    unknown: bool,
    by_time: bool = False,
    returning: float = 0.0,
    looks: str = "",
    isolated_by: str = "",
    doubt: Doubt | None = None,
) -> Experiment | None:
    """The motions that would tell most, reckoned on the fitted model; None where there is nothing to tell apart.

    unknown: something unexplained is likely; suspects: axes at which it sits or that it follows; by_time: it follows the time;
    returning: m (rms), what of it comes back with a period of the time, or of the first suspect's position; looks: what a person
    sees of it where an axis moves alone; isolated_by: what to run for it; doubt: the largest claim that may be another, of which
    nothing is said here but what the verdict says.
    """
    longest = max(model.scenes, key=len)
    if unknown and not longest.poses and (suspects or by_time or not claimed):
        axes = suspects or ([] if by_time else longest.axes)
        motions = [single_axis(longest, a) for a in moving(longest, axes)]
        if by_time and not suspects:
            motions.insert(0, standing_still(longest))
        shown = [(max(unknown_on(model, m), returning if k == 0 else 0.0), m) for k, m in enumerate(motions)]
        return _isolating(model, shown, looks)
    if unknown and not claimed:
        return None  # no two names are worth telling apart while neither explains the gap
    rivals = rivals_of(model, claimed)
    if rivals is None:
        return None
    again, *trials = [separation(model, rivals, m) for m in trial_motions(longest)]
    trials.sort(key=lambda s: -s.sigmas)
    clear = tuple(s for s in trials if s.sigmas >= CLEAR_SIGMAS)
    if not clear:
        return None
    text, about = _told(model, rivals, trials, again, isolated_by, doubt)
    return Experiment(tuple(s.motion for s in clear), text, _figures(rivals, trials, again), about) if text else None


def _told(
    model: Model,
    rivals: Rivals,
    trials: Sequence[Separation],
    again: Separation,
    isolated_by: str,
    doubt: Doubt | None,
) -> tuple[str, tuple[str, ...]]:
    """What to run and about what: the motion on which a person sees which of the rivals it is; where there is none, the run that
    shows a claim in doubt alone, or what is unexplained; "" for none of these.
    """
    both = {*rivals.first, *rivals.second}
    best = next((s for s in trials if worth_running(s.rms / model.noise, s.sigmas, again.sigmas)), None)
    if best is not None and (doubt is None or doubt.effect in both):
        return _words(rivals, best, model.noise), tuple(rivals.first or rivals.second)
    if doubt is not None:
        nothing = f", and no change of the program shows more of it {_at_most(trials, model.noise)}"
        return f"{doubt.text(nothing if doubt.effect in both else '')}: {doubt.isolated_by}.", (doubt.effect,)
    if isolated_by:
        return f"Isolate what is unexplained: {isolated_by}.", (UNKNOWN.name,)
    first, second = map(named, (rivals.first, rivals.second))
    if again.sigmas < CLEAR_SIGMAS or not (first and second):
        return "", ()
    text = f"None needed to tell {first} from its closest rival, {second}: a fit on these logs does ({_sigmas(again)} sigmas)"
    return f"{text}, and no change of the program that was reckoned shows more of it to the eye.", tuple(rivals.first)


def _at_most(trials: Sequence[Separation], noise: float) -> str:
    """The most by which rivals differ on motions, in words."""
    return f"({m_to_mm(max(s.rms for s in trials)):.3f} mm rms at most, in noise of {m_to_mm(noise):.3f} mm)"


def _isolating(model: Model, shown: Sequence[tuple[float, TrialMotion]], looks: str) -> Experiment | None:
    """The motion on which most of what is unexplained (m, rms) stands alone, with the answer that is expected of it; None where
    none would show it above the noise.
    """
    ranked = sorted(shown, key=lambda x: -x[0])
    if not ranked or ranked[0][0] < model.noise:
        return None
    size, noise = m_to_mm(ranked[0][0]), m_to_mm(model.noise)
    best = ranked[0][1]
    answer = f"{size:.3f} mm rms about its mean if it sits there, the noise ({noise:.3f} mm) if it does not"
    run = axes_alone(best.scene, [best.axis], looks) if best.axis else f"hold {best.text}, and measure"
    text = f"Isolate what is unexplained: {run}. Expected is at least {answer}."
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
    return Experiment(tuple(m for _, m in ranked if m.axis), text, figures, (UNKNOWN.name,))


def _words(rivals: Rivals, best: Separation, noise: float) -> str:
    first, second = map(named, (rivals.first, rivals.second))
    run, advice = best.motion.text, best.motion.advice
    if advice:
        run = f"{run[:-1]}; {advice})" if run.endswith(")") else f"{run} ({advice})"
    aim = f"tell {first} from {second}" if first and second else f"see whether {first or second} is at work too"
    return (
        f"To {aim}, run {run}: the paths that the two expect differ there by {m_to_mm(best.rms):.3f} mm rms (noise "
        f"{m_to_mm(noise):.3f} mm), most at {100.0 * best.at:.0f} % of the way, by {m_to_mm(best.most):.3f} mm; then diagnose "
        f"that log with these ({_sigmas(best)} sigmas)."
    )


def named(names: Sequence[str]) -> str:
    """Effects in words."""
    return " with ".join(names).replace("_", " ")


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
