"""How much the data speak for each set of effects, from Gram matrices alone.

Every parameter has a Gaussian prior: wide (its ordinary size) where its unit is in, and else so narrow that all that is
left out together stays a nuisance within the noise. The evidence of a set is then exact, weighs fit against freedom, and
one factorisation of the posterior gives that of all sets which differ in one unit (matrix determinant lemma).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import pairwise
from math import comb, log
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgetrf, dgetrs, dpotrf, dpotri
from scipy.special import ndtr

from camrob.gap.evidence.design import NUISANCE, Design
from camrob.gap.evidence.discrepancy import FieldGram, Integrated
from camrob.gap.evidence.single_changes import single_changes

__all__ = ["COUNTS_FROM", "Evidence", "Fitted", "Spread"]

Array = NDArray[np.float64]
Set = frozenset[int]

NUISANCE_SHARE = 0.06  # of the noise's rms: what an effect that counts as absent may still move the TCP by
_SHARES = (3.0, 1.0, 0.3, 0.1)
_WIDEST = 5.0  # times the ordinary sizes
COUNTS_FROM = 0.35  # of the noise's rms: an effect that moves the TCP by less is a nuisance
_LEAST_MOVE = 0.3  # of the noise's rms: what a unit is taken to move the TCP by at least
_TURNS = 2
_FAINT = 1e-9  # m: a size that is known that well is known
_CANCELS, _STRAIN = 3.0, 3.0  # times the energy of the whole from which effects' energies cost, and how dearly
_COUNTS = (0.22, 0.36, 0.27, 0.12, 0.027, 0.003)  # prior of how many effects a cell has


@cache
def _log_comb(n: int, k: int) -> float:
    return log(comb(n, k))


@dataclass(frozen=True)
class Spread:
    """How far all parameters may be off: covariance (base - let X^T) scale scale^T, SI. base: (K, K) with every unit out, let, X:
    (K, n) by how much less it is as n are let loose; scale: (K,). Most questions are put to a few entries of it.
    """

    base: Array
    let: Array
    X: Array
    scale: Array

    def block(self, c: NDArray[np.int64]) -> Array:
        """(k, k) of some parameters."""
        inner = self.base[np.ix_(c, c)] - self.let[c] @ self.X[c].T
        return np.asarray(inner * np.outer(self.scale[c], self.scale[c]))


@dataclass(frozen=True)
class Fitted:
    """The posterior of one set. mean, spread: of all parameters, SI; score: log evidence and prior; widths: of the priors,
    shares: what they are of the ordinary sizes, by effect.
    """

    members: Set
    mean: Array
    spread: Spread
    score: float
    widths: Array
    shares: Mapping[str, float]

    @cached_property
    def cov(self) -> Array:
        """(K, K) covariance of all parameters."""
        return self.spread.block(np.arange(len(self.mean)))


@dataclass(frozen=True)
class Evidence:
    """The comparison of sets of units (frozensets of their numbers). noise: 3-D rms, m; temperature: rows that one independent
    row stands for, as what stays is more than noise and hangs together: all weights are lowered by it; left_out: (B,) blocks that
    take no part; sizes: of the discrepancy that is integrated out, see `FieldGram`, None for none.
    """

    design: Design
    noise: float
    temperature: float = 1.0
    left_out: tuple[int, ...] = ()
    sizes: Array | None = None

    @cached_property
    def _sums(self) -> Integrated:
        used = [i for i in range(len(self.design.yy)) if i not in self.left_out]
        d = self.design
        A, b, yy = (x[used].sum(axis=0) / self.temperature for x in (d.A, d.b, d.yy))
        if d.field is None or self.sizes is None:
            return Integrated(A, b, float(yy), 0.0)
        return d.field.integrated(A, b, float(yy), self.sizes, used, self.temperature)

    @cached_property
    def field(self) -> FieldGram | None:
        """The discrepancy's part, at the temperature."""
        return None if self.design.field is None else self.design.field.heated(self.temperature)

    @cached_property
    def _variants(self) -> dict[tuple[tuple[int, ...], float | None], Evidence]:
        return {}

    def variant(self, left_out: tuple[int, ...] = (), alone: float | None = None) -> Evidence:
        """The same without some blocks, and without the discrepancy at a temperature `alone`. Each is made once: what many sets
        have in common is most of the work.
        """
        if not left_out and alone is None:
            return self
        key = left_out, alone
        if key not in self._variants:
            one = replace(self, left_out=left_out)
            self._variants[key] = one if alone is None else replace(one, sizes=None, temperature=alone)
        return self._variants[key]

    @cached_property
    def always(self) -> Set:
        """Units that are always in."""
        return frozenset(i for i, u in enumerate(self.design.units) if u.effect == NUISANCE)

    @cached_property
    def candidates(self) -> tuple[int, ...]:
        """Units that may be in or out."""
        return tuple(i for i in range(len(self.design.units)) if i not in self.always)

    @cached_property
    def _widths(self) -> tuple[Array, Array]:
        """(K,) prior deviations where a unit is out, and where it is in."""
        d = self.design
        counts = np.bincount(d.owner, minlength=len(d.units))[d.owner]
        out = NUISANCE_SHARE * self.noise / (np.maximum(d.size, 1e-12) * np.sqrt(counts))
        return np.minimum(out, d.usual), d.usual

    @cached_property
    def _columns(self) -> list[NDArray[np.int64]]:
        return [np.flatnonzero(self.design.owner == i) for i in range(len(self.design.units))]

    @cached_property
    def _effects(self) -> dict[str, list[int]]:
        found: dict[str, list[int]] = {}
        for i in self.candidates:
            found.setdefault(self.design.units[i].effect, []).append(i)
        return found

    def effects_of(self, members: Set) -> frozenset[str]:
        """Names of the effects that a set holds."""
        return frozenset(self.design.units[i].effect for i in members if i not in self.always)

    def prior(self, members: Set) -> float:
        """Log prior: so many effects, any of them alike, and of each any of its units."""
        chosen: dict[str, int] = {}
        for i in members - self.always:
            name = self.design.units[i].effect
            chosen[name] = chosen.get(name, 0) + 1
        cost = sum(self._of_units(len(self._effects[name]), k) for name, k in chosen.items())
        return (
            self._of_count(len(chosen)) - cost - sum(log(self.design.units[i].choices) for i in members - self.always)
        )

    def _of_count(self, n: int) -> float:
        """Log prior of n effects, whichever they are."""
        total = log(_COUNTS[n]) if n < len(_COUNTS) else log(_COUNTS[-1]) - 6.0 * (n - len(_COUNTS) + 1)
        return total - _log_comb(max(len(self._effects), n), n)

    @staticmethod
    def _of_units(m: int, k: int) -> float:
        """What k of an effect's m units cost, whichever they are."""
        return log(m) + _log_comb(m, k) if k > 0 else 0.0

    @cached_property
    def _least(self) -> dict[str, float]:
        """By effect, the smallest share of the ordinary sizes that its priors may shrink to.

        Effects come small and large: with one width they would pay for that with every parameter.
        """
        d = self.design
        moved = np.bincount(d.owner, (d.size * d.usual) ** 2, len(d.units))
        return {
            name: float(np.clip(_LEAST_MOVE * self.noise / np.sqrt(max(float(moved[own].sum()), 1e-24)), 0.01, 1.0))
            for name, own in self._effects.items()
            if name != "unknown"
        }

    def fit(self, members: Set) -> Fitted:
        """The posterior of a set, and its score, at the widths of its effects' priors that speak best for it."""
        out, usual = self._widths
        inside = self._in(members)[self.design.owner]
        widths = np.where(inside, usual, out)
        names, c, edges = self._owned(members)
        columns = {n: c[a:b] for n, a, b in zip(names, edges, edges[1:], strict=False) if n in self._least}
        own = np.flatnonzero(inside)
        at = {name: np.searchsorted(own, c) for name, c in columns.items()}
        scale = self._widths[0][own]
        base, start = self._base[0][np.ix_(own, own)], self._base[1][own]
        shares: dict[str, float] = {}
        for _ in range(_TURNS if columns else 0):
            # all but these parameters are narrow, so that a small system tells how these are fitted
            change = (scale / widths[own]) ** 2 - 1.0
            X = np.linalg.solve(np.eye(len(own)) + change[:, None] * base, change[:, None] * np.c_[base, start])
            means = (start - base @ X[:, -1]) * scale
            spreads = (np.diag(base) - np.einsum("ij,ji->i", base, X[:, :-1])) * scale**2
            for name, c in columns.items():
                mean, spread = means[at[name]], spreads[at[name]]
                known = max(float(np.sum(1.0 - spread / widths[c] ** 2)), 0.3)
                share = float(np.sqrt(np.sum((mean / usual[c]) ** 2) / known))
                shares[name] = float(np.clip(share, self._least[name], _WIDEST))
                widths[c] = np.maximum(shares[name] * usual[c], out[c])
        fitted = self._solve(members, widths, shares)
        return replace(fitted, score=fitted.score + self._strain(members, fitted.mean))

    @cached_property
    def _base(self) -> tuple[Array, Array, float, float]:
        """The posterior with every unit out, in widths of the priors: covariance, mean, log evidence's fit, half a log det."""
        sums = self._sums
        A, b, yy = sums.A, sums.b, sums.yy
        scale = self._widths[0]
        P = A * np.outer(scale, scale)
        P[np.diag_indices_from(P)] += 1.0
        L, _ = dpotrf(P, lower=1, clean=1)
        C, _ = dpotri(L, lower=1)
        C = np.tril(C) + np.tril(C, -1).T
        mean = C @ (b * scale)
        return C, mean, -0.5 * (yy - float((b * scale) @ mean)), float(np.log(np.diag(L)).sum()) + sums.half_log

    def _solve(self, members: Set, widths: Array, shares: Mapping[str, float]) -> Fitted:
        """The posterior at given widths (K,) of the priors, and the score: `_base` with the wider ones let loose (Woodbury)."""
        own = np.flatnonzero(widths != self._widths[0])
        C, mean, fit, half = self._base
        scale = self._widths[0]
        if len(own) == 0:
            score = fit - half + self.prior(members)
            none = np.zeros((len(C), 0))
            return Fitted(members, mean * scale, Spread(C, none, none, scale), score, widths.copy(), dict(shares))
        ratio = (scale[own] / widths[own]) ** 2
        change = ratio - 1.0
        let = C.take(own, axis=1)
        M = change[:, None] * let[own]
        M[np.diag_indices_from(M)] += 1.0
        lu, pivots, _ = dgetrf(M)
        X, _ = dgetrs(lu, pivots, change[:, None] * np.c_[let.T, mean[own]])
        fit -= 0.5 * float(mean[own] @ X[:, -1])
        half += 0.5 * float(np.log(np.abs(np.diag(lu))).sum())
        score = float(fit - half + 0.5 * np.log(ratio).sum()) + self.prior(members)
        spread = Spread(C, let, np.ascontiguousarray(X[:, :-1].T), scale)
        return Fitted(members, (mean - let @ X[:, -1]) * scale, spread, score, widths.copy(), dict(shares))

    @cached_property
    def _entries(self) -> _Entries:
        """The candidates, and what each is tried with."""
        d = self.design
        units = np.array(self.candidates, np.int64)
        columns = np.concatenate([np.zeros(0, np.int64), *(self._columns[i] for i in units)])
        names = [d.units[i].effect for i in units]
        counts = np.array([len(self._columns[i]) for i in units], np.int64)
        shares = [[max(share, self._least[n]) if n in self._least else 1.0 for n in names] for share in _SHARES]
        number = {n: k for k, n in enumerate(self._effects)}
        return _Entries(
            units,
            np.array([number[n] for n in names], np.int64),
            np.repeat(np.arange(len(units)), counts),
            np.cumsum(np.r_[0, counts]),
            columns,
            np.array(shares).reshape(len(_SHARES), -1),
            np.array([log(d.units[i].choices) for i in units]),
            [len(own) for own in self._effects.values()],
        )

    def _in(self, members: Set) -> NDArray[np.bool_]:
        """By unit, whether it is in a set."""
        inside = np.zeros(len(self.design.units), bool)
        inside[list(members)] = True
        return inside

    def seen(self, fitted: Fitted) -> dict[str, float]:
        """Effects of a set, and how probable it is that each moves the TCP by enough to count."""
        least = COUNTS_FROM * self.noise
        found = {}
        names, c, edges = self._owned(fitted.members)
        moves, cov, mean = self.design.moves[np.ix_(c, c)], fitted.spread.block(c), fitted.mean[c]
        for name, a, b in zip(names, edges, edges[1:], strict=False):
            pull = moves[a:b, a:b] @ mean[a:b]
            size = float(np.sqrt(max(float(mean[a:b] @ pull), 0.0)))
            spread = float(np.sqrt(max(float(pull @ cov[a:b, a:b] @ pull), 0.0))) / max(size, 1e-12)
            found[name] = float(ndtr((size - least) / max(spread, _FAINT)))
        return found

    def _owned(self, members: Set) -> tuple[list[str], NDArray[np.int64], list[int]]:
        """The effects in a set, their columns, one after the other, and where each one's begin and the last one's end."""
        found: dict[str, list[NDArray[np.int64]]] = {}
        for i in sorted(members - self.always):
            found.setdefault(self.design.units[i].effect, []).append(self._columns[i])
        columns = [x for own in found.values() for x in own]
        counts = [sum(len(x) for x in own) for own in found.values()]
        whole = np.concatenate(columns) if columns else np.zeros(0, np.int64)
        return list(found), whole, [0, *np.cumsum(counts).tolist()]

    def _strain(self, members: Set, mean: Array) -> float:
        """Log prior against effects that are far larger than the gap and cancel one another."""
        names, c, edges = self._owned(members)
        if len(names) < 2:
            return 0.0
        moves, values = self.design.moves[np.ix_(c, c)], mean[c]
        apart = sum(_energy(values[a:b], moves[a:b, a:b]) for a, b in pairwise(edges))
        together = _energy(values, moves) + self.noise**2
        return -_STRAIN * log(max(apart / (_CANCELS * together), 1.0))

    def neighbours(self, fitted: Fitted) -> dict[Set, tuple[float, float]]:
        """Sets that differ in one unit: the score, and by how much that unit then moves the TCP, m (rms)."""
        members = fitted.members
        return {members ^ {i}: (score, moved) for i, score, moved in self.changes(fitted)}

    def changes(self, fitted: Fitted) -> list[tuple[int, float, float]]:
        """Units that may enter a set or leave it: the score of the set with that one change, and by how much the unit then moves
        the TCP, m (rms). A unit enters at the best of a few widths of its priors.
        """
        out, usual = self._widths
        members, e = fitted.members, self._entries
        entering = ~self._in(members)[e.units]
        # a unit of an effect that is in comes at its width, others at the best of a few
        shares = np.array([fitted.shares.get(n, np.nan) for n in self._effects])[e.effect]
        tried = np.where(np.isnan(shares), e.shares, shares)
        into = np.maximum(tried.take(e.unit, axis=1) * usual[e.columns], out[e.columns])
        to = np.where(entering[e.unit], into, out[e.columns])
        s = fitted.spread
        best, size = single_changes(
            e.starts, e.columns, to, fitted.widths, fitted.mean, s.base, s.let, s.X, s.scale, self.design.moves
        )
        scores = fitted.score - self.prior(members) + best + self._priors(members, entering)
        good = np.isfinite(best)
        return list(zip(e.units[good].tolist(), scores[good].tolist(), size[good].tolist(), strict=True))

    def _priors(self, members: Set, entering: NDArray[np.bool_]) -> Array:
        """(U,) log prior of a set with each of the candidates entered, or left out where it was in."""
        e, effects = self._entries, len(self._effects)
        counts = np.bincount(e.effect, ~entering, effects).astype(np.int64)
        log_choices = float(np.sum(e.log_choices[~entering]))
        # by effect: the whole with one unit more, and with one less
        n, costs = (
            int(np.count_nonzero(counts)),
            [self._of_units(m, k) for m, k in zip(e.of_effect, counts, strict=True)],
        )
        whole, found = sum(costs), np.full((2, effects), -np.inf)
        for k, (m, count) in enumerate(zip(e.of_effect, counts.tolist(), strict=True)):
            for step, row in ((1, found[0]), (-1, found[1])):
                if 0 <= count + step <= m:
                    rest = whole - costs[k] + self._of_units(m, count + step)
                    row[k] = self._of_count(n + (count + step > 0) - (count > 0)) - rest
        changed = np.where(entering, found[0][e.effect] - e.log_choices, found[1][e.effect] + e.log_choices)
        return np.asarray(changed - log_choices)


class _Entries(NamedTuple):
    """U units that may be in or out: their numbers, those of their effects (U,), whose each column is (C,), where their columns
    begin in `columns` (U + 1,), the shares (S, U) of the ordinary sizes that each is tried with where its effect is not in, the
    logs (U,) of what each was chosen from; and how many units each effect has.
    """

    units: NDArray[np.int64]
    effect: NDArray[np.int64]
    unit: NDArray[np.int64]
    starts: NDArray[np.int64]
    columns: NDArray[np.int64]
    shares: Array
    log_choices: Array
    of_effect: list[int]


def _energy(values: Array, G: Array) -> float:
    """m2 (mean square) by which values (k,) move the TCP, with mean products G."""
    return max(float(values @ G @ values), 0.0)
