"""The speed along a path: as fast as the programmed speed, tool, rotation and every axis allow, by two passes.

The path is divided into short steps of even acceleration. A backward pass finds the highest square speed at each node from
which everything behind can still be braked for; a forward pass then accelerates as much as it may below that (numerical
integration in the phase plane, in the form of reachability analysis: Pham and Pham, IEEE T-RO 34(3), 2018). All bounds are
held at both ends of every step. Square speed x and acceleration u along the path give q' u + q'' x for an axis; the derivatives
come from the postures at the nodes of a piece, which is smooth.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.controller.interpolate import Pieces

__all__ = ["CAUSES", "FEED", "Bounds", "Course", "brake", "cruise", "look_ahead", "run_up", "where_at"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

CAUSES = (
    "programmed speed",
    "stop",
    "tool acceleration",
    "rotation speed",
    "rotation acceleration",
    "look-ahead",
)
"""What may hold the tool back, before the axes: then come the axes' speeds, then their accelerations."""
FEED, STOP, TOOL, TURN, TURN_UP, AHEAD, AXES = range(7)
_TRIES = 80  # more halvings than a double has digits


class Bounds(NamedTuple):
    """speed, acceleration: (2, n) of the axes, in CP motions and in PTP; those of the tool's rotation, rad/s and rad/s2.

    corner: s within which a corner that is passed without rounding may change a speed.
    """

    speed: Array
    acceleration: Array
    turn_speed: float
    turn_acceleration: float
    corner: float


class Course(NamedTuple):
    """The path at its K nodes, and what is asked of each piece.

    q: (K, n), p: (K, 3). cap: (P,) programmed speed along the path, push: (P,) the tool's acceleration, inf for PTP; turn0,
    turn1: (P, 3) rotation a metre of path at both ends. ptp: (P,) 1 for PTP. stop, sharp: (K,) where the motion rests, and
    where it passes a corner without rounding.
    """

    pieces: Pieces
    q: Array
    p: Array
    cap: Array
    push: Array
    turn0: Array
    turn1: Array
    ptp: Indices
    stop: NDArray[np.bool_]
    sharp: NDArray[np.bool_]


@part
def _rates(course: Course, k: int, j: int, A: Array, B: Array) -> None:
    """First (A) and second (B) derivatives of axes and tool (n + 3,) at node j of piece k."""
    n, first, count = course.q.shape[1], course.pieces.first[k], course.pieces.steps[k]
    h = course.pieces.length[k] / count
    mid = first + min(max(j, 1), count - 1)
    side = (first + j - mid) / h  # -1 / h, 0 or 1 / h: the derivative at an end, from that in the middle
    for i in range(n + 3):
        if i < n:
            a, b, c = course.q[mid - 1, i], course.q[mid, i], course.q[mid + 1, i]
        else:
            a, b, c = course.p[mid - 1, i - n], course.p[mid, i - n], course.p[mid + 1, i - n]
        bend = a - 2.0 * b + c
        A[i] = 0.5 * (c - a) / h + side * bend
        B[i] = bend / (h * h)


@part
def _tighten(room: Array, low: float, low_slope: float, high: float, high_slope: float) -> None:
    """Take the range low .. high, with its slopes over x, out of room (4,): low, high and their slopes."""
    if low > room[0]:
        room[0], room[2] = low, low_slope
    if high < room[1]:
        room[1], room[3] = high, high_slope


@part
def _norm(a: Array, b: Array, x: float, limit: float, room: Array) -> None:
    """Tighten room to the u with |a u + b x| <= limit for vectors (3,); an empty range where there is none."""
    aa = a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
    ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    bb = b[0] * b[0] + b[1] * b[1] + b[2] * b[2]
    if aa < 1e-24:
        if bb * x * x > limit * limit:
            _tighten(room, np.inf, 0.0, -np.inf, 0.0)
        return
    across = max(aa * bb - ab * ab, 0.0)
    square = aa * limit * limit - across * x * x
    if square < 0.0:
        _tighten(room, np.inf, 0.0, -np.inf, 0.0)
        return
    root = np.sqrt(square)
    slope = across * x / max(root, 1e-300)
    _tighten(room, (-ab * x - root) / aa, (slope - ab) / aa, (-ab * x + root) / aa, (-slope - ab) / aa)


