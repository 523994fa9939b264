"""How the rows of a run lie along the motions of its program, and the values at the motions' ends that fit those of the rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText

__all__ = ["RunWay", "arcs_of"]

Array = NDArray[np.float64]

_ASIDE = 1e-3  # weight of a way that does not cut
# m: what a row counts by where the tool stands, and a motion's end by itself, so that each end has a value
_FLOOR = 1e-6
# rad from an arc's auxiliary point to its ends, and of the whole arc: others are taken as lines
_NEAREST, _FARTHEST = 0.15, 5.0
_PLACE = 3  # columns of a twist


def arcs_of(program: ProgramText) -> Array:
    """(M, 2) rad from an arc's start to its auxiliary point, and on to its end, at the row of the end; zeros elsewhere, and where
    an arc is nearly a line or a whole circle, or where the text does not give its three points in one base.
    """
    out = np.zeros((len(program), 2))
    kind, base, pose = np.asarray(program.kind), np.asarray(program.base), np.asarray(program.pose, np.float64)
    end = np.flatnonzero(kind == Motion.CIRC_END)
    end = end[(end >= 2) & np.isnan(np.asarray(program.circular_angle_deg)[end])]
    end = end[(base[end - 2] == base[end]) & (kind[end - 2] != Motion.CIRC_VIA)]
    start, via, stop = (pose[end - k, :3] for k in (2, 1, 0))
    # a chord is seen from the rest of its circle under half of the angle that it spans
    found = 2.0 * np.stack([_angle(start - stop, via - stop), _angle(stop - start, via - start)], axis=1)
    fit = np.all(found >= _NEAREST, axis=1) & (found.sum(axis=1) <= _FARTHEST)
    out[end[fit]] = found[fit]
    return out


def _angle(a: Array, b: Array) -> Array:
    """(K,) rad between vectors (K, 3); NaN where one is not known."""
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.sum(a * b, axis=1)))


@dataclass(frozen=True)
class RunWay:
    """kind: (M,) of the program's motions. motion: (N,) the motion that each row of a run belongs to, in order. step: (N,) m
    that the tool has moved since the row before. arcs: (M, 2) as `arcs_of` has them; None: arcs are taken as lines.
    cuts: (M,) the motions whose ways are to be met; None: all lines and arcs.
    """

    kind: NDArray[np.int8]
    motion: NDArray[np.int64]
    step: Array
    arcs: Array | None = None
    cuts: NDArray[np.bool_] | None = None

    def share(self) -> Array:
        """(N,) the share of its motion that is done at each row; 1 in the first, and where the tool stands."""
        return self._nodes()[1]

    def length(self) -> Array:
        """(M,) m that the tool moves in each motion."""
        return np.asarray(np.bincount(self.motion, weights=self.step, minlength=len(self.kind)), np.float64)

    def fit(self, values: Array) -> Array:
        """Values (M, k) at the motions' ends that, interpolated, fit those at the rows (N, k) best, by the rows' ways.

        By least squares. Between two ends there is a straight line. The first three columns are a place: along an arc that goes
        through its auxiliary point, too, such that an arc that is shifted, turned or widened is met; all else is half-way there.
        """
        place = self._fit(values[:, :_PLACE], *self._basis())
        rest = self._fit(values[:, _PLACE:], *self._straight())
        return np.concatenate([place, rest], axis=1)

    def between(self, at_ends: Array) -> Array:
        """What values at the motions' ends (M, k) are at the rows (N, k), interpolated as `fit` has it."""
        parts = (at_ends[:, :_PLACE], self._basis()), (at_ends[:, _PLACE:], self._straight())
        return np.concatenate([np.einsum("nj,njk->nk", share, v[node]) for v, (node, share) in parts], axis=1)

    def _fit(self, values: Array, node: NDArray[np.int64], share: Array) -> Array:
        """Least squares for rows that are sums of shares (N, 3) of nodes (N, 3), no more than two apart."""
        count = len(self.kind)
        cuts = self.kind >= Motion.LIN if self.cuts is None else self.cuts
        weight = np.where(cuts[node[:, 2]], 1.0, _ASIDE) * (self.step + _FLOOR)
        banded = np.zeros((3, count))  # upper form: the diagonal comes last
        right = np.zeros((count, values.shape[1]))
        for j in range(3):
            np.add.at(right, node[:, j], (weight * share[:, j])[:, None] * values)
            for i in range(j + 1):
                # the same node twice holds its whole square
                twice = np.where((node[:, i] == node[:, j]) & (i != j), 2.0, 1.0)
                np.add.at(
                    banded, (2 - (node[:, j] - node[:, i]), node[:, j]), twice * weight * share[:, i] * share[:, j]
                )
        rows = np.maximum(np.searchsorted(self.motion, np.arange(count), side="right") - 1, 0)
        banded[2] += _FLOOR
        right += _FLOOR * values[rows]
        out = np.asarray(solveh_banded(banded, right)) if values.shape[1] else right
        via = np.flatnonzero(self.kind == Motion.CIRC_VIA)
        free = via[np.bincount(node.ravel(), weights=np.abs(share).ravel(), minlength=count)[via] == 0.0]
        out[free] = 0.5 * (out[np.maximum(free - 1, 0)] + out[free + 1])
        return out

    def split(self, shares: Mapping[int, Sequence[float]]) -> RunWay:
        """The same rows along a program in which lines end at these shares of them too: by motion, increasing, within 0 and 1."""
        count = np.zeros(len(self.kind), np.int64)
        count[list(shares)] = [len(ends) for ends in shares.values()]
        before = (np.cumsum(count) - count)[self.motion]
        share = self.share()
        for m, ends in shares.items():
            first, last = np.searchsorted(self.motion, [m, m + 1])
            before[first:last] += np.searchsorted(np.asarray(ends), share[first:last], side="left")
        arcs = None if self.arcs is None else np.repeat(self.arcs, count + 1, axis=0)
        cuts = None if self.cuts is None else np.repeat(self.cuts, count + 1)
        return RunWay(np.repeat(self.kind, count + 1), self.motion + before, self.step, arcs, cuts)

    def _straight(self) -> tuple[NDArray[np.int64], Array]:
        """Of each row the motions (N, 3) whose values it is made of, rising, and their shares: from end to end."""
        ends = self._ends()
        node, share = self._nodes()
        to, since = ends[node], ends[np.maximum(node - 1, 0)]
        return np.stack([since, since, to], axis=1), np.stack([np.zeros_like(share), 1.0 - share, share], axis=1)

    def _basis(self) -> tuple[NDArray[np.int64], Array]:
        """As `_straight`, and along arcs by the three points: a sum of 1, cosine and sine of the angle that is 1 in one of them
        and 0 in the others.
        """
        node, shares = self._straight()
        if self.arcs is None or not len(node):
            return node, shares
        bent = np.flatnonzero(self.arcs[self.motion, 0] > 0.0)
        m = self.motion[bent]
        at = np.cumsum(np.column_stack([np.zeros(len(m)), self.arcs[m]]), axis=1)
        angle = shares[bent, 2] * at[:, 2]
        node[bent] = m[:, None] + np.arange(-2, 1)
        for k in range(3):
            i, j = (o for o in range(3) if o != k)
            above = np.sin(0.5 * (angle - at[:, i])) * np.sin(0.5 * (angle - at[:, j]))
            below = np.sin(0.5 * (at[:, k] - at[:, i])) * np.sin(0.5 * (at[:, k] - at[:, j]))
            shares[bent, k] = above / below
        return node, shares

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
