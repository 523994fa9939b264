"""The joints' limits as the follower keeps them: a little inside, for between two points an axis runs a little past both."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.frozen import locked

__all__ = ["own_limits"]

Array = NDArray[np.float64]

_INSIDE = 1e-3, 1e-4  # rad, m; seen where A1 stood at its limit along arcs cut into lines: 2e-5 rad


def own_limits(cell: Cell) -> tuple[Array, Array]:
    """Lower and upper (n,) that the follower keeps, rad and m; never past the middle of what a joint may go."""
    inside = np.where([j.prismatic for j in cell.joints], _INSIDE[1], _INSIDE[0])
    inside = np.minimum(inside, 0.25 * (cell.q_upper - cell.q_lower))
    count = (len(cell),)
    return locked(cell.q_lower + inside, shape=count, name="lower"), locked(
        cell.q_upper - inside, shape=count, name="upper"
    )
