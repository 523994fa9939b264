"""The holder in the stock, what a move takes, and a cut held to a part's mesh: all worked out on paper."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import Dexels, Moves
from camrob.cutting.engagement import removed_area
from camrob.cutting.holder import holder_takes
from camrob.cutting.way import Way
from camrob.prediction.against_part import against_part

MM = 1e-3


def block(pitch: float = 0.25) -> Dexels:
    return Dexels(np.zeros(3), np.array([40.0, 20.0, 30.0]) * MM, pitch * MM)


def way_of(moves: Moves) -> Way:
    tip, axis = (np.concatenate([x[:, 0], x[-1:, 1]]) for x in (moves.tip, moves.axis))
    return Way.of(tip, axis, moves.cutters[0], tolerance=1e-9)


def along_x(zs: list[float], cutter: Cutter, *, y: float = 10.0, at: tuple[float, ...] = (-10.0, 50.0)) -> Moves:
    """One pass each way at heights zs, the tool upright."""
    tip = np.array([[x, y, z] for i, z in enumerate(zs) for x in (at if i % 2 == 0 else at[::-1])]) * MM
    return Moves.along(tip, np.tile([0.0, 0.0, 1.0], (len(tip), 1)), cutter)


def test_each_move_says_what_it_takes() -> None:
    """A flat cutter of 6 mm: 5 mm deep takes 40 x 6 x 5, the next pass another 40 x 6 x 3, one in the air nothing."""
    stock, moves = block(), along_x([25.0, 22.0, 22.0], Cutter(3 * MM, 0.0, 50 * MM))
    before = stock.volume()
    taken = stock.carve(moves)
    assert taken[[0, 2]] == pytest.approx(np.array([1200.0, 720.0]) * MM**3, rel=0.01)
    assert taken[[3, 4]] == pytest.approx(np.zeros(2), abs=1e-15)
    assert taken.sum() == pytest.approx(before - np.mean([stock.volume(d) for d in range(3)]), rel=1e-9)


def test_a_stock_carved_in_parts_is_the_same() -> None:
    """Somebody who wants to see how far it is changes nothing: not what is taken, nor which move made a wall."""
    moves = along_x([28.0, 25.0, 21.0, 20.5], Cutter(3 * MM, 1 * MM, 50 * MM), at=tuple(np.linspace(-10.0, 50.0, 30)))
    one, parts, shares = block(0.5), block(0.5), list[float]()
    assert np.array_equal(one.carve(moves), parts.carve(moves, shares.append))
    assert all(np.array_equal(a, b) for a, b in zip(one.count, parts.count, strict=True))
    for d in range(3):
        (edge, owner), (edge_2, owner_2) = one.stretches(d), parts.stretches(d)
        used = np.arange(edge.shape[2]) < 2 * one.count[d][:, :, None]
        assert np.array_equal(edge[used], edge_2[used])
        assert np.array_equal(owner[used], owner_2[used])
    assert shares == sorted(shares) and shares[-1] == 1.0 and len(shares) > 10


def test_the_area_across_a_way_is_that_of_the_groove() -> None:
    area = removed_area(block(), along_x([25.0], Cutter(3 * MM, 0.0, 50 * MM), at=(0.0, 20.0, 40.0)), parts=2)
    assert area == pytest.approx(np.full(2, 30.0) * MM**2, rel=0.03)


def test_the_holder_goes_through_what_stands_beside_a_short_cutter() -> None:
    """A cutter of 6 mm that is 8 long in a groove 10 deep: a holder of 12 mm cuts 2 mm into both sides, (12 - 6) x 2 x 40."""
    moves = along_x([28.0, 24.0, 20.0], Cutter(3 * MM, 0.0, 8 * MM))
    taken = holder_takes(block(), moves, [[(12 * MM, 20 * MM)]])
    assert taken[[0, 1, 2, 3]] == pytest.approx(np.zeros(4), abs=1e-12)
    assert taken[4] == pytest.approx(6 * 2 * 40 * MM**3, rel=0.02)


def test_a_holder_above_its_own_groove_is_clear() -> None:
    """As wide as the groove, it follows the cutter: what it would meet is gone when it comes."""
    moves = along_x([25.0, 20.0], Cutter(3 * MM, 0.0, 8 * MM))
    narrow, wide = (holder_takes(block(), moves, [[(d * MM, 20 * MM)]]).sum() for d in (5.9, 6.2))
    assert narrow == 0.0 < wide


def test_a_later_pass_does_not_hide_what_the_holder_met() -> None:
    """The wide cutter's second tool path clears all that the holder had gone through: it had gone through it all the same."""
    short, wide = Cutter(3 * MM, 0.0, 8 * MM), Cutter(9 * MM, 0.0, 50 * MM)
    first, then = along_x([20.0], short), along_x([15.0], wide)
    both = Moves(
        np.concatenate([first.tip, then.tip]), np.concatenate([first.axis, then.axis]), np.array([0, 1]), (short, wide)
    )
    alone = holder_takes(block(), first, [[(12 * MM, 20 * MM)]])
    assert holder_takes(block(), both, [[(12 * MM, 20 * MM)]])[0] == pytest.approx(alone[0])


