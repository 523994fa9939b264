"""Where the tool is clear of a job's part, so that the robot may go any way that it likes from there: by axis values, between
postures that have nothing in common.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.path import ToolPathInBase
from camrob.units import mm_to_m

__all__ = ["ClearAir"]

Array = NDArray[np.float64]

_ABOVE, _ASIDE = mm_to_m(1.0), mm_to_m(10.0)  # from what is solid: along the axis, and all round
_ROUNDED = 1e-9  # m
_ALIKE = 5  # decimals of a unit vector
_BLOCK = 64  # axes that are looked along at once: bounds the memory


@dataclass(frozen=True, slots=True)
class ClearAir:
    """What a tool in the clear lies above or far from: points (K, 3) that the file passes in rapid, and points (L, 3) that it
    cuts or that are corners of bodies.
    """

    passed: Array
    solid: Array

    @classmethod
    def of(cls, path: ToolPathInBase, corners: Sequence[Array]) -> ClearAir:
        """Of a path and corners (L, 3) of bodies. Nothing has to lie above what it passes before the region of its first cut."""
        cut, tip = path.cutting, path.base_T_tip[:, :3, 3]
        begin = int(path.region[np.argmax(cut)]) if cut.any() else 0
        passed = path.of_toolpath & ~cut & (path.region >= begin)
        return cls(tip[passed], np.concatenate([tip[cut], *corners]))

    def holds(self, base_T_tip: Array) -> NDArray[np.bool_]:
        """(N,) True for poses (N, 4, 4) of the tool whose tip lies, seen along its own axis, no lower than all that the file
        passes and above all that is solid; or all of which is outside of the sphere round all of that.
        """
        tip, axis = base_T_tip[:, :3, 3], base_T_tip[:, :3, 2]
        out = np.ones(len(tip), np.bool_)
        if not len(tip) or not len(self.solid) + len(self.passed):
            return out
        kinds, which = np.unique(np.round(axis, _ALIKE), axis=0, return_inverse=True)
        which = which.ravel()
        out = np.sum(tip * axis, axis=1) >= self._tops(kinds)[which] - _ROUNDED
        low = np.flatnonzero(~out)
        if len(low):
            middle, radius = self._sphere()
            away = tip[low] - middle
            up = np.sum(away * axis[low], axis=1)
            far = np.linalg.norm(away, axis=1)
            aside = np.sqrt(np.maximum(far**2 - up**2, 0.0))
            out[low] = (aside >= radius) | ((up >= 0.0) & (far >= radius))
        return np.asarray(out)

    def _tops(self, axes: Array) -> Array:
        """(A,) m along each of the axes (A, 3) that everything lies below."""
        out = np.full(len(axes), -np.inf)
        for points, above in ((self.passed, 0.0), (self.solid, _ABOVE)):
            if len(points):
                for start in range(0, len(axes), _BLOCK):
                    here = slice(start, start + _BLOCK)
                    out[here] = np.maximum(out[here], (points @ axes[here].T).max(axis=0) + above)
        return out

    def _sphere(self) -> tuple[Array, float]:
        everything = np.concatenate([self.passed, self.solid])
        middle = 0.5 * (everything.min(axis=0) + everything.max(axis=0))
        return middle, float(np.linalg.norm(everything - middle, axis=1).max()) + _ASIDE
