"""Corners that a control rounds or chamfers between two straight cuts: Siemens' RND, CHR, CHF, Heidenhain's RND, CHF, ,R and ,C.

840D sl "Fundamentals", 2.7 (CHF: the chamfer's own length, CHR: along the contour); TNC 640 "Klartext", 6.4 (CHF: side length);
Fanuc B-63944EN, "optional chamfering and corner R" (,C: along the contour).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError

__all__ = ["BASE", "LEG", "ROUND", "Corner", "Cut", "cut_corner"]

ROUND, LEG, BASE = "round", "leg", "base"
"""What the size of a corner is: a radius, how far a chamfer goes along the contour, or its own length."""

_SLACK = 1e-9  # m
_STRAIGHT = 1e-6  # rad: what turns by less is no corner
_IN_PLANE = 1e-6  # of a cut's length: what it may rise out of the plane

Point = NDArray[np.float64]


class Corner(NamedTuple):
    """A corner at the end of a straight cut: `kind` and `size` (the program's unit), `feed` as F would be, None: the cut's."""

    kind: str
    size: float
    feed: float | None = None


class Cut(NamedTuple):
    """Where a corner begins and ends (3,) m; of a rounded one the centre (3,) m and the normal that it turns about, else None."""

    begin: Point
    end: Point
    center: Point | None
    normal: Point | None


def cut_corner(start: Point, corner: Point, end: Point, plane: Point, kind: str, size: float) -> Cut | None:
    """The corner between the cuts from `start` to `corner` to `end` (3,) m, `size` in m, in the plane across the unit `plane`.

    None where the two are one line. Raises ToolpathError where they leave the plane, go back, or are too short.
    """
    back, on = start - corner, end - corner
    before, behind = float(np.linalg.norm(back)), float(np.linalg.norm(on))
    if before < _SLACK or behind < _SLACK:
        raise ToolpathError("a rounded or chamfered corner beside a cut without length", hint="take it out")
    u, v = back / before, on / behind
    if max(abs(float(u @ plane)), abs(float(v @ plane))) > _IN_PLANE:
        raise ToolpathError("a rounded or chamfered corner out of its plane", hint="write the corner out as moves")
    angle = math.acos(max(-1.0, min(1.0, float(u @ v))))
    if math.pi - angle < _STRAIGHT:
        return None
    if angle < _STRAIGHT:
        raise ToolpathError("a rounded or chamfered corner where the cut turns back", hint="take it out")
    half = 0.5 * angle
    leg = {ROUND: size / math.tan(half), LEG: size, BASE: 0.5 * size / math.sin(half)}[kind]
    if leg > min(before, behind) + _SLACK:
        raise ToolpathError("a corner that is larger than the cuts beside it", hint="make its radius or length smaller")
    if kind != ROUND:
        return Cut(corner + leg * u, corner + leg * v, None, None)
    middle = (u + v) / float(np.linalg.norm(u + v))
    normal = plane if float(np.cross(-u, v) @ plane) > 0.0 else -plane
    return Cut(corner + leg * u, corner + leg * v, corner + size / math.sin(half) * middle, normal)
