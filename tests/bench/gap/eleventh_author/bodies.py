"""What is wrong behind the encoders: zeros, links, gears, feet, carriages, tables."""

from __future__ import annotations

import numpy as np

from .robots import nudge
from .stages import Cause, Truth

__all__ = [
    "belt_wheel",
    "bent_links",
    "knocked_tool",
    "lost_zero",
    "moved_foot",
    "plate_wobbles",
    "play",
    "shifted_plate",
    "slip_inside",
    "track_shape",
    "wrist_mixed",
]

BODY = "encoder_to_tcp"
D = np.pi / 180


def lost_zero(degrees: dict[str, float], mm: float, alike=()) -> Cause:
    """Zeros off, by degrees (mm)."""

    def act(truth: Truth, s: float) -> None:
        for name, x in degrees.items():
            i = truth.robot.index(name)
            truth.link[:, i] += s * x * (1.0 if truth.robot.joints[i].slides else D)

    return Cause(
        "joint_offset",
        tuple(degrees),
        BODY,
        ("constant", "position"),
        act,
        0.05,
        mm,
        "mastering lost, put back by eye",
        "master these axes again (cartridge, pin or marks), then measure once more",
        "opening gears, changing link lengths",
        alike,
    )


def bent_links(at: dict[str, tuple], mm: float, alike=(), told="a link bent or exchanged") -> Cause:
    """Frames before axes off: (mm, mm, mm, mrad, mrad, mrad) in the frame of that axis."""

    def act(truth: Truth, s: float) -> None:
        for name, x in at.items():
            i = truth.robot.index(name)
            truth.bend(i, nudge(s * np.array(x[:3]), s * 1e-3 * np.array(x[3:])))

    return Cause(
        "geometry",
        tuple(at),
        BODY,
        ("position",),
        act,
        0.5,
        mm,
        told,
        "look at the arm for a bent or exchanged link, calibrate it, compensate its programs",
        "opening gears, tuning drives",
        alike,
    )


def _follow(x, half):
    out, now = np.empty(len(x)), x[0]
    for k in range(len(x)):
        now = min(max(now, x[k] - half), x[k] + half)
        out[k] = now
    return out


def play(widths: dict[str, float], mm: float, alike=()) -> Cause:
    """Whole play by degrees (mm). Of poses the last move's side decides."""

    def act(truth: Truth, s: float) -> None:
        for name, x in widths.items():
            i = truth.robot.index(name)
            half = 0.5 * s * x * (1.0 if truth.robot.joints[i].slides else D)
            if truth.run.poses:
                way = truth.run.way[:, i]
                truth.link[:, i] -= np.where(np.abs(way) > 2 * half, half * np.sign(way), 0.0)
            else:
                truth.link[:, i] += _follow(truth.enc[:, i], half) - truth.enc[:, i]

    return Cause(
        "backlash",
        tuple(widths),
        BODY,
        ("direction",),
        act,
        0.03,
        mm,
        "play behind the encoder",
        "measure lost motion of this axis with a dial gauge, take up or exchange the gear",
        "mastering, changing link lengths",
        alike,
    )


def slip_inside(shares: dict[str, float], mm: float, alike=("backlash",)) -> Cause:
    """Strain wave gears: a loop of many small plays, from 0.02 to 0.3 rad wide (or mm hundreds of it)."""

    def act(truth: Truth, s: float) -> None:
        for name, share in shares.items():
            i = truth.robot.index(name)
            for width, part in zip((0.02, 0.06, 0.14, 0.3), (0.3, 0.3, 0.25, 0.15), strict=True):
                truth.link[:, i] += s * share * part * (_follow(truth.enc[:, i], width) - truth.enc[:, i]) / width

    return Cause(
        "hysteresis",
        tuple(shares),
        BODY,
        ("direction",),
        act,
        5e-4,
        mm,
        "a strain wave gear with much hysteresis",
        "measure the gear's loop with a dial gauge and a spring balance; exchange it or come to all points from one side",
        "mastering",
        alike,
    )


def belt_wheel(name: str, waves, mm: float, alike=(), told="an eccentric wheel or gear") -> Cause:
    """Waves of the axis's own turn: (periods in a turn or in 1000 mm, share, phase)."""

    def act(truth: Truth, s: float) -> None:
        i = truth.robot.index(name)
        turn = truth.enc[:, i] * (2 * np.pi / 1000 if truth.robot.joints[i].slides else 1.0)
        for order, share, phase in waves:
            truth.link[:, i] += s * share * np.sin(order * turn + phase)

    return Cause(
        "gear_ripple",
        (name,),
        BODY,
        ("position",),
        act,
        5e-4,
        mm,
        told,
        "run this axis alone against a dial gauge or level over a turn; look at wheel, gear or screw",
        "mastering, tuning drives",
        alike,
    )


