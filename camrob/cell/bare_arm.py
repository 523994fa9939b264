"""An arm in short: rows of Denavit and Hartenberg of either convention, or a URDF, for a cell that is only measured."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Joint, Role
from camrob.cell.load import PointMass
from camrob.cell.read_joint import CONVENTIONS, row_of
from camrob.errors import InputError
from camrob.se3 import abc_to_rotation, rotation_exp
from camrob.text import bytes_of
from camrob.toml.table_reader import TableReader
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["BareArm", "read_bare_arm"]

Array = NDArray[np.float64]
Way = list[ElementTree.Element]

_MOST = 7  # axes that a log names
_WHOLE_ARM = 6  # turning axes that reach every pose of a place
_LARGEST = 10_000_000  # bytes of a URDF, without its meshes
_MOST_TURNS = 10  # of a joint with limits: no arm's cables take more
_MOVING = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class BareArm:
    """joints: A1, A2 .. ; masses: of a URDF's links, as points; wrist_T_flange: (4, 4) what stands behind the last joint."""

    joints: tuple[Joint, ...]
    masses: tuple[PointMass, ...]
    wrist_T_flange: Array


def read_bare_arm(table: TableReader, folder: Path) -> BareArm:
    """[arm]: `dh`, rows of alpha_deg, a_mm, theta_deg, d_mm, with `convention` "standard" or "modified"; or `urdf`, a file of the
    cell's folder, with the link `tip` where its chain ends.

    The conventions are those of `row_of`. Raises CellError naming the key.
    """
    if ("dh" in table) == ("urdf" in table):
        raise table.fail("dh", "and urdf: one of the two is needed", "give rows of Denavit and Hartenberg, or a URDF")
    arm = _of_urdf(table, folder) if "urdf" in table else _of_rows(table)
    signs, offsets = _each(table, "signs", len(arm.joints)), _each(table, "offsets_deg", len(arm.joints))
    if signs is not None and not np.isin(signs, (1.0, -1.0)).all():
        raise table.fail("signs", "holds others than 1 and -1", "give 1 or -1 for each axis")
    joints = tuple(
        replace(
            j,
            sign=1.0 if signs is None else float(signs[k]),
            offset=0.0
            if offsets is None
            else mm_to_m(float(offsets[k]))
            if j.prismatic
            else deg_to_rad(float(offsets[k])),
        )
        for k, j in enumerate(arm.joints)
    )
    table.finish()
    return BareArm(joints, arm.masses, arm.wrist_T_flange)


def _each(table: TableReader, key: str, count: int) -> Array | None:
    """One number an axis, in degrees (mm of a sliding one) where it is an offset; None where the key is absent."""
    return table.vector(key, count) if key in table else None


def _of_rows(table: TableReader) -> BareArm:
    rows = table.vectors("dh", 4)
    if not 1 <= len(rows) <= _MOST:
        raise table.fail("dh", f"has {len(rows)} rows", f"give one for each axis, 1 to {_MOST}")
    modified = "convention" in table and table.text("convention", choices=CONVENTIONS) == "modified"
    kinds = table.text("kinds") if "kinds" in table else "R" * len(rows)
    if len(kinds) != len(rows) or set(kinds) - {"R", "P"}:
        raise table.fail("kinds", f"is {kinds[:20]!r}", "give R (turns) or P (slides) for each axis, such as RRPR")
    joints = []
    for k, (alpha, a, theta, d) in enumerate(rows):
        before, after = row_of(float(alpha), float(a), float(theta), float(d), modified=modified)
        joints.append(Joint(f"A{k + 1}", Role.ARM, kinds[k] == "P", before, after))
    return BareArm(tuple(joints), (), np.eye(4))


def _of_urdf(table: TableReader, folder: Path) -> BareArm:
    name = table.text("urdf")
    file = folder / name
    if Path(name).is_absolute() or ".." in Path(name).parts or not os.path.isfile(file):
        raise table.fail("urdf", f"{name[:60]!r} is not a file in the cell's folder", "put the URDF there")
    text = bytes_of(file, _LARGEST)
    if len(text) > _LARGEST or b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        raise table.fail("urdf", "is too large, or declares entities", "give a plain URDF")
    try:
        robot = ElementTree.fromstring(text)
        if _unexpanded(robot):
            raise _xacro(table)
        return _chain(robot, table)
    except ElementTree.ParseError as error:
        if b"<xacro:" in text:  # whose prefix nobody has declared
            raise _xacro(table) from None
        what = f"is no URDF: it is not well-formed XML ({str(error)[:100]})"
        raise table.fail("urdf", what, "give the file that ROS or the robot's maker calls a URDF") from None
    except ValueError as error:
        raise table.fail("urdf", f"can't be read: {str(error)[:100]}", "give a URDF that a parser takes") from None


