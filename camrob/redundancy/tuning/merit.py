"""What weights are worth on a path: the planner's prices, for the postures that the published method takes with them.

In metres for each metre cut (l_k: metres of cutting that point k stands for, x = 1/k_F, prices of `[resolve.planned]`):

    conditioning  sum l_k conditioning (x_0 / x_k)^power
    margins       sum l_k margin sum_i (2 - d_i/m)+^2 + 10 (1 - d_i/m)+^2
    travel        sum travel |dE|, in air for AIR_SHARE of it
    feed          sum l_k (t_k / t_k^0 - 1): the time that a move takes for its axes' speeds and accelerations, over its own

and UNFOLLOWED for a path that no posture was found for. x_0 is the threshold of the cell.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import JobError
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.objective import AIR_SHARE, PlanWeights, plan_weights
from camrob.redundancy.published.virtual_joint import AIR_SPEED, PathFollower, postures_along
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["UNFOLLOWED", "Merit", "followed_merit", "postures_merit"]

Array = NDArray[np.float64]

UNFOLLOWED = 100.0
"""Price of a path that can't be followed: a metre of it costs what the planner asks where no posture exists."""
_SINGULAR = 0.02  # 1/k_F below which a posture is not priced worse: as the planner has it
_HELD = 0.98  # of the programmed feed, from where on it counts as held: as in the feed's own report


@dataclass(frozen=True, slots=True)
class Merit:
    """What a path costs, `price`, m a metre cut, with its `terms`; 1/k_F mean and lowest while cutting.

    travel: of each external axis while cutting, rad and m. held: the share of the cut length at the programmed feed. margin:
    the least distance to a limit that an arm's joint keeps while cutting, rad. All but `price` are NaN where the path was not
    followed.
    """

    followed: bool
    price: float
    terms: Mapping[str, float]
    inv_kf_mean: float
    inv_kf_min: float
    travel: Mapping[str, float]
    held: float
    margin: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "terms", MappingProxyType(dict(self.terms)))
        object.__setattr__(self, "travel", MappingProxyType(dict(self.travel)))


def followed_merit(follower: PathFollower, *, revise: bool = True) -> Merit:
    """What the published method makes of a follower's path with the weights that the follower has."""
    try:
        q, inv_kf, _revisions = postures_along(follower, revise=revise)
    except JobError:
        none = dict.fromkeys(follower.cell.external_names, np.nan)
        return Merit(False, UNFOLLOWED, {}, np.nan, np.nan, none, np.nan, np.nan)
    return postures_merit(follower.cell, follower.path, q, inv_kf)


def postures_merit(cell: Cell, path: ToolPathInBase, q: Array, inv_kf: Array) -> Merit:
    """What postures q (N, n) with 1/k_F (N,) cost, whatever method they are by."""
    weights = plan_weights(cell)
    cutting = np.asarray(path.cutting)
    step = np.linalg.norm(np.diff(np.asarray(path.base_T_tip)[:, :3, 3], axis=0, prepend=0.0), axis=1)
    step[0] = 0.0
    cut = np.where(cutting, step, 0.0)
    length = max(float(cut.sum()), 1e-9)  # a path of points alone is priced by the point
    cut = cut if cut.any() else np.where(cutting, length / max(1, int(cutting.sum())), 0.0)
    stretch = _slowdown(cell, path, q, step)
    moved = np.abs(np.diff(q, axis=0, prepend=q[:1]))
    price = _travel_prices(cell, weights)
    lying = _margins(cell, weights, q)
    poor = cell.resolve.threshold / np.maximum(inv_kf, _SINGULAR)
    terms = {
        "conditioning": float(cut @ (weights.conditioning * poor**weights.power)),
        "margins": float(cut @ (weights.margin * lying)),
        "travel": float(np.where(cutting, 1.0, AIR_SHARE) @ (moved @ price)),
        "feed": float(cut @ (weights.speed * (stretch - 1.0))),
    }
    terms = {name: value / length for name, value in terms.items()}
    room = np.minimum(q - cell.q_lower, cell.q_upper - q)[cutting][:, cell.arm_slice]
    return Merit(
        True,
        float(sum(terms.values())),
        terms,
        float(np.average(inv_kf, weights=cut)),
        float(inv_kf[cutting].min()),
        {name: float(moved[cutting, cell.index(name)].sum()) for name in cell.external_names},
        float(cut[stretch <= 1.0 / _HELD].sum() / cut.sum()),
        float(room.min()),
    )


def _travel_prices(cell: Cell, weights: PlanWeights) -> Array:
    """(n,) price of a metre or radian of each joint, 0 for all but external axes."""
    out = np.zeros(len(cell))
    for name in cell.external_names:
        i = cell.index(name)
        out[i] = weights.travel_prismatic if cell.joints[i].prismatic else weights.travel_revolute
    return out


def _margins(cell: Cell, weights: PlanWeights, q: Array) -> Array:
    """(N,) the barriers of all joints near their limits, summed."""
    wanted = np.array(
        [mm_to_m(weights.margin_mm) if j.prismatic else deg_to_rad(weights.margin_deg) for j in cell.joints]
    )
    room = np.where(cell.endless, np.inf, np.minimum(q - cell.q_lower, cell.q_upper - q))
    share = room / wanted
    barrier = np.maximum(0.0, 2.0 - share) ** 2 + 10.0 * np.maximum(0.0, 1.0 - share) ** 2
    return np.asarray(barrier.sum(axis=1))


def _slowdown(cell: Cell, path: ToolPathInBase, q: Array, step: Array) -> Array:
    """(N,) how many times its programmed time the move to a point takes, for the axes' speeds and accelerations."""
    feed = np.where(np.isfinite(path.feed) & (np.asarray(path.feed) > 0.0), path.feed, AIR_SPEED)
    time = np.maximum(step / feed, 1e-6)  # a move of nothing takes next to nothing
    dq = np.diff(q, axis=0, prepend=q[:1])
    rate = dq / time[:, None]
    speed = np.abs(rate) / cell.limits_of("speed")
    change = np.abs(np.diff(rate, axis=0, prepend=rate[:1])) / (0.5 * (time + np.roll(time, 1)))[:, None]
    inside = np.asarray(path.cutting) & np.roll(path.cutting, 1)
    inside[:2] = False  # before the first move there is none to change from
    acceleration = np.where(inside[:, None], change, 0.0) / cell.limits_of("acceleration")
    return np.asarray(np.maximum(1.0, np.maximum(speed.max(axis=1), np.sqrt(acceleration.max(axis=1)))))
