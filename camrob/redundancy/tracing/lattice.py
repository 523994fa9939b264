"""Postures of a path's poses over a lattice of the freedoms: those that keep the limits and have room."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.room import Room, RoomWork, has_room, room_work
from camrob.compiled import kernel, part
from camrob.kinematics.freed_chain import FreedChain, postures_at
from camrob.kinematics.spherical_wrist import BRANCH_OK

__all__ = ["lattice_postures"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@part
def _work(room: Room | None) -> RoomWork | None:
    if room is None:
        return None
    work: RoomWork = room_work(room)
    return work


@part
def _gap(room: Room | None, q: Array, wanted: float, work: RoomWork | None) -> float:
    """The room of a posture up to `wanted`, which is what there is where nothing can be touched."""
    if room is None:
        return wanted
    return float(has_room(room, q, wanted, work))


@part
def _with_turns(chain: FreedChain, one: Array, gap: float, q: Array, clear: Array, M: int) -> int:
    """Write the posture into row M of q, and below it its whole turns within limits; returns the next free row."""
    first = M
    if M < q.shape[0]:
        q[M], clear[M] = one, gap
        M += 1
    for i in range(6):
        j = chain.six[i]
        if chain.endless[j]:
            continue
        stop = M
        for sign in (-1.0, 1.0):
            other = one[j] + sign * 2.0 * np.pi
            if chain.lower[j] <= other <= chain.upper[j]:
                for row in range(first, stop):
                    if M < q.shape[0]:
                        q[M], clear[M] = q[row], gap
                        q[M, j] = other
                        M += 1
    return M


@kernel(nogil=True)
def lattice_postures(
    chain: FreedChain,
    room: Room | None,
    poses: Array,
    start: Ints,
    u: Array,
    near: Array,
    band: float,
    wanted: float,
    most: int,
) -> tuple[Array, Array, Ints, Array]:
    """Postures q (M, n), their room (M,), m up to `wanted`, the number of each pose's (T,), and why others were not taken (T, 3):
    how many were out of reach, past a limit, and without room.

    poses (T, 4, 4) of the tool in `base`; u (G, k): values of the freedoms, pose t's are rows start[t] .. start[t + 1]. Angles
    are those nearest to near (T, n), and whole turns beside them where the limits leave more than one; candidates of which an
    axis that was solved for is farther than `band` from there are left out.
    """
    T, n, k = poses.shape[0], chain.prismatic.shape[0], chain.given.shape[0]
    Q, why, R, p = np.empty((8, 6)), np.empty(8, np.int64), np.empty((3, 3)), np.empty(3)
    q = np.empty((most, n))
    clear = np.empty(most)
    count, lost = np.zeros(T, np.int64), np.zeros((T, 3))
    work = _work(room)
    M = 0
    one = chain.center.copy()
    for t in range(T):
        before = M
        for r in range(3):
            p[r] = poses[t, r, 3]
            for c in range(3):
                R[r, c] = poses[t, r, c]
        for g in range(start[t], start[t + 1]):
            for i in range(k):
                one[chain.given[i]] = u[g, i]
            for i in range(6):
                one[chain.six[i]] = near[t, chain.six[i]]
            if postures_at(chain, R, p, one, Q, why) == 0:
                lost[t, 0] += 1.0
                continue
            for b in range(8):
                if why[b] != BRANCH_OK:
                    continue
                inside, far = True, 0.0
                for i in range(6):
                    j = chain.six[i]
                    one[j] = Q[b, i]
                    far = max(far, abs(Q[b, i] - near[t, j]))
                    inside = inside and chain.lower[j] <= Q[b, i] <= chain.upper[j]
                if far > band:
                    continue
                if not inside:
                    lost[t, 1] += 1.0
                    continue
                gap = _gap(room, one, wanted, work)
                if gap <= 0.0:
                    lost[t, 2] += 1.0
                    continue
                M = _with_turns(chain, one, gap, q, clear, M)
        count[t] = M - before
    return q[:M], clear[:M], count, lost
