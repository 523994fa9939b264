"""Where the published method begins: at HOME, and where the way on from HOME's posture leads nowhere, in another posture of the
first point, to which the axes go by PTP.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.errors import JobError, LimitError, SingularError, UnreachableError
from camrob.findings import Finding, Severity
from camrob.kinematics.arm import Arm
from camrob.kinematics.kernels import chain_arrays, inverse_kf_many
from camrob.product_grid import product_grid
from camrob.progress import Share
from camrob.redundancy.following.follower import FollowState
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.published.virtual_joint import PathFollower, followed_whole, resolve_vjm
from camrob.redundancy.published.weighting import Weighting
from camrob.redundancy.solution import Solution

__all__ = ["other_beginnings", "resolve_begun_elsewhere", "resolve_published"]

Array = NDArray[np.float64]

_ROLLS = 24  # of a turn
_EXTERNAL = 7  # values of each external axis, where HOME's own reach no posture
_MARGIN = 0.0873  # rad (5 degrees) from the arm's limits, where there are such postures
_APART = 0.5  # rad that an axis of two of them differs by at the least
_TRIED = 4  # postures: each takes as long as the method does up to where it fails
_FAR = 0.05  # of 1/k_F that a posture may be worse for each radian that it is nearer to HOME


def resolve_published(
    cell: Cell,
    path: ToolPathInBase,
    *,
    weighting: Weighting | None = None,
    revise: bool = True,
    further: Mapping[str, float] | None = None,
    progress: Share | None = None,
) -> Solution:
    """`resolve_vjm`, and where that fails, begun in other postures of the first point, the best-conditioned first; a finding
    says so. The way from HOME is no part of the path: PTP makes it.

    Raises the error of the path begun at HOME where all fail.
    """
    try:
        return resolve_vjm(cell, path, weighting=weighting, revise=revise, further=further, progress=progress)
    except (LimitError, SingularError, UnreachableError) as error:
        found = next(_begun_elsewhere(cell, path, weighting, revise, further, progress), None)
        if found is None:
            raise
        why = f"begun in another posture than the one that the way from HOME leads to: {error.what.partition(';')[0]}"
        begun = Finding("begun-elsewhere", why, Severity.INFO, error.line)
        return replace(found, findings=(begun, *found.findings))


def resolve_begun_elsewhere(
    cell: Cell,
    path: ToolPathInBase,
    *,
    obstacles: Callable[[ToolPathInBase, Solution], NDArray[np.bool_]] | None = None,
    progress: Share | None = None,
    **_: Any,
) -> Solution:
    """The published method begun in another posture than HOME leads to, the first that is followed and, by `obstacles`, touches
    nothing: for a path on which the arm, as it comes from HOME, touches something. Raises UnreachableError where there is none.
    """
    for solution in _begun_elsewhere(cell, path, None, True, None, progress):
        if obstacles is None or not obstacles(path, solution).any():
            return solution
    raise UnreachableError("the path is followed, free of collisions, from no other posture of its first point")


def _begun_elsewhere(
    cell: Cell,
    path: ToolPathInBase,
    weighting: Weighting | None,
    revise: bool,
    further: Mapping[str, float] | None,
    progress: Share | None,
) -> Iterator[Solution]:
    """The path followed from each of `other_beginnings` that leads to its end."""
    for q_begin in other_beginnings(cell, np.asarray(path.base_T_tip[0])):
        follower = _BegunAt(cell, path, q_begin, weighting, further)
        try:
            found = followed_whole(follower, revise=revise, progress=progress)
        except JobError:
            continue
        yield found


def other_beginnings(cell: Cell, base_T_tip: Array) -> Array:
    """Postures (K, n) of the tool at a pose, `_TRIED` at most and apart from each other, best 1/k_F first; near HOME counts too.

    External axes stand as at HOME, or where no posture reaches the pose so, at values spread over their ranges. None for an arm
    whose postures are only searched for.
    """
    arm = Arm.of(cell)
    if arm.searched:
        return np.empty((0, len(cell)))
    external = [i for i, j in enumerate(cell.joints) if j.role in (Role.WORKPIECE, Role.CARRIAGE)]
    home = np.asarray(cell.q_home)
    q = _postures(cell, arm, base_T_tip, external, home[None, external])
    if not len(q) and external:
        ends = (_spread(cell.joints[i].endless, cell.q_lower[i], cell.q_upper[i]) for i in external)
        q = _postures(cell, arm, base_T_tip, external, product_grid(list(ends)))
    if not len(q):
        return q
    part = q[:, cell.arm_slice]
    roomy = np.minimum(part - arm.lower, arm.upper - part).min(axis=1) >= _MARGIN
    q = q[roomy] if roomy.any() else q
    value = inverse_kf_many(chain_arrays(cell), q) - _FAR * np.abs(q - home)[:, cell.arm_slice].max(axis=1)
    chosen: list[Array] = []
    for k in np.argsort(-value, kind="stable"):
        if all(np.abs(q[k] - other)[cell.arm_slice].max() > _APART for other in chosen):
            chosen.append(q[k])
        if len(chosen) == _TRIED:
            break
    return np.array(chosen)


def _spread(endless: bool, lower: float, upper: float) -> Array:
    low, high = (-np.pi, np.pi) if endless else (lower, upper)
    return np.linspace(low, high, _EXTERNAL + 2)[1:-1]


def _postures(cell: Cell, arm: Arm, base_T_tip: Array, external: list[int], values: Array) -> Array:
    """Postures (K, n) within limits at a pose: external axes at rows of `values`, roll all round, every branch."""
    found = []
    rolls = cell.indices(Role.ROLL)
    home = np.asarray(cell.q_home)
    for row in values:
        for roll in np.linspace(-np.pi, np.pi, _ROLLS, endpoint=False) if rolls else (0.0,):
            q = home.copy()
            q[external] = row
            q[list(rolls)] = roll
            for branch in arm.branches(arm.foot_T_tool(base_T_tip, q), home[cell.arm_slice]):  # frames: tip is tool
                q[cell.arm_slice] = branch
                found.append(q.copy())
    return np.array(found).reshape(-1, len(cell))


class _BegunAt(PathFollower):
    """A follower whose path begins in a posture (n,) of its first point."""

    def __init__(
        self,
        cell: Cell,
        path: ToolPathInBase,
        q_begin: Array,
        weighting: Weighting | None,
        further: Mapping[str, float] | None,
    ) -> None:
        super().__init__(cell, path, weighting=weighting, further=further)
        self._begin = q_begin

    def home(self) -> FollowState:
        """The state in the posture that it begins in."""
        return self.at(self._begin)
