"""The path that a program's text describes: motions, roundings of their corners, and pieces to walk along."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.controller.interpolate import ARC, LINE, PTP, Motions, lay_motions, nearest_to_corner
from camrob.controller.motion_settings import MotionSettings
from camrob.controller.replay import Replay, constant_transforms
from camrob.frozen import locked
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import seen_by_program, world_T_base
from camrob.kinematics.kernels import ChainArrays, chain_arrays
from camrob.program.motion import Blend, Motion
from camrob.program.program_text import ProgramText
from camrob.units import deg_to_rad

__all__ = ["Layout", "carrier_of", "lay_out"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

REACH = 0.02  # m of path that a radian (or, of a track, a metre) counts where the tip hardly moves
STILL = 1e-9  # m and rad: a motion that moves nothing by more is none
CORNER_TIME = 0.004  # s: the controller's finest cycle; what happens within it is not rounded further


@dataclass(frozen=True, slots=True)
class Layout:
    """M motions that move something, in the frame in which poses are programmed.

    row: (M + 1,) rows of the program that the ends belong to (the first: where the program begins). length, turn: (M,) m and
    rad of the tool. reach: (M,) how far the corner behind each motion is rounded off to both sides, in path; 0 where it
    isn't. stop: (M + 1,) True where the motion rests, as at both ends; wait: (M + 1,) s there. deviation: (M,) m that the
    rounding behind a motion keeps from its corner. in_world: True where poses are in `world`, else in `base`.
    """

    motions: Motions
    row: NDArray[np.int64]
    length: Array
    turn: Array
    reach: Array
    stop: Flags
    wait: Array
    deviation: Array
    in_world: bool

    def __post_init__(self) -> None:
        for name, dtype in (
            ("length", float),
            ("turn", float),
            ("reach", float),
            ("wait", float),
            ("deviation", float),
        ):
            object.__setattr__(self, name, locked(getattr(self, name), dtype=dtype, name=name))


def carrier_of(cell: Cell) -> tuple[ChainArrays, Array, Array] | None:
    """What `to_world` needs of the joints that carry the workpiece; None where there are none, and `base` is `world`."""
    workpiece = cell.indices(Role.WORKPIECE)
    if not workpiece:
        return None
    zero = np.array(cell.q_home)
    for i in workpiece:
        zero[i] = float(cell.joints[i].q_value(np.zeros(())))
    count = workpiece[-1] + 1
    return chain_arrays(cell)._replace(arm_start=count), constant_transforms(cell, count), zero


def lay_out(program: ProgramText, replay: Replay, settings: MotionSettings) -> Layout:
    """The path of a program that `replay` could follow to its end. Its first target is where the robot stands at the start.

    Raises ProgramError for a program that changes its tool.
    """
    cell = replay.one_tool(program)
    kind = np.asarray(program.kind)
    rows = np.flatnonzero(kind != Motion.CIRC_VIA)
    of_row = np.searchsorted(rows, np.arange(len(kind)))
    wait = np.bincount(of_row, weights=program.wait, minlength=len(rows))
    poses = seen_by_program(cell, np.asarray(replay.q), np.asarray(replay.base_T_tool))
    motions, length, turn = _motions(program, replay, poses, rows)
    moves = motions.size > STILL * REACH
    keep = np.concatenate([[True], moves])
    # what stands behind a motion that moves nothing happens at the end of the one before
    end = np.cumsum(keep) - 1
    waits = np.zeros(int(keep.sum()))
    np.add.at(waits, end[:-1], wait[1:])
    waits[0] += wait[0]
    waits[-1] += program.final_wait
    exact = np.asarray(program.blend)[rows[1:]] == Blend.EXACT
    halt = np.zeros(len(waits), np.bool_)
    halt[end[1:][exact & ~moves]] = True
    row = rows[keep]
    kept = _kept(motions, keep, moves)
    length, turn = length[moves], turn[moves]
    reach, stop = _corners(program, settings, kept, row, length, turn, halt | (waits > 0.0))
    deviation = nearest_to_corner(kept, reach)
    return Layout(kept, row, length, turn, reach, stop, waits, deviation, not cell.base_follows_table)


def _motions(
    program: ProgramText, replay: Replay, poses: Array, rows: NDArray[np.int64]
) -> tuple[Motions, Array, Array]:
    """All motions between the program's targets `rows`, with length and turn of the tool."""
    cell = replay.cell
    M, k = len(rows) - 1, cell.arm_slice.start
    kinds = np.asarray(program.kind)[rows[1:]]
    kind = np.full(M, PTP, np.int8)
    kind[kinds == Motion.LIN] = LINE
    kind[kinds == Motion.CIRC_END] = ARC
    q = np.asarray(replay.q)[rows]
    zeros = np.zeros((4, M, 3))
    motions = Motions(
        kind,
        np.ascontiguousarray(poses[rows, :3, :3]),
        np.ascontiguousarray(poses[rows, :3, 3]),
        np.ascontiguousarray(q[:, :k]),
        np.ascontiguousarray(q),
        zeros[0],
        zeros[1],
        zeros[2],
        zeros[3],
        np.zeros(M),
        np.zeros(M),
    )
    length, turn = np.zeros(M), np.zeros(M)
    via = np.ascontiguousarray(poses[np.maximum(rows[1:] - 1, 0), :3, 3])
    sweep = deg_to_rad(np.asarray(program.circular_angle_deg)[rows[1:]])
    lay_motions(motions, via, sweep, length, turn)
    external = np.abs(np.diff(motions.e, axis=0)).max(axis=1, initial=0.0)
    axes = np.abs(np.diff(motions.q, axis=0)).max(axis=1, initial=0.0)
    cp = np.maximum.reduce([length, REACH * turn, REACH * external])
    motions.size[:] = np.where(kind == PTP, REACH * axes, cp)
    _mend(cell, motions, sweep)
    return motions, length, turn


