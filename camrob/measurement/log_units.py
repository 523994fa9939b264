"""Whether a log's values can be in the format's units at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.errors import LogError
from camrob.measurement.log import (
    AXES,
    CURRENT,
    DISTANCE,
    EXTERNAL,
    EXTERNAL_TORQUE,
    FORCE,
    MOTOR,
    NORMAL,
    ORIENTATION,
    POSITION,
    TORQUE,
    MeasurementLog,
)
from camrob.units import deg_to_rad

__all__ = ["check_plausible", "check_turns"]

Array = NDArray[np.float64]

# name to the largest magnitude that is believed, in the file's unit
_LARGEST = {
    **dict.fromkeys(("t",), 1e9),
    **dict.fromkeys((*POSITION, DISTANCE), 1e5),
    **dict.fromkeys(NORMAL, 1.1),  # of a unit vector
    **dict.fromkeys(ORIENTATION, 360.0 + 1e-9),
    # mm, where an axis slides: that one turns, the cell tells (`check_turns`)
    **dict.fromkeys((*AXES, *(f"c{n}" for n in AXES), *EXTERNAL, *(f"c{n}" for n in EXTERNAL)), 1e6),
    **dict.fromkeys((*TORQUE, *EXTERNAL_TORQUE), 1e6),
    **dict.fromkeys(MOTOR, 1e6),
    **dict.fromkeys(CURRENT, 1e4),
    **dict.fromkeys(FORCE, 1e6),
    "temp": 200.0,
    "line": 1e9,
}
_TURNED = 1500.0  # degrees that an axis of an arm is from its zero at the most
_HINT = "the format's units are mm, degrees, s, Nm, N and degrees C"
_REACH_MM = 6000.0  # the longest lever that an axis turns the tool with
_GROSS_DEG = 30.0  # of travel of A1 to A3, with which no tool stays within ...
_METRES = 10.0  # ... mm


def check_plausible(columns: Mapping[str, Array], path: Path, lines: NDArray[np.int64]) -> None:
    """Raise LogError, with the line, where a value, or all of them together, can't be in mm and degrees.

    Together: the tool can't travel farther than the axes carry it (angles in radians), nor stay within a few
    millimetres of the origin while A1 to A3 turn a good deal (positions in metres), unless it stays at one place, as a ball in
    a socket does. lines: (N,) where the rows stand.
    """
    for name, largest in _LARGEST.items():
        if name in columns:
            beyond = np.abs(columns[name]) > largest
            if beyond.any():
                row = int(np.argmax(beyond))
                raise LogError(f"{name} is {columns[name][row]:g}", hint=_HINT, path=path, line=int(lines[row]))
    places = [n for n in (*POSITION, DISTANCE) if n in columns]
    if not places or NORMAL[0] in columns:
        return
    prefix = "" if "A1" in columns or "E1" in columns else "c"
    seen = ~np.isnan(columns[places[0]])
    travel = {n: _extent(columns[prefix + n][seen]) for n in AXES + EXTERNAL if prefix + n in columns}
    extent = float(np.linalg.norm([_extent(columns[n][seen]) for n in places]))
    carried = sum(float(deg_to_rad(travel[n])) * _REACH_MM for n in AXES if n in travel)
    # an external axis may be a track (mm) or a table (degrees): the larger of both
    carried += sum(max(travel[n], float(deg_to_rad(travel[n])) * _REACH_MM) for n in travel if n in EXTERNAL)
    if extent > 20.0 and not any(travel.values()):
        what = f"the tool travels {extent:.0f} mm while every axis stays the same to the last digit"
        raise LogError(what, hint="log the axis values of each row beside its reading", path=path, line=int(lines[0]))
    if extent > 1.5 * carried + 20.0:
        what = f"the tool travels {extent:.0f} mm while the axes move only {max(travel.values()):.3g} degrees"
        raise LogError(what, hint="are the angles in radians? give degrees", path=path, line=int(lines[0]))
    farthest = max(float(np.max(np.abs(columns[n][seen]), initial=0.0)) for n in places)
    if (
        len(places) == len(POSITION)
        and seen.any()
        and farthest < _METRES
        and extent > 0.0
        and sum(travel.get(n, 0.0) for n in AXES[:3]) > _GROSS_DEG
    ):
        what = f"the tool stays within {farthest:.3g} mm of the origin while the arm moves"
        raise LogError(what, hint="are the positions in metres? give mm", path=path, line=int(lines[0]))


def check_turns(log: MeasurementLog, turning: Sequence[str]) -> None:
    """Raise LogError, with the line, where one of the arm's axes `turning`, which don't slide, is at no angle in degrees."""
    for axis in turning:
        for name in (axis, f"c{axis}"):
            beyond = np.abs(log.columns.get(name, np.zeros(1))) > _TURNED
            if beyond.any():
                row = int(np.argmax(beyond))
                what = f"{name} is {log.columns[name][row]:g} degrees"
                raise log.error(what, hint="is it in increments, or another axis' column?", at=row)


def _extent(values: Array) -> float:
    """Largest less least, 0 where there is nothing."""
    known = values[~np.isnan(values)]
    return float(known.max() - known.min()) if len(known) else 0.0
