"""What happens, in order: the vocabulary in which a CL file and a robot program are compared.

Both readers tell a story of motions (columns, one row a motion) and of events between them. Lengths are in metres, speeds in
m/s, times in seconds; angles of axes are left in degrees (mm for sliding axes), as cell.toml and KRL have them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["Event", "Gap", "Kind", "Load", "Objection", "Path", "Pecks", "Run", "Stand", "Story", "Way"]

Array = NDArray[np.float64]


class Kind(StrEnum):
    """What an event is."""

    SPINDLE_ON = "spindle on"  # value: rev/min, text: "CLW" (clockwise, M3) or "CCLW" (M4)
    SPINDLE_OFF = "spindle off"
    COOLANT_ON = "coolant on"  # text: "FLOOD", "MIST", ... or "" where the file says only on
    COOLANT_OFF = "coolant off"
    TOOL = "tool"  # another tool is mounted than before; value: its number (0: it has none), text: its name
    DWELL = "dwell"  # value: seconds
    STOP = "stop"  # the operator continues
    OUTPUT = "output"  # programs only: an output or signal that no hook of the cell accounts for; text: the statement


class Way(IntEnum):
    """How a motion of a CL file is made."""

    RAPID = 0  # through air
    FEED = 1  # cutting, at `feed`
    HOLE = 2  # drilling: from the clear point down the tool's axis to the bottom, at `feed`, with pecks or without


@dataclass(frozen=True, slots=True)
class Event:
    """Happens before motion `before` (n: after the last) and after the motion before that one."""

    before: int
    kind: Kind
    value: float = 0.0
    text: str = ""
    line: int = 0
    file: int = 0


@dataclass(frozen=True, slots=True)
class Gap:
    """A stretch of the CL file, or statements of the program, that could not be read; it lies before motion `before`."""

    before: int
    first_line: int
    last_line: int
    text: str  # one line: what it is, and why it is not judged
    file: int = 0
    of_load: bool = False  # a `$LOAD`, which who knows the set-up can judge


@dataclass(frozen=True, slots=True)
class Load:
    """What a program says before its motion `before` of what hangs on the flange.

    values: (10,) the mass in kg, its centre X, Y, Z in mm, A, B, C in degrees, its inertia X, Y, Z in kg m2, NaN where the text
    doesn't say; None where the controller's own holds again.
    """

    before: int
    values: tuple[float, ...] | None
    line: int
    file: int = 0


@dataclass(frozen=True, slots=True)
class Stand:
    """Before motion `before`, a cut, the file only says where the tool stands (FROM): tip (3,) m, axis (3,) unit."""

    before: int
    tip: Array
    axis: Array
    line: int


@dataclass(frozen=True, slots=True)
class Objection:
    """Something that stands against a program. `code` is stable, kebab-case; `text` one line for a person.

    cl_line, line: of the CL file, of the program (0: none); file: index into `Run.files`. severity: "error" or "warning".
    """

    code: str
    text: str
    cl_line: int = 0
    line: int = 0
    file: int = 0
    axis: str = ""
    value: float | None = None
    limit: float | None = None
    unit: str = ""
    severity: str = "error"


@dataclass(slots=True)
class Path:
    """The motions of a story, column by column; row i is the motion that ends at `tip[i]`.

    tip: (N, 3) m; axis: (N, 3) unit, from the tip to the holder. center, normal: (N, 3) m and unit, angle: (N,) rad > 0 of
    motions on a circle (right-handed about `normal`, 2 pi a full turn, more for several; an axial rise along `normal` makes a
    helix); angle is NaN for a straight motion, and 0 for one that is a piece of a curve given in small steps (a program may
    leave it by chords as it does a circle). line: (N,) 1-based line of the text.
    The tool's axis turns along the great arc from the motion's start to its end.
    """

    tip: Array
    axis: Array
    center: Array
    normal: Array
    angle: Array
    line: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.tip)


class Pecks(NamedTuple):
    """How far the first peck of a hole may go, m from the start of its motion, and every other one, m from where the tool was.

    out: between two of them the tool is drawn back to where the motion starts, so that it takes the chips out; `breaks` of them
    in a row may break the chip in the hole before that. lows: where they differ, how far below its start each may reach, the
    last one to the bottom. fed: the tool is drawn out no faster than by the motion behind the hole's. lift: how far, m, it is
    drawn back where the chip is broken, no further than to where the motion starts; None where the file doesn't say.
    entry: the first peck's feed, m/s, None where it is the others'.
    """

    first: float
    others: float
    out: bool
    lows: tuple[float, ...] = ()
    breaks: int = 0
    fed: bool = False
    lift: float | None = None
    entry: float | None = None

    def deepest(self, n: int) -> float:
        """How far the n-th peck (from 0) may go at once, and none may go beyond `low`, m."""
        if self.lows:
            n = min(n, len(self.lows) - 1)
            return self.lows[n] - (self.lows[n - 1] if n else 0.0)
        return self.others if n else self.first

    def low(self, n: int) -> float:
        """How far below the motion's start the n-th peck (from 0) may reach, m."""
        return self.lows[min(n, len(self.lows) - 1)] if self.lows else math.inf


