"""Planned postures: still axes get from one region's stop to the next one's at the safe point between them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from camrob.cell.read_cell import read_cell
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.certificate import certify, survey_poses
from camrob.redundancy.planning.course import coarse_index
from camrob.redundancy.planning.curve import landscape
from camrob.redundancy.planning.freedoms import plan_space
from camrob.redundancy.planning.objective import Objective, plan_weights
from camrob.redundancy.planning.waypoints import waypoints
from camrob.se3 import pose
from camrob.toolpath.region import Move

CELL = read_cell(Path(__file__).resolve().parents[3] / "cells" / "kr15_track_table")


def two_regions() -> ToolPathInBase:
    """Tool down, then level from one side; between them the tool is lifted."""
    down = np.eye(3)
    level = np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    first = [[0.02 * k, 0.15, 0.25] for k in range(6)] + [[0.10, 0.15, 0.35]]
    second = [[-0.30, 0.0, 0.30]] + [[-0.15, 0.02 * k, 0.25] for k in range(6)]
    tips = np.array(first + second)
    n = len(tips)
    frames = pose(np.array([down] * 7 + [level] * 7), tips)
    safe = np.isin(np.arange(n), [6, 7])
    move = np.where(safe, int(Move.RAPID), int(Move.CUT)).astype(np.int8)
    region = np.repeat(np.array([0, 1], np.int32), 7)
    return ToolPathInBase(frames, move, np.where(safe, np.nan, 0.02), np.arange(n) + 10, region, np.arange(n), safe)


def stops(nodes, k):
    """The external postures among the candidates of waypoint k."""
    part = slice(nodes.offset[k], nodes.offset[k + 1])
    return {tuple(u) for u in np.round(nodes.u[part, :2], 9)}


def test_the_safe_point_between_regions_has_the_stops_of_both():
    space = plan_space(CELL)
    w = waypoints(two_regions(), 0.02)
    survey = survey_poses(space, w.base_T_tip)
    certificate = certify(space, w.base_T_tip, survey)
    coarse = coarse_index(w, 0.1)
    objective = Objective.of(CELL, space, plan_weights(CELL))

    def still(at):
        return landscape(CELL, space, objective, at, survey, certificate, coarse, still=True, flow=False).still_nodes

    at = w.take(coarse)
    leave = int(np.flatnonzero(at.safe & (np.asarray(at.region) == 0))[-1])
    last = len(coarse) - 1
    nodes = still(w)
    first, second = stops(nodes, 0) - stops(nodes, last), stops(nodes, last) - stops(nodes, 0)
    assert first and second, "the regions have the same stops: the case shows nothing"
    assert stops(nodes, leave) & first
    assert stops(nodes, leave) & second
    unsafe = still(replace(w, safe=np.zeros(len(w), bool)))
    assert not stops(unsafe, leave) & second
