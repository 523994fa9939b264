"""The published method over a whole program: the virtual-joint follower, region by region, with posture revision."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.compiled import kernel
from camrob.errors import JobError
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.kernels import chain_arrays
from camrob.progress import Share
from camrob.redundancy.following.failure import explain_failure
from camrob.redundancy.following.follower import FOLLOWED, FollowerSettings, FollowState, follow_path
from camrob.redundancy.free_frames import refine, rotation_minimising
from camrob.redundancy.path import TRANSIT, ToolPathInBase
from camrob.redundancy.published.kept_and_moved import kept_revisions, moved_in_holes
from camrob.redundancy.published.own_limits import held_joints, own_limits
from camrob.redundancy.published.revision import GAIN, revise_posture
from camrob.redundancy.published.weighting import Weighting, engine_weighting
from camrob.redundancy.solution import Revision, Solution
from camrob.runs import runs_of
from camrob.se3 import pose

__all__ = ["Attempt", "Failure", "PathFollower", "followed_whole", "postures_along", "resolve_vjm"]

Array = NDArray[np.float64]

STEP = 0.02  # m between points that the follower solves; farther neighbours get others between
ANGLE = 0.05  # rad, likewise
AIR_SPEED = 0.2  # m/s taken for the tool in air where self-motion is bounded by the axes' speeds
SELF_RATIO = 4.0  # of a joint's self-motion to the tool's motion (angles, and lengths by the characteristic length)
SPEED_SHARE = 0.5  # of an axis's speed that self-motion may use up


def resolve_vjm(
    cell: Cell,
    path: ToolPathInBase,
    *,
    weighting: Weighting | None = None,
    revise: bool = True,
    further: Mapping[str, float] | None = None,
    progress: Share | None = None,
) -> Solution:
    """Postures along a path by the published method (eq. 12, 15 to 20; section 3.2), starting at HOME.

    `weighting` stands in for the cell's engines, `revise` False leaves the posture alone between regions (for comparison). A
    revision is kept only if the region, tried to its end both ways, does not have a lower minimum of 1/k_F with it, and gains
    something (`revision.GAIN`) in that or in the mean. After a revision the external axes are held where it left them: the
    reference posture is the arm's. further: by joint, rad and m that it keeps from its limits, where it passed them between two
    points.
    Raises UnreachableError, LimitError or SingularError with line, region, axis and distance.
    """
    follower = PathFollower(cell, path, weighting=weighting, further=further)
    return followed_whole(follower, revise=revise, progress=progress)


def followed_whole(follower: PathFollower, *, revise: bool = True, progress: Share | None = None) -> Solution:
    """`resolve_vjm` with a follower of one's own, from where that one begins."""
    cell, path = follower.cell, follower.path
    q, inv_kf, revisions = postures_along(follower, revise=revise, progress=progress)
    findings = (*kept_revisions(revisions, path), *moved_in_holes(cell, path, q))
    return Solution("vjm", q, inv_kf, cell.digest, path.digest, tuple(revisions), findings)


def postures_along(
    follower: PathFollower, *, revise: bool = True, progress: Share | None = None
) -> tuple[Array, Array, list[Revision]]:
    """What `followed_whole` makes a solution of: postures (N, n), 1/k_F (N,), and revisions."""
    cell, path = follower.cell, follower.path
    blocks = _blocks(path)
    state = follower.home()
    reference = cell.q_reference.copy()
    q, inv_kf = np.empty((len(path), len(cell))), np.empty(len(path))
    revisions: list[Revision] = []
    for block in blocks:
        travel = follower.follow(state, reference, block.start, block.at + 1)
        if block.region == TRANSIT:
            attempt, revision = travel, None
        else:
            attempt, reference, revision = _work(follower, block, travel, reference, revise)
            revisions.append(revision)
        q[block.start : block.stop], inv_kf[block.start : block.stop] = attempt.q, attempt.inv_kf
        state = attempt.state
        if progress is not None:
            progress(block.stop / len(path))
    return q, inv_kf, revisions


@dataclass(frozen=True, slots=True)
class _Block:
    """A region with the moves through air before it: path points start .. stop, the posture may be revised at point `at`."""

    region: int
    start: int
    at: int
    stop: int


@dataclass(frozen=True, slots=True)
class Failure:
    """A path point that could not be followed: the pose that the follower stopped short of, why, and its posture there."""

    point: int
    base_T_target: Array
    code: int
    state: FollowState


@dataclass(frozen=True, slots=True)
class Attempt:
    """Postures (N, n) and 1/k_F (N,) along a piece of path, and the state at its end; `failure` where it wasn't reached."""

    q: Array
    inv_kf: Array
    state: FollowState
    failure: Failure | None = None


