"""Times of single steps at the sizes that matter, each beside the bound that it keeps on a machine at rest:
python tests/bench/bench_times.py [--only PART_OF_NAME] [--json OUT.json]

Run it alone: on a busy machine the times say nothing, which is why no test asserts them. A step runs once to warm up
(compiling, caches), then three times; the best counts. Ends with status 1 where a bound is missed.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / room) for room in ("", "jobs", "toolpath", "measurement")]

import test_compensate as of_compensate  # noqa: E402
import test_gcode as of_gcode  # noqa: E402
from feed_paths import CELL, path_of, wave  # noqa: E402
from krl_sample import make_program, written  # noqa: E402
from test_cl_reader import HEAD  # noqa: E402
from test_cl_reader import read as read_apt  # noqa: E402
from test_log import made  # noqa: E402

from camrob.calibration.compensate import compensate_postures  # noqa: E402
from camrob.cell.read_cell import read_cell  # noqa: E402
from camrob.errors import ToolpathError  # noqa: E402
from camrob.kinematics.frames import base_T_tool  # noqa: E402
from camrob.measurement.read_log import read_log  # noqa: E402
from camrob.measurement.write_log import write_log  # noqa: E402
from camrob.program.motion import Motion  # noqa: E402
from camrob.timing.timing import program_time  # noqa: E402

RUNS = 3
Step = Callable[[], object]


def million_points() -> Step:
    text = HEAD + "GOTO/12.3456,-65.4321,0.1000\n" * 1_000_000
    return lambda: read_apt(text)


def long_log() -> Step:
    file = Path(tempfile.mkdtemp()) / "l.csv"
    write_log(made(300_000), file)
    return lambda: read_log(file)


def long_program() -> Step:
    safe = list(range(5000, 100_000, 5000))
    program = make_program([Motion.PTP_AXES] + [Motion.LIN] * 100_000, safe=safe)
    return lambda: written(program)


def compensation() -> Step:
    q = np.tile(of_compensate.good_postures(2000), (50, 1))[:100_000]
    targets = np.tile(base_T_tool(of_compensate.CELL, q[:2000]), (50, 1, 1))[: len(q)]
    return lambda: compensate_postures(of_compensate.MODEL, of_compensate.VALUES, q, targets)


def timing() -> Step:
    path, q = path_of(np.repeat(wave(50_000), 4, axis=0), feed=0.1)
    speed = np.full(len(q), 0.1)
    return lambda: program_time(CELL, path, q, speed=speed)


def huge_gcode(data: bytes) -> Callable[[], Step]:
    def step() -> None:
        with suppress(ToolpathError):
            of_gcode.read(data)

    return lambda: step


def gcode(blocks: int) -> Callable[[], Step]:
    text = of_gcode.TCP + "".join(f"G1 X{i % 97}.5 Y{i % 31} A{i % 3} C{i % 5}\n" for i in range(blocks)) + "M30\n"
    return lambda: lambda: of_gcode.read(text)


def cell() -> Step:
    return lambda: read_cell(ROOT / "cells" / "kr15_track_table")


def help_text() -> Step:
    command = [sys.executable, "-m", "camrob.cli", "--help"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return lambda: subprocess.run(command, env=environment, check=True, capture_output=True)


STEPS: dict[str, tuple[float, Callable[[], Step]]] = {
    # name: (seconds that it may take, what makes the step)
    "read a million GOTOs": (10.0, million_points),
    "read a log of 300 000 rows": (6.0, long_log),
    "write 100 000 motions": (1.5, long_program),
    "compensate 100 000 postures": (20.0, compensation),
    "time 200 000 points": (2.0, timing),
    "refuse G-code, a number of 100 MB": (5.0, huge_gcode(b"G1 X" + b"1" * 100_000_000)),
    "refuse G-code, a comment of 50 MB": (5.0, huge_gcode(b"(" + b"a" * 50_000_000)),
    "refuse G-code, 50 MB of blanks": (5.0, huge_gcode(b" " * 50_000_000)),
    "refuse G-code, 9 MB of parentheses": (5.0, huge_gcode((b"(" * 9000 + b"\n") * 1000)),
    "refuse G-code, 9 MB of gaps": (5.0, huge_gcode((b"G1 A" + b" " * 9000 + b"\n") * 1000)),
    "refuse G-code, 50 MB of zeros": (5.0, huge_gcode(b"\0" * 50_000_000)),
    "read 4 000 blocks of G-code": (1.0, gcode(4_000)),
    "read 40 000 blocks of G-code": (10.0, gcode(40_000)),
    "read the KR15 cell, its poses held": (0.1, cell),
    "camrob --help": (0.5, help_text),
}


def best_of(step: Step) -> float:
    """Seconds of the best run after one to warm up."""
    step()
    taken = []
    for _ in range(RUNS):
        start = time.perf_counter()
        step()
        taken.append(time.perf_counter() - start)
    return min(taken)


def main() -> int:
    """Measure, print a row a step, give the status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="steps whose name holds this")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    rows = []
    for name, (bound, make) in STEPS.items():
        if given.only in name:
            seconds = best_of(make())
            rows.append({"step": name, "seconds": round(seconds, 4), "bound": bound, "kept": seconds <= bound})
            print(f"{name:40s} {seconds:8.3f} s of {bound:g} s{'' if seconds <= bound else '   TOO SLOW'}", flush=True)
    if given.json is not None:
        given.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 0 if all(r["kept"] for r in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
