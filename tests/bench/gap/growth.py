"""How the time of a diagnosis grows with the rows of its log: `python tests/bench/gap/growth.py --seed 950000`.

One case of two effects, its runs made longer and longer; prints rows, those of the withheld run, processor seconds of the
diagnosis alone, kernels warm, and what it claims.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tests" / "bench"), str(ROOT)]

from camrob.cell.read_cell import read_cell  # noqa: E402
from camrob.gap.diagnose import diagnose  # noqa: E402
from camrob.measurement.read_log import read_log  # noqa: E402
from gap.maker import write_case  # noqa: E402

LENGTHS = (0.42, 0.42, 0.84, 1.65, 3.3)  # times the drawn length, about 6000 rows of seed 950000; the first warms up


def main() -> None:
    """Run, and print a line a length."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=950_000)
    seed = parser.parse_args().seed
    cell = read_cell(ROOT / "cells" / "kr15_track_table")
    for n, longer in enumerate(LENGTHS):
        with tempfile.TemporaryDirectory() as folder:
            write_case(Path(folder), seed, "two", longer=longer)
            log, withheld = (read_log(Path(folder) / f"{seed}{end}.csv") for end in ("", "_withheld"))
        begin = time.process_time()
        found = diagnose([log], cell, withheld=[withheld])
        if n:
            print(len(log), len(withheld), f"{time.process_time() - begin:.1f} s", *found.claimed, flush=True)


if __name__ == "__main__":
    main()
