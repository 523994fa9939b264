"""Candidate postures at one pose, compiled: external postures that promise much, all rolls and branches, all turns."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.kinematics.arm import reach
from camrob.kinematics.spherical_wrist import BRANCH_OK
from camrob.redundancy.planning.certificate import inside
from camrob.redundancy.planning.freedoms import PlanSpace, PlanWork, conditioning, plan_work, pose_in_foot
from camrob.redundancy.planning.objective import BEYOND, Objective, error_price, posture_price

__all__ = ["ROLLS", "external_prices", "layer"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

ROLLS = 24  # of a turn
ROLLS_KEPT = 2  # cheapest rolls a branch, apart from each other
LATTICE = 3  # every third roll is a candidate however dear: a plan may have to pass through it
_TURNS = 4  # whole turns of a posture that a layer has room for at first
VARIANTS = 64  # of a posture by whole turns, at most


@kernel(nogil=True)
def external_prices(
    space: PlanSpace, objective: Objective, base_T_tip: Array, grid: Array, rolls: int, push: Array
) -> tuple[Array, float]:
    """The lowest price of a metre (M,) over roll and branch in each external posture of a grid (M, E), and the lowest that the
    part's error costs in any of them.
    """
    M, E = grid.shape
    work = plan_work()
    u, price, least = np.zeros(space.free.shape[0]), np.full(M, BEYOND), np.inf
    count = rolls if space.roll == 1 else 1
    for m in range(M):
        u[:E] = grid[m]
        for k in range(count):
            if space.roll == 1:
                u[E] = -np.pi + 2.0 * np.pi * k / rolls
            pose_in_foot(space, base_T_tip, u, work)
            if reach(space.arm, space.screws, work.Rt, work.pt, space.center, work.Q, work.why) == 0:
                continue
            for b in range(8):
                if work.why[b] == BRANCH_OK and inside(space, work.Q[b]):
                    q = work.Q[b].copy()
                    own = error_price(objective, u, q, push)
                    a, c = posture_price(space, objective, u, q, conditioning(space, q, work))
                    price[m] = min(price[m], own + a + c)
                    least = min(least, own)
    return price, least


@part
def _turns(lower: Array, upper: Array, q: Array, variants: Array) -> int:
    """Fill variants (VARIANTS, 6) with q and its whole turns within limits; returns their number, 0 where q itself is outside."""
    for i in range(6):
        if q[i] < lower[i] or q[i] > upper[i]:
            return 0
    variants[0] = q
    count = 1
    for i in range(6):
        before = count
        for sign in (-1.0, 1.0):
            other = q[i] + sign * 2.0 * np.pi
            if lower[i] <= other <= upper[i]:
                for k in range(before):
                    if count < variants.shape[0]:
                        variants[count] = variants[k]
                        variants[count, i] = other
                        count += 1
    return count


@part
def _price_branches(
    space: PlanSpace,
    objective: Objective,
    u: Array,
    push: Array,
    work: PlanWork,
    q: Array,
    price: Array,
    well: Array,
) -> None:
    """q (8, 6), price (8,), well (8,) <- each branch that `work` has, its price, and that without its limit margins."""
    value = -1.0
    for b in range(8):
        if b % space.alike == 0:
            value = -1.0
        if work.why[b] == BRANCH_OK:
            q[b] = work.Q[b]
            if inside(space, q[b]):
                if value < 0.0:  # both branches of a spherical wrist share 1/k_F
                    value = conditioning(space, q[b], work)
                a, c = posture_price(space, objective, u, q[b], value)
                if objective.errors.weight > 0.0:
                    a += error_price(objective, u, q[b], push)
                price[b], well[b] = a + c, a


@part
def _longer(rows: Array, count: int) -> Array:
    """rows (K, ..) with room for count of them."""
    out = np.empty((count, *rows.shape[1:]), rows.dtype)
    out[: rows.shape[0]] = rows
    return out


@kernel(nogil=True)
def layer(
    space: PlanSpace, objective: Objective, frame: Array, grid: Array, exact: bool, best: Array, rolls: int, push: Array,
    lower: Array, upper: Array,
) -> tuple[Array, Array, Ints, Array]:  # fmt: skip
    """Candidates of one pose: u (K, F), q (K, 6), branch (K,), price (K,). `exact`: the last of the grid has best's own roll;
    lower, upper (6,): within which whole turns are tried.
    """
    M, E = grid.shape
    F = space.free.shape[0]
    count = rolls if space.roll == 1 else 1
    work = plan_work()
    q_all, price, angle = np.empty((count, 8, 6)), np.empty((count, 8)), np.zeros(count)
    chosen, rest, well = np.zeros(count, np.bool_), np.empty(count), np.empty((count, 8))
    room = M * 8 * (ROLLS_KEPT + count // LATTICE + 1) * _TURNS
    u_out, q_out = np.empty((room, F)), np.empty((room, 6))
    branch_out, price_out = np.empty(room, np.int64), np.empty(room)
    variants, u = np.empty((VARIANTS, 6)), np.zeros(F)
    K = 0
    for m in range(M):
        u[:E] = grid[m]
        for k in range(count):
            angle[k] = -np.pi + 2.0 * np.pi * k / rolls if space.roll == 1 else 0.0
            if exact and m == M - 1 and space.roll == 1:
                angle[k] += best[F - 1]
                angle[k] -= 2.0 * np.pi * np.round(angle[k] / (2.0 * np.pi))
            if space.roll == 1:
                u[F - 1] = angle[k]
            price[k] = np.inf
            pose_in_foot(space, frame, u, work)
            if reach(space.arm, space.screws, work.Rt, work.pt, space.center, work.Q, work.why) == 0:
                continue
            _price_branches(space, objective, u, push, work, q_all[k], price[k], well[k])
        for b in range(8):
            chosen[:] = False
            for k in range(0, count, LATTICE):
                chosen[k] = price[k, b] < np.inf
            rest[:] = price[:, b]
            for _again in range(ROLLS_KEPT):
                k = int(np.argmin(rest))
                if rest[k] < np.inf:
                    chosen[k] = True
                    for d in range(-2, 3):  # its neighbours are no other choice
                        rest[(k + d) % count] = np.inf
            for k in range(count):
                if not chosen[k]:
                    continue
                total = _turns(lower, upper, q_all[k, b], variants)
                if K + total > room:
                    room *= 2
                    u_out, q_out = _longer(u_out, room), _longer(q_out, room)
                    branch_out, price_out = _longer(branch_out, room), _longer(price_out, room)
                if space.roll == 1:
                    u[F - 1] = angle[k]
                for v in range(total):
                    _a, c = posture_price(space, objective, u, variants[v], 1.0)
                    u_out[K], q_out[K], branch_out[K], price_out[K] = u, variants[v], b, well[k, b] + c
                    K += 1
    return u_out[:K], q_out[:K], branch_out[:K], price_out[:K]
