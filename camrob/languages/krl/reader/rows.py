"""Collects the motions of a KRL program, one at a time or in bulk, with what is modal at each."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.errors import KrlError
from camrob.frozen import sealed
from camrob.languages.krl.reader.line_scan import COMPONENTS
from camrob.program.motion import Motion

__all__ = ["KrlRows", "Modal"]

_MOST_ROWS = 50_000_000  # motions: beyond any program that a controller loads
_NAN6 = (float("nan"),) * 6
_COLUMNS: tuple[tuple[str, int, Any], ...] = (
    ("kind", 1, np.int8),
    ("pose", 6, np.float64),
    ("axes", 6, np.float64),
    ("external", 6, np.float64),
    ("status", 1, np.int16),
    ("turn", 1, np.int16),
    ("circular_angle_deg", 1, np.float64),
    ("blend", 1, np.int8),
    ("speed", 1, np.float64),
    ("acceleration", 1, np.float64),
    ("blend_mm", 1, np.float64),
    ("tool", 1, np.int32),
    ("base", 1, np.int32),
    ("wait", 1, np.float64),
    ("file", 1, np.int32),
    ("line", 1, np.int64),
)


@dataclass(slots=True)
class Modal:
    """What holds from one motion to the next: speeds (NaN: never set), frames by index, seconds waited since then."""

    speed: float = float("nan")
    acceleration: float = float("nan")
    blend_mm: float = float("nan")
    tool: int = 0
    base: int = 0
    wait: float = 0.0


@dataclass(slots=True)
class KrlRows:
    """Rows so far. `pose`, `axes`: of the last target, None where it gave none; `external`: E1..E6, NaN unknown."""

    modal: Modal = field(default_factory=Modal)
    pose: tuple[float, ...] | None = None
    axes: tuple[float, ...] | None = None
    external: tuple[float, ...] = _NAN6
    framed: tuple[int, int] | None = None  # tool and base of the last target, None where the robot isn't there
    count: int = 0
    _pending: list[tuple[float, ...]] = field(default_factory=list)
    _blocks: list[dict[str, NDArray[Any]]] = field(default_factory=list)

    def add(
        self,
        kind: Motion,
        *,
        status: int = -1,
        turn: int = -1,
        angle: float = float("nan"),
        approximation: int = 0,
        file: int,
        line: int,
    ) -> None:
        """A motion to the current `pose` or `axes` and `external`; `line` from 1."""
        modal = self.modal
        ptp = kind in (Motion.PTP_AXES, Motion.PTP_POSE)
        self._pending.append(
            (
                kind,
                *(self.pose or _NAN6),
                *(self.axes or _NAN6),
                *self.external,
                status,
                turn,
                angle,
                approximation,
                0.0 if ptp else modal.speed,
                modal.acceleration,
                modal.blend_mm,
                modal.tool,
                modal.base,
                modal.wait,
                file,
                line,
            )
        )
        modal.wait, self.framed = 0.0, (modal.tool, modal.base)
        self._grow(1)

    def add_lins(
        self,
        values: NDArray[np.float64],
        approximation: NDArray[np.int8],
        speed: NDArray[np.float64],
        file: int,
        line: NDArray[np.int64],
    ) -> None:
        """LINs: values (M, 12) of `COMPONENTS`, NaN where a line leaves one out; `line` (M,) from 1.

        Raises KrlError for a pose that is incomplete and whose missing part is not known from before.
        """
        self._flush()
        modal, count = self.modal, len(values)
        there = self.framed == (modal.tool, modal.base)
        before = np.array((*((self.pose or _NAN6) if there else _NAN6), *self.external))
        filled = _kept(values, before)
        incomplete = np.isnan(filled[:, :6])
        if incomplete.any():
            row, column = np.argwhere(incomplete)[0]
            raise KrlError(
                f"LIN gives no {COMPONENTS[column]} and none is known in this base and with this tool",
                hint="give X to C",
                line=int(line[row]),
            )
        wait = np.zeros(count)
        wait[0] = modal.wait
        block: dict[str, Any] = {
            "kind": int(Motion.LIN),
            "pose": filled[:, :6],
            "axes": np.nan,
            "external": filled[:, 6:],
            "status": -1,
            "turn": -1,
            "circular_angle_deg": np.nan,
            "blend": approximation,
            "speed": speed,
            "acceleration": modal.acceleration,
            "blend_mm": modal.blend_mm,
            "tool": modal.tool,
            "base": modal.base,
            "wait": wait,
            "file": file,
            "line": line,
        }
        shapes = {name: (count, width) if width > 1 else (count,) for name, width, _ in _COLUMNS}
        self._blocks.append({n: np.broadcast_to(np.asarray(block[n], dtype=t), shapes[n]) for n, _, t in _COLUMNS})
        self.pose, self.axes = tuple(filled[-1, :6].tolist()), None
        self.external = tuple(filled[-1, 6:].tolist())
        modal.wait, self.framed = 0.0, (modal.tool, modal.base)
        self._grow(count)

    def end_exactly(self) -> None:
        """The advance run stops: the last motion ends at its target, whatever rounding it names."""
        self._flush()
        if self._blocks and self.count:
            blend = self._blocks[-1]["blend"].copy()
            blend[-1:] = 0
            self._blocks[-1] = {**self._blocks[-1], "blend": blend}

    def columns(self) -> dict[str, NDArray[Any]]:
        """All rows, by the names of `ProgramText`'s fields; `external` with all of E1..E6. They are given away: none is left."""
        self._flush()
        blocks = [{n: np.empty((0, w) if w > 1 else (0,), dtype=t) for n, w, t in _COLUMNS}, *self._blocks]
        self._blocks = []
        return {name: sealed(np.concatenate([block.pop(name) for block in blocks])) for name, _, _ in _COLUMNS}

    def _flush(self) -> None:
        """Turns the rows that came one at a time into a block."""
        if not self._pending:
            return
        table = np.array(self._pending, dtype=np.float64)
        block: dict[str, NDArray[Any]] = {}
        at = 0
        for name, width, dtype in _COLUMNS:
            part = table[:, at] if width == 1 else table[:, at : at + width]
            block[name] = part.astype(dtype)
            at += width
        self._blocks.append(block)
        self._pending.clear()

    def _grow(self, count: int) -> None:
        """Counts rows. Raises KrlError where loops make more of them than any controller would run."""
        self.count += count
        if self.count > _MOST_ROWS:
            raise KrlError(f"more than {_MOST_ROWS} motions", hint="a loop runs away")


def _kept(values: NDArray[np.float64], before: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values (M, K) with each NaN replaced by the last number above it, or by `before` (K,)."""
    missing = np.isnan(values)
    if not missing.any():
        return values
    rows = np.where(missing, -1, np.arange(len(values))[:, None])
    last = np.maximum.accumulate(rows, axis=0)
    kept = np.take_along_axis(values, np.maximum(last, 0), axis=0)
    return np.where(last < 0, before, kept)
