"""Collects the motions of a RAPID program, and makes them the columns of a `ProgramText`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from camrob.errors import ProgramError
from camrob.program.motion import Motion
from camrob.se3 import quaternion_to_rotation, rotation_to_abc
from camrob.units import rad_to_deg

__all__ = ["ABSENT", "OFF_UNIT", "CollectedRows", "Modal", "Target"]

ABSENT = 8.9e9
"""From here on an external axis's value is 9E9: no such axis."""
_MOST_ROWS = 50_000_000  # motions: beyond any program that a controller loads
_NAN = float("nan")
OFF_UNIT = 0.01
"""Of a quaternion's length: more is no rounding, and the controller refuses it."""


@dataclass(slots=True)
class Modal:
    """What holds at a motion: its speed m/s, acceleration, zone, tool and base by index, and where it stands."""

    speed: float
    acceleration: float
    blend: int
    blend_mm: float
    tool: int
    base: int
    file: int
    line: int


@dataclass(frozen=True, slots=True)
class Target:
    """A robtarget: place, quaternion, status and turn; or a jointtarget: axes."""

    place: Sequence[float] | None
    rotation: Sequence[float]
    axes: Sequence[float]
    external: Sequence[float]
    status: int = -1
    turn: int = -1


@dataclass(slots=True)
class CollectedRows:
    """Rows so far, and the seconds waited since the last motion."""

    wait: float = 0.0
    external: list[float] = field(default_factory=lambda: [_NAN] * 6)
    _rows: list[tuple[float, ...]] = field(default_factory=list)
    _files: list[tuple[int, int]] = field(default_factory=list)

    @property
    def count(self) -> int:
        """Motions so far."""
        return len(self._rows)

    def add(self, kind: Motion, target: Target, modal: Modal) -> None:
        """One motion. Raises ProgramError for a target that is none."""
        if len(self._rows) >= _MOST_ROWS:
            raise ProgramError("more motions than any controller takes", hint="end its loops, or split it")
        posed = target.place is not None
        external = [e if e < ABSENT else old for e, old in zip(target.external, self.external, strict=True)]
        self.external = external
        rotation = target.rotation if posed else (1.0, 0.0, 0.0, 0.0)
        self._rows.append(
            (
                kind,
                *(target.place if target.place is not None else (_NAN,) * 3),
                *rotation,
                *(target.axes if not posed else (_NAN,) * 6),
                *external,
                target.status,
                target.turn,
                modal.speed,
                modal.acceleration,
                modal.blend,
                modal.blend_mm,
                self.wait,
                modal.tool,
                modal.base,
            )
        )
        self._files.append((modal.file, modal.line))
        self.wait = 0.0

    def columns(self) -> dict[str, Any]:
        """The columns by their names in `ProgramText`; `external` has all six. Raises ProgramError, with the line."""
        count = len(self._rows)
        table = np.array(self._rows, float).reshape(count, -1) if count else np.zeros((0, 29))  # as wide as a row
        place = np.array(self._files, np.int64).reshape(count, 2)
        posed = table[:, 0] != Motion.PTP_AXES
        size = np.linalg.norm(table[:, 4:8], axis=1)
        wrong = np.flatnonzero(posed & ~(np.abs(size - 1.0) < OFF_UNIT))
        if len(wrong):
            raise ProgramError("q1 .. q4 are not of length 1", hint="give a quaternion", line=int(place[wrong[0], 1]))
        angles = rad_to_deg(rotation_to_abc(quaternion_to_rotation(table[:, 4:8]))) + 0.0
        pose = np.concatenate([table[:, 1:4], np.where(posed[:, None], angles, np.nan)], axis=1)
        return {
            "kind": table[:, 0],
            "pose": pose,
            "axes": table[:, 8:14],
            "external": table[:, 14:20],
            "status": table[:, 20],
            "turn": table[:, 21],
            "speed": table[:, 22],
            "acceleration": table[:, 23],
            "blend": table[:, 24],
            "blend_mm": table[:, 25],
            "wait": table[:, 26],
            "tool": table[:, 27],
            "base": table[:, 28],
            "file": place[:, 0],
            "line": place[:, 1],
            "circular_angle_deg": np.full(count, np.nan),
        }
