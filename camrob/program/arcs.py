"""Arcs of a region that a program can keep as CIRC."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from camrob.program.motion import Motion
from camrob.toolpath.region import Arc, Move, Region
from camrob.toolpath.toolpath import Toolpath

__all__ = ["circ_rows", "without_arcs"]

LEAST_RADIUS = 2e-4  # m; below it the rounding of three points bends the arc
LEAST_WAY = 2e-4  # m between the points of a CIRC; ABB's MoveC takes none nearer than 0.1 mm
LEAST_ANGLE = 0.17  # rad; shorter arcs stay lines, within the chord tolerance that they were cut with
MOST_ANGLE = 3.5  # rad that one CIRC turns; a full circle becomes two


def circ_rows(region: Region, place: NDArray[np.int64], kind: NDArray[np.int8], keep: NDArray[np.bool_]) -> None:
    """Mark a region's arcs as CIRC: `kind` and `keep` (of the whole path) are changed in place.

    place: (n,) where in the path the region's points stand. An arc stays lines where the path leaves it on the
    way, where something happens on it, where
    its feed changes, or where it is too small or flat for three rounded points to carry it.
    """
    busy = {event.point for event in region.events}
    for arc in region.arcs:
        inside = slice(arc.first + 1, arc.last + 1)
        points = arc.last - arc.first
        whole = bool(np.all(region.move[inside] == Move.CUT)) and len(np.unique(region.feed[inside])) == 1
        quiet = not any(arc.first < p <= arc.last for p in busy)
        unbroken = place[arc.last] - place[arc.first] == points
        if not (
            whole and quiet and unbroken and points >= 2 and arc.radius >= LEAST_RADIUS and arc.angle >= LEAST_ANGLE
        ):
            continue
        pieces = _pieces(arc)
        ways = np.linalg.norm(np.diff(region.position[np.array(pieces)], axis=1), axis=2)
        if float(ways.min()) < LEAST_WAY:
            continue
        for first, via, last in pieces:
            keep[place[first + 1 : last]] = False
            keep[place[[via, last]]] = True
            kind[place[via]] = Motion.CIRC_VIA
            kind[place[last]] = Motion.CIRC_END


def _pieces(arc: Arc) -> list[tuple[int, int, int]]:
    """(first, via, last) of the CIRCs that make the arc; as few as its angle allows, two points each at the least."""
    points = arc.last - arc.first
    count = max(1, int(np.ceil(arc.angle / MOST_ANGLE)))
    count = min(count, points // 2)
    edges = arc.first + np.round(np.linspace(0, points, count + 1)).astype(int)  # the same wherever the arc stands
    return [(int(a), int((a + b) // 2), int(b)) for a, b in pairwise(edges)]


def without_arcs(toolpath: Toolpath, line: int) -> Toolpath | None:
    """The toolpath with lines instead of the arcs of the region that has one at a CL line; None where no region has."""
    regions = list(toolpath.regions)
    for k, region in enumerate(regions):
        if any(line in region.line[arc.first : arc.last + 1] for arc in region.arcs):
            regions[k] = replace(region, arcs=())
            return replace(toolpath, regions=tuple(regions))
    return None
