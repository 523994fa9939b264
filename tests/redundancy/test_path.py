"""What a path says of itself: its steps, which of them are cut, and what its points count."""

import numpy as np

from camrob.redundancy.path import TRANSIT, ToolPathInBase
from camrob.toolpath.region import Move


def _path(x, move):
    n = len(x)
    frames = np.tile(np.eye(4), (n, 1, 1))
    frames[:, 0, 3] = x
    move = np.array(move, np.int8)
    region = np.where(move == Move.LINK, TRANSIT, 0)
    safe = np.zeros(n, bool)
    return ToolPathInBase(
        frames, move, np.where(move == Move.CUT, 0.1, np.nan), np.arange(n), region, np.arange(n), safe
    )


def test_steps_and_what_is_cut_of_them():
    path = _path([0.0, 0.3, 0.2, 0.6], [Move.RAPID, Move.CUT, Move.LINK, Move.CUT])
    np.testing.assert_allclose(path.step, [0.0, 0.3, 0.1, 0.4])
    np.testing.assert_allclose(path.cut, [0.0, 0.3, 0.0, 0.4])
    np.testing.assert_allclose(path.weight, path.cut)


def test_all_points_count_alike_where_nothing_is_cut():
    path = _path([0.0, 0.3, 0.5], [Move.RAPID, Move.RAPID, Move.LINK])
    assert path.weight.tolist() == [1.0, 1.0, 1.0]
    assert len(_path([], []).step) == 0
