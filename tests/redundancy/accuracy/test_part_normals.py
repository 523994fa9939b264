"""Only what lies along the surface's normal counts: held to an arm of springs in plain numpy that shares nothing with camrob."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from test_part_error import COMPLIANCE, Push, errors_of
from test_planned import CELL, raster

from camrob.redundancy.accuracy.part_error import SHARE
from camrob.redundancy.accuracy.posture_errors import LeftSurface
from camrob.redundancy.planned import resolve_planned
from camrob.redundancy.planning.for_accuracy import expected_error, pushed
from camrob.redundancy.planning.waypoints import waypoints

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from gap import generator

FORCE = np.array([-60.0, 30.0, 20.0])


class Looks:
    """A surface that looks one way all along, and is left by some of the moves alone."""

    def __init__(self, normal, moves=slice(None)):
        self.normal, self.moves = np.asarray(normal, float), moves

    def left(self, base_T_tip, cutting):
        move = np.repeat(np.flatnonzero(cutting)[self.moves], 4)
        at = np.tile([0.125, 0.375, 0.625, 0.875], len(move) // 4)
        return LeftSurface(
            move, at, np.tile(self.normal, (len(move), 1)), np.full(len(move), 1e-6), np.zeros(len(cutting))
        )


def bent(solution, path):
    """(N, 3) m in `base` by which springs of COMPLIANCE let the tip go under FORCE, laid along the feed, as numpy finds it."""
    axis = CELL.to_axis_values(np.asarray(solution.q))[:, [CELL.axis_names.index(a) for a in generator.AXES]]
    axis = axis / np.array([1 / generator.DEG] * 6 + [1e3, 1 / generator.DEG])
    tips, z = np.asarray(path.base_T_tip)[:, :3, 3], np.asarray(path.base_T_tip)[:, :3, 2]
    x = np.gradient(tips, axis=0)
    x -= np.sum(x * z, axis=1, keepdims=True) * z
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    force = FORCE[0] * x + FORCE[1] * np.cross(z, x) + FORCE[2] * z
    c, s = np.cos(axis[:, 7]), np.sin(axis[:, 7])
    world_R_base = np.zeros((len(c), 3, 3))
    world_R_base[:, 0, 0] = world_R_base[:, 1, 1] = c
    world_R_base[:, 1, 0], world_R_base[:, 0, 1], world_R_base[:, 2, 2] = -s, s, 1.0
    world = np.einsum("nij,nj->ni", world_R_base, force)
    turned = np.zeros((len(axis), 6))
    for _ in range(20):
        there = axis.copy()
        there[:, :6] += turned
        turned = COMPLIANCE * np.einsum("nij,ni->nj", generator.jacobian(there)[:, :3], world)
    there = axis.copy()
    there[:, :6] += turned
    moved = generator.pose(there)[:, :3, 3] - generator.pose(axis)[:, :3, 3]
    return np.einsum("nji,nj->ni", world_R_base, moved)


def rms(values):
    return float(np.sqrt(np.mean(np.asarray(values) ** 2)))


def test_an_expected_error_along_a_normal_is_what_springs_do_along_it():
    path = raster(3, 5, width=0.1)
    plain = resolve_planned(CELL, path, mode="still")
    moved = bent(plain, path)
    middle = np.asarray(path.cutting) & (np.arange(len(path)) % 5 > 0) & (np.arange(len(path)) % 5 < 4)
    for n in ([0.0, 0.0, 1.0], [0.0, 0.6, 0.8]):
        errors = errors_of(compliance=COMPLIANCE, force=Push(*FORCE), normals=Looks(n))
        got = np.asarray(expected_error(CELL, errors, path, plain).error)
        np.testing.assert_allclose(got[middle], np.abs(moved @ n)[middle], rtol=0.02)


@pytest.mark.parametrize("normal", [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
def test_a_plan_for_the_normal_leaves_less_along_it_than_one_for_all_that_lies_across(normal):
    """A floor, and a wall that the lines run along."""
    path = raster(4, 6, width=0.12)
    across = resolve_planned(CELL, path, mode="still", errors=errors_of(compliance=COMPLIANCE, force=Push(*FORCE)))
    errors = errors_of(compliance=COMPLIANCE, force=Push(*FORCE), normals=Looks(normal))
    ours = resolve_planned(CELL, path, mode="still", errors=errors)
    plain = resolve_planned(CELL, path, mode="still")
    left = [rms((bent(s, path) @ normal)[np.asarray(path.cutting)]) for s in (ours, across, plain)]
    assert ours.plan.accuracy.taken
    assert left[0] < 0.95 * left[1] and left[0] < 0.8 * left[2], left


def test_what_is_cut_away_again_costs_nothing():
    path = raster(4, 6, width=0.12)
    errors = errors_of(compliance=COMPLIANCE, force=Push(*FORCE), normals=Looks([0.0, 0.0, 1.0], slice(12, None)))
    w = pushed(waypoints(path, 0.02), path, errors)
    share, cut = np.asarray(w.push)[:, SHARE], np.asarray(w.cut)
    first = np.asarray(w.point) < 11
    assert not share[first].any() and share[~first].max() > 1.0
    assert share @ cut == pytest.approx(cut.sum(), rel=0.05)
    # fewer waypoints stand for the same surface
    coarse = w.take(np.arange(0, len(w), 3))
    assert np.asarray(coarse.push)[:, SHARE] @ np.asarray(coarse.cut) == pytest.approx(cut.sum(), rel=0.05)
