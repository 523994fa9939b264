"""The machines: two that come with the project, and twelve of the author's own with the cell files that tell them."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path

import numpy as np

from .chain import Joint, Machine, Mass, frame

__all__ = ["MACHINES", "write_cell"]

ROOT = Path(__file__).resolve().parents[4]
D = np.pi / 180.0


def _unit(kind: str) -> float:
    return D if kind == "R" else 1.0


def _shipped(name: str, used: dict, keep, leave_out=("roll",)) -> Machine:
    """A cell that comes with the project; `used` gives each axis' range and speed (degrees, mm)."""
    told = tomllib.loads((ROOT / "cells" / name / "cell.toml").read_text())
    joints = []
    for row in told["joint"]:
        if row["name"] in leave_out:
            continue
        kind = "R" if row["type"] == "revolute" else "P"
        dh, axis, (low, high, speed) = row["dh"], row["axis"], used[row["name"]]
        u = _unit(kind)
        joints.append(
            Joint(
                row["name"],
                kind,
                (dh["alpha_deg"] * D, dh["a_mm"], dh["theta_deg"] * D, dh["d_mm"]),
                row["role"],
                axis["sign"],
                axis.get("offset_deg", axis.get("offset_mm", 0)) * u,
                False,
                low * u,
                high * u,
                speed * u,
            )
        )
    masses = tuple(Mass(m["after"], m["mass_kg"], tuple(m["center_mm"])) for m in told.get("mass", []))
    k = told["kinematics"]
    return Machine(
        name,
        tuple(joints),
        frame(told["tool"]["flange_to_tool"]),
        masses,
        told["load"]["payload_kg"],
        frame(k["base_to_first"]),
        frame(k["wrist_to_flange"]),
        keep,
        name,
    )


def _own(
    name, dh, used, tool, kinds=None, before=(), modified=False, masses=(), payload=0.0, first=None, keep=(-1e9, 1e9)
) -> Machine:
    """An arm by its rows (degrees, mm), with what stands before it: (name, kind, role, row, low, high, speed)."""
    joints = []
    for label, kind, role, row, low, high, speed in before:
        u = _unit(kind)
        joints.append(
            Joint(
                label, kind, (row[0] * D, row[1], row[2] * D, row[3]), role, low=low * u, high=high * u, speed=speed * u
            )
        )
    for k, (row, (low, high, speed)) in enumerate(zip(dh, used, strict=True)):
        kind = (kinds or "R" * len(dh))[k]
        u = _unit(kind)
        joints.append(
            Joint(
                f"A{k + 1}",
                kind,
                (row[0] * D, row[1], row[2] * D, row[3]),
                modified=modified,
                low=low * u,
                high=high * u,
                speed=speed * u,
            )
        )
    return Machine(
        name,
        tuple(joints),
        frame(tool),
        tuple(Mass(*m) for m in masses),
        payload,
        np.eye(4) if first is None else frame(first),
        keep=keep,
    )


_SMALL_ROWS = [(-90, 0, 0, 290), (0, 270, -90, 0), (-90, 70, 0, 0), (90, 0, 0, 302), (-90, 0, 0, 0), (0, 0, 180, 72)]
_SMALL_USED = [(-110, 110, 120), (-50, 70, 110), (-60, 50, 120), (-130, 130, 160), (-95, 95, 160), (-160, 160, 220)]
_SMALL_MASS = [("A2", 4.5, (-120, 0, 20)), ("A3", 4.2, (-35, 10, 0)), ("A5", 1.3, (0, 0, 5))]
_LARGE_ROWS = [
    (-90, 350, 0, 675),
    (0, 1150, -90, 0),
    (-90, -41, 0, 0),
    (90, 0, 0, 1200),
    (-90, 0, 0, 0),
    (0, 0, 0, 215),
]
_LARGE_USED = [(-80, 80, 60), (-40, 45, 55), (-30, 60, 60), (-140, 140, 90), (-100, 100, 90), (-170, 170, 120)]
_LARGE_MASS = [
    ("A1", 340.0, (-180, 60, 0)),
    ("A2", 190.0, (-620, 0, 120)),
    ("A3", 250.0, (20, 0, 160)),
    ("A5", 60.0, (0, 0, 60)),
]
_COBOT_ROWS = [
    (90, 0, 0, 162.5),
    (0, -425, 0, 0),
    (0, -392.2, 0, 0),
    (90, 0, 0, 133.3),
    (-90, 0, 0, 99.7),
    (0, 0, 0, 99.6),
]
_COBOT_USED = [
    (-120, 120, 110),
    (-140, -40, 90),
    (-120, 120, 110),
    (-160, -20, 140),
    (-130, 130, 140),
    (-170, 170, 160),
]
_COBOT_MASS = [
    ("A2", 8.06, (213, 0, 114)),
    ("A3", 2.85, (150, 0, 27)),
    ("A4", 1.37, (0, -2, 16)),
    ("A5", 1.3, (0, 2, 16)),
]
_SEVEN_ROWS = [
    (0, 0, 0, 333),
    (-90, 0, 0, 0),
    (90, 0, 0, 316),
    (90, 82.5, 0, 0),
    (-90, -82.5, 0, 384),
    (90, 0, 0, 0),
    (90, 88, 0, 107),
]
_SEVEN_USED = [
    (-110, 110, 80),
    (-60, 60, 70),
    (-100, 100, 80),
    (-140, -40, 80),
    (-120, 120, 100),
    (30, 170, 100),
    (-120, 120, 110),
]
_SEVEN_MASS = [
    ("A2", 3.4, (0, -70, 20)),
    ("A3", 3.2, (30, 30, -60)),
    ("A4", 3.6, (-40, 100, 30)),
    ("A5", 2.2, (0, 40, -110)),
    ("A6", 1.7, (50, 0, -10)),
    ("A7", 0.7, (10, 0, 60)),
]


