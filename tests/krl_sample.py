"""A small program with everything in it, and helpers, for the KRL tests."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from camrob.cell.controller_settings import ControllerSettings
from camrob.languages.krl import rounding
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.languages.krl.writer.write_krl import iter_krl
from camrob.program.motion import Motion
from camrob.program.program import Program, ProgramEvent, ProgramEventKind
from camrob.program.program_text import ProgramText

OWN = {
    "ori_type": "#VAR",
    "circ_type": "#BASE",
    "base_template": "EK(MACHINE_DEF[2].ROOT, MACHINE_DEF[2].MECH_TYPE, {base})",
    "act_ex_ax": 2,
    "tool_number": 3,
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
    max_line_length=255,
    hooks={
        "spindle_on": ("$ANOUT[1] = {speed} / 24000.0", "$OUT[5] = TRUE"),
        "spindle_off": ("$OUT[5] = FALSE",),
        "tool_change": ("TOOL_CHANGE ({number})",),
        "header": ("$OUT[1] = TRUE",),
        "footer": ("$OUT[1] = FALSE",),
    },
    own=OWN,
)


def make_program(
    kind: list[Motion], *, safe: list[int] = (), events: tuple[ProgramEvent, ...] = (), **changes
) -> Program:
    """A program of the given motions along a curve."""
    n = len(kind)
    k = np.arange(n, dtype=np.float64)
    pose, external = rounding.pose(
        np.stack(
            [100 * np.cos(k / 7), -100 * np.sin(k / 7), 0.1 * k - 0.0004, 179.5 + k / 3, -k / 50, 20.42 - k], axis=1
        ),
        np.stack([-1.5 * k, 350.0 + 4.321 * k], axis=1),
    )
    kinds = np.array(kind, dtype=np.int8)
    ptp = kinds <= Motion.PTP_POSE
    safe_rows = np.zeros(n, dtype=bool)
    safe_rows[list(safe)] = True
    program = Program(
        name="Flügel 3",
        kind=kinds,
        pose=pose,
        axes=rounding.axes(np.tile([0.0, -90.0, 90.0, -1e-9, 12.34567, 0.0], (n, 1))),
        external=external,
        external_names=("E1", "E2"),
        status=np.full(n, 2),
        turn=np.full(n, 35),
        speed=rounding.speed(np.where(ptp, 0.0, (1500 + 500 * ((k // 3) % 2)) / 60000)),
        approximate=(kinds == Motion.LIN) | (kinds == Motion.CIRC_END),
        line=10 * np.arange(n) + 10,
        region=np.zeros(n),
        safe=safe_rows,
        tool=np.array([0.0, -41.764, 415.578, 0.0, 0.0, -159.58]),
        base=np.array([12.3, 0.0, -0.0, 90.0, 0.0, 0.0]),
    )
    return dataclasses.replace(program, events=events, **changes)


def small_program(texts: tuple[str, str, str, str] = ("Flügel 3", "made for a test", "a remark", "rough")) -> Program:
    """Every kind of motion and event; `texts` are its name, its comment, an event's comment and a fold's title."""
    lin, kinds = Motion.LIN, ProgramEventKind
    events = (
        ProgramEvent(1, kinds.HOOK, "tool_change", 7),
        ProgramEvent(2, kinds.HOOK, "spindle_on", 12000.0),
        ProgramEvent(2, kinds.HOOK, "coolant_on"),
        ProgramEvent(2, kinds.REGION, texts[3]),
        ProgramEvent(2, kinds.COMMENT, texts[2]),
        ProgramEvent(5, kinds.DWELL, value=1.25),
        ProgramEvent(8, kinds.REGION, texts[3]),
        ProgramEvent(10, kinds.REGION, ""),
        ProgramEvent(10, kinds.HOOK, "spindle_off"),
    )
    kind = [Motion.PTP_AXES, Motion.PTP_POSE, lin, lin, Motion.CIRC_VIA, lin, lin, Motion.PTP_POSE, lin, lin]
    kind[4:6] = [lin, Motion.CIRC_VIA]
    kind[6] = Motion.CIRC_END
    return make_program(kind, safe=[6, 9], events=events, name=texts[0], comment=(texts[1],))


def read_back(files: dict[str, bytes], folder: Path) -> ProgramText:
    """The files, written into `folder` and read."""
    for name, content in files.items():
        (folder / name).write_bytes(content)
    return read_krl(folder / next(iter(files)))


def written(
    program: Program, controller: ControllerSettings = CONTROLLER, max_lines: int | None = None
) -> dict[str, bytes]:
    return dict(iter_krl(program, controller, max_lines=max_lines))


def assert_same(program: Program, read: ProgramText) -> None:
    """Every number that was printed came back."""
    ptp_axes = program.kind == Motion.PTP_AXES
    assert read.kind.tolist() == program.kind.tolist()
    assert np.array_equal(read.pose[~ptp_axes], program.pose[~ptp_axes]) and np.isnan(read.pose[ptp_axes]).all()
    assert np.array_equal(read.axes[ptp_axes], program.axes[ptp_axes]) and np.isnan(read.axes[~ptp_axes]).all()
    assert read.external_names == program.external_names
    assert np.array_equal(read.external, program.external)
    posed = program.kind == Motion.PTP_POSE
    assert np.array_equal(read.status, np.where(posed, program.status, -1))
    assert np.array_equal(read.turn, np.where(posed, program.turn, -1))
    assert np.array_equal(read.blend == 2, program.approximate)
    end = np.append(program.speed[1:], 0.0)
    assert np.array_equal(read.speed, np.where(program.kind == Motion.CIRC_VIA, end, program.speed))
