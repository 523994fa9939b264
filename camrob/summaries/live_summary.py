"""What `camrob tracker --listen` says of a session: how it ended, and what it counted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.summaries.base import Summary, keyed
from camrob.summaries.remarks import Remark

__all__ = [
    "AnswerTimes",
    "CorrectionFigures",
    "FrameCounts",
    "InstrumentClock",
    "MeasurementCounts",
    "Percentiles",
    "Stopped",
    "TrackLiveSummary",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Stopped(Summary):
    """Why a session answers no more; fault: the robot was stopped by it."""

    code: str
    text: str
    fault: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameCounts(Summary):
    """The controller's frames; refused: by reason."""

    received: int
    answered: int
    unanswered_after_stop: int
    answered_late: int
    late_arrivals: int
    missed: int
    duplicate: int
    out_of_order: int
    other_sender: int
    not_allowed: int
    held_stale: int
    held_implausible: int
    held_faulty: int
    refused: Mapping[str, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasurementCounts(Summary):
    """The instrument's measurements; refused: by reason."""

    received: int
    kept: int
    other_sender: int
    not_allowed: int
    refused: Mapping[str, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class CorrectionFigures(Summary):
    """The correction at the end, its largest increments, and the cycles in which it was at its limit."""

    total_mm: tuple[float, ...]
    total_deg: tuple[float, ...]
    largest_mm: tuple[float, ...]
    largest_deg: tuple[float, ...]
    saturated_cycles: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Percentiles(Summary):
    """Of times in ms; None where there are none."""

    p50: float | None
    p95: float | None
    p99: float | None
    max: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class AnswerTimes(Summary):
    """How long answers took, ms; source: the stamps that tell, "kernel" or "process"."""

    p50: float | None
    p95: float | None
    p99: float | None
    max: float | None
    source: str = keyed("from")


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentClock(Summary):
    """The instrument's clock, "own" or "shared", and the drift that was forgiven."""

    kind: str
    drift_forgiven_ms: float


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackLiveSummary(Summary):
    """A session. controller, instrument: their addresses, None for one that never spoke. strangers: datagrams by sender.

    within_cycle: the share of answers within their cycle, None without any.
    """

    mode: str
    gain: float
    cycle_ms: float
    controller: str | None
    instrument: str | None
    strangers: Mapping[str, int]
    stopped: Stopped
    frames: FrameCounts
    measurements: MeasurementCounts
    correction: CorrectionFigures
    latency_ms: AnswerTimes
    within_cycle: float | None
    interval_ms: Percentiles
    measurement_age_ms: Percentiles
    instrument_clock: InstrumentClock
    rows: int
    rows_dropped: int
    seconds: float
    warnings: tuple[Remark, ...]
