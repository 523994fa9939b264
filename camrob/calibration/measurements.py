"""Measured poses for a calibration: postures and frames out of logs, checked against the cell."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from camrob.calibration.error_model import ErrorModel
from camrob.cell.cell import Cell
from camrob.errors import LogError
from camrob.frozen import locked
from camrob.measurement.log import ORIENTATION, MeasurementLog
from camrob.measurement.log_info import MeasuredFrame, Target
from camrob.measurement.log_units import check_turns
from camrob.measurement.sight import Sight, sighted
from camrob.se3 import pose
from camrob.units import deg_to_rad

__all__ = ["Measurements", "measurements_of", "postures_of", "sampled_rows", "withheld_rows"]

Array = NDArray[np.float64]

_SAME_POSTURE = deg_to_rad(0.05)  # and m / 1000: axes that differ by less stand where they stood
_FINER = 0.2  # of it, to which postures are rounded first


@dataclass(frozen=True, slots=True)
class Measurements:
    """N postures q (N, n) with measured target poses (N, 4, 4); without `oriented`, their rotations mean nothing.

    in_base: the poses are seen from the turning `base`. frame_known, target_known: whether the instrument's frame and
    the reflector are the cell's own, else they are fitted. sigma_position (m), sigma_angle (rad): noise an axis, NaN
    unknown. rows (N,): where in the log each one stood. left_out: rows of the log with empty cells. single: poses at
    rest. same_frame_as, same_target_as: the set whose instrument, whose reflector was this one's. sight: what alone was measured
    of positions, None for all. lines (N,): where in the log's file each one stands, 0 unknown.
    """

    q: Array
    frames: Array
    oriented: bool
    in_base: bool = False
    frame_known: bool = True
    target_known: bool = True
    sigma_position: float = math.nan
    sigma_angle: float = math.nan
    rows: NDArray[np.int64] | None = None
    left_out: int = 0
    single: bool = True
    name: str = ""
    digest: str = ""
    same_frame_as: str = ""
    same_target_as: str = ""
    sight: Sight | None = None
    lines: NDArray[np.int64] | None = None

    def __post_init__(self) -> None:
        q = locked(self.q, shape=(None, None), name="q")
        rows = np.arange(len(q)) if self.rows is None else self.rows
        lines = np.zeros(len(q), np.int64) if self.lines is None else self.lines
        object.__setattr__(self, "q", q)
        object.__setattr__(self, "frames", locked(self.frames, shape=(len(q), 4, 4), name="frames"))
        object.__setattr__(self, "rows", locked(rows, shape=(len(q),), dtype=np.int64, name="rows"))
        object.__setattr__(self, "lines", locked(lines, shape=(len(q),), dtype=np.int64, name="lines"))

    def __len__(self) -> int:
        return len(self.q)

    def select(self, index: NDArray[np.int64] | NDArray[np.bool_] | slice) -> Measurements:
        """Some of the poses."""
        rows, lines = np.asarray(self.rows)[index], np.asarray(self.lines)[index]
        sight = None if self.sight is None else self.sight.select(index)
        return replace(self, q=self.q[index], frames=self.frames[index], rows=rows, lines=lines, sight=sight)

    @property
    def share(self) -> float:
        """Coordinates of a position that a row tells, of three."""
        return 1.0 if self.sight is None else self.sight.share

    def told(
        self, moved: NDArray[np.float64], index: NDArray[np.int64] | NDArray[np.bool_] | slice
    ) -> NDArray[np.float64]:
        """How some of the poses move (N, 6, ..), with what was measured of positions alone."""
        return moved if self.sight is None else self.sight.select(index).of(moved)

    def without_orientation(self) -> Measurements:
        """The same poses, their positions alone."""
        return replace(self, oriented=False)


def measurements_of(log: MeasurementLog, cell: Cell) -> Measurements:
    """The poses of a log, rows with empty cells left out and counted; encoders where there are some, else set-points.

    Raises LogError where the log lacks the position or an axis of the cell, moves an axis that the cell lacks, or
    holds no whole row.
    """
    names = cell.axis_names
    strange = [n for n in log.axis_names if n not in names]
    for name in strange:
        values = log.columns.get(name, log.columns.get(f"c{name}", np.zeros(1)))
        if np.nanmax(values) - np.nanmin(values) > 1e-6:
            hint = f"give the cell of this log; {cell.name} has {', '.join(names)}"
            raise LogError(f"moves {name}, which cell {cell.name} lacks", hint=hint, path=log.path, line=1)
    reported = log.has(*names)
    if not reported and not log.has(*(f"c{n}" for n in names)):
        missing = next(n for n in names if not log.has(n))
        hint = f"the cell's axes are {', '.join(names)}"
        raise LogError(f"has no column {missing}", hint=hint, path=log.path, line=1)
    if not log.sees_place:
        hint = "give x, y, z, those of them that are measured, or distances d"
        raise LogError("holds no measured position", hint=hint, path=log.path, line=1)
    check_turns(log, cell.turning_names)
    axes = log.axes(names) if reported else log.setpoints(names)
    oriented = log.has_orientation and bool(log.complete(ORIENTATION).any())
    whole = log.complete(log.place_names) & ~np.isnan(axes).any(axis=1)
    if oriented:
        whole &= log.complete(ORIENTATION)
    if not whole.any():
        hint = "every row lacks a position or an axis value"
        raise LogError("holds no whole row", hint=hint, path=log.path)
    q, info = cell.to_q(axes[whole]), log.info
    in_base = info.measured_frame is MeasuredFrame.BASE
    sight = None
    if log.sees_part:
        nominal = ErrorModel.of(cell, (), in_base=in_base).poses(np.zeros(0), q)[:, :3, 3]
        sight = sighted(log.select(np.flatnonzero(whole)), nominal)
    position = np.asarray(sight.places) if sight else log.position[whole]
    rotation = log.rotation[whole] if oriented else np.eye(3)
    return Measurements(
        q=q,
        frames=pose(np.broadcast_to(rotation, (len(position), 3, 3)), position),
        oriented=oriented,
        in_base=in_base,
        frame_known=info.measured_frame is not MeasuredFrame.UNKNOWN,
        target_known=info.target is Target.TOOL,
        sigma_position=info.sigma_position,
        sigma_angle=info.sigma_angle,
        rows=np.flatnonzero(whole),
        left_out=int(len(log) - whole.sum()),
        single=info.poses,
        name=log.path.name if log.path else "",
        digest=log.digest,
        same_frame_as=info.same_frame_as,
        same_target_as=info.same_target_as,
        sight=sight,
        lines=None if log.file_lines is None else log.file_lines[whole],
    )


def sampled_rows(count: int, most: int) -> NDArray[np.int64]:
    """At most `most` of `count` rows, evenly spread."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.round(np.linspace(0, count - 1, most)).astype(np.int64))


