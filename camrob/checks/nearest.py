"""Which two bodies are nearest to each other in single postures, for pictures: the check itself follows the whole way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.bodies import Body
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.setup import ToolSetup
from camrob.checks.rooms import nearest_pairs

__all__ = ["Nearest", "nearest_bodies"]

Array = NDArray[np.float64]

_NEIGHBOURS = 2  # axes between two limbs of the arm that are near each other in every posture


@dataclass(frozen=True, slots=True)
class Nearest:
    """pairs: two bodies' names each; pair (K,): which of them are nearest in a posture; distance (K,) m, 0 where they touch."""

    pairs: tuple[tuple[str, str], ...]
    pair: NDArray[np.int64]
    distance: Array


def nearest_bodies(
    cell: Cell,
    q: Array,
    *,
    part_mesh: Array | None = None,
    stock_mesh: Array | None = None,
    base_T_part: Array | None = None,
    tool: ToolSetup | None = None,
) -> Nearest | None:
    """The nearest two of the bodies that `check_collisions` follows, in postures q (K, n); None where it follows none.

    The tool beside part and stock is left out, as it cuts them, and so are limbs next to each other: the check follows them, but
    how near they always are tells nothing. Meshes, pose and tool as there. Raises CellError for a mesh of
    the cell that can't be read.
    """
    arm = cell.indices(Role.ARM)
    names, pair, distance = nearest_pairs(
        cell,
        q,
        part_mesh=part_mesh,
        stock_mesh=stock_mesh,
        base_T_part=base_T_part,
        tool=tool,
        keep=lambda one, other: not _neighbours(one, other, arm),
    )
    return Nearest(names, pair, distance) if names and len(q) else None


def _neighbours(one: Body, other: Body, arm: Sequence[int]) -> bool:
    links = {one.link, other.link}
    return links <= set(arm) and max(links) - min(links) <= _NEIGHBOURS
