"""A ball on a column, finished along three meridians: high over the table, leaning past the level, the arm nearly stretched."""

from __future__ import annotations

import numpy as np
import trimesh

from making.clsf import APPROACH, STEP, Clsf
from making.mesh import stl

__all__ = ["make", "part"]

RADIUS, HEIGHT, COLUMN = 130.0, 800.0, 40.0  # mm: the ball, its centre over the table, the column's radius
TLDATA = (10.0, 5.0, 60.0, 0.0, 0.0)
MSYS = (0, 0, HEIGHT, 1, 0, 0, 0, 1, 0)  # origin in the ball's middle
MERIDIANS, SWING = (75.0, 90.0, 105.0), 30.0  # degrees about the column: where they lie, and how far each sways
LOWEST = 105.0  # degrees from upright that the tool leans at most
POINTS = 160
FEED, FEED_PLUNGE = 3000.0, 2000.0
CLEAR, NEAR = 60.0, 5.0


def part() -> trimesh.Trimesh:
    """Ball and column, facets inside of the ball by up to a millimetre."""
    ball = trimesh.creation.icosphere(3, RADIUS - 0.5)
    ball.apply_translation([0.0, 0.0, HEIGHT])
    length = HEIGHT - RADIUS + 10.0
    column = trimesh.creation.cylinder(COLUMN, length, sections=32)
    column.apply_translation([0.0, 0.0, length / 2.0])
    return trimesh.util.concatenate([ball, column])


def make() -> tuple[Clsf, bytes]:
    """The CL file and the part's mesh."""
    cl = Clsf()
    cl.operation("MERIDIANS", "BALL_10", TLDATA, MSYS, 9000)
    s = np.linspace(0.0, 1.0, POINTS)
    lean = np.radians(LOWEST) * np.sin(np.pi * s) ** 2  # from the pole past the equator and back
    for middle in MERIDIANS:
        turn = np.radians(middle) + np.radians(SWING) * (s - 0.5)
        axis = np.stack([np.sin(lean) * np.cos(turn), np.sin(lean) * np.sin(turn), np.cos(lean)], axis=1)
        point = RADIUS * axis
        cl.rapid(point[0] + CLEAR * axis[0], axis[0])
        cl.cut(point[0] + NEAR * axis[0], FEED_PLUNGE, axis[0], APPROACH)
        cl.cut(point, FEED, axis)
        cl.cut(point[-1] + NEAR * axis[-1], FEED, axis[-1], STEP)
        cl.rapid(point[-1] + CLEAR * axis[-1], axis[-1])
    cl.end()
    return cl, stl(part())[0]
