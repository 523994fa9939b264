"""What the instrument makes of it, and causes behind the encoders that have no name."""

from __future__ import annotations

import numpy as np

from .chain import inverse, small
from .truth import Cause, Truth

__all__ = [
    "crane_passes",
    "dress_pack",
    "late_stamps",
    "long_rods",
    "long_yardstick",
    "loose_flange",
    "moved_too_soon",
    "slips",
    "stand_sinks",
]

D = np.pi / 180.0
_STAGE = "encoder_to_tcp"


def late_stamps(seconds: float) -> Cause:
    """The instrument's stamps and the controller's are of two clocks."""

    def act(truth: Truth) -> None:
        truth.late += seconds

    return Cause(
        "latency",
        _STAGE,
        (),
        ("speed",),
        act,
        "nothing on the robot: bring instrument and controller to one clock (trigger), and measure again",
        "tuning drives, calibrating the arm",
        ("servo_lag", "setpoint_delay"),
    )


def long_yardstick(ppm: float, stand) -> Cause:
    """Distances from the instrument come out too long: wrong air pressure or temperature entered."""

    def read(truth: Truth, T):
        out = T.copy()
        out[:, :3, 3] = stand[:3, 3] + (T[:, :3, 3] - stand[:3, 3]) * (1 + ppm * 1e-6)
        return out

    def act(truth: Truth) -> None:
        truth.reads.append(read)

    return Cause(
        "measurement_scale",
        _STAGE,
        (),
        ("position",),
        act,
        "check the instrument against a bar of known length, and the weather that it was told; nothing on the robot",
        "calibrating the arm by these data",
        ("geometry",),
    )


def stand_sinks(shift, turn_deg, seconds: float, about=(0, 0, 0)) -> Cause:
    """The instrument's stand settles in its first hours: as an exponential of time."""

    def read(truth: Truth, T):
        share = 1 - np.exp(-truth.run.t / seconds)
        turn = small(np.zeros(3), share[:, None] * np.array(turn_deg) * D)
        move = small(np.array(about, float), np.zeros(3)) @ turn @ small(-np.array(about, float), np.zeros(3))
        out = move @ T
        out[:, :3, 3] += share[:, None] * np.array(shift)
        return out

    def act(truth: Truth) -> None:
        truth.reads.append(read)

    return Cause(
        "measurement_drift",
        _STAGE,
        (),
        ("time",),
        act,
        "measure a fixed reference point at the beginning and the end: it moves, too; let the "
        "instrument settle, fix its stand",
        "mending or warming the robot",
        ("thermal_drift",),
    )


def slips(shift, turn_deg, share=0.55) -> Cause:
    """Foreign: the reflector's mount slips on the flange once."""
    E = small(np.array(shift, float), np.array(turn_deg, float) * D)

    def act(truth: Truth) -> None:
        behind = truth.run.t > truth.run.t[0] + share * (truth.run.t[-1] - truth.run.t[0])
        truth.tool = np.where(behind[:, None, None], truth.tool @ E, truth.tool)

    return Cause(
        "target_slips",
        _STAGE,
        (),
        ("time",),
        act,
        "look at the reflector's mount: it moved during the run; fix it and measure again",
        "calibrating or mending the robot by these data",
        ("measurement_drift", "frame_tool"),
        True,
    )


def loose_flange(name: str, play_deg: float, arm_mm: float) -> Cause:
    """Foreign: the gripper's bolts are loose; it tips by its play to whichever side gravity pulls it."""

    def act(truth: Truth) -> None:
        tip = truth.machine.frames(truth.q)[2]
        down = -tip[:, 2, :3]  # gravity's direction in the tool's axes
        side = np.hypot(down[:, 0], down[:, 1])
        tilt = np.tanh(side / 0.12)[:, None] * np.stack([-down[:, 1], down[:, 0], 0 * side], 1) / (side + 1e-9)[:, None]
        hinge = small(np.array([0.0, 0, arm_mm]), np.zeros(3))
        truth.tool = truth.tool @ hinge @ small(np.zeros(3), play_deg / 2 * D * tilt) @ inverse(hinge)

    return Cause(
        "loose_flange",
        _STAGE,
        (name,),
        ("load",),
        act,
        "take hold of the gripper and shake it: its flange is loose; tighten the bolts (torque "
        "wrench), then measure again",
        "mending gears, calibrating the arm",
        ("hysteresis", "joint_compliance", "frame_tool"),
        True,
    )


