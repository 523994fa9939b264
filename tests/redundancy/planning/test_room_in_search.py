"""Collisions within the search: what touches is not gone through, is found out only where the search comes by, and costs nothing
more than that.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from camrob.bodies.advance import pair_distances
from camrob.bodies.room import rooms
from camrob.cell.read_cell import read_cell
from camrob.checks.collisions import check_collisions
from camrob.checks.rooms import job_room
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.course import coarse_index, search
from camrob.redundancy.planning.forbidding import WANTED, RoomOf, room_price
from camrob.redundancy.planning.freedoms import plan_space
from camrob.redundancy.planning.layers import Nodes, candidate_nodes
from camrob.redundancy.planning.objective import Objective, plan_weights
from camrob.redundancy.planning.waypoints import Waypoints, waypoints
from camrob.toolpath.region import Move

CELL = read_cell(Path(__file__).resolve().parents[3] / "cells" / "kr15_track_table")
SPACE = plan_space(CELL)
OBJECTIVE = Objective.of(CELL, SPACE, plan_weights(CELL))


def lattice() -> tuple[Waypoints, Nodes]:
    """A straight cut of 1.2 m, a layer each 0.1 m, track and table at six places."""
    count = 61
    frames = np.tile(np.eye(4), (count, 1, 1))
    frames[:, 0, 3], frames[:, 2, 3] = np.linspace(-0.6, 0.6, count), 0.3
    path = ToolPathInBase(
        frames, np.full(count, int(Move.CUT)), np.full(count, 0.02), np.arange(count), np.zeros(count, np.int32),
        np.arange(count), np.zeros(count, np.bool_),
    )  # fmt: skip
    w = waypoints(path, 0.02)
    at = w.take(coarse_index(w, 0.1))
    seeds = [np.array([[turn, slide] for turn in (-0.3, 0.0, 0.3) for slide in (-0.2, 0.2)])] * len(at)
    return at, candidate_nodes(SPACE, OBJECTIVE, at.base_T_tip, seeds)


def freely_led(u: np.ndarray, q: np.ndarray, last: bool) -> np.ndarray:
    """Ways from and to HOME that nothing stands in."""
    return np.full(len(u), WANTED)


def wall(u: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Room that is lost as the second and the fourth axis turn one way: some postures of each layer touch, some nearly."""
    return np.clip(0.02 * (np.sin(3.0 * q[:, 3]) + np.cos(4.0 * u[:, 2]) + np.sin(5.0 * q[:, 1])), 0.0, WANTED)


def test_the_way_is_the_cheapest_of_all_that_touch_nothing_and_few_are_asked() -> None:
    at, nodes = lattice()
    asked: list[int] = []

    def room_of(u: np.ndarray, q: np.ndarray) -> np.ndarray:
        asked.append(len(u))
        return wall(u, q)

    free = search(SPACE, OBJECTIVE, at, nodes, still=False, travel=0.1)
    lazy = search(SPACE, OBJECTIVE, at, nodes, still=False, travel=0.1, room_of=RoomOf(room_of, freely_led))
    whole = nodes._replace(room=wall(nodes.u, nodes.q))
    weeded = whole._replace(price=whole.price + room_price(whole))
    best = search(SPACE, OBJECTIVE, at, weeded, still=False, travel=0.1)
    assert np.isinf(room_price(whole)[free.arrive]).any()  # there was something to go round
    assert not np.isinf(room_price(whole)[lazy.arrive]).any() and not np.isinf(room_price(whole)[lazy.leave]).any()
    assert lazy.price == pytest.approx(best.price, rel=1e-12) and lazy.price > free.price
    assert sum(asked) <= len(nodes.price)


def test_nothing_is_asked_of_what_the_way_has_nothing_to_do_with() -> None:
    at, nodes = lattice()
    asked: list[int] = []

    def room_of(u: np.ndarray, q: np.ndarray) -> np.ndarray:
        asked.append(len(u))
        return np.full(len(u), WANTED)

    free = search(SPACE, OBJECTIVE, at, nodes, still=True, travel=1.0)
    way = search(SPACE, OBJECTIVE, at, nodes, still=True, travel=1.0, room_of=RoomOf(room_of, freely_led))
    assert np.array_equal(way.arrive, free.arrive) and way.price == free.price
    assert sum(asked) <= 2 * len(at)


