"""What this path can't tell apart, said before anything is fitted: principal angles between effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.design import Design
from camrob.gap.nuisances import NUISANCE

__all__ = ["alias_groups", "alias_lists", "covered_by"]

Array = NDArray[np.float64]

_ALIKE = 0.05  # sine of the angle under which two effects count as one


def _basis(A: Array, columns: NDArray[np.int64], scale: Array) -> Array:
    """(K, r) combinations of some columns, orthonormal in the metric A."""
    s = scale[columns]
    G = A[np.ix_(columns, columns)] * np.outer(s, s)
    values, vectors = np.linalg.eigh(G)
    keep = values > max(values[-1], 1e-12) * 1e-9
    out = np.zeros((len(A), int(keep.sum())))
    out[columns] = s[:, None] * vectors[:, keep] / np.sqrt(values[keep])
    return out


def _by_effect(design: Design) -> dict[str, NDArray[np.int64]]:
    names = [design.units[o].effect for o in design.owner]
    found = {n: np.flatnonzero(np.array(names) == n) for n in dict.fromkeys(names) if n not in (NUISANCE, "unknown")}
    return found


def alias_groups(design: Design, total: Array) -> list[tuple[str, ...]]:
    """Effects of which every pattern of the one is, on these logs, one of the other: all principal angles nearly 0.

    total: (K, K) the Gram matrix of all rows.
    """
    own = _by_effect(design)
    bases = {n: _basis(total, c, design.usual) for n, c in own.items()}
    groups: list[set[str]] = []
    names = list(own)
    for i, a in enumerate(names):
        for b in names[i + 1 :]:
            small, large = sorted((bases[a], bases[b]), key=lambda B: B.shape[1])
            if small.shape[1] == 0:
                continue
            cosines = np.linalg.svd(small.T @ total @ large, compute_uv=False)
            if len(cosines) and np.sqrt(max(0.0, 1.0 - float(cosines.min()) ** 2)) < _ALIKE:
                near = [g for g in groups if a in g or b in g]
                merged = {a, b}.union(*near)
                groups = [g for g in groups if g not in near] + [merged]
    return [tuple(n for n in names if n in g) for g in groups]


def covered_by(design: Design, total: Array, values: Array, effect: str, share: float = 0.02) -> tuple[str, ...]:
    """Effects that alone would show the same as `effect` does with its fitted values (K,), but for a share of its energy."""
    own = _by_effect(design)
    energy = float(values @ total @ values)
    found = []
    for name, columns in own.items():
        if name == effect or energy <= 0.0:
            continue
        B = _basis(total, columns, design.usual)
        if B.shape[1] and float(np.sum((B.T @ total @ values) ** 2)) > (1.0 - share) * energy:
            found.append(name)
    return tuple(found)


def alias_lists(design: Design, library: Sequence[Effect], in_world: bool) -> tuple[tuple[str, ...], ...]:
    """`alias_groups` of all rows, and pairs that poses in world can't part where the table's turning doesn't (`in_world`)."""
    groups = [tuple(g) for g in alias_groups(design, design.A.sum(axis=0))]
    pairs = [(e.name, e.twin_in_world) for e in library if e.twin_in_world]
    return (*groups, *(pairs if in_world else []))
