"""What `camrob simulate` says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.summaries.base import Summary
from camrob.summaries.feed_figures import BlockTime
from camrob.summaries.remarks import Approximated, Remark

__all__ = ["LimitShares", "LostByCause", "SimulateSeconds", "SimulateSummary"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitShares(Summary):
    """The share of its limits that each axis takes at most, and the limits that are reached."""

    speed_share_max: Mapping[str, float]
    acceleration_share_max: Mapping[str, float]
    reached: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class LostByCause(Summary):
    """s that the run takes longer than at the programmed speed throughout, and what holds it back."""

    lost_s: float
    by_cause: Mapping[str, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulateSeconds(Summary):
    """How long the stages took."""

    read: float
    simulate: float
    write: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulateSummary(Summary):
    """A program's run on the ideal controller; blocks: of its lines and arcs, None where the cell has no `block_ms`."""

    program: str
    cell: str
    files: tuple[str, ...]
    motions: int
    rows: int
    cycle_ms: float
    duration_s: float
    approximation: Approximated
    limits: LimitShares
    feed: LostByCause
    blocks: BlockTime | None
    warnings: tuple[Remark, ...]
    seconds: SimulateSeconds