@part
def _line(a: float, b: float, x: float, limit: float, room: Array) -> None:
    """Tighten room to the u with |a u + b x| <= limit."""
    if abs(a) < 1e-12:
        if abs(b * x) > limit:
            _tighten(room, np.inf, 0.0, -np.inf, 0.0)
        return
    middle, half, slope = -b * x / a, limit / abs(a), -b / a
    _tighten(room, middle - half, slope, middle + half, slope)


@part
def _room(course: Course, bounds: Bounds, k: int, x: float, ends: Array, top: float, room: Array) -> bool:
    """Accelerations that a step of piece k which begins with square speed x may have; False where there is none.

    ends: (4, n + 6) derivatives A, B at its beginning and at its end, those of the rotation last. top: square speed that
    its end may not pass. Fills room (4,): from, to, and their slopes over x.
    """
    n = course.q.shape[1]
    h = course.pieces.length[k] / course.pieces.steps[k]
    room[0], room[1], room[2], room[3] = -0.5 * x / h, 0.5 * (top - x) / h, -0.5 / h, -0.5 / h
    a, ptp = np.empty(3), course.ptp[k]
    for end in range(2):
        A, B = ends[2 * end], ends[2 * end + 1]
        grow = 2.0 * h * end
        if not ptp:
            for group in range(2):
                first = n + 3 * group
                for r in range(3):
                    a[r] = A[first + r] + grow * B[first + r]
                limit = course.push[k] if group == 0 else bounds.turn_acceleration
                _norm(a, B[first : first + 3], x, limit, room)
        for i in range(n):
            limit = bounds.acceleration[ptp, i]
            if limit < np.inf:
                _line(A[i] + grow * B[i], B[i], x, limit, room)
    return bool(room[0] <= room[1])


@part
def _ends(course: Course, k: int, j: int, ends: Array) -> None:
    """Derivatives (4, n + 6) at both ends of step j of piece k, for `_room`."""
    n, count = course.q.shape[1], course.pieces.steps[k]
    length = course.pieces.length[k]
    for end in range(2):
        _rates(course, k, j + end, ends[2 * end], ends[2 * end + 1])
        share = (j + end) / count
        for r in range(3):
            ends[2 * end, n + 3 + r] = course.turn0[k, r] + share * (course.turn1[k, r] - course.turn0[k, r])
            ends[2 * end + 1, n + 3 + r] = (course.turn1[k, r] - course.turn0[k, r]) / length


@part
def _lower(cap: Array, cause: Indices, node: int, square: float, why: int) -> None:
    if square < cap[node]:
        cap[node], cause[node] = square, why


