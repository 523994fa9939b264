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

    @property
    def points(self) -> int | None:
        """CL points, or motions where its verb counts those; None where it says neither."""
        found = self._within("points") or self._within("motions")
        return found if isinstance(found, int) else None

    @property
    def lowest_inv_kf(self) -> float | None:
        """The lowest 1/k_F; None where its verb says none."""
        found = self._within("conditioning", "inv_kf_min")
        return found if isinstance(found, float) else None

    @property
    def least_margin(self) -> tuple[float, str] | None:
        """How near an axis comes to a limit, in its own unit, and which; None where its verb says none."""
        margins = self._within("limits", "margin_min")
        found = margins.items() if isinstance(margins, Mapping) else ()
        return min(((value, axis) for axis, value in found if isinstance(value, float)), default=None)

    @property
    def program_s(self) -> float | None:
        """s that the program takes at the programmed feed; None where its verb says none."""
        found = self._within("time_s", "program")
        return float(found) if isinstance(found, int | float) else None

    @property
    def warned(self) -> int | None:
        """How many kinds of warnings there are; None where its verb says none."""
        found = self._within("warnings")
        return len(found) if isinstance(found, list | tuple) else None

    @property
    def against(self) -> tuple[str, ...]:
        """Why it is not done, or what a check found, with lines; () where it is done."""
        if self.error:
            return (self.error,)
        errors = self._within("errors") or ()
        said = [(str(e.get("text", "")), e.get("line")) for e in errors if isinstance(e, Mapping)]
        texts = [text if not line or f"line {line}" in text else f"line {line}: {text}" for text, line in said]
        return tuple(texts or ["a check failed"]) if self.status else ()

    def _within(self, *keys: str) -> Any:
        """What its verb's summary has there, None for nothing."""
        found: Any = self.summary
        for key in keys:
            found = found.get(key) if isinstance(found, Mapping) else None
        return found


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
