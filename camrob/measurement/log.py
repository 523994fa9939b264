"""A measurement log: what the controller reported and what an instrument saw, a row a sample."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from camrob.errors import LogError
from camrob.frozen import digest, locked
from camrob.measurement.log_info import LogInfo
from camrob.se3 import abc_to_rotation
from camrob.units import deg_to_rad, mm_to_m

__all__ = [
    "AXES",
    "COLUMNS",
    "CURRENT",
    "DISTANCE",
    "EXTERNAL",
    "EXTERNAL_TORQUE",
    "FORCE",
    "MOTOR",
    "NORMAL",
    "ORIENTATION",
    "POSITION",
    "TORQUE",
    "MeasurementLog",
]

Array = NDArray[np.float64]

POSITION = ("x", "y", "z")
DISTANCE = "d"
NORMAL = ("nx", "ny", "nz")
ORIENTATION = ("a", "b", "c")
AXES = tuple(f"A{i}" for i in range(1, 8))
EXTERNAL = tuple(f"E{i}" for i in range(1, 7))
TORQUE = tuple(f"T{i}" for i in range(1, 8))
EXTERNAL_TORQUE = tuple(f"T{n}" for n in EXTERNAL)
MOTOR = (*(f"M{i}" for i in range(1, 8)), *(f"M{n}" for n in EXTERNAL))
CURRENT = (*(f"I{i}" for i in range(1, 8)), *(f"I{n}" for n in EXTERNAL))
FORCE = ("fx", "fy", "fz")
COLUMNS = (
    *("t", *POSITION, DISTANCE, *NORMAL, *ORIENTATION, *AXES, *EXTERNAL, *(f"c{n}" for n in AXES + EXTERNAL)),
    *(*TORQUE, *EXTERNAL_TORQUE, *MOTOR, *CURRENT, "temp", *FORCE, "line"),
)
"""Every column of the log format, in the order in which they are written."""


@dataclass(frozen=True, slots=True)
class MeasurementLog:
    """N samples. `columns` maps the format's column names to arrays (N,) in the units of the file (mm, degrees, s).

    A column that was not measured is absent, a cell that was not measured is NaN; `t` is whole and strictly increasing.
    What the properties and methods give is SI, but for axis values, which stay in degrees and mm, as only a cell knows
    which axis is which (`Cell.to_q` takes them so). path: the file it was read from, None for a log made here; file_lines: (N,)
    where in it each sample stands, as messages name it.
    """

    columns: Mapping[str, Array]
    info: LogInfo = field(default_factory=LogInfo)
    path: Path | None = None
    file_lines: NDArray[np.int64] | None = None

    def __post_init__(self) -> None:
        if "t" not in self.columns:
            raise LogError("has no column t", hint="give the time in seconds", path=self.path)
        count = len(self.columns["t"])
        unknown = sorted(set(self.columns) - set(COLUMNS))
        if unknown:
            raise LogError(
                f"{unknown[0][:40]!r} is not a column of a log", hint=f"use {', '.join(COLUMNS)}", path=self.path
            )
        ordered = {n: locked(self.columns[n], shape=(count,), name=n) for n in COLUMNS if n in self.columns}
        object.__setattr__(self, "columns", MappingProxyType(ordered))

    def __len__(self) -> int:
        return len(self.columns["t"])

    @property
    def name(self) -> str:
        """The file's name, "log" of one made here."""
        return self.path.name if self.path is not None else "log"

    def has(self, *names: str) -> bool:
        """True where the log has all these columns."""
        return all(name in self.columns for name in names)

    def has_axes(self, names: Sequence[str]) -> bool:
        """True where it has all these axes, by encoder or by set-point."""
        return self.has(*names) or self.has(*(f"c{name}" for name in names))

    def matrix(self, names: Sequence[str]) -> Array:
        """Columns (N, k) in the units of the file. Raises LogError where one is absent."""
        for name in names:
            if name not in self.columns:
                hint = f"this needs the columns {', '.join(names)}"
                raise LogError(f"has no column {name}", hint=hint, path=self.path, line=1 if self.path else 0)
        return np.stack([self.columns[name] for name in names], axis=1) if names else np.zeros((len(self), 0))

    @property
    def t(self) -> Array:
        """(N,) s."""
        return np.asarray(self.columns["t"])

    @property
    def has_position(self) -> bool:
        """True where the position was measured, all three coordinates of it."""
        return self.has(*POSITION)

    @property
    def sees_place(self) -> bool:
        """True where something of the position was measured: a coordinate, or a distance."""
        return any(name in self.columns for name in (*POSITION, DISTANCE))

    @property
    def sees_part(self) -> bool:
        """True where less than the position was measured: some coordinates, one along a normal, or a distance."""
        return self.sees_place and (not self.has_position or self.has(*NORMAL) or DISTANCE in self.columns)

    @property
    def place_names(self) -> tuple[str, ...]:
        """The columns that say where the target is."""
        return (DISTANCE,) if DISTANCE in self.columns else tuple(n for n in (*POSITION, *NORMAL) if n in self.columns)

    @property
    def has_orientation(self) -> bool:
        """True where the orientation was measured."""
        return self.has(*ORIENTATION)

    @property
    def position(self) -> Array:
        """Measured positions (N, 3), m, in the frame that `info.measured_frame` names."""
        return mm_to_m(self.matrix(POSITION))

    @property
    def rotation(self) -> Array:
        """Measured orientations (N, 3, 3) in the frame that `info.measured_frame` names."""
        return abc_to_rotation(deg_to_rad(self.matrix(ORIENTATION)))

    @property
    def torque(self) -> Array:
        """Axis torques (N, k) of the arm's axes that are logged, T1 .., Nm."""
        return self.matrix([n for n in TORQUE if n in self.columns] or TORQUE)

    def beside(self, kind: str, axes: Sequence[str]) -> Array | None:
        """What is logged of some axes beside their places (N, k), in the file's units; None where any lacks it.

        kind: T (Nm, N), M (motor-side encoders, degrees and mm of the axis) or I (A, motor currents).
        """
        names = [f"{kind}{a.removeprefix('A')}" for a in axes]
        return self.matrix(names) if self.has(*names) else None

    @property
    def force(self) -> Array:
        """Force on the tool in `world` (N, 3), N."""
        return self.matrix(FORCE)

    @property
    def line(self) -> NDArray[np.int64]:
        """Program line of each sample (N,), 0 where unknown."""
        return np.nan_to_num(self.matrix(("line",))[:, 0]).astype(np.int64)

    @property
    def axis_names(self) -> tuple[str, ...]:
        """The axes that the log reports, by encoder or by set-point, A1 .. then E1 .."""
        return tuple(n for n in AXES + EXTERNAL if n in self.columns or f"c{n}" in self.columns)

    def axes(self, names: Sequence[str]) -> Array:
        """Axis positions (N, k) as the encoders report them, degrees and mm, as `Cell.to_q` takes them."""
        return self.matrix(names)

    def setpoints(self, names: Sequence[str]) -> Array:
        """Commanded axis positions (N, k), degrees and mm."""
        return self.matrix([f"c{name}" for name in names])

    def complete(self, names: Iterable[str]) -> NDArray[np.bool_]:
        """(N,) True where none of these columns has an empty cell."""
        return np.asarray(~np.isnan(self.matrix(tuple(names))).any(axis=1))

    def select(self, rows: NDArray[np.bool_] | NDArray[np.int64] | slice) -> MeasurementLog:
        """Some of the samples, in their order."""
        lines = None if self.file_lines is None else self.file_lines[rows]
        return MeasurementLog({n: v[rows] for n, v in self.columns.items()}, self.info, self.path, lines)

    def error(self, what: str, *, hint: str, at: int | None = 0) -> LogError:
        """What is wrong with this log, by the line of its file where it first shows: that of a sample, None for the header's."""
        where = self.file_lines
        line = 0 if where is None else 1 if at is None else int(where[at])
        return LogError(what, hint=hint, path=self.path, line=line)

    @property
    def digest(self) -> str:
        """What the log holds."""
        return digest(*(part for name, values in self.columns.items() for part in (name, values)))
