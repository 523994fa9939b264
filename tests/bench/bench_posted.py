"""What the planner posts, beside what its knee alone would: the samples, and the 36 drawn paths of `path_family`, beside which
two of the rule's three allowances were set.

`python tests/bench/bench_posted.py [PATH ...] [--to FILE.md]`; PATH: a sample's name or `family`. One process; with kernels
compiled some 10 minutes of one core for all. Price: the planner's objective, travel in full; feed held: the share of the cutting
on which the programmed feed is held; within limits: time with each cut slowed evenly until jerk is kept, too. Two numbers: by
the knee alone, and as posted.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT), str(HERE)]

from path_family import family  # noqa: E402

from camrob.cell.read_cell import read_cell  # noqa: E402
from camrob.jobs.files.cell_for import cell_for  # noqa: E402
from camrob.jobs.files.inputs import read_inputs  # noqa: E402
from camrob.jobs.solving.plan_obstacles import job_obstacles  # noqa: E402
from camrob.jobs.solving.plan_run import job_run  # noqa: E402
from camrob.redundancy.planned import resolve_planned  # noqa: E402

CELL = ROOT / "cells" / "kr15_track_table"
SAMPLES = ("engraving", "carving", "relief", "globe")
RAPID = 0.2  # m/s in air, of the drawn paths
HEAD = (
    "| path | taken: knee, posted | price, m | lowest 1/k_F | mean | E1 mm, E2 deg while cutting | s | feed held % | s within "
    "limits | seconds of planning |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
)


def cases(names: list[str]) -> Iterator[tuple[str, Any, Any, Any, float]]:
    """Name, cell, path, obstacles and rapid speed of what is planned."""
    for name in names:
        if name == "family":
            cell = read_cell(CELL)
            for member in family(cell):
                yield f"{member.kind} {member.seed}", cell, member.path, None, RAPID
        else:
            inputs = read_inputs(ROOT / "toolpaths" / name / f"{name}.cls", cell_for("post", CELL), None)
            yield name, inputs.cell, inputs.path, job_obstacles(inputs), inputs.rapid_speed


def planned(cell: Any, path: Any, obstacles: Any, rapid: float, run: Any) -> dict[str, Any]:
    """One plan, and what it comes to."""
    begun = time.process_time()
    solution = resolve_planned(cell, path, obstacles=obstacles, run=run)
    seconds = time.process_time() - begun
    whole, q = solution.path or path, np.asarray(solution.q)
    length = np.diff(np.asarray(whole.length), prepend=0.0) * whole.cutting
    moved = np.abs(np.diff(q, axis=0))[whole.cutting[1:]].sum(axis=0)
    ran = job_run(cell, rapid)(whole, solution)
    touches = 0 if obstacles is None else int(np.sum(obstacles(whole, solution)))
    plan = solution.plan
    return {
        "name": "published" if plan is None else plan.chosen,
        "price": np.nan if plan is None else sum(plan.terms.values()),
        "low": solution.inv_kf[length > 0.0].min(),
        "mean": np.average(solution.inv_kf, weights=length),
        "E1": 1e3 * moved[cell.index("E1")],
        "E2": np.degrees(moved[cell.index("E2")]),
        "s": ran.seconds,
        "held": 100.0 * ran.held,
        "within": ran.within_limits,
        "planning": seconds,
        "touches": touches,
    }


def row(name: str, a: dict[str, Any], b: dict[str, Any]) -> str:
    """Before and after in one line; what is alike once."""

    def both(key: str, form: str) -> str:
        one, other = (form.format(x[key]) for x in (a, b))
        return one if one == other else f"{one}, {other}"

    travel = " to ".join(dict.fromkeys(f"{x['E1']:.0f}, {x['E2']:.0f}" for x in (a, b)))
    return (
        f"| {name} | {both('name', '{}')} | {both('price', '{:.4f}')} | {both('low', '{:.4f}')} | {both('mean', '{:.4f}')} "
        f"| {travel} | {both('s', '{:.1f}')} | {both('held', '{:.1f}')} "
        f"| {both('within', '{:.0f}')} | {both('planning', '{:.1f}')} |"
    )


def main(names: list[str], to: Path | None) -> None:
    """Plan all, print and write the table."""
    rows = ["# What is posted, beside what the knee alone would take\n", __doc__.split("\n\n")[1].rstrip() + "\n", HEAD]
    print(HEAD, flush=True)
    for name, cell, path, obstacles, rapid in cases(names):
        ways = [planned(cell, path, obstacles, rapid, run) for run in (None, job_run(cell, rapid))]
        rows.append(row(name, *ways))
        print(rows[-1], "touches", *(w["touches"] for w in ways), flush=True)
    if to is not None:
        to.write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("paths", nargs="*", default=[*SAMPLES, "family"])
    parser.add_argument("--to", type=Path)
    given = parser.parse_args()
    main(given.paths, given.to)
