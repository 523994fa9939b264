"""Mutants of camrob, drawn by rule, posted on small jobs and judged: is anything wrong ever released?

    python tests/bench/mutants.py --count 3000 --results mutants.jsonl     the long run; goes on where it stopped
    python tests/bench/mutants.py --quick --seconds 120                         a selection for every change
    python tests/bench/mutants.py --table                                       writes mutants_table.md and .csv of the results

Exit status 1 where a mutant is released and wrong, or a job of the bench comes out wrong without any mutant.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]  # this checkout's camrob, whichever is installed

from scratch import one_thread, scratch_folder  # noqa: E402


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=3000, help="mutants to run")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=1e9, help="stop drawing new ones after this time")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--most", type=int, default=4, help="jobs a mutant runs on that changes the program")
    parser.add_argument("--results", type=Path, default=Path(tempfile.gettempdir()) / "mutants.jsonl")
    parser.add_argument("--only", nargs="*", help="keys, or parts of keys")
    parser.add_argument(
        "--again", nargs="*", help="run those of the results again that came out so (wrong, valid, ...)"
    )
    parser.add_argument("--quick", action="store_true", help="a fixed selection of the table, results not kept")
    parser.add_argument(
        "--coverage", type=Path, help="keeps which lines each job goes through, which takes minutes to find"
    )
    parser.add_argument("--jobs", nargs="*", help="only these jobs")
    parser.add_argument("--baseline", action="store_true", help="only the jobs without any mutant")
    parser.add_argument("--table", action="store_true", help="write the table of the results and end")
    options = parser.parse_args()
    one_thread()
    from mutation import report

    if options.table:
        report.write(options.results, report.TABLE)
        return 0
    with scratch_folder("mutants") as root:
        return _run(options, root)


def _run(options: argparse.Namespace, root: Path) -> int:
    from mutation import report
    from mutation.apply import load, touched_kernels
    from mutation.draw import ordered
    from mutation.jobs import all_jobs
    from mutation.posting import Bench
    from mutation.run import Warm, run_all, warm_up

    started = time.time()

    def say(text: str) -> None:
        print(f"{time.time() - started:7.1f} s  {text}", file=sys.stderr, flush=True)

    every, only, does = all_jobs(), {}, {}
    listed = report.quick(report.TABLE.with_suffix(".csv"), options.seed) if options.quick else []
    package = load({key.split(".")[0] for key, _, _ in listed} if options.quick else None)
    if options.quick:
        there = {m.key for source in package.sources.values() for m in source.mutants}
        gone = sum(key not in there for key, _, _ in listed)
        say(f"{gone} of {len(listed)} mutants of the table are not in the source any more")
        listed = [row for row in listed if row[0] in there and row[1] in every][: report.QUICK]
        only, does = {key: [job] for key, job, _ in listed}, {key: what for key, _, what in listed}
        wanted = {job for jobs in only.values() for job in jobs}
    else:
        wanted = {n for n in every if not options.jobs or any(part in n for part in options.jobs)}
    mutants = ordered([m for s in package.sources.values() for m in s.mutants], options.seed, package.kernels)
    wanted |= {every[n].before for n in wanted if every[n].before}
    bench = Bench(root, {n: j for n, j in every.items() if n in wanted})
    baselines, coverage, unfit = warm_up(package, bench, say, trace=not options.quick, kept=options.coverage)
    for name, why in unfit.items():
        say(f"not used: {name}: {why}")
    if options.baseline:
        return 1 if unfit else 0
    total = len(mutants)
    warm = Warm(package, bench, baselines, coverage, options.seed, options.most, only, does)
    if options.quick:
        results, by_key = root / "results.jsonl", {m.key: m for m in mutants}
        mutants = [by_key[key] for key in only if not touched_kernels(package, by_key[key])]
    else:
        results = options.results
        mutants = report.chosen(mutants, results, options, warm)
    say(f"{total} mutants drawn, {len(mutants)} to run on {len(baselines)} jobs")
    run_all(warm, mutants, results, options.processes, started + options.seconds, say)
    wrong = report.summary(results, say)
    return 1 if wrong or unfit else 0


if __name__ == "__main__":
    sys.exit(main())
