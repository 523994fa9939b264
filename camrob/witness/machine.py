"""The machine as cell.toml alone describes it: chain, limits, HOME, tool, controller.

Axis values are KRL's: degrees, mm of sliding axes, in the order of `Machine.axis_names` (A1..A6, then E1..). Frames are in
metres. A row is A = Rz(theta) Tz(d) Tx(a) Rx(alpha) in which every number counts: q is added to theta_deg of a turning joint,
to d_mm of a sliding one, and axis = sign * q + offset. A row that says it is "modified" is A = Rx(alpha) Tx(a) Rz(theta) Tz(d):
its a and alpha are added to those of the row before, or stand in the frame in which the first row begins.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.errors import CellError
from camrob.witness.arm import Arm, Pose, chain
from camrob.witness.fields import Fields, read_toml
from camrob.witness.frames import frame, inverse, joined, rotation
from camrob.witness.units import deg_to_rad, mm_to_m

__all__ = ["Controller", "Joint", "Machine", "read_machine"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Joint:
    """One joint of the chain: `a`, `d` in m, `alpha`, `theta` in rad; `offset`, `home`, `low`, `high` are axis values."""

    name: str
    word: str  # the name that KRL has for it: A1..A6, E1..E6
    role: str
    turning: bool
    a: float
    alpha: float
    d: float
    theta: float
    sign: float
    offset: float
    home: float
    low: float
    high: float
    endless: bool
    speed: float = np.inf  # degrees or mm a second
    modified: bool = False  # a and alpha stand before the motion, not behind it


_SETTINGS = {
    "$APO.CDIS": "apo_cdis_mm",
    "$APO.CVEL": "apo_cvel_percent",
    "$APO.CORI": "apo_cori_deg",
    "$ACC.CP": "acc_cp_m_s2",
    "$VEL.ORI1": "vel_ori_deg_s",
    "$VEL.ORI2": "vel_ori_deg_s",
    "$ACC.ORI1": "acc_ori_deg_s2",
    "$ACC.ORI2": "acc_ori_deg_s2",
}


@dataclass(frozen=True, slots=True)
class Controller:
    """What `[controller]` says of programs; None or empty where it is silent. `hooks`: name to lines of KRL."""

    hooks: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    spindle_rpm: tuple[float, float] | None = None
    tool_change_pose: tuple[float, ...] | None = None  # axis values in the order of axis_names
    base_template: str = ""
    act_ex_ax: int | None = None
    ptp_percent: float | None = None
    base_frame: tuple[float, ...] = (0.0,) * 6  # the cell's base in the controller's world, or in its plate that turns
    settings: Mapping[str, float] = field(default_factory=dict)  # system variables, as programs are to set them
    own: Mapping[str, object] = field(default_factory=dict)  # all of the section, for languages with words of their own

    @property
    def mechanism(self) -> int | None:
        """The number of the mechanism that carries the part: the base template's MACHINE_DEF, else `act_ex_ax`."""
        found = re.search(r"MACHINE_DEF\s*\[\s*(\d+)\s*\]", self.base_template.upper())
        return int(found[1]) if found else self.act_ex_ax


