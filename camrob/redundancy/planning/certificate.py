"""The certificate: at every waypoint the best 1/k_F that any posture of the cell within its limits allows.

A scan over external axes, roll and branches at a few poses that stand for the path finds the basins; from the best of
them, and from the neighbour's best, a compass search climbs at every waypoint; where limits leave little room these miss
poses, which are scanned for themselves. The scan is what makes the bound global: it is a searched bound, not a proven one, so a
posture found elsewhere that beats it raises it (`Certificate.raised`).
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.frozen import locked
from camrob.kinematics.arm import reach
from camrob.kinematics.spherical_wrist import BRANCH_OK
from camrob.product_grid import product_grid
from camrob.redundancy.planning.freedoms import PlanSpace, PlanWork, conditioning, plan_work, pose_in_foot, posture
from camrob.redundancy.planning.scan_batched import Score, scan_batched

__all__ = [
    "Certificate",
    "Survey",
    "certify",
    "climb",
    "external_grid",
    "inside",
    "representatives",
    "scan",
    "survey_poses",
]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

ROLLS = 18  # of a turn in the scan
_TURN = 18  # values of an endless axis in the scan
_PRISMATIC_STEP = 0.15  # m
_REVOLUTE_STEP = 0.35  # rad
_GRID = 4000  # external postures at most
_ANCHORS = 40  # poses that are scanned
_MORE = 4  # times as many each time that some are still not reached
_BASIN_NODES = 2000  # best nodes of a scan among which the basins are looked for
_STARTS = 4  # basins of a scanned pose that are climbed from
_CLIMB_FIRST, _CLIMB_NEAR, _CLIMB_LAST = 0.1, 0.02, 5e-4  # rad or m, steps of the compass search


@dataclass(frozen=True, slots=True)
class Certificate:
    """The best 1/k_F (W,) found at W poses, with the freedoms u (W, F) and branch (W,) that reach it; 0 where none does.

    unreached: a pose that a scan of its own reaches by nothing, -1 where all are reached; no further pose was looked for then.
    """

    inv_kf: Array
    u: Array
    branch: Ints
    unreached: int = -1

    def __post_init__(self) -> None:
        n = len(self.inv_kf)
        object.__setattr__(self, "inv_kf", locked(self.inv_kf, shape=(n,), name="inv_kf"))
        object.__setattr__(self, "u", locked(self.u, shape=(n, None), name="u"))
        object.__setattr__(self, "branch", locked(self.branch, shape=(n,), dtype=np.int64, name="branch"))

    def raised(self, inv_kf: Array) -> Certificate:
        """The certificate with what was reached after all: no bound stays below a posture that exists."""
        return replace(self, inv_kf=np.maximum(self.inv_kf, inv_kf))

    def along(self, at: Array, s: Array) -> Array:
        """The bound (N,) at places s (N,) of a path whose waypoints lie at `at` (W,), increasing.

        Linear between waypoints, raised by what a curve that bends as at both ends rises above its chord (at most an
        eighth of the second difference); where the bound has a kink, at a waypoint, there is nothing to raise.
        """
        value = np.asarray(self.inv_kf)
        line = np.interp(s, at, value)
        if len(value) < 3:
            return np.asarray(line)
        bend = np.zeros(len(value))
        bend[1:-1] = np.abs(value[2:] - 2.0 * value[1:-1] + value[:-2])
        k = np.clip(np.searchsorted(at, s, side="right") - 1, 0, len(at) - 2)
        share = np.clip((s - at[k]) / np.maximum(at[k + 1] - at[k], 1e-12), 0.0, 1.0)
        return np.asarray(line + 0.5 * share * (1.0 - share) * np.minimum(bend[k], bend[k + 1]))


@dataclass(frozen=True, slots=True)
class Survey:
    """A scan at A poses that stand for W.

    anchors (A,): indices of the poses that were scanned; nearest (W,): which of them stands for each pose. grid (M, E): the
    external postures that were tried; best (A, M): the best 1/k_F over roll and branch in each, 0 for none. u (A, S, F) and
    branch (A, S): the S best basins, climbed, -1 where there are fewer. price (A, M): of a metre in each of the grid, where a
    plan looks at more than conditioning.
    """

    anchors: Ints
    nearest: Ints
    grid: Array
    best: NDArray[np.float32]
    u: Array
    branch: Ints
    price: Array | None = None


def survey_poses(space: PlanSpace, base_T_tip: Array, score: Score | None = None, *, count: int = _ANCHORS) -> Survey:
    """Scan the poses that stand for all (W, 4, 4); about 20 ms for each of `count` at most.

    score: what gives the scan's postures their 1/k_F in batches, where the compiled scan is not to do that.
    """
    frames = locked(base_T_tip)
    anchors, nearest = representatives(frames, count)
    grid = external_grid(space)
    best = np.empty((len(anchors), len(grid)), np.float32)
    u = np.empty((len(anchors), _STARTS, len(space.free)))
    branch = np.full((len(anchors), _STARTS), -1, np.int64)

    def look(k: int) -> None:
        frame = frames[anchors[k]]
        found = (
            scan(space, frame, grid, ROLLS)
            if score is None or space.alike == 1  # the batches hold one posture for both of a wrist's branches
            else scan_batched(space, frame, grid, ROLLS, score)
        )
        best[k] = found.max(axis=(1, 2))
        _basins(space, frame, grid, found, u[k], branch[k])

    with ThreadPoolExecutor(2 if score is None else 1) as pool:  # the kernel releases the interpreter's lock
        list(pool.map(look, range(len(anchors))))
    _climb_basins(space, frames[anchors], u, branch)
    return Survey(anchors, nearest, grid, best, u, branch)


def certify(
    space: PlanSpace, base_T_tip: Array, survey: Survey | None = None, score: Score | None = None
) -> Certificate:
    """The certificate of poses (W, 4, 4) in the order of travel; under 1 ms a pose beside the survey; `score`: `survey_poses`.

    What no climb reaches is surveyed anew, few poses of it at first. A scanned pose that nothing reaches ends that; each scan
    reaches at least the pose that it is of, so that no more rounds are needed than there are poses.
    """
    poses = frames = locked(base_T_tip)
    survey = survey_poses(space, frames, score) if survey is None else survey
    W = len(frames)
    value, u, branch, some, count = np.zeros(W), np.zeros((W, len(space.free))), np.zeros(W, np.int64), np.arange(W), 1
    while True:
        found = _climb_all(space, frames, survey.anchors, survey.nearest, survey.u, survey.branch)
        value[some], u[some], branch[some] = found
        empty = some[survey.anchors[survey.best.max(axis=1) <= 0.0]]
        some = np.flatnonzero(value <= 0.0)
        if len(empty) or not len(some):
            return Certificate(value, u, branch, int(empty.min()) if len(empty) else -1)
        frames = locked(poses[some])
        survey = survey_poses(space, frames, score, count=count)
        count = min(_MORE * count, _ANCHORS)


def external_grid(space: PlanSpace) -> Array:
    """External postures (M, E) that a scan goes through; (1, 0) for a cell without external axes."""
    axes: list[Array] = []
    count = len(space.free) - space.roll
    for i in range(count):
        if space.u_endless[i]:
            axes.append(np.linspace(-np.pi, np.pi, _TURN, endpoint=False))
        else:
            step = _PRISMATIC_STEP if space.prismatic[i] else _REVOLUTE_STEP
            span = space.u_upper[i] - space.u_lower[i]
            axes.append(np.linspace(space.u_lower[i], space.u_upper[i], max(3, int(np.ceil(span / step)) + 1)))
    while axes and np.prod([len(a) for a in axes]) > _GRID:
        longest = int(np.argmax([len(a) for a in axes]))
        a = axes[longest]
        axes[longest] = np.linspace(a[0], a[-1], (len(a) + 1) // 2, endpoint=not space.u_endless[longest])
    return product_grid(axes)


def representatives(base_T_tip: Array, count: int) -> tuple[Ints, Ints]:
    """`count` poses at most that stand for all (W, 4, 4), by farthest points, and the nearest of them (W,) to each."""
    feature = np.concatenate([base_T_tip[:, :3, 3] / 0.1, base_T_tip[:, :3, 2] / 0.2], axis=1)
    chosen = [0]
    distance = np.linalg.norm(feature - feature[0], axis=1)
    nearest = np.zeros(len(feature), np.int64)
    while len(chosen) < count and distance.max() > 0.25:
        k = int(np.argmax(distance))
        d = np.linalg.norm(feature - feature[k], axis=1)
        closer = d < distance
        nearest[closer], distance[closer] = len(chosen), d[closer]
        chosen.append(k)
    return np.array(chosen, np.int64), nearest


@part
def inside(space: PlanSpace, q: Array) -> bool:
    """Whether a posture (6,) is within the limits."""
    for i in range(6):
        if q[i] < space.lower[i] or q[i] > space.upper[i]:
            return False
    return True


@kernel(nogil=True)
def scan(space: PlanSpace, base_T_tip: Array, grid: Array, rolls: int) -> NDArray[np.float32]:
    """1/k_F (M, rolls, 8) of every external posture, roll (a turn's share; one where there is no roll) and branch; 0: none."""
    M, E = grid.shape
    F = space.free.shape[0]
    out = np.zeros((M, rolls, 8), np.float32)
    work = plan_work()
    u, q = np.zeros(F), np.empty(6)
    count = rolls if space.roll == 1 else 1
    for m in range(M):
        u[:E] = grid[m]
        for k in range(count):
            if space.roll == 1:
                u[F - 1] = -np.pi + 2.0 * np.pi * k / rolls
            pose_in_foot(space, base_T_tip, u, work)
            if reach(space.arm, space.screws, work.Rt, work.pt, space.center, work.Q, work.why) == 0:
                continue
            for b in range(0, 8, 2):  # the two branches of a spherical wrist share 1/k_F
                value = -1.0
                for side in range(2):
                    if work.why[b + side] == BRANCH_OK:
                        for i in range(6):
                            q[i] = work.Q[b + side, i]
                        if inside(space, q):
                            if value < 0.0 or space.alike == 1:
                                value = conditioning(space, q, work)
                            out[m, k, b + side] = value
    return out


def _basins(space: PlanSpace, frame: Array, grid: Array, found: NDArray[np.float32], u: Array, branch: Ints) -> None:
    """Fill u (S, F) and branch (S,) with the best nodes of a scan that lie apart in branch or by more than a grid step."""
    E, rolls = grid.shape[1], found.shape[1]
    flat = found.ravel()
    some = min(_BASIN_NODES, flat.size)
    order = np.argpartition(flat, flat.size - some)[flat.size - some :]
    order = order[np.lexsort((order, flat[order]))[::-1]]
    m, k, b = np.unravel_index(order, found.shape)
    count = 0
    for i in range(len(order)):
        if found[m[i], k[i], b[i]] <= 0.0 or count == len(u):
            break
        candidate = np.zeros(len(space.free))
        candidate[:E] = grid[m[i]]
        if space.roll:
            candidate[E] = -np.pi + 2.0 * np.pi * k[i] / rolls
        for j in range(count):
            apart = np.abs(candidate - u[j])
            apart[space.u_endless] = np.abs((apart[space.u_endless] + np.pi) % (2.0 * np.pi) - np.pi)
            if branch[j] // space.alike == b[i] // space.alike and np.all(apart < 0.8):
                break
        else:
            u[count], branch[count] = candidate, b[i]
            count += 1


@part
def _value(space: PlanSpace, frame: Array, u: Array, branch: int, q: Array, work: PlanWork) -> float:
    """1/k_F on the turns in the middle of the ranges; 0 out of reach or limits."""
    for i in range(u.shape[0]):
        if u[i] < space.u_lower[i] or u[i] > space.u_upper[i]:
            return 0.0
    if not posture(space, frame, u, branch, space.center, q, work) or not inside(space, q):
        return 0.0
    return float(conditioning(space, q, work))


@part
def climb(space: PlanSpace, frame: Array, u: Array, branch: int, first: float, last: float, work: PlanWork) -> float:
    """Move u (F,) uphill on 1/k_F by a compass search with pattern moves; returns the value, 0 if it starts outside."""
    F = u.shape[0]
    q, trial, before = np.empty(6), np.empty(F), np.empty(F)
    best = _value(space, frame, u, branch, q, work)
    if best == 0.0:
        return 0.0
    step = first
    while step > last:
        before[:] = u
        for i in range(F):
            for sign in (1.0, -1.0):
                trial[:] = u
                trial[i] += sign * step
                value = _value(space, frame, trial, branch, q, work)
                if value > best:
                    best = value
                    u[:] = trial
                    break
        moved = False
        for i in range(F):
            trial[i] = 2.0 * u[i] - before[i]
            moved = moved or u[i] != before[i]
        if not moved:
            step *= 0.5
            continue
        value = _value(space, frame, trial, branch, q, work)
        if value > best:
            best = value
            u[:] = trial
    return float(best)


@kernel(nogil=True)
def _climb_basins(space: PlanSpace, frames: Array, u: Array, branch: Ints) -> None:
    """Climb the basins u (A, S, F) of frames (A, 4, 4): the best comes first, one that ends in another's top is dropped (-1)."""
    A, S, _F = u.shape
    work = plan_work()
    value = np.empty(S)
    for a in range(A):
        for s in range(S):
            value[s] = (
                climb(space, frames[a], u[a, s], branch[a, s], _CLIMB_FIRST, _CLIMB_LAST, work)
                if branch[a, s] >= 0
                else 0.0
            )
        order = np.argsort(-value)
        u[a] = u[a][order].copy()
        branch[a] = branch[a][order].copy()
        value = value[order].copy()
        for s in range(1, S):
            for other in range(s):
                if (
                    branch[a, s] // space.alike == branch[a, other] // space.alike
                    and np.max(np.abs(u[a, s] - u[a, other])) < 0.05
                ):
                    branch[a, s] = -1
                    break


@kernel(nogil=True)
def _climb_all(
    space: PlanSpace, frames: Array, anchors: Ints, nearest: Ints, starts: Array, branches: Ints
) -> tuple[Array, Array, Ints]:
    """The best of the neighbours' optima and of the nearest scanned pose's basins, climbed, forward and back along the path."""
    W, S, F = frames.shape[0], starts.shape[1], starts.shape[2]
    value, u, branch = np.zeros(W), np.zeros((W, F)), np.zeros(W, np.int64)
    work = plan_work()
    trial, tops, met = np.empty(F), np.empty((S, F)), np.zeros(S)
    for k in range(W):
        a = nearest[k]
        for s in range(S):
            if branches[a, s] < 0:
                continue
            found = 0.0
            if (
                k > 0 and nearest[k - 1] == a and met[s] > 0.0
            ):  # the basin's top has moved a little since the pose before
                trial[:] = tops[s]
                if space.roll == 1:
                    trial[F - 1] += _spin(frames[k - 1], frames[k])
                found = climb(space, frames[k], trial, branches[a, s], _CLIMB_NEAR, _CLIMB_LAST, work)
            if found == 0.0:
                trial[:] = starts[a, s]
                if space.roll == 1:  # the same direction of the tool's x in `base`
                    trial[F - 1] += _spin(frames[anchors[a]], frames[k])
                found = climb(space, frames[k], trial, branches[a, s], _CLIMB_FIRST, _CLIMB_LAST, work)
            tops[s], met[s] = trial, found
            if found > value[k]:
                value[k], branch[k] = found, branches[a, s]
                u[k] = trial
    for direction in (1, -1):
        for i in range(1, W):
            k = i if direction == 1 else W - 1 - i
            j = k - direction
            trial[:] = u[j]
            if value[j] > 0.0:
                found = climb(space, frames[k], trial, branch[j], _CLIMB_NEAR, _CLIMB_LAST, work)
                if found > value[k]:
                    value[k], branch[k] = found, branch[j]
                    u[k] = trial
    return value, u, branch


@part
def _spin(one: Array, other: Array) -> float:
    """What to add to the roll so that x points alike from one frame (4, 4) to another."""
    c = s = 0.0
    for r in range(3):
        c += one[r, 0] * other[r, 0]
        s += one[r, 0] * other[r, 1]
    return float(-np.arctan2(s, c))
