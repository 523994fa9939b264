"""Names that move the tool by less than what stays beside them, and may be a likeness of that."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.model import Model, whole_gap
from camrob.gap.evidence.shrink import Shrinkage, Trial, settled_rms, shrinkage
from camrob.gap.verdict.at_drives import (
    at_drives,
    behind_encoders,
    moved_at_drives,
    stays_at_drives,
    without_drives_rest,
)
from camrob.gap.verdict.belief import BELIEF
from camrob.gap.verdict.carried_over import carried_over
from camrob.gap.verdict.delivers import taken, taken_last
from camrob.gap.verdict.remains import claims, left_panels

__all__ = ["SMOOTH", "beside_more", "gains"]

SMOOTH = frozenset({"position", "load", "time"})
"""Regimes that change slowly, as the discrepancy does."""


def beside_more(
    model: Model, trial: Trial, together: Shrinkage, probability: Mapping[str, float], library: Sequence[Effect]
) -> dict[str, float]:
    """Probabilities of effects that move the tool by less than what stays beside all claims, on withheld samples (`together`) or
    on the fitted ones: such a one may be a likeness of that, and is, as likely as not, where withheld samples don't surely get
    better by it. Names that follow posture, load or time alone and mostly cancel have to move it by more: together they are any
    smooth function. What carries over to far postures is no likeness. Sizes are but for what frames that nobody reported take up.
    So are a drive's lag and delay that mostly cancel, or move less than its friction: they may be the course that it has.
    No name is nearly sure that moves the tool by less than twice what stays, wherever it carries over to: a dent in a gear does.
    Claims that together take far less than they move the tool by work against something that is not claimed. Names of drives of
    which the logs tell both ends are held to what stays between these.
    """
    sizes = {n: settled_rms(model, model.panels, [n]) for n, p in probability.items() if p >= 0.5}
    seen, behind = at_drives(model, library).intersection(sizes), behind_encoders(model).intersection(sizes)
    there = _at_drives(model, trial, probability) if seen else together
    rest = shrinkage(model, without_drives_rest(model, trial), model.best.members, claims(model, probability))
    held = {n: there if n in seen else rest if n in behind else together for n in sizes}
    left_of = {False: _left_of_fitted(model, probability), True: _left_of_fitted(model, probability, behind=True)}
    bars = {
        n: stays_at_drives(model, there, probability)
        if n in seen
        else max(_beyond(model, held[n].rms_after), _beyond(model, left_of[n in behind]))
        for n in sizes
    }
    moved = {n: moved_at_drives(model, [n]) if n in seen else size for n, size in sizes.items()}
    smooth = {e.name for e in library if SMOOTH.issuperset(e.regimes)} & set(sizes)
    cancel = _cancel(model, sizes, smooth)
    small = [n for n, m in moved.items() if m < bars[n] * (BELIEF.smooth_more if cancel and n in smooth else 1.0)]
    carried = carried_over(model, trial, small)
    small = [n for n in small if n not in carried]
    less = gains(model, trial, [n for n in small if moved[n] < bars[n]], seen)
    left = {n: BELIEF.doubtful if n in less and less[n][0] <= 0.0 else 1.0 for n in small}
    drives = [e for e in library if e.stages == ("setpoint_to_encoder",) and "speed" in e.regimes and e.name in sizes]
    steady = {e.name for e in drives if not e.at_reversals}
    friction = settled_rms(model, model.panels, {e.name for e in drives if e.at_reversals})
    if _cancel(model, sizes, steady) or settled_rms(model, model.panels, steady) < friction:
        left = dict.fromkeys(steady, 1.0) | left
    against = [n for n in sizes if taken(held[n]) < BELIEF.taken]
    left = dict.fromkeys(against, 1.0) | left
    sure = {n for n, m in moved.items() if m >= BELIEF.sure_from * bars[n]}
    doubted = {n: p * (BELIEF.beside_more * left[n] if n in left else 1.0) for n, p in probability.items()}
    return {n: p if n in sure else min(p, BELIEF.likely) for n, p in doubted.items()}


def _cancel(model: Model, sizes: Mapping[str, float], names: Collection[str]) -> bool:
    """Whether names move the tool by far less together than each for itself."""
    return sum(sizes[n] ** 2 for n in names) > BELIEF.cancels * settled_rms(model, model.panels, names) ** 2


def gains(
    model: Model, trial: Trial, names: Sequence[str], drives: Collection[str] = ()
) -> dict[str, tuple[float, float]]:
    """90 % of the share that each of these effects takes from withheld samples when it is taken away last; of `drives`, from what
    lies between the ends of the drives.
    """
    found = dict.fromkeys(names, (0.0, 0.0))
    return found | {n: last.interval() for n, last in taken_last(model, trial, names, drives).items()}


def _at_drives(model: Model, trial: Trial, probability: Mapping[str, float]) -> Shrinkage:
    """What lies between the ends of the drives on withheld samples without and with all claims."""
    return shrinkage(model, trial, model.best.members, claims(model, probability), at_drives=True)


def _left_of_fitted(model: Model, probability: Mapping[str, float], *, behind: bool = False) -> float:
    """m (rms) that the claims leave of the fitted logs, or of what these show behind the encoders."""
    panels = left_panels(model, claims(model, probability))
    left = np.concatenate([(p.y_tcp[:, :3] if behind else whole_gap(p))[p.w_tcp[:, 0] > 0.0] for p in panels])
    return float(np.sqrt(np.mean(np.sum(left**2, axis=1))))


def _beyond(model: Model, rms: float) -> float:
    """m of an rms that is more than noise."""
    return float(np.sqrt(max(rms**2 - model.noise**2, 0.0)))
