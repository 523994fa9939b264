"""Two bodies along a whole path of postures, compiled: conservative advancement from one sample to the next.

Between path points the postures run straight in the joints. From a sample where two bodies are d apart, the path is
followed as long as no point of one body can have moved by more than d against the other: what lies between needs no
sample. The motion is bounded joint by joint from the tool inwards (Schwarzer, Saha, Latombe 2005, adaptive dynamic
collision checking): a joint that turns by at most D moves what it carries by at most D (rho + what the joints beyond it
move), rho being the farthest that the body reaches from the joint's axis at the sample.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.convex import Pieces
from camrob.bodies.tree import ball_distance, new_search, tree_distance
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.compiled import inlined, kernel
from camrob.frame_steps import compose, move_joint

__all__ = ["Links", "Riders", "block_ranges", "chain_links", "follow_pair", "pair_distances"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_SPLITS = 30  # halvings of a path step: fine enough for a millimetre of a motion across the shop floor
_ROUGH = 0.1  # of a distance to a mesh, on the way
_EXACT = 1e-3
_BLOCK = 8  # points: most samples reach over some ten
_NEAR = 0.3  # m between the balls about two bodies within which their distance saves samples
_CLOSE = 0.1  # how finely the smallest clearance is looked for, as a part of itself


class Links(NamedTuple):
    """The chain as constants: before (n, 4, 4) and after (n, 4, 4) each joint's motion; prismatic (n,)."""

    before: Array
    after: Array
    prismatic: NDArray[np.bool_]


class Riders(NamedTuple):
    """The bodies: link (k,) they follow, link_T_body (k, 4, 4), root (k,) of their trees in `pieces`."""

    link: Index
    link_T_body: Array
    root: Index
    pieces: Pieces


def chain_links(cell: Cell) -> Links:
    """A cell's chain from `base`; behind joint i stands the frame that its Denavit-Hartenberg row ends in."""
    before = np.stack([j.before for j in cell.joints])
    before[0] = cell.base_T_first @ before[0]
    roll = cell.indices(Role.ROLL)
    if roll:
        before[roll[0]] = cell.wrist_T_flange @ cell.flange_T_tool @ before[roll[0]]
    return Links(before, np.stack([j.after for j in cell.joints]), np.array([j.prismatic for j in cell.joints]))


@inlined
def _place(links: Links, riders: Riders, a: int, b: int, q: Array, R: Array, p: Array, rho: Array) -> None:
    """R, p <- body a seen from body b; rho[i] <- how far a reaches from the axis of joint i, for the joints between.

    a rides at least as far out on the chain as b does.
    """
    low, high = riders.link[b] + 1, riders.link[a]
    Z, P = np.empty((high + 1, 3)), np.empty((high + 1, 3))
    for r in range(3):
        p[r] = 0.0
        for c in range(3):
            R[r, c] = 1.0 if r == c else 0.0
    for i in range(low, high + 1):
        compose(R, p, links.before[i])
        for r in range(3):
            Z[i, r] = R[r, 2]
            P[i, r] = p[r]
        move_joint(R, p, links.prismatic[i], q[i])
        compose(R, p, links.after[i])
    compose(R, p, riders.link_T_body[a])
    root = riders.root[a]
    middle = riders.pieces.center[root]
    x = p[0] + R[0, 0] * middle[0] + R[0, 1] * middle[1] + R[0, 2] * middle[2]
    y = p[1] + R[1, 0] * middle[0] + R[1, 1] * middle[1] + R[1, 2] * middle[2]
    z = p[2] + R[2, 0] * middle[0] + R[2, 1] * middle[1] + R[2, 2] * middle[2]
    for i in range(low, high + 1):
        dx, dy, dz = x - P[i, 0], y - P[i, 1], z - P[i, 2]
        along = dx * Z[i, 0] + dy * Z[i, 1] + dz * Z[i, 2]
        away2 = dx * dx + dy * dy + dz * dz - along * along
        rho[i] = np.sqrt(max(0.0, away2)) + riders.pieces.reach[root]
    # from b's link into b: R <- B^T R, p <- B^T (p - b)
    B = riders.link_T_body[b]
    dx, dy, dz = p[0] - B[0, 3], p[1] - B[1, 3], p[2] - B[2, 3]
    for r in range(3):
        p[r] = B[0, r] * dx + B[1, r] * dy + B[2, r] * dz
    for c in range(3):
        x, y, z = R[0, c], R[1, c], R[2, c]
        for r in range(3):
            R[r, c] = B[0, r] * x + B[1, r] * y + B[2, r] * z


