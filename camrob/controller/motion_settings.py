"""What a controller goes by beside the motions: speeds, accelerations, distances, from the program and else the cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import ProgramError
from camrob.findings import Finding, Severity
from camrob.frozen import locked
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["MotionSettings", "motion_settings"]

Array = NDArray[np.float64]

_HALF = 50.0  # percent of the speed from which a target is rounded off by speed, where the program is silent
_WHOLE = 100.0  # percent of the way that PTP may be rounded off, likewise
_ANGLE = 5.0  # degrees from which a target is rounded off by angle, likewise


@dataclass(frozen=True, slots=True)
class MotionSettings:
    """SI. speed, acceleration, distance: (N,) along the path and of rounding off, for each row (speed 0 for PTP).

    axis_speed, axis_acceleration: (2, n) of the chain's joints, in CP motions and in PTP (shares of the top taken).
    turn_speed, turn_acceleration: of the tool. advance: motions known ahead. near_speed, near_ptp: shares, near_angle: rad, from
    which targets are rounded off.
    """

    speed: Array
    acceleration: Array
    distance: Array
    axis_speed: Array
    axis_acceleration: Array
    turn_speed: float
    turn_acceleration: float
    advance: int
    near_speed: float
    near_ptp: float
    near_angle: float
    findings: tuple[Finding, ...] = ()

    def __post_init__(self) -> None:
        for name in ("speed", "acceleration", "distance", "axis_speed", "axis_acceleration"):
            object.__setattr__(self, name, locked(getattr(self, name), name=name))


def motion_settings(program: ProgramText, cell: Cell) -> MotionSettings:
    """Settings of a program on a cell. What the program sets once holds for all of it, path speeds and the like from there on.

    Raises ProgramError for a CP motion before any speed was set, and for a setting that no controller takes.
    """
    own = cell.controller
    ptp = (program.kind == Motion.PTP_AXES) | (program.kind == Motion.PTP_POSE)
    speed = np.where(ptp, 0.0, np.asarray(program.speed))
    unset = np.flatnonzero(np.isnan(speed))
    if len(unset):
        row = int(unset[0])
        hint = "set the path's speed (m/s) before it"
        raise ProgramError(
            "a CP motion without a speed", hint=hint, path=_file(program, row), line=int(program.line[row])
        )

    def number(name: str, default: float, most: float = np.inf) -> float:
        setting = program.settings.get(name)
        value = default if setting is None else setting.value
        if isinstance(value, (bool, str)) or not 0.0 < value <= most:
            raise ProgramError(
                f"{name if setting is None else setting.name} = {value}",
                hint="write a positive number that the controller takes",
                path=program.files[0],
            )
        return float(value)

    shares = np.ones((2, len(cell)))
    shares[0] = own.ptp_velocity_percent
    shares[1] = 100.0
    for k, what in enumerate(("speed", "acceleration")):
        for joint, name in enumerate(cell.names):
            shares[k, joint] = number(f"{what} {name}", float(shares[k, joint]), 100.0)
    top, push = cell.limits_of("speed"), cell.limits_of("acceleration")
    distance = np.where(np.isnan(program.blend_mm), own.apo_cdis_mm, program.blend_mm)
    return MotionSettings(
        speed,
        np.where(np.isnan(program.acceleration), own.acc_cp, program.acceleration),
        mm_to_m(distance),
        np.stack([top, top * shares[0] / 100.0]),
        np.stack([push, push * shares[1] / 100.0]),
        deg_to_rad(min(number("turn_speed", own.vel_ori_deg_s), number("roll_speed", own.vel_ori_deg_s))),
        deg_to_rad(
            min(number("turn_acceleration", own.acc_ori_deg_s2), number("roll_acceleration", own.acc_ori_deg_s2))
        ),
        _advance(program, own.advance),
        number("blend_speed", _HALF, 100.0) / 100.0,
        number("blend_axes", _WHOLE, 100.0) / 100.0,
        deg_to_rad(number("blend_turn", _ANGLE)),
        _unlike(program),
    )


def _advance(program: ProgramText, default: int) -> int:
    """How many motions are known ahead. Raises ProgramError for what no controller takes."""
    setting = program.settings.get("advance")
    if setting is None:
        return default
    if isinstance(setting.value, (bool, str)) or not 0 <= setting.value <= 5:
        raise ProgramError(f"{setting.name} = {setting.value}", hint="write 0 to 5", path=program.files[0])
    return int(setting.value)


def _unlike(program: ProgramText) -> tuple[Finding, ...]:
    """Findings on settings that are run otherwise than they say."""
    findings = []
    for setting in program.settings.values():
        if setting.usual and setting.value != setting.usual:
            text = f"{setting.name} = {setting.value} is run as {setting.usual}: rotation along the great arc"
            findings.append(Finding("rotation-type", text, Severity.WARNING))
    return tuple(findings)


def _file(program: ProgramText, row: int) -> str:
    return program.files[int(program.file[row])]
