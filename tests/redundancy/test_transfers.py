"""Moves through air: above everything, around the part where the tool's side changes, and not a point lost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from follower_twins import CELL

from camrob.errors import ToolpathError
from camrob.kinematics.frames import base_T_tool
from camrob.redundancy.path import TRANSIT
from camrob.redundancy.transfers import build_path
from camrob.se3 import angle_between, frame_from_xyzabc
from camrob.toolpath.region import Move, Region
from camrob.toolpath.toolpath import Toolpath

CLEARANCE = 0.05
UP, FRONT = np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])
PLACE = frame_from_xyzabc(np.array([0.1, -0.05, 0.2, 0.3, 0.0, 0.0]))


def region(name: str, axis: np.ndarray, offset: float, *, in_air: bool = False, operation: str = "") -> Region:
    tips = np.linspace([0, 0, 0], [0.1, 0, 0], 6) + offset * axis
    move = np.full(6, int(Move.CUT), np.int8)
    feed = np.full(6, 0.02)
    if in_air:
        move[[0, -1]], feed[[0, -1]] = Move.RAPID, np.nan
        tips[[0, -1]] += 0.03 * axis
    lines = np.arange(10, 16) + int(1000 * offset)
    return Region(name, tips, np.tile(axis, (6, 1)), feed, move, lines, operation=operation)


def built(*regions: Region, **options):
    return build_path(CELL, Toolpath(regions, "t.cls", "0", "nx-clsf"), PLACE, clearance=CLEARANCE, **options)


def test_the_toolpath_is_in_it_unchanged() -> None:
    a, b = region("a", UP, 0.0), region("b", FRONT, 0.01)
    path = built(a, b)
    own = path.of_toolpath
    R, p = PLACE[:3, :3], PLACE[:3, 3]
    np.testing.assert_allclose(
        path.base_T_tip[own, :3, 3], np.concatenate([a.position, b.position]) @ R.T + p, atol=1e-12
    )
    np.testing.assert_allclose(path.base_T_tip[own, :3, 2], np.concatenate([a.axis, b.axis]) @ R.T, atol=1e-12)
    np.testing.assert_array_equal(path.line[own], np.concatenate([a.line, b.line]))
    assert path.region[own].tolist() == [0] * 6 + [1] * 6 and path.source[own].tolist() == [*range(6), *range(6)]
    linked = ~own
    assert np.all(path.region[linked] == TRANSIT) and np.all(path.move[linked] == Move.LINK)
    assert np.all(path.safe[linked]) and np.all(np.isnan(path.feed[linked])) and not path.line[linked].any()
    assert linked[0] and linked[-1]  # from and to HOME through air


def test_links_stay_above_everything() -> None:
    a, b = region("a", UP, 0.0), region("b", UP, 0.08)
    top = np.array([[0.0, 0.0, 0.9]])
    for bounds in (None, top):
        path = built(a, b, bounds=bounds)
        tips = path.base_T_tip[:, :3, 3]
        highest = max(tips[path.of_toolpath, 2].max(), -1 if bounds is None else 0.9)
        assert tips[~path.of_toolpath, 2].min() >= highest + CLEARANCE - 1e-12
        between = np.flatnonzero(
            (path.region == TRANSIT) & (np.arange(len(path)) > 3) & (np.arange(len(path)) < len(path) - 3)
        )
        assert len(between) == 2
        np.testing.assert_allclose(tips[between[0], :2], tips[between[0] - 1, :2], atol=1e-12)  # straight up
        np.testing.assert_allclose(tips[between[1], :2], tips[between[1] + 1, :2], atol=1e-12)  # straight down


def test_regions_of_one_operation_in_the_air_need_no_link() -> None:
    a, b = (region(n, UP, 0.0, in_air=True, operation="OP") for n in "ab")
    assert (built(a, b).region == TRANSIT).sum() == 2  # from HOME and to HOME
    other = region("b", UP, 0.0, in_air=True, operation="OTHER")
    assert (built(a, other).region == TRANSIT).sum() == 4


def test_a_region_whose_way_the_file_does_not_state_is_come_to_from_above() -> None:
    """Both ends count as in the air, in one operation: only the region itself says that the file leaves the way open."""
    a, b = (region(n, UP, 0.0, in_air=True, operation="OP") for n in "ab")
    path = built(a, replace(b, detached=True))
    between = np.flatnonzero(
        (path.region == TRANSIT) & (np.arange(len(path)) > 3) & (np.arange(len(path)) < len(path) - 3)
    )
    tips = path.base_T_tip[:, :3, 3]
    assert len(between) == 2 and tips[between, 2].min() >= tips[path.of_toolpath, 2].max() + CLEARANCE - 1e-12


def test_a_change_of_tools_parts_the_path_above_the_part() -> None:
    a, b = (region(n, UP, 0.0, in_air=True, operation="OP") for n in "ab")
    there = frame_from_xyzabc(np.array([0.5, 0.5, 0.9, 1.0, 0.0, 0.0]))
    path = built(a, b, changes={1: there})
    assert [s.stop - s.start for s in path.stretches] == [8, 8]
    tips = path.base_T_tip[:, :3, 3]
    for edge in (0, 7, 8, 15):  # each stretch begins and ends above everything
        assert path.region[edge] == TRANSIT and tips[edge, 2] >= tips[path.of_toolpath, 2].max() + CLEARANCE - 1e-12
    first = path.base_T_tip[8]  # x begins at the roll that the tool has at the pose for changes
    assert float(angle_between(there[:3, :3], first[:3, :3])) == pytest.approx(0.0, abs=1e-9)


def test_points_that_repeat_the_one_before_are_one() -> None:
    a = region("a", UP, 0.0, in_air=True, operation="OP")
    twice = np.repeat(np.arange(6), 2)
    doubled = Region("a", a.position[twice], a.axis[twice], a.feed[twice], a.move[twice], a.line[twice], operation="OP")
    once, path = built(a), built(doubled)
    for column in ("base_T_tip", "move", "feed", "line", "region", "safe"):
        np.testing.assert_array_equal(getattr(path, column), getattr(once, column))
    assert path.source[path.of_toolpath].tolist() == [0, 2, 4, 6, 8, 10]
    other = replace(a, position=a.position[::-1])  # begins where the other ends
    assert (built(a, other).region >= 0).sum() == 11


@pytest.mark.parametrize("second", [FRONT, -UP, np.array([0.6, 0.0, 0.8])], ids=["side", "below", "leaning"])
def test_around_the_part(second: np.ndarray) -> None:
    """A sphere about all points, plus clearance: the tip never comes nearer, and the axis turns bit by bit."""
    a, b = region("a", UP, 0.0), region("b", second, 0.0)
    path = built(a, b)
    own = path.of_toolpath
    tips, axes = path.base_T_tip[:, :3, 3], path.base_T_tip[:, :3, 2]
    center = 0.5 * (tips[own].min(axis=0) + tips[own].max(axis=0))
    radius = np.linalg.norm(tips[own] - center, axis=1).max() + CLEARANCE
    link = np.flatnonzero(~own)[1:-1]
    np.testing.assert_allclose(np.linalg.norm(tips[link] - center, axis=1), radius, atol=1e-9)
    angle = np.arctan2(
        np.linalg.norm(np.cross(axes[link[:-1]], axes[link[1:]]), axis=1),
        np.sum(axes[link[:-1]] * axes[link[1:]], axis=1),
    )
    assert angle.max() <= 0.1 + 1e-9
    chord = np.linalg.norm(np.diff(tips[link], axis=0), axis=1)
    assert chord.max() <= 0.1 * radius + 1e-9
    for k, end in ((link[0], link[0] - 1), (link[-1], link[-1] + 1)):  # out and in along the tool's axis
        np.testing.assert_allclose(np.cross(tips[k] - tips[end], axes[end]), 0.0, atol=1e-12)
        np.testing.assert_allclose(axes[k], axes[end], atol=1e-12)


def test_safe_points_are_those_in_air() -> None:
    a = region("a", UP, 0.0, in_air=True)
    path = built(a)
    inside = path.safe[path.region == 0]
    assert inside.tolist() == [False, False, False, False, False, True]  # the first is left at feed, into the part


def test_a_posture_may_change_by_axis_values_only_high_above() -> None:
    """Rapids 30 mm above one pocket are no place to swing the tool where another one's rapids, or the stock, lie higher."""
    low, high = region("a", UP, 0.0, in_air=True), region("b", UP, 0.08, in_air=True)
    path = built(low, high)
    rapid = path.of_toolpath & path.safe
    assert path.clear[rapid].tolist() == (path.region[rapid] == 1).tolist()
    assert path.clear[path.safe & ~path.of_toolpath].all() and not path.clear[~path.safe].any()
    assert built(low).clear[built(low).safe].all()
    stock = PLACE[:3, 3] + np.array([[0.05, 0.0, 0.035]])
    above = built(low, bounds=stock)
    assert not above.clear[above.of_toolpath].any() and above.clear[above.safe & ~above.of_toolpath].all()


def test_the_roll_starts_at_homes_and_is_carried_on() -> None:
    path = built(region("a", UP, 0.0), region("b", FRONT, 0.0))
    home = base_T_tool(CELL, CELL.q_home)
    first = path.base_T_tip[0]
    tilt = np.arccos(home[:3, 2] @ first[:3, 2])
    assert float(angle_between(home[:3, :3], first[:3, :3])) == pytest.approx(tilt, abs=1e-9)
    turned = angle_between(path.base_T_tip[:-1, :3, :3], path.base_T_tip[1:, :3, :3])
    z = path.base_T_tip[:, :3, 2]
    np.testing.assert_allclose(np.cos(turned), np.sum(z[:-1] * z[1:], axis=1), atol=1e-9)


def test_nothing_to_do_is_an_error() -> None:
    empty = Region("none", np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty(0, np.int8), np.empty(0, np.int64))
    with pytest.raises(ToolpathError, match="no motion"):
        built(empty)
    assert (built(empty, region("a", UP, 0.0)).region >= 0).sum() == 6
