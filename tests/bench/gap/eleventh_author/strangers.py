"""What no library names: only the place can be told."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from .stages import Cause, Truth

__all__ = [
    "bent_beam",
    "creeping_bearing",
    "current_limit",
    "dirty_disc",
    "haze",
    "hose",
    "loose_changer",
    "rack_joint",
    "shaft_key",
]

BODY, DRIVE = "encoder_to_tcp", "setpoint_to_encoder"


def _foreign(name, axes, stage, follows, act, unit, mm, told, step, order=1):
    return Cause(
        name, axes, stage, follows, act, unit, mm, told, step, "what a library's name would ask for", (), True, order
    )


def hose(mm: float) -> Cause:
    """A hose over the wrist, slack up to a turn of the fourth axis, then a spring that pulls the fifth."""

    def act(truth: Truth, s: float) -> None:
        i, k = truth.robot.index("A4"), truth.robot.index("A5")
        pull = np.maximum(np.abs(truth.enc[:, i] - 0.2) - 0.5, 0.0)
        truth.link[:, k] += s * pull * np.cos(truth.enc[:, k])

    return _foreign(
        "hose on the wrist",
        ("A4", "A5"),
        BODY,
        ("position",),
        act,
        2e-3,
        mm,
        "a hose pulls beyond a turn of A4",
        "look at the dress pack, give it slack",
    )


def creeping_bearing(mm: float) -> Cause:
    """An outer race that creeps along in its seat with the way that the first axis has gone."""

    def act(truth: Truth, s: float) -> None:
        i = truth.robot.index("A1")
        moved = (
            np.abs(truth.run.way[:, i])
            if truth.run.poses
            else np.abs(np.diff(truth.enc[:, i], prepend=truth.enc[0, i]))
        )
        gone = np.cumsum(moved)
        truth.link[:, i] += s * gone / gone[-1]

    return _foreign(
        "creeping bearing seat",
        ("A1",),
        BODY,
        ("time",),
        act,
        1e-3,
        mm,
        "the base turns under its gear, a little each turn",
        "mark gear and casting, look at the bolts of A1",
    )


def rack_joint(at: float, mm: float) -> Cause:
    """Two racks meet with a gap: beyond the joint the carriage is off, and jumps back at a second."""

    def act(truth: Truth, s: float) -> None:
        i = truth.robot.index("E1")
        x = truth.enc[:, i]
        step = 0.5 * (1 + np.tanh((x - at) / 25.0)) - 0.6 * 0.5 * (1 + np.tanh((x - at - 1900) / 25.0))
        truth.link[:, i] += s * step

    return _foreign(
        "gap at a rack's joint",
        ("E1",),
        BODY,
        ("position",),
        act,
        0.5,
        mm,
        "racks joined with a gap",
        "look at the joints of the rack with a pin gauge",
    )


def haze(mm: float) -> Cause:
    """Warm air before an oven's door bends the beam: in a corner of the cell, and when the door is open."""

    def act(truth: Truth, s: float) -> None:
        def read(T, t, setup):
            out = T.copy()
            d = np.linalg.norm(T[:, :3, 3] - setup["oven"], axis=1)
            door = 0.5 * (1 + np.sign(np.sin(2 * np.pi * t / 610.0 + 1.0)))
            bend = s * door * np.exp(-((d / 700.0) ** 2))
            out[:, 2, 3] += bend
            out[:, 1, 3] -= 0.4 * bend
            return out

        truth.reading.append(read)

    return _foreign(
        "hot air before the beam",
        (),
        BODY,
        ("position", "time"),
        act,
        1.0,
        mm,
        "an oven's door opens into the beam",
        "shut the door, shield the beam",
    )


def current_limit(name: str, mm: float) -> Cause:
    """A drive whose current is cut off: above a torque it just doesn't follow, and catches up later."""

    def act(truth: Truth, s: float) -> None:
        i = truth.robot.index(name)
        dt = truth.t[1] - truth.t[0]
        acc = np.gradient(np.gradient(truth.run.q[:, i], dt), dt)
        need = np.abs(acc) / (np.percentile(np.abs(acc), 99) + 1e-12)
        over = np.sign(acc) * np.maximum(need - 0.45, 0.0)
        keep = np.exp(-dt / 0.12)
        truth.enc[:, i] -= s * lfilter([1 - keep], [1, -keep], over)

    return _foreign(
        "current cut off",
        (name,),
        DRIVE,
        ("acceleration",),
        act,
        5e-3,
        mm,
        "a current limit left from commissioning",
        "read the drive's current limit and its alarms",
        0,
    )


def dirty_disc(name: str, at: float, mm: float) -> Cause:
    """Oil on a sector of an encoder's disc: in it the axis really stands elsewhere than is read."""

    def act(truth: Truth, s: float) -> None:
        i = truth.robot.index(name)
        x = (truth.enc[:, i] - at + np.pi) % (2 * np.pi) - np.pi
        truth.link[:, i] += s * (np.abs(x) < 0.3) * (0.7 + 0.3 * np.cos(60 * x))

    return _foreign(
        "dirt on an encoder's disc",
        (name,),
        BODY,
        ("position",),
        act,
        1e-3,
        mm,
        "in one sector the encoder reads wrong",
        "clean or exchange the encoder of this axis",
    )


def loose_changer(mm: float) -> Cause:
    """A tool changer with worn pins: the tool falls to one side of its seat or the other, as gravity asks."""

    def act(truth: Truth, s: float) -> None:
        tip = truth.robot.tip(truth.run.q)
        down = -tip[:, 2, :3]  # of gravity along the tool's axes
        side = np.tanh(down / 0.15) * np.array([1.0, 0.5, 0.0])
        truth.shift += s * np.einsum("nij,nj->ni", tip[:, :3, :3], side)

    return _foreign(
        "worn tool changer",
        (),
        BODY,
        ("load", "position"),
        act,
        0.2,
        mm,
        "the tool rocks in its changer",
        "rock the tool by hand, look at the changer's pins and air",
    )


def shaft_key(name: str, mm: float) -> Cause:
    """A key that was sheared: the gear slips on its shaft once, in the middle of the run, and stays there."""

    def act(truth: Truth, s: float) -> None:
        i = truth.robot.index(name)
        truth.link[:, i] += s * (np.arange(truth.n) > 0.55 * truth.n)

    return _foreign(
        "slipped on its shaft",
        (name,),
        BODY,
        ("time",),
        act,
        1e-3,
        mm,
        "a gear slipped on its shaft at a moment",
        "mark shaft and gear, look at clamp and key",
    )


def bent_beam(mm: float) -> Cause:
    """A gantry's beam sags between its posts, most in the middle."""

    def act(truth: Truth, s: float) -> None:
        robot = truth.robot
        j = robot.joints[1]
        u = (truth.enc[:, 1] - j.low) / (j.high - j.low)
        down = -np.sin(np.pi * u) - 0.15 * np.sin(3 * np.pi * u)
        truth.shift[:, 2] += s * down

    return _foreign(
        "a beam that sags",
        ("A2",),
        BODY,
        ("position",),
        act,
        0.1,
        mm,
        "the beam sags between its posts",
        "measure the beam with a level, support it",
    )
