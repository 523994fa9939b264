"""Names that follow direction or time alone, and that a simpler name which follows the same nearly shows: one class with it. So
is, of single poses, one of the same kind that can't be described there at all, and that was never tried.

What follows posture is told apart by posture. What follows an axis's direction or the time has nothing else to tell it by, and
machines have it in more ways than the library describes: a play that is crossed in some time is as near to a spring that slips
as to the play of the library. Single poses know of an axis's way no more than from which side it came: how far a spring is wound
up there, nobody logged, and a wound-up spring was play at 97 %.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.model import Model, members_of
from camrob.gap.verdict.belief import BELIEF

__all__ = ["shown_by_simpler"]

Array = NDArray[np.float64]

_POSTURE = frozenset({"position", "load"})
_RANK = 1e-9  # of the largest singular value of columns


def shown_by_simpler(model: Model, library: Sequence[Effect], claimed: Collection[str]) -> dict[str, list[str]]:
    """Claimed effects, and those of the same stages and regimes with fewer parameters that show nearly all of what each does, but
    for what frames and latencies that are always fitted take up; or that have no parameter, where logs hold single poses.
    """
    kin = [e for e in library if not _POSTURE.intersection(e.regimes)]
    columns = {e.name: _columns(model, e.name) for e in kin}
    found: dict[str, list[str]] = {}
    poses = any(s.poses for s in model.scenes)
    for one in (e for e in kin if e.name in claimed):
        values = model.values(members_of(model, one.name), model.best)
        for other in kin:
            alike = other.stages == one.stages and set(other.regimes) == set(one.regimes)
            own, others = len(columns[one.name]), len(columns[other.name])
            shows = 0 < others < own and _shown(model, values, columns[other.name]) > BELIEF.shown
            if alike and other is not one and (shows or (poses and others == 0 < own)):
                found.setdefault(one.name, []).append(other.name)
    return found


def _columns(model: Model, name: str) -> NDArray[np.int64]:
    return np.flatnonzero([model.units[o].effect == name for o in model.design.owner])


def _shown(model: Model, values: Array, columns: NDArray[np.int64]) -> float:
    """Share of the energy of values (K,) that some parameters show, both behind those that are always fitted."""
    always = np.flatnonzero(np.isin(model.design.owner, list(model.evidence.always)))
    A = model.design.A.sum(axis=0)
    both = np.r_[always, columns]
    none, some = (float(values @ A @ values - _taken(A, values, c)) for c in (always, both))
    return 1.0 - some / none if none > 0.0 else 0.0


def _taken(A: Array, values: Array, columns: NDArray[np.int64]) -> float:
    """Energy of values (K,) that some parameters show, by the Gram matrix (K, K)."""
    if not len(columns):
        return 0.0
    G, right = A[np.ix_(columns, columns)], A[columns] @ values
    scale = np.sqrt(np.maximum(np.diag(G), 1e-300))
    solved = np.linalg.lstsq(G / np.outer(scale, scale), right / scale, rcond=_RANK)[0]
    return float((right / scale) @ solved)
