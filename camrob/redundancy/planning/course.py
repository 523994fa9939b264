"""From candidates to a course: dynamic programming over coarse waypoints, then refinement over all of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.accuracy.part_error import SHARE
from camrob.redundancy.planning.dynamic_programming import Layers, Way, cheapest_way
from camrob.redundancy.planning.forbidding import LOOKS, RoomOf, forbidden, forbidden_price, narrow, room_price
from camrob.redundancy.planning.freedoms import PlanSpace
from camrob.redundancy.planning.layers import Nodes
from camrob.redundancy.planning.objective import AIR_SHARE, Moves, Objective, motion_price, plan_prices
from camrob.redundancy.planning.refinement import ITERATIONS, Course, arm_along, refine_course
from camrob.redundancy.planning.waypoints import Waypoints

__all__ = [
    "RETRACT_NEEDED",
    "RETRACT_PRICE",
    "Draft",
    "coarse_index",
    "draft_course",
    "draft_terms",
    "moves_along",
    "relaxed",
    "search",
    "stopped",
    "waypoint_weights",
]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

RETRACT_PRICE, RETRACT_NEEDED = 200.0, 1.0
"""m: price of a re-posture where the path has no safe point, so that a retract has to be put in: only where nothing else goes;
and, where it is known that nothing else goes, how much better the postures have to become by one more.
"""
_WINDOW_REVOLUTE, _WINDOW_PRISMATIC = 0.6, 0.3  # rad, m that an external axis may move between coarse waypoints
_WINDOW_ROLL, _WINDOW_ARM, _WINDOW_WRIST = 0.9, 0.9, 1.6  # rad
_HELD = 1e-9
_STIFF = 1e3  # m a rad2 or m2: price that holds a freedom still while the whole is refined
_LEAST_STEP, _LEAST_TIME = 1e-3, 1e-3  # m, s taken for a move that is shorter


@dataclass(frozen=True, slots=True)
class Draft:
    """A plan: u (K, F), q (K, 6), branch (K,) at waypoints `index` (K,), increasing; one that stands twice is where the posture
    jumps (`joined` (K,) False at the second). `rigid` (K,): the move there leads on in the same region. `price`: the search's.
    """

    index: Ints
    u: Array
    q: Array
    branch: Ints
    joined: Mask
    rigid: Mask
    price: float

    def __len__(self) -> int:
        return len(self.index)


def coarse_index(w: Waypoints, spacing: float) -> Ints:
    """Waypoints to search over: ends, safe points and borders of regions, and others about `spacing` (m of s) apart."""
    n = len(w)
    must = np.array(w.safe)
    must[[0, n - 1]] = True
    border = np.diff(w.region) != 0
    must[:-1] |= border
    must[1:] |= border
    run = np.cumsum(must)
    first = np.concatenate([[0.0], w.s[must]])[run]
    cell = np.floor((np.asarray(w.s) - first) / spacing)
    fresh = np.ones(n, np.bool_)
    fresh[1:] = (np.diff(cell) > 0) | must[1:]
    return np.flatnonzero(must | fresh)


def waypoint_weights(w: Waypoints) -> Array:
    """(W,) m that the posture at each waypoint counts for: what is cut, and a share of what is travelled in air."""
    s = np.asarray(w.s)
    edge = np.concatenate([[s[0]], 0.5 * (s[1:] + s[:-1]), [s[-1]]])
    return np.asarray(w.cut + AIR_SHARE * np.maximum(np.diff(edge) - w.cut, 0.0) + 1e-4)


def search(
    space: PlanSpace,
    objective: Objective,
    w: Waypoints,
    nodes: Nodes,
    *,
    still: bool,
    travel: float,
    retract: float = RETRACT_PRICE,
    room_of: RoomOf | None = None,
) -> Way:
    """The cheapest way through candidates of waypoints `w`; `still` holds the external axes within a region.

    travel: times the cell's price of external travel; retract: m, price of a re-posture that needs a retract. With `room_of` no
    candidate on the way touches anything, where there is such a way.
    """
    T, F, external = len(w), len(space.free), len(space.free) - space.roll
    n = F + 7
    x = np.concatenate([nodes.u, nodes.q, nodes.branch[:, None].astype(float)], axis=1)
    window = np.empty((T, n))
    window[:, :external] = np.where(space.prismatic, _WINDOW_PRISMATIC, _WINDOW_REVOLUTE)
    window[:, external:F] = _WINDOW_ROLL
    window[:, F : F + 3] = _WINDOW_ARM
    window[:, F + 3 : F + 6] = _WINDOW_WRIST
    window[:, F + 6] = 0.5
    if still:
        window[1:][_same_region(w), :external] = _HELD
    motion = motion_price(objective._replace(travel=travel * objective.travel), moves_along(w, np.arange(T)))
    rate, square, top = (
        np.pad(x, ((0, 0), (0, 1)), constant_values=empty)  # a branch is not gone along
        for x, empty in ((motion.rate, 0.0), (motion.square, 0.0), (motion.top, np.inf))
    )
    jump = np.where(w.safe, objective.reposture, np.where(w.on_point, retract, np.inf))
    endless = np.zeros(n, np.bool_)
    endless[:F] = space.u_endless
    weight = np.repeat(waypoint_weights(w), np.diff(nodes.offset))
    price = (nodes.price + forbidden_price(objective, nodes.offset, nodes.q, w.s)) * weight
    layers = Layers(nodes.offset, x, price, window, rate, square, top, motion.haste, endless, jump)
    for look in range(LOOKS if room_of is not None else 0):
        way: Way = cheapest_way(layers._replace(price=price + room_price(nodes) * weight))
        if way.reached < T or room_of is None:
            break
        some = np.unique(np.concatenate([way.arrive, way.leave]))
        if not narrow(nodes, some, room_of, 2**look) or look == LOOKS - 1:
            return way
    freely: Way = cheapest_way(layers)  # what it touches is told by the plan
    return freely


def _same_region(w: Waypoints) -> Mask:
    """(W - 1,) True for moves within one region."""
    region = np.asarray(w.region)
    return np.asarray((region[1:] == region[:-1]) & (region[1:] >= 0))


def draft_course(space: PlanSpace, w: Waypoints, coarse: Ints, nodes: Nodes, way: Way, home: Array) -> Draft:
    """The way through coarse waypoints, drawn out over all of `w`: freedoms linear between them, the arm on its branch.

    home (F,): the freedoms near whose turns endless axes begin.
    """
    jumps = [int(t) for t in np.flatnonzero(way.arrive != way.leave)]
    index: list[Ints] = []
    us: list[Array] = []
    branches: list[Ints] = []
    starts: list[Array] = []
    joined: list[Mask] = []
    last = home
    for a, b in zip([0, *jumps], [*jumps, len(coarse) - 1], strict=True):
        node = np.concatenate([[way.leave[a]], way.arrive[a + 1 : b + 1]])
        u = nodes.u[node].copy()
        for i in np.flatnonzero(space.u_endless):
            u[:, i] = np.unwrap(u[:, i])
            u[:, i] += 2.0 * np.pi * np.round((last[i] - u[0, i]) / (2.0 * np.pi))
        fine = np.arange(coarse[a], coarse[b] + 1)
        index.append(fine)
        us.append(np.stack([np.interp(fine, coarse[a : b + 1], column) for column in u.T], axis=1))
        branches.append(np.full(len(fine), nodes.branch[node[0]]))
        starts.append(np.repeat(nodes.q[node[:1]], len(fine), axis=0))
        joined.append(np.arange(len(fine)) > 0)
        last = us[-1][-1]
    at = np.concatenate(index)
    rigid = np.concatenate([[False], _same_region(w)])[at] & np.concatenate(joined)
    draft = Draft(
        at,
        np.concatenate(us),
        np.concatenate(starts),
        np.concatenate(branches),
        np.concatenate(joined),
        rigid,
        way.price,
    )
    frames = np.ascontiguousarray(w.base_T_tip[at])
    q, _good = arm_along(space, frames, draft.branch, draft.joined, draft.u, draft.q)
    return replace(draft, q=q)


def moves_along(w: Waypoints, at: Ints) -> Moves:
    """The moves from each of the waypoints `at` (K,) to the next."""
    push = w.pushes(at)
    counts = (push[:, SHARE] > 0.0).astype(float) if len(push) else np.zeros(len(at))
    return Moves(
        np.maximum(np.diff(w.s[at], prepend=w.s[at[0]]), _LEAST_STEP),
        np.maximum(w.time[at], _LEAST_TIME),
        np.where(w.cutting[at], 1.0, AIR_SHARE),
        counts * np.append(0.0, counts[:-1]),
    )


def _draft_weights(w: Waypoints, draft: Draft) -> Array:
    """(K,) m that the posture at each waypoint of a draft counts for, shared by the two where the posture jumps."""
    weight = waypoint_weights(w)[draft.index]
    second = ~draft.joined
    second[0] = False
    weight[second] *= 0.5
    weight[np.flatnonzero(second) - 1] *= 0.5
    return weight


def draft_terms(space: PlanSpace, objective: Objective, w: Waypoints, draft: Draft) -> dict[str, float]:
    """The objective's terms for a draft, m, re-postures apart."""
    moves, push = moves_along(w, draft.index), w.pushes(draft.index)
    return plan_prices(space, objective, draft.u, draft.q, _draft_weights(w, draft), push, moves, draft.joined)


