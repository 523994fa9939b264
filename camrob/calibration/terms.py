"""The names of error parameters, and what each one moves.

    base.x .. base.rz      error of world_T_root, multiplied on the left: mm and degrees about the axes of `world`
    tool.x .. tool.rz      error at the tip, multiplied on the right, in the axes of `tool`
    root.rx.by.NAME        the robot's foot moves with a quantity NAME that the caller gives (lean, drift, straightness)
    A3.x .y .z .rx .ry     where the axis A3 stands, in its own frame (z is the axis); what it carries goes along
    A3.zero                real axis value = reported + zero, in the controller's sign
    A3.scale               real axis value = reported (1 + scale)
    A3.compliance          rad/Nm: gravity's torque turns the link beyond its encoder
    A3.cos2 A3.sin2        gear ripple: amplitude of the second order in the axis value
    A5.by.A4  A3.by.NAME   coupling to another axis, or to a quantity that the caller gives, in the controller's sign
    E2.x E2.y E2.rx E2.ry  where the axis of a table or track stands; nothing changes where the axis stands at 0
    E1.scale E1.zero       as above
    base.x@2 .. tool.rz@2  of a fit to several sets of poses: the second one's own instrument and reflector, nothing of the cell's

A displacement x, y, z, rx, ry, rz is Trans(x, y, z) exp(rx, ry, rz), the angles a rotation vector.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum

from camrob.calibration.error_kernel import BASE, JOINT, JOINT_SLOTS, MOTION, ROOT, TOOL
from camrob.calibration.parameters import Parameter
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.errors import LogError

__all__ = [
    "FRAMES",
    "PARTS",
    "SIDES",
    "ErrorTerm",
    "TermKind",
    "is_one_sets",
    "parameter_of",
    "plain_name",
    "set_name",
    "side_of",
    "standard_names",
    "term_of",
]

PARTS = ("x", "y", "z", "rx", "ry", "rz")
"""Of a displacement."""
SIDES = ("base", "tool")
"""What stands before them for an instrument's place and a reflector's."""
FRAMES = tuple(f"{side}.{part}" for side in SIDES for part in PARTS)
_MOTION = re.compile(r"(zero|scale|compliance)|(cos|sin)(\d{1,4}(?:\.\d{1,4})?)|by\.([A-Za-z][A-Za-z0-9_]{0,30})")
_LENGTH, _ANGLE, _COMPLIANCE, _SCALE = 0.1, 0.1, 1e-3, 0.1  # what no calibration believes


def side_of(name: str) -> str:
    """Which of `SIDES` a name of `FRAMES` is of."""
    return name.partition(".")[0]


def set_name(name: str, number: int) -> str:
    """A name of `FRAMES` for the instrument of a set, by its number from 1, beside that of the first."""
    return f"{name}@{number}"


def plain_name(name: str) -> str:
    """The name without the set's number: what the parameter moves."""
    return name.partition("@")[0]


def is_one_sets(name: str) -> bool:
    """Whether it is of a further set's instrument alone: nothing of the cell's."""
    return "@" in name


class TermKind(StrEnum):
    """What a motion term is proportional to."""

    PLACE = "place"  # no motion: a displacement of a frame
    ZERO = "zero"
    SCALE = "scale"
    COMPLIANCE = "compliance"
    COS = "cos"
    SIN = "sin"
    BY = "by"


@dataclass(frozen=True, slots=True)
class ErrorTerm:
    """One parameter's place: the kernel's slot, and for motions what they are proportional to.

    joint: index in the chain, -1 for base, tool and root. order: of gear ripple. by: an axis's or a quantity's name.
    """

    name: str
    slot: int
    kind: TermKind = TermKind.PLACE
    joint: int = -1
    order: float = 0.0
    by: str = ""


