"""Where a tool may be swung any way: held to a cut and a rapid whose heights are known."""

from __future__ import annotations

import numpy as np
import pytest

from camrob.redundancy.clear_air import ClearAir

UP, ALONG_X = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
AIR = ClearAir(np.array([[0.0, 0.0, 0.10]]), np.array([[-0.2, 0.0, 0.0], [0.2, 0.0, 0.0995]]))
"""Its sphere: about (0, 0, 0.05), of radius 0.2061 + 0.01 m."""


def frame(tip: tuple[float, float, float], axis: np.ndarray) -> np.ndarray:
    out = np.eye(4)
    out[:3, 2], out[:3, 3] = axis, tip
    return out


@pytest.mark.parametrize(
    ("tip", "axis", "clear"),
    [
        ((0.0, 0.0, 0.1006), UP, True),  # above the rapid, and by 1.1 mm above what is cut
        ((0.0, 0.0, 0.1004), UP, False),  # by 0.9 mm
        ((0.0, 0.0, 0.0990), UP, False),
        ((0.202, 0.0, 0.0), ALONG_X, True),  # seen along its own axis
        ((0.200, 0.0, 0.0), ALONG_X, False),
        ((0.0, 0.3, 0.0), ALONG_X, True),  # aside of the sphere, which its axis passes by
        ((0.0, 0.1, 0.0), ALONG_X, False),
        ((-0.3, 0.0, 0.05), -ALONG_X, True),  # outside, the holder away from it
        ((-0.3, 0.0, 0.05), ALONG_X, False),  # outside, but the holder reaches through it
    ],
)
def test_clear_is_above_all_or_outside_of_all(tip: tuple[float, float, float], axis: np.ndarray, clear: bool) -> None:
    assert AIR.holds(frame(tip, axis)[None]).tolist() == [clear]


def test_poses_are_judged_each_by_its_own_axis() -> None:
    frames = np.stack([frame((0.0, 0.0, 0.2), UP), frame((0.0, 0.0, 0.2), ALONG_X), frame((0.25, 0.0, 0.0), ALONG_X)])
    assert AIR.holds(frames).tolist() == [True, False, True]
    assert ClearAir(np.zeros((0, 3)), np.zeros((0, 3))).holds(frames).all()
