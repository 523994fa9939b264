"""What a diagnosis says of the instrument: how likely it errs itself, and which of its rows are gross."""

from __future__ import annotations

from dataclasses import dataclass

from camrob.summaries.base import OpenSummary

__all__ = ["GrossRow", "GrossRows", "InstrumentSuspect"]


@dataclass(frozen=True, slots=True, kw_only=True)
class GrossRow(OpenSummary):
    """A row, counted from 1, that stands far from all others, and how far."""

    sample: int
    t_s: float
    off_mm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class GrossRows(OpenSummary):
    """How many rows of a log take no part because they are gross, which share of it, and the first of them."""

    log: str
    rows: int
    share: float
    first: tuple[GrossRow, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentSuspect(OpenSummary):
    """How likely an error of the instrument is at work, its scale and drift as fitted (None where not), and gross rows."""

    suspect: float
    scale_ppm: float | None
    drift_mm: float | None
    gross: tuple[GrossRows, ...]
    text: str
