"""Legal CL files drawn at random, posted, and held to what was drawn: all have to come out, and right.

    python tests/bench/legal_files.py --count 100                    so many jobs, each in every dialect
    python tests/bench/legal_files.py --show nx/17                   one of them: its text and what came of it
    python tests/bench/legal_files.py --count 40 --dialects gcode

A job is drawn as what the tool does (`legal/plan.py`), written down by each dialect's own rules (`legal/dialects.py`), and the
program that camrob releases is judged by the judge of the mutants, which shares nothing with camrob. Exit status 1 where a
program is wrong, or a file is refused that shouldn't be.
"""

from __future__ import annotations

import argparse
import random
import shutil
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]  # this checkout's camrob, whichever is installed

from scratch import one_thread  # noqa: E402

# what a drawn job may run into for a reason of its own: the arm's reach, its limits, an axis that can't follow, its bodies
RIGHTLY = ("can't be reached", "limit", "faster than", "would have to run at", "touches")
NEVER = ("fault of camrob", "error in camrob")


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0, help="the first job's")
    parser.add_argument("--dialects", nargs="*")
    parser.add_argument("--show", help="dialect/seed")
    options = parser.parse_args()
    one_thread()
    from legal.dialects import DIALECTS

    cases = [(d, options.seed + k) for k in range(options.count) for d in options.dialects or DIALECTS]
    if options.show:
        dialect, seed = options.show.split("/")
        cases = [(dialect, int(seed))]
    folder = Path(tempfile.mkdtemp(prefix="legal_files"))
    try:
        return _run(cases, folder, bool(options.show))
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _run(cases: list[tuple[str, int]], folder: Path, show: bool) -> int:
    from legal.dialects import DIALECTS
    from legal.plan import draw, told
    from mutation.jobs import Job
    from mutation.posting import Bench
    from mutation.truth import judge

    came: Counter[str] = Counter()
    started = time.time()
    for number, (name, seed) in enumerate(cases, start=1):
        dialect, rng = DIALECTS[name], random.Random(seed)
        steps = draw(rng, dialect.able)
        place = (
            *(round(rng.uniform(-60, 60), 1) for _ in range(2)),
            round(rng.uniform(180, 260), 1),
            round(rng.uniform(-180, 180), 2),
            round(rng.uniform(-8, 8), 2),
            round(rng.uniform(-8, 8), 2),
        )
        text = dialect.write(rng, steps)
        setup = f"part_in_base = [{', '.join(f'{v:g}' for v in place)}]\n"
        job = Job(f"{name}-{seed}", f"drawn{dialect.suffix}", text, told(steps, place, dialect.plane), setup)
        bench = Bench(folder / job.name, {job.name: job})
        outcome = bench.run(job.name, folder / job.name / "out")
        rules = job.rules()
        found = outcome.error
        if outcome.status == "released" and rules is not None:
            found = "; ".join(f"{kind}: {fault}" for kind, fault in judge(outcome.files, job.program, rules).faults[:2])
            kind = "WRONG" if found else "released"
        else:
            rightly = (
                outcome.status == "refused"
                and any(word in found for word in RIGHTLY)
                and not any(word in found for word in NEVER)
            )
            kind = "rightly refused" if rightly else "REFUSED"
        came[f"{kind} {outcome.said if kind == 'released' and 'part' in outcome.said else ''}".strip()] += 1
        if show:
            print(text, *(data.decode("latin-1") for data in outcome.files.values()), sep="\n")
        if kind != "released":
            print(f"{kind} {name}/{seed}: {found[:400]}", flush=True)
        shutil.rmtree(folder / job.name, ignore_errors=True)
        if number % 20 == 0:
            print(f"{time.time() - started:.0f} s  {number} of {len(cases)}", file=sys.stderr, flush=True)
    print(", ".join(f"{count} {kind}" for kind, count in sorted(came.items())))
    return 1 if came["WRONG"] + came["REFUSED"] else 0


if __name__ == "__main__":
    sys.exit(main())
