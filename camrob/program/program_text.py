"""A program as it was read back from its text, in any language: motions as arrays, in the units of the trade."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from camrob.findings import Finding
from camrob.frozen import locked
from camrob.program.motion import Turning

__all__ = ["FrameKind", "ProgramAction", "ProgramFrame", "ProgramText", "Setting"]


class FrameKind(StrEnum):
    """Where a tool or a base comes from."""

    LITERAL = "literal"
    MECHANISM = "mechanism"  # xyzabc is relative to the flange of what carries the workpiece, and follows it
    UNKNOWN = "unknown"  # not in the program: text says what it names, xyzabc is NaN


@dataclass(frozen=True, slots=True)
class ProgramFrame:
    """A tool or a base: xyzabc (6,) in mm and degrees, `text` as the program writes it."""

    kind: FrameKind
    xyzabc: NDArray[np.float64]
    text: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "xyzabc", locked(self.xyzabc, shape=(6,), name="xyzabc"))


@dataclass(frozen=True, slots=True)
class ProgramAction:
    """What the text does beside moving, before motion `motion` (N: behind the last).

    text: the statement in the one spelling in which the language compares it.
    """

    motion: int
    text: str


@dataclass(frozen=True, slots=True)
class Setting:
    """What a program sets for all that follows: the setting's name in the program's own words, and its value.

    usual: the value, in the same words, that a controller is taken to run by; "" where any value is run as it says.
    """

    name: str
    value: float | int | bool | str
    usual: str = ""


@dataclass(frozen=True, slots=True)
class ProgramText:
    """N motions in the order in which the controller would run them.

    kind: (N,) `Motion`. pose: (N, 6) X, Y, Z mm, A, B, C degrees in the program's base, NaN where the target is axes.
    axes: (N, 6) A1..A6 degrees, NaN where the target is a pose. external: (N, E) E1.. in mm or degrees, in the order of
    `external_names`; a value that a statement leaves out is the one before, NaN before the first. status, turn: (N,) the arm's
    branch and the turns of its axes as `turning` counts them, -1 where absent. circular_angle_deg: (N,) of an arc that states
    one, NaN where absent. speed: (N,) m/s of LIN and CIRC, 0 for PTP, NaN where never set. acceleration: (N,) m/s2 along the path
    and blend_mm: (N,) distance from which targets are rounded off, NaN where never set. blend: (N,) `Blend`.
    wait: (N,) seconds waited before the motion; final_wait: those after the last. file: (N,) index into `files`;
    line: (N,) 1-based line there. tool, base: (N,) indices into `tools`, `bases`.
    actions: outputs, waits, halts, settings, in their order; frames and speeds, which the columns hold, left out.
    statements: how often each keyword was met. settings: what was set at the end, where the text sets it, by the names of
    "advance" (motions known ahead), "turn_speed", "roll_speed" (degrees/s of the tool's axis and about it), "turn_acceleration",
    "roll_acceleration" (degrees/s2), "blend_speed", "blend_axes" (percent), "blend_turn" (degrees), "turning", "arc_turning" (how
    the tool turns along a line and along an arc), "speed A1", "acceleration E1" and so on (percent of an axis's own).
    findings: what was not understood, or has an effect that is not known here. language: the name of the text's language.
    """

    name: str
    files: tuple[str, ...]
    kind: NDArray[np.int8]
    pose: NDArray[np.float64]
    axes: NDArray[np.float64]
    external: NDArray[np.float64]
    external_names: tuple[str, ...]
    status: NDArray[np.int16]
    turn: NDArray[np.int16]
    circular_angle_deg: NDArray[np.float64]
    speed: NDArray[np.float64]
    acceleration: NDArray[np.float64]
    blend_mm: NDArray[np.float64]
    blend: NDArray[np.int8]
    wait: NDArray[np.float64]
    final_wait: float
    file: NDArray[np.int32]
    line: NDArray[np.int64]
    tool: NDArray[np.int32]
    base: NDArray[np.int32]
    tools: tuple[ProgramFrame, ...]
    bases: tuple[ProgramFrame, ...]
    actions: tuple[ProgramAction, ...] = ()
    statements: Mapping[str, int] = field(default_factory=dict)
    settings: Mapping[str, Setting] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()
    language: str = ""
    turning: Turning = Turning.SIGNS

    def __post_init__(self) -> None:
        count = len(self.kind)
        for name, shape, dtype in (
            ("kind", (count,), np.int8),
            ("pose", (count, 6), np.float64),
            ("axes", (count, 6), np.float64),
            ("external", (count, len(self.external_names)), np.float64),
            ("status", (count,), np.int16),
            ("turn", (count,), np.int16),
            ("circular_angle_deg", (count,), np.float64),
            ("speed", (count,), np.float64),
            ("acceleration", (count,), np.float64),
            ("blend_mm", (count,), np.float64),
            ("blend", (count,), np.int8),
            ("wait", (count,), np.float64),
            ("file", (count,), np.int32),
            ("line", (count,), np.int64),
            ("tool", (count,), np.int32),
            ("base", (count,), np.int32),
        ):
            object.__setattr__(self, name, locked(getattr(self, name), shape=shape, dtype=dtype, name=name))
        object.__setattr__(self, "statements", MappingProxyType(dict(self.statements)))
        object.__setattr__(self, "settings", MappingProxyType(dict(self.settings)))

    def __len__(self) -> int:
        return len(self.kind)
