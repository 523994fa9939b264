"""Where to put the part: the placements that let the best postures be best."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import UnreachableError
from camrob.frozen import locked
from camrob.progress import Share
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.certificate import certify, external_grid, representatives, scan
from camrob.redundancy.planning.freedoms import PlanSpace, plan_space
from camrob.redundancy.planning.sought import between_nodes
from camrob.redundancy.planning.waypoints import waypoints
from camrob.se3 import inverse

__all__ = ["Placements", "place_stretches"]

Array = NDArray[np.float64]

SPACING = 0.05  # m of the path between the poses that may stand for it
POSES = 24  # that stand for a path
_CHUNK = 64  # placements that are looked at together


@dataclass(frozen=True, slots=True)
class Placements:
    """Placements P of a part and what the best postures at its poses would give.

    base_T_part: (P, 4, 4). mean, worst: (P,) of the certificate's 1/k_F over the path's poses; 0 where a pose is out of
    reach. best: the placement with the highest sum of both. here: the index of the placement as it is.
    """

    base_T_part: Array
    mean: Array
    worst: Array
    best: int
    here: int

    def __post_init__(self) -> None:
        n = len(self.mean)
        object.__setattr__(self, "base_T_part", locked(self.base_T_part, shape=(n, 4, 4), name="base_T_part"))
        object.__setattr__(self, "mean", locked(self.mean, shape=(n,), name="mean"))
        object.__setattr__(self, "worst", locked(self.worst, shape=(n,), name="worst"))

    @property
    def value(self) -> Array:
        """(P,) what placements are ranked by: mean and worst 1/k_F, summed; 0 out of reach."""
        return np.asarray(self.mean + self.worst)

    @property
    def ranking(self) -> NDArray[np.int64]:
        """The placements in reach, the best one first."""
        order = np.argsort(-self.value, kind="stable")
        return np.asarray(order[self.value[order] > 0.0])


def place_stretches(
    stretches: Sequence[tuple[Cell, ToolPathInBase]],
    base_T_part: Array,
    shifts: Array,
    *,
    progress: Share | None = None,
    seconds: float | None = None,
    poses: int = POSES,
) -> Placements:
    """Placements that differ from base_T_part (4, 4) by `shifts` (S, 3), m, in `base`; the present one comes first.

    stretches: between changes of tools, the cell with the tool and the toolpath placed by base_T_part. About 20 ms a placement
    and stretch. Turning the part about an endless table's axis changes nothing that the table could not make good, so it is no
    freedom here. seconds: of processor after which no further placements are begun, and what is out of reach at first sight is
    looked for no further; those that there was no time for are left out of what is returned. poses: of each stretch, at most,
    that stand for it. Raises UnreachableError where no placement that was looked at has all of them in reach, CellError for an
    arm without closed form.
    """
    looked = [_Stretch.of(cell, path, base_T_part, poses) for cell, path in stretches]
    placed = np.repeat(np.asarray(base_T_part, float)[None], len(shifts) + 1, axis=0)
    placed[1:, :3, 3] += shifts
    weight = np.concatenate([s.weight for s in looked])
    value = np.empty((len(placed), len(weight)))
    until = np.inf if seconds is None else time.process_time() + seconds
    for start in range(0, len(placed), _CHUNK):
        if time.process_time() > until:
            placed, value = placed[:start], value[:start]
            break
        some = placed[start : start + _CHUNK]
        value[start : start + _CHUNK] = np.concatenate([s.bounds(some, until) for s in looked], axis=1)
        if progress is not None:
            progress((start + len(some)) / len(placed))
    reached = np.all(value > 0.0, axis=1)
    if not np.any(reached):
        raise UnreachableError(
            "no placement within the given freedom has the whole path in reach; give more (--x, --y, --z), or first correct "
            "part_in_base: camrob post says how far off it is"
        )
    mean = np.where(reached, value @ weight / weight.sum(), 0.0)
    worst = np.where(reached, value.min(axis=1), 0.0)
    return Placements(placed, mean, worst, int(np.argmax(mean + worst)), 0)


@dataclass(frozen=True)
class _Stretch:
    """Poses (A, 4, 4) of the tip in the part that stand for what one tool cuts, and how much of it (A,) each stands for."""

    cell: Cell
    space: PlanSpace
    part_T_tip: Array
    weight: Array

    @classmethod
    def of(cls, cell: Cell, path: ToolPathInBase, base_T_part: Array, poses: int) -> _Stretch:
        w = waypoints(path, SPACING)
        cut = np.flatnonzero(np.asarray(w.cut) > 0.0)
        cuts = np.asarray(w.base_T_tip)[cut if len(cut) else np.arange(len(w))]
        chosen, nearest = representatives(cuts, poses)
        weight = np.bincount(nearest, minlength=len(chosen)).astype(float)
        return cls(cell, plan_space(cell), np.asarray(inverse(base_T_part) @ cuts[chosen]), weight)

    def bounds(self, base_T_part: Array, until: float) -> Array:
        """(P, A) as `_bounds`, of placements (P, 4, 4)."""
        return _bounds(self.cell, self.space, np.einsum("aij,bjk->abik", base_T_part, self.part_T_tip), until)


def _bounds(cell: Cell, space: PlanSpace, base_T_tip: Array, until: float) -> Array:
    """The best 1/k_F (P, A) at poses (P, A, 4, 4) of placements: by the certificate, or over the branches where the cell has no
    spare freedom. Of a placement that has a pose out of reach not all are looked for.

    A pose that no scan reaches is sought between its nodes, as a plan would; after `until`, s of processor, no more.
    """
    P, A = base_T_tip.shape[:2]
    poses = locked(base_T_tip.reshape(P * A, 4, 4))
    if not len(space.free):
        grid = external_grid(space)
        return np.array([scan(space, frame, grid, 1).max() for frame in poses], float).reshape(P, A)
    value = np.array(certify(space, poses).inv_kf)
    for placement in np.arange(P * A).reshape(P, A):
        if time.process_time() > until:
            continue
        for k in placement[value[placement] <= 0.0]:  # what another placement out of reach kept from being looked for
            value[k] = certify(space, poses[k : k + 1]).inv_kf[0]
            own = between_nodes(cell, space, poses[k]) if value[k] <= 0.0 else None
            value[k] = value[k] if own is None else own.inv_kf[0]
            if value[k] <= 0.0:
                break
    return np.asarray(value.reshape(P, A))
