"""How much the data speak for each set of effects, from Gram matrices alone.

Every parameter has a Gaussian prior: wide (its ordinary size) where its unit is in, and else so narrow that all that is
left out together stays a nuisance within the noise. The evidence of a set is then exact, weighs fit against freedom, and
one factorisation of the posterior gives that of all sets which differ in one unit (matrix determinant lemma).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from camrob.gap.design import NUISANCE, Design

__all__ = ["Evidence", "Fitted"]

Array = NDArray[np.float64]
Set = frozenset[int]

NUISANCE_SHARE = 0.06  # of the noise's rms: what an effect that counts as absent may still move the TCP by
_COUNTS = (0.22, 0.36, 0.27, 0.12, 0.027, 0.003)  # prior of how many effects a cell has


@dataclass(frozen=True)
class Fitted:
    """The posterior of one set. mean, cov: of all parameters, SI; score: log evidence and prior."""

    members: Set
    mean: Array
    cov: Array
    score: float


@dataclass(frozen=True)
class Evidence:
    """The comparison of sets of units (frozensets of their numbers). noise: 3-D rms, m; temperature: by which log evidence
    is divided, as the description of the noise is not perfect; left_out: (B,) blocks that take no part.
    """

    design: Design
    noise: float
    temperature: float = 1.0
    left_out: tuple[int, ...] = ()

    @cached_property
    def _sums(self) -> tuple[Array, Array, float]:
        used = [i for i in range(len(self.design.yy)) if i not in self.left_out]
        d = self.design
        return d.A[used].sum(axis=0), d.b[used].sum(axis=0), float(d.yy[used].sum())

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
        from math import comb, log

        total = 0.0
        chosen: dict[str, int] = {}
        for i in members:
            unit = self.design.units[i]
            if i in self.always:
                continue
            chosen[unit.effect] = chosen.get(unit.effect, 0) + 1
            total -= log(unit.choices)
        n = len(chosen)
        total += log(_COUNTS[n]) if n < len(_COUNTS) else log(_COUNTS[-1]) - 6.0 * (n - len(_COUNTS) + 1)
        total -= log(comb(max(len(self._effects), n), n))
        for name, k in chosen.items():
            m = len(self._effects[name])
            total -= log(m) + log(comb(m, k))
        return total

    def fit(self, members: Set) -> Fitted:
        """The posterior of a set, and its score."""
        A, b, yy = self._sums
        out, usual = self._widths
        inside = np.isin(self.design.owner, list(members))
        scale = out
        ratio = np.where(inside, (out / usual) ** 2, 1.0)
        P = A * np.outer(scale, scale)
        P[np.diag_indices_from(P)] += ratio
        L = np.linalg.cholesky(P)
        inverse = np.linalg.inv(L)
        C = inverse.T @ inverse
        right = b * scale
        mean = C @ right
        log_evidence = -0.5 * (yy - right @ mean) - np.log(np.diag(L)).sum() + 0.5 * np.log(ratio).sum()
        score = float(log_evidence) / self.temperature + self.prior(members)
        return Fitted(members, mean * scale, C * np.outer(scale, scale), score)

    def neighbours(self, fitted: Fitted) -> dict[Set, float]:
        """Scores of all sets that differ in one unit."""
        out, usual = self._widths
        scores: dict[Set, float] = {}
        base = fitted.score - self.prior(fitted.members)
        for i in self.candidates:
            c = self._columns[i]
            s = out[c]
            mean, C = fitted.mean[c] / s, fitted.cov[np.ix_(c, c)] / np.outer(s, s)
            ratio = (s / usual[c]) ** 2
            entering = i not in fitted.members
            change = (ratio - 1.0) if entering else (1.0 - ratio)
            if np.all(np.abs(change) < 1e-12):
                continue
            M = np.eye(len(c)) + change[:, None] * C
            sign, log_det = np.linalg.slogdet(M)
            if sign <= 0:
                continue
            gain = -0.5 * float(mean @ np.linalg.solve(M, change * mean))
            log_ratio = 0.5 * np.log(ratio).sum() * (1.0 if entering else -1.0)
            members = fitted.members | {i} if entering else fitted.members - {i}
            delta = gain - 0.5 * float(log_det) + log_ratio
            scores[members] = base + delta / self.temperature + self.prior(members)
        return scores
