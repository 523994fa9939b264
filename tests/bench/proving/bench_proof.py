"""How much better than what was found any posture along a sample could be, proved.

`python tests/bench/proving/bench_proof.py SAMPLE [EPSILON]`
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.inputs import read_inputs
from camrob.redundancy.planning.certificate import certify
from camrob.redundancy.planning.freedoms import plan_space
from camrob.redundancy.planning.waypoints import waypoints
from camrob.redundancy.replanning.one_plan import SPACING

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from proving.proof import EPSILON, prove_path

ROOT = Path(__file__).resolve().parents[3]


def main(sample: str, epsilon: float) -> None:
    """Prove the bound of a sample, and say what it comes to."""
    inputs = read_inputs(
        ROOT / "toolpaths" / sample / f"{sample}.cls", cell_for("post", ROOT / "cells" / "kr15_track_table"), None
    )
    path = inputs.path
    w = waypoints(path, SPACING)
    certificate = certify(plan_space(inputs.cell), w.base_T_tip)
    searched = certificate.along(w.s, w.place)
    start = time.perf_counter()
    proof = prove_path(inputs.cell, path, searched, epsilon=epsilon)
    seconds = time.perf_counter() - start
    cut = np.isfinite(proof.bound)
    length = np.diff(path.length, prepend=0.0)[cut]
    found, proved = (float(np.average(v[cut], weights=length)) for v in (searched, np.asarray(proof.bound)))
    print(
        f"{sample}: {cut.sum()} moves, searched mean 1/k_F {found:.4f}, proved {proved:.4f} "
        f"({100.0 * (proved / found - 1.0):.2f} % more), whole on {100.0 * proof.share:.1f} % of the length, "
        f"{proof.boxes} boxes, {seconds:.0f} s"
    )


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else EPSILON)
