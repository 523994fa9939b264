"""What one moving part would explain of a gap: an axis, or the robot's foot, that is off as a smooth function of one quantity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import some_rows, whole_gap
from camrob.gap.evidence.unknown import basis, quantities, targets

__all__ = ["SingleShape", "single_shape"]

Array = NDArray[np.float64]

_MOST_ROWS = 1200  # of a log that show a shape well enough
_FOLDS = 8
_RIDGE = 1e-9


@dataclass(frozen=True, slots=True)
class SingleShape:
    """moves: an axis, or "foot x"; follows: one of `quantities`; share: of the energy beyond the noise that was withheld."""

    moves: str
    follows: str
    share: float


def single_shape(panels: Sequence[Panel], noise: float, moves: str = "") -> SingleShape | None:
    """The part (`moves`, any where it is "") and the quantity that explain most of some logs' gap at the TCP; None where nothing
    does.

    Every part with every quantity in turn, as a polynomial beside a constant shift; its size is fitted to the other blocks where
    a share is wanted. noise: m, 3-D rms.
    """
    rows = [some_rows(p, _MOST_ROWS) for p in panels]
    gap = np.concatenate([whole_gap(p)[r] for p, r in zip(panels, rows, strict=True)])
    fold = np.concatenate([p.block[r] for p, r in zip(panels, rows, strict=True)]) % _FOLDS
    gap = gap - gap.mean(axis=0)
    energy = float(np.sum(gap**2)) - len(gap) * noise**2
    if energy <= 0.0 or len(np.unique(fold)) < 2:
        return None
    given = [quantities(p.scene) for p in panels]
    names = [n for n in given[0] if all(n in g for g in given)]
    shapes = {}
    for n in names:
        lower, upper = (f([f(g[n]) for g in given]) for f in (min, max))
        parts = [basis(g[n], float(lower), float(upper), n)[r] for g, r in zip(given, rows, strict=True)]
        shapes[n] = np.concatenate([np.ones((len(gap), 1)), np.concatenate(parts)], axis=1)
    levers = {}
    for target in targets(panels[0].scene):
        kind, _, part = target.rpartition(" ")
        term = f"root.{part}" if kind == "foot" else f"{part}.zero"
        if kind != "drive" and moves in ("", target) and all(term in p.scene.places for p in panels):
            levers[target] = np.concatenate([p.scene.places[term][r, :3] for p, r in zip(panels, rows, strict=True)])
    if not levers or not names:
        return None
    order = np.argsort(fold, kind="stable")
    edges = np.r_[np.flatnonzero(np.diff(fold[order], prepend=-1)), len(order)]
    lever, gap = np.stack(list(levers.values()))[:, order], gap[order]
    taken = np.stack([_withheld(lever, shapes[n][order], gap, edges) for n in names], axis=1)
    most = int(np.argmax(taken))
    return SingleShape(list(levers)[most // len(names)], names[most % len(names)], float(taken.flat[most]) / energy)


def _withheld(levers: Array, shape: Array, gap: Array, edges: NDArray[np.int64]) -> Array:
    """(T,) m2 that each of T levers (T, N, 3) times a shape (N, d), beside a constant, takes of a gap (N, 3) from folds that it
    was not fitted to; edges: where each fold begins, and the last one ends. Products of all levers are summed at once.
    """
    d, count = shape.shape[1], len(levers)
    upper = np.triu_indices(d)
    pairs = shape[:, upper[0]] * shape[:, upper[1]]
    squares, pulls = np.sum(levers**2, axis=2), np.sum(levers * gap, axis=2)
    A, b = np.zeros((len(edges) - 1, count, d + 3, d + 3)), np.zeros((len(edges) - 1, count, d + 3))
    for own, right, first, last in zip(A, b, edges, edges[1:], strict=False):
        here = slice(int(first), int(last))
        own[:, upper[0], upper[1]] = own[:, upper[1], upper[0]] = squares[:, here] @ pairs[here]
        beside = np.einsum("tnc,nd->tdc", levers[:, here], shape[here], optimize=True)
        own[:, :d, d:], own[:, d:, :d] = beside, beside.swapaxes(1, 2)
        own[:, d:, d:] = (last - first) * np.eye(3)
        right[:, :d], right[:, d:] = pulls[:, here] @ shape[here], gap[here].sum(axis=0)
    scale = np.sqrt(np.einsum("ftii->ti", A)) + 1e-30
    A, b = A / (scale[:, :, None] * scale[:, None, :]), b / scale
    others = A.sum(axis=0) - A + _RIDGE * np.eye(d + 3)
    solved = np.linalg.solve(others, (b.sum(axis=0) - b)[..., None])[..., 0]
    gained = 2.0 * np.sum(solved * b, axis=2) - np.einsum("fti,ftij,ftj->ft", solved, A, solved, optimize=True)
    return np.asarray(gained.sum(axis=0))
