"""How the rows of a run lie along the motions of its program, and the values at the motions' ends that fit those of the rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from camrob.program.motion import Motion

__all__ = ["RunWay"]

Array = NDArray[np.float64]

_ASIDE = 1e-3  # weight of a way that is no line or arc
# m: what a row counts by where the tool stands, and a motion's end by itself, so that each end has a value
_FLOOR = 1e-6


@dataclass(frozen=True)
class RunWay:
    """kind: (M,) of the program's motions. motion: (N,) the motion that each row of a run belongs to, in order. step: (N,) m
    that the tool has moved since the row before.
    """

    kind: NDArray[np.int8]
    motion: NDArray[np.int64]
    step: Array

    def share(self) -> Array:
        """(N,) the share of its motion that is done at each row; 1 in the first, and where the tool stands."""
        return self._nodes()[1]

    def length(self) -> Array:
        """(M,) m that the tool moves in each motion."""
        return np.asarray(np.bincount(self.motion, weights=self.step, minlength=len(self.kind)), np.float64)

    def fit(self, values: Array) -> Array:
        """Values (M, k) at the motions' ends that, interpolated, fit those at the rows (N, k) best, by the rows' ways.

        By least squares: between two ends there is a straight line. At an arc's auxiliary point they are those half-way.
        """
        node, share = self._nodes()
        ends = self._ends()
        weight = np.where(self.kind[ends][node] >= Motion.LIN, 1.0, _ASIDE) * (self.step + _FLOOR)
        banded = np.zeros((2, len(ends)))
        right = np.zeros((len(ends), values.shape[1]))
        np.add.at(banded[1], node, weight * share**2)
        np.add.at(banded[1], np.maximum(node - 1, 0), weight * (1.0 - share) ** 2)
        np.add.at(banded[0], node, weight * share * (1.0 - share))
        np.add.at(right, node, (weight * share)[:, None] * values)
        np.add.at(right, np.maximum(node - 1, 0), (weight * (1.0 - share))[:, None] * values)
        banded[0, 0] = 0.0
        rows = np.maximum(np.searchsorted(self.motion, ends, side="right") - 1, 0)
        banded[1] += _FLOOR
        right += _FLOOR * values[rows]
        out = np.empty((len(self.kind), values.shape[1]))
        out[ends] = solveh_banded(banded, right)
        via = np.flatnonzero(self.kind == Motion.CIRC_VIA)
        out[via] = 0.5 * (out[np.maximum(via - 1, 0)] + out[via + 1])
        return out

    def between(self, at_ends: Array) -> Array:
        """What values at the motions' ends (M, k) are at the rows (N, k), interpolated."""
        node, share = self._nodes()
        values = at_ends[self._ends()]
        before = values[np.maximum(node - 1, 0)]
        return np.asarray(before + share[:, None] * (values[node] - before))

    def split(self, shares: Mapping[int, Sequence[float]]) -> RunWay:
        """The same rows along a program in which lines end at these shares of them too: by motion, increasing, within 0 and 1."""
        count = np.zeros(len(self.kind), np.int64)
        count[list(shares)] = [len(cuts) for cuts in shares.values()]
        before = (np.cumsum(count) - count)[self.motion]
        share = self.share()
        for m, cuts in shares.items():
            first, last = np.searchsorted(self.motion, [m, m + 1])
            before[first:last] += np.searchsorted(np.asarray(cuts), share[first:last], side="left")
        return RunWay(np.repeat(self.kind, count + 1), self.motion + before, self.step)

    def _ends(self) -> NDArray[np.int64]:
        return np.flatnonzero(self.kind != Motion.CIRC_VIA)

    def _nodes(self) -> tuple[NDArray[np.int64], Array]:
        """Of each row the end that it leads to, among the ends, and its share."""
        ends = self._ends()
        node = np.searchsorted(ends, self.motion)
        done = np.cumsum(self.step)
        finished = np.maximum.accumulate(np.bincount(node, weights=self.step, minlength=len(ends)).cumsum())
        begin = np.concatenate([[0.0], finished])[node]
        length = finished[node] - begin
        share = np.divide(done - begin, length, out=np.ones_like(done), where=length > 0.0)
        share[node == 0] = 1.0
        return node, share
