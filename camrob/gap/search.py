"""The sets of effects worth comparing: best first, adding, dropping and exchanging units until nothing better turns up."""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np

from camrob.gap.evidence import Evidence, Fitted

__all__ = ["explore", "posterior"]

Set = frozenset[int]

_MOST_FITS = 90
_CLOSE = 9.0  # log units below the best: not worth a look any more
_EXCHANGE = 4  # of the best sets, how many are looked at with each member left out
_ROUNDS, _STEPS, _MORE_FITS = 3, 8, 30  # times every effect is taken out, units then changed, and sets looked at after that


def explore(evidence: Evidence, starts: tuple[Set, ...] = ()) -> tuple[dict[Set, float], Fitted]:
    """Scores of all sets met, and the best one's posterior. Starts from nothing, and from `starts`.

    Climbs to a set that no single unit betters; then takes each of its effects out and climbs without it, as one effect may
    stand in for two others.
    """
    met = _Met(evidence, {}, {})
    for start in (evidence.always, *starts):
        met.look(start | evidence.always)
    met.climb(_MOST_FITS)
    for _ in range(_ROUNDS):
        top = met.best
        for name in sorted(evidence.effects_of(top.members)):
            met.stand_in(top.members, name)
        met.climb(len(met.fits) + _MORE_FITS)
        if met.best.members == top.members:
            break
    return met.scores, met.best


@dataclass(frozen=True, slots=True)
class _Met:
    """Sets met so far. scores: of all; fits: of those looked at."""

    evidence: Evidence
    scores: dict[Set, float]
    fits: dict[Set, Fitted]

    @property
    def best(self) -> Fitted:
        """The best set looked at."""
        return max(self.fits.values(), key=lambda f: f.score)

    def look(self, members: Set) -> Fitted:
        """Fit a set, and score its neighbours."""
        if members not in self.fits:
            fitted = self.evidence.fit(members)
            self.fits[members] = fitted
            self.scores[members] = fitted.score
            for other, score in self.evidence.neighbours(fitted).items():
                if other not in self.fits:
                    self.scores[other] = score
        return self.fits[members]

    def climb(self, most: int) -> None:
        """Look at sets near the best, at `most` in all."""
        while len(self.fits) < most:
            best = max(self.scores.values())
            waiting = [m for m, s in self.scores.items() if s > best - _CLOSE and m not in self.fits]
            if waiting:
                self.look(max(waiting, key=lambda m: self.scores[m]))
                continue
            leading = heapq.nlargest(_EXCHANGE, self.scores, key=lambda m: self.scores[m])
            always = self.evidence.always
            without = [m - {i} for m in leading for i in m if i not in always and m - {i} not in self.fits]
            if not without:
                break
            for members in without[: most - len(self.fits)]:
                self.look(members)

    def stand_in(self, members: Set, name: str) -> None:
        """Take an effect out of a set, and add or drop one unit after the other while that helps, but none of that effect."""
        units = self.evidence.design.units
        now = self.look(frozenset(i for i in members if units[i].effect != name or i in self.evidence.always))
        for _ in range(_STEPS):
            near = {m: s for m, s in self.evidence.neighbours(now).items() if name not in self.evidence.effects_of(m)}
            if not near or max(near.values()) <= now.score:
                return
            now = self.look(max(near, key=lambda m: near[m]))


def posterior(
    evidence: Evidence, scores: dict[Set, float], small: frozenset[str] = frozenset()
) -> dict[frozenset[str], float]:
    """Probabilities of sets of effects, from the scores of sets of units; effects that are `small` don't count."""
    best = max(scores.values())
    total: dict[frozenset[str], float] = {}
    for members, score in scores.items():
        if score > best - 30.0:
            names = evidence.effects_of(members) - small
            total[names] = total.get(names, 0.0) + float(np.exp(score - best))
    sum_ = sum(total.values())
    return {names: p / sum_ for names, p in sorted(total.items(), key=lambda item: -item[1])}