@pytest.mark.parametrize("off", [-0.12, 0.07])
def test_a_floor_that_is_off_is_told_as_a_gouge_or_as_rest(off: float) -> None:
    """The part is the block with its upper half milled away to z = 15; the floor is cut `off` beside that."""
    stock, part = block(0.5), trimesh.creation.box(bounds=np.array([[0.0, 0.0, 0.0], [40.0, 20.0, 15.0]]) * MM)
    tip = np.array([[x, y, 15.0 + off] for y in np.arange(-5.0, 26.0, 3.0) for x in (-10.0, 50.0)]) * MM
    moves = Moves.along(tip, np.tile([0.0, 0.0, 1.0], (len(tip), 1)), Cutter(3 * MM, 0.0, 50 * MM))
    stock.carve(moves)
    held = against_part(stock, way_of(moves), np.asarray(part.triangles), farthest=5 * MM)
    assert len(held.point) > 1000 and held.elsewhere == 0
    assert held.deviation == pytest.approx(np.full(len(held.deviation), off * MM), abs=1e-7)
    layer = 40 * 20 * abs(off) * MM**3
    volume = held.left if off > 0 else held.gouged
    assert volume == pytest.approx(layer, rel=0.02) and min(held.left, held.gouged) == pytest.approx(0.0, abs=1e-15)


def test_a_notch_in_an_edge_is_no_deeper_than_the_way_to_the_nearest_wall() -> None:
    """A step of 0.6 mm into the side of a part and 5 mm down from its top: 0.6 mm deep, not 5."""
    stock, part = block(), trimesh.creation.box(bounds=np.array([[0.0, 0.0, 0.0], [40.0, 9.6, 20.0]]) * MM)
    moves = along_x([15.0], Cutter(3 * MM, 0.0, 50 * MM), y=12.0)
    stock.carve(moves)
    held = against_part(stock, way_of(moves), np.asarray(part.triangles), farthest=6 * MM)
    assert held.deviation.min() == pytest.approx(-0.6 * MM, abs=0.03 * MM)


def test_a_part_that_reaches_out_of_its_stock_is_noticed() -> None:
    stock, part = block(1.0), trimesh.creation.box(bounds=np.array([[-3.0, 0.0, 0.0], [40.0, 20.0, 31.0]]) * MM)
    moves = along_x([25.0], Cutter(3 * MM, 0.0, 50 * MM))
    stock.carve(moves)
    assert against_part(stock, way_of(moves), np.asarray(part.triangles), farthest=5 * MM).beyond == pytest.approx(
        3 * MM
    )


