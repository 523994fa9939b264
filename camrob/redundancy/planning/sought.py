"""The certificate of a path, with poses sought between the nodes of the scan before one of them is given up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.frozen import locked
from camrob.kinematics.arm import Arm
from camrob.redundancy.following.nearest_miss import nearest_miss
from camrob.redundancy.planning.certificate import Certificate, Survey, certify, external_grid, survey_poses
from camrob.redundancy.planning.freedoms import PlanSpace
from camrob.redundancy.planning.scan_batched import Score

__all__ = ["between_nodes", "sought"]

Array = NDArray[np.float64]

_BRANCHES = 8  # of a closed form, each of which may be the one that was met
# that are sought, as many as a survey scans: some 10 ms each, and a path of which more are missing is hopeless
_POSES = 40


def sought(
    cell: Cell, space: PlanSpace, base_T_tip: Array, survey: Survey, score: Score | None = None
) -> tuple[Survey, Certificate]:
    """The certificate of poses (W, 4, 4), and the survey with what was found for it.

    A pose that nothing reaches is looked for as a refusal looks for its nearest miss: by a compass search for the least that
    limits are passed by. Where that ends within them, the pose stands for itself in the survey, and those that are still
    missing climb from it; the first that isn't found ends the search.
    """
    frames = locked(base_T_tip)
    certificate = certify(space, frames, survey, score)
    for _ in range(_POSES):
        k = certificate.unreached
        own = _own(cell, space, frames, certificate) if k >= 0 else None
        if own is None:
            break
        survey = _with(survey, k, own)
        certificate = _further(space, frames, certificate, _alone(own, survey.grid), score)
    return survey, certificate


def _own(cell: Cell, space: PlanSpace, frames: Array, known: Certificate) -> Certificate | None:
    """The certificate of the pose that a scan reaches by nothing: a neighbour's posture may have led to it all the same."""
    k = slice(known.unreached, known.unreached + 1)
    if known.inv_kf[k][0] > 0.0:
        return Certificate(known.inv_kf[k], known.u[k], known.branch[k])
    return between_nodes(cell, space, frames[known.unreached])


def between_nodes(cell: Cell, space: PlanSpace, base_T_tip: Array) -> Certificate | None:
    """The certificate of one pose from where the compass search ends, None where that is within no limits."""
    miss = nearest_miss(cell, Arm.of(cell), base_T_tip, cell.q_home)
    if miss.q is None or not miss.reached:
        return None
    one, grid = np.zeros(1, np.int64), external_grid(space)
    u = np.tile(miss.q[space.free], (1, _BRANCHES, 1))
    branches = np.arange(_BRANCHES, dtype=np.int64)[None]
    start = Survey(one, one, grid, np.ones((1, len(grid)), np.float32), u, branches)
    found = certify(space, locked(base_T_tip[None]), start)
    return found if found.unreached < 0 else None


def _further(space: PlanSpace, frames: Array, known: Certificate, own: Survey, score: Score | None) -> Certificate:
    """The certificate with what climbs to the poses that it lacks, from the one that was found for `known.unreached`."""
    rest = np.flatnonzero(known.inv_kf <= 0.0)
    if not len(rest):
        return replace(known, unreached=-1)
    some, at = locked(frames[rest]), np.flatnonzero(rest == known.unreached)
    survey = replace(own, anchors=at, nearest=np.zeros(len(rest), np.int64)) if len(at) else None
    found = certify(space, some, survey or survey_poses(space, some, score, count=1), score)
    value, u, branch = np.array(known.inv_kf), np.array(known.u), np.array(known.branch)
    value[rest], u[rest], branch[rest] = found.inv_kf, found.u, found.branch
    return Certificate(value, u, branch, int(rest[found.unreached]) if found.unreached >= 0 else -1)


def _alone(own: Certificate, grid: Array) -> Survey:
    """The survey of one pose, by its certificate."""
    best = np.zeros((1, len(grid)), np.float32)
    best[0, np.argmin(np.abs(grid - own.u[0, : grid.shape[1]]).sum(axis=1))] = own.inv_kf[0]
    one = np.zeros(1, np.int64)
    return Survey(one, one, grid, best, np.array(own.u)[None], np.array(own.branch)[None])


def _with(survey: Survey, k: int, own: Certificate) -> Survey:
    """The survey in which pose k stands for itself, by its own certificate."""
    alone = _alone(own, survey.grid)
    u, branch = np.zeros((1, *survey.u.shape[1:])), np.full((1, survey.u.shape[1]), -1, np.int64)
    u[0, 0], branch[0, 0] = own.u[0], own.branch[0]
    rest = survey.anchors != k
    at = np.cumsum(rest) - 1  # where each anchor stands without k
    nearest = at[survey.nearest]
    nearest[np.append(~rest, False)[survey.nearest] | (np.arange(len(nearest)) == k)] = int(rest.sum())
    return replace(
        survey,
        anchors=np.append(survey.anchors[rest], k),
        nearest=nearest,
        best=np.concatenate([survey.best[rest], alone.best]),
        u=np.concatenate([survey.u[rest], u]),
        branch=np.concatenate([survey.branch[rest], branch]),
    )
