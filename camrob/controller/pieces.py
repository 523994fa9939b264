"""A path cut into pieces that are smooth within, each divided into steps fine enough for posture and speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.compiled import kernel
from camrob.controller.interpolate import PTP, Pieces
from camrob.controller.layout import Layout
from camrob.controller.motion_settings import MotionSettings
from camrob.controller.speed_profile import Course

__all__ = ["course_of", "cut", "motion_ends"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

STEP_LENGTH = 0.005  # m, of the tip or a track, between nodes
STEP_ANGLE = 0.0175  # rad, of the tool or a table
STEP_ARC = 0.1  # rad, of a circle
STEP_TIME = 0.024  # s at the programmed speed
RAMP_TIME = 0.006  # s likewise, where the tool may speed up or slow down
_BLEND_STEPS = 4  # of a rounding, at the least
_RAMP_STEPS = 8  # of a ramp, at the most, but for what the geometry asks


def cut(cell: Cell, layout: Layout, settings: MotionSettings) -> Pieces:
    """The pieces of a path.

    A motion's own part is divided where a ramp from rest at the acceleration that tool and external axes allow reaches
    the programmed speed, so that a trapezoid of speed comes out exactly.
    """
    speed, push = _straight(cell, layout, settings)
    motions = layout.motions
    carried = np.abs(np.diff(motions.e, axis=0))
    fine = np.maximum(layout.length / STEP_LENGTH, layout.turn / STEP_ANGLE)
    fine = np.maximum(fine, np.abs(motions.angle) / STEP_ARC)
    for i in range(carried.shape[1]):
        fine = np.maximum(fine, carried[:, i] / (STEP_LENGTH if cell.joints[i].prismatic else STEP_ANGLE))
    fine = np.where(motions.kind == PTP, 0.0, fine) / motions.size
    most = 4 * len(motions.kind)
    motion, count = np.empty(most, np.int64), np.empty(most, np.int64)
    blend, start, length = np.empty(most), np.empty(most), np.empty(most)
    P = _cut(motions.size, np.asarray(layout.reach), speed, push, fine, motion, blend, start, length, count)
    first = np.concatenate([[0], np.cumsum(count[:P])[:-1]]) if P else np.zeros(0, np.int64)
    return Pieces(motion[:P].copy(), blend[:P].copy(), start[:P].copy(), length[:P].copy(), count[:P].copy(), first)


def _straight(cell: Cell, layout: Layout, settings: MotionSettings) -> tuple[Array, Array]:
    """Speed and acceleration along the path (M,) of each motion by itself, as far as they do not depend on the arm's posture."""
    motions, row = layout.motions, layout.row[1:]
    ptp = (motions.kind == PTP).astype(int)
    out = []
    for tool, turn, axes in (
        (settings.speed[row], settings.turn_speed, settings.axis_speed),
        (settings.acceleration[row], settings.turn_acceleration, settings.axis_acceleration),
    ):
        with np.errstate(divide="ignore", invalid="ignore"):
            least = np.minimum(tool / layout.length, turn / layout.turn)
            least = np.where(ptp == 1, np.inf, least)
            way = np.abs(np.diff(motions.q, axis=0))
            way[ptp == 0, motions.e.shape[1] :] = 0.0
            share = np.where(way > 0.0, axes[ptp] / way, np.inf)
        out.append(np.minimum(least, share.min(axis=1)) * motions.size)
    return out[0], out[1]


@kernel
def _cut(
    size: Array,
    reach: Array,
    speed: Array,
    push: Array,
    fine: Array,
    motion: Indices,
    blend: Array,
    start: Array,
    length: Array,
    count: Indices,
) -> int:
    """Fill the pieces' arrays; how many there are."""
    P = 0
    for m in range(size.shape[0]):
        begin = reach[m - 1] if m > 0 else 0.0
        whole = size[m] - begin - reach[m]
        if whole > 1e-9 * size[m]:
            ramp = min(0.5 * speed[m] * speed[m] / push[m], 0.5 * whole)
            flat = whole - 2.0 * ramp
            parts = 3 if flat > 1e-6 * whole else 2
            for part in range(parts):
                even = parts == 3 and part == 1
                length[P] = flat if even else (ramp if parts == 3 else 0.5 * whole)
                start[P] = begin
                begin += length[P]
                motion[P], blend[P] = m, 0.0
                seconds = length[P] / speed[m]
                steps = np.ceil(seconds / STEP_TIME) if even else min(np.ceil(seconds / RAMP_TIME), _RAMP_STEPS)
                count[P] = int(max(2, steps, np.ceil(fine[m] * length[P])))
                P += 1
        if reach[m] > 0.0:
            motion[P], blend[P], start[P], length[P] = m, reach[m], 0.0, 2.0 * reach[m]
            steps = np.ceil(reach[m] * (fine[m] + fine[m + 1]))
            seconds = reach[m] / speed[m] + reach[m] / speed[m + 1]
            count[P] = int(max(_BLEND_STEPS, steps, min(np.ceil(seconds / RAMP_TIME), 2 * _RAMP_STEPS)))
            P += 1
    return P


def course_of(layout: Layout, settings: MotionSettings, pieces: Pieces, q: Array, p: Array) -> Course:
    """What the speed passes need, of postures q (K, n) and tool positions p (K, 3) at the nodes."""
    motions, row = layout.motions, layout.row[1:]
    m, rounded = pieces.motion, pieces.blend > 0.0
    after = np.minimum(m + 1, len(motions.kind) - 1)
    ptp = motions.kind == PTP
    with np.errstate(divide="ignore", invalid="ignore"):
        cap = np.where(ptp | (layout.length == 0.0), np.inf, settings.speed[row] * motions.size / layout.length)
    push = np.where(ptp, np.inf, settings.acceleration[row])
    turn = np.where(ptp[:, None], 0.0, motions.w / motions.size[:, None])
    cap = np.where(rounded, np.minimum(cap[m], cap[after]), cap[m])
    push = np.where(rounded, np.minimum(push[m], push[after]), push[m])
    turn1 = np.where(rounded[:, None], turn[after], turn[m])
    stop, sharp = np.zeros(len(q), np.bool_), np.zeros(len(q), np.bool_)
    ends = motion_ends(layout, pieces)[0]
    stop[0] = True
    stop[ends[layout.stop[1:]]] = True
    sharp[ends[~layout.stop[1:] & (layout.reach == 0.0) & ~ptp]] = True
    return Course(
        pieces,
        q,
        p,
        cap,
        push,
        np.ascontiguousarray(turn[m]),
        np.ascontiguousarray(turn1),
        ptp[m].astype(np.int64),
        stop,
        sharp,
    )


def motion_ends(layout: Layout, pieces: Pieces) -> tuple[Indices, Indices]:
    """The node (M,) at which each motion, less its roundings, ends, and the piece (M,) that ends there."""
    M = len(layout.motions.kind)
    own = pieces.blend == 0.0
    piece = np.full(M, -1)
    np.maximum.at(piece, pieces.motion[own], np.flatnonzero(own))
    # a motion that its roundings leave nothing of ends with the rounding before it
    rounding = np.full(M + 1, -1)
    rounding[pieces.motion[~own] + 1] = np.flatnonzero(~own)
    piece = np.where(piece < 0, rounding[:M], piece)
    return (pieces.first + pieces.steps)[piece], piece