@dataclass(slots=True)
class Story:
    """What a CL file asks for, in the part's frame (the CL data's own, after MSYS and the like).

    way: (N,) `Way`. feed: (N,) m/s, NaN for RAPID and where the file states none. joined: (N,) True where the motion begins at
    the end of the one before it; False for the first (unless FROM says where the tool stands), after a machine position (G28) and
    after a gap, where the start is not known in the part's frame. operation: (N,) index of the operation, counted from 0.
    gaps: what was not read; `complete` is True where there are none. pecks: of holes that are to be drilled in pecks, by row.
    """

    path: Path
    way: NDArray[np.int8]
    feed: Array
    joined: NDArray[np.bool_]
    operation: NDArray[np.int32]
    events: tuple[Event, ...]
    gaps: tuple[Gap, ...]
    dialect: str = ""
    units: str = "mm"
    notes: tuple[str, ...] = ()  # choices that the file left open, one line each
    stands: tuple[Stand, ...] = ()
    pecks: Mapping[int, Pecks] = field(default_factory=dict)

    @property
    def complete(self) -> bool:
        """True where all of the file was read."""
        return not self.gaps

    def __len__(self) -> int:
        return len(self.path)


@dataclass(slots=True)
class Run:
    """What a controller would do with a program, from the first statement to the last; tip and axis in `base`.

    The tip and axis are where the tool really is: by the `$TOOL` and `$BASE` that the text sets, of PTP by axes by the cell's
    kinematics. ptp: (M,) True for point-to-point motions (whose way between is not a line). speed: (M,) m/s that `$VEL.CP` gives
    a LIN or CIRC, NaN for PTP and where the text states none. exact: (M,) True where the robot stops exactly at the end, False
    where it may round the corner. tool: (M,) index into `tools` (flange_T_tool, (4, 4) each). axes: (M, n) axis values at the
    end, degrees and mm in the order of `axis_names`, NaN where they could not be worked out. file: (M,) index into `files`.
    events: in the order of the text, hooks of the cell recognised as what they stand for. objections: what is wrong with the
    program by itself (limits, reach, Status and Turn, singular postures, frames). gaps: statements that are not understood.
    conduct, unsettled: the same of how it moves besides, and whether it does the same on every run. loads: in their order.
    """

    path: Path
    ptp: NDArray[np.bool_]
    speed: Array
    exact: NDArray[np.bool_]
    tool: NDArray[np.int32]
    tools: tuple[Array, ...]
    axes: Array
    axis_names: tuple[str, ...]
    file: NDArray[np.int32]
    files: tuple[str, ...]
    events: tuple[Event, ...]
    gaps: tuple[Gap, ...]
    objections: tuple[Objection, ...] = field(default=())
    conduct: tuple[Objection, ...] = field(default=())
    unsettled: tuple[Gap, ...] = field(default=())
    loads: tuple[Load, ...] = field(default=())

    def __len__(self) -> int:
        return len(self.path)
