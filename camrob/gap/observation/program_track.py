"""Set-points held against the path of the program that was run, by place: written, and rounded off by the virtual controller."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from camrob.cell.cell import Cell
from camrob.compiled import kernel
from camrob.controller.programmed_path import ProgrammedPath, programmed_path
from camrob.controller.replay import Replay, program_cell, replay
from camrob.gap.observation.scene import Scene
from camrob.kinematics.frames import base_T_tool, world_T_base
from camrob.measurement.log_info import MeasuredFrame
from camrob.program.program_text import ProgramText
from camrob.units import m_to_mm, mm_to_m

__all__ = ["ProgramTrack", "motions_of_lines", "nearest_on_path", "track_of"]

Array = NDArray[np.float64]

_AROUND = 3  # motions to each side of the reported one that a sample may lie on
_STRANGE = mm_to_m(25.0)  # farther off the path than any rounding: another program was run


@dataclass(frozen=True)
class ProgramTrack:
    """One log's set-points and its program. base_p, world_p: (N, 3) m where the set-points put the tool, with the program's
    tool; turn: (N, 3, 3) base into world; motion: (N,) place of each sample in the program's order, -1 where the log says
    none.
    """

    scene: Scene
    program: ProgramText
    replayed: Replay
    base_p: Array
    world_p: Array
    turn: Array
    motion: NDArray[np.int64]

    def path(self, distance: float | None = None) -> ProgrammedPath:
        """The program's path: see `programmed_path`."""
        return programmed_path(self.program, self.replayed, distance=distance)

    def at(self, rows: NDArray[np.int64]) -> ProgramTrack:
        """Some of the samples."""
        return replace(
            self, base_p=self.base_p[rows], world_p=self.world_p[rows], turn=self.turn[rows], motion=self.motion[rows]
        )

    def places(self, path: ProgrammedPath) -> tuple[NDArray[np.int64], Array]:
        """Where on a path without roundings the set-points are: (N,) rows of the program that they move to, (N,) shares done."""
        segment, share = nearest_on_path(self.led(path), path, self.motion)[1:]
        motion = np.asarray(path.motion)
        if len(motion) < 2:
            return segment, share
        owner = motion[1:][segment]
        # nodes of one motion lie evenly, the first at its beginning
        begin = np.searchsorted(motion, owner, side="left")
        count = np.maximum(np.searchsorted(motion, owner, side="right") - begin - 1, 1)
        return owner, np.asarray(np.clip((segment - begin + share) / count, 0.0, 1.0))

    def led(self, path: ProgrammedPath) -> Array:
        """(N, 3) m, the tool by the set-points in the frame in which the path's poses are programmed."""
        return self.world_p if path.in_world else self.base_p

    def offset(self, path: ProgrammedPath) -> Array:
        """(N, 3) m from the nearest place of a path to the set-points, in the measured frame."""
        actual = self.led(path)
        off = actual - nearest_on_path(actual, path, self.motion)[0]
        in_base = self.scene.log.info.measured_frame is MeasuredFrame.BASE
        if path.in_world and in_base:
            off = np.einsum("nji,nj->ni", self.turn, off)
        elif not path.in_world and not in_base:
            off = np.einsum("nij,nj->ni", self.turn, off)
        return np.asarray(off @ self.scene.frames.left[:3, :3].T)


def track_of(scene: Scene, program: ProgramText) -> ProgramTrack:
    """Lay a log's set-points beside its program.

    Raises LogError where they lie centimetres off its path: then another program was run. Raises UnreachableError and
    ProgramError for a program that the cell can't follow.
    """
    cell: Cell = program_cell(program, scene.cell)[0]
    replayed = replay(program, scene.cell)
    q = cell.to_q(scene.log.setpoints(scene.axes))
    in_base = base_T_tool(cell, q)
    frames = world_T_base(cell, q)
    motion = np.full(len(scene), -1, np.int64)
    if scene.log.has("line"):
        motion = motions_of_lines(program, scene.log.line)
    world = frames @ in_base
    found = ProgramTrack(
        scene, program, replayed, in_base[:, :3, 3], world[:, :3, 3], np.asarray(frames[:, :3, :3]), motion
    )
    off = np.linalg.norm(found.offset(found.path(0.0)), axis=1)
    size = float(np.median(off))
    if size > _STRANGE:
        what = f"its set-points lie {m_to_mm(size):.0f} mm off the path of {program.name} (median)"
        raise scene.log.error(
            what, hint="give the program that was run, with --program", at=int(np.argmax(off >= size))
        )
    return found


