"""Poses of a cell's frames in plain NumPy, for postures of any leading shape; the twin of the compiled kernels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.se3 import inverse

__all__ = [
    "base_T_flange",
    "base_T_joint_axes",
    "base_T_joint_frames",
    "base_T_root",
    "base_T_tool",
    "seen_by_program",
    "tool_jacobians",
    "tool_poses",
    "world_T_base",
]

Array = NDArray[np.float64]

_CHUNK = 4096  # postures that are worked on together, so that what they need stays in the processor's cache


def base_T_joint_frames(cell: Cell, q: Array, *, first: int | None = None) -> Array:
    """Frames (n, ..., 4, 4) that the joints' Denavit-Hartenberg rows end in, seen from `base`, of postures q (..., n).

    first: of so many joints only, from the workpiece on.
    """
    frames = []
    T = np.broadcast_to(cell.base_T_first, (*q.shape[:-1], 4, 4))
    last_of_arm = cell.indices(Role.ARM)[-1]
    for i, joint in enumerate(cell.joints[:first]):
        T = T @ joint.before @ joint.motion(q[..., i]) @ joint.after
        frames.append(T)
        if i == last_of_arm:
            T = T @ cell.wrist_T_flange @ cell.flange_T_tool
    return np.stack(frames)


def base_T_joint_axes(cell: Cell, q: Array) -> Array:
    """Frames (n, ..., 4, 4) about or along whose z the joints move, seen from `base`, of postures q (..., n)."""
    frames = base_T_joint_frames(cell, q)
    rows = np.concatenate([np.broadcast_to(cell.base_T_first, frames[:1].shape), frames[:-1]])  # where each begins
    if roll := cell.indices(Role.ROLL):
        rows[roll[0]] = rows[roll[0]] @ cell.wrist_T_flange @ cell.flange_T_tool
    return np.stack([row @ joint.before for row, joint in zip(rows, cell.joints, strict=True)])


def tool_jacobians(cell: Cell, q: Array) -> Array:
    """Geometric Jacobians (N, 6, n) of the tool's tip in `base`, rows (v, w), of postures q (N, n)."""
    tip = base_T_tool(cell, q)[:, :3, 3]
    columns = []
    for joint, axis in zip(cell.joints, base_T_joint_axes(cell, q), strict=True):
        z, p = axis[:, :3, 2], axis[:, :3, 3]
        v, w = (z, np.zeros_like(z)) if joint.prismatic else (np.cross(z, tip - p), z)
        columns.append(np.concatenate([v, w], axis=1))
    return np.stack(columns, axis=2)


def base_T_tool(cell: Cell, q: Array) -> Array:
    """Where postures put the tool, its virtual roll included.

    Args:
        cell: the machine, with its tool.
        q: postures (..., n), rad and m, in the chain's order.

    Returns:
        Poses (..., 4, 4) of `tool` in `base`, m.

    Raises:
        ValueError: postures of another number of joints.

    Example:
        >>> cell = camrob.read_cell(Path("cells/kr15_track_table"))
        >>> camrob.base_T_tool(cell, cell.q_home[None]).shape
        (1, 4, 4)
    """
    if q.shape[-1:] != (len(cell),):
        raise ValueError(f"postures are {q.shape}, expected {len(cell)} numbers each")
    frames = base_T_joint_frames(cell, q)
    if cell.indices(Role.ROLL):
        return np.asarray(frames[-1])
    return np.asarray(frames[-1] @ cell.wrist_T_flange @ cell.flange_T_tool)


def tool_poses(cell: Cell, q: Array) -> Array:
    """`base_T_tool` of many postures q (N, n), to rounding, in a fifth of the time: by columns instead of matrices.

    Programs aren't made of it: a target half way between two printed numbers has to fall to the same side as ever.
    """
    T = np.zeros((len(q), 4, 4))
    T[:, 3, 3] = 1.0
    for start in range(0, len(q), _CHUNK):
        part = slice(start, start + _CHUNK)
        T[part, :3] = _tool_columns(cell, np.ascontiguousarray(q[part].T)).transpose(2, 1, 0)
    return T


def _tool_columns(cell: Cell, q: Array) -> Array:
    """Columns x, y, z and place (4, 3, M) of the tool in `base`, of postures q (n, M)."""
    columns = np.repeat(cell.base_T_first[:3].T[:, :, None], q.shape[1], axis=2)
    last_of_arm = cell.indices(Role.ARM)[-1]
    for i, joint in enumerate(cell.joints):
        x, y, z, place = columns = _moved(columns, joint.before)
        if joint.prismatic:
            place += q[i] * z
        else:
            cosine, sine = np.cos(q[i]), np.sin(q[i])
            columns[0], columns[1] = x * cosine + y * sine, y * cosine - x * sine
        columns = _moved(columns, joint.after)
        if i == last_of_arm:
            columns = _moved(columns, cell.wrist_T_flange @ cell.flange_T_tool)
    return columns


def _moved(columns: Array, transform: Array) -> Array:
    """The frames, as columns, behind a constant transform (4, 4)."""
    return np.asarray(transform.T @ columns.reshape(4, -1)).reshape(columns.shape)


def base_T_flange(cell: Cell, q: Array) -> Array:
    """Pose (..., 4, 4) of the mounting plate."""
    base_T_wrist = base_T_joint_frames(cell, q)[cell.indices(Role.ARM)[-1]]
    return np.asarray(base_T_wrist @ cell.wrist_T_flange)


def base_T_root(cell: Cell, q: Array) -> Array:
    """Pose (..., 4, 4) of the robot's root (`$ROBROOT`)."""
    first_of_arm = cell.indices(Role.ARM)[0]
    if first_of_arm == 0:
        base_T_foot = np.broadcast_to(cell.base_T_first, (*q.shape[:-1], 4, 4))  # frames: foot is first
    else:
        base_T_foot = base_T_joint_frames(cell, q, first=first_of_arm)[first_of_arm - 1]
    return np.asarray(base_T_foot @ cell.foot_T_root)


def world_T_base(cell: Cell, q: Array) -> Array:
    """Pose (..., 4, 4) of `base` in `world`; `world` stands on the floor, where `base` is when all workpiece axes are at 0."""
    workpiece = cell.indices(Role.WORKPIECE)
    if not workpiece:
        return np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4))
    zero = np.array(cell.q_home)
    for i in workpiece:
        zero[i] = float(cell.joints[i].q_value(np.zeros(())))
    of = workpiece[-1] + 1
    world_T_floor = base_T_joint_frames(cell, zero, first=of)[-1]  # frames: world is base
    base_T_floor = base_T_joint_frames(cell, q, first=of)[-1]
    return np.asarray(world_T_floor @ inverse(base_T_floor))


def seen_by_program(cell: Cell, q: Array, poses: Array) -> Array:
    """Poses (N, 4, 4) in `base`, of postures q (N, n), in the frame that a program's base without an offset stands for.

    That is `base` where it follows the table, else `world`, where `base` is while the table is at 0.
    """
    if cell.base_follows_table:
        return poses
    return np.asarray(world_T_base(cell, q) @ poses)  # frames: world is base
