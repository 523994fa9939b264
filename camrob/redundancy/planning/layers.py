"""The layers of the lattice that is searched: which external postures are tried at each waypoint, and which candidates stay."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.accuracy.part_error import PUSH
from camrob.redundancy.planning.candidates import LATTICE, ROLLS, ROLLS_KEPT, layer
from camrob.redundancy.planning.certificate import Certificate, Survey
from camrob.redundancy.planning.freedoms import PlanSpace
from camrob.redundancy.planning.objective import Objective

__all__ = ["Nodes", "candidate_nodes", "region_seeds"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

NODES = 1000  # a layer at most
_TURNS = 4  # of a posture, before all others of it


class Nodes(NamedTuple):
    """Candidates of T layers: offset (T + 1,); u (M, F), q (M, 6), branch (M,), price (M,) a metre. room (M,): m that the bodies
    have in them, as far as the search has asked (`forbidding`), else NaN.
    """

    offset: Ints
    u: Array
    q: Array
    branch: Ints
    price: Array
    room: Array


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
    *,
    every: bool = False,
) -> Nodes:
    """Candidates of poses (T, 4, 4): `seeds` holds the external postures (K, E) to try at each; with a certificate (T poses)
    its own best posture is one, too. push: (T, PUSH), where the part's error is looked at. every: the last branches, too, of an
    arm with so many whole turns that those of the first ones fill a layer: a UR10's plans by them touch something oftener than
    by the others, so that they are for a search that asks for room.
    """
    external = len(space.free) - space.roll
    most = 8 * _TURNS * (ROLLS_KEPT + ROLLS // LATTICE + 1)

    def one(t: int) -> tuple[Array, Array, Ints, Array]:
        grid, best = seeds[t], None
        if certificate is not None and certificate.inv_kf[t] > 0.0:
            best = np.array(certificate.u[t])  # a copy: frozen arrays would be compiled for separately
            grid = np.concatenate([grid, best[None, :external]])
        frame = np.ascontiguousarray(frames[t])
        u, q, branch, price = layer(
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
        if not every:
            u, q, branch, price = (column[: most * len(grid)] for column in (u, q, branch, price))
        keep = _kept(external, u, branch, price)
        return u[keep], q[keep], branch[keep], price[keep]

    with ThreadPoolExecutor(2) as pool:  # the kernel releases the interpreter's lock
        made = list(pool.map(one, range(len(frames))))
    counts = np.array([0, *(len(price) for _u, _q, _branch, price in made)])
    us, qs, branches, prices = (np.concatenate(column) for column in zip(*made, strict=True))
    return Nodes(np.cumsum(counts), us, qs, branches, prices, np.full(len(prices), np.nan))


def _kept(external: int, u: Array, branch: Ints, price: Array) -> Ints:
    """Indices of NODES candidates at most, the cheapest first of each external posture, so that none dies out for being dear
    at one pose; of each posture _TURNS of its whole turns before any further ones, so that these don't take all the room.
    """
    if len(price) <= NODES:
        return np.argsort(price, kind="stable")
    other = np.any(u[1:] != u[:-1], axis=1)
    posture = np.concatenate([[0], np.cumsum(other | (branch[1:] != branch[:-1]))])
    place = np.concatenate([[0], np.cumsum(np.any(u[1:, :external] != u[:-1, :external], axis=1))])
    turns = np.maximum(_ranked(posture, price) - (_TURNS - 1), 0)
    return np.lexsort((price, _ranked(place, turns, price)))[:NODES]


def _ranked(group: Ints, *by: Array | Ints) -> Ints:
    """The rank (K,) of each within its group, increasing from row to row, by what comes first in `by`."""
    order = np.lexsort((*by[::-1], group))
    first = np.flatnonzero(np.diff(group[order], prepend=-1))
    rank = np.empty(len(group), np.int64)
    rank[order] = np.arange(len(group)) - np.repeat(first, np.diff(np.append(first, len(group))))
    return rank
