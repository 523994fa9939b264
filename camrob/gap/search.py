"""The sets of effects worth comparing: best first, adding, dropping and exchanging units until nothing better turns up."""

from __future__ import annotations

import numpy as np

from camrob.gap.evidence import Evidence, Fitted

__all__ = ["explore", "posterior"]

Set = frozenset[int]

_MOST_FITS = 90
_CLOSE = 9.0  # log units below the best: not worth a look any more
_EXCHANGE = 4  # of the best sets, how many are looked at with each member left out


def explore(evidence: Evidence, starts: tuple[Set, ...] = ()) -> tuple[dict[Set, float], Fitted]:
    """Scores of all sets met, and the best one's posterior. Starts from nothing, and from `starts`."""
    scores: dict[Set, float] = {}
    fits: dict[Set, Fitted] = {}

    def look(members: Set) -> None:
        if members in fits or len(fits) >= _MOST_FITS:
            return
        fits[members] = evidence.fit(members)
        scores[members] = fits[members].score
        for other, score in evidence.neighbours(fits[members]).items():
            if other not in fits:
                scores[other] = score

    for start in (evidence.always, *starts):
        look(start | evidence.always)
    while len(fits) < _MOST_FITS:
        best = max(scores.values())
        waiting = [m for m, s in scores.items() if m not in fits and s > best - _CLOSE]
        if waiting:
            look(max(waiting, key=lambda m: scores[m]))
            continue
        leading = sorted(scores, key=lambda m: -scores[m])[:_EXCHANGE]
        without = [m - {i} for m in leading for i in m if i not in evidence.always and m - {i} not in fits]
        if not without:
            break
        for members in without:
            look(members)
    top = max(fits, key=lambda m: fits[m].score)
    return scores, fits[top]


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
