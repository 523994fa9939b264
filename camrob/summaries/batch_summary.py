"""What `camrob batch` says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from camrob.summaries.base import Summary

__all__ = ["BatchSummary", "JobFigures"]


@dataclass(frozen=True, slots=True, kw_only=True)
class JobFigures(Summary):
    """A job: its status and error, its files, and its own verb's summary as JSON; None where it has come to none."""

    index: int
    verb: str
    input: str
    out: str | None
    status: int
    error: str | None
    files: tuple[str, ...]
    attempts: int
    seconds: float
    summary: Mapping[str, Any] | None


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchSummary(Summary):
    """The jobs; status: the worst one's; counts: how many jobs by status; workers: None on a cluster, which `scheduler` names."""

    ok: bool
    status: int
    counts: Mapping[str, int]
    workers: int | None
    scheduler: str | None
    jobs: tuple[JobFigures, ...]
    seconds: float
