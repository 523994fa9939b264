"""How much the data speak for each set of effects, from Gram matrices alone.

Every parameter has a Gaussian prior: wide (its ordinary size) where its unit is in, and else so narrow that all that is
left out together stays a nuisance within the noise. The evidence of a set is then exact, weighs fit against freedom, and
one factorisation of the posterior gives that of all sets which differ in one unit (matrix determinant lemma).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, cached_property
from math import comb, log
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotri
from scipy.special import ndtr

from camrob.gap.evidence.design import Design
from camrob.gap.evidence.discrepancy import FieldGram, Integrated
from camrob.gap.evidence.posteriors.set_posterior import effects_moves, fitted_widths, let_loose
from camrob.gap.evidence.posteriors.single_changes import single_changes
from camrob.gap.nuisances import NUISANCE

__all__ = ["COUNTS_FROM", "Evidence", "Fitted", "Spread"]

Array = NDArray[np.float64]
Set = frozenset[int]

NUISANCE_SHARE = 0.06  # of the noise's rms: what an effect that counts as absent may still move the TCP by
_SHARES = (3.0, 1.0, 0.3, 0.1)
COUNTS_FROM = 0.35  # of the noise's rms: an effect that moves the TCP by less is a nuisance
_LEAST_MOVE = 0.3  # of the noise's rms: what a unit is taken to move the TCP by at least
_FAINT = 1e-9  # m: a size that is known that well is known
_CANCELS, _STRAIN = 3.0, 3.0  # times the energy of the whole from which effects' energies cost, and how dearly
_COUNTS = (0.22, 0.36, 0.27, 0.12, 0.027, 0.003)  # prior of how many effects a cell has


@cache
def _log_comb(n: int, k: int) -> float:
    return log(comb(n, k))


@dataclass(frozen=True)
class Spread:
    """How far all parameters may be off: covariance (base + R.T R) scale scale.T, SI. base: (K, K) with every unit out, R: (n, K)
    by how much more it is as n are let loose; scale: (K,). Most questions are put to a few entries of it.
    """

    base: Array
    R: Array
    scale: Array

    def block(self, c: NDArray[np.int64]) -> Array:
        """(k, k) of some parameters."""
        more = self.R.take(c, axis=1)
        return np.asarray((self.base[np.ix_(c, c)] + more.T @ more) * np.outer(self.scale[c], self.scale[c]))


@dataclass(frozen=True)
class Fitted:
    """The posterior of one set. mean, spread: of all parameters, SI; score: log evidence and prior; widths: of the priors,
    shares: (E,) what they are of the ordinary sizes, by effect, NaN where they are these or the effect is not in; energy, doubt:
    (E,) m2 (mean square) by which each effect of the set moves the TCP, and m4, the variance of half of that.
    """

    members: Set
    mean: Array
    spread: Spread
    score: float
    widths: Array
    shares: Array
    energy: Array
    doubt: Array

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
        if members not in self._named:
            self._named[members] = frozenset([self.design.units[i].effect for i in members - self.always])
        return self._named[members]

    @cached_property
    def _named(self) -> dict[Set, frozenset[str]]:
        return {}  # as they are asked for: many are, again and again

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
        own, (scale, usual), (C, mean, _, _) = self._own(members), self._widths, self._base
        widths, shares = fitted_widths(C, mean, scale, usual, self._numbers, self._entries.least, own)
        return self._solve(members, widths, shares, own)

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

    def _solve(self, members: Set, widths: Array, shares: Array, own: NDArray[np.int64]) -> Fitted:
        """The posterior at given widths (K,) of the priors, and the score: `_base` with those of parameters `own` let loose."""
        (C, start, fit, half), scale, moves = self._base, self._widths[0], self.design.moves
        mean, R, better, cost = let_loose(C, start, scale, own, widths)
        energy, doubt, whole = effects_moves(C, R, scale, mean, moves, self._numbers, own, len(self._effects))
        score = fit - half + better - cost + self.prior(members) + self._strain(energy, whole)
        return Fitted(members, mean, Spread(C, R, scale), score, widths, shares, energy, doubt)

    @cached_property
    def _entries(self) -> _Entries:
        """The candidates, and what each is tried with."""
        d = self.design
        units = np.array(self.candidates, np.int64)
        columns = np.concatenate([np.zeros(0, np.int64), *(self._columns[i] for i in units)])
        names = [d.units[i].effect for i in units]
        counts = np.array([len(self._columns[i]) for i in units], np.int64)
        shares = [[max(share, self._least[n]) if n in self._least else 1.0 for n in names] for share in _SHARES]
        counts_of = [len(own) for own in self._effects.values()]
        most = max(counts_of, default=0) + 1
        costs = [[self._of_units(m, k) if k <= m else np.inf for k in range(most)] for m in counts_of]
        return _Entries(
            units,
            np.array([self._number[n] for n in names], np.int64),
            np.repeat(np.arange(len(units)), counts),
            np.cumsum(np.r_[0, counts]),
            columns,
            np.array(shares).reshape(len(_SHARES), -1),
            np.array([log(d.units[i].choices) for i in units]),
            np.array([self._least.get(n, np.nan) for n in self._effects]),
            np.array(costs).reshape(len(counts_of), most),
            np.array([self._of_count(n) for n in range(len(counts_of) + 2)]),
        )

    def _in(self, members: Set) -> NDArray[np.bool_]:
        """By unit, whether it is in a set."""
        inside = np.zeros(len(self.design.units), bool)
        inside[list(members)] = True
        return inside

    @cached_property
    def _number(self) -> dict[str, int]:
        return {n: k for k, n in enumerate(self._effects)}

    @cached_property
    def _numbers(self) -> NDArray[np.int64]:
        """(K,) number of each parameter's effect, -1 for those that are always in."""
        of_unit = np.array([self._number.get(u.effect, -1) for u in self.design.units], np.int64)
        return np.asarray(of_unit[self.design.owner])

    @cached_property
    def _order(self) -> NDArray[np.int64]:
        """(K,) parameters, effect after effect."""
        return np.argsort(self._numbers, kind="stable")

    def _own(self, members: Set) -> NDArray[np.int64]:
        """(n,) the parameters of a set, effect after effect."""
        return np.asarray(self._order[self._in(members)[self.design.owner[self._order]]])

    def seen(self, fitted: Fitted) -> dict[str, float]:
        """Effects of a set, and how probable it is that each moves the TCP by enough to count."""
        names = list(dict.fromkeys(self.design.units[i].effect for i in sorted(fitted.members - self.always)))
        at = [self._number[n] for n in names]
        size = np.sqrt(np.maximum(fitted.energy[at], 0.0))
        spread = np.sqrt(np.maximum(fitted.doubt[at], 0.0)) / np.maximum(size, 1e-12)
        chances = ndtr((size - COUNTS_FROM * self.noise) / np.maximum(spread, _FAINT))
        return dict(zip(names, chances.tolist(), strict=True))

    def _strain(self, energy: Array, whole: float) -> float:
        """Log prior against effects that are far larger than the gap and cancel one another. energy: (E,) m2 by effect; whole: of
        all together.
        """
        if np.count_nonzero(energy) < 2:
            return 0.0
        together = max(whole, 0.0) + self.noise**2
        return -_STRAIN * log(max(float(np.maximum(energy, 0.0).sum()) / (_CANCELS * together), 1.0))

    def neighbours(self, fitted: Fitted) -> dict[Set, tuple[float, float]]:
        """Sets that differ in one unit: the score, and by how much that unit then moves the TCP, m (rms)."""
        units, scores, moved = (x.tolist() for x in self.changes(fitted))
        return {fitted.members ^ {i}: (s, m) for i, s, m in zip(units, scores, moved, strict=True)}

    def changes(self, fitted: Fitted) -> tuple[NDArray[np.int64], Array, Array]:
        """(U,) units that may enter a set or leave it; the score of the set with that one change, and by how much the unit then
        moves the TCP, m (rms). A unit enters at the best of a few widths of its priors.
        """
        out, usual = self._widths
        members, e, s = fitted.members, self._entries, fitted.spread
        entering = ~self._in(members)[e.units]
        # a unit of an effect that is in comes at its width, others at the best of a few
        shares = fitted.shares[e.effect]
        tried = np.where(np.isnan(shares), e.shares, shares)
        into = np.maximum(tried.take(e.unit, axis=1) * usual[e.columns], out[e.columns])
        to = np.where(entering[e.unit], into, out[e.columns])
        best, size = single_changes(
            e.starts, e.columns, to, fitted.widths, fitted.mean, s.base, s.R, s.scale, self.design.moves
        )
        scores = fitted.score - self.prior(members) + best + self._priors(entering)
        good = np.isfinite(best)
        return e.units[good], scores[good], size[good]

    def _priors(self, entering: NDArray[np.bool_]) -> Array:
        """(U,) log prior of a set with each of the candidates entered, or left out where it was in."""
        e = self._entries
        effects = np.arange(len(e.costs))
        counts = np.bincount(e.effect, ~entering, len(effects)).astype(np.int64)
        n, costs = int(np.count_nonzero(counts)), e.costs[effects, counts]
        # by effect: the whole with one unit more, and with one less
        more, less = np.minimum(counts + 1, e.costs.shape[1] - 1), np.maximum(counts - 1, 0)
        rest = costs.sum() - costs
        enters = e.of_count[n + (counts == 0)] - rest - e.costs[effects, more]
        leaves = e.of_count[n - (counts == 1)] - rest - e.costs[effects, less]
        changed = np.where(entering, enters[e.effect] - e.log_choices, leaves[e.effect] + e.log_choices)
        return np.asarray(changed - float(np.sum(e.log_choices[~entering])))


class _Entries(NamedTuple):
    """U units that may be in or out: their numbers, those of their effects (U,), whose each column is (C,), where their columns
    begin in `columns` (U + 1,), the shares (S, U) of the ordinary sizes that each is tried with where its effect is not in, the
    logs (U,) of what each was chosen from. Of E effects: least (E,), see `fitted_widths`; costs (E, k): what so many units of
    each cost, infinity for more than it has; of_count (E + 2,): log prior of so many effects.
    """

    units: NDArray[np.int64]
    effect: NDArray[np.int64]
    unit: NDArray[np.int64]
    starts: NDArray[np.int64]
    columns: NDArray[np.int64]
    shares: Array
    log_choices: Array
    least: Array
    costs: Array
    of_count: Array
