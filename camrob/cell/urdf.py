"""A cell's chain as URDF, for second opinions by other libraries."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Joint
from camrob.cell.load import PointMass
from camrob.cell.world import segments
from camrob.se3 import rotation_to_abc

__all__ = ["cell_urdf"]

Array = NDArray[np.float64]


def cell_urdf(cell: Cell) -> str:
    """The whole chain base -> tool as URDF text; its joint values are the chain's q, SI, not the controller's axis values.

    Links and fixed links are those of `segments`. Limits are those of q; an endless joint is `continuous`. Numbers
    carry 17 digits, so that float64 survives the text. The cell's point masses become inertials of the links they are
    fixed to (several on a link are merged); links without masses have none. Efforts, unknown to a cell, are 0.

    pytorch-kinematics parses URDF in float32 (errors of about 1e-7 m); `kinematics.batched` builds its chain without.
    """
    robot = ElementTree.Element("robot", name=cell.name)
    ElementTree.SubElement(robot, "link", name="base")
    parent = "base"
    for segment in segments(cell):
        link = ElementTree.SubElement(robot, "link", name=segment.link)
        joint = segment.joint
        if joint is None:
            element = ElementTree.SubElement(robot, "joint", name=f"fixed-{segment.link}", type="fixed")
        else:
            masses = [m for m in cell.masses if m.after == joint.name]
            if masses:
                _inertial(link, joint, masses)
            kind = "prismatic" if joint.prismatic else "continuous" if joint.endless else "revolute"
            element = ElementTree.SubElement(robot, "joint", name=joint.name, type=kind)
        ElementTree.SubElement(element, "parent", link=parent)
        ElementTree.SubElement(element, "child", link=segment.link)
        _origin(element, segment.parent_T_joint)
        if joint is not None:
            ElementTree.SubElement(element, "axis", xyz="0 0 1")
            _limit(element, joint)
        parent = segment.link
    ElementTree.indent(robot)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(robot, encoding="unicode") + "\n"


def _numbers(values: Iterable[float]) -> str:
    """Numbers with all the digits of float64."""
    return " ".join(f"{float(v) + 0.0:.17g}" for v in values)  # + 0.0: no -0


def _origin(parent: ElementTree.Element, parent_T_child: Array) -> None:
    """<origin>; URDF's rpy is C, B, A."""
    abc = rotation_to_abc(parent_T_child[:3, :3])
    ElementTree.SubElement(parent, "origin", xyz=_numbers(parent_T_child[:3, 3]), rpy=_numbers(abc[::-1]))


def _limit(parent: ElementTree.Element, joint: Joint) -> None:
    """<limit>, which URDF wants of every revolute and prismatic joint."""
    attributes = {"effort": "0", "velocity": _numbers([joint.speed if np.isfinite(joint.speed) else 0.0])}
    if not joint.endless:
        attributes |= {"lower": _numbers([joint.q_lower]), "upper": _numbers([joint.q_upper])}
    ElementTree.SubElement(parent, "limit", attributes)


def _inertial(link: ElementTree.Element, joint: Joint, masses: list[PointMass]) -> None:
    """<inertial> of point masses that are fixed behind `joint`; their centres are in the frame that its row ends in."""
    total = sum(m.mass for m in masses)
    centers = np.array([joint.after[:3, :3] @ m.center + joint.after[:3, 3] for m in masses])
    weights = np.array([m.mass for m in masses])
    center = weights @ centers / total if total > 0.0 else centers[0]
    arms = centers - center
    inertia = np.einsum("k,kij->ij", weights, [d @ d * np.eye(3) - np.outer(d, d) for d in arms])
    element = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(element, "origin", xyz=_numbers(center), rpy="0 0 0")
    ElementTree.SubElement(element, "mass", value=_numbers([total]))
    names = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    ElementTree.SubElement(element, "inertia", {name: _numbers([inertia[rc]]) for name, rc in names.items()})
