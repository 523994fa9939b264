"""Which surface a path leaves, and where it looks: slots and planes of which geometry says it."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "redundancy" / "planning"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "redundancy" / "accuracy"))

from test_part_error import errors_of
from test_planned import raster

from camrob.cell.setup import Body, Setup
from camrob.cutting.cutter import Cutter
from camrob.jobs.solving.surface_of_path import SurfaceOfPath
from camrob.prediction.read_force import read_forces
from camrob.redundancy.planning.for_accuracy import pushed
from camrob.redundancy.planning.waypoints import waypoints

NOWHERE = np.eye(4)
NOWHERE[:3, 3] = 0.3, -0.2, 0.1


def along(tips, axis=(0.0, 0.0, 1.0)):
    """Frames (N, 4, 4) in `base` of a cutter at tips (N, 3) in `part`."""
    z = np.asarray(axis, float) / np.linalg.norm(axis)
    x = np.cross([0.0, 1.0, 0.0], z)
    x /= np.linalg.norm(x)
    frames = np.tile(np.eye(4), (len(tips), 1, 1))
    frames[:, :3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    frames[:, :3, 3] = tips
    return NOWHERE @ frames


def surface(cutter, stock=None, part=None):
    return SurfaceOfPath(cutter, NOWHERE, Setup(None, NOWHERE, (), part=part, stock=stock), "the stock")


def box(*corners):
    return Body(None, lower=np.array(corners[:3]), upper=np.array(corners[3:]))


def test_a_slot_has_a_floor_and_two_walls():
    tips = np.array([[-0.06, 0.0, -0.004], [0.0, 0.0, -0.004], [0.06, 0.0, -0.004]])
    given = surface(Cutter(0.005, 0.0, 0.03), box(-0.04, -0.02, -0.02, 0.04, 0.02, 0.0))
    left = given.left(along(tips), np.array([False, True, True]))
    n = left.normal
    floor, walls = np.abs(n[:, 2]) > 0.99, np.abs(n[:, 1]) > 0.99
    assert np.all(floor | walls)
    assert left.area[floor].sum() == pytest.approx(0.08 * 0.010, rel=0.1)
    assert left.area[walls].sum() == pytest.approx(2 * 0.08 * 0.004, rel=0.15)
    assert np.all(n[floor, 2] > 0.99)  # out of the material
    # half of it on either move, within the radius that a flat floor is under the cutter
    assert set(left.move.tolist()) == {1, 2}
    assert left.area[left.move == 1].sum() == pytest.approx(left.area.sum() / 2, rel=0.1)


def test_what_is_cut_away_later_is_not_left_and_air_cuts_nothing():
    first = np.array([[-0.06, 0.0, -0.002], [0.06, 0.0, -0.002]])
    tips = np.concatenate([first, first[::-1] - [0.0, 0.0, 0.002], [[0.06, 0.0, -0.006]]])
    given = surface(Cutter(0.005, 0.0, 0.03), box(-0.04, -0.02, -0.02, 0.04, 0.02, 0.0))
    left = given.left(along(tips), np.array([False, True, True, True, False]))
    floor = left.normal[:, 2] > 0.99
    assert set(left.move[floor].tolist()) == {3}
    assert left.area[floor].sum() == pytest.approx(0.08 * 0.010, rel=0.1)
    assert given.left(along(tips), np.zeros(5, bool)) is None


def test_a_tilted_plane_rastered_by_a_ball_looks_where_the_plane_looks():
    tilt = np.radians(35.0)
    normal = np.array([0.0, -np.sin(tilt), np.cos(tilt)])
    up = np.array([0.0, np.cos(tilt), np.sin(tilt)])
    rows = np.arange(-10, 11) * 0.001
    centres = [
        (s * x * np.array([1.0, 0, 0]) + y * up)
        for s, y in zip([1, -1] * 11, rows, strict=False)
        for x in (-0.03, 0.03)
    ]
    tips = np.array(centres) + 0.004 * normal - 0.004 * np.array([0.0, 0.0, 1.0])
    part = box(-0.02, -0.006, -0.02, 0.02, 0.006, 0.012)
    for stock, other in ((part, None), (None, part)):
        left = surface(Cutter(0.004, 0.004, 0.03), stock, other).left(along(tips), np.arange(len(tips)) > 0)
        looks = left.normal @ normal
        assert np.average(looks**2, weights=left.area) > 0.98
        # the plane within the block, from wall to wall
        assert left.area.sum() == pytest.approx(0.04 * 0.012 / np.cos(tilt), rel=0.08)
    alone = surface(Cutter(0.004, 0.004, 0.03)).left(along(tips), np.arange(len(tips)) > 0)
    inner = (alone.move > 12) & (alone.move < 30)  # ends of a raster in a block about it are walls
    assert np.average((alone.normal[inner] @ normal) ** 2, weights=alone.area[inner]) > 0.9


def test_how_much_is_cut_on_the_way_to_a_point():
    """Slots 4 mm deep and 10 mm wide: along the stock the way has that area, in the air behind it none."""
    tips = np.array([[-0.03, 0.0, -0.004], [0.0, 0.0, -0.004], [0.03, 0.0, -0.004], [0.06, 0.0, -0.004]])
    given = surface(Cutter(0.005, 0.0, 0.03), box(-0.04, -0.02, -0.02, 0.04, 0.02, 0.0))
    left = given.left(along(tips), np.array([False, True, True, False]))
    np.testing.assert_allclose(left.taken, [0.0, 4e-5, 4e-5, 0.0], rtol=0.2)


def test_a_plan_takes_the_engagement_from_the_removal(tmp_path):
    """Slots of which everybody knows how deep they are: the same force as where the file says that."""
    path, text = raster(4, 12, width=0.12), '[milling]\nteeth = 2\ndiameter_mm = 8\nspindle_rpm = 9000\nside = "left"\n'
    text += "tangential_n_mm2 = 700\nradial_n_mm2 = 300\naxial_n_mm2 = 100\naxial_edge_n_mm = 3\n"
    (tmp_path / "asks.toml").write_text(text)
    (tmp_path / "says.toml").write_text(text + "depth_mm = 2\nwidth_mm = 8\n")
    block = Setup(None, np.eye(4), (), part=None, stock=box(-0.08, -0.02, 0.24, 0.08, 0.05, 0.252))
    known = SurfaceOfPath(Cutter(0.004, 0.0, 0.03), np.eye(4), block, "the stock")
    w = waypoints(path, 0.02)
    push = [
        np.asarray(pushed(w, path, errors_of(force=read_forces(tmp_path / f).on([None], f)[0], normals=known)).push)[
            :, :3
        ]
        for f in ("asks.toml", "says.toml")
    ]
    middle = np.abs(np.asarray(w.base_T_tip)[:, 0, 3]) < 0.04
    assert np.abs(push[1][middle]).max() > 20.0
    np.testing.assert_allclose(push[0][middle], push[1][middle], rtol=0.12, atol=1.0)
    asks = replace(known, setup=Setup(None, np.eye(4), (), part=None, stock=None))
    assert known.of_stock and not asks.of_stock
