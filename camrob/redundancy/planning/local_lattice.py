"""The lattice of a plan that is made anew in places: open about what is forbidden, and elsewhere the plan as it stands."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.planning.course import Draft
from camrob.redundancy.planning.forbidding import FEATURES
from camrob.redundancy.planning.layers import Nodes
from camrob.redundancy.planning.waypoints import Waypoints

__all__ = ["local_nodes"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

# m of s to either side of what is forbidden in which another way may be taken: five layers of the lattice
_AROUND = 0.5


def local_nodes(nodes: Nodes, w: Waypoints, coarse: Ints, draft: Draft, blocked: Array) -> Nodes:
    """The lattice's candidates in the layers about what is forbidden, rows (K, 9), and in the others the draft's own postures.

    coarse (T,): the waypoints that the layers are at. The draft's postures are free of price: there is no choice.
    """
    parts: list[tuple[Array, Array, Ints, Array, Array]] = []
    for t, k in enumerate(coarse.tolist()):
        s = w.s[k]
        if np.any((blocked[:, FEATURES] - _AROUND <= s) & (s <= blocked[:, FEATURES + 1] + _AROUND)):
            own = slice(int(nodes.offset[t]), int(nodes.offset[t + 1]))
            parts.append((nodes.u[own], nodes.q[own], nodes.branch[own], nodes.price[own], nodes.room[own]))
        else:
            row = np.flatnonzero(draft.index == k)
            parts.append((draft.u[row], draft.q[row], draft.branch[row], np.zeros(len(row)), np.full(len(row), np.inf)))
    offset = np.cumsum([0, *(len(part[3]) for part in parts)])
    u, q, branch, price, room = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Nodes(offset, u, q, branch, price, room)
