"""What a controller goes by beside the motions: speeds, accelerations, distances, from the program and else the cell."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import KrlError
from camrob.frozen import locked
from camrob.issues import Finding, Severity
from camrob.post.krl_program import KrlMotion, KrlProgram
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["MotionSettings", "motion_settings"]

Array = NDArray[np.float64]

_HALF = 50.0  # percent: `$APO.CVEL` where the program is silent
_WHOLE = 100.0  # percent: `$APO.CPTP`, likewise
_ANGLE = 5.0  # degrees: `$APO.CORI`, likewise


@dataclass(frozen=True, slots=True)
class MotionSettings:
    """SI. speed, acceleration, distance: (N,) `$VEL.CP`, `$ACC.CP`, `$APO.CDIS` of each row (speed 0 for PTP).

    axis_speed, axis_acceleration: (2, n) of the chain's joints, in CP motions and in PTP (shares of the top taken). turn_speed,
    turn_acceleration: of the tool. advance: `$ADVANCE`. near_speed, near_ptp: shares, near_angle: rad, of `$APO`.
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


def motion_settings(program: KrlProgram, cell: Cell) -> MotionSettings:
    """Settings of a program on a cell. What the program sets once holds for all of it, `$VEL.CP` and the like from there on.

    Raises KrlError for a CP motion before any `$VEL.CP`, and for a setting that no controller takes.
    """
    own = cell.controller
    ptp = (program.kind == KrlMotion.PTP_AXES) | (program.kind == KrlMotion.PTP_POSE)
    speed = np.where(ptp, 0.0, np.asarray(program.speed))
    unset = np.flatnonzero(np.isnan(speed))
    if len(unset):
        row = int(unset[0])
        cure = "set $VEL.CP (m/s) before it"
        raise KrlError("a CP motion without a speed", cure=cure, path=_file(program, row), line=int(program.line[row]))

    def number(name: str, default: float, most: float = np.inf) -> float:
        value = program.settings.get(name, default)
        if isinstance(value, (bool, str)) or not 0.0 < value <= most:
            raise KrlError(
                f"{name} = {value}", cure="write a positive number that the controller takes", path=program.files[0]
            )
        return float(value)

    shares = np.ones((2, len(cell)))
    shares[0] = own.ptp_velocity_percent
    shares[1] = 100.0
    for k, kind in enumerate(("VEL", "ACC")):
        for name, joint in _axes_of(cell, kind):
            shares[k, joint] = number(name, float(shares[k, joint]), 100.0)
    top, push = cell.limits_of("speed"), cell.limits_of("acceleration")
    advance = program.settings.get("$ADVANCE", own.advance)
    if isinstance(advance, (bool, str)) or not 0 <= advance <= 5:
        raise KrlError(f"$ADVANCE = {advance}", cure="write 0 to 5", path=program.files[0])
    distance = np.where(np.isnan(program.apo_cdis_mm), own.apo_cdis_mm, program.apo_cdis_mm)
    return MotionSettings(
        speed,
        np.where(np.isnan(program.acc_cp), own.acc_cp, program.acc_cp),
        mm_to_m(distance),
        np.stack([top, top * shares[0] / 100.0]),
        np.stack([push, push * shares[1] / 100.0]),
        deg_to_rad(min(number("$VEL.ORI1", own.vel_ori_deg_s), number("$VEL.ORI2", own.vel_ori_deg_s))),
        deg_to_rad(min(number("$ACC.ORI1", own.acc_ori_deg_s2), number("$ACC.ORI2", own.acc_ori_deg_s2))),
        int(advance),
        number("$APO.CVEL", _HALF, 100.0) / 100.0,
        number("$APO.CPTP", _WHOLE, 100.0) / 100.0,
        deg_to_rad(number("$APO.CORI", _ANGLE)),
        _unlike(program),
    )


def _axes_of(cell: Cell, kind: str) -> list[tuple[str, int]]:
    """Names of the percentages of the axes with the joint that each is for, `$VEL_AXIS[1]` and `$VEL_EXTAX[1]` on."""
    out = []
    for joint, name in enumerate(cell.names):
        match = re.fullmatch(r"([AE])(\d)", name)
        if match:
            out.append((f"${kind}_{'AXIS' if match[1] == 'A' else 'EXTAX'}[{match[2]}]", joint))
    return out


def _unlike(program: KrlProgram) -> tuple[Finding, ...]:
    """Findings on settings that are run otherwise than they say."""
    findings = []
    for name, usual in (("$ORI_TYPE", "#VAR"), ("$CIRC_TYPE", "#BASE")):
        value = program.settings.get(name, usual)
        if value != usual:
            text = f"{name} = {value} is run as {usual}: rotation along the great arc"
            findings.append(Finding("rotation-type", text, Severity.WARNING))
    return tuple(findings)


def _file(program: KrlProgram, row: int) -> str:
    return program.files[int(program.file[row])]
