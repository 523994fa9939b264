"""An instrument, or its target, that was moved between two rows of a log: nearly all of the gap is one shift, from there on."""

from __future__ import annotations

from camrob.calibration.cautions import move_words, step_of
from camrob.cell.cell import Cell
from camrob.gap.long_logs import shortened
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog

__all__ = ["moved_instrument"]

_LEAST = 12  # rows


def moved_instrument(log: MeasurementLog, cell: Cell) -> str:
    """In words, from which line on a log's readings lie elsewhere, and what to do; "" where its gap is no such one."""
    if not log.has_position or log.sees_part or not log.has_axes(cell.axis_names):
        return ""
    part = shortened([log])[0]
    if part.complete(part.place_names).sum() < _LEAST:
        return ""
    scene = make_scene(part, cell, least=_LEAST)
    step = step_of(scene.tcp_gap[:, :3])
    if step is None:
        return ""
    what, hint = move_words(step[1])
    line = "" if scene.log.file_lines is None else f"line {scene.log.file_lines[step[0]]} of "
    return f"from {line}{scene.name} on, {what}: {hint}"
