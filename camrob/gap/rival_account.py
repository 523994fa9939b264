"""A rival account of the same gap: what stays beside its causes is no smooth field, but readings that repeat one another.

A discrepancy that is smooth over posture is one description of what the library lacks. Beside a path in a small work space it has
room for a whole cause, too: a cutting force along the feed, 17 times the noise, was a latency with a field of 12 times the noise
beside it, by 265 log units, as nothing else on that arm was described to the last bit. The other description asks nothing of what
stays but how large it is and how far it hangs together, so that so many rows count as one. Which of the two holds can't be told
from rows that were fitted, but from samples that took no part: there a field that has swallowed a cause foretells nothing.

Both accounts foretell withheld samples, the first with its field; what each leaves there, with its scale unknown, is its
predictive evidence, of as many readings as there are neighbourhoods (Geisser and Eddy, J. Am. Stat. Assoc. 74, 1979, 153).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.comparison import excess_beside, too_small
from camrob.gap.evidence.evidence import Evidence
from camrob.gap.evidence.field_size import no_sizes
from camrob.gap.evidence.model import Model, whole_gap
from camrob.gap.evidence.predicted import field_at
from camrob.gap.evidence.search import explore, posterior, worth_counting
from camrob.gap.evidence.shrink import Trial, settled, trial_of
from camrob.gap.evidence.temperature import temperatures
from camrob.gap.observation.scene import Scene
from camrob.gap.pose_sets import frozen_frames
from camrob.gap.verdict.verdict import Verdict, judge_effects

__all__ = ["judge_accounts", "rival_account"]

Array = NDArray[np.float64]

_HEATS = (200.0, 50.0)  # rows that may count as one: few causes first, then more
_HOPELESS = 0.9  # of the energy that the first account leaves: few causes that leave more make no rival
_ROOM = 1.4  # times the noise, that the first account leaves at the least where a rival is asked
# of the energy that the first leaves, that the rival may leave at the most; and so of what is claimed by each
_LEAST = 0.5
_ERRORS = 3.0  # standard errors among neighbourhoods, by which it has to be less
_AS_GOOD = 1.25  # times the least energy of all rivals: of these the one with the fewest causes


@dataclass(frozen=True)
class _Left:
    """What an account leaves of withheld samples: m2 (sum of squares) by neighbourhood, and how many samples there are."""

    energy: Array
    count: int

    @property
    def rms(self) -> float:
        """m."""
        return float(np.sqrt(self.energy.sum() / max(self.count, 1)))


def judge_accounts(
    model: Model, trial: Trial, withheld: Sequence[Scene], library: Sequence[Effect], *, in_world: bool
) -> tuple[Verdict, Trial]:
    """The verdict on effects, and the withheld samples that it was held to: by the rival account where there is one, and what is
    claimed by it leaves far less of named withheld logs than what is claimed by the first.
    """
    verdict = judge_effects(model, trial, library, in_world=in_world)
    rival = rival_account(model, trial)
    if rival is None:
        return verdict, trial
    asked = frozen_frames(rival, trial_of(rival, withheld))
    other = judge_effects(rival, asked, library, in_world=in_world)
    better = other.shrunk.rms_after**2 <= _LEAST * verdict.shrunk.rms_after**2
    return (other, asked) if better else (verdict, trial)


def rival_account(model: Model, trial: Trial) -> Model | None:
    """The comparison without a smooth field beside the causes, each row weighing as little as what stays says, where that leaves
    surely and far less of named withheld logs; sets of effects are weighed over both accounts. Else None.
    """
    if not trial.named or model.discrepancy < model.noise:
        return None
    first = _left(model, trial)
    if len(first.energy) < 2 or first.rms < _ROOM * model.noise:
        return None
    rivals: list[tuple[Model, _Left]] = []
    for rival in _rivals(model):
        left = _left(rival, trial)
        if not rivals and left.energy.sum() > _HOPELESS * first.energy.sum():
            return None
        rivals.append((rival, left))
    least = min(float(left.energy.sum()) for _, left in rivals)
    members = next(r.best.members for r, left in rivals if left.energy.sum() <= _AS_GOOD * least)
    # of one set the last, whose rows weigh most nearly what it leaves
    rival, left = [(r, left) for r, left in rivals if r.best.members == members][-1]
    gained = first.energy - left.energy
    error = float(gained.std() * np.sqrt(len(gained)))
    far_less = left.energy.sum() <= _LEAST * first.energy.sum() and gained.sum() >= _ERRORS * error
    if not rival.evidence.effects_of(members) or not far_less:
        return None
    odds = 0.5 * len(gained) * float(np.log(first.energy.sum() / left.energy.sum()))
    share = 1.0 / (1.0 + float(np.exp(-odds)))
    names = [*rival.sets, *(n for n in model.sets if n not in rival.sets)]
    sets = {n: share * rival.sets.get(n, 0.0) + (1.0 - share) * model.sets.get(n, 0.0) for n in names}
    return replace(rival, sets=dict(sorted(sets.items(), key=lambda item: -item[1])))


def _rivals(model: Model) -> Iterator[Model]:
    """Comparisons without a field, each with more causes than the one before; values are fitted at the temperature that the rest
    has.
    """
    free = replace(model.evidence, sizes=no_sizes())
    starts: tuple[frozenset[int], ...] = ()
    nothing = np.zeros((len(model.basis.part), 6))
    for heat in _HEATS:
        evidence = replace(free, temperature=heat)
        found = explore(evidence, starts)
        starts = (found.best.members,)
        own = replace(free, temperature=max(1.0, temperatures(model.panels, found.best.mean, nothing)[0]))
        rival = replace(model, evidence=own, best=own.fit(found.best.members), heat_alone=None, scores=found.scores)
        rival = replace(rival, excess=_excess(rival, own))
        yield replace(
            rival, sets=posterior(found.scores, worth_counting(found.scores, found.counting), too_small(rival))
        )


def _excess(model: Model, evidence: Evidence) -> float:
    left = [p.y_tcp - p.twists(model.best.mean) for p in model.panels]
    return excess_beside(model.panels, evidence, model.best, left)


def _left(model: Model, trial: Trial) -> _Left:
    """What the best set and the discrepancy beside it, as far as it is known, leave of withheld logs."""
    energy, block, count = [], [], 0
    values = model.values(model.best.members, model.best)
    for k, rows, _ in trial.asked:
        p = trial.panels[k]
        rest = settled(model, p, rows, whole_gap(p)[rows] - p.moves(values, rows) - field_at(model, p, rows))
        energy.append(np.sum(rest**2, axis=1))
        block.append(p.block[rows])
        count += len(rest)
    _, number = np.unique(np.concatenate(block), return_inverse=True)
    return _Left(np.bincount(number, np.concatenate(energy)).astype(np.float64), count)
