"""A robot program between solver and language: motions as arrays, what happens between them as events.

Units here are those of the trade: millimetres, degrees, m/s, seconds. Values are already rounded to the decimals that the
program's language prints.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked

__all__ = ["Program", "ProgramEvent", "ProgramEventKind"]


class ProgramEventKind(StrEnum):
    """What is written before a motion."""

    HOOK = "hook"  # text: name of one of the cell's hooks, value: the number that its template prints
    COMMENT = "comment"  # text of any origin: it never does anything
    DWELL = "dwell"  # value: seconds
    REGION = "region"  # text: title of the region that begins here; empty: the region before ends
    TOOL = "tool"  # value: index into the program's `tools`, which is mounted from here on
    LOAD = "load"  # value: index into the program's `loads`, which hangs on the flange from here on


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
    order of `external_names`. status, turn: (N,) the arm's branch and turns, as the
    language counts them (used where kind is PTP_POSE). speed: (N,) m/s of the TCP
    for LIN and CIRC (0 for PTP). approximate: (N,) bool, rounded off from a distance on. line: (N,) CL source line (0 =
    camrob's own). region: (N,) index, -1 for motions outside of regions. safe: (N,) bool, the tool is at a safe retract, so that
    a sub-program may end after this motion.
    tool, base: X, Y, Z, A, B, C of the tool, and of the base (relative to the table where `base_follows_table`). tools: (T, 6)
    further tools, which events mount on the way. loads: (L, 7) mass in kg, its centre X, Y, Z in `flange` in mm and its
    moments about X, Y, Z there in kg m^2, which events set; without any the controller's load data stay as they are.
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
    tools: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 6)))
    loads: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 7)))

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
            ("tools", (None, 6), np.float64),
            ("loads", (None, 7), np.float64),
            ("base", (6,), np.float64),
        ):
            object.__setattr__(self, name, locked(getattr(self, name), shape=shape, dtype=dtype, name=name))

    def __len__(self) -> int:
        return len(self.kind)

    @property
    def mounted(self) -> NDArray[np.float64]:
        """(N, 6) the tool that each motion is made with."""
        out = np.tile(self.tool, (len(self), 1))
        for event in self.events:
            if event.kind is ProgramEventKind.TOOL:
                out[event.motion :] = self.tools[int(event.value)]
        return out
