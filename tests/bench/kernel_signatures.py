"""Writes camrob/warm/kernels.json: runs the verbs' jobs with an empty cache and notes what each kernel is compiled for.

    python tests/bench/kernel_signatures.py             # after a kernel has got, lost or changed arguments; takes minutes
    python tests/bench/kernel_signatures.py post        # only these jobs; kernels that no job asked for stay as they were

Prints the processor's seconds of each kernel, parts included.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import sys
import tempfile
import time
from pathlib import Path

SCRATCH = tempfile.TemporaryDirectory()
os.environ["NUMBA_CACHE_DIR"] = SCRATCH.name
os.environ["CAMROB_JIT"] = "1"
ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from numba.core import event  # noqa: E402

import camrob  # noqa: E402
from camrob.compiled import Kernel  # noqa: E402
from camrob.jobs.studies.weld import weld  # noqa: E402
from camrob.warm.signatures import spelled  # noqa: E402

OUT = ROOT / "camrob/warm/kernels.json"
CELL = ROOT / "cells/kr15_track_table"
SAMPLE = ROOT / "toolpaths/engraving/engraving.cls"
DONE = Path(SCRATCH.name) / "done"


class Recorder(event.Listener):
    """Notes the compilations of kernels that Python calls: kernel, arguments, and how long."""

    def __init__(self) -> None:
        self.begun: list[float] = []
        self.rows: dict[tuple[str, str], dict] = {}
        self.within: dict[tuple[str, str], dict] = {}  # compiled for another kernel first: Python may call them later

    def on_start(self, event) -> None:
        self.begun.append(time.process_time())

    def on_end(self, event) -> None:
        took = time.process_time() - self.begun.pop()
        dispatcher = event.data["dispatcher"]
        module = sys.modules[dispatcher.py_func.__module__]
        wanted = dispatcher.py_func
        name = next((n for n, value in vars(module).items() if getattr(value, "py_func", None) is wanted), None)
        if name is None or not module.__name__.startswith("camrob."):
            return
        kernel = f"{module.__name__}:{name}"
        if self.begun and not isinstance(getattr(module, name), Kernel):
            return
        row = {"kernel": kernel, "seconds": round(took, 1), "arguments": [spelled(a) for a in event.data["args"]]}
        if self.begun:
            self.within.setdefault(_key(row), row)
            return
        again = any(kernel == other for other, _ in self.rows)
        print(f"{took:7.1f} s  {kernel}{' for another kind of arguments' if again else ''}", flush=True)
        self.rows[_key(row)] = row


def _key(row: dict) -> tuple[str, str]:
    """A kernel and what it is called with."""
    return row["kernel"], json.dumps(row["arguments"])


def post() -> None:
    camrob.post(SAMPLE, cell=CELL, out=DONE / "post")


def planned() -> None:
    camrob.post(SAMPLE, cell=CELL, out=DONE / "planned", method="planned", feed="optimal")


def accurate() -> None:
    camrob.post(SAMPLE, cell=CELL, out=DONE / "accurate", method="planned", for_accuracy=True)


def simulate() -> None:
    camrob.simulate(DONE / "post/engraving.src", cell=CELL, out=DONE / "log.csv")


def diagnose() -> None:
    camrob.diagnose(cell=CELL, log=[DONE / "log.csv"], program=DONE / "post/engraving.src", out=DONE / "diagnosis")


def refused() -> None:
    """A program with a target elsewhere: what a failing verify draws."""
    folder = DONE / "elsewhere"
    shutil.copytree(DONE / "post", folder)
    program = folder / "engraving.src"
    lines = program.read_text().splitlines(keepends=True)
    cut = [k for k, line in enumerate(lines) if line.startswith("LIN")][len(lines) // 4]
    lines[cut] = re.sub(r"Z (-?[0-9.]+)", lambda found: f"Z {float(found[1]) - 40.0:.4f}", lines[cut])
    program.write_text("".join(lines))
    camrob.verify(program, cell=CELL, against=SAMPLE, manifest=False, out=DONE / "refused")


def _another_arm(name: str, row: str, instead: str) -> Path:
    """The cell with an arm of another kind: a row of its Denavit-Hartenberg table is changed."""
    folder = DONE / name
    shutil.copytree(CELL, folder, ignore=shutil.ignore_patterns("poses.csv"))
    file = folder / "cell.toml"
    text = file.read_text()
    if text.count(row) != 1:
        sys.exit(f"{file} holds {row!r} {text.count(row)} times")
    file.write_text(text.replace(row, instead))
    return folder


def screws() -> None:
    """A2 askew to A3: closed forms by screws."""
    cell = _another_arm("askew", "alpha_deg = 0, a_mm = 650", "alpha_deg = 5, a_mm = 650")
    camrob.post(SAMPLE, cell=cell, out=DONE / "screws")
    camrob.post(SAMPLE, cell=cell, out=DONE / "screws_planned", method="planned")


def no_closed_form() -> None:
    """A wrist whose axes don't meet: by Newton's method."""
    wrist = "theta_deg = 0, d_mm = 0 }\naxis = { sign = -1"
    cell = _another_arm("offset_wrist", wrist, wrist.replace("d_mm = 0", "d_mm = 60"))
    camrob.post(SAMPLE, cell=cell, out=DONE / "no_closed_form")


def proved() -> None:
    """A plan whose price is bounded: upright waypoints, and the globe's, which lean."""
    globe = ROOT / "toolpaths/globe/globe.cls"
    camrob.post(SAMPLE, cell=CELL, out=DONE / "proved", method="planned", prove=20.0, report=False)
    camrob.post(globe, cell=CELL, out=DONE / "proved_leaning", method="planned", prove=60.0, report=False)


