"""Time a point costs: the follower against the bare floor (forward kinematics, Jacobian, one 6x6 solve), one core.

Run: OMP_NUM_THREADS=1 python tests/bench/bench_follower.py [POINTS]

Least times over repeats, since other work shares the machine; the ratio is of runs in turn, so that both meet the same.
"""

from __future__ import annotations

import os
import sys
from importlib.metadata import version
from pathlib import Path
from time import thread_time

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from spiral import poses, spiral  # noqa: E402

from camrob.cell.joint import Role  # noqa: E402
from camrob.cell.read_cell import read_cell  # noqa: E402
from camrob.compiled import kernel  # noqa: E402
from camrob.kinematics.frames import base_T_tool  # noqa: E402
from camrob.kinematics.kernels import chain_arrays, forward, jacobian  # noqa: E402
from camrob.redundancy.following.follower import FOLLOWED, FollowerSettings, FollowState, follow_path  # noqa: E402
from camrob.redundancy.fuzzy.surfaces import compile_surface  # noqa: E402
from camrob.redundancy.published.virtual_joint import SELF_RATIO  # noqa: E402
from camrob.se3 import inverse, rotation_log  # noqa: E402

REPEATS = 7


@kernel
def floor(chain, q, targets, out):
    """Once a point: forward kinematics, Jacobian, J J^T by Cholesky, a step; the least that any follower of poses does."""
    n = q.shape[1]
    Z, P, J = np.empty((n, 3)), np.empty((n, 3)), np.empty((6, n))
    R, p, plate = np.empty((3, 3)), np.empty(3), np.empty(3)
    L, e = np.empty((6, 6)), np.empty(6)
    for k in range(q.shape[0]):
        forward(chain, q[k], Z, P, R, p, plate)
        jacobian(chain, Z, P, p, J)
        T = targets[k]
        for r in range(3):
            e[r] = T[r, 3] - p[r]
            e[3 + r] = 0.0
        for c in range(3):
            e[3] += 0.5 * (R[1, c] * T[2, c] - R[2, c] * T[1, c])
            e[4] += 0.5 * (R[2, c] * T[0, c] - R[0, c] * T[2, c])
            e[5] += 0.5 * (R[0, c] * T[1, c] - R[1, c] * T[0, c])
        for r in range(6):
            for c in range(r + 1):
                s = 0.0
                for i in range(n):
                    s += J[r, i] * J[c, i]
                for i in range(c):
                    s -= L[r, i] * L[c, i]
                L[r, c] = np.sqrt(s) if r == c else s / L[c, c]
        for r in range(6):
            for i in range(r):
                e[r] -= L[r, i] * e[i]
            e[r] /= L[r, r]
        for r in range(5, -1, -1):
            for i in range(r + 1, 6):
                e[r] -= L[i, r] * e[i]
            e[r] /= L[r, r]
        for i in range(n):
            s = q[k, i]
            for r in range(6):
                s += J[r, i] * e[r]
            out[k, i] = s


def setting(count):
    """The cell, its chain, the spiral's poses, and the follower's settings with and without a threshold always met."""
    cell = read_cell(ROOT / "cells" / "kr15_track_table")
    targets = poses(*spiral(count))
    surfaces = [compile_surface(cell, e) for e in (cell.resolve.joint_engine, cell.resolve.condition_engine)]
    free = np.zeros(len(cell), np.bool_)
    settings = FollowerSettings(cell.q_lower, cell.q_upper, cell.endless, *surfaces, cell.resolve.threshold, free)
    return cell, chain_arrays(cell), targets, settings


def bounds(cell, targets):
    """(N, n) what `PathFollower` allows self-motion at each point, speeds left out."""
    step = np.linalg.norm(np.diff(targets[:, :3, 3], axis=0, prepend=targets[:1, :3, 3]), axis=1)
    axis = targets[:, :3, 2]
    turn = np.arccos(np.clip(np.sum(axis * np.vstack([axis[:1], axis[:-1]]), axis=1), -1.0, 1.0))
    length = cell.condition_length
    slides = np.array([j.prismatic for j in cell.joints])
    out = SELF_RATIO * np.where(slides, (step + length * turn)[:, None], (step / length + turn)[:, None])
    out[0] = np.inf
    return out


def run(cell, chain, settings, targets, limits, start):
    """Postures (N, n) and 1/k_F (N,) along the poses, and the seconds that `follow_path` took."""
    n, N = len(cell), len(targets)
    state = FollowState(start.copy(), start.copy(), np.zeros(n, np.int64), np.zeros(2, np.int64))
    q, inv_kf = np.empty((N, n)), np.empty(N)
    reference = cell.q_reference[None].copy()
    begin = thread_time()
    code, reached = follow_path(chain, settings, targets, reference, state, limits, q, inv_kf)
    seconds = thread_time() - begin
    if code != FOLLOWED:
        raise SystemExit(f"not followed: code {code} at point {reached}")
    return q, inv_kf, seconds


def quality(cell, targets, q, inv_kf):
    """What stands beside the time: worst errors, largest joint step, conditioning, external travel."""
    T = inverse(targets) @ base_T_tool(cell, q)
    step = np.abs(np.diff(q, axis=0))
    e1, e2 = cell.indices(Role.CARRIAGE)[0], cell.indices(Role.WORKPIECE)[0]
    return {
        "error mm": 1e3 * np.linalg.norm(T[:, :3, 3], axis=1).max(),
        "error deg": np.degrees(np.linalg.norm(rotation_log(T[:, :3, :3]), axis=1).max()),
        "step deg": np.degrees(np.delete(step, e1, axis=1).max()),
        "step mm": 1e3 * step[:, e1].max(),
        "1/k_F min": inv_kf.min(),
        "1/k_F mean": inv_kf.mean(),
        "E1 mm": 1e3 * step[:, e1].sum(),
        "E2 deg": np.degrees(step[:, e2].sum()),
    }


def main(count: int = 100_000) -> None:
    cell, chain, targets, settings = setting(count)
    limits = bounds(cell, targets)
    start = run(cell, chain, settings, targets[:1], np.full((1, len(cell)), np.inf), cell.q_home)[0][0]
    q, inv_kf, _ = run(cell, chain, settings, targets, limits, start)
    forced = settings._replace(threshold=1.0)
    q_forced, inv_kf_forced, _ = run(cell, chain, forced, targets, limits, start)
    stepped = np.empty_like(q)
    floor(chain, q, targets, stepped)
    assert np.abs(stepped - q).max() < 1e-9  # the floor is real: it stays where the pose is met
    times = {"floor": [], "follower": [], "follower, k_F term always on": []}
    for _ in range(REPEATS):
        begin = thread_time()
        floor(chain, q, targets, stepped)
        times["floor"].append(thread_time() - begin)
        times["follower"].append(run(cell, chain, settings, targets, limits, start)[2])
        times["follower, k_F term always on"].append(run(cell, chain, forced, targets, limits, start)[2])
    print(f"{count} points, numpy {np.__version__}, numba {version('numba')}, load {os.getloadavg()[0]:.1f}")
    least = min(times["floor"])
    for name, seconds in times.items():
        print(f"  {name:28s} {1e6 * min(seconds) / count:6.2f} us a point, {min(seconds) / least:5.2f} of the floor")
    for name, result in (("follower", (q, inv_kf)), ("always on", (q_forced, inv_kf_forced))):
        print(f"  {name}: " + ", ".join(f"{k} {v:.4g}" for k, v in quality(cell, targets, *result).items()))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
