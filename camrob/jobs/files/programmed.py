"""What a cell out of a URDF needs for programs, at values that are assumed, and said to be: to be replaced one by one."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Joint
from camrob.cell.load import PointMass
from camrob.errors import CellError
from camrob.kinematics.best_condition import best_condition
from camrob.kinematics.dh_rows import DhChain, DhRow, dh_chain
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.kernels import chain_arrays, inverse_kf_many
from camrob.se3 import mm_deg_from_frame
from camrob.units import deg_to_rad, m_to_mm, rad_to_deg

__all__ = ["straightened_by", "tables_for_programs"]

Array = NDArray[np.float64]

_AXES = 6  # of an arm that programs are made for
_JOINT = """[[joint]]
name = "{name}"
role = "{role}"
type = "{type}"
dh = {{ alpha_deg = {alpha}, a_mm = {a}, theta_deg = {theta}, d_mm = {d} }}
axis = {{ sign = 1, offset_{unit} = 0 }}
home_{unit} = {home}
reference_{unit} = {home}
limits = {{ range_{unit} = {ends}, speed_{unit}_s = {speed}, acceleration_{unit}_s2 = {rate}, jerk_{unit}_s3 = {jerk} }}
standing = {{ dh = "datasheet", axis = "assumed", home = "assumed", reference = "assumed", limits = "{limits}" }}
"""
_MASS = """[[mass]]
name = {name}
after = "{after}"
mass_kg = {mass}
center_mm = {center}
standing = "datasheet"
"""
_WIDE = 2.0 * np.pi, 2.0  # rad, m that an axis without limits goes either way
_SPEED = deg_to_rad(100.0), 1.0  # rad/s, m/s of an axis that the URDF tells none of
_QUICK = 3.0  # 1/s: its acceleration, in speeds
_MEANT = 0.1  # hundredths by which a limit may lie below a round number and mean it
_COMPARED = 500  # postures in which the rows are held to the file
_DRAWN = 40_000  # postures among which HOME is looked for
_FROM_LIMITS = 0.05  # of an axis's range that HOME keeps from its ends
_LEAN = 0.98  # cosine of the plate's lean at HOME at the most
_HIGH = 0.2  # m of the plate above the robot's foot at HOME at the least
_ASIDE = deg_to_rad(30.0)  # by which it stands aside of the foot's x at the most
_WORSE = 0.03  # of 1/k_F, that an axis at 0 may cost

_TABLES = """
# Chain, limits, speeds and masses are the URDF's, its chain as standard Denavit-Hartenberg rows. What else stands here no URDF
# says and is assumed: replace it by the machine's own, and say "measured" or "datasheet".
[kinematics]
base_follows_table = false
characteristic_length_mm = {length:.1f}          # found as by camrob cell condition
base_to_first = {first}
foot_to_root = {root}      # $ROBROOT is the URDF's root link
wrist_to_flange = {flange}
standing = "datasheet"

{joints}

[[joint]]
name = "roll"
role = "roll"
type = "revolute"
dh = {{ alpha_deg = 0, a_mm = 0, theta_deg = 0, d_mm = 0 }}
axis = {{ sign = 1, offset_deg = 0 }}
home_deg = 0
reference_deg = 0
limits = {{ endless = true }}
standing = "assumed"

[tool]
flange_to_tool = [0, 0, 200, 0, 0, 180]    # the tip 200 mm before the plate, its z back along the tool
standing = "assumed"

[load]
payload_kg = 5
standing = "assumed"
{masses}
[controller]
acc_cp_m_s2 = 2
vel_ori_deg_s = 200
acc_ori_deg_s2 = 400
ori_type = "#VAR"
circ_type = "#BASE"
apo_cdis_mm = 0.5
advance = 5
ptp_velocity_percent = 10
max_lines = 20000
max_bytes = 4000000
max_line_length = 255
standing = "assumed"

[controller.hooks]
spindle_on = [";spindle on", "$ANOUT[1] = {{speed}} / 24000.0", "$OUT[1] = TRUE", "WAIT SEC 3.0"]
spindle_off = ["$OUT[1] = FALSE", "WAIT SEC 3.0"]
coolant_on = ["$OUT[2] = TRUE"]
coolant_off = ["$OUT[2] = FALSE"]
tool_change = ["HALT ;change to tool {{number}}"]
stop = ["HALT"]
footer = ["$OUT[1] = FALSE ;spindle off, whatever the CL file says", "$OUT[2] = FALSE ;coolant off"]

