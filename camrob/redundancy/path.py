"""The path that the tool travels, whole: regions placed in `base`, with the moves through air that camrob puts between."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import digest, locked
from camrob.runs import runs_of
from camrob.toolpath.region import Move

__all__ = ["REPEATED", "SHORT_RETRACT", "TRANSIT", "ToolPathInBase", "joined_paths"]

Array = NDArray[np.float64]

REPEATED = 2e-6  # m, rad: poses nearer to each other than this may be printed alike, and are one point of a path
SHORT_RETRACT = 0.01  # m: so far the arm goes along the tool's axis by itself; a track is slower than that is worth
TRANSIT = -1
"""The region index of points that camrob puts between regions."""


@dataclass(frozen=True, slots=True)
class ToolPathInBase:
    """Points in the order of travel.

    base_T_tip: (N, 4, 4), z the tool axis (tip to holder), x rotation-minimising along the path. move: (N,) `Move`,
    how the tool comes to the point. feed: (N,) m/s (NaN in air). line: (N,) CL line, 0 for camrob's own points. region:
    (N,) index, TRANSIT between regions. source: (N,) index of the point within its region, -1 for camrob's own. safe: (N,)
    True where the tool is clear of the part, so that a posture may be revised or a file be cut there. stretch: (N,) how often
    the tool has been changed before the point (left out: never); at a change the tool leaves the path, and the next stretch
    begins where the change has taken it to. clear: (N,) True for safe points that are so high that the robot may leave them by
    axis values, the tool swung any way (left out: all of them).
    """

    base_T_tip: Array
    move: NDArray[np.int8]
    feed: Array
    line: NDArray[np.int64]
    region: NDArray[np.int32]
    source: NDArray[np.int64]
    safe: NDArray[np.bool_]
    stretch: NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, np.int32))
    clear: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, np.bool_))

    def __post_init__(self) -> None:
        frames = locked(self.base_T_tip, shape=(None, 4, 4), name="base_T_tip")
        n = len(frames)
        object.__setattr__(self, "base_T_tip", frames)
        if not len(self.stretch):
            object.__setattr__(self, "stretch", np.zeros(n, np.int32))
        if not len(self.clear):
            object.__setattr__(self, "clear", self.safe)
        for name, dtype in (
            ("move", np.int8),
            ("feed", np.float64),
            ("line", np.int64),
            ("region", np.int32),
            ("source", np.int64),
            ("safe", np.bool_),
            ("stretch", np.int32),
            ("clear", np.bool_),
        ):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(n,), dtype=dtype, name=name))

    def __len__(self) -> int:
        return len(self.base_T_tip)

    @property
    def of_toolpath(self) -> NDArray[np.bool_]:
        """(N,) True for the CL file's own points."""
        return np.asarray(self.source >= 0)

    @property
    def cutting(self) -> NDArray[np.bool_]:
        """(N,) True for points that the tool comes to at the programmed feed."""
        return np.asarray(self.move == int(Move.CUT))

    @property
    def entering(self) -> NDArray[np.bool_]:
        """(N,) True for camrob's own points that the tool comes to at a feed: the way back into a cut behind a retract."""
        return np.asarray((self.source < 0) & ~self.cutting & np.isfinite(self.feed))

    def commanded_speed(self, rapid_speed: float) -> Array:
        """(N,) m/s that a program commands on the way to each point: the feed, and `rapid_speed` through air."""
        return np.where(self.cutting | self.entering, self.feed, rapid_speed)

    @property
    def along_axis(self) -> NDArray[np.bool_]:
        """(N,) True for points that the tool comes to along its own axis, by a short way or back and forth: holes and retracts.

        No external axis has anything to do on such a way: the arm goes it alone.
        """
        if len(self) < 2:
            return np.zeros(len(self), np.bool_)
        axis, step = self.base_T_tip[:, :3, 2], np.diff(self.base_T_tip[:, :3, 3], axis=0)
        depth = np.einsum("ij,ij->i", step, axis[1:])
        aside = np.linalg.norm(step - depth[:, None] * axis[1:], axis=1)
        turned = np.linalg.norm(np.diff(axis, axis=0), axis=1)
        joined = (np.diff(self.region) == 0) & (self.region[1:] != TRANSIT) & (np.diff(self.stretch) == 0)
        straight = joined & (aside < REPEATED) & (turned < REPEATED)
        held = straight & (np.abs(depth) <= SHORT_RETRACT)
        # a stretch of such steps that goes back on itself is a hole, however deep
        number = np.cumsum(np.append(True, ~straight[1:] | ~straight[:-1]))
        back = np.flatnonzero(straight[1:] & straight[:-1] & (depth[1:] * depth[:-1] < 0.0))
        held |= straight & np.isin(number, number[back])
        return np.append(False, held)

    @property
    def length(self) -> Array:
        """(N,) length of the tip's path up to each point, m."""
        step = np.linalg.norm(np.diff(self.base_T_tip[:, :3, 3], axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(step)]) if len(self) else np.zeros(0)

    @property
    def step(self) -> Array:
        """(N,) m of the tip's way from the point before to each point; 0 at the first."""
        return np.diff(self.length, prepend=0.0)

    @property
    def cut(self) -> Array:
        """(N,) m of that way which is cut: the steps of `cutting`, 0 elsewhere."""
        return np.asarray(self.step * self.cutting)

    @property
    def weight(self) -> Array:
        """(N,) what each point counts in a mean over the path: `cut`, or 1 each where nothing is cut."""
        cut = self.cut
        return cut if np.any(cut > 0.0) else np.ones(len(self))

    @property
    def digest(self) -> str:
        """What the path is."""
        return digest(self.base_T_tip, self.move, self.feed, self.line, self.region)

    @property
    def stretches(self) -> tuple[slice, ...]:
        """Where the stretches between tool changes lie."""
        return runs_of(self.stretch)

    def part(self, where: slice | NDArray[np.bool_]) -> ToolPathInBase:
        """Some of the points."""
        return ToolPathInBase(**{f.name: np.asarray(getattr(self, f.name))[where] for f in fields(self)})


def joined_paths(paths: Sequence[ToolPathInBase]) -> ToolPathInBase:
    """One path after the other."""
    names = [f.name for f in fields(ToolPathInBase)]
    return ToolPathInBase(**{n: np.concatenate([np.asarray(getattr(p, n)) for p in paths]) for n in names})
