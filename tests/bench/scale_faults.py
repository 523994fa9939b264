"""Inputs of unusual size, posted by the command line: `python tests/bench/scale_faults.py [--points 1000000]`.

A path with one point out of reach in its middle beside the same path without it, a file of a gigabyte of blanks, a line of
100 MB, ten thousand regions of one point. Prints status, message, seconds and memory of each; tests/hostile/test_scale.py holds
smaller ones of the same kind to what must come out.
"""

from __future__ import annotations

import argparse
import math
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"
HEAD = "TOOL PATH/A,TOOL,B\nTLDATA/MILL,10,0,50,0,0\nMSYS/0,0,0,1,0,0,0,1,0\n"
SETUP = "part_in_base = [0, 0, 200, 0, 0, 0]\n"

__all__ = ["HEAD", "SETUP", "blanks", "long_line", "many_regions", "wavy_spiral"]


def wavy_spiral(points: int, *, unreachable: bool = False) -> Iterator[str]:
    """A spiral that rises and falls; with `unreachable`, the point in the middle lies nine metres under the floor."""
    yield HEAD + "RAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/MMPM,3000\n"
    for k in range(points):
        angle, radius = k * 0.002, 20.0 + 60.0 * k / points
        z = -9000.0 if unreachable and k == points // 2 else 8.0 + 5.0 * math.sin(3.0 * angle)
        yield f"GOTO/{radius * math.cos(angle):.4f},{radius * math.sin(angle):.4f},{z:.4f}\n"
    yield "RAPID\nGOTO/0,0,80\nEND-OF-PATH\n"


def many_regions(count: int) -> Iterator[str]:
    """Regions of one point each."""
    for k in range(count):
        place = f"{k % 100 * 0.5:.2f},{k // 100 * 0.5:.2f},20"
        yield HEAD.replace("/A,", f"/R{k},") + f"RAPID\nGOTO/{place},0,0,1\nEND-OF-PATH\n"


def blanks(megabytes: int) -> Iterator[str]:
    """Nothing, and much of it."""
    return (" " * (1 << 20) for _ in range(megabytes))


def long_line(megabytes: int) -> Iterator[str]:
    """A GOTO that doesn't end."""
    yield HEAD + "GOTO/"
    yield from ("1.0," * 250_000 for _ in range(megabytes))
    yield "\n"


def main() -> None:
    """Write each file, post it, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=1_000_000)
    points = parser.parse_args().points
    cases: dict[str, Callable[[], Iterator[str]]] = {
        f"{points} points": lambda: wavy_spiral(points),
        f"{points} points, one out of reach": lambda: wavy_spiral(points, unreachable=True),
        "a gigabyte of blanks": lambda: blanks(1024),
        "a line of 100 MB": lambda: long_line(100),
        "10 000 regions of one point": lambda: many_regions(10_000),
    }
    for name, lines in cases.items():
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            (folder / "setup.toml").write_text(SETUP)
            with (folder / "part.cls").open("w") as file:
                file.writelines(lines())
            command = [
                "post",
                str(folder / "part.cls"),
                "--cell",
                str(CELL),
                "--out",
                str(folder / "out"),
                "--no-report",
            ]
            before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
            done = subprocess.run(
                [sys.executable, "-m", "camrob.cli", *command, "--quiet"],
                cwd=ROOT,
                capture_output=True,
                text=True,
                check=False,
            )
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            told = done.stderr.strip().replace(place, "")
            print(
                f"{name}: status {done.returncode}, {time.perf_counter() - start:.1f} s ({cpu:.1f} s of CPU), "
                f"at most {after.ru_maxrss / 1024:.0f} MB so far{': ' + told if told else ''}",
                flush=True,
            )


if __name__ == "__main__":
    main()
