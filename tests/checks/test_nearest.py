"""The nearest two bodies: against distances of balls worked out by hand, and against what the check itself finds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from camrob.cell.read_cell import read_cell
from camrob.cell.shape import Shape, ShapeKind
from camrob.checks.collisions import check_collisions
from camrob.checks.nearest import nearest_bodies
from camrob.checks.rooms import pair_rooms
from camrob.kinematics.frames import base_T_flange

CELL = read_cell(Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table")


def ball(name: str, frame: str, radius: float, at=(0.0, 0.0, 0.0)) -> Shape:
    frame_T_ball = np.eye(4)
    frame_T_ball[:3, 3] = at
    return Shape(name, name, frame, ShapeKind.SPHERE, np.array([radius]), frame_T_ball)


def wandering(count: int) -> np.ndarray:
    return CELL.q_home + np.random.default_rng(7).uniform(-0.3, 0.3, (count, len(CELL)))


def test_of_three_balls_the_nearest_two_are_named_with_the_room_between_them() -> None:
    """On the flange, and two that stand on the table: centres apart, less both radii. The two that stand never move."""
    left, right = np.array([0.4, 0.5, 0.3]), np.array([0.4, -0.5, 0.3])
    shapes = (ball("held", "flange", 0.05), ball("left", "base", 0.1, left), ball("right", "base", 0.02, right))
    cell, q = replace(CELL, shapes=shapes), wandering(40)
    found = nearest_bodies(cell, q)
    assert found is not None
    held = base_T_flange(cell, q)[:, :3, 3]
    room = np.stack([np.linalg.norm(held - left, axis=1) - 0.15, np.linalg.norm(held - right, axis=1) - 0.07])
    assert np.allclose(found.distance, room.min(axis=0), rtol=2e-3)
    names = [set(found.pairs[k]) for k in found.pair]
    assert names == [{"held", ("left", "right")[k]} for k in np.argmin(room, axis=0)]
    assert len({frozenset(n) for n in names}) == 2, "both are nearest somewhere"


def test_pairs_whose_balls_lie_too_far_off_are_left_out_and_change_nothing() -> None:
    """Beside every pair in every posture, one by one."""
    part = np.asarray(trimesh.creation.box((0.2, 0.1, 0.1)).triangles)
    q = np.concatenate([wandering(60), CELL.q_home + 0.1 * wandering(60)])
    found = nearest_bodies(CELL, q, part_mesh=part, base_T_part=np.eye(4))
    assert found is not None
    rooms = pair_rooms(CELL, q, part_mesh=part, base_T_part=np.eye(4))
    distance = rooms.distance[[rooms.names.index(pair) for pair in found.pairs]]
    assert np.array_equal(found.pair, np.argmin(distance, axis=0))
    assert np.array_equal(found.distance, distance.min(axis=0))


def test_limbs_next_to_each_other_and_the_tool_at_what_it_cuts_do_not_count() -> None:
    part = np.asarray(trimesh.creation.box((0.02, 0.02, 0.02)).triangles)
    tip = np.eye(4)
    found = nearest_bodies(CELL, wandering(5), part_mesh=part, base_T_part=tip)
    assert found is not None
    pairs = {frozenset(p) for p in found.pairs}
    assert frozenset({"A4 tube", "spindle bracket"}) not in pairs
    assert frozenset({"tool", "part"}) not in pairs
    assert any("part" in p for p in pairs)
    assert nearest_bodies(replace(CELL, shapes=()), wandering(3)) is None


@pytest.mark.slow
def test_where_the_check_finds_a_touch_there_is_no_room() -> None:
    held = ball("held", "flange", 0.05)
    q = wandering(12)
    post = ball("post", "base", 0.06, base_T_flange(CELL, q[4:5])[0, :3, 3])
    cell = replace(CELL, shapes=(held, post))
    found = nearest_bodies(cell, q)
    count = len(q)
    report = check_collisions(
        cell, q, cutting=np.zeros(count, bool), line=np.arange(count) + 1, region=np.zeros(count, int)
    )
    assert found is not None
    assert found.distance[4] == 0.0
    assert report.count
    assert report.hit[4]
