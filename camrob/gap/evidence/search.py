"""The sets of effects worth comparing: best first, adding, dropping and exchanging units until nothing better turns up."""

from __future__ import annotations

import heapq
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from camrob.gap.evidence.evidence import COUNTS_FROM, Evidence, Fitted

__all__ = ["explore", "posterior"]

Set = frozenset[int]

_MOST_FITS = 90  # at the most, for the time it takes: most searches end by themselves
_CLOSE = 9.0  # log units below the best: not worth a look any more
_HOLLOW = 0.12  # of the noise
_SURE = 0.02  # probability that is as good as none
_EXCHANGE = 4  # of the best sets, how many are looked at with each member left out
# times every effect is taken out, units then changed, and sets looked at after that
_ROUNDS, _STEPS, _MORE_FITS = 3, 8, 30


def explore(
    evidence: Evidence, starts: tuple[Set, ...] = ()
) -> tuple[dict[Set, float], dict[Set, Mapping[str, float]], Fitted]:
    """Scores of all sets met, their effects and how probable it is that each counts, and the best one's posterior.

    Starts from nothing, and from `starts`.

    Climbs to a set that no single unit betters; then takes each of its effects out and climbs without it, as one effect may
    stand in for two others.
    """
    met = _Met(evidence, {}, {}, set(), {}, [])
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
    return met.scores, met.names, met.best


@dataclass(frozen=True, slots=True)
class _Met:
    """Sets met so far. scores: of all; names: of their effects that count; hollow: with a last unit that
    hardly moves the TCP, not worth a look; fits: of those looked at; waiting: a heap of (- score, order, set), which may hold
    sets that were looked at since, or got another score.
    """

    evidence: Evidence
    scores: dict[Set, float]
    names: dict[Set, Mapping[str, float]]
    hollow: set[Set]
    fits: dict[Set, Fitted]
    waiting: list[tuple[float, int, Set]]

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
            seen = self.evidence.seen(fitted)
            self.names[members] = seen
            for other, (score, moved) in self.evidence.neighbours(fitted).items():
                if other not in self.fits:
                    self._meet(other, score, moved, members, seen)
        return self.fits[members]

    def _meet(self, other: Set, score: float, moved: float, members: Set, seen: Mapping[str, float]) -> None:
        """Note a neighbour of a set whose effects were seen to count by so much."""
        self.scores[other] = score
        heapq.heappush(self.waiting, (-score, len(self.scores), other))
        (unit,) = other ^ members
        name = self.evidence.design.units[unit].effect
        if unit in members:
            left = self.evidence.effects_of(other)
            self.names[other] = {n: p for n, p in seen.items() if n in left}
            return
        counts = float(moved >= COUNTS_FROM * self.evidence.noise)
        self.names[other] = {**seen, name: max(counts, seen.get(name, 0.0))}
        if moved < _HOLLOW * self.evidence.noise:
            self.hollow.add(other)

    def _next(self) -> Set | None:
        """The best set that was met and not looked at, where it is near the best of all."""
        while self.waiting:
            score, _, members = self.waiting[0]
            if members not in self.fits and members not in self.hollow and self.scores[members] == -score:
                return members if -score > max(self.scores.values()) - _CLOSE else None
            heapq.heappop(self.waiting)
        return None

    def climb(self, most: int) -> None:
        """Look at sets near the best, at `most` in all."""
        while len(self.fits) < most:
            promising = self._next()
            if promising is not None:
                self.look(promising)
                continue
            leading = heapq.nlargest(_EXCHANGE, self.scores.keys() - self.hollow, key=lambda m: self.scores[m])
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
            near = {
                m: s for m, (s, _) in self.evidence.neighbours(now).items() if name not in self.evidence.effects_of(m)
            }
            if not near or max(near.values()) <= now.score:
                return
            now = self.look(max(near, key=lambda m: near[m]))


def posterior(
    scores: Mapping[Set, float], counting: Mapping[Set, Mapping[str, float]], small: frozenset[str] = frozenset()
) -> dict[frozenset[str], float]:
    """Probabilities of sets of effects, from the scores of sets of units and how probable it is that their effects count;
    those of `small` don't.
    """
    best = max(scores.values())
    total: dict[frozenset[str], float] = {}
    for members, score in scores.items():
        if score > best - 30.0:
            for names, p in _counted(counting[members], small):
                total[names] = total.get(names, 0.0) + p * float(np.exp(score - best))
    sum_ = sum(total.values())
    return {names: p / sum_ for names, p in sorted(total.items(), key=lambda item: -item[1])}


def _counted(counting: Mapping[str, float], small: frozenset[str]) -> list[tuple[frozenset[str], float]]:
    """Sets of those effects that count, and how probable each is."""
    out = [(frozenset[str](), 1.0)]
    for name, p in counting.items():
        if name in small or p < _SURE:
            continue
        if p > 1.0 - _SURE:
            out = [(names | {name}, q) for names, q in out]
        else:
            out = [(names | {name}, q * p) for names, q in out] + [(names, q * (1.0 - p)) for names, q in out]
    return out