def _blocks(path: ToolPathInBase) -> list[_Block]:
    """The path cut into blocks of moves through air and the region that they lead to; the last may be air only."""
    blocks: list[_Block] = []
    changes = np.flatnonzero(np.diff(path.region)) + 1
    starts = [0, *changes.tolist()]
    stops = [*changes.tolist(), len(path)]
    air_start: int | None = None
    for start, stop in zip(starts, stops, strict=True):
        region = int(path.region[start])
        if region == TRANSIT:
            air_start = start
            continue
        first = start if air_start is None else air_start
        blocks.append(_Block(region, first, start if air_start is None else start - 1, stop))
        air_start = None
    if air_start is not None:
        blocks.append(_Block(TRANSIT, air_start, len(path) - 1, len(path)))
    return blocks


def _work(
    follower: PathFollower, block: _Block, travel: Attempt, reference: Array, revise: bool
) -> tuple[Attempt, Array, Revision]:
    """Work a region as the travel brings the posture, and from a revised posture; the better of both, and its reference."""
    cell, path = follower.cell, follower.path
    way = block.at + 1, block.stop
    safe = path.safe[block.at]
    moves = revise_posture(cell, follower.chain, follower.arm, travel.q[-1]) if revise and safe else None
    with ThreadPoolExecutor(1) as pool:  # both ways at once: the follower lets other threads run
        other = None if moves is None or len(moves) == 1 else pool.submit(_revised, follower, moves, reference, way)
        plain = follower.follow(travel.state, reference, *way, tolerant=True)
    first = 0 if path.region[block.at] == TRANSIT else -1  # the region's first point within `plain`
    before = float(plain.inv_kf[first]) if first == 0 and len(plain.inv_kf) else float(travel.inv_kf[-1])
    none = Revision(block.region, block.at, np.empty((0, len(cell))), False, before, before)
    chosen, revision = plain, none
    if moves is None and plain.failure is not None and safe:
        moves = revise_posture(cell, follower.chain, follower.arm, travel.q[-1])
    if moves is not None:
        if len(moves) == 1:
            revision = replace(none, reason="the posture is the best within reach of the external axes")
        else:
            revised, revised_reference = _revised(follower, moves, reference, way) if other is None else other.result()
            if revised.failure is None and (plain.failure is not None or _worth_it(revised, plain)):
                after = float(revised.inv_kf[first]) if first == 0 else float(follower.inv_kf(moves[-1]))
                chosen, reference = revised, revised_reference
                travel = replace(travel, q=np.vstack([travel.q[:-1], moves[-1]]), inv_kf=np.append(
                    travel.inv_kf[:-1], follower.inv_kf(moves[-1])))  # fmt: skip
                revision = Revision(block.region, block.at, moves, True, before, after)
            else:
                revision = replace(none, reason="1/k_F along the region would fall at its lowest, or hardly rise")
    if chosen.failure is not None and path.safe[block.at]:
        chosen, reference, travel, revision = _other_turns(follower, block, travel, reference, chosen, revision)
    if chosen.failure is not None:
        raise follower.explain(chosen.failure)
    whole = Attempt(np.vstack([travel.q, chosen.q]), np.append(travel.inv_kf, chosen.inv_kf), chosen.state)
    return whole, reference, revision


def _revised(follower: PathFollower, moves: Array, reference: Array, way: tuple[int, int]) -> tuple[Attempt, Array]:
    """A region worked from the posture that the revision ends in, with the external axes held about there; the reference too."""
    cell = follower.cell
    external = [*cell.indices(Role.WORKPIECE), *cell.indices(Role.CARRIAGE)]
    held = reference.copy()
    held[external] = moves[-1, external]
    return follower.follow(follower.at(moves[-1]), held, *way, tolerant=True), held


