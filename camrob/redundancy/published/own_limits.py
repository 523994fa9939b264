"""What the follower may do with the joints: limits as it keeps them, and joints that it holds still while the tool cuts."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role

__all__ = ["held_joints", "own_limits"]

Array = NDArray[np.float64]

_INSIDE = 1e-3, 1e-4  # rad, m; seen where A1 stood at its limit along arcs cut into lines: 2e-5 rad


def own_limits(cell: Cell, further: Mapping[str, float] | None = None) -> tuple[Array, Array]:
    """Lower and upper (n,) that the follower keeps, rad and m: a little inside, for an axis runs past its limit between points
    at it. further: by joint, what it keeps from its limits beside that.
    """
    inside = np.array([_INSIDE[j.prismatic] + (further or {}).get(j.name, 0.0) for j in cell.joints])
    inside = np.minimum(inside, 0.25 * (cell.q_upper - cell.q_lower))
    return cell.q_lower + inside, cell.q_upper - inside


def held_joints(cell: Cell) -> NDArray[np.bool_]:
    """(n,) True for joints that may move in void motions only: the table where the controller's base doesn't follow it."""
    return np.array([j.role is Role.WORKPIECE and not cell.base_follows_table for j in cell.joints])
