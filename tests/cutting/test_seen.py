"""What is seen of the stock while it is cut, against blocks and grooves worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import Moves
from camrob.cutting.seen import seen_stock

FLAT = Cutter(0.005, 0.0, 0.05)


def _block():
    block = trimesh.creation.box((0.1, 0.06, 0.02))
    block.apply_translation((0.0, 0.0, -0.01))
    return np.array(block.triangles)


def _groove(depth, cutter=FLAT, begin=-0.06, end=0.06):
    tip = np.array([[begin, 0.0, 0.01], [begin, 0.0, -depth], [end, 0.0, -depth], [end, 0.0, 0.01]])
    return Moves.along(tip, np.tile([0.0, 0.0, 1.0], (4, 1)), cutter)


def _side(seen, axis, facing):
    return next(s for s in seen.sides if (s.axis, s.facing) == (axis, facing))


def _rays(seen, side):
    """Coordinates of the rays on the two other axes."""
    return [side.first[k] + seen.pitch * np.arange(side.height.shape[1 + k]) for k in range(2)]


def test_a_groove_from_above_and_from_its_ends():
    seen = seen_stock(_block(), _groove(0.005), np.array([1.0, 5.0, 6.0]))
    top = _side(seen, 2, 1)
    x, y = _rays(seen, top)
    within = (np.abs(x) < 0.05)[:, None] & (np.abs(y) < 0.0048)[None, :]
    np.testing.assert_allclose(top.height[0][within], 0.0, atol=1e-12)
    np.testing.assert_allclose(top.height[-1][within], -0.005, atol=1e-12)
    np.testing.assert_allclose(top.far[-1][within], seen.lower[2], atol=1e-12)
    since = np.nanmax(top.since, axis=0)
    assert np.all(since[within] == 5.0) and np.all(np.isnan(since[np.abs(y)[None, :] > 0.005 + 0 * x[:, None]]))
    end = _side(seen, 0, 1)
    y, z = _rays(seen, end)
    through = (np.abs(y) < 0.0048)[:, None] & ((z > -0.005) & (z < 0.0))[None, :]
    assert np.all(end.height[0][through] == 0.05) and np.all(np.isnan(end.height[-1][through]))
    assert np.all(np.nanmax(end.since, axis=0)[through] == 5.0)
    assert not np.isfinite(_side(seen, 2, -1).height).any()  # from below, the box lies within the block


def test_cut_again_later_is_seen_twice_and_the_last_hides_what_was_before():
    first, second = _groove(0.004), _groove(0.010, Cutter(0.003, 0.0, 0.05))
    moves = Moves(
        np.concatenate([first.tip, second.tip]),
        np.concatenate([first.axis, second.axis]),
        np.repeat([0, 1], 3),
        (first.cutters[0], second.cutters[0]),
    )
    seen = seen_stock(_block(), moves, np.array([1.0, 5.0, 6.0, 51.0, 55.0, 60.0]))
    top = _side(seen, 2, 1)
    x, y = _rays(seen, top)
    middle, rim = np.abs(y) < 0.0028, (np.abs(y) > 0.0031) & (np.abs(y) < 0.0048)
    inside = np.abs(x) < 0.05
    steps = [top.height[k][inside][:, middle] for k in range(len(top.height))]
    assert np.all(steps[0] == 0.0) and np.allclose(steps[1], -0.004) and np.allclose(steps[-1], -0.010)
    assert np.allclose(top.height[-1][inside][:, rim], -0.004)
    times = top.since[:, inside][:, :, middle]
    assert np.all(times[0] == 5.0) and np.all(times[-1] == 55.0)


def test_material_above_a_groove_cut_from_aside_ends_where_the_groove_begins():
    """An undercut: from above nothing changes, but the material that is seen has an end."""
    tip = np.array([[-0.06, -0.05, -0.01], [0.06, -0.05, -0.01], [0.06, -0.02, -0.01], [-0.06, -0.02, -0.01]])
    moves = Moves.along(tip, np.tile([0.0, -1.0, 0.0], (4, 1)), Cutter(0.003, 0.0, 0.05))
    seen = seen_stock(_block(), moves, np.array([1.0, 2.0, 3.0]))
    top, front = _side(seen, 2, 1), _side(seen, 1, -1)
    assert not np.isfinite(top.since).any()
    assert np.isfinite(front.since).any()
    z, x = _rays(seen, front)
    cut = (np.abs(z + 0.01) < 0.0028)[:, None] & (np.abs(x) < 0.049)[None, :]
    assert np.allclose(front.height[-1][cut], -0.02)


def test_what_is_not_cut_is_nothing_to_see():
    above = Moves.along(np.array([[0.0, 0.0, 0.01], [0.05, 0.0, 0.01]]), np.tile([0.0, 0.0, 1.0], (2, 1)), FLAT)
    assert seen_stock(_block(), above, np.array([1.0])) is None
    hollow = _block()[:-1]
    from camrob.errors import InputError

    with pytest.raises(InputError, match="mesh"):
        seen_stock(hollow, _groove(0.005), np.array([1.0, 5.0, 6.0]))
