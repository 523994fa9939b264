"""The motions of a run, column by column, as its text has them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["AXES", "CIRC", "LIN", "POSE", "Columns", "Motions"]

Array = NDArray[np.float64]

AXES, POSE, LIN, CIRC = range(4)  # PTP by axes, PTP by pose, and the two that follow a path


@dataclass(slots=True)
class Motions:
    """All motions, column by column, as the text has them; one row a motion.

    how: (M,). pose: (M, 6) X..C in mm and degrees in `bases[base]`, NaN of AXES. middle: (M, 3) mm, a CIRC's auxiliary point.
    sweep: (M,) degrees, a CIRC's CA. axes: (M, n), of AXES NaN where a value is kept, else the external axes alone. status,
    turn: (M,) -1 where left out. constant: (M,) the tool doesn't turn. exact: (M,) no corner is rounded.
    """

    how: NDArray[np.int8]
    pose: Array
    middle: Array
    sweep: Array
    axes: Array
    status: NDArray[np.int64]
    turn: NDArray[np.int64]
    base: NDArray[np.int32]
    tool: NDArray[np.int32]
    constant: NDArray[np.bool_]
    speed: Array
    exact: NDArray[np.bool_]
    line: NDArray[np.int64]
    file: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.how)


Single = tuple[int, list[float], list[float], float, list[float], int, int, int, int, bool, float, bool, int, int]
_TYPES = (
    np.int8,
    float,
    float,
    float,
    float,
    np.int64,
    np.int64,
    np.int32,
    np.int32,
    bool,
    float,
    bool,
    np.int64,
    np.int32,
)


class Columns:
    """Collects motions one by one and row by row."""

    def __init__(self, axes: int) -> None:
        self.widths = {1: 6, 2: 3, 4: axes}
        self.singles: list[Single] = []
        self.chunks: list[list[NDArray[np.generic]]] = []
        self.count = 0

    def add(self, single: Single) -> None:
        """One motion."""
        self.singles.append(single)
        self.count += 1

    def add_rows(self, columns: list[NDArray[np.generic]]) -> None:
        """Motions that are columns already, in the order of `Motions`."""
        self.close()
        self.chunks.append(columns)
        self.count += len(columns[0])

    def close(self) -> None:
        """Turns the single motions so far into columns."""
        if self.singles:
            columns = zip(*self.singles, strict=True)
            self.chunks.append([np.array(column, dtype=kind) for column, kind in zip(columns, _TYPES, strict=True)])
            self.singles = []

    def motions(self, most: int | None = None) -> Motions:
        """All of them, or the first ones."""
        self.close()
        if not self.chunks:
            shapes = [(0, self.widths[k]) if k in self.widths else (0,) for k in range(len(_TYPES))]
            return Motions(*(np.empty(shape, dtype=kind) for shape, kind in zip(shapes, _TYPES, strict=True)))
        return Motions(*(np.concatenate(column)[:most] for column in zip(*self.chunks, strict=True)))
