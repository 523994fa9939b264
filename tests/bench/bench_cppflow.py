"""CppFlow's 13 planning problems, obstacles on, on the CPU: `python tests/bench/bench_cppflow.py`; needs ../shared/benchmarks.

Each problem becomes a cell (`camrob cell from-urdf`'s reader, capsules, obstacles), is traced (`camrob/redundancy/tracing`), and
the postures are judged by Pinocchio and Coal (`cppflow_judge`). One problem is traced once before, so that nothing is compiled in
the seconds that are told. --only NAME ..; --table FILE writes the rows as Markdown.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
from cppflow_judge import Verdict, judge
from cppflow_problems import NAMES, Problem, build_cell, read_problem

from camrob.bodies.room import cell_room
from camrob.errors import JobError
from camrob.redundancy.tracing.traced import Trace, trace_poses

SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "benchmarks"
COLUMNS = (
    "problem|poses|solved|length rad|length m|largest step deg|largest step cm|least room mm|error mm, deg|s".split("|")
)


def traced(problem: Problem, folder: Path) -> tuple[Trace | None, str, float]:
    """The trace of a problem, or why there is none, and the seconds of one core that it took."""
    cell = build_cell(problem, SHARED, folder)
    begin = time.process_time()
    try:
        found, why = trace_poses(cell, problem.world_T_tip, room=cell_room(cell)), ""
    except JobError as error:
        found, why = None, str(error)
    return found, why, time.process_time() - begin


def row(problem: Problem, verdict: Verdict | None, why: str, seconds: float) -> str:
    """A line of the table."""
    if verdict is None:
        return f"| {problem.name} | {len(problem.world_T_tip)} | no: {why} | | | | | | | {seconds:.1f} |"
    room = 1e3 * min(verdict.own, verdict.obstacles)
    return (
        f"| {problem.name} | {len(problem.world_T_tip)} | {'yes' if verdict.solved else 'NO'} | {verdict.length:.2f} | "
        f"{verdict.slid:.3f} | {np.degrees(verdict.step):.2f} | {100 * verdict.slide:.2f} | {room:.1f} | "
        f"{1e3 * verdict.position:.0e}, {np.degrees(verdict.angle):.0e} | {seconds:.1f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="*", default=NAMES)
    parser.add_argument("--table", type=Path)
    given = parser.parse_args()
    lines = [f"| {' | '.join(cells)} |" for cells in (COLUMNS, ["---"] * len(COLUMNS))]
    with tempfile.TemporaryDirectory() as scratch:
        traced(read_problem("panda__1cube", SHARED), Path(scratch) / "first")
        print(*lines, sep="\n")
        solved = 0
        for name in given.only:
            problem = read_problem(name, SHARED)
            found, why, seconds = traced(problem, Path(scratch) / name)
            verdict = None if found is None else judge(problem, np.asarray(found.q), SHARED)
            solved += verdict is not None and verdict.solved
            lines.append(row(problem, verdict, why, seconds))
            print(lines[-1], flush=True)
    lines += ["", f"{solved} of {len(given.only)} solved."]
    print(*lines[-2:], sep="\n")
    if given.table:
        given.table.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