@dataclass(frozen=True, slots=True, eq=False)
class Machine:
    """Arm, tables and tracks of one cell. `joints` are in the chain's order, the virtual roll left out."""

    name: str
    joints: tuple[Joint, ...]
    arm: Arm
    base_T_first: Array
    foot_T_root: Array
    wrist_T_flange: Array
    flange_T_tool: Array
    follows: bool
    controller: Controller

    @property
    def axis_names(self) -> tuple[str, ...]:
        """A1..A6, then the external axes by number: the order of all axis values here."""
        return tuple(sorted(joint.word for joint in self.joints))

    @property
    def in_order(self) -> tuple[Joint, ...]:
        """The joints in the order of `axis_names`."""
        return tuple(sorted(self.joints, key=lambda joint: joint.word))

    @property
    def home(self) -> Array:
        """HOME (n,)."""
        return np.array([joint.home for joint in self.in_order])

    @property
    def low(self) -> Array:
        """Least axis values (n,), -inf for an endless axis."""
        return np.array([joint.low for joint in self.in_order])

    @property
    def high(self) -> Array:
        """Greatest axis values (n,)."""
        return np.array([joint.high for joint in self.in_order])

    @property
    def speed(self) -> Array:
        """What the axes turn or run at most (n,), degrees or mm a second."""
        return np.array([joint.speed for joint in self.in_order])

    def carrier(self, axes: Array, roles: tuple[str, ...] = ("workpiece", "carriage")) -> Pose:
        """base_T_foot (where the arm's rows begin) of axis values (M, n); with fewer roles, the pose before the next."""
        picked = [joint for joint in self.joints if joint.role in roles]
        theta, d = [], []
        for joint in picked:
            value = axes[:, self.axis_names.index(joint.word)]
            q = joint.sign * (value - joint.offset)
            theta.append(joint.theta + deg_to_rad(q) if joint.turning else np.array([joint.theta]))
            d.append(np.array([joint.d]) if joint.turning else joint.d + mm_to_m(q))
        a, alpha = np.array([joint.a for joint in picked]), np.array([joint.alpha for joint in picked])
        turn, place = chain(theta, d, a, alpha)
        start = self.base_T_first
        return start[:3, :3] @ turn, place @ start[:3, :3].T + start[:3, 3]

    def base_T_root(self, axes: Array) -> Array:
        """(M, 4, 4) of axis values (M, n)."""
        return self._whole(self.carrier(axes), len(axes)) @ self.foot_T_root

    def base_T_world(self, axes: Array) -> Array:
        """(M, 4, 4): world is where base is with the workpiece's axes at 0."""
        foot = ("workpiece",)
        now = self._whole(self.carrier(axes, foot), len(axes))
        return now @ inverse(joined(*self.carrier(np.zeros((1, axes.shape[1])), foot)))

    def held(self) -> dict[str, Any]:
        """What the controller holds by the cell's word: HOME by its name, the row of BASE_DATA that is the cell's base."""
        own = self.controller.own
        values: dict[str, Any] = {}
        point = own.get("home_point")
        if isinstance(point, dict) and len(point["axes"]) == len(self.axis_names):
            axes = dict(zip(self.axis_names, map(float, point["axes"]), strict=True))
            values[str(point["name"]).upper()] = {"": "E6AXIS", **axes}
        if own.get("base_measured") is True:
            values[f"BASE_DATA[{own.get('base_number')}]"] = dict(
                zip("XYZABC", self.controller.base_frame, strict=True)
            )
        return values

    @property
    def base_T_controller(self) -> Array:
        """(4, 4) what a `$BASE` of zeros stands for: in base, where it stands still at the table's 0."""
        return inverse(frame(np.array(self.controller.base_frame)))

    def base_T_flange(self, axes: Array) -> Array:
        """Forward kinematics: (M, 4, 4) of axis values (M, n)."""
        foot_T_wrist = joined(*self.arm.forward(self.arm.theta(axes[:, :6])))
        return self._whole(self.carrier(axes), len(axes)) @ foot_T_wrist @ self.wrist_T_flange

    @staticmethod
    def _whole(pose: Pose, count: int) -> Array:
        return np.broadcast_to(joined(*pose), (count, 4, 4))


def _joint(fields: Fields, words: Mapping[str, str]) -> Joint:
    """One [[joint]], in SI but for the axis values; raises CellError for what is missing or odd."""
    name, role, kind = fields.text("name"), fields.text("role"), fields.text("type")
    if kind not in ("revolute", "prismatic"):
        raise fields.wrong("type", f"is {kind!r}", "write revolute or prismatic")
    turning, unit = kind == "revolute", "deg" if kind == "revolute" else "mm"
    if role == "arm" and not turning:
        raise fields.wrong("type", "of an arm's joint is not revolute")
    dh, axis, limits = fields.sub("dh"), fields.sub("axis"), fields.sub("limits")
    sign, offset = axis.number("sign"), axis.number(f"offset_{unit}", 0.0)
    if sign not in (1.0, -1.0):
        raise axis.wrong("sign", "is neither 1 nor -1")
    endless = limits.flag("endless", False)
    low, high = (-np.inf, np.inf) if endless else limits.numbers(f"range_{unit}", 2)
    if low >= high:
        raise limits.wrong(f"range_{unit}", "does not rise from least to greatest")
    return Joint(
        name=name,
        word=words.get(name, name),
        role=role,
        turning=turning,
        a=mm_to_m(dh.number("a_mm")),
        alpha=deg_to_rad(dh.number("alpha_deg")),
        d=mm_to_m(dh.number("d_mm")),
        theta=deg_to_rad(dh.number("theta_deg")),
        sign=sign,
        offset=offset,
        home=sign * fields.number(f"home_{unit}") + offset,
        low=float(low),
        high=float(high),
        endless=endless,
        speed=np.inf if (speed := limits.maybe(f"speed_{unit}_s")) is None else speed,
        modified=_modified(dh),
    )


def _modified(dh: Fields) -> bool:
    """The convention of a row."""
    said = dh.text("convention", "standard")
    if said not in ("standard", "modified"):
        raise dh.wrong("convention", f"is {said!r}", "write standard or modified")
    return said == "modified"


def _along_x(a: float, alpha: float) -> Array:
    """Tx(a) Rx(alpha) (4, 4)."""
    turn = np.eye(4)
    turn[:3, :3], turn[0, 3] = rotation(0, np.array([alpha]))[0], a
    return turn


def _standard(joints: tuple[Joint, ...], first: Array, foot: Array) -> tuple[tuple[Joint, ...], Array, Array]:
    """The same chain in standard rows, and base_T_first and foot_T_root with it: where the arm's first row takes its a and alpha
    along before it, the foot that root is seen from moves to behind them.
    """
    rows = list(joints)
    for k, joint in enumerate(joints):
        if not joint.modified:
            continue
        if joint.role == "arm" and (k == 0 or joints[k - 1].role != "arm"):
            foot = inverse(_along_x(joint.a, joint.alpha)) @ foot
        if k == 0:
            first = first @ _along_x(joint.a, joint.alpha)
        else:
            before = rows[k - 1]
            rows[k - 1] = replace(before, a=before.a + joint.a, alpha=before.alpha + joint.alpha)
        rows[k] = replace(joint, a=0.0, alpha=0.0, modified=False)
    return tuple(rows), first, foot