[resolve]
threshold = 0.5
standing = "assumed"
"""


def tables_for_programs(cell: Cell, file: Path) -> str:
    """cell.toml behind its name, for the measured cell of a URDF, `file`: the chain as Denavit-Hartenberg rows, and the rest.

    Raises CellError for an arm that no programs are made for.
    """
    arm = cell.joints[cell.arm_slice]
    if len(arm) != _AXES or any(j.prismatic for j in arm):
        what = f"has an arm of {len(arm)} axes, and programs are made for six that turn"
        hint = "leave --post out: such a cell is measured and diagnosed"
        if len(arm) > _AXES:
            hint += "; where the last of them moves a gripper, name with --tip a link before it"
        raise CellError(what, hint=hint, path=file)
    length = best_condition(cell).length
    chain, foot = dh_chain(cell.joints), cell.arm_slice.start
    frames = {
        "first": chain.base_T_frames[0],
        "root": np.linalg.inv(chain.base_T_frames[foot]),
        "flange": np.linalg.inv(chain.base_T_frames[-1]) @ base_T_tool(cell, np.zeros(len(cell))),
    }
    q = _home(cell, length)
    return _TABLES.format(
        length=m_to_mm(length),
        joints="\n".join(
            _joint(j, row, float(v)) for j, row, v in zip(cell.joints, chain.rows, q, strict=True)
        ).rstrip(),
        masses="\n".join(_mass(cell, m, chain) for m in cell.masses),
        **{key: _row(mm_deg_from_frame(T)) for key, T in frames.items()},
    )


def straightened_by(measured: Cell, programmed: Cell) -> float:
    """m that the plate of the cell for programs lies beside the URDF's at the most, where axes were made square or parallel."""
    n = len(measured)
    low, high = (np.clip(limit[:n], -np.pi, np.pi) for limit in (programmed.q_lower, programmed.q_upper))
    q = np.random.default_rng(0).uniform(low, high, (_COMPARED, n))
    plate = base_T_tool(programmed, np.column_stack([q, np.zeros(_COMPARED)])) @ np.linalg.inv(programmed.flange_T_tool)
    return float(np.linalg.norm(plate[:, :3, 3] - base_T_tool(measured, q)[:, :3, 3], axis=1).max())


def _joint(joint: Joint, row: DhRow, home: float) -> str:
    """One [[joint]]."""
    wide, usual = _WIDE[joint.prismatic], _SPEED[joint.prismatic]
    speed = joint.speed if np.isfinite(joint.speed) else usual
    return _JOINT.format(
        name=joint.name,
        role=joint.role.value,
        type="prismatic" if joint.prismatic else "revolute",
        unit=joint.unit,
        alpha=_number(rad_to_deg(row.alpha)),
        a=_number(m_to_mm(row.a)),
        theta=_number(rad_to_deg(row.theta)),
        d=_number(m_to_mm(row.d)),
        home=f"{joint.to_edge(home):.1f}",
        ends=_row(_least(joint.to_edge(np.clip([joint.q_lower, joint.q_upper], -wide, wide)))),
        speed=_number(most := float(_least(joint.to_edge(speed)))),
        rate=_number(round(_QUICK * most, 1)),
        jerk=_number(round(10.0 * _QUICK * most, 1)),
        limits="assumed" if joint.endless or not np.isfinite(joint.speed) else "datasheet",
    )


def _mass(cell: Cell, mass: PointMass, chain: DhChain) -> str:
    """One [[mass]], its centre seen from where the joint's row ends."""
    k = cell.names.index(mass.after)
    base_T_center = chain.base_T_ends[k] @ np.append(mass.center, 1.0)
    center = np.linalg.inv(chain.base_T_frames[k + 1]) @ base_T_center
    return _MASS.format(
        name=json.dumps(mass.name), after=mass.after, mass=_number(mass.mass), center=_row(m_to_mm(center[:3]))
    )


def _least(limit: ArrayLike) -> Array:
    """Limits in trade units at a hundredth, towards 0: a URDF has 2.9671 for 170 degrees, whose further digits nobody meant."""
    value = np.asarray(limit, np.float64)
    rounded = np.sign(value) * np.floor(np.abs(value) * 100.0 + _MEANT) / 100.0
    return np.where(rounded == 0.0, value, rounded)


def _row(values: Array) -> str:
    return f"[{', '.join(_number(v) for v in values)}]"


def _number(value: float) -> str:
    """To 1e-9 mm or degrees, as a person would write it."""
    return f"{round(float(value), 9) + 0.0:.9f}".rstrip("0").rstrip(".")


def _home(cell: Cell, length: float) -> Array:
    """The best-conditioned posture (n,) of those drawn in which the plate looks down from a fair height before the robot's foot,
    its first axis at 0, else of all; each further axis at 0 where that is no worse.
    """
    part = cell.arm_slice
    lower, upper = np.clip(cell.q_lower[part], -np.pi, np.pi), np.clip(cell.q_upper[part], -np.pi, np.pi)
    inside = _FROM_LIMITS * (upper - lower)
    lower, upper = lower + inside, upper - inside
    q = np.tile(cell.q_home, (_DRAWN, 1))
    q[:, part] = np.random.default_rng(0).uniform(lower, upper, (_DRAWN, len(lower)))
    q[1::2, part.start] = np.clip(0.0, lower[0], upper[0])  # it changes where the plate is, and no more

    def value(q: Array) -> Array:
        plate = base_T_tool(cell, q)
        ahead = plate[:, 0, 3] > np.cos(_ASIDE) * np.hypot(plate[:, 0, 3], plate[:, 1, 3])
        fair = (plate[:, 2, 2] < -_LEAN) & (plate[:, 2, 3] > _HIGH) & ahead
        ahead_at_zero = fair & (q[:, part.start] == 0.0)
        return np.asarray(inverse_kf_many(chain_arrays(cell)._replace(length=length), q) + fair + ahead_at_zero)

    best = q[int(np.argmax(value(q)))]
    for i in range(part.start, part.stop):
        straight = best.copy()
        straight[i] = 0.0
        if (
            lower[i - part.start] <= 0.0 <= upper[i - part.start]
            and value(straight[None])[0] >= value(best[None])[0] - _WORSE
        ):
            best = straight
    return np.asarray(best)
