"""Poses of arms with narrow limits: what lies between the nodes of the plan's scan is sought before it is given up."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np
from follower_twins import CELL, narrow

from camrob.cell.cell import Cell
from camrob.errors import JobError
from camrob.frozen import locked
from camrob.kinematics.frames import base_T_tool
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planned import resolve_planned
from camrob.redundancy.planning.certificate import Survey, certify, survey_poses
from camrob.redundancy.planning.freedoms import plan_space
from camrob.redundancy.planning.placement import place_stretches
from camrob.redundancy.planning.sought import sought
from camrob.toolpath.region import Move


def near_a_posture(seed: int, count: int = 5, step: float = 0.002) -> tuple[Cell, np.ndarray]:
    """A narrow cell, and poses (count, 4, 4) a step apart about one that it has a posture for."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(np.maximum(CELL.q_lower, -2.5), np.minimum(CELL.q_upper, 2.5))
    frames = np.repeat(base_T_tool(CELL, q)[None], count, axis=0)
    frames[:, 0, 3] += step * (np.arange(count) - count // 2)
    return narrow(CELL, q, 10.0), frames


def straight(frames: np.ndarray) -> ToolPathInBase:
    """A cut through poses (N, 4, 4), with the way in and out along the tool at the first and the last."""
    placed = frames.copy()
    placed[[0, -1], :3, 3] -= 0.02 * placed[0, :3, 2]
    N = len(placed)
    safe = np.isin(np.arange(N), (0, N - 1))
    return ToolPathInBase(
        placed, np.where(safe, Move.RAPID, Move.CUT), np.where(safe, np.nan, 0.02), np.arange(1, N + 1),
        np.zeros(N, np.int32), np.arange(N), safe,
    )  # fmt: skip


def test_what_lies_between_the_nodes_is_found_and_is_a_posture() -> None:
    scanned = found = 0
    for seed in range(8):
        cell, frames = near_a_posture(seed)
        space, poses = plan_space(cell), locked(frames)
        survey = survey_poses(space, poses)
        before = certify(space, poses, survey)
        after_survey, after = sought(cell, space, poses, survey)
        scanned += before.unreached < 0
        if after.unreached >= 0:
            continue
        found += 1
        assert np.all(after.inv_kf > 0.0)
        well_formed(after_survey, 5)
        if before.unreached < 0:  # nothing was missing: nothing changes
            assert after_survey is survey and np.array_equal(after.inv_kf, before.inv_kf)
        for u, value in zip(after.u, after.inv_kf, strict=True):
            assert np.all(u >= space.u_lower) and np.all(u <= space.u_upper) and value <= 1.0
    assert found >= 7 > 5 > scanned


def well_formed(survey: Survey, count: int) -> None:
    """Each pose has an anchor, each anchor stands for itself, and has a place where it is reached."""
    assert len(survey.nearest) == count and survey.nearest.max() < len(survey.anchors) == len(np.unique(survey.anchors))
    assert np.array_equal(survey.nearest[survey.anchors], np.arange(len(survey.anchors)))


def test_a_pose_out_of_reach_is_still_refused() -> None:
    cell, frames = near_a_posture(1)
    frames[3, 2, 3] += 5.0
    space = plan_space(cell)
    survey, found = sought(cell, space, locked(frames), survey_poses(space, locked(frames)))
    assert found.unreached == 3 and found.inv_kf[3] == 0.0
    assert survey.nearest.max() < len(survey.anchors)


def test_a_scanned_pose_that_a_neighbour_leads_to_is_not_given_up() -> None:
    """Poses 20 mm apart, each scanned for itself: a scan that meets nothing does not undo what was climbed to from beside it."""
    reached = 0
    for seed in range(8):
        cell, frames = near_a_posture(seed, 3, 0.01)
        space = plan_space(cell)
        for poses in (locked(frames), locked(frames[::-1])):
            survey = survey_poses(space, poses, count=1)
            survey = replace(
                survey,
                anchors=np.arange(3),
                nearest=np.arange(3),
                best=np.concatenate([survey.best, np.zeros((2, len(survey.grid)), np.float32)]),
                u=np.concatenate([survey.u, np.zeros((2, *survey.u.shape[1:]))]),
                branch=np.concatenate([survey.branch, np.full((2, survey.branch.shape[1]), -1)]),
            )
            before = certify(space, poses, survey)
            if before.unreached >= 0 and before.inv_kf[before.unreached] > 0.0:
                reached += 1
                assert sought(cell, space, poses, survey)[1].unreached == -1
    assert reached >= 2


def test_narrow_paths_are_planned_and_placed() -> None:
    """Cuts of 40 mm through a pose that has a posture, which say nothing of their ends."""
    planned = placed = 0
    for seed in range(8):
        cell, frames = near_a_posture(seed, 41, 0.001)
        path = straight(frames)
        with suppress(JobError):
            solution = resolve_planned(cell, path)
            planned += solution.method == "planned"
            assert np.all(solution.q >= cell.q_lower - 1e-9) and np.all(solution.q <= cell.q_upper + 1e-9)
        with suppress(JobError):
            placed += bool(place_stretches([(cell, path)], np.eye(4), np.zeros((0, 3))).worst[0] > 0.0)
    assert planned >= 6 and placed >= 6
