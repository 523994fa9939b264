"""The sets of effects worth comparing: best first, adding, dropping and exchanging units until nothing better turns up."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from camrob.gap.evidence.evidence import COUNTS_FROM, Evidence, Fitted

__all__ = ["Counting", "explore", "posterior", "worth_counting"]

Set = frozenset[int]
Counting = Callable[[], Mapping[str, float]]
"""The effects of a set, and how probable it is that each counts: of many sets, few are asked."""

_MOST_FITS = 90  # at the most, for the time it takes: most searches end by themselves
_CLOSE = 9.0  # log units below the best: not worth a look any more
_WORTH = 30.0  # log units below the best from which a set's probability is nothing
_HOLLOW = 0.12  # of the noise
_SURE = 0.02  # probability that is as good as none
_EXCHANGE = 4  # of the best sets, how many are looked at with each member left out
# times every effect is taken out, units then changed, and sets looked at after that
_ROUNDS, _STEPS, _MORE_FITS = 3, 8, 30


def explore(evidence: Evidence, starts: tuple[Set, ...] = ()) -> tuple[dict[Set, float], dict[Set, Counting], Fitted]:
    """Scores of all sets met, their effects and how probable it is that each counts, and the best one's posterior.

    Starts from nothing, and from `starts`.

    Climbs to a set that no single unit betters; then takes each of its effects out and climbs without it, as one effect may
    stand in for two others.
    """
    met = _Met(evidence, {}, {}, set(), {}, [], [])
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
    sets that were looked at since, or got another score; ranks: the same of all sets.
    """

    evidence: Evidence
    scores: dict[Set, float]
    names: dict[Set, Counting]
    hollow: set[Set]
    fits: dict[Set, Fitted]
    waiting: list[tuple[float, int, Set]]
    ranks: list[tuple[float, int, Set]]

    @property
    def best(self) -> Fitted:
        """The best set looked at."""
        return max(self.fits.values(), key=lambda f: f.score)

    @property
    def _top(self) -> float:
        """The best score of all."""
        while self.scores[self.ranks[0][2]] != -self.ranks[0][0]:
            heapq.heappop(self.ranks)  # it got another score since
        return -self.ranks[0][0]

    def look(self, members: Set) -> Fitted:
        """Fit a set, and score its neighbours."""
        if members not in self.fits:
            fitted = self.evidence.fit(members)
            self.fits[members] = fitted
            self._score(members, fitted.score)
            seen = self.evidence.seen(fitted)
            self.names[members] = lambda: seen
            counted = _Counted(self.evidence, members, seen)
            for unit, score, moved in self.evidence.changes(fitted):
                other = members ^ {unit}
                if other not in self.fits:
                    heapq.heappush(self.waiting, self._score(other, score))
                    self.names[other] = partial(counted.with_change, unit, moved)
                    if unit not in members and moved < _HOLLOW * self.evidence.noise:
                        self.hollow.add(other)
        return self.fits[members]

    def _score(self, members: Set, score: float) -> tuple[float, int, Set]:
        """Note a set's score; gives its entry in a heap."""
        self.scores[members] = score
        entry = -score, len(self.scores), members
        heapq.heappush(self.ranks, entry)
        return entry

    def _next(self) -> Set | None:
        """The best set that was met and not looked at, where it is near the best of all."""
        while self.waiting:
            score, _, members = self.waiting[0]
            if members not in self.fits and members not in self.hollow and self.scores[members] == -score:
                return members if -score > self._top - _CLOSE else None
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
            # the effect is out: a set beside this one holds it where it is that which enters
            near = [(s, i) for i, s, _ in self.evidence.changes(now) if units[i].effect != name]
            score, unit = max(near, key=lambda x: x[0], default=(-np.inf, 0))
            if score <= now.score:
                return
            now = self.look(now.members ^ {unit})


class _Counted:
    """How probable it is that each effect counts in the sets beside one, by what they change: many sets have one answer."""

    def __init__(self, evidence: Evidence, members: Set, seen: Mapping[str, float]) -> None:
        self._evidence, self._members, self._seen = evidence, members, seen
        self._left: dict[str, int] = {}
        for i in members - evidence.always:
            name = evidence.design.units[i].effect
            self._left[name] = self._left.get(name, 0) + 1
        self._known: dict[tuple[str, float], Mapping[str, float]] = {}

    def with_change(self, unit: int, moved: float) -> Mapping[str, float]:
        """With a unit entered, which then moves the TCP by so much, m, or left out where it was in."""
        name = self._evidence.design.units[unit].effect
        if unit in self._members:
            return self._seen if self._left[name] > 1 else self._answer(name, -1.0)
        return self._answer(name, float(moved >= COUNTS_FROM * self._evidence.noise))

    def _answer(self, name: str, counts: float) -> Mapping[str, float]:
        """With an effect that counts or not, or without it where that is negative."""
        if (name, counts) not in self._known:
            others = {n: p for n, p in self._seen.items() if n != name}
            self._known[name, counts] = (
                others if counts < 0.0 else {**self._seen, name: max(counts, self._seen.get(name, 0.0))}
            )
        return self._known[name, counts]


def worth_counting(scores: Mapping[Set, float], counting: Mapping[Set, Counting]) -> dict[Set, Mapping[str, float]]:
    """What counts in those sets whose probability is more than nothing."""
    best = max(scores.values())
    return {members: counting[members]() for members, score in scores.items() if score > best - _WORTH}


def posterior(
    scores: Mapping[Set, float], counting: Mapping[Set, Mapping[str, float]], small: frozenset[str] = frozenset()
) -> dict[frozenset[str], float]:
    """Probabilities of sets of effects, from the scores of sets of units and how probable it is that their effects count;
    those of `small` don't.
    """
    best = max(scores.values())
    total: dict[frozenset[str], float] = {}
    for members, score in scores.items():
        if score > best - _WORTH:
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
