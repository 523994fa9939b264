"""One closed form in its own environment: all postures of six-axis poses, and the seconds that they took.

Run by `bench_peers.py` with each environment's own Python: peer_closed_forms.py PEER ARM.npz OUT.npz; needs no camrob. The arm is
given by axes H (6, 3) and ways P (7, 3) in its zero posture, the poses (N, 4, 4) have that posture's rotation taken off, so that
all peers speak of the same one.
"""

from __future__ import annotations

import sys
from importlib.metadata import version
from time import thread_time

import numpy as np

MOST = 16
"""Postures of six axes at most."""


def with_eaik(H, P, poses):
    """EAIK, a pose a call from Python; what it calls a least-squares answer is left out."""
    from eaik.IK_HP import HPRobot

    robot = HPRobot(H, P)
    poses = [np.array(T) for T in poses]
    begin = thread_time()
    answers = [robot.IK(T) for T in poses]
    seconds = thread_time() - begin
    found = [[q for q, least in zip(a.Q, a.is_LS, strict=True) if not least] for a in answers]
    return found, seconds, version("eaik")


def with_ssik(H, P, poses):
    """ssik, a pose a call, without its refinement and without limits."""
    import ssik

    arm = ssik.Manipulator.from_axes(H, P)
    arm.solve(poses[0], respect_limits=False)
    begin = thread_time()
    answers = [arm.solve(T, respect_limits=False, enumerate_windings=False) for T in poses]
    seconds = thread_time() - begin
    return [[s.q for s in a] for a in answers], seconds, version("ssik")


PEERS = {"eaik": with_eaik, "ssik": with_ssik}


def main(peer, arm, out):
    given = np.load(arm)
    found, seconds, told = PEERS[peer](given["H"], given["P"], given["poses"])
    Q = np.full((len(found), MOST, 6), np.nan)
    for k, some in enumerate(found):
        for b, q in enumerate(some[:MOST]):
            Q[k, b] = q
    np.savez(out, Q=Q, seconds=seconds, version=told)


if __name__ == "__main__":
    main(*sys.argv[1:])
