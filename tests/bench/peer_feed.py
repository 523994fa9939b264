"""COPP in its own environment: the fastest squares of speed along a path under bounds on speed and acceleration of its axes.

Run by `bench_peers.py`: peer_feed.py PATH.npz OUT.npz; needs no camrob. Given are stations s (K + 1,), q and its derivatives
there, bounds (n,); written is a = (ds/dt)^2 at the stations, by its reachability analysis (`topp2_ra`).
"""

from __future__ import annotations

import sys
from time import thread_time

import numpy as np


def main(path, out):
    import copp_py as copp

    given = np.load(path)
    s, count = given["s"], len(given["s"])
    begin = thread_time()
    robot = copp.Robot(given["q"].shape[1], capacity=count)
    robot.append_s(s)
    robot.set_q(given["q"], given["dq"], given["ddq"], 0)
    robot.add_velocity_limits(given["speed"], -given["speed"], start_idx_s=0, length=count)
    robot.add_acceleration_limits(given["acceleration"], -given["acceleration"], start_idx_s=0, length=count)
    problem = copp.solver.topp2_ra.Problem(robot.constraints, idx_s_interval=(0, count - 1), a_boundary=(0.0, 0.0))
    a = copp.solver.topp2_ra.solve(problem, copp.solver.topp2_ra.Options())
    np.savez(out, a=np.asarray(a), seconds=thread_time() - begin, version=copp.version())


if __name__ == "__main__":
    main(*sys.argv[1:])