def _surroundings(
    space: PlanSpace, objective: Objective, w: Waypoints, draft: Draft, travel: float, stiff: float = 0.0
) -> Course:
    """The surroundings of a draft: external travel at `travel` times its price, `stiff` holding it within regions."""
    at = draft.index
    motion = motion_price(objective._replace(travel=travel * objective.travel), moves_along(w, at))
    motion.square[draft.rigid, : len(space.free) - space.roll] += stiff
    return Course(
        np.ascontiguousarray(w.base_T_tip[at]),
        draft.branch,
        _draft_weights(w, draft),
        motion,
        draft.joined,
        w.pushes(at),
        forbidden(objective, w.s[at]),
    )


def relaxed(space: PlanSpace, objective: Objective, w: Waypoints, draft: Draft, travel: float) -> Draft:
    """The draft refined, external travel priced `travel` times the cell's weight."""
    course = _surroundings(space, objective, w, draft, travel)
    u, q = draft.u.copy(), draft.q.copy()
    price = refine_course(space, objective, course, u, q, np.zeros(len(space.free), np.bool_), ITERATIONS)
    return replace(draft, u=u, q=q, price=price)


def stopped(space: PlanSpace, objective: Objective, w: Waypoints, draft: Draft) -> Draft:
    """The draft refined with the external axes exactly still along each region's stretches."""
    external = len(space.free) - space.roll
    u, q = draft.u.copy(), draft.q.copy()
    group = np.cumsum(~draft.rigid) - 1
    weight = waypoint_weights(w)[draft.index]
    _settle(u, group, weight, external)
    nothing, hold = np.zeros(len(space.free), np.bool_), np.zeros(len(space.free), np.bool_)
    hold[:external] = True
    course = _surroundings(space, objective, w, draft, 1.0, _STIFF)
    q, _good = arm_along(space, course.frames, course.branch, course.joined, u, q)
    refine_course(space, objective, course, u, q, nothing, ITERATIONS)
    _settle(u, group, weight, external)
    q, _good = arm_along(space, course.frames, course.branch, course.joined, u, q)
    price = refine_course(space, objective, course, u, q, hold, ITERATIONS)
    return replace(draft, u=u, q=q, price=price)


def _settle(u: Array, group: Ints, weight: Array, external: int) -> None:
    """Give the external axes of each group their mean."""
    total = np.bincount(group, weight)
    for i in range(external):
        u[:, i] = (np.bincount(group, weight * u[:, i]) / total)[group]
