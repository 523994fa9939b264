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


def single_shape(panels: Sequence[Panel], noise: float) -> SingleShape | None:
    """The part and the quantity that explain most of some logs' gap at the TCP; None where nothing does.

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
    best: SingleShape | None = None
    for target in targets(panels[0].scene):
        kind, _, part = target.rpartition(" ")
        term = f"root.{part}" if kind == "foot" else f"{part}.zero"
        if kind == "drive" or any(term not in p.scene.places for p in panels):
            continue
        lever = np.concatenate([p.scene.places[term][r, :3] for p, r in zip(panels, rows, strict=True)])
        for n in names:
            share = _withheld(lever, shapes[n], gap, fold) / energy
            if best is None or share > best.share:
                best = SingleShape(target, n, share)
    return best


def _withheld(lever: Array, shape: Array, gap: Array, fold: NDArray[np.int64]) -> float:
    """m2 that a lever (N, 3) times a shape (N, d), beside a constant, takes from folds that it was not fitted to."""
    X = np.concatenate([lever[:, :, None] * shape[:, None, :], np.tile(np.eye(3), (len(gap), 1, 1))], axis=2)
    scale = np.sqrt(np.sum(X**2, axis=(0, 1))) + 1e-30
    X = X / scale
    parts = [(X[fold == k].reshape(-1, X.shape[2]), gap[fold == k].ravel()) for k in np.unique(fold)]
    grams = [(x.T @ x, x.T @ y) for x, y in parts]
    A, b = np.sum([a for a, _ in grams], axis=0), np.sum([c for _, c in grams], axis=0)
    gained = 0.0
    for own, right in grams:
        solved = np.linalg.solve(A - own + _RIDGE * np.eye(len(A)), b - right)
        gained += float(2.0 * solved @ right - solved @ own @ solved)
    return gained
