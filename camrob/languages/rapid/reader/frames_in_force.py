"""Tools and work objects as frames, one index each frame that a motion is made with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ProgramError
from camrob.languages.rapid.reader.collected_rows import OFF_UNIT
from camrob.languages.rapid.reader.data import Data, numbers
from camrob.languages.rapid.reader.expressions import Value
from camrob.program.program_text import FrameKind, ProgramFrame
from camrob.se3 import frame_from_mm_deg, mm_deg_from_frame, quaternion_to_rotation, rotation_to_abc
from camrob.units import rad_to_deg

__all__ = ["FramesInForce"]

Array = NDArray[np.float64]


class FramesInForce:
    """The frames of a program so far. `tools`, `bases`: in the order of use, what no motion names first."""

    def __init__(self, data: Data) -> None:
        self._data = data
        nothing = ProgramFrame(FrameKind.UNKNOWN, np.full(6, np.nan), "")
        self.tools: list[ProgramFrame] = [nothing]
        self.bases: list[ProgramFrame] = [nothing]
        self._known: dict[tuple[str, str], int] = {}
        self._loads: dict[str, str] = {}
        self._changes = -1

    def tool(self, name: str) -> int:
        """The index of a tooldata's frame as it is now."""
        return self._index("tool", name)

    def base(self, name: str) -> int:
        """The index of a work object's frame as it is now."""
        return self._index("base", name)

    def load_text(self, name: str) -> str:
        """What a tooldata says of the load; "" where the text does not say it."""
        self._refresh()
        if name not in self._loads:
            kind, value = self._data.find(name)
            told = kind == "TOOLDATA" and isinstance(value, list) and len(value) == 3
            self._loads[name] = _flat(value[2]) if told and isinstance(value, list) else ""
        return self._loads[name]

    def _refresh(self) -> None:
        if self._changes != self._data.changes:
            self._known, self._loads, self._changes = {}, {}, self._data.changes

    def _index(self, what: str, name: str) -> int:
        self._refresh()
        if (what, name) not in self._known:
            frames = self.tools if what == "tool" else self.bases
            made = _tool(self._data, name) if what == "tool" else _base(self._data, name)
            found = next((k for k, old in enumerate(frames) if k and _same(old, made)), None)
            if found is None:
                frames.append(made)
            self._known[what, name] = len(frames) - 1 if found is None else found
        return self._known[what, name]


def _tool(data: Data, name: str) -> ProgramFrame:
    """A tooldata's frame; unknown for one that stands in the cell, or is not in the text."""
    kind, value = data.find(name)
    if kind == "TOOLDATA" and isinstance(value, list) and len(value) == 3:
        frame = _xyzabc(value[1])
        if value[0] is True and frame is not None:
            return ProgramFrame(FrameKind.LITERAL, frame, name)
    return ProgramFrame(FrameKind.UNKNOWN, np.full(6, np.nan), name)


def _base(data: Data, name: str) -> ProgramFrame:
    """A work object's frame: in the world, or on the mechanical unit that carries it."""
    kind, value = data.find(name)
    if kind == "WOBJDATA" and isinstance(value, list) and len(value) == 5 and value[0] is False:
        user, offset = _xyzabc(value[3]), _xyzabc(value[4])
        if value[1] is False and value[2] and offset is not None:
            return ProgramFrame(FrameKind.MECHANISM, offset, f"{name} on {value[2]}")
        if value[1] is True and user is not None and offset is not None:
            return ProgramFrame(FrameKind.LITERAL, offset if not user.any() else _behind(user, offset), name)
    return ProgramFrame(FrameKind.UNKNOWN, np.full(6, np.nan), name)


def _xyzabc(value: Value | None) -> Array | None:
    """X..C, mm and degrees, of a pose; None where it is not known."""
    try:
        if not isinstance(value, list) or len(value) != 2:
            return None
        place, turn = numbers(value[0], 3, "a frame"), numbers(value[1], 4, "a frame")
    except ProgramError:
        return None
    if not abs(np.linalg.norm(turn) - 1.0) < OFF_UNIT:
        return None
    angles = rad_to_deg(rotation_to_abc(quaternion_to_rotation(np.array(turn))))
    return np.asarray(np.concatenate([place, angles]) + 0.0)


def _behind(first: Array, second: Array) -> Array:
    """X..C of one frame in another."""
    return mm_deg_from_frame(frame_from_mm_deg(first) @ frame_from_mm_deg(second))


def _same(old: ProgramFrame, new: ProgramFrame) -> bool:
    return old.kind is new.kind and old.text == new.text and np.array_equal(old.xyzabc, new.xyzabc, equal_nan=True)


def _flat(value: Value | None) -> str:
    """The numbers of a record in their order; "" where one is not known."""
    items = value if isinstance(value, list) else [value]
    if any(item is None for item in items):
        return ""
    return ", ".join(_flat(item) if isinstance(item, list) else repr(item) for item in items)
