"""What `camrob feed` says of a path's derivatives, and `camrob study weld` of a seam."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.summaries.base import Summary, left_out

__all__ = [
    "FILES",
    "DerivativeFigures",
    "DerivativeSummary",
    "FeedSummary",
    "KindFigures",
    "OptimumFigures",
    "PassedBound",
    "SchemeFigures",
    "SeamFigures",
    "StatementFigures",
    "UniformFeed",
    "WeldSummary",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class StatementFigures(Summary):
    """What a paper states, what was found, and the verdict: holds, does not hold, unclear."""

    published: str
    found: str
    verdict: str


@dataclass(frozen=True, slots=True, kw_only=True)
class KindFigures(Summary):
    """A figure for each kind of limit: speed, acceleration and jerk."""

    speed: float
    acceleration: float
    jerk: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PassedBound(Summary):
    """A stretch that passes a bound: how many times at its worst, at which displacement (rad), and the line there."""

    axis: str
    quantity: str
    s: float
    line: int
    times: float


@dataclass(frozen=True, slots=True, kw_only=True)
class DerivativeFigures(Summary):
    """Coordinates under an interpolation: the least ds/dt that limits admit, rad/s, and the stretches that pass one."""

    interpolation: str
    coordinates: str
    rate_admitted: KindFigures
    violations: int
    worst: tuple[PassedBound, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class DerivativeSummary(Summary):
    """The derivatives of a path's coordinates; line_counts: what a `line` is, "line" or "point"."""

    cell: str
    sources: tuple[str, ...]
    displacement_rad: float
    rate_rad_s: float
    analyses: tuple[DerivativeFigures, ...]
    line_counts: str
    statements: tuple[StatementFigures, ...] | None = left_out()
    files: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SeamFigures(Summary):
    """The seam's length, and how far its postures miss it."""

    length_mm: float
    position_error_mm_max: float


@dataclass(frozen=True, slots=True, kw_only=True)
class UniformFeed(Summary):
    """The published scheme: its feed from the lowest to the highest, its time, and the share of each limit that it uses."""

    feed_m_s: tuple[float, float]
    time_s: float
    use: KindFigures


@dataclass(frozen=True, slots=True, kw_only=True)
class OptimumFigures(Summary):
    """An optimum: its time, and the share of each limit that it uses."""

    time_s: float
    use: KindFigures


@dataclass(frozen=True, slots=True, kw_only=True)
class SchemeFigures(Summary):
    """A scheme with its highest feed, beside the optimum in motion and from rest to rest."""

    feed_top_m_s: float
    published: UniformFeed
    optimum_moving: OptimumFigures
    optimum_resting: OptimumFigures


@dataclass(frozen=True, slots=True, kw_only=True)
class WeldSummary(Summary):
    """The study of a weld seam; constant_feed_m_s: the highest constant feed that each kind of limit allows."""

    cell: str
    seam: SeamFigures
    constant_feed_m_s: KindFigures
    schemes: tuple[SchemeFigures, ...]
    torque_max_nm: Mapping[str, float]
    gravity_max_nm: Mapping[str, float]
    statements: tuple[StatementFigures, ...]
    files: tuple[str, ...]


FeedSummary = DerivativeSummary | WeldSummary
"""What `camrob feed` says, and the studies of the papers' feeds."""

FILES = ("feed.html", "feed.json")
"""What is written of either."""
