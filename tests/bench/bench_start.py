"""What a command costs before and beside its work: seconds of processor, of the clock, and memory, each in a fresh process.

    python tests/bench/bench_start.py            # with the library of kernels that `python -m camrob.warm` makes
    python tests/bench/bench_start.py --cold     # and what Numba takes without it, from an empty cache: minutes

The least of three runs each, since everything else on the machine only adds to it.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PART = ["toolpaths/engraving/engraving.cls", "--cell", "cells/kr15_track_table", "--out"]
RUNS = 3


def measured(arguments: list[str], cache: Path, **environment: str) -> tuple[float, float, float]:
    """Seconds of processor, seconds of the clock, and MB at most, of `camrob ARGUMENTS`."""
    left = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", "PYTHONDONTWRITEBYTECODE")}
    left |= {"XDG_CACHE_HOME": str(cache), "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1", **environment}
    start = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-m", "camrob", *arguments],
        cwd=ROOT,
        env=left,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _pid, _status, used = os.wait4(process.pid, 0)
    return used.ru_utime + used.ru_stime, time.perf_counter() - start, used.ru_maxrss / 1024.0


def best(runs: list[tuple[float, float, float]]) -> tuple[float, ...]:
    return tuple(map(min, zip(*runs, strict=True)))


def main() -> None:
    from camrob.machine_code import ready_library

    if ready_library() is None:
        sys.exit("no library of kernels for these sources: python -m camrob.warm makes it")
    print("| command | processor s | clock s | MB |\n| --- | --- | --- | --- |")

    def row(name: str, runs: list[tuple[float, float, float]]) -> None:
        print("| {} | {:.2f} | {:.2f} | {:.0f} |".format(name, *best(runs)), flush=True)

    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        warm, out = place / "warm", str(place / "out")
        post = ["post", *PART, out]
        row("`camrob --help`", [measured(["--help"], warm) for _ in range(RUNS)])
        row("a path that isn't there", [measured(["post", "nothing.cls", *PART[1:], out], warm) for _ in range(RUNS)])
        row("post, nothing in the cache", [measured(post, place / f"empty{k}") for k in range(RUNS)])
        measured(post, warm)
        row("post", [measured(post, warm) for _ in range(RUNS)])
        row("post `--no-report`", [measured([*post, "--no-report"], warm) for _ in range(RUNS)])
        if "--cold" in sys.argv:
            row("post by Numba, nothing in the cache", [measured(post, place / "numba", CAMROB_JIT="1")])
            row("post by Numba", [measured(post, place / "numba", CAMROB_JIT="1") for _ in range(RUNS)])
            row(
                "... `--no-report`",
                [measured([*post, "--no-report"], place / "numba", CAMROB_JIT="1") for _ in range(RUNS)],
            )


if __name__ == "__main__":
    main()
