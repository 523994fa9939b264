"""Candidate postures at coarse waypoints: external postures that promise much, all rolls and branches, all turns."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.kinematics.arm import reach
from camrob.kinematics.spherical_wrist import BRANCH_OK
from camrob.redundancy.accuracy.part_error import PUSH
from camrob.redundancy.planning.certificate import Certificate, Survey, inside
from camrob.redundancy.planning.freedoms import PlanSpace, PlanWork, conditioning, plan_work, pose_in_foot
from camrob.redundancy.planning.objective import BEYOND, Objective, error_price, posture_price

__all__ = ["Nodes", "candidate_nodes", "external_prices", "region_seeds"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

ROLLS = 24  # of a turn
ROLLS_KEPT = 2  # cheapest rolls a branch, apart from each other
LATTICE = 3  # every third roll is a candidate however dear: a plan may have to pass through it
NODES = 1000  # a layer at most
TURNS_KEPT = (
    4  # whole turns of a posture that a layer takes, in the mean: more of them lead a UR10e's forearm into the stock
)
VARIANTS = 64  # of a posture by whole turns, at most


class Nodes(NamedTuple):
    """Candidates of T layers: offset (T + 1,); u (M, F), q (M, 6), branch (M,), price (M,) a metre."""

    offset: Ints
    u: Array
    q: Array
    branch: Ints
    price: Array


def region_seeds(survey: Survey, members: Ints, count: int, *, spread: bool) -> Array:
    """External postures (K, E) for poses (indices `members`) of one region, K <= count.

    The ones that suit all its scanned poses best, and with `spread` also the best ones of single poses.
    """
    anchors = np.unique(survey.nearest[members])
    rows = survey.best[anchors].astype(float)
    cost = (1.0 / np.maximum(rows, 0.05)) ** 4 if survey.price is None else survey.price[anchors]
    order = np.argsort(cost.mean(axis=0), kind="stable")
    if not spread:
        return np.asarray(survey.grid[order[:count]])
    chosen = list(order[: count // 2])
    ranks = np.argsort(cost, axis=1, kind="stable")
    for rank in range(ranks.shape[1]):
        for row in ranks:
            if len(chosen) >= count:
                return np.asarray(survey.grid[chosen])
            if row[rank] not in chosen:
                chosen.append(row[rank])
    return np.asarray(survey.grid[chosen])


def candidate_nodes(
    space: PlanSpace,
    objective: Objective,
    frames: Array,
    seeds: list[Array],
    certificate: Certificate | None = None,
    push: Array | None = None,
) -> Nodes:
    """Candidates of poses (T, 4, 4): `seeds` holds the external postures (K, E) to try at each; with a certificate (T poses)
    its own best posture is one, too. push: (T, PUSH), where the part's error is looked at.
    """
    external, rows = len(space.free) - space.roll, 8 * TURNS_KEPT * (ROLLS_KEPT + ROLLS // LATTICE + 1)

    def one(t: int) -> tuple[Array, Array, Ints, Array]:
        grid, best = seeds[t], None
        if certificate is not None and certificate.inv_kf[t] > 0.0:
            best = np.array(certificate.u[t])  # a copy: frozen arrays would be compiled for separately
            grid = np.concatenate([grid, best[None, :external]])
        frame = np.ascontiguousarray(frames[t])
        u, q, branch, price = _layer(
            space,
            objective,
            frame,
            np.ascontiguousarray(grid),
            best is not None,
            best if best is not None else np.zeros(len(space.free)),
            ROLLS,
            np.array(push[t]) if push is not None and len(push) else np.zeros(PUSH),
            space.lower,
            space.upper,
        )
        u, q, branch, price = (x[: rows * len(grid)] for x in (u, q, branch, price))
        keep = _kept(u[:, :external], price)
        return u[keep], q[keep], branch[keep], price[keep]

    with ThreadPoolExecutor(2) as pool:  # the kernel releases the interpreter's lock
        layers = list(pool.map(one, range(len(frames))))
    counts = np.array([0, *(len(layer[3]) for layer in layers)])
    us, qs, branches, prices = (np.concatenate(column) for column in zip(*layers, strict=True))
    return Nodes(np.cumsum(counts), us, qs, branches, prices)


def _kept(external: Array, price: Array) -> Ints:
    """Indices of NODES candidates at most, the cheapest first of each external posture, so that none dies out for being dear
    at one pose.
    """
    if len(price) <= NODES:
        return np.argsort(price, kind="stable")
    group = np.concatenate([[0], np.cumsum(np.any(external[1:] != external[:-1], axis=1))])
    order = np.lexsort((price, group))
    first = np.flatnonzero(np.diff(group[order], prepend=-1))
    rank = np.empty(len(price), np.int64)
    rank[order] = np.arange(len(price)) - np.repeat(first, np.diff(np.append(first, len(price))))
    return np.lexsort((price, rank))[:NODES]


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
def _layer(
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
    room = M * 8 * (ROLLS_KEPT + count // LATTICE + 1) * 4
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
