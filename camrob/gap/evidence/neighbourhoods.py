"""Neighbourhoods of posture, that samples are withheld by: rows beside each other in time or place tell each other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.gap.observation.scene import Scene

__all__ = ["neighbourhoods", "neighbours_in_row"]

_STRETCHES = 4  # of a path, a neighbourhood: what the path comes back to is withheld with it
_TRACK = 0.5  # m of a sliding axis that count as a rad


def neighbourhoods(scene: Scene, count: int) -> NDArray[np.int64]:
    """(N,) numbers below `count` of the neighbourhood that a sample belongs to. Rows of one posture are never parted; a path is
    cut into stretches of time first, as neighbours in time tell each other too.
    """
    prismatic = [scene.cell.joints[scene.cell.index(a)].prismatic for a in scene.axes]
    postures = scene.link / np.where(prismatic, _TRACK, 1.0)
    rows = np.arange(len(scene))
    stretch = rows if scene.poses else (rows * _STRETCHES * count) // len(scene)
    sizes = np.bincount(stretch)
    middles = np.stack([np.bincount(stretch, x) / np.maximum(sizes, 1) for x in postures.T], axis=1)
    out = np.zeros(len(middles), np.int64)
    waiting = [(np.flatnonzero(sizes > 0), count, 0)]
    while waiting:
        own, parts, first = waiting.pop()
        if parts == 1 or len(own) < 2:
            out[own] = first
            continue
        values = middles[own]
        widest = values[:, int(np.argmax(np.ptp(values, axis=0)))]
        order = np.argsort(widest, kind="stable")
        cut = len(own) * (parts // 2) // parts
        while 0 < cut < len(own) and widest[order[cut]] == widest[order[cut - 1]]:
            cut += 1
        waiting += [(own[order[:cut]], parts // 2, first), (own[order[cut:]], parts - parts // 2, first + parts // 2)]
    return out[stretch]


def neighbours_in_row(scene: Scene) -> NDArray[np.int64]:
    """(N,) order of samples in which neighbours stand beside each other: on a path as they were taken, of poses by posture."""
    if not scene.poses:
        return np.arange(len(scene))
    return np.argsort(neighbourhoods(scene, len(scene)), kind="stable")
