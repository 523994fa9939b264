"""Holes and short retracts are the arm's alone: no track travels while a drill is drawn out by three millimetres."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.read_cell import read_cell
from camrob.redundancy.path import TRANSIT, ToolPathInBase
from camrob.redundancy.published.virtual_joint import PathFollower, resolve_vjm
from camrob.toolpath.region import Move

KR15 = Path(__file__).resolve().parents[3] / "cells" / "kr15_track_table"
TILTED = np.array([np.sin(0.2), 0.0, np.cos(0.2)])


def _path(
    points: list[tuple[float, float, float]], axis: np.ndarray, region: list[int] | None = None
) -> ToolPathInBase:
    """A path through points (mm), 200 mm above the table, with one tool axis."""
    n = len(points)
    frames = np.tile(np.eye(4), (n, 1, 1))
    x = np.cross([0.0, 1.0, 0.0], axis)
    frames[:, :3, 0], frames[:, :3, 2] = x, axis
    frames[:, :3, 1] = np.cross(axis, x)
    frames[:, :3, 3] = np.array(points) / 1e3 + (0.0, 0.0, 0.2)
    move = np.full(n, Move.CUT, np.int8)
    return ToolPathInBase(
        frames,
        move,
        np.full(n, 0.01),
        np.arange(1, n + 1),
        np.array(region or [0] * n, np.int32),
        np.arange(n),
        np.ones(n, np.bool_),
    )


@pytest.mark.parametrize(
    ("points", "region", "held"),
    [
        ([(0, 0, 50), (0, 0, -40), (0, 0, 50), (60, 0, 50)], None, [0, 1, 1, 0]),  # a deep hole
        ([(0, 0, 50), (0, 0, 3), (0, 0, -20), (0, 0, 3), (60, 0, 3)], None, [0, 1, 1, 1, 0]),
        ([(0, 0, 50), (0, 0, -40), (60, 0, -40), (60, 0, 50)], None, [0, 0, 0, 0]),  # a pocket's plunge and its way out
        ([(0, 0, 50), (60, 0, 0), (60, 0, 3), (90, 0, 3)], None, [0, 0, 1, 0]),  # a retract of 3 mm
        ([(0, 0, 3), (0, 0, 0), (0, 0, 3)], [0, TRANSIT, 0], [0, 0, 0]),
        ([(0, 0, 3), (0, 0, 0), (0, 0, 3), (0, 0, 0)], [0, 0, 1, 1], [0, 1, 0, 1]),
        ([(0, 0, 3)], None, [0]),
    ],
)
def test_which_ways_are_the_arms_alone(
    points: list[tuple[float, float, float]], region: list[int] | None, held: list[int]
) -> None:
    assert _path(points, np.array([0.0, 0.0, 1.0]), region).along_axis.astype(int).tolist() == held


def _holes(axis: np.ndarray) -> ToolPathInBase:
    at = [(x, y) for x in (-80, 0, 90) for y in (-60, 70)]
    return _path([tuple(np.array([x, y, 0.0]) + d * axis) for x, y in at for d in (60, 3, -20, 3, -40, 60)], axis)


@pytest.fixture(scope="module")
def kr15() -> Cell:
    return read_cell(KR15)


@pytest.mark.parametrize("axis", [np.array([0.0, 0.0, 1.0]), TILTED])
def test_external_axes_stand_in_holes_and_go_between_them(kr15: Cell, axis: np.ndarray) -> None:
    path = _holes(axis)
    solution = resolve_vjm(kr15, path)
    external = [*kr15.indices(Role.WORKPIECE), *kr15.indices(Role.CARRIAGE)]
    travel = np.abs(np.diff(solution.q[:, external], axis=0)).max(axis=1)
    held = path.along_axis[1:]
    assert held.sum() == 5 * 6 and (travel[held] == 0.0).all() and (travel[~held] > 1e-4).all()
    assert "external-axis-in-hole" not in {f.code for f in solution.findings}


def test_where_the_arm_alone_cannot_do_it_the_external_axes_help_and_it_is_said(
    kr15: Cell, monkeypatch: pytest.MonkeyPatch
) -> None:
    weigh = PathFollower.weigh

    def helpless(follower: PathFollower, weighting: object) -> None:
        weigh(follower, weighting)  # type: ignore[arg-type]
        follower._arm_alone = follower._arm_alone._replace(locked=np.ones(len(kr15), np.bool_))

    monkeypatch.setattr(PathFollower, "weigh", helpless)
    path = _holes(TILTED)
    solution = resolve_vjm(kr15, path)
    (said,) = [f for f in solution.findings if f.code == "external-axis-in-hole"]
    assert said.line == 2
