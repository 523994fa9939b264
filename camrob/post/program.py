"""A robot program between solver and dialect: motions as arrays, what happens between them as events.

Units here are those that KRL prints: millimetres, degrees, m/s, seconds. Values are already rounded to the printed decimals.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum, StrEnum

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked

__all__ = ["Motion", "Program", "ProgramEvent", "ProgramEventKind"]


class Motion(IntEnum):
    """The motion that ends at a point."""

    PTP_AXES = 0  # PTP {E6AXIS: A1 .., E1 ..}: `axes` holds the target
    PTP_POSE = 1  # PTP {E6POS: .., S, T, E1 ..}
    LIN = 2
    CIRC_VIA = 3  # auxiliary point of the CIRC that ends at the next row
    CIRC_END = 4


class ProgramEventKind(StrEnum):
    """What is written before a motion."""

    HOOK = "hook"  # text: name of one of the cell's hooks, value: the number that its template prints
    COMMENT = "comment"  # text of any origin: only ever after a semicolon
    DWELL = "dwell"  # value: seconds
    FOLD = "fold"  # text: title of the region that begins here; empty: the region before ends


@dataclass(frozen=True, slots=True)
class ProgramEvent:
    """Written just before motion `motion` (index; n = after the last one)."""

    motion: int
    kind: ProgramEventKind
    text: str = ""
    value: float = 0.0


@dataclass(frozen=True, slots=True)
class Program:
    """A program, ready to be printed.

    kind: (N,) `Motion`. pose: (N, 6) X, Y, Z, A, B, C in `base`. axes: (N, 6) A1..A6. external: (N, E) E1.. in the
    order of `external_names`. status, turn: (N,) S and T (used where kind is PTP_POSE). speed: (N,) m/s of the TCP
    for LIN and CIRC (0 for PTP). approximate: (N,) bool, C_DIS at the point. line: (N,) CL source line (0 = camrob's own).
    region: (N,) index, -1 for motions outside of regions. safe: (N,) bool, the tool is at a safe retract, so that a
    sub-program may end after this motion.
    tool, base: X, Y, Z, A, B, C of `$TOOL`, and of `$BASE` (relative to the table where `base_follows_table`).
    """

    name: str
    kind: NDArray[np.int8]
    pose: NDArray[np.float64]
    axes: NDArray[np.float64]
    external: NDArray[np.float64]
    external_names: tuple[str, ...]
    status: NDArray[np.int16]
    turn: NDArray[np.int16]
    speed: NDArray[np.float64]
    approximate: NDArray[np.bool_]
    line: NDArray[np.int64]
    region: NDArray[np.int32]
    safe: NDArray[np.bool_]
    tool: NDArray[np.float64]
    base: NDArray[np.float64]
    comment: tuple[str, ...] = ()
    events: tuple[ProgramEvent, ...] = field(default=())

    def __post_init__(self) -> None:
        kind = locked(self.kind, shape=(None,), dtype=np.int8, name="kind")
        n = len(kind)
        object.__setattr__(self, "kind", kind)
        for name, shape, dtype in (
            ("pose", (n, 6), np.float64),
            ("axes", (n, 6), np.float64),
            ("external", (n, len(self.external_names)), np.float64),
            ("status", (n,), np.int16),
            ("turn", (n,), np.int16),
            ("speed", (n,), np.float64),
            ("approximate", (n,), np.bool_),
            ("line", (n,), np.int64),
            ("region", (n,), np.int32),
            ("safe", (n,), np.bool_),
            ("tool", (6,), np.float64),
            ("base", (6,), np.float64),
        ):
            object.__setattr__(self, name, locked(getattr(self, name), shape=shape, dtype=dtype, name=name))

    def __len__(self) -> int:
        return len(self.kind)
