"""Feed and torques of a post: what a program takes, where it falls short of its feed and why, what it asks of the drives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.summaries.base import Summary, keyed, left_out

__all__ = [
    "AxisTorque",
    "BlockTime",
    "Breaks",
    "FeedFigures",
    "HeldToTolerance",
    "LimitUse",
    "LostFeed",
    "TimeUnderLimits",
    "Torques",
    "WrittenFeedFigures",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class LostFeed(Summary):
    """A stretch that stays below the programmed feed, and what holds it back; axis: "" for the tool or a corner."""

    first_line: int
    last_line: int
    axis: str
    cause: str
    feed_mm_min: float
    reached_mm_min: float
    lost_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeUnderLimits(Summary):
    """The program's time and the planned one (None without a plan) under the same limits.

    override_percent_least: what a cut has to be slowed to so that the program as it stands keeps them.
    """

    limits: str
    program_s: float
    planned_s: float | None
    override_percent_least: float | None = left_out()


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitUse(Summary):
    """Where a program takes most of the limits on a quantity: how many times the limit, and of what."""

    quantity: str
    times_the_limit: float
    cause: str
    axis: str
    line: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Breaks(Summary):
    """The share of the cutting that passes a limit, and the place of most use of each."""

    percent_of_cutting: float
    worst: tuple[LimitUse, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class WrittenFeedFigures(Summary):
    """The program with the planned feed, as the controller's model runs it."""

    model_s: float
    points_added: int
    percent_of_cutting: float
    worst: tuple[LimitUse, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldToTolerance(Summary):
    """The feed held to the set-up's tolerance: the most that the machine's speed carries the tool off across its way while
    cutting, at the programmed feed and as written, and the CL line of the latter; how much of the cutting is slowed, and the
    slowest of it (None where nothing had to be).
    """

    tolerance_mm: float
    off_before_mm: float
    off_mm: float
    line: int
    slowed_percent: float
    slowest_mm_min: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockTime(Summary):
    """The controller's least time for a motion: how many motions there are (of the cutting; of a program that is read, along
    lines and arcs), how many of them would take less at the programmed feed and are run slower, and what the shortest would take.
    """

    block_ms: float
    motions: int
    short: int
    shortest_ms: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FeedFigures(Summary):
    """How far the programmed feed is held, what is lost and to what, and the limits that are taken and passed.

    lost_by_axis_s: the axis that lost most first, "none" for stops and corners, "tolerance" for what it took to
    hold it, "block time" for motions shorter than the controller takes for one. losses: the dearest ones. planned_uses: the
    largest share of the limits on speed, acceleration and jerk that the plan takes; None without one. fastest_cut_mm_min: left
    out where rapids are lines no faster than that.
    """

    mode: str
    kept_percent: float
    lost_s: float
    lost_by_axis_s: Mapping[str, float]
    losses_count: int
    losses: tuple[LostFeed, ...]
    compared: tuple[TimeUnderLimits, ...]
    program_breaks: Breaks
    planned_uses: Mapping[str, float] | None
    written: WrittenFeedFigures | None = left_out()
    tolerance: HeldToTolerance | None = left_out()
    blocks: BlockTime | None = left_out()
    fastest_cut_mm_min: float | None = left_out()


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisTorque(Summary):
    """The largest torque (Nm) of a turning axis, or force (N) of a sliding one, gravity's part, and the line of the largest."""

    max_n: float | None = left_out()
    gravity_max_n: float | None = left_out()
    max_nm: float | None = left_out()
    gravity_max_nm: float | None = left_out()
    line: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Torques(Summary):
    """What the drives have to give, with the masses that it rests on."""

    masses: tuple[str, ...]
    provenance: str = keyed("standing")
    axes: Mapping[str, AxisTorque]