def test_a_tilted_wall_is_measured_along_its_normal() -> None:
    """A ball that follows a plane of 30 degrees, 0.1 mm too deep along the normal: between the passes stands what paper says."""
    tilt, R, s = np.deg2rad(30.0), 5 * MM, 0.5 * MM
    n, up_slope = np.array([-np.sin(tilt), 0.0, np.cos(tilt)]), np.array([np.cos(tilt), 0.0, np.sin(tilt)])
    origin = np.array([0.0, 0.0, 4.0]) * MM
    corners = [[0.0, 0.0], [40.0, 0.0], [40.0, 4.0 + 40.0 * np.tan(tilt)], [0.0, 4.0]]
    part = trimesh.convex.convex_hull(np.array([[x, y, z] for x, z in corners for y in (0.0, 20.0)]) * MM)
    stock = block(0.5)
    reach = np.arange(-4.0, 50.0, 0.5) * MM
    centers = origin + reach[:, None] * up_slope + (R - 0.1 * MM) * n
    tip = np.repeat(centers - np.array([0.0, 0.0, R]), 2, axis=0)
    tip[::2, 1], tip[1::2, 1] = -10 * MM, 30 * MM
    moves = Moves.along(tip, np.tile([0.0, 0.0, 1.0], (len(tip), 1)), Cutter(R, R, 60 * MM))
    stock.carve(moves)
    held = against_part(stock, way_of(moves), np.asarray(part.triangles), farthest=5 * MM)
    ridge = R - np.sqrt(R**2 - s**2 / 4)
    inner = (held.point[:, 0] > 5 * MM) & (held.point[:, 0] < 35 * MM)
    # the cut's own normal leans up to s / 2 R from the plane's, by which a ray's length is taken wrongly by 3 %
    assert held.deviation[inner].min() == pytest.approx(-0.1 * MM, abs=4e-6)
    assert held.deviation[inner].max() < -0.1 * MM + ridge + 4e-6


def test_a_way_keeps_the_rows_that_it_needs() -> None:
    """A circle in 2 000 rows, then 500 at rest, then a straight line: every row lies within the tolerance of its move."""
    angle = np.linspace(0.0, 2 * np.pi, 2000)
    circle = np.c_[30 * np.cos(angle), 30 * np.sin(angle), np.zeros(2000)] * MM
    line = np.linspace(circle[-1], circle[-1] + np.array([50.0, 0.0, 20.0]) * MM, 700)
    tip = np.concatenate([circle, np.repeat(circle[-1:], 500, axis=0), line])
    axis = np.tile([0.0, 0.0, 1.0], (len(tip), 1))
    way = Way.of(tip, axis, Cutter(3 * MM, 0.0, 40 * MM), tolerance=1e-6)
    assert way.kept[0] == 0 and way.kept[-1] == len(tip) - 1 and len(way.moves.tip) == len(way.kept) - 1
    # a chord of 2 acos(1 - tolerance / radius) is a micrometre off the circle: 385 of them at the least
    assert 385 <= np.count_nonzero(way.kept < 2000) < 420 and np.count_nonzero(way.kept >= 2500) < 5
    for a, b in zip(way.kept[:-1], way.kept[1:], strict=True):
        gone = way.along[a : b + 1] - way.along[a]
        share = gone / gone[-1] if gone[-1] > 0 else np.zeros(len(gone))
        assert np.abs(tip[a : b + 1] - (tip[a] + share[:, None] * (tip[b] - tip[a]))).max() <= 1e-6
    row, at = way.rows(np.arange(len(way.moves.tip)), np.full(len(way.moves.tip), 0.5))
    middle = tip[row] + at[:, None] * (tip[np.minimum(row + 1, len(tip) - 1)] - tip[row])
    assert np.abs(middle - way.moves.tip.mean(axis=1)).max() < 2e-6


def test_a_tool_that_turns_on_the_spot_keeps_its_turn() -> None:
    lean = np.linspace(0.0, 0.6, 300)
    axis = np.c_[np.sin(lean), np.zeros(300), np.cos(lean)]
    way = Way.of(np.zeros((300, 3)), axis, Cutter(3 * MM, 3 * MM, 50 * MM), tolerance=1e-6)
    assert 40 < len(way.kept) < 120 and np.all(np.diff(way.along) > 0.0)


@pytest.mark.parametrize("deep", [0.3, 0.7, 1.3])
def test_what_is_cut_of_a_layer_thinner_than_the_pitch(deep):
    """Rays along the layer meet it once or not at all, those across it everywhere."""
    moves = along_x([30.0 - deep], Cutter(4 * MM, 0.0, 50 * MM), at=(0.0, 40.0))
    area = removed_area(Dexels(np.zeros(3), np.array([40.0, 20.0, 30.0]) * MM, 1.0 * MM), moves, parts=1)
    np.testing.assert_allclose(area, 8.0 * deep * MM**2, rtol=0.12)


def test_a_block_has_no_rays_beside_it():
    for size in (12.0, 12.3, 12.7, 12.0 + 1e-12):
        block = Dexels(np.zeros(3), np.array([size, 20.0, 20.0]) * MM, 1.0 * MM)
        assert block.count[2].shape[0] == round(size)
        assert block.volume() == pytest.approx(round(size) * 400 * MM**3)