def dress_pack(name: str, taut_deg: float, mm_rad: float) -> Cause:
    """Foreign: the hose pack is taut when an axis is wound up beyond an angle, and pulls the wrist back towards the elbow."""

    def act(truth: Truth) -> None:
        k = truth.at(name)
        wound = np.clip(np.abs(truth.q[:, k]) - taut_deg * D, 0, None)
        before, _, tip = truth.machine.frames(truth.q)
        pull = before["A3"][:, :3, 3] - tip[:, :3, 3]
        pull /= np.linalg.norm(pull, axis=1)[:, None]
        truth.shift = truth.shift + mm_rad * wound[:, None] * pull

    return Cause(
        "dress_pack",
        _STAGE,
        (name,),
        ("position",),
        act,
        "turn that axis to its ends by hand and look at the hose pack: it is taut there; lengthen or re-route it",
        "mastering, opening gears",
        (),
        True,
    )


def crane_passes(shift, turn_deg, begin: float, end: float) -> Cause:
    """Foreign: a hall crane stands beside the robot for a while, and the floor gives."""

    def act(truth: Truth) -> None:
        t = truth.run.t
        soft = 0.04 * (t[-1] - t[0])
        b, e = t[0] + begin * (t[-1] - t[0]), t[0] + end * (t[-1] - t[0])
        there = 0.5 * (np.tanh((t - b) / soft) - np.tanh((t - e) / soft))
        truth.world = small(there[:, None] * np.array(shift), there[:, None] * np.array(turn_deg) * D) @ truth.world

    return Cause(
        "crane_passes",
        _STAGE,
        (),
        ("time",),
        act,
        "find out what happened in the hall while the error stood (crane, truck): look at the "
        "foundation, measure a fixed point beside",
        "calibrating or mending the robot by these data",
        ("measurement_drift",),
        True,
    )


def long_rods(drive: int, more_mm: float, rod=650.0, out=220.0) -> Cause:
    """Foreign: a linear delta whose controller gives x, y, z as axes; the rods of one of its columns are too long."""
    phi = 2 * np.pi * np.arange(3) / 3
    foot = np.stack([out * np.cos(phi), out * np.sin(phi)], 1)

    def act(truth: Truth) -> None:
        x = np.stack([truth.q[:, 0], truth.q[:, 1], -truth.q[:, 2]], 1)  # in world: the third axis goes down
        flat = np.sum((x[:, None, :2] - foot) ** 2, axis=2)
        slide = x[:, 2:] + np.sqrt(rod**2 - flat)  # where the carriages are, by the controller
        rods = np.full(3, rod)
        rods[drive] += more_mm
        here = x.copy()
        for _ in range(8):
            rel = here[:, None, :] - np.concatenate([np.broadcast_to(foot, (len(x), 3, 2)), slide[:, :, None]], 2)
            length = np.linalg.norm(rel, axis=2)
            here = here + np.linalg.solve(rel / length[:, :, None], (rods - length)[:, :, None])[:, :, 0]
        truth.shift = truth.shift + here - x

    return Cause(
        "delta_rods",
        _STAGE,
        (),
        ("position",),
        act,
        "measure the rods of all three arms (or calibrate the delta by its own model): one pair is "
        "longer than the controller was told",
        "fitting a serial arm's links to it, mending gears",
        ("geometry",),
        True,
    )


def moved_too_soon(name: str, share: float) -> Cause:
    """Positions are read before the axis has come to rest: what is left of the last move."""

    def act(truth: Truth) -> None:
        truth.link[:, truth.at(name)] -= (
            share * truth.run.last[:, truth.at(name)] * np.sqrt(np.abs(truth.run.extra["moves"][:, truth.at(name)]))
        )

    return Cause(
        "early_reading",
        _STAGE,
        (name,),
        ("direction",),
        act,
        "wait longer at each pose before reading (a second), and measure a few poses again: the error goes",
        "mending the gear, mastering",
        ("backlash", "hysteresis"),
    )
