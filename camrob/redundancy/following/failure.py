"""Why a point can't be followed: which axis, which line, how far, and what every other posture would meet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import JobError, LimitError, SingularError, UnreachableError
from camrob.kinematics.arm import STARTS, Arm
from camrob.kinematics.frames import base_T_tool
from camrob.redundancy.following.follower import FAILED_SINGULAR, FollowState
from camrob.redundancy.following.nearest_miss import Miss, nearest_miss, way_into_span
from camrob.redundancy.path import ToolPathInBase
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["explain_failure", "explain_unreached"]

Array = NDArray[np.float64]

_ELSEWHERE = "place the part elsewhere (part_in_base)"


def _evidence(cell: Cell, arm: Arm, base_T_tip: Array, miss: Miss) -> str:
    """What it rests on that no posture reaches a point, and what would have to give."""
    way = way_into_span(cell, arm, base_T_tip)
    beyond = float(np.linalg.norm(way))
    where = f" at each of {miss.values} values of {', '.join(miss.axes)}" if miss.axes else ""
    if beyond > 0.0:
        moved = ", ".join(
            f"{axis} {v:+.0f}" for axis, v in zip("XYZ", m_to_mm(way).tolist(), strict=True) if abs(v) >= 1.0
        )
        nearer = f", so the part has to come that much nearer, as by {moved} mm in base" if moved else ""
        return f"proved: {m_to_mm(beyond):.0f} mm at least beyond the stretched arm{_wherever(cell)}{nearer}"
    if arm.searched:
        known = f"searched from {STARTS} starts{where}, which is not a proof"
    elif miss.axes or not arm.proves:
        branches = "all branches by closed form" if arm.proves else "the branches round the last axis"
        known = f"searched, not proved: {branches}{where}" + (", and on from the nearest" if miss.axes else "")
    else:
        known = "proved: all branches by closed form"
    if miss.q is None:
        return f"{known}; whatever its limits, the arm is too short there, or folds too little"
    joints = " and ".join(f"{name} by {rad_to_deg(past):.1f}" for name, past in miss.past.items())
    stand = ", ".join(_stand(cell, name, miss.q) for name in cell.external_names)
    return f"{known}; the nearest posture passes the limits of {joints} degrees" + (f", with {stand}" if stand else "")


def _wherever(cell: Cell) -> str:
    names = cell.external_names
    return f", wherever {' and '.join(names)} stand{'s' if len(names) == 1 else ''}" if names else ""


def _stand(cell: Cell, name: str, q: Array) -> str:
    """Where an external axis stands in a posture, as the controller shows it."""
    i = cell.index(name)
    value = float(cell.joints[i].axis_value(q[i]))
    return f"{name} at " + (
        f"{m_to_mm(value):.0f} mm" if cell.joints[i].prismatic else f"{rad_to_deg(value):.1f} degrees"
    )


def explain_failure(
    cell: Cell, arm: Arm, path: ToolPathInBase, point: int, base_T_target: Array, code: int, state: FollowState
) -> JobError:
    """The error for a path point (index) that the follower could not follow; `base_T_target` is where it stopped short."""
    line, region = _place(path, point)
    reached = base_T_tool(cell, state.q)
    base_T_point = np.asarray(path.base_T_tip[point])  # frames: point is tip
    gap = float(np.linalg.norm(base_T_point[:3, 3] - reached[:3, 3]))
    miss = nearest_miss(cell, arm, base_T_target, state.q)  # frames: target is tip
    stopped = [i for i in range(len(cell)) if state.side[i] != 0]
    tilt = float(np.arccos(np.clip(base_T_point[:3, 2] @ reached[:3, 2], -1.0, 1.0)))
    short = f"the tool stops {m_to_mm(gap):.3f} mm and {rad_to_deg(tilt):.3f} degrees before it"
    if code == FAILED_SINGULAR:
        return SingularError(
            f"the cell has no way on from a singular posture; {short}; {_ELSEWHERE}",
            line=line,
            region=region,
            reasons=miss.tally,
        )
    if not miss.reached:
        what, cure = _named(path, point)
        there = nearest_miss(cell, arm, base_T_point, state.q)  # frames: point is tip
        if there.reached:
            known = f"the way to {what} ({_evidence(cell, arm, base_T_target, miss)}); {short}"
        else:
            known = f"{what} ({_evidence(cell, arm, base_T_point, there)})"
        return UnreachableError(
            f"no posture of the cell reaches {known}; {cure}",
            line=line,
            region=region,
            reasons=miss.tally,
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
            reasons=miss.tally,
        )
    return UnreachableError(
        f"the path can't be followed from the posture that it was begun in; {short}; move the part (part_in_base) "
        "or cut the operation in two",
        line=line,
        region=region,
        reasons=miss.tally,
    )


def explain_unreached(cell: Cell, arm: Arm, path: ToolPathInBase, point: int, base_T_target: Array) -> JobError:
    """The error for a path point (index) that a scan of the plan's reached by no posture."""
    (line, region), (what, cure) = _place(path, point), _named(path, point)
    miss = nearest_miss(cell, arm, base_T_target, cell.q_home)  # frames: target is tip
    if miss.reached:
        scanned = f"the plan's scan of table, track and roll found no posture at {what}, though there is one"
        return UnreachableError(f"{scanned}; {_ELSEWHERE}, or leave out --method", line=line, region=region)
    known = _evidence(cell, arm, base_T_target, miss)
    return UnreachableError(
        f"no posture of the cell reaches {what} ({known}); {cure}",
        line=line,
        region=region,
        reasons=miss.tally,
    )


def _place(path: ToolPathInBase, point: int) -> tuple[int, str]:
    """Line and region of a path point (index)."""
    line = int(path.line[point]) or int(path.line[_beside(path, point)])
    return line, str(int(path.region[point])) if path.region[point] >= 0 else ""


def _named(path: ToolPathInBase, point: int) -> tuple[str, str]:
    """What a path point (index) is to whoever knows the file, and what to do where nothing reaches it."""
    if path.of_toolpath[point]:
        return "this point", _ELSEWHERE
    frames, own = np.asarray(path.base_T_tip), _beside(path, point)
    off = m_to_mm(float(np.linalg.norm(frames[point, :3, 3] - frames[own, :3, 3])))
    where = f"the safe point {off:.0f} mm off that of line {path.line[own]}, which clearance_mm puts there"
    return where, f"{_ELSEWHERE}, or lower clearance_mm"


def _beside(path: ToolPathInBase, point: int) -> int:
    """The file's own point that one of camrob's (index) is put before or, at the end, behind."""
    own = np.flatnonzero(path.of_toolpath)
    return int(own[min(int(np.searchsorted(own, point)), len(own) - 1)])