def _xacro(table: TableReader) -> InputError:
    """The error to raise for a file that xacro has not been through."""
    return table.fail("urdf", "is a xacro file", "expand it first: xacro FILE > robot.urdf")


def _unexpanded(robot: ElementTree.Element) -> bool:
    """Whether xacro has work to do yet: its own elements, or an expression in an attribute. What stands in comments it left."""
    return any("xacro" in one.tag or any("${" in value for value in one.attrib.values()) for one in robot.iter())


def _chain(robot: ElementTree.Element, table: TableReader) -> BareArm:
    """The chain from the root link to the tip."""
    carried = [
        (j.find("child").get("link"), j)  # type: ignore[union-attr]
        for j in robot.iter("joint")
        if j.find("child") is not None and j.find("parent") is not None
    ]
    into = dict(carried)
    if len(into) < len(carried):
        raise table.fail("urdf", "has a link that two joints carry", "give a URDF whose links form a tree")
    parents = {c: j.find("parent").get("link") for c, j in into.items()}  # type: ignore[union-attr]
    tip = table.text("tip") if "tip" in table else ""
    if not tip:
        # what stands still (ROS-Industrial's `base` beside `tool0`) is nobody's tip
        ends = [str(c) for c in into if c not in parents.values() and _moving(_way(str(c), into, parents))]
        ends.sort(key=lambda end: -len(_moving(_way(end, into, parents))))
        if len(ends) != 1:
            one = f"name one, such as {', '.join(ends[:5])}" if ends else "give one whose links move and end"
            raise table.fail("tip", f"is needed where a URDF has {len(ends)} ends that move, not 1", one)
        tip = ends[0]
    if tip not in into:
        raise table.fail("tip", f"{tip[:40]!r} is not a link that a joint carries", "name a link of the URDF")
    way = _way(tip, into, parents)
    for element in _moving(way):
        _check_alone(element, table)
    links = {str(one.get("name")): one for one in robot.iter("link")}
    joints: list[Joint] = []
    masses: list[PointMass] = []
    moved_T_link = np.eye(4)  # from the last moving link, or the root
    for element in way:
        moved_T_link = moved_T_link @ _origin(element)
        kind, child = element.get("type"), str(element.find("child").get("link"))  # type: ignore[union-attr]
        if kind in _MOVING:
            joints.append(_joint_of(element, f"A{len(joints) + 1}", moved_T_link))
            moved_T_link = np.eye(4)
        elif kind != "fixed":
            raise table.fail("urdf", f"has a joint of type {str(kind)[:20]!r}", "make it revolute, prismatic or fixed")
        if joints and child in links:
            masses += _mass_of(links[child], joints[-1].name, moved_T_link)
    if _placeholders([links[m.name] for m in masses]):
        masses = []
    joints, masses = _lifted(joints, masses)
    if not 1 <= sum(j.role is Role.ARM for j in joints) <= _MOST:
        names = [str(e.find("child").get("link")) for e in _moving(way)]  # type: ignore[union-attr]
        behind = f"name a tip behind 1 to {_MOST}" + (
            f", such as {names[_WHOLE_ARM - 1]}" if len(names) > _MOST else ""
        )
        raise table.fail("urdf", f"has {len(joints)} moving joints up to its tip", behind)
    return BareArm(tuple(joints), tuple(masses), moved_T_link)


def _way(tip: str, into: Mapping[str | None, ElementTree.Element], parents: Mapping[str | None, str | None]) -> Way:
    """The joints from the root to a link."""
    way: Way = []
    link: str | None = tip
    while link in into and len(way) <= len(into):
        way.append(into[link])
        link = parents[link]
    return way[::-1]


def _moving(way: Way) -> Way:
    return [element for element in way if element.get("type") in _MOVING]


def _check_alone(element: ElementTree.Element, table: TableReader) -> None:
    """Raises CellError for a joint that follows another one, and for one whose limits can't be radians."""
    name, mimic, limit = str(element.get("name"))[:40], element.find("mimic"), element.find("limit")
    if mimic is not None:
        what = f"has a joint {name!r} that follows {str(mimic.get('joint'))[:40]!r} (mimic: a geared wrist, a parallelogram)"
        raise table.fail("urdf", what, "an arm whose axes turn each other is not known to a cell: no rows stand for it")
    if element.get("type") == "revolute" and limit is not None:
        ends = [abs(_finite(limit.get(side, "0"))) for side in ("lower", "upper")]
        if max(ends) > _MOST_TURNS * 2.0 * np.pi:
            what = f"has a joint {name!r} with a limit of {max(ends):g} rad, which look like degrees"
            raise table.fail("urdf", what, "give limits in radians, or make a joint without limits continuous")


