"""The sets of effects worth comparing: best first, adding, dropping and exchanging units until nothing better turns up."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from camrob.gap.evidence.evidence import COUNTS_FROM, Evidence, Fitted

__all__ = ["Counting", "Explored", "explore", "posterior", "worth_counting"]

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


def explore(evidence: Evidence, starts: tuple[Set, ...] = ()) -> Explored:
    """Sets of units, from nothing and from `starts`.

    Climbs to a set that no single unit betters; then takes each of its effects out and climbs without it, as one effect may
    stand in for two others.
    """
    met = Explored(evidence)
    for start in (evidence.always, *starts):
        met.look(start | evidence.always)
    met.climb(_MOST_FITS)
    for _ in range(_ROUNDS):
        top = met.best
        for name in sorted(evidence.effects_of(top.members)):
            met.stand_in(top.members, name)
        met.climb(len(met.looks) + _MORE_FITS)
        if met.best.members == top.members:
            break
    return met


@dataclass(frozen=True, slots=True)
class _Look:
    """A set that was looked at, and those beside it: each with one of `units` more or less, its score, and by how much, m, that
    unit then moves the TCP; order: of those beside it, best first, its own place -1 among them.
    """

    fitted: Fitted
    counted: _Counted
    units: list[int]
    scores: list[float]
    moved: list[float]
    order: list[int]


class Explored:
    """Sets met so far, as numbers with a bit a unit: there are thousands, and most are never asked for. looks: at sets, by
    number. Within: scores of all; places: of each, the look that met it last and which of its neighbours it is, -1 for itself;
    hollow: those with a last unit that hardly moves the TCP, not worth a look.
    """

    def __init__(self, evidence: Evidence) -> None:
        self.evidence = evidence
        self.looks: dict[int, _Look] = {}
        self._scores: dict[int, float] = {}
        self._places: dict[int, tuple[int, int]] = {}
        self._hollow: set[int] = set()
        # heaps of (- score, how many looks there were, look, how many of its sets stand before this one): of each look the best
        # set that may still be one, where all before it have been passed
        self._waiting: list[tuple[float, int, int, int]] = []
        self._ranks: list[tuple[float, int, int, int]] = []

    @property
    def best(self) -> Fitted:
        """The best set looked at."""
        return max((x.fitted for x in self.looks.values()), key=lambda f: f.score)

    @property
    def scores(self) -> dict[Set, float]:
        """Of all sets met."""
        return {self._members(place): self._scores[number] for number, place in self._places.items()}

    @property
    def counting(self) -> dict[Set, Counting]:
        """Of all sets met, their effects and how probable it is that each counts."""
        return {self._members(place): self._counting(place) for place in self._places.values()}

    def _members(self, place: tuple[int, int]) -> Set:
        """The set at a place."""
        look, k = self.looks[place[0]], place[1]
        return look.fitted.members if k < 0 else look.fitted.members ^ {look.units[k]}

    def _counting(self, place: tuple[int, int]) -> Counting:
        look, k = self.looks[place[0]], place[1]
        return look.counted.itself if k < 0 else partial(look.counted.with_change, look.units[k], look.moved[k])

    def _number(self, place: tuple[int, int]) -> int:
        return place[0] if place[1] < 0 else place[0] ^ (1 << self.looks[place[0]].units[place[1]])

    def look(self, members: Set) -> Fitted:
        """Fit a set, and score its neighbours."""
        own = sum(1 << i for i in members)
        if own not in self.looks:
            fitted = self.evidence.fit(members)
            units, scores, moved = (x.tolist() for x in self.evidence.changes(fitted))
            counted = _Counted(self.evidence, members, self.evidence.seen(fitted))
            look = self.looks[own] = _Look(fitted, counted, units, scores, moved, [-1])
            self._scores[own], self._places[own] = fitted.score, (own, -1)
            faint = _HOLLOW * self.evidence.noise
            for k, (unit, score) in enumerate(zip(units, scores, strict=True)):
                other = own ^ (1 << unit)
                if other not in self.looks:
                    self._scores[other], self._places[other] = score, (own, k)
                    look.order.append(k)
                    if other > own and moved[k] < faint:
                        self._hollow.add(other)
            look.order.sort(key=lambda k: -fitted.score if k < 0 else -scores[k])
            for heap in (self._waiting, self._ranks):
                self._push(heap, own, 0)
        return self.looks[own].fitted

    def _push(self, heap: list[tuple[float, int, int, int]], own: int, first: int) -> None:
        """Note the next set of a look, where there is one."""
        look = self.looks[own]
        if first < len(look.order):
            k = look.order[first]
            score = look.fitted.score if k < 0 else look.scores[k]
            heapq.heappush(heap, (-score, len(self.looks), own, first))

    def _first(self, heap: list[tuple[float, int, int, int]], *, open_: bool) -> tuple[float, tuple[int, int]] | None:
        """The best set of a heap, its score and its place; open_: of those that were not looked at and are worth it."""
        while heap:
            score, _, own, first = heap[0]
            place = own, self.looks[own].order[first]
            number = self._number(place)
            if self._scores[number] == -score and not (open_ and (number in self.looks or number in self._hollow)):
                return -score, place
            heapq.heappop(heap)  # it got another score since, or was looked at
            self._push(heap, own, first + 1)
        return None

    def _next(self) -> Set | None:
        """The best set that was met and not looked at, where it is near the best of all."""
        found, top = self._first(self._waiting, open_=True), self._first(self._ranks, open_=False)
        return self._members(found[1]) if found and top and found[0] > top[0] - _CLOSE else None

    def climb(self, most: int) -> None:
        """Look at sets near the best, at `most` in all."""
        while len(self.looks) < most:
            promising = self._next()
            if promising is not None:
                self.look(promising)
                continue
            rest = ((s, m) for m, s in self._scores.items() if m not in self._hollow)
            leading = [self._members(self._places[m]) for _, m in heapq.nlargest(_EXCHANGE, rest)]
            always = self.evidence.always
            without = [m - {i} for m in leading for i in m if i not in always]
            without = [m for m in without if sum(1 << i for i in m) not in self.looks]
            if not without:
                break
            for members in without[: most - len(self.looks)]:
                self.look(members)

    def stand_in(self, members: Set, name: str) -> None:
        """Take an effect out of a set, and add or drop one unit after the other while that helps, but none of that effect."""
        units = self.evidence.design.units
        now = self.look(frozenset(i for i in members if units[i].effect != name or i in self.evidence.always))
        for _ in range(_STEPS):
            look = self.looks[sum(1 << i for i in now.members)]
            # the effect is out: a set beside this one holds it where it is that which enters
            near = [(s, i) for s, i in zip(look.scores, look.units, strict=True) if units[i].effect != name]
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

    def itself(self) -> Mapping[str, float]:
        """In the set as it is."""
        return self._seen

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
