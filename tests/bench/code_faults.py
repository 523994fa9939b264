"""Faults put into camrob by hand, one at a time, on the jobs of the mutants' bench: is a wrong program ever released?

    python tests/bench/code_faults.py [--only PATTERN] [--everywhere]

What a programmer does wrong and no operator of `mutants.py` draws: units, signs, orders, numbers of tables, what comes before or
behind what (`mutation/by_hand.toml`). A fault is tried on its own jobs, with --everywhere on all of the bench but the slow ones.
Those of RAPID are tried on the post of `rapid_job`, of which no other statement may be released. Exit status 1 where a program is
released and wrong, where a fault shows on none of its jobs, or where it no longer fits its source.

On 2026-11-27, of 212 faults 199 are stopped, 13 leave the program right in another way (so the bench's judge), none is wrong.
Some 80 ran --everywhere; what the judge calls wrong there was looked at, and is right: SLIN rounded by C_DIS, as KSS has it;
a PTP in the clear; the way straight down past a first place that the file comes to from where only its machine knows.
"""

from __future__ import annotations

import argparse
import importlib
import re
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1]), str(HERE.parent)]  # this checkout's camrob, whichever is installed

from scratch import one_thread, scratch_folder  # noqa: E402


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="faults in whose name or file this is found (a regular expression)")
    parser.add_argument("--everywhere", action="store_true", help="on every job of the bench that is no slow one")
    options = parser.parse_args()
    one_thread()
    with scratch_folder("faults") as root:
        return _run(options, root)


def _run(options: argparse.Namespace, root: Path) -> int:
    from mutation.apply import load
    from mutation.jobs import all_jobs
    from mutation.posting import Bench
    from mutation.put_in import faults, posted, posted_as_rapid
    from mutation.report import SLOW_JOBS
    from mutation.run import Warm, warm_up

    started = time.time()

    def say(text: str) -> None:
        print(f"{time.time() - started:7.1f} s  {text}", flush=True)

    chosen = [f for f in faults() if re.search(options.only, f"{f.name} {f.file}")]
    for fault in chosen:
        importlib.import_module("camrob." + fault.file.removesuffix(".py").replace("/", "."))
    package, every = load(only=()), all_jobs()
    general = [n for n, job in every.items() if not job.refuse and n not in SLOW_JOBS] if options.everywhere else []
    wanted = {n for f in chosen for n in (*f.jobs, *(() if f.rapid else general))}
    bench = Bench(root, {n: every[n] for n in every if n in wanted})
    baselines, _, unfit = warm_up(package, bench, lambda text: None, trace=False)
    for name, why in unfit.items():
        say(f"not used: {name}: {why}")
    warm = Warm(package, bench, baselines, {}, seed=1, most=len(every))
    bad = len(unfit)
    for fault in chosen:
        if fault.rapid:
            outcome, text = posted_as_rapid(package, fault, root)
        else:
            outcome, text = posted(warm, fault, [*fault.jobs, *(n for n in general if n not in fault.jobs)])
        wrong = outcome not in ("stopped", "valid")
        bad += wrong
        say(f"{'!! ' if wrong else '   '}{outcome:9s} {fault.name}: {text[:150]}")
    say(f"{len(chosen)} faults, {bad} wrong")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
