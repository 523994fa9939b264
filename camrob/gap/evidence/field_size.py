"""How large the discrepancy is: its sizes by stage and part, at which the data beside a set of effects are most probable."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve
from scipy.linalg.lapack import dpotrf
from scipy.special import logsumexp

from camrob.gap.evidence.discrepancy import PARTS, FieldGram, Integrated
from camrob.gap.evidence.evidence import Evidence, Fitted
from camrob.gap.observation.noise import Noise

__all__ = ["fit_sizes", "no_sizes", "over_sizes", "row_noise", "sizes_beside"]

Array = NDArray[np.float64]

_SMALLEST, _LARGEST = 0.15, 2e4  # times the noise of one row of the twist
_STEPS = (4.0, 2.0, 1.4)  # factors by which a size is tried larger and smaller, one after the other
_TURNS = 2
_FACTORS = (0.0, 0.5, 0.7, 1.0, 1.4, 2.0)  # of the likeliest sizes, over which sets are weighed
_STAND_INS, _STANDS = (PARTS.index("time"), PARTS.index("travel")), 0.5  # parts, and their size in that of posture's
_WEIGHED, _CLOSE = 16, 9.0  # sets that are, at the most, and log units below the best
_APPEARS = 3.0  # log odds against a part of the discrepancy being there at all


def no_sizes() -> Array:
    """(2, parts) of a discrepancy that is not there."""
    return np.zeros((2, len(PARTS)))


def fit_sizes(
    evidence: Evidence, fitted: Fitted, start: Array, noise: tuple[float, float], parts: Sequence[str] = PARTS
) -> Array:
    """(2, parts) sizes of the discrepancy of shifts, m, and of turns, rad, beside a set of effects with the widths it has now.

    start: from where; noise: of one row, m and rad; parts: those that may be there.
    """
    field = evidence.field
    if field is None:
        return no_sizes()
    own = np.flatnonzero(np.isin(evidence.design.owner, list(fitted.members)))
    used = [i for i in range(len(evidence.design.yy)) if i not in evidence.left_out]
    d = evidence.design
    sums = d.A[used].sum(axis=0)[np.ix_(own, own)], d.b[used].sum(axis=0)[own], d.yy[used].sum()
    A, b, yy = (x / evidence.temperature for x in sums)
    small = FieldGram(
        field.C[used][:, :, own].sum(axis=0)[None],
        field.D[used].sum(axis=0)[None],
        field.d[used].sum(axis=0)[None],
        field.part,
    )
    w, whole = fitted.widths[own], Integrated(A, b, float(yy), 0.0)
    known: dict[tuple[int, bytes], Integrated] = {}  # of two stages one changes at a time

    def taken(stage: int, sizes: Array) -> Integrated:
        key = stage, sizes[stage].tobytes()
        if key not in known:
            known[key] = small.taken(stage, sizes, (0,))
        return known[key]

    def score(sizes: Array) -> float:
        got = whole.less([taken(k, sizes) for k in range(len(sizes))])
        P = got.A * np.outer(w, w)
        P[np.diag_indices_from(P)] += 1.0
        L, _ = dpotrf(P, lower=1, clean=1)
        right = got.b * w
        fit = -0.5 * (got.yy - float(right @ cho_solve((L, True), right)))
        return fit - got.half_log - float(np.log(np.diag(L)).sum()) - _APPEARS * np.count_nonzero(sizes)

    sizes, best = start.copy(), score(start)
    places = [
        (k, p) for p in map(PARTS.index, parts) for k in (0, 1) if (field.part == p).any() and small.D[0, 3 * k].any()
    ]
    for _ in range(_TURNS):
        for place in places:
            unit = noise[place[0]]
            first = sizes[place]
            for value in (0.0, unit) if first == 0.0 else (0.0,):
                sizes, best = _better(score, sizes, best, place, value)
            for step in _STEPS if sizes[place] > 0.0 else ():
                for factor in (step, 1.0 / step):
                    while _SMALLEST * unit < sizes[place] * factor < _LARGEST * unit:
                        tried, one = _better(score, sizes, best, place, sizes[place] * factor)
                        if tried is sizes:
                            break
                        sizes, best = tried, one
    return sizes


def row_noise(noises: Sequence[Noise]) -> tuple[float, float]:
    """Noise of one row of the twist, m and rad."""
    shift, turn = (float(np.sqrt(np.mean([n.tcp[k] ** 2 for n in noises]))) for k in (0, 3))
    return shift, turn


def sizes_beside(evidence: Evidence, members: frozenset[int], noises: Sequence[Noise]) -> Array:
    """(2, parts) sizes of the discrepancy beside some units, which may be fewer than those that it was sized beside."""
    start = no_sizes() if evidence.sizes is None else evidence.sizes
    return fit_sizes(evidence, evidence.fit(members | evidence.always), start, row_noise(noises))


def _better(
    score: Callable[[Array], float], sizes: Array, best: float, place: tuple[int, int], value: float
) -> tuple[Array, float]:
    """The sizes with another value at a place, and their score, where that is better; else as they were."""
    tried = sizes.copy()
    tried[place] = value
    one = score(tried)
    return (tried, one) if one > best else (sizes, best)


def over_sizes(
    evidence: Evidence, scores: Mapping[frozenset[int], float], noise: tuple[float, float]
) -> dict[frozenset[int], float]:
    """Scores of sets with the discrepancy's size integrated out; those far below the best as they would be if it changed
    nothing for them. noise: of one row, m and rad.
    """
    if evidence.design.field is None or evidence.sizes is None:
        return dict(scores)
    best = max(scores.values())
    order = sorted(scores, key=lambda m: -scores[m])
    leading = [m for m in order[:_WEIGHED] if scores[m] > best - _CLOSE]
    for name in sorted(evidence.effects_of(order[0])):
        leading += [m for m in (next((m for m in order if name not in evidence.effects_of(m)), None),) if m is not None]
    leading = list(dict.fromkeys(leading))
    table = []
    for sizes in _others(evidence.sizes, noise):
        one = replace(evidence, sizes=sizes)
        prior = -_APPEARS * np.count_nonzero(sizes)
        table.append([one.fit(m).score + prior for m in leading])
    whole = logsumexp(np.array(table), axis=0)
    offset = float(whole.max()) - best
    return {m: s + offset for m, s in scores.items()} | dict(zip(leading, whole.tolist(), strict=True))


def _others(sizes: Array, noise: tuple[float, float]) -> list[Array]:
    """Sizes about those that were fitted; where nothing was, none, and a field as large as the noise."""
    if sizes.any():
        # and with a part that isn't there beside these sets, but may stand in for one of their effects
        others = [sizes.copy() for p in _STAND_INS if not sizes[:, p].any() and sizes[0, 0] > 0.0]
        for one, p in zip(others, (p for p in _STAND_INS if not sizes[:, p].any()), strict=False):
            one[0, p] = _STANDS * sizes[0, 0]
        return [*(f * sizes for f in _FACTORS), *others]
    there = no_sizes()
    there[:, 0] = noise
    return [sizes, 0.5 * there, there]
