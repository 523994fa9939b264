"""The machine tool that a G-code program was posted for, as its TOML describes it: how its rotary axes carry part and tool.

Of a program without tool centre point, X, Y and Z are where the tool's tip is while all rotary axes are at zero. A head's axes
move that tip; a table's move the part away from under it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.errors import SetupError
from camrob.witness.fields import Fields, read_toml
from camrob.witness.frames import inverse, joined, rotations_about
from camrob.witness.units import deg_to_rad, mm_to_m

__all__ = ["MachineTool", "beside", "named_by", "read_machine_tool"]

Array = NDArray[np.float64]
_FAR = 20.0  # m
_LONG = 2.0  # m
_FEEDS = ("linear", "all")


@dataclass(frozen=True, slots=True, eq=False)
class _Axis:
    """letter; line: (2, 3) a point of the axis (m) and its direction (unit)."""

    letter: str
    line: Array


@dataclass(frozen=True, slots=True, eq=False)
class MachineTool:
    """Axes under the part and in the head, each from the bed on; lengths: m by tool number; counts: "linear", "all" or ""."""

    under: tuple[_Axis, ...]
    head: tuple[_Axis, ...]
    lengths: Mapping[int, float]
    counts: str

    @property
    def letters(self) -> set[str]:
        """Of its rotary axes."""
        return {axis.letter for axis in (*self.under, *self.head)}

    def length(self, tool: int) -> float:
        """m, from the gauge line to the tip; NaN where a head needs it and nobody says."""
        return self.lengths.get(tool, self.lengths.get(0, math.nan)) if self.head else 0.0

    def seen(self, at: Mapping[str, float], length: float) -> Array:
        """part_T_tip (4, 4): the tip, and along z the tool, for X, Y, Z in m and A, B, C in degrees."""
        tip = np.eye(4)
        tip[:3, 3] = [at[letter] for letter in "XYZ"]
        raised = np.array([0.0, 0.0, length])
        return np.asarray(inverse(_carried(self.under, at, 0.0 * raised)) @ tip @ _carried(self.head, at, raised))


def _carried(axes: tuple[_Axis, ...], at: Mapping[str, float], raised: Array) -> Array:
    """What the axes do (4, 4) to what they carry; raised: (3,) from where their points count to where the frame is."""
    out = np.eye(4)
    for axis in axes:
        turn = rotations_about(deg_to_rad(at[axis.letter]) * axis.line[1][None])[0]
        point = axis.line[0] + raised
        out = out @ joined(np.eye(3), point) @ joined(turn, np.zeros(3)) @ joined(np.eye(3), -point)
    return out


def named_by(top: Fields) -> MachineTool | None:
    """The machine that a set-up names, None where it names none. Raises SetupError, naming file and key."""
    path = beside(top, "machine")
    return None if path is None else read_machine_tool(path)


def beside(top: Fields, key: str) -> Path | None:
    """The file that a set-up names under a key, None where it names none. Raises SetupError where it lies elsewhere."""
    if key not in top:
        return None
    name = top.text(key)
    if Path(name).name != name:
        raise top.wrong(key, f"is {name!r}", "name a file beside the set-up")
    return top.path.parent / name


def read_machine_tool(path: Path) -> MachineTool:
    """The machine of a TOML file. Raises SetupError, naming file and key."""
    top = read_toml(path, SetupError)
    top.none_but("feed", "table", "head", "lengths_mm")
    counts = top.text("feed", "")
    if "feed" in top and counts not in _FEEDS:
        raise top.wrong("feed", f"is {counts!r}", f"write one of {', '.join(_FEEDS)}")
    under, head = (tuple(_axis(axis) for axis in top.subs(key)) for key in ("table", "head"))
    machine = MachineTool(under, head, _lengths(top), counts)
    if not machine.letters or len(machine.letters) < len(under) + len(head):
        raise top.wrong("table", "and head have no axis, or one letter twice")
    return machine


def _axis(fields: Fields) -> _Axis:
    fields.none_but("word", "direction", "point_mm")
    letter, direction = fields.text("word"), fields.numbers("direction", 3)
    size, point = float(np.linalg.norm(direction)), mm_to_m(fields.numbers("point_mm", 3))
    if letter not in ("A", "B", "C"):
        raise fields.wrong("word", f"is {letter!r}", "write A, B or C")
    if not 1e-3 < size < 1e3:
        raise fields.wrong("direction", "has no direction")
    if float(np.abs(point).max()) > _FAR:
        raise fields.wrong("point_mm", f"lies more than {_FAR:g} m off")
    return _Axis(letter, np.stack([point, direction / size]))


def _lengths(top: Fields) -> dict[int, float]:
    """m, by the tools' numbers."""
    rows = top.table.get("lengths_mm", [])
    pairs: dict[int, float] = {}
    for i, row in enumerate(rows if isinstance(rows, list) else [rows]):
        number, length = Fields({f"lengths_mm[{i}]": row}, top.path, top.error).numbers(f"lengths_mm[{i}]", 2)
        if number != int(number) or number < 0 or int(number) in pairs or not 0.0 < mm_to_m(length) <= _LONG:
            raise top.wrong(f"lengths_mm[{i}]", "is no tool's number with its length, or that tool's second")
        pairs[int(number)] = float(mm_to_m(length))
    return pairs
