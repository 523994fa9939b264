"""The time that a controller takes for a motion at the least: shorter ones are run slower than programmed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.controller.interpolate import PTP, Pieces
from camrob.controller.layout import Layout
from camrob.controller.motion_settings import MotionSettings
from camrob.units import ms_to_s

__all__ = ["LEAST_TIME", "ShortBlocks", "block_ceilings_of", "joined_blocks", "short_blocks"]

Array = NDArray[np.float64]

LEAST_TIME = "block time"
"""What holds the tool back where motions are shorter than the controller takes for one."""


@dataclass(frozen=True, slots=True)
class ShortBlocks:
    """Motions along lines and arcs: how many, how many of them would take less than `block` s as programmed, the shortest, s."""

    block: float
    count: int
    short: int
    shortest: float


def _ceilings(cell: Cell, layout: Layout) -> Array:
    """Speed along the path (M,) above which a motion would take less than the cell's `block_ms`; none for PTP."""
    block = ms_to_s(cell.controller.block_ms)
    if block <= 0.0:
        return np.full(len(layout.motions.kind), np.inf)
    return np.where(layout.motions.kind == PTP, np.inf, np.asarray(layout.motions.size) / block)


def block_ceilings_of(cell: Cell, layout: Layout, pieces: Pieces) -> Array:
    """Speeds along the path (P,) of the pieces, a rounding's by both its motions."""
    own, m = _ceilings(cell, layout), pieces.motion
    after = np.minimum(m + 1, len(own) - 1)
    return np.where(pieces.blend > 0.0, np.minimum(own[m], own[after]), own[m])


def short_blocks(cell: Cell, layout: Layout, settings: MotionSettings) -> ShortBlocks | None:
    """The motions that lead the tool anywhere, by the time that the program leaves them; None without a block time."""
    block = ms_to_s(cell.controller.block_ms)
    if block <= 0.0:
        return None
    counts = (layout.motions.kind != PTP) & (layout.length > 0.0)
    seconds = np.asarray(layout.length)[counts] / settings.speed[layout.row[1:]][counts]
    short = int(np.sum(seconds < block))
    return ShortBlocks(block, len(seconds), short, float(seconds.min(initial=np.inf)) if len(seconds) else 0.0)


def joined_blocks(found: Sequence[ShortBlocks | None]) -> ShortBlocks | None:
    """Those of several runs of one controller; None without a block time."""
    known = [one for one in found if one is not None]
    if not known:
        return None
    shortest = min((one.shortest for one in known if one.count), default=0.0)
    return ShortBlocks(known[0].block, sum(one.count for one in known), sum(one.short for one in known), shortest)
