"""A domed rosette of nine swirling petals, cut in one spiral with all axes moving: the tool leans with the dome."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from making.clsf import APPROACH, ENGAGE, STEP, Clsf
from making.drop_cutter import drop, thin
from making.mesh import polar_relief, stl

__all__ = ["height", "make", "part"]

Array = NDArray[np.float64]
RIM = 110.0  # mm: radius of the round body
THICK = 30.0  # of its wall
RISE = 42.0  # of the dome above the wall
PETALS = 9
BALL = 5.0  # radius of the ball
TLDATA = (10.0, 5.0, 75.0, 0.0, 0.0)
MSYS = (0, 0, 0, 1, 0, 0, 0, 1, 0)
STEPOVER = 3.0
LEAN = 0.75  # share of the dome's slope that the tool follows: 34 degrees at the rim
LEAD = np.radians(8.0)  # forward, along the feed
CHORD = 0.02
LONGEST = 3.0
CLEAR = 120.0
FEED, FEED_ENGAGE = 4000.0, 1500.0


def _smooth(t: Array) -> Array:
    t = np.clip(t, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _dome(r: Array) -> Array:
    sphere = (RIM**2 + RISE**2) / (2.0 * RISE)
    return np.sqrt(sphere**2 - np.minimum(r, RIM) ** 2) - (sphere - RISE)


def height(x: Array, y: Array) -> Array:
    """Height of the rosette over the part's bottom plane: a dome, petals that swirl, a knob, a ring within the rim."""
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    petals = np.cos(PETALS * (angle + 0.55 * np.sin(np.pi * r / RIM)))
    fade = _smooth((r - 22.0) / 62.0) * _smooth((98.0 - r) / 16.0)
    knob = 5.0 * np.exp(-((r / 15.0) ** 2)) - 3.0 * np.exp(-(((r - 24.0) / 6.0) ** 2))
    ring = 2.5 * np.exp(-(((r - 101.0) / 5.0) ** 2))
    return THICK + _dome(r) + 5.0 * fade * petals + knob + ring


def part() -> trimesh.Trimesh:
    """The body as a mesh."""
    return polar_relief(height, RIM, rings=33, sectors=144, bottom=0.0)


def _spiral() -> tuple[Array, Array, Array]:
    """Places (n, 2) of an inward spiral, steps of about 1 mm; their radii and angles (n,)."""
    first, last = RIM - 1.0, 1.5
    turns = (first - last) / STEPOVER
    length = np.pi * (first**2 - last**2) / STEPOVER
    share = np.linspace(0.0, 1.0, int(length / 1.0))
    r = np.sqrt(first**2 + (last**2 - first**2) * share)  # equal steps along the path
    angle = 2.0 * np.pi * turns * (first - r) / (first - last)
    return np.column_stack([r * np.cos(angle), r * np.sin(angle)]), r, angle


def _axes(r: Array, angle: Array) -> Array:
    """Unit tool axes (n, 3): the dome's normal in part, and a lead along the feed that fades towards the middle."""
    sphere = (RIM**2 + RISE**2) / (2.0 * RISE)
    lean = LEAN * np.arcsin(np.minimum(r, RIM) / sphere)
    out = np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(r)])
    normal = np.sin(lean)[:, None] * out + np.cos(lean)[:, None] * [0.0, 0.0, 1.0]
    feed = np.column_stack([-np.sin(angle), np.cos(angle), np.zeros_like(r)])
    lead = LEAD * _smooth(r / 30.0)
    return np.cos(lead)[:, None] * normal + np.sin(lead)[:, None] * feed


def make() -> tuple[Clsf, bytes]:
    """The CL file and the part's STL."""
    data, triangles = stl(part())
    xy, r, angle = _spiral()
    center = np.column_stack([xy, drop(triangles, xy, BALL, 0.0)])
    axis = _axes(r, angle)
    tip = center - BALL * axis
    kept = thin(np.column_stack([tip, 30.0 * axis]), CHORD, LONGEST)  # 30 mm: what a turn of the axis weighs
    tip, axis = tip[kept], axis[kept]

    n = np.arange(24, 0, -1)  # lead-in: falls off the spiral's tangent, along the axis, as a parabola of 24 mm by 15 mm
    ahead = tip[0] - tip[1]
    ahead = ahead / np.linalg.norm(ahead)
    lead_in = tip[0] + n[:, None] * ahead + (15.0 * (n / 24.0) ** 2)[:, None] * axis[0]
    behind = (tip[-1] - tip[-2]) / np.linalg.norm(tip[-1] - tip[-2])
    m = np.arange(1, 13)
    lead_out = tip[-1] + 0.5 * m[:, None] * behind + (15.0 * (m / 12.0) ** 2)[:, None] * axis[-1]

    out = Clsf()
    out.operation("SPIRAL_5AX", "BALL_10", TLDATA, MSYS, 12000)
    out.rapid(lead_in[0] + axis[0] * (CLEAR - lead_in[0, 2]) / axis[0, 2], axis[0])
    out.rapid(lead_in[0] + 3.0 * axis[0], axis[0], color=APPROACH)
    out.cut(lead_in, FEED_ENGAGE, axis[0], color=ENGAGE)
    out.cut(tip, FEED, axis)
    out.cut(lead_out, FEED, axis[-1], color=STEP)
    out.rapid(lead_out[-1] + axis[-1] * (CLEAR - lead_out[-1, 2]) / axis[-1, 2], axis[-1])
    out.end()
    return out, data
