"""What gives under weight, push and heat."""

from __future__ import annotations

import numpy as np

from .robots import nudge
from .stages import Cause, Truth

__all__ = ["cutter_pushes", "give", "heavier_than_told", "sways", "warming"]

BODY = "encoder_to_tcp"


def give(shares: dict[str, float], mm: float, alike=("payload",), hardens: float = 0.25) -> Cause:
    """Gears give under gravity, stiffer the more they carry."""

    def act(truth: Truth, s: float) -> None:
        load = truth.load
        for name, share in shares.items():
            i = truth.robot.index(name)
            most = np.max(np.abs(load[:, i])) + 1e-9
            truth.link[:, i] += s * share * load[:, i] * (1 - hardens * (load[:, i] / most) ** 2)

    return Cause(
        "joint_compliance",
        tuple(shares),
        BODY,
        ("load",),
        act,
        1e-6,
        mm,
        "gears give under the weight",
        "nothing to adjust: correct it in the programs (look at the gear's bearing if it grew)",
        "mastering, exchanging links",
        alike,
    )


def heavier_than_told(mm: float, alike=("joint_compliance",)) -> Cause:
    """Something on the flange that the controller's load data leave out: its drives give as ever, for more."""

    def act(truth: Truth, s: float) -> None:
        more = truth.robot.load(truth.run.q, s, own=False)
        truth.link += more * np.array([j.soft for j in truth.robot.joints])

    return Cause(
        "payload",
        (),
        BODY,
        ("load",),
        act,
        10.0,
        mm,
        "a gripper heavier than the load data tell",
        "weigh tool and part, enter the load data",
        "mastering, opening gears",
        alike,
    )


def sways(before: str, mm: float, alike=(), vertical: bool = True) -> Cause:
    """What carries the arm leans with the moment of weight about it."""

    def act(truth: Truth, s: float) -> None:
        robot = truth.robot
        i = robot.index(before)
        links = robot.behind(truth.run.q)
        at = links[i][:, :3, 3]
        moment = np.zeros((truth.n, 3))
        for lump in robot.lumps:
            T = links[lump.after]
            c = T[:, :3, :3] @ np.array(lump.at) + T[:, :3, 3]
            moment += np.cross(c - at, np.array([0, 0, -9.81 * lump.kg])) / 1000.0
        tip = (links[-1] @ robot.flange)[:, :3, 3]
        moment += np.cross(tip - at, np.array([0, 0, -9.81 * (robot.payload + truth.run.held)])) / 1000.0
        up = at[:, 2:3] / 1000.0 if vertical else 1.0
        turn = np.einsum("nji,nj->ni", _still(robot, i, links), s * moment * (0.4 + up))
        truth.bend(i, nudge(np.zeros(3), turn))

    return Cause(
        "lean",
        (before,),
        BODY,
        ("load", "position"),
        act,
        1e-6,
        mm,
        "column or carriage gives under the moment",
        "look at bolts, guides and preload of column or carriage",
        "mastering",
        alike,
    )


def _still(robot, i, links):
    """Orientation of the frame before joint i's motion."""
    before = links[i - 1] if i else np.broadcast_to(np.eye(4), links[0].shape)
    return (before @ robot.joints[i].pre)[:, :3, :3]


def cutter_pushes(shares: dict[str, float], mm: float, alike=("joint_compliance",)) -> Cause:
    """What the logged force bends."""

    def act(truth: Truth, s: float) -> None:
        held = truth.robot.load(truth.run.q, 0.0, push=truth.run.push, own=False)
        for name, share in shares.items():
            i = truth.robot.index(name)
            truth.link[:, i] += s * share * held[:, i]

    return Cause(
        "cutting_force",
        tuple(shares),
        BODY,
        ("force",),
        act,
        1e-6,
        mm,
        "the cutter's force bends the arm",
        "lower feed or depth of cut, or correct the programs for the force",
        "mastering, tuning drives",
        alike,
    )


def warming(mm: float, tau=(700.0, 5200.0), creep: str | None = "A2", alike=()) -> Cause:
    """Links grow with their length, castings fast and slow; one axis creeps along. Skin temperature is what a log shows."""

    def act(truth: Truth, s: float) -> None:
        t = truth.t
        heat = 0.6 * (1 - np.exp(-t / tau[0])) + 0.4 * (1 - np.exp(-t / tau[1]))
        truth.run.warm = 21.0 + 17.0 * (1 - np.exp(-t / (0.8 * tau[0])))
        for i, j in enumerate(truth.robot.joints):
            if i and j.role == "arm":
                truth.bend(i, nudge(s * heat[:, None] * (j.pre[:3, :3].T @ j.pre[:3, 3]), np.zeros(3)))
        if creep:
            truth.link[:, truth.robot.index(creep)] += 0.6 * s * heat

    return Cause(
        "thermal_drift",
        (),
        BODY,
        ("time",),
        act,
        2e-4,
        mm,
        "measured from cold on",
        "run warm before measuring and working, or measure and correct warm",
        "mastering, opening gears",
        alike,
    )
