"""Machine tools: how rotary axes carry part and tool, for programs that name them.

X, Y and Z are where the tip would be with all rotary axes at zero, which is what a program without tool centre point names. The
head's axes turn the tool, and the table's turn the part.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.frozen import locked
from camrob.se3 import rotation_exp

__all__ = [
    "FEEDS",
    "TURNED",
    "Feed",
    "MachineTool",
    "RotaryAxis",
    "pieces",
    "placed",
    "reach",
    "rotary_axes",
    "unknown_axes",
]

Array = NDArray[np.float64]
Feed = Literal["", "linear", "all"]
FEEDS = ("linear", "all")
_UP = np.array([0.0, 0.0, 1.0])
TURNED = 1e-9  # rad: a rotary axis nearer to a whole turn than this counts as at zero
_MOST = 1 << 17  # pieces of one block


@dataclass(frozen=True, slots=True)
class RotaryAxis:
    """word: A, B or C. direction: (3,) unit, about which a positive word turns what the axis carries, right-handedly, all rotary
    axes at zero. point: (3,) m on the axis: of a table from the program's zero, of a head from the spindle's gauge line.
    """

    word: str
    direction: Array
    point: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "direction", locked(self.direction, shape=(3,), name="direction"))
        object.__setattr__(self, "point", locked(self.point, shape=(3,), name="point"))


@dataclass(frozen=True, slots=True)
class MachineTool:
    """table: the axes that carry the part, from the bed on; head: those that carry the tool, from the bed on.

    lengths: m from the gauge line to the tip by tool number (0: any). feed: what F counts in a block that turns rotary axes
    without tool centre point: "linear" axes alone, "all" with degrees as lengths, "" not known.
    """

    table: tuple[RotaryAxis, ...]
    head: tuple[RotaryAxis, ...]
    lengths: Mapping[int, float]
    feed: Feed = ""

    @property
    def words(self) -> frozenset[str]:
        """The letters of its rotary axes."""
        return frozenset(axis.word for axis in (*self.table, *self.head))

    @property
    def key(self) -> tuple[str | float | Array, ...]:
        """What it is, flat."""
        axes = [(kind, a.word, a.direction, a.point) for kind in ("table", "head") for a in getattr(self, kind)]
        lengths = [float(v) for pair in sorted(self.lengths.items()) for v in pair]
        return (self.feed, *(v for axis in axes for v in axis), *lengths)

    def length(self, tool: int) -> float | None:
        """Gauge line to tip, m; None where it is not known. A machine without a head needs none: 0."""
        return self.lengths.get(tool, self.lengths.get(0)) if self.head else 0.0


def rotary_axes(kinematics: str, angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit tool axes (N, 3) in the part's frame for rotary angles A, B, C (N, 3), rad.

    XYZAC: (sin A sin C, sin A cos C, cos A); XYZBC: (-sin B cos C, sin B sin C, cos B): LinuxCNC's table-table
    machines with the tool centre point on. Anything else is a three-axis machine: (0, 0, 1).
    """
    c = angles[:, 2]
    if kinematics == "xyzac":
        a = angles[:, 0]
        return np.stack((np.sin(a) * np.sin(c), np.sin(a) * np.cos(c), np.cos(a)), axis=1)
    if kinematics == "xyzbc":
        b = angles[:, 1]
        return np.stack((-np.sin(b) * np.cos(c), np.sin(b) * np.sin(c), np.cos(b)), axis=1)
    if kinematics == "unknown" and np.any(np.abs(np.sin(0.5 * angles)) > TURNED):
        raise unknown_axes()
    return np.broadcast_to(_UP, (len(angles), 3)).copy()


def unknown_axes() -> ToolpathError:
    """That nobody has said how the rotary axes turn, as an error to be raised."""
    return ToolpathError(
        "which way the rotary axes turn the tool is the machine's own, and the program doesn't say it",
        hint="--dialect gcode-xyzac-iso or gcode-xyzbc-iso (signs by ISO 841), gcode-xyzac or gcode-xyzbc (the table's own)"
        ", or post tool vectors",
    )


def reach(machine: MachineTool, tool: int) -> float:
    """From the gauge line to the tip, m. Raises ToolpathError where a head needs it and the machine's file doesn't give it."""
    length = machine.length(tool)
    if length is None:
        raise ToolpathError(
            f"the head turns tool {tool}, whose length from the gauge line the machine's file doesn't give",
            hint=f"add [{tool}, LENGTH] to its lengths_mm",
        )
    return length


def placed(machine: MachineTool, length: float, xyz: Array, angles: Array) -> tuple[Array, Array, Array]:
    """Tips (N, 3) m and tool axes (N, 3) in the part, and part_R_program (N, 3, 3), of X, Y, Z (N, 3) m and A, B, C (N, 3) rad.

    length: m from the gauge line to the tip.
    """
    head_R, head_p = _turned(machine.head, angles, length * _UP)
    part_R, part_p = _turned(machine.table, angles, np.zeros(3))
    back = np.swapaxes(part_R, -1, -2)
    tips = (back @ (xyz + head_p - part_p)[..., None])[..., 0]
    return tips, (back @ head_R)[..., 2], back


def _turned(axes: Sequence[RotaryAxis], angles: Array, lift: Array) -> tuple[Array, Array]:
    """Rotation (N, 3, 3) and translation (N, 3), m, of what the axes carry; lift: (3,) m, added to their points."""
    R, p = np.broadcast_to(np.eye(3), (len(angles), 3, 3)), np.zeros((len(angles), 3))
    for axis in axes:
        turn = rotation_exp(angles[:, "ABC".index(axis.word), None] * axis.direction)
        point = axis.point + lift
        p = p + (R @ (point - turn @ point)[..., None])[..., 0]
        R = R @ turn
    return R, p


def pieces(
    machine: MachineTool, length: float, ends: tuple[Array, Array], *, tcp: bool, chord: float, angle: float
) -> tuple[Array, Array, float]:
    """The way of one block whose axes go in proportion: tips (N, 3) m and tool axes (N, 3) in the part, each the end of a piece,
    and the length (m) of the tip's way.

    ends: X, Y, Z, A, B, C (6,) m and rad where the block begins and ends. tcp: X, Y, Z are the tip's in the part. The tip keeps
    within `chord` (m) of each piece's straight line, and the tool's axis turns by at most `angle` (rad) on it. Raises
    ToolpathError for a way that needs more pieces than any control would be given.
    """
    start, end = ends
    count = 1
    while count <= _MOST:
        share = np.linspace(0.0, 1.0, 2 * count + 1)[:, None]
        at = start + share * (end - start)
        at[-1] = end
        tips, axes, _ = placed(machine, length, at[:, :3], at[:, 3:])
        tips = at[:, :3] if tcp else tips
        bow = np.linalg.norm(tips[1::2] - 0.5 * (tips[:-2:2] + tips[2::2]), axis=1)
        turn = np.linalg.norm(np.diff(axes, axis=0), axis=1)
        if np.all(bow <= chord) and np.all(turn[0::2] + turn[1::2] <= angle):
            chords, double = (np.linalg.norm(np.diff(tips[::n], axis=0), axis=1).sum() for n in (1, 2))
            return tips[2::2], axes[2::2], float(4.0 * chords - double) / 3.0  # Richardson's: chords lack a square
        count *= 2
    raise ToolpathError(
        f"a block that turns rotary axes needs more than {_MOST} points",
        hint="check its words, or choose a coarser tolerance",
    )