def _other_turns(
    follower: PathFollower, block: _Block, travel: Attempt, reference: Array, failed: Attempt, revision: Revision
) -> tuple[Attempt, Array, Attempt, Revision]:
    """Try a region that failed on other whole turns of the arm's axes, unwound by PTP before it; the first that does it.

    Where none does, the failed attempt comes back.
    """
    cell = follower.cell
    many_turns = [
        i for i in range(*cell.arm_slice.indices(len(cell))) if cell.q_upper[i] - cell.q_lower[i] > 2.0 * np.pi
    ]
    for turns in sorted(product((0, 1, -1), repeat=len(many_turns)), key=lambda t: sum(map(abs, t)))[1:]:
        shift = np.zeros(len(cell))
        shift[many_turns] = 2.0 * np.pi * np.array(turns)
        q = travel.q[-1] + shift
        if np.any(q < cell.q_lower) or np.any(q > cell.q_upper):
            continue
        attempt = follower.follow(follower.at(q), reference + shift, block.at + 1, block.stop, tolerant=True)
        if attempt.failure is None:
            moves = np.array([travel.q[-1], q])
            value = revision.inv_kf_before
            reason = "axes unwound, so that the whole region stays within their range"
            unwound = Revision(block.region, block.at, moves, True, value, value, reason, by_axes=True)
            return attempt, reference + shift, replace(travel, q=np.vstack([travel.q[:-1], q])), unwound
    return failed, reference, travel, revision


def _worth_it(revised: Attempt, plain: Attempt) -> bool:
    """Whether a region, done whole both ways, gains by a revision: 1/k_F no lower at its lowest, higher there or in the mean."""
    if not len(plain.inv_kf):
        return True
    least = float(revised.inv_kf.min() - plain.inv_kf.min())
    mean = float(revised.inv_kf.mean() - plain.inv_kf.mean())
    return least >= 0.0 and max(least, mean) >= GAIN


@kernel(nogil=True)
def _self_motion_bounds(
    points: Array, axes: Array, feed: Array, where: NDArray[np.int64], slides: NDArray[np.bool_], length: float,
    speed: Array, out: Array,
) -> None:  # fmt: skip
    """out (M, n) <- bounds on self-motion at points 1 .. M, of which `where` (N,) are the path's own, with feeds (N,)."""
    own = 0
    for k in range(out.shape[0]):
        square, along = 0.0, 0.0
        for r in range(3):
            d = points[k + 1, r] - points[k, r]
            square += d * d
            along += axes[k + 1, r] * axes[k, r]
        step, turn = np.sqrt(square), np.arccos(min(1.0, max(-1.0, along)))
        while own < len(where) - 1 and where[own] < k:
            own += 1
        time = max(step / feed[own], turn / 1.0) + 1e-3
        for i in range(out.shape[1]):
            moved = step + length * turn if slides[i] else step / length + turn
            out[k, i] = min(SPEED_SHARE * time * speed[i], SELF_RATIO * moved)