def test_a_layer_in_which_all_touch_is_gone_through_so_that_the_plan_tells_of_it() -> None:
    at, nodes = lattice()
    fifth = {row.tobytes() for row in nodes.q[nodes.offset[4] : nodes.offset[5]]}

    def room_of(u: np.ndarray, q: np.ndarray) -> np.ndarray:
        return np.array([0.0 if row.tobytes() in fifth else WANTED for row in q])

    way = search(SPACE, OBJECTIVE, at, nodes, still=False, travel=0.1, room_of=RoomOf(room_of, freely_led))
    free = search(SPACE, OBJECTIVE, at, nodes, still=False, travel=0.1)
    assert way.reached == len(at) and np.array_equal(way.arrive, free.arrive)


def test_a_plan_begins_and_ends_in_postures_that_have_a_free_way_from_home_and_back() -> None:
    at, nodes = lattice()
    free = search(SPACE, OBJECTIVE, at, nodes, still=False, travel=0.1)
    begin, end = nodes.q[free.leave[0]], nodes.q[free.arrive[-1]]

    def led(u: np.ndarray, q: np.ndarray, last: bool) -> np.ndarray:
        """Blocked within 0.3 rad of where the search would begin and end by itself, the turns of A6 told apart."""
        far = np.abs(q - (end if last else begin)).max(axis=1)
        return np.where(far < 0.3, 0.0, WANTED)

    way = search(
        SPACE, OBJECTIVE, at, nodes, still=False, travel=0.1, room_of=RoomOf(lambda u, q: freely_led(u, q, True), led)
    )
    assert way.reached == len(at) and way.price >= free.price
    assert np.abs(nodes.q[way.leave[0]] - begin).max() >= 0.3 and np.abs(nodes.q[way.arrive[-1]] - end).max() >= 0.3


@pytest.fixture
def boulder() -> np.ndarray:
    """A stock of 300 triangles about the middle of the table."""
    rng = np.random.default_rng(2)
    middle = rng.uniform([-0.3, -0.3, 0.0], [0.3, 0.3, 0.5], (300, 1, 3))
    return np.asarray(middle + rng.uniform(-0.04, 0.04, (300, 3, 3)))


def test_the_least_room_is_that_of_all_pairs_one_by_one(boulder: np.ndarray) -> None:
    rng = np.random.default_rng(3)
    q = np.ascontiguousarray(CELL.q_home + rng.uniform(-1.0, 1.0, (200, len(CELL))))
    room = job_room(CELL, stock_mesh=boulder)
    assert room is not None
    alone = np.array([pair_distances(room.links, room.riders, a, b, q) for a, b in room.pairs.tolist()]).min(axis=0)
    for wanted in (0.01, 0.3):
        ours = rooms(room, q, wanted)
        assert np.array_equal(ours <= 0.0, alone <= 0.0)
        np.testing.assert_allclose(ours, np.minimum(alone, wanted), rtol=3e-3, atol=1e-9)
    assert 5 < int(np.sum(alone <= 0.0)) < 195


def test_touches_alone_are_those_of_the_whole_check(boulder: np.ndarray) -> None:
    rng = np.random.default_rng(4)
    corners = CELL.q_home + rng.uniform(-0.8, 0.8, (9, len(CELL)))
    q = np.concatenate([np.linspace(a, b, 40) for a, b in pairwise(corners)])
    whole = check_collisions(CELL, q, stock_mesh=boulder)
    ours = check_collisions(CELL, q, stock_mesh=boulder, touches=True)
    assert 0 < whole.count < len(q) and np.array_equal(whole.hit, ours.hit)
    assert ours.samples < whole.samples and {f.code for f in ours.findings} == {f.code for f in whole.findings}
