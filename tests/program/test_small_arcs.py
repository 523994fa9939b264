"""Which arcs a program keeps: none whose points are nearer than a MoveC takes them, or rounding leaves them."""

from __future__ import annotations

import numpy as np
import pytest

from camrob.program.arcs import circ_rows
from camrob.program.motion import Motion
from camrob.toolpath.region import Arc, Move, Region


def region(radius: float, angle: float, count: int = 9) -> Region:
    """A region that is one arc."""
    at = np.linspace(0.0, angle, count)
    position = np.stack([radius * np.cos(at), radius * np.sin(at), np.zeros(count)], axis=1)
    arc = Arc(0, count - 1, np.zeros(3), np.array([0.0, 0.0, 1.0]), radius, angle)
    move = np.full(count, int(Move.CUT))
    return Region(
        "arc", position, np.tile([0.0, 0.0, 1.0], (count, 1)), np.full(count, 0.01), move, np.arange(count), arcs=(arc,)
    )


@pytest.mark.parametrize(
    ("radius", "angle", "kept"),
    [
        (3e-4, 0.5, False),
        (3e-4, 2.0, True),
        (4e-4, 0.9, False),
        (1e-3, 0.3, False),
        (1e-3, 0.5, True),
        (0.02, 0.2, True),
    ],
)
def test_the_points_of_an_arc_are_0_2_mm_apart(radius: float, angle: float, kept: bool) -> None:
    """The chord of half the arc, 2 r sin(angle / 4), decides."""
    assert (2.0 * radius * np.sin(angle / 4.0) >= 2e-4) == kept
    made = region(radius, angle)
    kind, keep = np.full(9, int(Motion.LIN), np.int8), np.ones(9, np.bool_)
    circ_rows(made, np.arange(9), kind, keep)
    assert (Motion.CIRC_END in kind) == kept and keep.all() != kept
