"""Set-points or encoder values that a recorder renews in every k-th row alone: the rows in which they are new stand for all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.measurement.log import MeasurementLog

__all__ = ["fresh_rows"]

Array = NDArray[np.float64]

_LEAST = 30  # times that values are renewed
_MOST = 50  # rows from one to the next
_ALIKE = 0.9  # of them that are as many rows apart as the most are
_RESTS = 3  # times as many: nothing moves there, and old values are as good as new ones
_QUANTA = 5.0  # of its smallest step that a renewed value goes: an encoder that counts its steps slowly goes one


def fresh_rows(log: MeasurementLog, cell: Cell) -> tuple[MeasurementLog, str]:
    """A log's rows in which all that the controller says is new, and what is to be said of that; itself and "" for others.

    Values that stay for some rows while the arm moves are those of a time before, and would be taken for a lag of the drives.
    """
    keep, said = np.ones(len(log), bool), []
    for kind, words in (("c", "set-points"), ("", "encoder values")):
        names = [f"{kind}{a}" for a in cell.axis_names]
        if log.info.poses or not log.has(*names) or len(log) < _LEAST:
            continue
        every, new = _renewed(log.matrix(names))
        if every > 1:
            keep &= new
            said.append(f"{words} are new in one row of {every} alone")
    if not said or keep.sum() < _LEAST:
        return log, ""
    name = log.name
    return log.select(
        np.flatnonzero(keep)
    ), f"{name}: its {' and its '.join(said)}, so that those {keep.sum()} rows stand for all"


def _renewed(values: Array) -> tuple[int, NDArray[np.bool_]]:
    """In every how many-th row values (N, k) are new, 1 where in no regular way, and (N,) True where they are, or rest."""
    jump = np.abs(np.diff(values, axis=0))
    at = np.flatnonzero((jump > 0.0).any(axis=1)) + 1
    apart = np.diff(at)
    often = apart[apart <= _MOST]
    new = np.ones(len(values), bool)
    if len(often) < _LEAST:
        return 1, new
    every = int(np.bincount(often).argmax())
    regular = often[often <= _RESTS * every]
    slack = 1 if every > 3 else 0  # clocks of two recorders drift
    if every == 1 or np.mean(np.abs(regular - every) <= slack) < _ALIKE or not _far(jump):
        return 1, new
    new[:] = False
    new[at] = True
    for first, last in zip(at, [*at[1:], len(values)], strict=True):
        if last - first > _RESTS * every:
            new[first : last - every] = True  # behind, it may move already
    return every, new


def _far(jump: Array) -> bool:
    """Whether values that are renewed go many of their own smallest steps."""
    moved = [j[j > 0.0] for j in jump.T if (j > 0.0).any()]
    return any(float(np.median(j)) > _QUANTA * float(j.min()) for j in moved)
