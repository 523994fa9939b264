"""What `camrob regress` says."""

from __future__ import annotations

from dataclasses import dataclass

from camrob.summaries.base import Summary

__all__ = ["RegressSummary", "SampleFigures"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleFigures(Summary):
    """A sample: what differs from its golden files, how many numbers were rounded the other way; points: None where it can't
    be posted.
    """

    part: str
    ok: bool
    points: int | None
    differences: tuple[str, ...]
    rounded: int
    seconds: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RegressSummary(Summary):
    """The samples; updated: what came out now is golden."""

    ok: bool
    cell: str
    updated: bool
    samples: tuple[SampleFigures, ...]
