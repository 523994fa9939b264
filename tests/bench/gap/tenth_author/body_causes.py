"""What goes wrong behind the encoders: zeros, links, what gives under weight, gears, warmth. Each from its mechanics."""

from __future__ import annotations

import numpy as np

from .chain import small
from .truth import Cause, Truth

__all__ = [
    "bent",
    "coupled_wrist",
    "gears_give",
    "leans",
    "loops",
    "other_load",
    "play",
    "rail",
    "ripple",
    "shifted_foot",
    "shifted_tool",
    "warm_links",
    "warm_screw",
    "zeros",
]

D = np.pi / 180.0
_STAGE = "encoder_to_tcp"


def zeros(**degrees: float) -> Cause:
    """Zeros of axes that are off since a crash or a wrong mastering (degrees; mm of what slides)."""

    def act(truth: Truth) -> None:
        for name, value in degrees.items():
            k = truth.at(name)
            truth.link[:, k] += value * (D if truth.machine.joints[k].kind == "R" else 1.0)

    return Cause(
        "joint_offset",
        _STAGE,
        tuple(degrees),
        ("constant", "position"),
        act,
        "master these axes again (gauge cartridge or marks), or enter the offsets found; then measure once more",
        "opening gears, changing link lengths",
    )


def bent(rows: dict[str, tuple], alike=()) -> Cause:
    """Links that are bent or were made otherwise: by joint alpha (degrees), a, theta (degrees), d (mm) more than told."""

    def act(truth: Truth) -> None:
        for name, (alpha, a, theta, d) in rows.items():
            truth.rows[name] = truth.rows.get(name, np.zeros(4)) + np.array([alpha * D, a, theta * D, d])

    return Cause(
        "geometry",
        _STAGE,
        tuple(rows),
        ("position",),
        act,
        "look at the arm for a bent or exchanged link, then calibrate it and let programs be compensated",
        "opening gears, tuning drives",
        alike,
    )


def shifted_foot(shift, turn_deg) -> Cause:
    """The robot was pushed, or set down anew: its foot stands elsewhere than told."""
    E = small(np.array(shift, float), np.array(turn_deg, float) * D)

    def act(truth: Truth) -> None:
        truth.world = E @ truth.world

    return Cause(
        "frame_base",
        _STAGE,
        (),
        ("constant",),
        act,
        "measure the robot's base frame anew (three points in the cell), look at its anchor bolts",
        "mastering axes, calibrating links",
        ("measurement_frame",),
    )


def shifted_tool(shift, turn_deg=(0, 0, 0)) -> Cause:
    """A tool that was bent or changed: its tip is elsewhere on the flange than told."""
    E = small(np.array(shift, float), np.array(turn_deg, float) * D)

    def act(truth: Truth) -> None:
        truth.tool = truth.tool @ E

    return Cause(
        "frame_tool",
        _STAGE,
        (),
        ("constant", "position"),
        act,
        "measure the tool centre point anew (four points about a tip), look whether the tool is bent",
        "mastering axes, calibrating links",
    )


def gears_give(micro: dict[str, float], hard=0.0) -> Cause:
    """Gears that give under weight (microrad a Nm), harder the more they are loaded."""

    def act(truth: Truth) -> None:
        tau = truth.machine.weight(truth.q, truth.run.held, (0, 0, 80))
        for name, value in micro.items():
            k = truth.at(name)
            truth.link[:, k] += (
                value * 1e-6 * tau[:, k] / (1 + hard * np.abs(tau[:, k]) / (1e-9 + np.max(np.abs(tau[:, k]))))
            )

    return Cause(
        "joint_compliance",
        _STAGE,
        tuple(micro),
        ("load",),
        act,
        "hang a known weight on the flange and read a dial gauge with these axes; then enter the "
        "stiffness (compensation), or mend the gear that is too soft",
        "mastering axes, changing frames",
        ("payload",),
    )