def _lifted(joints: list[Joint], masses: list[PointMass]) -> tuple[list[Joint], list[PointMass]]:
    """Sliding axes beneath an arm of six that turn or more (a lift, a track) are external, E1 ..; the arm's are counted anew."""
    slides = next((k for k, j in enumerate(joints) if not j.prismatic), 0)
    if not slides or len(joints) - slides < _WHOLE_ARM or any(j.prismatic for j in joints[slides:]):
        return joints, masses
    names = [f"E{k + 1}" for k in range(slides)] + [f"A{k + 1}" for k in range(len(joints) - slides)]
    known = {j.name: name for j, name in zip(joints, names, strict=True)}
    roles = [Role.CARRIAGE] * slides + [Role.ARM] * (len(joints) - slides)
    named = [replace(j, name=n, role=r) for j, n, r in zip(joints, names, roles, strict=True)]
    return named, [replace(m, after=known[m.after]) for m in masses]


def _joint_of(element: ElementTree.Element, name: str, before: Array) -> Joint:
    """A moving joint; its frame is turned so that the axis is z, and turned back behind it."""
    axis = _numbers(element.find("axis"), "xyz", (1.0, 0.0, 0.0))
    if not np.any(axis):
        raise ValueError(f"joint {str(element.get('name'))[:40]!r} has an axis of no length")
    axis = axis / np.linalg.norm(axis)
    across = np.cross([0.0, 0.0, 1.0], axis)
    size = float(np.linalg.norm(across))
    angle = float(np.arctan2(size, axis[2]))
    turned = np.eye(4)
    turned[:3, :3] = rotation_exp(across / size * angle if size > 0.0 else np.array([angle, 0.0, 0.0]))
    limit, kind = element.find("limit"), element.get("type")
    known = {}
    if limit is not None and kind != "continuous" and "lower" in limit.attrib and "upper" in limit.attrib:
        known = {side: _finite(limit.attrib[side]) for side in ("lower", "upper")}
    speed = 0.0 if limit is None else _finite(limit.get("velocity", "0"))
    if speed > 0.0:
        known["speed"] = speed
    return Joint(name, Role.ARM, kind == "prismatic", before @ turned, turned.T, **known)


def _mass_of(link: ElementTree.Element, after: str, moved_T_link: Array) -> list[PointMass]:
    inertial = link.find("inertial")
    found = None if inertial is None else inertial.find("mass")
    if inertial is None or found is None:
        return []
    center = moved_T_link @ np.append(_origin(inertial)[:3, 3], 1.0)
    return [PointMass(str(link.get("name")), after, _finite(found.get("value", "0")), center[:3])]


def _placeholders(links: list[ElementTree.Element]) -> bool:
    """Whether the masses of some links were made up to satisfy a simulator: all alike, each in its link's own origin."""
    bodies = [i for i in (link.find("inertial") for link in links) if i is not None and i.find("mass") is not None]
    values = {_finite(body.find("mass").get("value", "0")) for body in bodies}  # type: ignore[union-attr]
    return len(bodies) > 2 and len(values) == 1 and not any(_origin(body)[:3, 3].any() for body in bodies)


def _origin(element: ElementTree.Element) -> Array:
    """(4, 4) of <origin>; its rpy is C, B, A."""
    origin, T = element.find("origin"), np.eye(4)
    T[:3, 3] = _numbers(origin, "xyz", (0.0, 0.0, 0.0))
    T[:3, :3] = abc_to_rotation(_numbers(origin, "rpy", (0.0, 0.0, 0.0))[::-1])
    return T


def _finite(text: str) -> float:
    """A number of an attribute. Raises ValueError."""
    value = float(text)
    if not np.isfinite(value):
        raise ValueError(f"a number is {text[:40]!r}")
    return value


def _numbers(element: ElementTree.Element | None, key: str, otherwise: tuple[float, float, float]) -> Array:
    """Three finite numbers of an attribute. Raises ValueError."""
    text = None if element is None else element.get(key)
    values = np.array(otherwise if text is None else [float(v) for v in text.split()])
    if values.shape != (3,) or not np.isfinite(values).all():
        raise ValueError(f"{key} is {str(text)[:40]!r}")
    return values
