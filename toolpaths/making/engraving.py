"""A name plate: a hexfoil, `camrob` in single strokes, a frame, and four holes for pins."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from making.clsf import APPROACH, ENGAGE, STEP, Clsf
from making.mesh import rounded_slab, stl

__all__ = ["make", "part", "strokes"]

Array = NDArray[np.float64]
PLATE = (240.0, 110.0, 20.0)  # mm
PLATE_CORNER = 12.0
MSYS = (0, 0, 20, 1, 0, 0, 0, 1, 0)  # origin in the middle of the plate's top
TLDATA = (3.0, 1.5, 30.0, 0.0, 0.0)
DEPTH = 0.8
CLEAR, NEAR = 25.0, 3.0
FEED, FEED_PLUNGE = 1500.0, 300.0
SCALE = 0.88  # of the letters
HOLES = ((-108.0, -43.0), (108.0, -43.0), (108.0, 43.0), (-108.0, 43.0))
HOLE_DEPTH = 6.0

# A stroke: its start, then lines ("line", x, y) and arcs ("arc", center x, y, degrees turned: + anticlockwise).
Stroke = tuple[tuple[float, float], list[tuple[str, float, float, float]]]


def _line(x: float, y: float) -> tuple[str, float, float, float]:
    return "line", x, y, 0.0


def _arc(x: float, y: float, degrees: float) -> tuple[str, float, float, float]:
    return "arc", x, y, degrees


def _letter(name: str) -> tuple[float, list[Stroke]]:
    """Width and strokes of a letter, before scaling: its body is 24 high (radius 12), its stems reach 40."""
    s = float(np.round(12.0 * np.sqrt(0.5), 4))
    letters: dict[str, tuple[float, list[Stroke]]] = {
        "c": (21.0, [((12.0 + s, 12.0 + s), [_arc(12, 12, 270)])]),
        "a": (24.0, [((24.0, 12.0), [_arc(12, 12, 360)]), ((24.0, 24.0), [_line(24, 0)])]),
        "m": (
            32.0,
            [
                ((0.0, 0.0), [_line(0, 24)]),
                ((0.0, 16.0), [_arc(8, 16, -180), _line(16, 0)]),
                ((16.0, 16.0), [_arc(24, 16, -180), _line(32, 0)]),
            ],
        ),
        "r": (10.0, [((0.0, 24.0), [_line(0, 0)]), ((0.0, 14.0), [_arc(10, 14, -90)])]),
        "o": (24.0, [((24.0, 12.0), [_arc(12, 12, 360)])]),
        "b": (24.0, [((0.0, 40.0), [_line(0, 0)]), ((0.0, 12.0), [_arc(12, 12, 360)])]),
    }
    return letters[name]


def _place(u: float, v: float, x: float) -> tuple[float, float]:
    return float(np.round(x + SCALE * u, 4)), float(np.round(-14.0 + SCALE * v, 4))


def strokes() -> list[Stroke]:
    """All strokes on the plate, in the order of cutting."""
    found: list[Stroke] = []
    x = -44.0
    for name in "camrob":
        width, parts = _letter(name)
        for start, moves in parts:
            placed = [(kind, *_place(u, v, x), turn) for kind, u, v, turn in moves]
            found.append((_place(*start, x), placed))
        x += SCALE * (width + 6.0)
    middle, r = np.array([-80.0, 0.0]), 25.0
    corner = [np.round(middle + r * np.array([np.cos(a), np.sin(a)]), 4) for a in np.radians(np.arange(6) * 60.0)]
    found.append(((middle[0] + r, middle[1]), [_arc(*middle, 360)]))
    for i in range(6):  # each petal's edge is an arc about a corner of the hexagon, from one neighbour to the other
        a = corner[(i - 1) % 6]
        found.append(((float(a[0]), float(a[1])), [_arc(float(corner[i][0]), float(corner[i][1]), -120)]))
    hx, hy, k = 112.0, 47.0, 10.0
    frame = [_line(hx - k, -hy), _arc(hx, -hy, -90), _line(hx, hy - k), _arc(hx, hy, -90)]
    frame += [_line(-hx + k, hy), _arc(-hx, hy, -90), _line(-hx, -hy + k), _arc(-hx, -hy, -90), _line(0, -hy)]
    found.append(((0.0, -hy), frame))
    return found


def part() -> trimesh.Trimesh:
    """The blank plate."""
    return rounded_slab(PLATE, PLATE_CORNER)


def _turned(point: Array, center: Array, degrees: float) -> Array:
    a = np.radians(degrees)
    R = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    return np.asarray(np.round(center + R @ (point - center), 4))


def _cut(out: Clsf, stroke: Stroke) -> None:
    start, moves = stroke
    here = np.array(start)
    out.rapid((*here, CLEAR))
    out.rapid((*here, NEAR), color=APPROACH)
    out.cut((*here, -DEPTH), FEED_PLUNGE, color=ENGAGE)
    for kind, x, y, degrees in moves:
        if kind == "line":
            here = np.array([x, y])
            out.cut((x, y, -DEPTH), FEED)
            continue
        center, parts = np.array([x, y]), 1 if abs(degrees) < 360 else 2  # a full circle goes as two halves
        for _ in range(parts):
            radius = float(np.linalg.norm(here - center))
            here = _turned(here, center, degrees / parts)
            about = (0, 0, np.sign(degrees))
            out.arc((*center, -DEPTH), about, radius, (*here, -DEPTH), FEED)
    out.cut((*here, NEAR), FEED, color=STEP)
    out.rapid((*here, CLEAR))


def make() -> tuple[Clsf, bytes]:
    """The CL file and the plate's STL."""
    data, _ = stl(part())
    out = Clsf()
    out.operation("ENGRAVE", "BALL_3", TLDATA, MSYS, 18000)
    for stroke in strokes():
        _cut(out, stroke)
    out.end()
    out.operation("PIN_HOLES", "BALL_3", TLDATA, MSYS, 12000)
    out.rapid((*HOLES[0], CLEAR))
    out.cut((*HOLES[0], NEAR), FEED_PLUNGE, color=APPROACH)
    out.drill([(*hole, 0.0) for hole in HOLES], NEAR, HOLE_DEPTH, FEED_PLUNGE)
    out.rapid((*HOLES[-1], CLEAR))
    out.end()
    return out, data