def _kept(motions: Motions, ends: Flags, own: Flags) -> Motions:
    """Some of the motions: what belongs to their ends, and what is their own."""
    m = motions
    return Motions(
        m.kind[own],
        m.R[ends],
        m.p[ends],
        m.e[ends],
        m.q[ends],
        m.w[own],
        m.center[own],
        m.u[own],
        m.v[own],
        m.angle[own],
        m.size[own],
    )


def _mend(cell: Cell, motions: Motions, sweep: Array) -> None:
    """The posture where a CIRC with CA ends and a PTP begins, which is not the one at its target."""
    ends = np.flatnonzero((motions.kind[:-1] == ARC) & ~np.isnan(sweep[:-1]) & (motions.kind[1:] == PTP))
    if not len(ends):
        return
    arm, part = Arm.of(cell), cell.arm_slice
    for m in ends:
        frame = np.eye(4)
        frame[:3, :3], frame[:3, 3] = motions.R[m + 1], motions.p[m + 1]
        q = motions.q[m + 1]
        if not cell.base_follows_table:
            frame = np.linalg.inv(np.asarray(world_T_base(cell, q))) @ frame
        found = arm.branches(arm.foot_T_tool(frame, q), q[part])
        if found:
            motions.q[m + 1, part] = min(found, key=lambda x: float(np.abs(x - q[part]).max()))
    axes = np.abs(np.diff(motions.q, axis=0)).max(axis=1)
    motions.size[motions.kind == PTP] = REACH * axes[motions.kind == PTP]


def _corners(
    program: ProgramText,
    settings: MotionSettings,
    motions: Motions,
    row: NDArray[np.int64],
    length: Array,
    turn: Array,
    halt: Flags,
) -> tuple[Array, Flags]:
    """How far each corner is rounded (M,), and where the motion rests (M + 1,)."""
    M = len(motions.kind)
    reach, stop = np.zeros(M), np.ones(M + 1, np.bool_)
    if M < 2 or settings.advance < 1:
        return reach, stop
    ends = row[1:-1]
    approximation = np.asarray(program.blend)[ends]
    cp = motions.kind != PTP
    through = ~halt[1:-1] & (approximation != Blend.EXACT) & (cp[:-1] == cp[1:])
    through &= (approximation == Blend.AXES) != cp[:-1]
    stop[1:-1] = ~through
    speed, push = settings.speed[row[1:]], settings.acceleration[row[1:]]
    with np.errstate(divide="ignore"):
        per_length, per_turn = motions.size / length, motions.size / turn
    half = 0.5 * np.minimum(motions.size[:-1], motions.size[1:])
    braking = 0.5 * speed**2 * (1.0 - settings.near_speed**2) / push
    distance = np.where(approximation == Blend.SPEED, braking[:-1], settings.distance[ends])
    per = np.minimum(per_length[:-1], per_length[1:])
    way = np.minimum(half, np.where(np.isfinite(per), distance * np.where(np.isfinite(per), per, 1.0), np.inf))
    per = np.minimum(per_turn[:-1], per_turn[1:])
    angle = np.where(np.isfinite(per), settings.near_angle * np.where(np.isfinite(per), per, 1.0), np.inf)
    way = np.where(approximation == Blend.TURN, np.minimum(half, angle), way)
    way = np.where(approximation == Blend.AXES, settings.near_ptp * half, way)
    # a rounding that is over within the finest cycle is none: its corner is passed at a point
    bend = np.linalg.norm(_leaving(motions, length)[1:] - _arriving(motions, length)[:-1], axis=1)
    slower, least = np.minimum(speed[:-1], speed[1:]), np.minimum(push[:-1], push[1:])
    at_point = np.minimum(slower, least * CORNER_TIME / np.maximum(bend, 1e-12))
    rounded = np.sqrt(2.0 * least * way / np.maximum(bend, 1e-12))
    way = np.where(cp[:-1] & (rounded < at_point), 0.0, way)
    reach[:-1] = np.where(through & (way > STILL), way, 0.0)
    return reach, stop


def _leaving(motions: Motions, length: Array) -> Array:
    """Direction (M, 3) of the tip at the beginning of each motion, per metre of its way."""
    return np.where((motions.kind == ARC)[:, None], _on_arc(motions, np.zeros_like(length)), _chord(motions, length))


def _arriving(motions: Motions, length: Array) -> Array:
    """Direction (M, 3) of the tip at the end of each motion, likewise."""
    return np.where((motions.kind == ARC)[:, None], _on_arc(motions, motions.angle), _chord(motions, length))


def _chord(motions: Motions, length: Array) -> Array:
    return np.asarray(np.diff(motions.p, axis=0) / np.where(length > 0.0, length, np.inf)[:, None])


def _on_arc(motions: Motions, angle: Array) -> Array:
    radius = np.maximum(np.linalg.norm(motions.u, axis=1), 1e-30)
    along = motions.v * np.cos(angle)[:, None] - motions.u * np.sin(angle)[:, None]
    return np.asarray(along * (np.sign(motions.angle) / radius)[:, None])
