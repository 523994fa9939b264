"""A small program with everything in it, whose RAPID text was written by hand (golden/Bracket_7.mod), and helpers."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from camrob.cell.controller_settings import ControllerSettings
from camrob.languages import language_named
from camrob.program.motion import Motion
from camrob.program.program import Program, ProgramEvent, ProgramEventKind
from camrob.program.program_text import ProgramText

RAPID = language_named("rapid")
OWN = {
    "mechanical_unit": "STN1",
    "active_units": ["STN1", "TRACK1"],
    "tool_data": "tSpindle",
    "ptp_speed": [500, 50, 400, 20],
}
CONTROLLER = ControllerSettings(
    acc_cp=2.0,
    vel_ori_deg_s=200.0,
    acc_ori_deg_s2=400.0,
    apo_cdis_mm=0.5,
    advance=3,
    ptp_velocity_percent=30.0,
    max_lines=10_000,
    max_bytes=1_000_000,
    max_line_length=400,
    language="rapid",
    own=OWN,
    hooks={
        "spindle_on": ("SetAO aoSpindle,{speed}/2400;", "SetDO doSpindle,1;", "WaitTime\\InPos,3;"),
        "spindle_off": ("SetDO doSpindle,0;",),
        "tool_change": ("ToolChange {number};",),
        "header": ("SetDO doRunning,1;",),
        "footer": ("SetDO doRunning,0;",),
    },
)
HOME = [0.0, -15.0, 20.0, 0.0, 55.0, 0.0]
# motion, pose (or where axes lead), axes, E1 and E3, branch, m/s, rounded off
_P, _J, _L, _V, _E = Motion.PTP_AXES, Motion.PTP_POSE, Motion.LIN, Motion.CIRC_VIA, Motion.CIRC_END
_ROWS = [
    (_P, [0, 0, 0, 0, 0, 0], HOME, [0.0, 1200.0], 2, 0.0, False),
    (_J, [100, -20, 300.5, 0, 0, 180], [-95, 10, -100, 185, -30, -190.5], [-45.5, 1200.25], 6, 0.0, False),
    (_L, [100, -20, 10, 0, 0, 180], [-90, 0, 0, 90, 30, 0], [-45.5, 1200.25], 2, 0.2, False),
    (_L, [50, 0, 10, 90, 0, 0], [-90.0001, 0, 0, 89.9999, 30, -0.0001], [-45, 1200], 0, 0.008333, True),
    (_V, [60, 10, 10, 90, 0, 0], [10, 0, 0, 180, 30, 270], [-44, 1200], 2, 0.025, False),
    (_E, [50, 20, 10, 0, -90, 0], [10, 0, 0, -180, -30, 359.9999], [-43, 1200], 7, 0.025, False),
    (_J, [50, 20, 200, 0, 0, 0], [20, 0, 0, 0, 30, 0], [-43, 1200], 3, 0.0, False),
    (_L, [50, 20, 10, 0, 0, 0], [20, 0, 0, 0, 30, 0], [-43, 1200], 3, 0.025, False),
    (_P, [0, 0, 0, 0, 0, 0], HOME, [0.0, 1200.0], 2, 0.0, False),
]


def turns(axes: np.ndarray) -> np.ndarray:
    """Quarters packed, from a rule of its own: how often 90 degrees go into the angle, downwards."""
    packed = []
    for row in axes:
        quarters = [int(np.floor(np.floor(row[k] * 1e4 + 0.5) / 9e5)) for k in (0, 3, 5)]
        packed.append(sum((q + 8) * 16**place for q, place in zip(quarters, (2, 1, 0), strict=True)))
    return np.array(packed)


def bracket() -> Program:
    """The program whose text was written by hand."""
    kind, pose, axes, external, status, speed, rounded = zip(*_ROWS, strict=True)
    kinds = ProgramEventKind
    axes_ = RAPID.round.axes(np.array(axes, float))
    pose_, external_ = RAPID.round.pose(np.array(pose, float), np.array(external, float))
    return Program(
        name="Bracket 7",
        kind=np.array(kind),
        pose=pose_,
        axes=axes_,
        external=external_,
        external_names=("E1", "E3"),
        status=np.array(status),
        turn=turns(axes_),
        speed=RAPID.round.speed(np.array(speed)),
        approximate=np.array(rounded),
        line=10 * np.arange(len(kind)) + 10,
        region=np.zeros(len(kind)),
        safe=np.isin(np.arange(len(kind)), [2, 6]),
        tool=RAPID.round.frame([0.0, 0.0, 200.0, 0.0, 0.0, 180.0]),
        base=RAPID.round.frame([100.0, 0.0, 50.0, 90.0, 0.0, 0.0]),
        comment=("made by hand; \u00fcber {all}",),
        events=(
            ProgramEvent(0, kinds.LOAD, value=0.0),
            ProgramEvent(1, kinds.HOOK, "spindle_on", 12000.0),
            ProgramEvent(2, kinds.REGION, "rough"),
            ProgramEvent(3, kinds.DWELL, value=1.25),
            ProgramEvent(3, kinds.COMMENT, "a remark\n! MoveL p1"),
            ProgramEvent(6, kinds.HOOK, "spindle_off"),
            ProgramEvent(6, kinds.HOOK, "tool_change", 2.0),
            ProgramEvent(6, kinds.TOOL, value=0.0),
            ProgramEvent(6, kinds.LOAD, value=1.0),
            ProgramEvent(8, kinds.HOOK, "coolant_off"),
        ),
        tools=RAPID.round.frame(np.array([[10.0, -20.5, 150.0, 0.0, 90.0, 0.0]])),
        loads=RAPID.round.load(np.array([[38.5, 0.0, -20.25, 300.0, 0, 0, 0], [21.0, 0.0, 0.0, 150.0, 0, 0, 0]])),
    )


def written(
    program: Program, controller: ControllerSettings = CONTROLLER, max_lines: int | None = None
) -> dict[str, bytes]:
    """The files of a program."""
    return dict(RAPID.write(program, controller, max_lines=max_lines))


def read_module(text: str, folder: Path) -> ProgramText:
    """The program in a module's text."""
    (folder / "part.mod").write_bytes(text.encode("latin-1"))
    return RAPID.read(folder / "part.mod")


def controller(**own: object) -> ControllerSettings:
    """The controller with other settings of RAPID's own; None takes one away."""
    kept = {key: value for key, value in {**OWN, **own}.items() if value is not None}
    return dataclasses.replace(CONTROLLER, own=kept)