def _machines() -> dict[str, Machine]:
    kr15 = {
        "E2": (-175, 175, 40),
        "E1": (-700, 700, 400),
        "A1": (-45, 45, 70),
        "A2": (-110, -45, 60),
        "A3": (55, 125, 70),
        "A4": (-120, 120, 120),
        "A5": (25, 110, 120),
        "A6": (-150, 150, 200),
    }
    irb = {
        "E1": (-150, 150, 45),
        "A1": (-60, 60, 60),
        "A2": (-30, 50, 50),
        "A3": (-50, 35, 50),
        "A4": (-150, 150, 100),
        "A5": (-100, 100, 90),
        "A6": (-180, 180, 120),
    }
    rail = [("E1", "P", "carriage", (90, 0, 0, 0), 0, 5200, 900)]
    lift = [("E1", "P", "carriage", (0, 0, 0, 400), 0, 800, 250)]
    tilt = [
        ("E2", "R", "workpiece", (90, 0, 0, -180), -170, 170, 60),
        ("E1", "R", "workpiece", (-90, 1250, 0, 0), -60, 60, 40),
    ]
    beams = [
        ("E1", "P", "carriage", (90, 0, 0, 0), 0, 3000, 500),
        ("E2", "P", "carriage", (90, 0, 90, 0), 0, 1600, 500),
    ]
    return {
        "kr15": _shipped("kr15_track_table", kr15, (-100, 1400)),
        "irb6700": _shipped("irb6700_table", irb, (100, 2600)),
        "small": _own(
            "used_small_arm",
            _SMALL_ROWS,
            _SMALL_USED,
            (30, 0, 95, 0, 0, 0),
            masses=_SMALL_MASS,
            payload=1.5,
            keep=(80, 900),
        ),
        "cobot": _own(
            "cobot_six",
            _COBOT_ROWS,
            _COBOT_USED,
            (0, 0, 160, 0, 0, 0),
            masses=_COBOT_MASS,
            payload=2.5,
            keep=(60, 1200),
        ),
        "seven": _own(
            "cobot_seven",
            _SEVEN_ROWS,
            _SEVEN_USED,
            (0, 0, 120, -45, 0, 0),
            modified=True,
            masses=_SEVEN_MASS,
            payload=1.2,
            keep=(60, 1100),
        ),
        "rail": _own(
            "handling_on_rail",
            _LARGE_ROWS,
            _LARGE_USED,
            (120, 0, 350, 0, 0, 0),
            before=rail,
            masses=_LARGE_MASS,
            payload=120.0,
            first=(0, 0, 0, 0, 0, -90),
            keep=(200, 2800),
        ),
        "large": _own(
            "large_arm",
            _LARGE_ROWS,
            _LARGE_USED,
            (0, 0, 310, 0, 20, 0),
            masses=_LARGE_MASS,
            payload=150.0,
            keep=(300, 2600),
        ),
        "lift": _own(
            "cobot_on_lift",
            _COBOT_ROWS,
            _COBOT_USED,
            (0, 40, 140, 0, 0, 0),
            before=lift,
            masses=_COBOT_MASS,
            payload=3.0,
            keep=(400, 2200),
        ),
        "tilt": _own(
            "tilt_turn_cell",
            _SMALL_ROWS,
            _SMALL_USED,
            (30, 0, 95, 0, 0, 0),
            before=tilt,
            masses=_SMALL_MASS,
            payload=1.5,
            keep=(-600, 900),
        ),
        "scara": _own(
            "scara",
            [(0, 325, 0, 387), (180, 275, 0, 0), (0, 0, 0, 0), (0, 0, 0, 0)],
            [(-120, 120, 180), (-135, 135, 220), (10, 170, 500), (-170, 170, 400)],
            (0, 0, 60, 0, 0, 0),
            kinds="RRPR",
            masses=[("A1", 9.0, (-150, 0, 0)), ("A2", 7.0, (-110, 0, -60))],
            payload=2.0,
            first=(0, 0, -237, 0, 0, 0),
        ),
        "gantry": _own(
            "gantry_two_head",
            [(90, 0, 0, 0), (90, 0, 180, 0)],
            [(-170, 170, 60), (-80, 80, 50)],
            (0, 0, 260, 0, 0, 0),
            before=[*beams, ("E3", "P", "carriage", (0, 0, 0, -900), 0, 700, 300)],
            masses=[("A1", 30.0, (0, 0, 40))],
            payload=18.0,
            first=(0, 0, 0, 0, -90, 180),
        ),
        "delta": _own(
            "delta_as_cartesian",
            [(-90, 0, -90, 0), (-90, 0, -90, 0), (0, 0, 0, 0), (0, 0, 0, 0)],
            [(-250, 250, 900), (-250, 250, 900), (620, 820, 700), (-170, 170, 400)],
            (0, 0, 50, 0, 0, 0),
            kinds="PPPR",
            first=(0, 0, 0, 90, 0, 90),
        ),
        "bench": _own("one_drive", [(0, 400, 0, 0)], [(-160, 160, 60)], (0, 0, 0, 0, 0, 0), payload=4.0),
        "stage": _own(
            "one_stage", [(0, 0, 0, 0)], [(0, 900, 150)], (0, 0, 80, 0, 0, 0), kinds="P", first=(0, 0, 0, 0, 90, 0)
        ),
    }


