"""Why a point can't be followed: which axis, which line, how far, and what every other posture would meet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.errors import JobError, LimitError, SingularError, UnreachableError
from camrob.kinematics.arm import STARTS, Arm
from camrob.kinematics.frames import base_T_tool
from camrob.redundancy.following.follower import FAILED_SINGULAR, FollowState
from camrob.redundancy.path import ToolPathInBase
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["explain_failure", "tally_postures"]

Array = NDArray[np.float64]

_TURN, _SPAN = 12, 9  # values of an endless axis, and of one with limits, that a scan goes through


def tally_postures(cell: Cell, arm: Arm, base_T_tip: Array, near: Array) -> dict[str, int]:
    """What an even scan over external axes, roll and branches meets at a pose: reason to count, "in reach" among them."""
    grids = []
    for i, joint in enumerate(cell.joints):
        if joint.role is Role.ARM:
            continue
        if joint.endless:
            grids.append((i, np.linspace(-np.pi, np.pi, _TURN, endpoint=False)))
        else:
            grids.append((i, np.linspace(joint.q_lower, joint.q_upper, _SPAN)))
    tally: dict[str, int] = {}
    mesh = np.meshgrid(*[g for _, g in grids], indexing="ij") if grids else []
    count = mesh[0].size if grids else 1
    postures = np.tile(near, (count, 1))
    for (i, _), values in zip(grids, mesh, strict=True):
        postures[:, i] = values.ravel()
    poses = arm.foot_T_tool(np.broadcast_to(base_T_tip, (count, 4, 4)), postures)  # frames: tip is tool
    for k in range(count):
        inside = len(arm.branches(poses[k], near[cell.arm_slice]))
        if inside:
            tally["in reach"] = tally.get("in reach", 0) + inside
        for reason, number in arm.reasons(poses[k], near[cell.arm_slice]).items():
            tally[reason] = tally.get(reason, 0) + number
    return tally


def _tried(cell: Cell, arm: Arm) -> str:
    """How it is known that no posture reaches a point: by what is closed over a lattice, or by a search, which proves nothing."""
    axes = [j for j in cell.joints if j.role is not Role.ARM]
    values = int(np.prod([_TURN if j.endless else _SPAN for j in axes]))
    where = f" at each of {values} values of {', '.join(j.name for j in axes)}" if axes else ""
    if arm.searched:
        return f"searched from {STARTS} starts{where}, which is not a proof"
    return f"all branches by closed form{where}"


def explain_failure(
    cell: Cell, arm: Arm, path: ToolPathInBase, point: int, base_T_target: Array, code: int, state: FollowState
) -> JobError:
    """The error for a path point (index) that the follower could not follow; `base_T_target` is where it stopped short."""
    line = int(path.line[point]) or int(path.line[min(point + 1, len(path) - 1)])
    region = str(int(path.region[point])) if path.region[point] >= 0 else ""
    reached = base_T_tool(cell, state.q)
    gap = float(np.linalg.norm(base_T_target[:3, 3] - reached[:3, 3]))
    tally = tally_postures(cell, arm, base_T_target, state.q)  # frames: target is tip
    stopped = [i for i in range(len(cell)) if state.side[i] != 0]
    tilt = float(np.arccos(np.clip(base_T_target[:3, 2] @ reached[:3, 2], -1.0, 1.0)))
    short = f"the tool stays {m_to_mm(gap):.3f} mm and {rad_to_deg(tilt):.3f} degrees away"
    if code == FAILED_SINGULAR:
        return SingularError(
            f"the cell has no way on from a singular posture; {short}; place the part elsewhere (part_in_base)",
            line=line,
            region=region,
            reasons=tally,
        )
    if not tally.get("in reach"):
        return UnreachableError(
            f"no posture of the cell reaches this point ({_tried(cell, arm)}); {short}; place the part elsewhere (part_in_base)",
            line=line,
            region=region,
            reasons=tally,
        )
    if stopped:
        i = stopped[0]
        joint = cell.joints[i]
        limit = joint.upper if (state.side[i] > 0) == (joint.sign > 0) else joint.lower
        edge = m_to_mm(limit) if joint.prismatic else rad_to_deg(limit)
        names = ", ".join(cell.names[k] for k in stopped)
        return LimitError(
            f"the path can't be followed within the limits ({names} at the end of travel); {short}; other postures reach "
            "the point: move the part (part_in_base) or cut the operation in two",
            line=line,
            region=region,
            axis=joint.name,
            value=edge,
            limit=edge,
            unit="mm" if joint.prismatic else "degrees",
            reasons=tally,
        )
    return UnreachableError(
        f"the path can't be followed from the posture that it was begun in; {short}; move the part (part_in_base) "
        "or cut the operation in two",
        line=line,
        region=region,
        reasons=tally,
    )