@kernel(nogil=True)
def cruise(course: Course, bounds: Bounds) -> tuple[Array, Indices]:
    """Square speed (K,) that no node may pass, whatever is before or behind it, and its cause."""
    pieces, n, K = course.pieces, course.q.shape[1], course.q.shape[0]
    cap, cause = np.full(K, np.inf), np.zeros(K, np.int64)
    A, B, before = np.empty(n + 3), np.empty(n + 3), np.empty(n + 6)
    for k in range(pieces.motion.shape[0]):
        for j in range(pieces.steps[k] + 1):
            node = pieces.first[k] + j
            _rates(course, k, j, A, B)
            _lower(cap, cause, node, course.cap[k] ** 2, FEED)
            share = j / pieces.steps[k]
            turn = course.turn0[k] + share * (course.turn1[k] - course.turn0[k])
            rate = np.sqrt(np.sum(turn * turn))
            if rate > 0.0 and not course.ptp[k]:
                _lower(cap, cause, node, (bounds.turn_speed / rate) ** 2, TURN)
            for i in range(n):
                if A[i] != 0.0:
                    _lower(cap, cause, node, (bounds.speed[course.ptp[k], i] / A[i]) ** 2, AXES + i)
            if j == 0 and course.sharp[node]:
                for i in range(n):
                    change = abs(A[i] - before[i]) / bounds.corner
                    if change > 0.0:
                        _lower(cap, cause, node, (bounds.acceleration[0, i] / change) ** 2, AXES + n + i)
                change = np.sqrt(np.sum((A[n:] - before[n : n + 3]) ** 2)) / bounds.corner
                if change > 0.0:
                    _lower(cap, cause, node, (course.push[k] / change) ** 2, TOOL)
                change = np.sqrt(np.sum((turn - before[n + 3 :]) ** 2)) / bounds.corner
                if change > 0.0:
                    _lower(cap, cause, node, (bounds.turn_acceleration / change) ** 2, TURN_UP)
            before[: n + 3], before[n + 3 :] = A, turn
    for node in range(K):
        if course.stop[node]:
            cap[node], cause[node] = 0.0, STOP
    return cap, cause


@part
def _worst(course: Course, bounds: Bounds, k: int, ends: Array) -> int:
    """The cause that bends most against its acceleration in a step of piece k."""
    n = course.q.shape[1]
    worst, why = 0.0, TOOL
    for end in range(2):
        B = ends[2 * end + 1]
        share = np.sqrt(np.sum(B[n : n + 3] ** 2)) / course.push[k]
        if share > worst:
            worst, why = share, TOOL
        share = np.sqrt(np.sum(B[n + 3 :] ** 2)) / bounds.turn_acceleration
        if share > worst:
            worst, why = share, TURN_UP
        for i in range(n):
            share = abs(B[i]) / bounds.acceleration[course.ptp[k], i]
            if share > worst:
                worst, why = share, AXES + n + i
    return why


@part
def _step_back(course: Course, bounds: Bounds, k: int, cap: float, ends: Array, top: float, room: Array) -> float:
    """The highest square speed up to `cap` at the beginning of a step of piece k that may end with up to `top`.

    The width of the room is concave over x: Newton's method comes down from an infeasible x and stays above the answer.
    """
    if _room(course, bounds, k, cap, ends, top, room):
        return cap
    good, bad = 0.0, cap
    for _ in range(_TRIES):
        width, slope = room[1] - room[0], room[3] - room[2]
        x = 0.5 * (good + bad)
        if np.isfinite(width) and slope < 0.0:
            x = max((bad - width / slope) * (1.0 - 1e-9), good)
        if _room(course, bounds, k, x, ends, top, room):
            good = x
            if np.isfinite(width) or bad - good < 1e-9 * bad:
                break
            _room(course, bounds, k, bad, ends, top, room)
        else:
            bad = x
    return good


@kernel(nogil=True)
def brake(course: Course, bounds: Bounds, cap: Array, cause: Indices) -> tuple[Array, Indices]:
    """Highest square speed (K,) at each node from which all that follows can be held, and its cause."""
    pieces = course.pieces
    x, why = cap.copy(), cause.copy()
    ends, room = np.empty((4, course.q.shape[1] + 6)), np.empty(4)
    for k in range(pieces.motion.shape[0] - 1, -1, -1):
        for j in range(pieces.steps[k] - 1, -1, -1):
            node = pieces.first[k] + j
            if cap[node] == 0.0:
                continue
            _ends(course, k, j, ends)
            x[node] = _step_back(course, bounds, k, cap[node], ends, x[node + 1], room)
            if x[node] < cap[node]:
                freely = _room(course, bounds, k, min(1.0001 * x[node] + 1e-12, cap[node]), ends, np.inf, room)
                why[node] = why[node + 1] if freely else _worst(course, bounds, k, ends)
    return x, why


