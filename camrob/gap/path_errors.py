"""What the pictures of a diagnosis are drawn from: errors without and with what is claimed, sample by sample."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.gap.diagnosis import PathError
from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import Model, whole_gap
from camrob.gap.evidence.shrink import Shrinkage, Trial, settled

__all__ = ["fitted_errors", "withheld_errors"]

Array = NDArray[np.float64]


def withheld_errors(trial: Trial, together: Shrinkage) -> tuple[PathError, ...]:
    """Log by log, in the logs' own order, the very residuals that the shrinkage `together` is measured on."""
    parts: dict[int, list[tuple[NDArray[np.int64], int]]] = {}
    start = 0
    for k, asked, _ in trial.asked:
        rows = np.flatnonzero(asked)
        parts.setdefault(k, []).append((rows, start))
        start += len(rows)
    out = []
    for k, own in sorted(parts.items()):
        rows = np.concatenate([r for r, _ in own])
        at = np.concatenate([first + np.arange(len(r)) for r, first in own])[np.argsort(rows)]
        out.append(_path(trial.panels[k], np.sort(rows), together.before[at], together.after[at]))
    return tuple(out)


def fitted_errors(model: Model, members: frozenset[int]) -> tuple[PathError, ...]:
    """Every fitted log, whole, without and with some units; frames that are not known are fitted anew to both."""
    values = model.values(members, model.best)
    out = []
    for p in model.panels:
        good = p.w_tcp[:, 0] > 0.0
        gap = whole_gap(p)[good]
        before, after = (settled(model, p, good, e) for e in (gap, gap - p.moves(values, good)))
        out.append(_path(p, np.flatnonzero(good), before, after))
    return tuple(out)


def _path(panel: Panel, rows: NDArray[np.int64], before: Array, after: Array) -> PathError:
    scene = panel.scene
    line = scene.log.line if scene.log.has("line") else np.zeros(len(scene), np.int64)
    position = scene.nominal[rows, :3, 3]
    return PathError(scene.name, position, before, after, scene.t[rows], line[rows], scene.poses)
