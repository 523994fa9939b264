"""Material removal: what paper says of slots, grooves and ridges, and a library of solids as a second opinion."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import Dexels, Moves, deviation, of_mesh
from camrob.errors import InputError

MM = 1e-3
UP = np.array([0.0, 0.0, 1.0])


def straight(points, cutter, axis=UP):
    """Moves along points (K, 3), mm."""
    tip = np.asarray(points, float) * MM
    axes = np.broadcast_to(np.asarray(axis, float), tip.shape)
    return Moves.along(tip, axes / np.linalg.norm(axes, axis=1)[:, None], cutter)


def plate(x=20.0, y=20.0, z=10.0, pitch=0.25):
    return Dexels(np.zeros(3), np.array([x, y, z]) * MM, pitch * MM)


def of(radius, corner, length=40.0):
    return Cutter(radius * MM, corner * MM, length * MM)


@pytest.mark.slow
def test_a_slot_has_its_width_and_depth() -> None:
    stock, moves = plate(), straight([[-10, 10, 6], [30, 10, 6]], of(3, 0))
    stock.carve(moves)
    for direction in (0, 1, 2):
        assert stock.volume(direction) == pytest.approx((20 * 20 * 10 - 20 * 6 * 4) * MM**3, rel=5e-3)
    cut = stock.surface(moves)
    floor = np.abs(cut.normal[:, 2]) > 0.9
    assert np.abs(cut.point[floor, 2] - 6 * MM).max() < 1e-9
    assert np.abs(np.abs(cut.point[~floor, 1] - 10 * MM) - 3 * MM).max() < 1e-7
    assert np.all(cut.normal[floor, 2] > 0.999)  # out of the material


@pytest.mark.parametrize("fall", [0.0, 0.1])
def test_every_point_of_a_flat_cutters_floor_looks_across_its_way(fall: float) -> None:
    """A floor, and a ramp that the rim behind the axis leaves, z = z0 - fall (x + sqrt(R^2 - y^2)): all rays that meet it."""
    stock, moves = plate(), straight([[-10, 10, 6 + 10 * fall], [30, 10, 6 - 30 * fall]], of(3, 0))
    stock.carve(moves)
    cut = stock.surface(moves)
    ramp = cut.direction == 2
    y = cut.point[ramp, 1] - 10 * MM
    slopes = np.stack([np.full(len(y), fall), -fall * y / np.sqrt((3 * MM) ** 2 - y**2), np.ones(len(y))], axis=1)
    across = slopes / np.linalg.norm(slopes, axis=1)[:, None]
    assert ramp.sum() == 80 * 24  # rays a quarter of a mm apart, on 20 x 6 mm
    assert np.abs(cut.normal[ramp] - across).max() < 1e-3


@pytest.mark.parametrize("step", [40.0, 0.37])
def test_a_ball_leaves_its_own_section(step: float) -> None:
    x = np.arange(-10.0, 30.0 + step, step)
    stock, moves = plate(), straight(np.c_[x, np.full(len(x), 10.0), np.full(len(x), 7.0)], of(5, 5))
    stock.carve(moves)
    cut = stock.surface(moves)
    r = np.hypot(cut.point[:, 1] - 10 * MM, cut.point[:, 2] - 12 * MM)
    assert np.abs(r - 5 * MM).max() < 0.1e-6
    section = 25 * np.arccos(0.4) - 2 * np.sqrt(21)  # mm2: a circle's segment, 3 deep
    assert stock.volume(0) == pytest.approx((20 * 20 * 10 - 20 * section) * MM**3, rel=5e-3)


def test_ridges_between_passes_are_as_high_as_paper_says() -> None:
    """h = R - sqrt(R^2 - (s / 2)^2)."""
    R, s = 5.0, 2.0
    stock = plate(pitch=0.05, x=2.0)
    passes = [straight([[-10, y, 5], [30, y, 5]], of(R, R)) for y in np.arange(2.0, 19.0, s)]
    for one in passes:
        stock.carve(one)
    (edge, _), count = stock.stretches(2), stock.count[2]
    assert np.all(count == 1)
    y = stock.grid(2)[1] + np.arange(edge.shape[1]) * stock.pitch
    inside = (y > 4 * MM) & (y < 16 * MM)
    top = edge[0, inside, 1]
    assert top.max() - 5 * MM == pytest.approx((R - np.sqrt(R**2 - s**2 / 4)) * MM, rel=0.05)
    ridge = y[inside][np.argmax(top)]
    assert ridge / MM % s == pytest.approx(1.0, abs=0.06)


def test_a_swept_sphere_takes_a_capsule_away() -> None:
    stock, R, way = plate(30, 30, 30, 0.2), 4.0, 9.0
    moves = straight([[10, 15, 11], [19, 15, 11]], of(R, R, R))
    stock.carve(moves)
    capsule = 4 / 3 * np.pi * R**3 + np.pi * R**2 * way
    for direction in (0, 1, 2):
        assert 27000 - stock.volume(direction) / MM**3 == pytest.approx(capsule, rel=4e-3)
    assert stock.count[2].max() == 2  # material above and below


def solid(cutter: Cutter, count: int = 160) -> np.ndarray:
    """Points of a convex hull that is the cutter, the tip at the origin, z to the holder."""
    around = np.linspace(0, 2 * np.pi, count, endpoint=False)
    bend = np.linspace(0, np.pi / 2, 41 if cutter.corner else 1)
    rings = [(cutter.radius - cutter.corner + cutter.corner * np.sin(b), cutter.corner * (1 - np.cos(b))) for b in bend]
    if not cutter.corner:
        rings = [(cutter.radius, 0.0)]
    rings.append((cutter.radius, cutter.length))
    return np.concatenate([np.c_[r * np.cos(around), r * np.sin(around), np.full(count, h)] for r, h in rings])


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("corner", [0.0, 1.0, 3.0])
def test_it_leaves_what_a_library_of_solids_leaves(corner: float) -> None:
    """Two ramps with the axis leaning. A convex body's way along a line is the hull of its two ends: qhull's, by planes."""
    cutter, axis = of(3.0, corner, 30.0), np.array([0.3, -0.2, 1.0]) / np.linalg.norm([0.3, -0.2, 1.0])
    path = np.array([[2.0, 5.0, 8.0], [14.0, 11.0, 4.0], [17.0, 4.0, 6.5]])
    stock, moves = plate(pitch=0.2), straight(path, cutter, axis)
    stock.carve(moves)
    turned = np.linalg.svd(np.eye(3) - np.outer(axis, axis))[0][:, :2]
    body = solid(cutter) @ np.c_[turned, axis].T
    hulls = [
        ConvexHull(np.concatenate([body + a, body + b])) for a, b in zip(path[:-1] * MM, path[1:] * MM, strict=True)
    ]
    cut = stock.surface(moves)
    some = np.linspace(0, len(cut.point) - 1, 1000).astype(int)
    planes = [h.equations[:, :3] @ cut.point[some].T + h.equations[:, 3:] for h in hulls]
    off = np.min([p.max(axis=0) for p in planes], axis=0)  # m outside the union, where above 0
    # hulls are of chords: 0.6 um within the round; a few rays graze the rim of what has a flat between two places of it
    assert np.abs(off).max() < 1.5e-6 if corner == 3.0 else np.mean(off < -1.5e-6) < {0.0: 2e-2, 1.0: 2e-3}[corner]
    assert off.max() < 1.5e-6
    # and nothing else was taken, and nothing left: what is inside of a hull is air
    rng = np.random.default_rng(1)
    points = rng.uniform(0, 1, (2000, 3)) * np.array([20, 20, 10]) * MM
    for d in (0, 1, 2):
        u, v = stock.others(d)
        grid = stock.grid(d)
        i, j = (np.rint((points[:, k] - grid[n]) / grid[2]).astype(int) for n, k in enumerate((u, v)))
        snapped = points.copy()
        snapped[:, u], snapped[:, v] = grid[0] + i * grid[2], grid[1] + j * grid[2]
        depth = np.min([(h.equations[:, :3] @ snapped.T + h.equations[:, 3:]).max(axis=0) for h in hulls], axis=0)
        edge, count = stock.stretches(d)[0][i, j], stock.count[d][i, j]
        used = np.arange(edge.shape[1] // 2) < count[:, None]
        solid_there = np.any(used & (edge[:, ::2] < snapped[:, [d]]) & (edge[:, 1::2] > snapped[:, [d]]), axis=1)
        clear = np.abs(depth) > 5e-6
        assert np.mean(solid_there[clear] != (depth[clear] > 0)) <= (0.0 if corner == 3.0 else 1e-3)


def test_normals_are_those_of_the_surface() -> None:
    stock, moves = plate(), straight([[2, 5, 8], [14, 11, 4]], of(3, 1), [0.3, -0.2, 1.0])
    stock.carve(moves)
    cut = stock.surface(moves)
    ends, who = stock.nearest_end(cut)
    assert np.abs(ends - cut.point[np.arange(len(ends)), cut.direction]).max() == 0.0
    assert np.array_equal(who, cut.move)
    # a push of the whole cutter moves the surface by the push's share along the normal
    push = np.array([4.0, -7.0, 5.0]) * 1e-6
    other = plate()
    other.carve(Moves(moves.tip + push, moves.axis, moves.cutter, moves.cutters))
    moved = deviation(cut, Moves(moves.tip + push, moves.axis, moves.cutter, moves.cutters), other, farthest=1e-3)
    assert np.nanquantile(np.abs(moved - cut.normal @ push), 0.98) < 0.3e-6


def test_a_groove_that_is_cut_deeper_is_off_by_that_along_its_normals() -> None:
    """A ball that goes 0.3 mm too deep: a point's distance to the circle below it, which no single ray tells."""
    centre, R, deeper = np.array([10.0, 12.0]) * MM, 5 * MM, 0.3 * MM
    stock, moves = plate(), straight([[-10, 10, 7], [30, 10, 7]], of(5, 5))
    low = straight([[-10, 10, 6.7], [30, 10, 6.7]], of(5, 5))
    other = plate()
    stock.carve(moves)
    other.carve(low)
    cut = stock.surface(moves)
    off = deviation(cut, low, other, farthest=1e-3)
    # from a point inwards along its normal, out of the material, back to the circle below
    n, p = cut.normal[:, 1:], cut.point[:, 1:] - (centre - [0.0, deeper])
    along = np.sum(n * p, axis=1)
    true = -along - np.sqrt(along**2 - np.sum(p * p, axis=1) + R**2)
    good = np.isfinite(off)
    assert good.mean() > 0.95 and np.abs(off[good] - true[good]).max() < 0.025 * deeper


