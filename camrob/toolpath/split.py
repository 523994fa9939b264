"""Regions cut in two where the tool turns in the air: a place at which the arm's posture may be chosen anew."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise

import numpy as np

from camrob.toolpath.region import Arc, Move, Region

__all__ = ["split_at_turns"]


def split_at_turns(region: Region, least_angle: float = math.pi / 18.0) -> list[Region]:
    """The region, cut within each run of rapids over which the tool axis turns by more than `least_angle` (rad).

    The second part begins with the first rapid point whose axis has left that of the last cut, so that the retract
    stays with the first part. Events and arcs go with their points. Regions that need no cut come back as they are.
    """
    cutting = np.flatnonzero(region.move == Move.CUT)
    if len(cutting) < 2:
        return [region]
    before, after = cutting[:-1], cutting[1:]
    cosine = np.sum(region.axis[before] * region.axis[after], axis=1)
    turning = np.flatnonzero((after - before > 1) & (cosine < math.cos(least_angle)))
    if not len(turning):
        return [region]
    cuts = [0]
    for n in turning:
        run = np.arange(before[n] + 1, after[n])
        left = region.axis[run] @ region.axis[before[n]] < math.cos(0.5 * least_angle)
        cuts.append(int(run[np.argmax(left)]) if left.any() else int(run[-1]))
    cuts.append(len(region))
    return [_part(region, a, b, n) for n, (a, b) in enumerate(pairwise(cuts))]


def _part(region: Region, first: int, stop: int, number: int) -> Region:
    s = slice(first, stop)
    last = stop == len(region)
    arcs = tuple(
        Arc(a.first - first, a.last - first, a.center, a.axis, a.radius, a.angle)
        for a in region.arcs
        if first <= a.first and a.last < stop
    )
    events = tuple(
        dataclasses.replace(e, point=e.point - first)
        for e in region.events
        if first <= e.point < stop or (last and e.point == stop)
    )
    return Region(
        name=region.name if number == 0 else f"{region.name} ({number + 1})",
        position=region.position[s],
        axis=region.axis[s],
        feed=region.feed[s],
        move=region.move[s],
        line=region.line[s],
        tool=region.tool,
        operation=region.operation,
        arcs=arcs,
        events=events,
        detached=region.detached and number == 0,
    )