def decimated() -> None:
    """Points that a program can do without."""
    folder = DONE / "decimated"
    shutil.copytree(SAMPLE.parent, folder)
    setup = folder / "setup.toml"
    setup.write_text(f"decimate_mm = 0.01\n{setup.read_text()}")
    camrob.post(folder / SAMPLE.name, cell=CELL, out=folder / "out", report=False)


def corrected() -> None:
    """A calibration, and the program that it makes."""
    camrob.calibrate(DONE / "log.csv", cell=CELL, out=DONE / "calibration.toml")
    camrob.compensate(
        DONE / "post/engraving.src", cell=CELL, calibration=DONE / "calibration.toml", out=DONE / "corrected"
    )


def tuned() -> None:
    camrob.tune_engines(CELL, on=[SAMPLE], out=DONE / "tuned", budget=3, seeds=1, points=40)


def welded() -> None:
    weld(cell=ROOT / "cells/ta1400_weld", out=DONE / "welded")


JOBS = {
    job.__name__: job
    for job in (
        post, planned, accurate, simulate, diagnose, refused, screws, no_closed_form, proved, decimated, corrected, tuned, welded,
    )
}  # fmt: skip


def _noting_calls() -> set[str]:
    """The names of the kernels that Python calls from here on."""
    called: set[str] = set()
    run = Kernel.__call__

    def noted(kernel: Kernel, *arguments: object) -> object:
        called.add(kernel.name)
        return run(kernel, *arguments)

    Kernel.__call__ = noted
    return called


def main() -> None:
    recorder, called = Recorder(), _noting_calls()
    event.register("numba:compile", recorder)
    asked = sys.argv[1:] or list(JOBS)
    before = {_key(row): row for row in json.loads(OUT.read_text())} if sys.argv[1:] else {}
    for name in asked:
        start, count = time.process_time(), len(recorder.rows)
        JOBS[name]()
        took = time.process_time() - start
        print(f"{name}: {took:.0f} s of processor, {len(recorder.rows) - count} kernels", flush=True)
        within = {key: row for key, row in recorder.within.items() if key[0] in called}
        rows = sorted({**before, **within, **recorder.rows}.values(), key=lambda row: row["kernel"])
        OUT.write_text("[\n" + ",\n".join(json.dumps(row) for row in rows) + "\n]\n")


if __name__ == "__main__":
    main()
