"""How much the data speak for each set of effects, from Gram matrices alone.

Every parameter has a Gaussian prior: wide (its ordinary size) where its unit is in, and else so narrow that all that is
left out together stays a nuisance within the noise. The evidence of a set is then exact, weighs fit against freedom, and
one factorisation of the posterior gives that of all sets which differ in one unit (matrix determinant lemma).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from math import comb, log
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotri
from scipy.special import ndtr

from camrob.gap.evidence.design import NUISANCE, Design
from camrob.gap.evidence.discrepancy import FieldGram, Integrated
from camrob.gap.evidence.single_changes import single_changes

__all__ = ["COUNTS_FROM", "Evidence", "Fitted"]

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
class Fitted:
    """The posterior of one set. mean, cov: of all parameters, SI; score: log evidence and prior; widths: of the priors,
    shares: what they are of the ordinary sizes, by effect.
    """

    members: Set
    mean: Array
    cov: Array
    score: float
    widths: Array
    shares: Mapping[str, float]


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
        if self.field is None or self.sizes is None:
            return Integrated(A, b, float(yy), 0.0)
        return self.field.integrated(A, b, float(yy), self.sizes, used)

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
        return self._prior(chosen) - sum(log(self.design.units[i].choices) for i in members - self.always)

    def _prior(self, chosen: Mapping[str, int]) -> float:
        """Log prior of so many units of each effect, whichever they are."""
        n = sum(1 for k in chosen.values() if k > 0)
        total = log(_COUNTS[n]) if n < len(_COUNTS) else log(_COUNTS[-1]) - 6.0 * (n - len(_COUNTS) + 1)
        total -= _log_comb(max(len(self._effects), n), n)
        for name, k in chosen.items():
            if k > 0:
                m = len(self._effects[name])
                total -= log(m) + _log_comb(m, k)
        return total

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
        columns = {name: c for name, c in self._owned(members).items() if name in self._least}
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
        ratio = (scale[own] / widths[own]) ** 2
        change = ratio - 1.0
        M = np.eye(len(own)) + change[:, None] * C[np.ix_(own, own)]
        X = np.linalg.solve(M, change[:, None] * np.c_[C[own], mean[own]])
        fit -= 0.5 * float(mean[own] @ X[:, -1])
        log_evidence = fit - half - 0.5 * np.linalg.slogdet(M)[1] + 0.5 * np.log(ratio).sum()
        score = float(log_evidence) + self.prior(members)
        full = (C - C[:, own] @ X[:, :-1]) * np.outer(scale, scale)
        return Fitted(members, (mean - C[:, own] @ X[:, -1]) * scale, full, score, widths.copy(), dict(shares))

    @cached_property
    def _entries(self) -> _Entries:
        """The candidates, and what each is tried with."""
        d = self.design
        units = np.array(self.candidates, np.int64)
        columns = np.concatenate([np.zeros(0, np.int64), *(self._columns[i] for i in units)])
        names = [d.units[i].effect for i in units]
        counts = np.array([len(self._columns[i]) for i in units], np.int64)
        shares = [[max(share, self._least[n]) if n in self._least else 1.0 for n in names] for share in _SHARES]
        return _Entries(units, names, np.cumsum(np.r_[0, counts]), columns, np.array(shares).reshape(len(_SHARES), -1))

    def _in(self, members: Set) -> NDArray[np.bool_]:
        """By unit, whether it is in a set."""
        inside = np.zeros(len(self.design.units), bool)
        inside[list(members)] = True
        return inside

    def seen(self, fitted: Fitted) -> dict[str, float]:
        """Effects of a set, and how probable it is that each moves the TCP by enough to count."""
        least = COUNTS_FROM * self.noise
        found = {}
        for name, c in self._owned(fitted.members).items():
            pull = self.design.moves[np.ix_(c, c)] @ fitted.mean[c]
            size = float(np.sqrt(max(float(fitted.mean[c] @ pull), 0.0)))
            spread = float(np.sqrt(max(float(pull @ fitted.cov[np.ix_(c, c)] @ pull), 0.0))) / max(size, 1e-12)
            found[name] = float(ndtr((size - least) / max(spread, _FAINT)))
        return found

    def _owned(self, members: Set) -> dict[str, NDArray[np.int64]]:
        """Columns of each effect in a set."""
        return {
            name: np.concatenate([self._columns[i] for i in own if i in members])
            for name, own in self._effects.items()
            if any(i in members for i in own)
        }

    def _strain(self, members: Set, mean: Array) -> float:
        """Log prior against effects that are far larger than the gap and cancel one another."""
        owned = self._owned(members)
        if len(owned) < 2:
            return 0.0
        apart = sum(_energy(mean[c], self.design.moves[np.ix_(c, c)]) for c in owned.values())
        c = np.concatenate(list(owned.values()))
        together = _energy(mean[c], self.design.moves[np.ix_(c, c)]) + self.noise**2
        return -_STRAIN * log(max(apart / (_CANCELS * together), 1.0))

    def neighbours(self, fitted: Fitted) -> dict[Set, tuple[float, float]]:
        """Sets that differ in one unit: the score, and by how much that unit then moves the TCP, m (rms).

        A unit enters at the best of a few widths of its priors.
        """
        out, usual = self._widths
        scores: dict[Set, tuple[float, float]] = {}
        members = fitted.members
        base = fitted.score - self.prior(members)
        chosen = {name: sum(i in members for i in own) for name, own in self._effects.items()}
        choices = sum(log(self.design.units[i].choices) for i in members - self.always)
        priors: dict[tuple[str, int], float] = {}
        inside = self._in(members)
        e = self._entries
        entering = ~inside[e.units]
        # a unit of an effect that is in comes at its width, others at the best of a few
        tried = np.where([n in fitted.shares for n in e.names], [fitted.shares.get(n, 1.0) for n in e.names], e.shares)
        counts = np.diff(e.starts)
        into = np.maximum(np.repeat(tried, counts, axis=1) * usual[e.columns], out[e.columns])
        to = np.where(np.repeat(entering, counts), into, out[e.columns])
        best, size = single_changes(e.starts, e.columns, to, fitted.widths, fitted.mean, fitted.cov, self.design.moves)
        for k in np.flatnonzero(np.isfinite(best)):
            i, step = int(e.units[k]), 1 if entering[k] else -1
            name = e.names[k]
            if (name, step) not in priors:
                priors[name, step] = self._prior({**chosen, name: chosen[name] + step})
            prior = priors[name, step] - choices - step * log(self.design.units[i].choices)
            scores[members | {i} if step > 0 else members - {i}] = base + float(best[k]) + prior, float(size[k])
        return scores


class _Entries(NamedTuple):
    """U units that may be in or out: their numbers, the names of their effects, where their columns begin in `columns` (U + 1,),
    and the shares (S, U) of the ordinary sizes that each is tried with where its effect is not in.
    """

    units: NDArray[np.int64]
    names: list[str]
    starts: NDArray[np.int64]
    columns: NDArray[np.int64]
    shares: Array


def _energy(values: Array, G: Array) -> float:
    """m2 (mean square) by which values (k,) move the TCP, with mean products G."""
    return max(float(values @ G @ values), 0.0)
