"""Plain NumPy twins of the follower's compiled pieces, and short paths to track."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.kernels import chain_arrays
from camrob.redundancy.following.follower import FollowerSettings, FollowState, follow_path
from camrob.redundancy.fuzzy.surfaces import WeightSurface, compile_surface
from camrob.se3 import rotation_exp
from camrob.units import deg_to_rad

__all__ = ["CELL", "CHAIN", "FOLDER", "bilinear", "five_axis_path", "follow", "narrow", "settings_of", "state_at"]

FOLDER = Path(__file__).resolve().parents[1] / "cells" / "kr15_track_table"
CELL = read_cell(FOLDER)
CHAIN = chain_arrays(CELL)


def narrow(cell: Cell, q: np.ndarray, degrees: float) -> Cell:
    """The cell with an arm that goes no farther than that from a posture."""
    joints = list(cell.joints)
    for i in range(*cell.arm_slice.indices(len(cell))):
        value, d = float(joints[i].axis_value(q[i])), deg_to_rad(degrees)
        joints[i] = replace(joints[i], lower=value - d, upper=value + d)
    return replace(cell, joints=tuple(joints))


def settings_of(cell: Cell, **changed: object) -> FollowerSettings:
    surfaces = [compile_surface(cell, e) for e in (cell.resolve.joint_engine, cell.resolve.condition_engine)]
    locked = np.zeros(len(cell), np.bool_)
    whole = FollowerSettings(cell.q_lower, cell.q_upper, cell.endless, *surfaces, cell.resolve.threshold, locked)
    return whole._replace(**changed)


def state_at(q: np.ndarray, recorded: np.ndarray | None = None) -> FollowState:
    flags = np.array([0 if recorded is None else 1, 0], np.int64)
    return FollowState(q.copy(), (q if recorded is None else recorded).copy(), np.zeros(len(q), np.int64), flags)


def follow(settings, targets, state, reference=None, limit=np.inf, chain=CHAIN):
    """The follower along targets: code, points followed, postures, 1/k_F."""
    N, n = len(targets), len(state.q)
    reference = CELL.q_reference if reference is None else reference
    out, inv_kf = np.full((N, n), np.nan), np.full(N, np.nan)
    limits = np.broadcast_to(np.asarray(limit, float), (N, n)).copy()
    code, reached = follow_path(
        chain, settings, np.ascontiguousarray(targets), reference[None], state, limits, out, inv_kf
    )
    return code, reached, out, inv_kf


def five_axis_path(start: np.ndarray, count: int, step: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Poses (count, 4, 4): from the tool's pose in a posture, `step` (3,) m and `turn` (3,) rad on from point to point."""
    first = base_T_tool(CELL, start)
    path = np.tile(first, (count, 1, 1))
    for k in range(count):
        path[k, :3, 3] += (k + 1) * step
        path[k, :3, :3] = rotation_exp((k + 1) * turn) @ first[:3, :3]
    return path


def bilinear(surface: WeightSurface, q: np.ndarray) -> np.ndarray:
    """Weights (n,) by scipy's interpolation on the surface's grid, the border held beyond it."""
    nodes = [np.sort(n) for n in (surface.nodes0, surface.nodes1, surface.nodes2)]
    table, used = surface.table, [k for k in range(3) if len(nodes[k]) > 1]
    for k in range(2, -1, -1):
        if surface.step[k] < 0.0:
            table = np.flip(table, k)
        if k not in used:
            table = table.take(0, axis=k)
    place = [np.clip(q[surface.axis[k]], nodes[k][0], nodes[k][-1]) for k in used]
    return RegularGridInterpolator([nodes[k] for k in used], table)(place)[0]
