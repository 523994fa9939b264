"""A KRL program as it was read: motions as arrays, in the units of the text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked
from camrob.issues import Finding

__all__ = ["KrlAction", "KrlApproximation", "KrlFrame", "KrlFrameKind", "KrlMotion", "KrlProgram"]


class KrlMotion(IntEnum):
    """The motion that ends at a row."""

    PTP_AXES = 0
    PTP_POSE = 1
    LIN = 2
    CIRC_VIA = 3  # auxiliary point; the CIRC ends at the next row
    CIRC_END = 4


class KrlApproximation(IntEnum):
    """How the row's target is rounded off."""

    EXACT = 0
    C_PTP = 1
    C_DIS = 2
    C_VEL = 3
    C_ORI = 4


class KrlFrameKind(StrEnum):
    """Where a tool or a base comes from."""

    LITERAL = "literal"
    MECHANISM = "mechanism"  # EK(...): xyzabc is relative to the kinematic's flange and follows it
    UNKNOWN = "unknown"  # not in the program: text says what it names, xyzabc is NaN


@dataclass(frozen=True, slots=True)
class KrlFrame:
    """A `$TOOL` or `$BASE`: xyzabc (6,) in mm and degrees, `text` the statement's right side."""

    kind: KrlFrameKind
    xyzabc: NDArray[np.float64]
    text: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "xyzabc", locked(self.xyzabc, shape=(6,), name="xyzabc"))


@dataclass(frozen=True, slots=True)
class KrlAction:
    """What the text does beside moving, before motion `motion` (N: behind the last): the statement, `canonical`."""

    motion: int
    text: str


@dataclass(frozen=True, slots=True)
class KrlProgram:
    """N motions in the order in which the controller would run them.

    kind: (N,) `KrlMotion`. pose: (N, 6) X, Y, Z mm, A, B, C degrees in `$BASE`, NaN where the target is axes.
    axes: (N, 6) A1..A6 degrees, NaN where the target is a pose. external: (N, E) E1.. in mm or degrees, in the order of
    `external_names`; a value that a statement leaves out is the one before, NaN before the first. status, turn: (N,) S
    and T, -1 where absent. circular_angle_deg: (N,) CA, NaN where absent. speed: (N,) `$VEL.CP` in m/s, 0 for PTP,
    NaN where never set. acc_cp: (N,) m/s2 and apo_cdis_mm: (N,), NaN where never set. approximation: (N,)
    `KrlApproximation`.
    wait: (N,) seconds of WAIT SEC before the motion; final_wait: those after the last. file: (N,) index into `files`;
    line: (N,) 1-based line there. tool, base: (N,) indices into `tools`, `bases`.
    actions: outputs, waits, halts, settings, in their order; frames and `$VEL.CP`, which the columns hold, left out.
    statements: how often each keyword was met. settings: values that system variables had at the end.
    findings: what was not understood, or has an effect that is not known here.
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
    acc_cp: NDArray[np.float64]
    apo_cdis_mm: NDArray[np.float64]
    approximation: NDArray[np.int8]
    wait: NDArray[np.float64]
    final_wait: float
    file: NDArray[np.int32]
    line: NDArray[np.int64]
    tool: NDArray[np.int32]
    base: NDArray[np.int32]
    tools: tuple[KrlFrame, ...]
    bases: tuple[KrlFrame, ...]
    actions: tuple[KrlAction, ...] = ()
    statements: Mapping[str, int] = field(default_factory=dict)
    settings: Mapping[str, float | int | bool | str] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()

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
            ("acc_cp", (count,), np.float64),
            ("apo_cdis_mm", (count,), np.float64),
            ("approximation", (count,), np.int8),
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
