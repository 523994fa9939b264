"""Whether measured poses can calibrate a cell, asked as the diagnosis asks it, and why a fit of them ended where no robot is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camrob.cell.cell import Cell
from camrob.errors import LogError
from camrob.gap.long_logs import shortened
from camrob.gap.observation.believable import check_poses, mixed_up
from camrob.gap.observation.few_decimals import rounding_of
from camrob.gap.observation.scene import Scene, make_scene
from camrob.measurement.log import MeasurementLog
from camrob.units import deg_to_rad, m_to_mm

__all__ = ["check_measured", "coarse", "misfit"]

_APART = deg_to_rad(1.0)  # between two rows that are single poses, whatever the log says of it
_OF_REST = 0.5  # of what stays of a fit: then coarse steps are a cause of it


def check_measured(log: MeasurementLog, cell: Cell) -> None:
    """Raises LogError for readings that were taken of no new pose: of axes that stand still, frozen ones, zeros."""
    scene = _scene(log, cell)
    if scene is not None:
        check_poses(scene)


def misfit(log: MeasurementLog, cell: Cell) -> LogError | None:
    """What was mixed up in a log that no errors of the cell fit; None where its gap is an ordinary one, or nothing mends it."""
    scene = _scene(log, cell)
    return None if scene is None else mixed_up(scene, again="calibrate")


def coarse(log: MeasurementLog, cell: Cell, *, beside: float) -> tuple[str, ...]:
    """A sentence for each coarse step of a log's values that leaves more than a share of `beside`, m, which stays of a fit."""
    scene = _scene(log, cell)
    steps = [] if scene is None else rounding_of(scene)
    name = log.path.name if log.path else "the log"
    return tuple(
        f"{name}: {words}, which alone leaves {m_to_mm(size):.2g} mm rms at the tool: log more decimals"
        for words, size in steps
        if size > _OF_REST * beside
    )


def _scene(log: MeasurementLog, cell: Cell) -> Scene | None:
    """A log laid out, as single poses where it is; None where its rows are too few for that."""
    taken = shortened([log])[0]
    try:
        scene = make_scene(taken, cell, least=1)
        if scene.poses or np.median(np.abs(np.diff(scene.link, axis=0)).max(axis=1)) < _APART:
            return scene
        return make_scene(replace(taken, info=replace(taken.info, poses=True)), cell, least=1)
    except LogError:
        return None