@inlined
def _moved(links: Links, low: int, high: int, turn: Array, rho: Array) -> float:
    """How far at most a body moves while the joints low..high leave the sample by at most turn[i]."""
    total = 0.0
    for i in range(high, low - 1, -1):
        if links.prismatic[i]:
            total += turn[i]
        else:
            total += min(turn[i], 2.0) * (rho[i] + total)  # a chord is no longer than the diameter
    return total


def block_ranges(q: Array) -> Array:
    """The least and the most (2, B, n) of postures q (M, n) in each block of `_BLOCK` points, which are then passed at once."""
    starts = np.arange(0, len(q), _BLOCK)
    return np.stack([pick.reduceat(q, starts, axis=0) for pick in (np.minimum, np.maximum)])


@inlined
def _reach_on(
    links: Links,
    low: int,
    high: int,
    q: Array,
    ranges: Array,
    stop: int,
    k: int,
    t: float,
    posture: Array,
    rho: Array,
    reach: float,
    turn: Array,
    trial: Array,
) -> tuple[int, float, float]:
    """Follow the path from the sample (k, t) while nothing moves by more than `reach`.

    Returns the segment's start and the part of it that were reached, and the motion up to there. A run of active
    segments, which ends before point `stop`, is never left: at its end the start is its last point and the part 0.
    """
    for i in range(low, high + 1):
        turn[i] = 0.0
    moved, j, single = 0.0, k + 1, 0
    while j < stop:
        block = j >= single and j % _BLOCK == 0 and j + _BLOCK <= stop
        for i in range(low, high + 1):
            if block:
                least, most = ranges[0, j // _BLOCK, i], ranges[1, j // _BLOCK, i]
                trial[i] = max(turn[i], max(most - posture[i], posture[i] - least))
            else:
                trial[i] = max(turn[i], abs(q[j, i] - posture[i]))
        further = _moved(links, low, high, trial, rho)
        if further > reach:
            if not block:
                break
            single = j + _BLOCK  # somewhere in this block: point by point
            continue
        moved = further
        for i in range(low, high + 1):
            turn[i] = trial[i]
        j += _BLOCK if block else 1
    if j == stop:
        return j - 1, 0.0, moved
    below = t if j == k + 1 else 0.0
    above = 1.0
    for _ in range(_SPLITS):
        middle = 0.5 * (below + above)
        for i in range(low, high + 1):
            trial[i] = max(turn[i], abs(q[j - 1, i] + middle * (q[j, i] - q[j - 1, i]) - posture[i]))
        further = _moved(links, low, high, trial, rho)
        if further <= reach:
            below, moved = middle, further
        else:
            above = middle
        if further <= reach and further > 0.98 * reach:
            break
    return j - 1, below, moved


@inlined
def _next_run(active: NDArray[np.bool_], k: int) -> int:
    """Start of the next active segment at or behind point k; the number of points where there is none."""
    for j in range(k + 1, len(active)):
        if active[j]:
            return j - 1
    return len(active)


@inlined
def _run_end(active: NDArray[np.bool_], j: int) -> int:
    """The first point from j on into which no active segment leads; the number of points where there is none."""
    while j < len(active) and active[j]:
        j += 1
    return j


@kernel(nogil=True)
def follow_pair(
    links: Links,
    riders: Riders,
    a: int,
    b: int,
    q: Array,
    ranges: Array,
    active: NDArray[np.bool_],
    step: float,
    budget: int,
    touches: bool,
    hit: NDArray[np.bool_],
) -> tuple[float, int, float, int]:
    """Clearance of bodies a and b (a rides farther out) along postures q (M, n), straight in the joints between them.

    ranges: `block_ranges` of q. active (M,): whether the motion into a point counts; of a single posture active[0]. Sets
    hit[j] where the bodies touch at point j or on the way to it. Samples lie nowhere farther apart than
    max(clearance, step) in motion of any point of the bodies; `step` doubles each time `budget` samples are used up.
    Returns the smallest clearance found (m, inf without a sample), the point where (or on the way to which) it is, the
    largest motion between samples that no clearance covered (m, 0 where all is proven), and the number of samples. touches:
    nothing but these is looked for, in fewer samples; the clearance is 0 then, or inf.
    """
    low, high = riders.link[b] + 1, riders.link[a]
    count, n = q.shape
    search = new_search()
    R, p, rho = np.empty((3, 3)), np.empty(3), np.zeros(n)
    posture, closest, turn, trial = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    root_a, root_b, pieces = riders.root[a], riders.root[b], riders.pieces
    clearance, at, blind, samples = 0.0 if touches else np.inf, 0, 0.0, 0
    near = _NEAR if touches else 2.0 * step
    finest, k, t, stop = step, 0 if count == 1 and active[0] else _next_run(active, 0), 0.0, 0
    while k < count:
        if k + 1 >= stop:
            stop = _run_end(active, k + 1)
        for i in range(n):
            posture[i] = q[k, i] + (t * (q[k + 1, i] - q[k, i]) if t > 0.0 else 0.0)
        _place(links, riders, a, b, posture, R, p, rho)
        here = k + 1 if t > 0.0 else k
        d = ball_distance(pieces, root_a, root_b, R, p)
        if d <= max(clearance, near, 2.0 * step):
            d = tree_distance(pieces, root_a, root_b, R, p, _ROUGH, search)
        samples += 1
        step *= 2.0 if samples % budget == 0 else 1.0
        if d < clearance:
            clearance, at = d, here
            for i in range(n):
                closest[i] = posture[i]
        if d <= 0.0:
            hit[here] = True
            reach = step if step > finest else 0.0
        else:
            reach = max(step, min(d, d - clearance + max(step, _CLOSE * clearance)))
        new_k, new_t = k, t
        if reach > 0.0:
            new_k, new_t, moved = _reach_on(links, low, high, q, ranges, stop, k, t, posture, rho, reach, turn, trial)
            blind = max(blind, moved - d)
        ended = new_t == 0.0 and (new_k + 1 >= count or not active[new_k + 1])
        if new_k == k and (d <= 0.0 or new_t <= t) and not ended:
            k, t = k + 1, 0.0
        elif ended and (d > 0.0 or new_k == k):
            k, t = _next_run(active, new_k), 0.0
        else:
            k, t = new_k, new_t
    if touches:
        clearance = 0.0 if np.any(hit) else np.inf
    if 0.0 < clearance < np.inf:
        _place(links, riders, a, b, closest, R, p, rho)
        clearance = tree_distance(pieces, root_a, root_b, R, p, _EXACT, search)
    return clearance, at, blind, samples


@kernel(nogil=True)
def pair_distances(links: Links, riders: Riders, a: int, b: int, q: Array) -> Array:
    """Distances (M,), m, of bodies a and b (a rides farther out) in postures q (M, n); 0.0 where they touch."""
    search = new_search()
    R, p, rho = np.empty((3, 3)), np.empty(3), np.zeros(q.shape[1])
    out = np.empty(len(q))
    for k in range(len(q)):
        _place(links, riders, a, b, q[k], R, p, rho)
        out[k] = tree_distance(riders.pieces, riders.root[a], riders.root[b], R, p, _EXACT, search)
    return out
