"""What a plan has to know of a machine's errors, in plain numbers: whoever has diagnosed it fills this in.

Nothing here knows of diagnoses, calibrations or files; `jobs` reads them and hands this to the planner.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "ARM_AXES",
    "PLACES",
    "CutNormals",
    "ForceOfCut",
    "LeftSurface",
    "NoForce",
    "PostureErrors",
    "ToolForce",
    "UnexplainedRest",
]

Array = NDArray[np.float64]

ARM_AXES = 6
"""Axes of the arms that are planned for."""
PLACES = ARM_AXES + 2
"""Frames of the chain that may stand off: the floor's, the arm's axes', the tool's."""


class ToolForce(Protocol):
    """The force on the tool while it cuts."""

    def mean(self, feed: Array, area: Array | None = None) -> Array:
        """(N, 3) N on the tool along the feed, across it (to its left, seen from the holder) and along the tool to the holder, at
        feeds (N,) in m/s; area: (N,) m2 that is cut across the feed there, None where nobody knows.
        """
        ...


class NoForce:
    """A tool that nothing pushes."""

    def mean(self, feed: Array, area: Array | None = None) -> Array:
        """(N, 3) zeros."""
        return np.zeros((len(feed), 3))


@dataclass(frozen=True)
class ForceOfCut:
    """A force at N places of a path at which area (N,) m2 is cut across the feed."""

    force: ToolForce
    area: Array

    def mean(self, feed: Array, area: Array | None = None) -> Array:
        """See `ToolForce`; what is cut is known."""
        return self.force.mean(feed, self.area)


@dataclass(frozen=True)
class LeftSurface:
    """P points of the surface that a path leaves when all of it is cut. move: (P,) index of the path's point at which the move
    that left each of them ends; at: (P,) which share of that move; normal: (P, 3) unit vectors in `base`; area: (P,) m2.
    taken: (N,) m2 that is cut across the way to each of the path's points.
    """

    move: NDArray[np.int64]
    at: Array
    normal: Array
    area: Array
    taken: Array


class CutNormals(Protocol):
    """The surface that a path leaves on the part."""

    def left(self, base_T_tip: Array, cutting: NDArray[np.bool_]) -> LeftSurface | None:
        """Of a path through frames (N, 4, 4), cutting (N,) on the way to each; None where it leaves none."""
        ...


@dataclass(frozen=True)
class UnexplainedRest:
    """A smooth error over posture that is known at M postures and grows with the way to them (a Gaussian process).

    postures: (M, E + 6), of the external axes and the arm in the chain's q; per: (E + 6,) what a unit of each is multiplied by, 0
    of axes that it doesn't follow; turns: (E + 6,) True of tables, which turn what is measured. Its kernel, of squared
    exponentials of `length` and of a half and a quarter of it, is summed over axes and pairs of them; variance: m2 of it, same:
    m2 of a constant beside it. values: (M, 3) m, the error expected at the postures, cov: (M, M) m2, how far it may be off there
    in each direction; own: (M, M) m2, the kernel among them. by_root: (M, 3, K) m by how much less the error is in each of the K
    directions of `PostureErrors.root`. in_base: values and by_root are seen from `base`, else from `world`.
    """

    postures: Array
    per: Array
    turns: NDArray[np.bool_]
    length: float
    variance: float
    same: float
    values: Array
    cov: Array
    own: Array
    by_root: Array
    in_base: bool


@dataclass(frozen=True)
class PostureErrors:
    """By how much the arm's axes err, and what pushes on its tool; the axes' values are those of the chain's q.

    compliance: (6,) rad/Nm under the force. sagging: (6,) rad/Nm under gravity, 0 of axes whose sag nobody found or is
    corrected elsewhere. shift: (6,) rad that each axis stands beyond its encoder. swing: (6,) rad, rms, of what has a sign or a
    phase that nobody knows beforehand (friction, a ripple). mark: (6,) rad by which each axis's link jumps where the axis
    turns round. couples: (M, 2) and coupling: (M,) rad a rad, by how much more an axis is shifted the farther another, or it,
    stands. places: (PLACES, 6), m and rad, by which the frames of the chain stand off, in their own axes: of the floor, of each
    axis before it turns, and of the tool; or none. root: (12 + M + 6 PLACES, K), compliance (rad/Nm) over shift (rad),
    coupling and places: root @ root.T is the covariance of all. tip: (2,) m/N
    that tool and holder give across and along the tool.

    granted: (6,) rad/Nm, the standard deviation of a compliance that nobody measured: under the force, as what gravity does was
    measured with all that is unexplained. force: what pushes while cutting; doubt: share of it by which it may be wrong;
    any_force: N, the standard deviation in each direction of a force of which nothing else is known. rest: m, the standard
    deviation in any one direction of what nobody has explained, alike in all postures; unexplained: of what is not alike, None
    where nobody knows where. corrected: the program is compensated afterwards with all that is known here, so that only what is
    doubtful stays. normals: the surface that counts; None where the cutter's shape is not known, and all that lies across the
    feed counts. counted, left_out: what the numbers hold, and what is known and not in them, in words.
    """

    compliance: Array
    sagging: Array
    shift: Array
    swing: Array
    mark: Array
    root: Array
    tip: Array
    force: ToolForce = field(default_factory=NoForce)
    granted: Array = field(default_factory=lambda: np.zeros(ARM_AXES))
    doubt: float = 0.0
    any_force: float = 0.0
    couples: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    coupling: Array = field(default_factory=lambda: np.zeros(0))
    places: Array = field(default_factory=lambda: np.zeros((0, 6)))
    rest: float = 0.0
    unexplained: UnexplainedRest | None = None
    corrected: bool = False
    normals: CutNormals | None = None
    counted: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
