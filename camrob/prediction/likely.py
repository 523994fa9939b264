"""How large the error of a part is likely to be: machines are drawn from all that a diagnosis leaves open.

What is expected of each point is smaller than what will come: an error that nobody can foretell is expected to be 0. The 95 %
error of a whole part is therefore found on drawn machines, of which each has one value of all that may be wrong, and one smooth
field of what is unexplained, of a size of its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.prediction.band import field_sizes

__all__ = ["DRAWN_POINTS", "LikelySizes", "likely_distances", "likely_sizes"]

Array = NDArray[np.float64]

DRAWN_POINTS = 10_000
"""Points of the surface on which that is found: what they say of a percentile is right within a hundredth."""

_MACHINES = 400  # their middle one is then known within a twentieth of the spread
_SEED = 20  # any: the same files shall give the same figures
_SHARES = (2.5, 50.0, 97.5)  # percentiles of the machines


class LikelySizes(NamedTuple):
    """(3,) m each, of the machines' errors: what 2.5, 50 and 97.5 % of the machines stay below. rms: over the surface; p95:
    within which 95 % of it lie.
    """

    rms: Array
    p95: Array


def likely_sizes(deviation: Array, normal: Array, own: Array, together: Array, apart: Array) -> LikelySizes:
    """Sizes over P points of a surface. deviation: (P,) m, what is expected; normal: (P, 3) in any one frame; own: (P, K) m by
    which each of K things that may be wrong moves the point along it, a standard deviation of each; together: (P, L) m, how a
    smooth field of which nothing is known moves the point in any one direction, by L independent parts; apart: (P,) m, the
    standard deviation of what is another at each point. Zeros of no points.
    """
    if not len(deviation):
        return LikelySizes(np.zeros(3), np.zeros(3))
    rng = np.random.default_rng(_SEED)
    drawn = deviation[:, None] + own @ rng.standard_normal((own.shape[1], _MACHINES))
    size = field_sizes(rng, _MACHINES)
    for axis in range(3):
        drawn += normal[:, axis : axis + 1] * (together @ (size * rng.standard_normal((together.shape[1], _MACHINES))))
    drawn += apart[:, None] * rng.standard_normal(drawn.shape)
    return _sizes(np.abs(drawn))


def likely_distances(off: Array, way: Array, own: Array, together: Array, apart: Array) -> LikelySizes:
    """As `likely_sizes`, of how far a tool is off its way at P places. off: (P, 3) m, what is expected; way: (P, 3) unit vectors
    along it, which count nothing; own: (P, 3, K) m by which each of K things that may be wrong moves the tool.
    """
    if not len(off):
        return LikelySizes(np.zeros(3), np.zeros(3))
    rng = np.random.default_rng(_SEED)
    # two directions across the way
    first = np.cross(way, np.eye(3)[np.argmin(np.abs(way), axis=1)])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    square = np.zeros((len(off), _MACHINES))
    values = rng.standard_normal((own.shape[2], _MACHINES))
    fields = field_sizes(rng, _MACHINES) * rng.standard_normal((3, together.shape[1], _MACHINES))
    for across in (first, np.cross(way, first)):
        part = np.einsum("pi,pi->p", across, off)[:, None] + np.einsum("pi,pik->pk", across, own) @ values
        part += sum(across[:, [i]] * (together @ fields[i]) for i in range(3))
        square += (part + apart[:, None] * rng.standard_normal(part.shape)) ** 2
    return _sizes(np.sqrt(square))


def _sizes(drawn: Array) -> LikelySizes:
    """Of sizes (P, machines)."""
    rms = np.sqrt(np.mean(drawn**2, axis=0))
    p95 = np.quantile(drawn, 0.95, axis=0)
    return LikelySizes(np.percentile(rms, _SHARES), np.percentile(p95, _SHARES))
