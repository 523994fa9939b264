"""Logs as their recorders wrote them, put right before anything is compared: rows that are old, clocks apart, late encoders."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from camrob.cell.cell import Cell
from camrob.errors import LogError
from camrob.gap.observation.fresh_rows import fresh_rows
from camrob.gap.observation.late_clock import brought_together
from camrob.gap.observation.late_rows import rows_in_time
from camrob.gap.observation.mistakes.alternating import alternating
from camrob.gap.observation.mistakes.moved_instrument import moved_instrument
from camrob.measurement.log import MeasurementLog

__all__ = ["Recorded", "as_recorded"]

_Answer = TypeVar("_Answer")

_READINGS = (alternating, moved_instrument)  # what is asked of readings


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
    timed = [_asked(rows_in_time, log, cell, (log, "")) for (log, _), cell in zip(fresh, cells, strict=True)]
    clock = brought_together([log for log, _ in timed], cells)
    beside = [_asked(ask, log, c, "") for log, c in zip(clock.logs, cells, strict=True) for ask in _READINGS]
    said = tuple(words for words in (*(w for _, w in (*fresh, *timed)), *beside) if words)
    return Recorded(clock.logs, clock.delays, said)


def _asked(
    ask: Callable[[MeasurementLog, Cell], _Answer], log: MeasurementLog, cell: Cell, otherwise: _Answer
) -> _Answer:
    """What is found of a log, `otherwise` where it can't be laid out: it is refused where it is."""
    try:
        return ask(log, cell)
    except LogError:
        return otherwise
