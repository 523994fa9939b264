"""How far a tool is off its path, counted by the way: of runs that are foretold and of logs alike."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.summaries.compensate_summary import OffPathSize
from camrob.units import m_to_mm

__all__ = ["OffWay", "off_path_size"]

Array = NDArray[np.float64]


class OffWay(NamedTuple):
    """At rows of a run that cut: how far the tool is off the path (K,), m; the way (K,) since the row before, m, by
    which that counts, as surface is made by the way and not by the time that it takes; and the motion (K,) that the row is of.
    """

    off: Array
    way: Array
    motion: NDArray[np.int64]

    def mean_square(self) -> float:
        """Of the distance, m2, over the way."""
        return float(np.average(self.off**2, weights=self.way)) if self.way.sum() > 0.0 else 0.0

    def within(self, share: float) -> float:
        """The distance, m, that is kept on a share of the way."""
        order = np.argsort(self.off)
        done = np.cumsum(self.way[order])
        return float(self.off[order][min(np.searchsorted(done, share * done[-1]), len(order) - 1)])

    def worst(self) -> float:
        """The largest distance, m."""
        return float(np.max(self.off))

    def by_motion(self, count: int) -> Array:
        """(count,) m rms over the way of each motion; 0 where none is told."""
        way = np.bincount(self.motion, weights=self.way, minlength=count)
        square = np.bincount(self.motion, weights=self.way * self.off**2, minlength=count)
        return np.asarray(np.sqrt(np.divide(square, way, out=np.zeros(count), where=way > 0.0)))


def off_path_size(found: OffWay) -> OffPathSize:
    """The figures of a run."""
    return OffPathSize(
        rms_mm=m_to_mm(float(np.sqrt(found.mean_square()))),
        p95_mm=m_to_mm(found.within(0.95)),
        max_mm=m_to_mm(found.worst()),
    )
