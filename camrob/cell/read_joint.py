"""The joints of a cell.toml: a row of Denavit and Hartenberg each, how the controller counts it, limits and HOME."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import POSTED_ARM
from camrob.cell.joint import Joint, Role, dh_after, dh_before
from camrob.errors import InputError
from camrob.toml.table_reader import TableReader
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["CONVENTIONS", "check_chain", "read_joint", "row_of"]

Array = NDArray[np.float64]

CONVENTIONS = ("standard", "modified")
_MOST_ARM = 7  # axes of an arm that a log names


def row_of(alpha_deg: float, a_mm: float, theta_deg: float, d_mm: float, *, modified: bool) -> tuple[Array, Array]:
    """What stands before and behind the motion about or along z, (4, 4) each, of a row of Denavit and Hartenberg.

    Standard: Rz(theta) Tz(d) Tx(a) Rx(alpha), a and alpha behind the joint. Modified (Craig): Rx(alpha) Tx(a) Rz(theta) Tz(d),
    both before it.
    """
    before = dh_before(theta=deg_to_rad(theta_deg), d=mm_to_m(d_mm))
    after = dh_after(a=mm_to_m(a_mm), alpha=deg_to_rad(alpha_deg))
    # Rx(alpha) and Tx(a) commute: what stands behind a standard row stands before a modified one
    return (after @ before, np.eye(4)) if modified else (before, after)


def read_joint(table: TableReader, *, measured: bool) -> Joint:
    """One [[joint]]. measured: of a cell that no program is made for, whose axes may be given without limits, sign and home.

    Raises CellError naming the key.
    """
    name = table.text("name")
    role = Role(table.text("role", choices=tuple(r.value for r in Role)))
    prismatic = table.text("type", choices=("revolute", "prismatic")) == "prismatic"
    unit = "mm" if prismatic else "deg"

    def si(value: float) -> float:
        return mm_to_m(value) if prismatic else deg_to_rad(value)

    dh = table.table("dh")
    modified = "convention" in dh and dh.text("convention", choices=CONVENTIONS) == "modified"
    before, after = row_of(*(dh.number(key) for key in ("alpha_deg", "a_mm", "theta_deg", "d_mm")), modified=modified)
    sign, offset = (1.0, 0.0) if measured and "axis" not in table else _counting(table, f"offset_{unit}")
    rates = {"speed": np.inf, "acceleration": np.inf, "jerk": np.inf}
    lower, upper = -np.inf, np.inf
    if not measured or "limits" in table:
        limits = table.table("limits")
        if not ("endless" in limits and limits.flag("endless")):
            lower, upper = (si(float(v)) for v in limits.vector(f"range_{unit}", 2))
            if not lower < upper:
                raise limits.fail(f"range_{unit}", "has its lower end above its upper one", "swap them")
        for power, quantity in enumerate(rates, start=1):
            key = f"{quantity}_{unit}_s{power if power > 1 else ''}"
            if role is not Role.ROLL and not (measured and key not in limits):
                rates[quantity] = si(limits.number(key, lower=1e-6))
        limits.finish()
    stand = si(offset) if measured else 0.0  # the axis at 0, where nobody says HOME
    postures = {
        key: -sign * stand if measured and f"{key}_{unit}" not in table else si(table.number(f"{key}_{unit}"))
        for key in ("home", "reference")
    }
    joint = Joint(
        name=name,
        role=role,
        prismatic=prismatic,
        before=before,
        after=after,
        sign=sign,
        offset=si(offset),
        lower=lower,
        upper=upper,
        speed=rates["speed"],
        acceleration=rates["acceleration"],
        jerk=rates["jerk"],
        home=postures["home"],
        reference=postures["reference"],
    )
    for part in (dh, table):
        part.finish()
    if role is Role.ROLL and (prismatic or not np.array_equal(joint.before @ joint.after, np.eye(4))):
        raise table.fail(
            "dh", "is not that of a turn about the tool's own axis", "make it revolute, all zeros; $TOOL holds the rest"
        )
    for key, value in (("home", joint.home), ("reference", joint.reference)):
        if not (measured and f"{key}_{unit}" not in table) and not joint.q_lower <= value <= joint.q_upper:
            raise table.fail(f"{key}_{unit}", "lies outside the axis's range", f"correct {key} or limits")
    return joint


def _counting(table: TableReader, key: str) -> tuple[float, float]:
    """How the controller counts an axis: sign, and the offset in the unit of the file."""
    axis = table.table("axis")
    sign = axis.number("sign", lower=-1, upper=1)
    if abs(sign) != 1.0:
        raise axis.fail("sign", f"is {sign:g}", "use 1 or -1")
    offset = axis.number(key)
    axis.finish()
    return sign, offset


def check_chain(joints: tuple[Joint, ...], table: TableReader) -> None:
    """Roles in order, names once; an arm of six that turn where programs are made, of one to seven where it is measured."""
    order = [list(Role).index(j.role) for j in joints]
    if order != sorted(order):
        raise table.fail("joint", "roles are out of order", "list workpiece, carriage, arm, roll joints in this order")
    names = [j.name for j in joints]
    for name in names:
        if names.count(name) > 1:
            raise _joint_error(table, name, "appears twice", "give every joint a name of its own")
    arm = [j for j in joints if j.role is Role.ARM]
    arm_names = [j.name for j in arm]
    counted = arm_names == [f"A{i}" for i in range(1, len(arm) + 1)] and 1 <= len(arm) <= _MOST_ARM
    if not counted and arm_names != ["E1"]:
        hint = f"name the joints of role arm A1, A2 .. in order, {_MOST_ARM} at the most; a lift or track alone is E1, "
        hint += "of role arm"
        raise table.fail("joint", "the arm's joints are not A1, A2 ..", hint)
    for section in ("controller", "resolve"):
        if section in table and (len(arm) != POSTED_ARM or any(j.prismatic for j in arm)):
            what = f"is given, and the arm's {len(arm)} axes are not six that turn"
            hint = "leave it out: such a cell is measured and diagnosed, not programmed"
            if any(j.prismatic for j in arm):
                hint += "; linear axes that carry six that turn are of role carriage"
            raise table.fail(section, what, hint)
    for j in joints:
        external = j.role in (Role.WORKPIECE, Role.CARRIAGE)
        if external and not (len(j.name) == 2 and j.name[0] == "E" and j.name[1] in "123456"):
            raise _joint_error(table, j.name, "is not a name of an external axis", "use E1 .. E6")
    if sum(j.role is Role.ROLL for j in joints) > 1:
        raise table.fail("joint", "there are two roll joints", "leave one")
    for j in joints:
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,23}", j.name):
            raise _joint_error(table, j.name, "is not a name for a joint", "use letters and digits, 24 at most")


def _joint_error(table: TableReader, name: str, what: str, hint: str) -> InputError:
    """The error to raise for the last joint of a name, by its line."""
    named = [k for k, joint in enumerate(table.tables("joint")) if joint.text("name") == name]
    return table.fail("joint", f"{name[:40]!r} {what}", hint, stands=("joint", *named[-1:], "name"))
