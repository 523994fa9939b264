"""Plans on a tilting and turning table, whose limits leave little room: no pose is given up that a search reaches."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from follower_twins import CELL

from camrob.cell.cell import Cell
from camrob.cell.joint import Joint, Role, dh_after, dh_before
from camrob.frozen import locked
from camrob.product_grid import product_grid
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planned import resolve_planned
from camrob.redundancy.planning.certificate import _climb_all, certify, external_grid, scan, survey_poses
from camrob.redundancy.planning.freedoms import plan_space
from camrob.redundancy.planning.placement import SPACING, place_stretches
from camrob.redundancy.planning.waypoints import waypoints
from camrob.toolpath.region import Move
from camrob.units import deg_to_rad


def positioner_cell() -> Cell:
    """The KR15 fixed 1.25 m beside a table that turns (E2) on a frame that tilts (E1) about a level axis 0.3 m below its top."""
    turning = Joint(
        "E2", Role.WORKPIECE, False, dh_before(theta=0.0, d=-0.3), dh_after(a=0.0, alpha=np.pi / 2),
        speed=1.0, acceleration=2.0, jerk=20.0,
    )  # fmt: skip
    tilt = deg_to_rad(95.0)
    tilting = Joint(
        "E1", Role.WORKPIECE, False, np.eye(4), dh_after(a=1.25, alpha=np.pi / 2),
        lower=-tilt, upper=tilt, speed=1.0, acceleration=2.0, jerk=20.0,
    )  # fmt: skip
    joints = (turning, tilting, *CELL.joints[CELL.index("A1") :])
    return replace(CELL, name="positioner", joints=joints, shapes=(), masses=())


def drawn(count: int, spread: float, seed: int) -> np.ndarray:
    """Poses (count, 4, 4) of an upright tool over the table."""
    frames = np.tile(np.eye(4), (count, 1, 1))
    frames[:, :2, 3] = np.random.default_rng(seed).uniform(-spread, spread, (count, 2))
    frames[:, 2, 3] = 0.22
    return frames


def in_pocket(xy: np.ndarray) -> ToolPathInBase:
    """A cut through places xy (N, 2), m, of an upright tool, with the way in and out."""
    frames = np.tile(np.eye(4), (len(xy) + 2, 1, 1))
    frames[1:-1, :2, 3], frames[:, 2, 3] = xy, 0.2192
    frames[[0, -1], 2, 3] = 0.285
    safe = np.isin(np.arange(len(frames)), (0, len(frames) - 1))
    return ToolPathInBase(
        frames, np.where(safe, Move.RAPID, Move.CUT), np.where(safe, np.nan, 0.02), np.arange(1, len(frames) + 1),
        np.zeros(len(frames), np.int32), np.arange(len(frames)), safe,
    )  # fmt: skip


def test_poses_that_no_neighbour_leads_to_are_scanned_for_themselves() -> None:
    space, frames = plan_space(positioner_cell()), drawn(40, 0.05, 3)
    survey = survey_poses(space, frames)
    alone, u, _branch = _climb_all(space, frames, survey.anchors, survey.nearest, survey.u, survey.branch)
    missed = np.flatnonzero(alone <= 0.0)
    assert 0 < len(missed) < 40
    found = certify(space, frames, survey)
    assert found.unreached == -1
    kept = np.setdiff1d(np.arange(40), missed)
    assert np.array_equal(found.inv_kf[kept], alone[kept]) and np.array_equal(found.u[kept], u[kept])
    grid = external_grid(space)
    for k in missed:
        assert found.inv_kf[k] > 0.9 * scan(space, frames[k], grid, 18).max() > 0.0  # climbed from another pose's basin


def test_a_pose_out_of_reach_stays_one_and_is_named() -> None:
    space, frames = plan_space(positioner_cell()), drawn(40, 0.05, 3)
    frames[23, :3, 3] = [0.0, 0.0, 4.0]
    assert certify(space, frames).unreached == 23
    survey = survey_poses(space, frames[:23])  # of all but that one, as where a survey passes it over
    passed = replace(survey, nearest=np.append(survey.nearest, np.full(17, survey.nearest[-1])))
    found = certify(space, frames, passed)
    assert found.unreached == 23 and found.inv_kf[23] == 0.0


def test_no_placement_that_a_scan_reaches_is_called_out_of_reach() -> None:
    """By the neighbours' basins alone all were, and the part was refused; one 4 m up is."""
    path = in_pocket(drawn(40, 0.2, 5)[:, :2, 3])
    near = 0.05 * product_grid([np.array([-1.0, 0.0, 1.0])] * 3)
    found = place_stretches([(positioner_cell(), path)], np.eye(4), np.concatenate([near, [[0.0, 0.0, 4.0]]]))
    assert np.array_equal(found.worst > 0.0, np.arange(29) < 28)
    space, w = plan_space(positioner_cell()), waypoints(path, SPACING)
    part_T_tip = np.asarray(w.base_T_tip)[np.asarray(w.cut) > 0.0][::4]
    for placed in np.asarray(found.base_T_part)[:28:9]:
        assert all(scan(space, frame, external_grid(space), 18).max() > 0.0 for frame in locked(placed @ part_T_tip))


def test_a_path_on_the_positioner_is_planned() -> None:
    """A square in a pocket: with the neighbours' basins alone, waypoints of it had no posture, and the path was refused."""
    corners = np.array([[0, 0], [0.03, 0], [0.03, 0.03], [0, 0.03], [0, 0]])
    path = in_pocket(np.concatenate([np.linspace(a, b, 20) for a, b in pairwise(corners)]))
    cell = positioner_cell()
    solution = resolve_planned(cell, path)
    assert solution.method == "planned"
    position, axis = solution.residual(cell, path)
    assert position.max() < 1e-6 and axis.max() < 1e-6
    q = np.asarray(solution.q)
    assert np.all(q >= cell.q_lower) and np.all(q <= cell.q_upper)
