"""Logs as their recorders wrote them, put right before anything is compared: rows that are old, clocks apart, late encoders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from camrob.cell.cell import Cell
from camrob.gap.observation.fresh_rows import fresh_rows
from camrob.gap.observation.late_clock import brought_together
from camrob.gap.observation.late_rows import rows_in_time
from camrob.gap.observation.mistakes.alternating import alternating
from camrob.measurement.log import MeasurementLog

__all__ = ["Recorded", "as_recorded"]


@dataclass(frozen=True, slots=True)
class Recorded:
    """Logs put right; delays: s by which each one's readings came late, 0 where they did not; said: what was done besides, in
    words.
    """

    logs: tuple[MeasurementLog, ...]
    delays: tuple[float, ...]
    said: tuple[str, ...]


def as_recorded(logs: Sequence[MeasurementLog], cells: Sequence[Cell]) -> Recorded:
    """Logs with what their recorders mixed up taken off."""
    fresh = [fresh_rows(log, cell) for log, cell in zip(logs, cells, strict=True)]
    timed = [rows_in_time(log, cell) for (log, _), cell in zip(fresh, cells, strict=True)]
    clock = brought_together([log for log, _ in timed], cells)
    beside = [("", alternating(log, cell)) for log, cell in zip(clock.logs, cells, strict=True)]
    said = tuple(words for _, words in (*fresh, *timed, *beside) if words)
    return Recorded(clock.logs, clock.delays, said)