class PathFollower:
    """The follower bound to a cell and a path; every call takes and gives states, nothing is kept between calls."""

    def __init__(
        self,
        cell: Cell,
        path: ToolPathInBase,
        *,
        weighting: Weighting | None = None,
        further: Mapping[str, float] | None = None,
    ) -> None:
        self.cell, self.path = cell, path
        self._kept = own_limits(cell, further)
        self.chain = chain_arrays(cell)
        self.arm = Arm.of(cell)
        self._still = path.along_axis
        self._external = [*cell.indices(Role.WORKPIECE), *cell.indices(Role.CARRIAGE)]
        self.weigh(engine_weighting(cell) if weighting is None else weighting)
        self._speed = np.where(np.isfinite(cell.limits_of("speed")), cell.limits_of("speed"), np.inf)

    def weigh(self, weighting: Weighting) -> None:
        """Take other weights from now on."""
        cell = self.cell
        self.settings = FollowerSettings(
            *self._kept,
            cell.endless,
            weighting.joint,
            weighting.condition,
            weighting.threshold,
            held_joints(cell),
            weighting.gradient,
        )
        locked = np.asarray(self.settings.locked).copy()
        locked[self._external] = True
        self._arm_alone = self.settings._replace(locked=locked)

    def at(self, q: Array) -> FollowState:
        """The state of a follower that starts in posture q (n,)."""
        n = len(q)
        return FollowState(np.array(q), np.array(q), np.zeros(n, np.int64), np.zeros(2, np.int64))

    def home(self) -> FollowState:
        """The state at HOME."""
        return self.at(self.cell.q_home)

    def inv_kf(self, q: Array) -> float:
        """1/k_F of one posture."""
        from camrob.kinematics.kernels import inverse_kf_many

        return float(inverse_kf_many(self.chain, q[None])[0])

    def follow(
        self,
        state: FollowState,
        reference: Array,
        start: int,
        stop: int,
        *,
        tolerant: bool = False,
        bounded: bool = True,
    ) -> Attempt:
        """Follow the path's points start .. stop from a state; the state itself is left alone.

        reference: one posture (n,) for all points, or a posture a point (stop - start, n), which then moves evenly between
        them. `bounded` False lets self-motion go as fast as the reference posture asks.
        The way from the state's posture to the first point goes straight, the axis along the great arc. Raises the
        JobError of a point that can't be reached, or with `tolerant` returns it with what was reached.
        """
        state = FollowState(state.q.copy(), state.q_threshold.copy(), state.side.copy(), state.flags.copy())
        if stop <= start:
            return Attempt(np.empty((0, len(self.cell))), np.empty(0), state)
        here = base_T_tool(self.cell, state.q)
        path_frames = self.path.base_T_tip[start:stop]
        tips = np.concatenate([here[None, :3, 3], path_frames[:, :3, 3]])
        axes = np.concatenate([here[None, :3, 2], path_frames[:, :3, 2]])
        points, directions, where = refine(tips, axes, STEP, ANGLE)
        targets = pose(rotation_minimising(directions, np.ascontiguousarray(here[:3, 0])), points)[1:]
        where = where[1:] - 1
        targets[where] = path_frames
        limits = self._limits(points, directions, where, start, stop)
        if not bounded:
            limits[:] = np.inf
        if reference.ndim == 2:
            known = np.concatenate([[-1], where])
            rows = np.vstack([state.q, reference])
            reference = np.stack([np.interp(np.arange(len(targets)), known, column) for column in rows.T], axis=1)
        else:
            reference = reference[None]
        q, inv_kf = np.empty((len(targets), len(self.cell))), np.empty(len(targets))
        still = self._still[start:stop][np.searchsorted(where, np.arange(len(targets)))]
        code, reached = self._followed(targets, np.ascontiguousarray(reference), state, limits, still, q, inv_kf)
        if code == FOLLOWED:
            return Attempt(q[where], inv_kf[where], state)
        point = start + int(np.searchsorted(where, reached))
        failure = Failure(point, targets[reached], code, state)
        if not tolerant:
            raise self.explain(failure)
        kept = where[: np.searchsorted(where, reached)]
        return Attempt(q[kept], inv_kf[kept], state, failure)

    def _followed(
        self, targets: Array, reference: Array, state: FollowState, limits: Array, still: NDArray[np.bool_], q: Array,
        inv_kf: Array,
    ) -> tuple[int, int]:  # fmt: skip
        """`follow_path`, in pieces: external axes stand on those that are `still` (M,), but where the arm can't do it alone."""
        for part in runs_of(still):
            rows = reference if len(reference) == 1 else reference[part]
            piece = targets[part], limits[part], q[part], inv_kf[part]
            if still[part.start]:
                alone = FollowState(state.q.copy(), state.q_threshold.copy(), state.side.copy(), state.flags.copy())
                kept = rows.copy()
                kept[:, self._external] = state.q[self._external]
                code, _ = follow_path(self.chain, self._arm_alone, piece[0], kept, alone, *piece[1:])
                if code == FOLLOWED:
                    for now, then in zip(state, alone, strict=True):
                        now[:] = then
                    continue
            code, reached = follow_path(self.chain, self.settings, piece[0], rows, state, *piece[1:])
            if code != FOLLOWED:
                return code, part.start + reached
        return FOLLOWED, len(targets)

    def explain(self, failure: Failure) -> JobError:
        """The error for a point that could not be followed, with what other postures would meet there."""
        f = failure
        return explain_failure(self.cell, self.arm, self.path, f.point, f.base_T_target, f.code, f.state)

    def _limits(self, points: Array, axes: Array, where: NDArray[np.int64], start: int, stop: int) -> Array:
        """(M, n) how far self-motion may take each joint at each refined point.

        What its speed allows in the time of the move, and in proportion to the tool's own motion, so that the posture
        glides where its equilibrium folds over to another; at safe points, where it may, by what is left of its speed in the
        whole way there; without bound on the way from HOME.
        """
        feed = np.where(np.isfinite(self.path.feed[start:stop]), self.path.feed[start:stop], AIR_SPEED)
        slides = np.array([j.prismatic for j in self.cell.joints])
        limits = np.empty((len(points) - 1, len(self.cell)))
        _self_motion_bounds(points, axes, feed, where, slides, self.cell.condition_length, self._speed, limits)
        way = np.linalg.norm(np.diff(points, axis=0), axis=1).cumsum()[where]
        time = np.diff(way, prepend=0.0) / feed
        free = self.path.safe[start:stop]
        speed = np.where(time[free, None] > 0.0, self._speed, 0.0)  # 0 s at any speed, be it without limit, is no way
        room = (1.0 - SPEED_SHARE) * time[free, None] * speed
        limits[where[free]] = np.maximum(limits[where[free]], room)
        if start == 0:
            limits[:] = np.inf  # the way from HOME is travelled by PTP
        return np.asarray(limits)
