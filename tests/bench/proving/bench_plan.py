"""How far a sample's plan may be above the best that exists, by the planner's own objective, proved.

`python tests/bench/proving/bench_plan.py SAMPLE [TARGET] [LEVELS] [FILE.npz]`; TARGET: the share of the best plan's price that is
aimed at; FILE.npz: the certificate, which `check_plan.py` proves again.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.inputs import read_inputs
from camrob.redundancy.clock import Clock
from camrob.redundancy.planning.choice import plan_terms
from camrob.redundancy.planning.course import Draft, relaxed
from camrob.redundancy.planning.freedoms import conditioning, plan_space, plan_work
from camrob.redundancy.planning.objective import Objective, plan_weights
from camrob.redundancy.replanning.one_plan import Plan, Task, make_plan

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from proving.plan_certificate import write_certificate
from proving.whole_plan import Level, prove_plan

ROOT = Path(__file__).resolve().parents[3]
_ABOVE_BEST, _ABOVE_PLAN = 1.3, 1.15  # times the place's best and the plan's: dearer postures are passed over


def main(sample: str, share: float, levels: int, to: Path | None) -> None:
    """Plan a sample, prove a bound of its price, and say what it comes to."""
    inputs = read_inputs(
        ROOT / "toolpaths" / sample / f"{sample}.cls", cell_for("post", ROOT / "cells" / "kr15_track_table"), None
    )
    cell, space = inputs.cell, plan_space(inputs.cell)
    objective = Objective.of(cell, space, plan_weights(cell))
    plan = make_plan(Task(cell, space, "knee", None, Clock(None)), inputs.path, objective, lambda share: None)
    if not isinstance(plan, Plan):
        raise SystemExit(f"{sample}: no plan in one piece")
    land = plan.land
    drafts = [p.draft for p in plan.curve]
    drafts += [relaxed(space, objective, land.w, d, 1.0) for d in drafts]
    prices = [sum(plan_terms(space, objective, land.w, d).values()) for d in drafts]
    best, taken = int(np.argmin(prices)), prices[plan.choice.curve_index]
    print(f"{sample}: {len(land.w)} waypoints; plan taken {taken:.4f} m, best found {prices[best]:.4f} m", flush=True)
    print("  " + ", ".join(f"{n} {v:.4f}" for n, v in plan_terms(space, objective, land.w, drafts[best]).items()))
    most = _most(plan, objective, drafts[best])
    start, processor = time.perf_counter(), time.process_time()
    told: list[dict[str, NDArray[np.float64] | NDArray[np.int64]]] = []
    proof = prove_plan(cell, objective, land.w, most, share * prices[best], levels=levels, say=_say, told=told)
    if to is not None:
        write_certificate(to, cell, objective, land.w, most, told)
    print(
        f"{sample}: proved {proof.bound:.4f} m: best found within {100.0 * proof.gap(prices[best]):.2f} %, plan taken within "
        f"{100.0 * proof.gap(taken):.2f} % of the best that exists; {time.process_time() - processor:.0f} s of one core, "
        f"{time.perf_counter() - start:.0f} s in all"
    )


def _most(plan: Plan, objective: Objective, draft: Draft) -> NDArray[np.float64]:
    """(W,) prices of a metre above which postures are passed over."""
    work = plan_work()
    values = np.array([conditioning(plan.land.space, q, work) for q in np.ascontiguousarray(draft.q)])
    own = np.zeros(len(plan.land.w))
    np.maximum.at(own, draft.index, (objective.threshold / values) ** objective.power)
    found = (objective.threshold / np.asarray(plan.land.certificate.inv_kf)) ** objective.power
    return objective.conditioning * np.maximum(_ABOVE_BEST * found, _ABOVE_PLAN * own)


def _say(level: Level) -> None:
    print(
        f"  {level.cells} cells, {level.left} left, {level.bins} bins, {level.planes} planes, bound {level.bound:.4f} m, "
        f"{level.seconds:.0f} s",
        flush=True,
    )


if __name__ == "__main__":
    given = [*sys.argv[1:], *[None] * 4]
    main(given[0], float(given[1] or 0.99), int(given[2] or 5), Path(given[3]) if given[3] else None)
