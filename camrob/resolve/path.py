"""The path that the tool travels, whole: regions placed in `base`, with the moves through air that camrob puts between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import digest, locked
from camrob.toolpath.region import Move

__all__ = ["TRANSIT", "ToolPathInBase"]

Array = NDArray[np.float64]

REPEATED = 2e-6  # m, rad: poses nearer to each other than this may be printed alike
TRANSIT = -1
"""The region index of points that camrob puts between regions."""


@dataclass(frozen=True, slots=True)
class ToolPathInBase:
    """Points in the order of travel.

    base_T_tip: (N, 4, 4), z the tool axis (tip to holder), x rotation-minimising along the path. move: (N,) `Move`,
    how the tool comes to the point. feed: (N,) m/s (NaN in air). line: (N,) CL line, 0 for camrob's own points. region:
    (N,) index, TRANSIT between regions. source: (N,) index of the point within its region, -1 for camrob's own. safe: (N,)
    True where the tool is clear of the part, so that a posture may be revised or a file be cut there.
    """

    base_T_tip: Array
    move: NDArray[np.int8]
    feed: Array
    line: NDArray[np.int64]
    region: NDArray[np.int32]
    source: NDArray[np.int64]
    safe: NDArray[np.bool_]

    def __post_init__(self) -> None:
        frames = locked(self.base_T_tip, shape=(None, 4, 4), name="base_T_tip")
        n = len(frames)
        object.__setattr__(self, "base_T_tip", frames)
        for name, dtype in (
            ("move", np.int8),
            ("feed", np.float64),
            ("line", np.int64),
            ("region", np.int32),
            ("source", np.int64),
            ("safe", np.bool_),
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
    def repeated(self) -> NDArray[np.bool_]:
        """(N,) True for points that a printed program can't tell from the last one that is kept (`REPEATED`, m and rad).

        Kind of move, region and feed are that one's too. A LIN that leads nowhere would stop the tool.
        """
        out = np.zeros(len(self), np.bool_)
        frames, feed = np.asarray(self.base_T_tip), np.nan_to_num(np.asarray(self.feed))
        for start in range(1, len(self), 50_000):
            here = slice(start, min(start + 50_000, len(self)))
            before = slice(here.start - 1, here.stop - 1)
            out[here] = np.abs(frames[here] - frames[before]).max(axis=(1, 2)) <= REPEATED
            out[here] &= (feed[here] == feed[before]) & (self.move[here] == self.move[before])
            out[here] &= self.region[here] == self.region[before]
        kept, last = -1, -1
        for i in np.flatnonzero(out).tolist():
            if last != i - 1:
                kept = i - 1
            last = i
            if np.abs(frames[i] - frames[kept]).max() > REPEATED:
                out[i], kept = False, i
        return out

    @property
    def entering(self) -> NDArray[np.bool_]:
        """(N,) True for camrob's own points that the tool comes to at a feed: the way back into a cut behind a retract."""
        return np.asarray((self.source < 0) & ~self.cutting & np.isfinite(self.feed))

    @property
    def length(self) -> Array:
        """(N,) length of the tip's path up to each point, m."""
        step = np.linalg.norm(np.diff(self.base_T_tip[:, :3, 3], axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(step)]) if len(self) else np.zeros(0)

    @property
    def digest(self) -> str:
        """What the path is."""
        return digest(self.base_T_tip, self.move, self.feed, self.line, self.region)
