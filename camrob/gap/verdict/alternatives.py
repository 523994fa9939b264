"""Sets of effects with what is believed of them: the evidence, doubted as much as the names in them are."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from camrob.gap.verdict.belief import BELIEF
from camrob.summaries.diagnosis_summary import Alternative

__all__ = ["alternatives"]

Set = frozenset[str]

# of the probability: the likeliest sets that hold as much are reported, and no name that all else holds
_REPORTED = 0.97


def alternatives(sets: Mapping[Set, float], probability: Mapping[str, float]) -> list[Alternative]:
    """The likeliest sets of effects with their probabilities, the unknown beside them or not; they sum to 1.

    sets: by the evidence; probability: of each effect, as it is believed after all doubts. A set is believed no more than each
    name in it; what is taken from it goes to what is left of it without the doubted names, and at last to the unknown alone. What
    makes one name wrong (a foreign cause, a description that is off) makes the others wrong too, so doubts fall together. Names
    that sets which are left out may hold as well, as all of theirs together are no likelier, are left open: each would double the
    number of sets.
    """
    total: dict[Set, float] = {}
    for names, p in sets.items():
        known = names - {"unknown"}
        total[known] = total.get(known, 0.0) + p
    whole = sum(p**BELIEF.slope for p in total.values())
    tempered = {names: p**BELIEF.slope / whole for names, p in total.items()}
    out = sorted(_without_unlikely(_doubted(tempered, probability)).items(), key=lambda x: (-x[1], sorted(x[0])))
    held = np.cumsum([p for _, p in out])
    kept = out[: int(np.searchsorted(held, _REPORTED * held[-1])) + 1]
    said = sum(p for _, p in kept)
    return [Alternative(effects=tuple(sorted(names)), probability=p / said) for names, p in kept]


def _without_unlikely(sets: Mapping[Set, float]) -> dict[Set, float]:
    """Sets without the names that are less likely than what need not be reported."""
    held = {n: sum(p for s, p in sets.items() if n in s) for s in sets for n in s}
    out: dict[Set, float] = {}
    for names, p in sets.items():
        kept = frozenset(n for n in names if held[n] >= 1.0 - _REPORTED)
        out[kept] = out.get(kept, 0.0) + p
    return out


def _doubted(sets: Mapping[Set, float], probability: Mapping[str, float]) -> dict[Set, float]:
    """Sets of which none of the names is more probable than it is believed to be."""
    names = {n for s in sets for n in s}
    evidence = {n: sum(p for s, p in sets.items() if n in s) for n in names}
    kept = {n: min(1.0, probability.get(n, 0.0) / max(evidence[n], 1e-12)) for n in names}
    out: dict[Set, float] = {}
    for members, p in sets.items():
        left, given = members, 0.0
        # the most doubted name is the first to go
        for name in sorted(members, key=lambda n: (kept[n], n)):
            out[left] = out.get(left, 0.0) + p * (kept[name] - given)
            left, given = left - {name}, kept[name]
        out[left] = out.get(left, 0.0) + p * (1.0 - given)
    return out