def postures_of(data: Measurements) -> NDArray[np.int64]:
    """(N,) which posture each row is of, numbered from 0 in the order in which they come: one is measured again and again."""
    # rows that are all but one first: of a pose that was logged for minutes every pair would be near
    q, same = np.unique(np.round(data.q / (_FINER * _SAME_POSTURE)), axis=0, return_inverse=True)
    near = cKDTree(q).query_pairs(1.0 / _FINER, output_type="ndarray")
    links = coo_array((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=(len(q), len(q)))
    _, of_row = connected_components(links, directed=False)
    _, first, which = np.unique(of_row[same.reshape(-1)], return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[which].astype(np.int64))


def withheld_rows(data: Sequence[Measurements], share: float) -> list[NDArray[np.bool_]]:
    """Which rows take no part in fitting: of single poses a random share, all rows of a posture together; of paths whole
    blocks of a twentieth.
    """
    generator = np.random.default_rng(20120618)
    masks = []
    for part in data:
        if part.single:
            which = postures_of(part)
            count = int(which.max(initial=-1)) + 1
            masks.append((generator.permutation(count) < round(share * count))[which])
        else:
            block = np.arange(len(part)) * 20 // max(len(part), 1)
            masks.append(np.isin(block, generator.permutation(20)[: round(20 * share)]))
    return masks