MACHINES = _machines()


def _list(values, digits=6) -> str:
    return "[" + ", ".join(f"{round(float(v), digits):g}" if abs(v) > 1e-9 else "0" for v in values) + "]"


def _told(T: np.ndarray) -> list[float]:
    """X, Y, Z, A, B, C of a frame, also where B is 90 degrees."""
    R = T[:3, :3]
    b = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    if np.hypot(R[0, 0], R[1, 0]) < 1e-9:
        a, c = np.arctan2(-R[0, 1], R[1, 1]), 0.0
    else:
        a, c = np.arctan2(R[1, 0], R[0, 0]), np.arctan2(R[2, 1], R[2, 2])
    return [*T[:3, 3], *np.degrees([a, b, c])]


def write_cell(machine: Machine, folder: Path) -> None:
    """The cell's folder: a copy, or cell.toml as the contract has it."""
    if machine.shipped:
        shutil.copytree(ROOT / "cells" / machine.shipped, folder, dirs_exist_ok=True)
        return
    folder.mkdir(parents=True, exist_ok=True)
    lines = ["schema = 1", f'name = "{machine.name}"', 'standing = "assumed"', ""]
    table = any(j.role == "workpiece" for j in machine.joints)
    if not np.allclose(machine.first, np.eye(4)) or table:
        lines += ["[kinematics]", f"base_to_first = {_list(_told(machine.first))}"]
        lines += [f"base_follows_table = {'true' if table else 'false'}", ""]
    for j in machine.joints:
        if j.role == "arm":
            continue
        kind, unit = ("revolute", "deg") if j.kind == "R" else ("prismatic", "mm")
        row = f"alpha_deg = {j.row[0] / D:g}, a_mm = {j.row[1]:g}, theta_deg = {j.row[2] / D:g}, d_mm = {j.row[3]:g}"
        lines += ["[[joint]]", f'name = "{j.name}"', f'role = "{j.role}"', f'type = "{kind}"', f"dh = {{ {row} }}"]
        lines += [f"axis = {{ sign = 1, offset_{unit} = 0 }}", ""]
    arm = [j for j in machine.joints if j.role == "arm"]
    lines += ["[arm]", f'convention = "{"modified" if arm[0].modified else "standard"}"', "dh = ["]
    lines += [f"  {_list([j.row[0] / D, j.row[1], j.row[2] / D, j.row[3]])}," for j in arm] + ["]"]
    if any(j.kind == "P" for j in arm):
        lines.append(f'kinds = "{"".join(j.kind for j in arm)}"')
    lines += ["", "[tool]", f"flange_to_tool = {_list(_told(machine.tool))}", ""]
    if machine.payload:
        lines += ["[load]", f"payload_kg = {machine.payload:g}", ""]
    for k, m in enumerate(machine.masses):
        lines += [
            "[[mass]]",
            f'name = "body {k + 1}"',
            f'after = "{m.after}"',
            f"mass_kg = {m.kg:g}",
            f"center_mm = {_list(m.center)}",
            "",
        ]
    (folder / "cell.toml").write_text("\n".join(lines))
