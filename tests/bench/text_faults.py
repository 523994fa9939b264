"""Faults in program text for `verify`, drawn by rule over the program's syntax tree, and legal rewrites that have to pass.

    python tests/bench/text_faults.py --results text_faults.jsonl      all of them, some minutes
    python tests/bench/text_faults.py --only spindle --jobs tools           those whose key has a word in it
    python tests/bench/text_faults.py --show a-digit/arcs/0                 one, with the text that it makes
    python tests/bench/text_faults.py --table                               writes text_faults_table.md of the results

Exit status 1 where a fault passes or a legal rewrite is refused.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from scratch import one_thread, scratch_folder  # noqa: E402


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", type=Path, default=Path(tempfile.gettempdir()) / "text_faults.jsonl")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--times", type=int, default=1, help="how often every rule is drawn")
    parser.add_argument("--jobs", nargs="*", help="only these jobs")
    parser.add_argument("--only", nargs="*", default=[], help="parts of keys")
    parser.add_argument("--show", help="one case: its edit, its program, and what verify says")
    parser.add_argument("--again", action="store_true", help="those of the results that came out badly once more")
    parser.add_argument("--go-on", action="store_true", help="without those that the results have")
    parser.add_argument("--table", action="store_true", help="write the table of the results and end")
    options = parser.parse_args()
    one_thread()
    from text_faults import report

    if options.table:
        report.write(options.results, HERE / "text_faults_table.md")
        return 0
    with scratch_folder("text_faults") as folder:
        return _run(options, folder)


def _run(options: argparse.Namespace, folder: Path) -> int:
    from text_faults import report
    from text_faults.jobs import post_all
    from text_faults.run import cases, read, run

    started = time.time()
    only = [options.show] if options.show else options.only
    jobs = [options.show.split("/")[1]] if options.show and not options.jobs else options.jobs
    posted = post_all(folder, jobs)
    chosen = cases(posted, seed=options.seed, times=options.times, only=only)
    kept = read(options.results) if options.results.is_file() and (options.again or options.go_on) else []
    if not options.show and not kept:
        options.results.unlink(missing_ok=True)
    done = {o.key for o in kept if not (options.again and o.bad)}
    chosen = [case for case in chosen if case.key not in done]
    print(f"{time.time() - started:.1f} s  {len(chosen)} cases on {len(posted)} programs", file=sys.stderr, flush=True)
    outcomes = run(posted, chosen, folder, None if options.show else options.results)
    if options.show:
        for case, outcome in zip(chosen, outcomes, strict=True):
            print("\n".join(f"=== {name}\n{text}" for name, text in case.files.items()))
            print(f"{case.key}: {case.verdict}, {case.differs}\n{case.edit}\n{outcome.answer}: {outcome.said}")
    print(report.summary(outcomes))
    print(f"{time.time() - started:.1f} s", file=sys.stderr)
    return 1 if any(outcome.bad for outcome in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