@kernel(nogil=True)
def look_ahead(
    course: Course, bounds: Bounds, x: Array, why: Indices, advance: int, last: Indices, piece: Indices
) -> tuple[Array, Indices]:
    """`brake`'s speeds where the controller knows `advance` motions ahead only, and stops where its knowledge ends.

    last: (M,) the node at which each motion proper ends (its rounding not counted), with the piece (M,) that ends there.
    """
    pieces = course.pieces
    out, cause = x.copy(), why.copy()
    ends, room = np.empty((4, course.q.shape[1] + 6)), np.empty(4)
    motions = last.shape[0]
    k0 = 0
    for m in range(motions):
        k1 = k0
        while k1 < pieces.motion.shape[0] and pieces.motion[k1] == m:
            k1 += 1
        if k1 > k0 and m + advance < motions - 1:
            k, node, square, known = piece[m + advance], last[m + advance], 0.0, False
            while k >= k0 and not known:
                for j in range(pieces.steps[k] - 1, -1, -1):
                    node = pieces.first[k] + j
                    _ends(course, k, j, ends)
                    square = _step_back(course, bounds, k, x[node], ends, square, room)
                    if square >= x[node] * (1.0 - 1e-9):
                        known = True  # from here back nothing is new
                        break
                    if k < k1 and square < out[node]:
                        out[node], cause[node] = square, AHEAD
                k -= 1
        k0 = k1
    return out, cause


@kernel(nogil=True)
def run_up(course: Course, bounds: Bounds, most: Array, why: Indices) -> tuple[Array, Array, Indices]:
    """Square speed x (K,) from rest, as high as it may be below `most`; seconds (K - 1,) a step, and its cause."""
    pieces = course.pieces
    x, seconds, cause = most.copy(), np.empty(max(most.shape[0] - 1, 0)), why[1:].copy()
    ends, room = np.empty((4, course.q.shape[1] + 6)), np.empty(4)
    now = STOP
    for k in range(pieces.motion.shape[0]):
        h = pieces.length[k] / pieces.steps[k]
        for j in range(pieces.steps[k]):
            node = pieces.first[k] + j
            top = most[node + 1]
            _ends(course, k, j, ends)
            u = room[1] if _room(course, bounds, k, x[node], ends, top, room) else 0.5 * (room[0] + room[1])
            if not np.isfinite(u):  # rounding at the very edge of what is possible
                u = 0.5 * (top - x[node]) / h
            reached = min(max(x[node] + 2.0 * h * u, 0.0), top)
            if reached >= top * (1.0 - 1e-9):
                now = why[node + 1]
            x[node + 1], cause[node] = reached, now
            seconds[node] = 2.0 * h / max(np.sqrt(x[node]) + np.sqrt(reached), 1e-12)
    return x, seconds, cause


@kernel(nogil=True)
def where_at(pieces: Pieces, x: Array, arrive: Array, leave: Array, t: Array) -> tuple[Indices, Array, Indices]:
    """Piece (N,), place in it (N,) and node before (N,) at times t (N,), rising, of nodes reached and left (K,) at times."""
    N, P = t.shape[0], pieces.motion.shape[0]
    piece, at, before = np.empty(N, np.int64), np.empty(N), np.empty(N, np.int64)
    k, j = 0, 0
    for i in range(N):
        while k < P - 1 or j < pieces.steps[k] - 1:
            if t[i] < arrive[pieces.first[k] + j + 1]:
                break
            j += 1
            if j == pieces.steps[k]:
                k, j = k + 1, 0
        node = pieces.first[k] + j
        h = pieces.length[k] / pieces.steps[k]
        past = min(max(t[i] - leave[node], 0.0), arrive[node + 1] - leave[node])
        u = 0.5 * (x[node + 1] - x[node]) / h
        way = past * (np.sqrt(x[node]) + 0.5 * u * past)
        piece[i], at[i], before[i] = k, j * h + min(max(way, 0.0), h), node
    return piece, at, before
