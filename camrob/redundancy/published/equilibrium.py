"""Where a solution of the published method stands off the method's own equilibrium, and the weights along it.

Algorithm 1 ends where self-motion has nothing left to gain: N^T h = 0. Followed without a bound, table and track jump where that
posture folds over; camrob bounds self-motion by the tool's own motion and the axes' speeds (`virtual_joint`), so that the posture
lags behind there. How far is worked out from the postures alone, in plain NumPy.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.frozen import locked
from camrob.kinematics.frames import tool_jacobians
from camrob.redundancy.fuzzy.surfaces import WeightSurface
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.published.own_limits import held_joints, own_limits
from camrob.redundancy.published.weighting import engine_weighting
from camrob.redundancy.solution import Solution

__all__ = ["Equilibrium", "equilibrium", "weights_along"]

Array = NDArray[np.float64]

_AT_LIMIT = 1e-9  # rad, m from a limit at which a joint stands there and is no longer free
_LEFT = 1e-6  # rad, m times a weight that may be left along self-motion: the follower's own answer leaves some 1e-10


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """Along a path of N points: weights (N, n) of h_jnt; acting (N,): h_cond has a part in the point; bounded (N,): the posture
    lags behind the equilibrium of h_jnt, since self-motion was bounded (False where h_cond acts: the two can't be told apart,
    and on ways along the tool's axis, where the arm goes alone).
    """

    weights: Array
    acting: NDArray[np.bool_]
    bounded: NDArray[np.bool_]

    def __post_init__(self) -> None:
        object.__setattr__(self, "weights", locked(self.weights, shape=(None, None), name="weights"))
        for name in ("acting", "bounded"):
            object.__setattr__(
                self, name, locked(getattr(self, name), shape=(len(self.weights),), dtype=np.bool_, name=name)
            )


def equilibrium(cell: Cell, path: ToolPathInBase, solution: Solution) -> Equilibrium:
    """What weighed the joints along a solution of `resolve_vjm`, and where it stands off the published equilibrium.

    Raises CellError for an engine that can't be read.
    """
    weighting = engine_weighting(cell)
    q = np.asarray(solution.q)
    weights = weights_along(weighting.joint, q)
    apart = q - _references(cell, path, solution)
    apart = np.where(cell.endless, apart - 2.0 * np.pi * np.round(apart / (2.0 * np.pi)), apart)
    lower, upper = own_limits(cell)
    free = (q > lower + _AT_LIMIT) & (q < upper - _AT_LIMIT) | cell.endless
    free &= ~held_joints(cell)
    h = np.where(free, -weights * apart, 0.0)
    rows = tool_jacobians(cell, q) * free[:, None, :]
    unseen = h - np.einsum("kij,kj->ki", np.linalg.pinv(rows), np.einsum("kij,kj->ki", rows, h))
    left = np.linalg.norm(unseen, axis=1)
    before = np.concatenate([[np.inf], np.asarray(solution.inv_kf)[:-1]])
    acting = before < weighting.threshold
    return Equilibrium(weights, acting, (left > _LEFT) & ~acting & ~path.along_axis)


def weights_along(surface: WeightSurface, q: Array) -> Array:
    """Weights (N, n) that a compiled engine gives postures q (N, n)."""
    table = surface.table
    place = np.empty((3, len(q)))
    for k, nodes in enumerate((surface.nodes0, surface.nodes1, surface.nodes2)):
        rising = slice(None, None, -1 if nodes[0] > nodes[-1] else 1)
        place[k] = np.interp(q[:, surface.axis[k]], nodes[rising], np.arange(len(nodes), dtype=float)[rising])
    low = place.astype(np.int64)
    share = place - low
    weights = np.zeros((len(q), table.shape[3]))
    for corner in product((0, 1), repeat=3):
        at = np.minimum(low.T + corner, np.array(table.shape[:3]) - 1)
        part = np.prod(np.where(np.array(corner)[:, None], share, 1.0 - share), axis=0)
        weights += part[:, None] * table[tuple(at.T)]
    return weights


def _references(cell: Cell, path: ToolPathInBase, solution: Solution) -> Array:
    """(N, n) the reference posture of each point: a kept revision holds the external axes about where it left them."""
    reference = np.tile(cell.q_reference, (len(path), 1))
    external = [*cell.indices(Role.WORKPIECE), *cell.indices(Role.CARRIAGE)]
    for revision in solution.revisions:
        if revision.kept:
            after = slice(revision.point + 1, None)
            if revision.by_axes:
                reference[after] += revision.q[-1] - revision.q[0]
            else:
                reference[after, external] = revision.q[-1, external]
    return reference