def _joints(top: Fields) -> tuple[Joint, ...]:
    """All joints but the roll; the arm's six are found by role, and take KRL's A1..A6 in the chain's order unless so named."""
    tables = top.subs("joint")
    roles = [fields.text("role") for fields in tables]
    order = ["workpiece", "carriage", "arm", "roll"]
    if sorted(roles, key=lambda role: order.index(role) if role in order else 9) != roles or set(roles) - set(order):
        raise top.wrong("joint", "has roles other than workpiece, carriage, arm, roll in this order")
    names = [fields.text("name") for fields, role in zip(tables, roles, strict=True) if role == "arm"]
    if len(names) != 6 or roles.count("roll") > 1:
        raise top.wrong("joint", "has not six of role arm, and one of role roll at most")
    plain = [f"A{k + 1}" for k in range(6)]
    if names != plain and set(names) & set(plain):
        raise top.wrong("joint", "has arm joints named A1 to A6, but not in the chain's order")
    words = {} if names == plain else dict(zip(names, plain, strict=True))
    for fields, role in zip(tables, roles, strict=True):
        row = fields.sub("dh").table
        if role == "roll" and any(value for key, value in row.items() if key != "convention"):
            raise fields.wrong("dh", "is not all zeros", "a roll turns about the tool's own axis: [tool] says where")
    joints = tuple(_joint(fields, words) for fields, role in zip(tables, roles, strict=True) if role != "roll")
    for joint in joints:
        if joint.role != "arm" and not re.fullmatch(r"E[1-6]", joint.word):
            raise top.wrong("joint", f"{joint.name!r} has no name that KRL knows", "name external axes E1 to E6")
    if len({joint.word for joint in joints}) != len(joints):
        raise top.wrong("joint", "names one axis twice")
    return joints


def _controller(fields: Fields, joints: tuple[Joint, ...]) -> Controller:
    """[controller], all of it optional."""
    table = fields.sub("controller")
    hooks = table.sub("hooks")
    spindle = tuple(table.numbers("spindle_rpm", 2)) if "spindle_rpm" in table else None
    names = sorted(joint.word for joint in joints)
    pose: tuple[float, ...] | None = None
    if isinstance(table.table.get("tool_change_pose"), dict):
        named = table.sub("tool_change_pose")
        pose = tuple(named.number(name) for name in names)
    elif "tool_change_pose" in table:
        pose = tuple(float(value) for value in table.numbers("tool_change_pose", len(names)))
    return Controller(
        hooks={name: hooks.texts(name) for name in hooks.table},
        spindle_rpm=None if spindle is None else (float(spindle[0]), float(spindle[1])),
        tool_change_pose=pose,
        base_template=table.text("base_template", ""),
        act_ex_ax=None if "act_ex_ax" not in table else int(table.number("act_ex_ax")),
        base_frame=tuple(float(value) for value in table.numbers("base_frame", 6, [0.0] * 6)),
        ptp_percent=table.maybe("ptp_velocity_percent"),
        settings={name: value for name, key in _SETTINGS.items() if (value := table.maybe(key)) is not None},
        own=dict(table.table),
    )


def read_machine(cell: Path) -> Machine:
    """The machine of a cell's folder, or of a cell.toml itself. Raises CellError, naming file and key."""
    top = read_toml(cell / "cell.toml" if cell.is_dir() else cell, CellError)
    chain_of = top.sub("kinematics")
    base_T_first, foot_T_root, wrist_T_flange = (
        frame(chain_of.numbers(key, 6)) for key in ("base_to_first", "foot_to_root", "wrist_to_flange")
    )
    joints, base_T_first, foot_T_root = _standard(_joints(top), base_T_first, foot_T_root)
    rows = [joint for joint in joints if joint.role == "arm"]
    arm = Arm(
        a=np.array([joint.a for joint in rows]),
        alpha=np.array([joint.alpha for joint in rows]),
        d=np.array([joint.d for joint in rows]),
        theta_offset=np.array([joint.theta for joint in rows]),
        sign=np.array([joint.sign for joint in rows]),
        axis_offset=np.array([joint.offset for joint in rows]),
        foot_R_root=foot_T_root[:3, :3],
    )
    return Machine(
        name=top.text("name"),
        joints=joints,
        arm=arm,
        base_T_first=base_T_first,
        foot_T_root=foot_T_root,
        wrist_T_flange=wrist_T_flange,
        flange_T_tool=frame(top.sub("tool").numbers("flange_to_tool", 6, [0, 0, 0, 0, 0, 0])),
        follows=chain_of.flag("base_follows_table"),
        controller=_controller(top, joints),
    )