def other_load(kg: float, center, micro: dict[str, float]) -> Cause:
    """The controller takes off the sag of the load that it was told; there hangs `kg` more at `center` (mm off the flange)."""

    def act(truth: Truth) -> None:
        more = truth.machine.weight(truth.q, kg, center) - truth.machine.weight(truth.q, 0.0)
        for name, value in micro.items():
            k = truth.at(name)
            truth.link[:, k] += value * 1e-6 * more[:, k]

    return Cause(
        "payload",
        _STAGE,
        (),
        ("load",),
        act,
        "weigh the tool and what it holds; enter mass and centre in the controller's load data (load determination)",
        "mending gears, mastering axes",
        ("joint_compliance",),
    )


def leans(micro_rad_nm: float, side=1.0) -> Cause:
    """What the arm stands on leans with the weight's moment about its foot."""

    def act(truth: Truth) -> None:
        m = truth.machine
        before, behind, _ = m.frames(truth.q)
        first = next(j.name for j in m.joints if j.role == "arm")
        foot, last = before[first], m.names[-1]
        moment = np.zeros((len(truth.q), 3))
        loads = [(behind[x.after] @ np.array([*x.center, 1.0]), x.kg) for x in m.masses]
        loads.append((behind[last][:, :, 3], truth.run.held))
        for place, kg in loads:
            moment += np.cross((place[:, :3] - foot[:, :3, 3]) / 1000.0, np.array([0, 0, -9.81 * kg]))
        here = (
            np.einsum("nij,ni->nj", foot[:, :3, :3], moment) * np.array([micro_rad_nm, micro_rad_nm * side, 0.0]) * 1e-6
        )
        truth.foot = truth.foot @ small(np.zeros(3), here)

    return Cause(
        "lean",
        _STAGE,
        (),
        ("load",),
        act,
        "put a level or a dial gauge at the pedestal (column, carriage) while the arm reaches out "
        "to each side; tighten or stiffen what it stands on",
        "mastering axes, mending gears",
        ("joint_compliance",),
    )


def rail(name: str, scale_um_m=0.0, dip_mm=0.0, at=0.0, wide=600.0, side_mm=0.0) -> Cause:
    """A rail whose ground settles about a place: the carriage goes down and pitches with the slope; its scale, a bow aside."""

    def act(truth: Truth) -> None:
        k = truth.at(name)
        x = truth.q[:, k]
        joint = truth.machine.joints[k]
        truth.link[:, k] += scale_um_m * 1e-6 * (x - joint.low)
        low = 1 / (1 + np.exp(-(x - at) / (wide / 4)))  # what lies beyond has gone down: a step, not a bump
        slope = low * (1 - low) / (wide / 4)
        bow = side_mm * np.sin(np.pi * (x - joint.low) / (joint.high - joint.low))
        before, _, _ = truth.machine.frames(truth.q)
        along = before[name][:, :3, 2]
        up = np.broadcast_to([0.0, 0.0, 1.0], along.shape)
        across = np.cross(up, along)
        first = next(j.name for j in truth.machine.joints if j.role == "arm")
        to_foot = np.swapaxes(before[first][:, :3, :3], 1, 2)
        shift = np.einsum("nij,nj->ni", to_foot, -dip_mm * low[:, None] * up + bow[:, None] * across)
        turn = np.einsum("nij,nj->ni", to_foot, across * (dip_mm * slope)[:, None])
        truth.foot = truth.foot @ small(shift, turn)

    return Cause(
        "track",
        _STAGE,
        (name,),
        ("position",),
        act,
        "run the carriage along the rail with a level and an indicator (or the tracker) on it; "
        "align or shim the rail where it is off",
        "mastering the arm, mending its gears",
    )


def play(widths_deg: dict[str, float]) -> Cause:
    """Play behind the encoder: the link lags by half of it whichever way the axis went last."""

    def act(truth: Truth) -> None:
        for name, width in widths_deg.items():
            k = truth.at(name)
            half = width * D / 2
            if truth.run.poses:
                truth.link[:, k] -= half * truth.run.last[:, k]
                continue
            x, now = truth.q[:, k], truth.q[0, k]
            out = np.zeros(len(x))
            for i, m in enumerate(x):
                now = min(max(now, m - half), m + half)
                out[i] = now
            truth.link[:, k] += out - x

    return Cause(
        "backlash",
        _STAGE,
        tuple(widths_deg),
        ("direction",),
        act,
        "hold that axis' motor by its brake and move the link to and fro with a dial gauge on it; "
        "adjust or change the gear",
        "mastering, changing frames",
        ("hysteresis",),
    )


