"""What was not claimed and may be there all the same, and how far off what was claimed may be for that.

The covariance of a set's values takes for granted that the set is the right one. Sets with one unit more, and the same set beside
a larger or smaller discrepancy, are as far from it as their odds say (Hoeting et al., Statist. Sci. 14, 1999, 382, eq. 2 and 3):
where a lean and a compliance do the same on the logs, the compliance is known only as well as nobody's lean is excluded. What
such a set adds to the covariance leaves the tool where it was seen on the logs; elsewhere it doesn't.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.gap.evidence.discrepancy import PARTS
from camrob.gap.evidence.evidence import Evidence, Fitted
from camrob.gap.evidence.model import Model
from camrob.gap.unexplained import SIZE_DOUBT

__all__ = ["OpenDoubt", "open_doubt"]

Array = NDArray[np.float64]

_LEAST = 1e-3  # probability of a unit below which nothing it does shows in a band
_MOST = 12  # units, those that add most
_SHOWS = 1e-2  # of a variance, that a unit adds at the least to that of a claimed value
_KEPT = 1e-6  # of the largest variance in units of its value's doubt: what rounding leaves is smaller
# Gauss and Hermite's three nodes of a Gaussian, in its deviations, and their weights
_NODES, _WEIGHTS = (-(3.0**0.5), 3.0**0.5), (1.0 / 6.0, 1.0 / 6.0)


@dataclass(frozen=True)
class OpenDoubt:
    """units: numbers of those that were not claimed; root: (K + L, R), by whose square the covariance of the K claimed values and
    the L of these is more than that of the claimed ones alone.
    """

    units: tuple[int, ...]
    root: Array


def open_doubt(model: Model, members: frozenset[int], without: frozenset[int] = frozenset()) -> OpenDoubt:
    """The doubt beside the claimed units `members` of the best set; without: units that no other run has anything of."""
    evidence, owner = model.evidence, model.design.owner
    fitted = evidence.fit(model.best.members)
    own = np.flatnonzero(np.isin(owner, sorted(members)))
    entered = _entered(evidence, fitted, own, without)
    left = sorted(fitted.members - evidence.always - members - without)
    units = (*left, *(i for i, _, _ in entered))
    columns = np.concatenate([own, *(np.flatnonzero(owner == i) for i in units)]).astype(np.int64)
    more = np.zeros((len(columns), len(columns)))
    plain = _block(fitted, columns, own)
    if left:  # fitted with the others, and not reckoned with
        some = np.isin(owner[columns], left) | np.isin(columns, own)
        apart = np.where(np.isin(owner[columns], left), fitted.mean[columns], 0.0)
        more += (fitted.spread.block(columns) * np.outer(some, some)) - plain + np.outer(apart, apart)
    for i, probability, one in entered:
        held = np.concatenate([own, np.flatnonzero(owner == i)])
        apart = np.where(np.isin(columns, held), one.mean[columns], 0.0)
        apart[: len(own)] -= fitted.mean[own]
        more += probability * (_block(one, columns, held) - plain + np.outer(apart, apart))
    for share, sized in _other_sizes(evidence):
        one = sized.fit(fitted.members)
        apart = np.zeros(len(columns))
        apart[: len(own)] = (one.mean - fitted.mean)[own]
        more += share * (_block(one, columns, own) - plain + np.outer(apart, apart))
    return OpenDoubt(units, _root(more))


def _entered(
    evidence: Evidence, fitted: Fitted, own: NDArray[np.int64], without: frozenset[int]
) -> list[tuple[int, float, Fitted]]:
    """Units that may be there beside a set, how probable each is by itself, and the set with it."""
    doubt = np.sqrt(np.diag(fitted.spread.block(own)))
    found = []
    for unit, score, moved in zip(*(x.tolist() for x in evidence.changes(fitted)), strict=True):
        odds = score - fitted.score
        if unit in fitted.members or unit in without or odds < np.log(_LEAST):
            continue
        one = evidence.fit(fitted.members | {unit})
        probability = float(1.0 / (1.0 + np.exp(-odds)))
        apart = np.abs(one.mean - fitted.mean)[own] / np.maximum(doubt, 1e-300)
        adds = probability * max(float(apart.max(initial=0.0)) ** 2, (moved / evidence.noise) ** 2)
        if adds > _SHOWS:
            found.append((adds, unit, probability, one))
    found.sort(key=lambda f: -f[0])
    return [(unit, probability, one) for _, unit, probability, one in found[:_MOST]]


def _other_sizes(evidence: Evidence) -> list[tuple[float, Evidence]]:
    """The evidence beside a smooth discrepancy that is smaller and larger than was found, with the weight of each."""
    if evidence.sizes is None or evidence.field is None:
        return []
    smooth = np.array([part in ("posture", "travel") for part in PARTS])
    factors = [np.where(smooth, np.exp(SIZE_DOUBT * node), 1.0) for node in _NODES]
    return [(w, replace(evidence, sizes=evidence.sizes * f)) for w, f in zip(_WEIGHTS, factors, strict=True)]


def _block(fitted: Fitted, columns: NDArray[np.int64], held: NDArray[np.int64]) -> Array:
    """(C, C) covariance of parameters, 0 for those that are not held."""
    own = np.isin(columns, held)
    return np.asarray(fitted.spread.block(columns) * np.outer(own, own))


def _root(more: Array) -> Array:
    """(C, R) whose square is a covariance, as far as that has no negative part: priors that are fitted anew may make one."""
    size = np.sqrt(np.maximum(np.diag(more), 0.0))
    scale = np.where(size > 0.0, size, 1.0)
    values, vectors = np.linalg.eigh(0.5 * (more + more.T) / np.outer(scale, scale))
    kept = values > _KEPT * max(float(values.max(initial=0.0)), 1e-300)
    return np.asarray(scale[:, None] * vectors[:, kept] * np.sqrt(values[kept]))