def test_the_axis_may_turn_along_a_move() -> None:
    """A ball whose axis swings about its centre leaves the centre where it is: a bowl, whatever the axis does."""
    centre, R = np.array([10.0, 10.0, 9.0]), 4.0
    angle = np.linspace(-0.6, 0.6, 7)
    axis = np.c_[np.sin(angle), np.zeros(7), np.cos(angle)]
    moves = Moves.along((centre - R * axis) * MM, axis, of(R, R))
    stock = plate()
    stock.carve(moves)
    cut = stock.surface(moves)
    low = cut.point[:, 2] < (9.0 - 4.0 * np.sin(0.6)) * MM  # above, the shank swings out
    r = np.linalg.norm(cut.point[low] - centre * MM, axis=1)
    assert np.abs(r - R * MM).max() < 3e-6


def test_a_mesh_is_filled_as_it_is_closed() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4, radius=5 * MM)
    body = of_mesh(np.asarray(ball.triangles), 0.1 * MM)
    for direction in (0, 1, 2):
        assert body.volume(direction) == pytest.approx(ball.volume, rel=2e-3)
    with pytest.raises(InputError, match="close its holes"):
        of_mesh(np.asarray(ball.triangles)[: len(ball.faces) // 2], 0.1 * MM)


def test_a_block_of_equal_sides_is_closed() -> None:
    """Each of its faces is two triangles that meet on a diagonal, along which a ray of every row would run."""
    block = trimesh.creation.box(extents=[80 * MM, 80 * MM, 80 * MM])
    body = of_mesh(np.asarray(block.triangles), 0.25 * MM)
    for direction in (0, 1, 2):
        assert body.volume(direction) == pytest.approx(block.volume, rel=1e-9)


def test_room_grows_where_a_ray_meets_many_walls() -> None:
    stock = plate(40, 4, 10, 0.25)
    passes = [straight([[x, -5, 2], [x, 9, 2]], of(0.5, 0)) for x in np.arange(1.0, 39.0, 2.0)]
    for one in passes:
        stock.carve(one)
    assert stock.count[0].max() == len(passes) + 1
    assert stock.volume(0) == pytest.approx(stock.volume(2), rel=0.03)


def test_what_has_no_volume_is_refused() -> None:
    with pytest.raises(InputError, match="no volume"):
        Dexels(np.zeros(3), np.zeros(3), 1e-4)
    with pytest.raises(ValueError, match="no cutter"):
        Cutter(1.0, 2.0, 3.0)