def term_of(cell: Cell, name: str) -> ErrorTerm:
    """The term that a name stands for. Raises LogError for a name that says nothing on this cell."""
    owner, _, rest = name.partition(".")
    if owner in SIDES and rest in PARTS:
        return ErrorTerm(name, (BASE if owner == "base" else TOOL) + PARTS.index(rest))
    if owner == "root" and (found := re.fullmatch(r"(x|y|z|rx|ry|rz)\.by\.(\w{1,31})", rest)):
        return ErrorTerm(name, ROOT + PARTS.index(found[1]), TermKind.BY, by=found[2])
    if owner not in cell.axis_names:
        known = f"base, tool, root, {', '.join(cell.axis_names)}"
        raise LogError(
            f"{name[:40]!r} is not an error parameter of cell {cell.name}", hint=f"begin with one of {known}"
        )
    i = cell.index(owner)
    joint = cell.joints[i]
    slot = JOINT + JOINT_SLOTS * i
    arm = ("x", "y", "z", "rx", "ry")
    external = ("rx", "ry") if joint.prismatic else ("x", "y", "rx", "ry")
    places = arm if joint.role is Role.ARM else external
    if rest in places:
        return ErrorTerm(name, slot + PARTS.index(rest), joint=i)
    found = _MOTION.fullmatch(rest)
    if not found:
        hint = f"use {owner} with {', '.join(places)}, zero, scale, compliance, cos1, sin1, by.NAME"
        raise LogError(f"{name[:40]!r} is not an error parameter", hint=hint)
    if found[1]:
        return ErrorTerm(name, slot + MOTION, TermKind(found[1]), i)
    if found[2]:
        return ErrorTerm(name, slot + MOTION, TermKind(found[2]), i, float(found[3]))
    return ErrorTerm(name, slot + MOTION, TermKind.BY, i, by=found[4])


def parameter_of(cell: Cell, name: str) -> Parameter:
    """A free parameter at 0 with its unit, its ordinary size, and bounds that only base and tool lack."""
    term = term_of(cell, name)
    length = Parameter(name, "m", 1e-3, lower=-_LENGTH, upper=_LENGTH)
    angle = Parameter(name, "rad", 1e-3, lower=-_ANGLE, upper=_ANGLE)
    if term.joint < 0:
        part = name.split(".")[1]
        if term.kind is TermKind.BY:
            return Parameter(name, "", 1e-3)
        return Parameter(name, "rad" if part[0] == "r" else "m", 1e-3)
    prismatic = cell.joints[term.joint].prismatic
    if term.kind is TermKind.PLACE:
        return angle if name.rpartition(".")[2][0] == "r" else length
    if term.kind is TermKind.SCALE:
        return Parameter(name, "1", 1e-4, lower=-_SCALE, upper=_SCALE)
    if term.kind is TermKind.COMPLIANCE:
        return Parameter(name, "m/N" if prismatic else "rad/Nm", 1e-6, lower=-_COMPLIANCE, upper=_COMPLIANCE)
    if term.kind is TermKind.BY:
        return Parameter(name, "", 1e-3)
    return length if prismatic else angle


def standard_names(cell: Cell, *, table: bool = False, track: bool = True, harmonics: int = 0) -> tuple[str, ...]:
    """The parameters of an ordinary calibration, in the order in which they claim what they share with others.

    Base and tool (12); zeros of the arm (6); its axes' places (24), with the zeros the 30 geometric ones; 5
    compliances, A2 to A6, where the cell says its masses; scale and place of external axes (of workpiece axes with
    `table`: measured from `base`), scale of the arm's own slides; `harmonics` orders of gear ripple an arm axis.
    """
    arm = [j.name for j in cell.joints if j.role is Role.ARM]
    names = [*FRAMES]
    for joint in cell.joints:
        if (joint.role is Role.CARRIAGE and track) or (joint.role is Role.WORKPIECE and table):
            places = ("rx", "ry") if joint.prismatic else ("x", "y", "rx", "ry")
            names += [f"{joint.name}.{part}" for part in ("scale", *places)]
    names += [f"{j.name}.scale" for j in cell.joints if j.role is Role.ARM and j.prismatic]
    names += [f"{a}.zero" for a in arm]
    names += [f"{a}.{part}" for a in arm for part in ("x", "y", "rx", "ry")]
    if cell.masses:
        names += [f"{a}.compliance" for a in arm[1:]]
    names += [f"{a}.{wave}{k}" for k in range(1, harmonics + 1) for a in arm for wave in ("cos", "sin")]
    return tuple(names)