def motions_of_lines(program: ProgramText, line: NDArray[np.int64]) -> NDArray[np.int64]:
    """(N,) the first row of the program at each line that a log tells (N,), or at the next line with one."""
    lines = np.asarray(program.line)
    order = np.argsort(lines, kind="stable")
    return np.asarray(order[np.clip(np.searchsorted(lines[order], line), 0, len(order) - 1)])


def nearest_on_path(
    actual: Array, path: ProgrammedPath, motion: NDArray[np.int64]
) -> tuple[Array, NDArray[np.int64], Array]:
    """(N, 3) nearest places on the path to points (N, 3), looked for around each sample's motion; (N,) the node before each,
    and (N,) the share of the way to the next.

    motion: (N,) rows of the program, the first of them negative where nobody tells.
    """
    nodes = np.asarray(path.points)
    if len(nodes) < 2:
        return np.tile(nodes[0], (len(actual), 1)), np.zeros(len(actual), np.int64), np.zeros(len(actual))
    start, end = nodes[:-1], nodes[1:]
    owner = np.asarray(path.motion)[1:]
    if motion[0] < 0:
        motion = _guessed(actual, start, end, owner)
    ranks = np.unique(owner)
    rank = np.clip(np.searchsorted(ranks, motion), 0, len(ranks) - 1)
    first = np.searchsorted(owner, ranks[np.maximum(rank - _AROUND, 0)], side="left")
    last = np.searchsorted(owner, ranks[np.minimum(rank + _AROUND, len(ranks) - 1)], side="right")
    # copies: frozen arrays would be compiled for separately
    place, segment, share = _among(np.array(actual), np.array(nodes), first, last)
    return place, segment, share


@kernel
def _among(
    actual: Array, nodes: Array, first: NDArray[np.int64], last: NDArray[np.int64]
) -> tuple[Array, NDArray[np.int64], Array]:
    """`nearest_on_path` among the stretches first (N,) to last (N,), the latter left out, between nodes (M, 3)."""
    N = actual.shape[0]
    place, segment, share = actual.copy(), np.zeros(N, np.int64), np.zeros(N)
    for row in range(N):
        best = np.inf
        x, y, z = actual[row, 0], actual[row, 1], actual[row, 2]
        for k in range(first[row], last[row]):
            u, v, w = nodes[k + 1, 0] - nodes[k, 0], nodes[k + 1, 1] - nodes[k, 1], nodes[k + 1, 2] - nodes[k, 2]
            way = (x - nodes[k, 0]) * u + (y - nodes[k, 1]) * v + (z - nodes[k, 2]) * w
            way = min(max(way / max(u * u + v * v + w * w, 1e-18), 0.0), 1.0)
            p, q, r = nodes[k, 0] + way * u, nodes[k, 1] + way * v, nodes[k, 2] + way * w
            off = (x - p) ** 2 + (y - q) ** 2 + (z - r) ** 2
            if off < best:
                best, segment[row], share[row] = off, k, way
                place[row, 0], place[row, 1], place[row, 2] = p, q, r
    return place, segment, share


def _guessed(actual: Array, start: Array, end: Array, owner: NDArray[np.int64]) -> NDArray[np.int64]:
    """(N,) the motions that points are nearest to, where the log does not say."""
    length = np.linalg.norm(end - start, axis=1)
    step = max(float(length.sum()) / 20_000, 1e-4)
    count = np.maximum(np.ceil(length / step), 1).astype(np.int64)
    segment = np.repeat(np.arange(len(start)), count)
    share = (np.arange(len(segment)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[segment]
    dense = start[segment] + share[:, None] * (end - start)[segment]
    return np.asarray(owner[segment[cKDTree(dense).query(actual)[1]]])