def wrist_mixed(factors: dict[tuple[str, str], float], mm: float, alike=()) -> Cause:
    """A wrist axis turned along by another: (turned, by) and factor."""

    def act(truth: Truth, s: float) -> None:
        for (name, by), x in factors.items():
            k = truth.robot.index(by)
            truth.link[:, truth.robot.index(name)] += s * x * truth.enc[:, k]

    names = tuple(dict.fromkeys(a for a, _ in factors))
    return Cause(
        "wrist_coupling",
        names,
        BODY,
        ("position",),
        act,
        2e-3,
        mm,
        "coupling factors of another wrist",
        "enter the wrist's coupling factors at the controller",
        "opening gears, mastering",
        alike,
    )


def track_shape(mm: float, pitch: float = 0.0, bow: float = 0.0, yaw: float = 0.0, sag: float = 0.0, alike=()) -> Cause:
    """A track whose pitch is off, that is bowed sideways, sags, and turns what it carries: shares of mm over its length."""

    def act(truth: Truth, s: float) -> None:
        robot = truth.robot
        i = robot.index("E1")
        j = robot.joints[i]
        u = (truth.enc[:, i] - j.low) / (j.high - j.low) * 2 - 1
        along = pitch * u
        side, down = bow * (u**2 + 0.3 * np.sin(4.5 * u)), sag * (u**2 - 0.25 * u**4)
        off = nudge(s * np.stack([side, down, along], 1), 1e-3 * s * yaw * np.stack([0 * u, u**2, 0 * u], 1))
        fixed = robot.joints[i + 1].pre
        truth.bend(i + 1, np.linalg.inv(fixed) @ off @ fixed)

    return Cause(
        "track",
        ("E1",),
        BODY,
        ("position",),
        act,
        0.5,
        mm,
        "rails laid badly, or a rack of another pitch",
        "measure the rails with level and tracker, align them; or enter the pitch",
        "mastering the arm",
        alike,
    )


def moved_foot(move, mrad, mm: float, alike=("measurement_frame",)) -> Cause:
    """The robot does not stand where its frame says."""

    def act(truth: Truth, s: float) -> None:
        truth.foot = nudge(s * np.array(move), 1e-3 * s * np.array(mrad))[0] @ truth.foot

    return Cause(
        "frame_base",
        (),
        BODY,
        ("constant", "position"),
        act,
        1.0,
        mm,
        "the robot's foot is not where its frame says",
        "measure the robot's place again and enter it",
        "mastering, opening gears",
        alike,
    )


def knocked_tool(move, mrad, mm: float, alike=()) -> Cause:
    """The tool's tip is elsewhere."""

    def act(truth: Truth, s: float) -> None:
        truth.tool = truth.tool @ nudge(s * np.array(move), 1e-3 * s * np.array(mrad))[0]

    return Cause(
        "frame_tool",
        (),
        BODY,
        ("constant", "position"),
        act,
        1.0,
        mm,
        "the tool was knocked",
        "measure the tool again (four points or gauge), straighten or enter it",
        "mastering, opening gears",
        alike,
    )


def shifted_plate(move, mrad, mm: float, alike=()) -> Cause:
    """The table's axis stands elsewhere and leans: move and turn of the axis, in the floor's frame."""

    def act(truth: Truth, s: float) -> None:
        off = nudge(s * np.array(move), 1e-3 * s * np.array(mrad))
        turned = truth.robot.plate(truth.enc)
        truth.plate = np.linalg.inv(turned) @ off @ turned @ np.linalg.inv(off)  # the base was taken at 0

    return Cause(
        "frame_table",
        ("E2",),
        BODY,
        ("position", "constant"),
        act,
        1.0,
        mm,
        "the table's axis is not where its frame says",
        "measure the table's axis by a target on its plate over a turn, enter it",
        "mastering",
        (*alike, "frame_base"),
    )


def plate_wobbles(mm: float, tilt=(0.4, 0.15), out=(0.06, 0.03), alike=()) -> Cause:
    """The plate's bearing: it tilts and runs out once and twice in a turn (mrad, mm)."""

    def act(truth: Truth, s: float) -> None:
        q = truth.enc[:, truth.robot.index("E2")]
        one, two = (
            np.stack([np.cos(q), np.sin(q), 0 * q], 1),
            np.stack([np.cos(2 * q + 1), np.sin(2 * q + 1), 0 * q], 1),
        )
        turned = truth.robot.plate(truth.enc)
        off = nudge(s * (out[0] * one + out[1] * two), 1e-3 * s * (tilt[0] * one + tilt[1] * two))
        truth.plate = np.linalg.inv(turned) @ off @ turned

    return Cause(
        "turntable",
        ("E2",),
        BODY,
        ("position",),
        act,
        1.0,
        mm,
        "a worn bearing below the plate",
        "clock the plate with a dial gauge over a turn, axial and radial; look at its bearing",
        "mastering the arm",
        (*alike, "frame_table"),
    )