def loops(name: str, size_deg: float, reach_deg=(0.2, 1.0, 4.0)) -> Cause:
    """Hysteresis by three slipping springs that let go one behind the other."""

    def act(truth: Truth) -> None:
        k = truth.at(name)
        x, sizes = truth.q[:, k] / D, np.array(reach_deg)
        spring, out = np.zeros(3), np.zeros(len(truth.q))
        for i in range(len(x)):
            spring = np.clip(spring + (x[i] - x[max(i - 1, 0)]), -sizes, sizes)
            out[i] = np.mean(spring / sizes)
        truth.link[:, k] -= size_deg / 2 * D * out

    return Cause(
        "hysteresis",
        _STAGE,
        (name,),
        ("direction",),
        act,
        "drive that axis to one place from both sides with a dial gauge on the link, by small and "
        "by large moves; gear and bearing of that axis",
        "mastering, changing frames",
        ("backlash",),
    )


def ripple(name: str, waves: dict[int, float]) -> Cause:
    """A gear's transmission error: by waves a turn of the axis, degrees."""

    def act(truth: Truth) -> None:
        k = truth.at(name)
        for number, size in waves.items():
            truth.link[:, k] += size * D * np.sin(number * truth.q[:, k] + 0.4 * number)

    return Cause(
        "gear_ripple",
        _STAGE,
        (name,),
        ("position",),
        act,
        "drive that axis slowly by itself with a gauge or a tracker's point far out: the error "
        "comes again with the gear's period; look at that gear",
        "mastering, tuning loops",
        ("motor_commutation",),
    )


def coupled_wrist(driven: str, by: str, share: float) -> Cause:
    """Bevel wheels of the wrist: turning one axis takes the next along, of which the controller takes off too little."""

    def act(truth: Truth) -> None:
        truth.link[:, truth.at(driven)] += share * truth.q[:, truth.at(by)]

    return Cause(
        "wrist_coupling",
        _STAGE,
        (driven, by),
        ("position",),
        act,
        "check the wrist's coupling factors in the machine data: turn the one axis alone and read "
        "whether the next moves",
        "mastering again and again, opening gears at the foot",
    )


def warm_links(parts: dict[str, tuple[str, float]], warm_from=22.0, late_s=0.0) -> Cause:
    """Links that grow with the shop's or their own warmth: by joint (a or d, micrometres a metre and K)."""

    def act(truth: Truth) -> None:
        warm = truth.run.temp - warm_from
        if late_s:
            t, slow = truth.run.t, np.zeros(len(warm))
            slow[0] = warm[0]
            for i in range(1, len(t)):
                slow[i] = slow[i - 1] + (warm[i] - slow[i - 1]) * (1 - np.exp(-(t[i] - t[i - 1]) / late_s))
            warm = slow
        for name, (what, um_m) in parts.items():
            joint = truth.machine.joints[truth.at(name)]
            column = 1 if what == "a" else 3
            err = np.zeros((len(warm), 4))
            err[:, column] = um_m * 1e-6 * joint.row[column] * warm
            truth.rows[name] = truth.rows.get(name, np.zeros(4)) + err

    return Cause(
        "thermal_drift",
        _STAGE,
        (),
        ("time",),
        act,
        "let the machine warm up before it works, or measure a reference point from time to time "
        "and correct; check by one pose cold and warm",
        "mastering while it is cold, mending gears",
        ("measurement_drift",),
    )


def warm_screw(name: str, um_m: float, warm_from=20.0) -> Cause:
    """A ball screw that grows from its fixed bearing on."""

    def act(truth: Truth) -> None:
        k = truth.at(name)
        truth.link[:, k] += um_m * 1e-6 * (truth.run.temp - warm_from) * (truth.q[:, k] - truth.machine.joints[k].low)

    return Cause(
        "thermal_drift",
        _STAGE,
        (name,),
        ("time", "position"),
        act,
        "warm the screw up before work, or compensate by its temperature; check the same place "
        "cold and warm against the laser",
        "adjusting the scale once, changing the screw",
        ("track", "geometry"),
    )
