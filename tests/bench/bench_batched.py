"""Time a posture costs: pytorch-kinematics in chunks against the compiled kernels.

Run: OMP_NUM_THREADS=1 python tests/bench/bench_batched.py

Microseconds a posture, 20 000 random postures of the KR15 cell, one thread of a shared 2-core x86 machine (nothing else
could be kept off it: read them as orders of magnitude), torch CPU, float64:

    compiled forward                     0.39 us
    compiled 1/k_F                       0.69 us
    batched forward, chunk 256           6.30 us
    batched Jacobian, chunk 256          7.18 us
    batched 1/k_F, chunk 256             5.21 us
    batched forward, chunk 1024          5.42 us
    batched Jacobian, chunk 1024         5.92 us
    batched 1/k_F, chunk 1024            3.79 us
    batched forward, chunk 4096          8.04 us
    batched Jacobian, chunk 4096         5.99 us
    batched 1/k_F, chunk 4096            3.58 us
    batched forward, chunk 16384        10.20 us
    batched Jacobian, chunk 16384       10.18 us
    batched 1/k_F, chunk 16384           5.19 us
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import perf_counter

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from camrob.cell.read_cell import read_cell  # noqa: E402
from camrob.kinematics import kernels  # noqa: E402
from camrob.kinematics.batched import BatchedKinematics  # noqa: E402


def main(count: int = 20_000) -> None:
    cell = read_cell(ROOT / "cells" / "kr15_track_table")
    chain = kernels.chain_arrays(cell)
    lower = np.where(np.isfinite(cell.q_lower), cell.q_lower, -np.pi)
    upper = np.where(np.isfinite(cell.q_upper), cell.q_upper, np.pi)
    q = np.random.default_rng(0).uniform(lower, upper, (count, len(cell)))
    runs = {
        "compiled forward": lambda: kernels.forward_many(chain, q),
        "compiled 1/k_F": lambda: kernels.inverse_kf_many(chain, q),
    }
    for chunk in (256, 1024, 4096, 16384):
        batched = BatchedKinematics(cell, chunk=chunk)
        runs |= {
            f"batched forward, chunk {chunk}": lambda b=batched: b.forward(q),
            f"batched Jacobian, chunk {chunk}": lambda b=batched: b.jacobian(q),
            f"batched 1/k_F, chunk {chunk}": lambda b=batched: b.inverse_kf(q),
        }
    for name, run in runs.items():
        run()  # compiles, warms up
        times = []
        for _ in range(3):
            start = perf_counter()
            run()
            times.append(perf_counter() - start)
        print(f"{name:34s} {1e6 * min(times) / count:6.2f} us")


if __name__ == "__main__":
    main()
