"""Writes camrob/warm/kernels.json: runs the verbs' jobs with an empty cache and notes what each kernel is compiled for.

    python tests/bench/kernel_signatures.py             # after a kernel has got, lost or changed arguments; takes minutes
    python tests/bench/kernel_signatures.py post        # only these jobs; kernels that no job asked for stay as they were

Prints the processor's seconds of each kernel, parts included.
"""

from __future__ import annotations

import json
import os
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
from camrob.warm.signatures import spelled  # noqa: E402

OUT = ROOT / "camrob/warm/kernels.json"
CELL = ROOT / "cells/kr15_track_table"
SAMPLE = ROOT / "toolpaths/engraving/engraving.cls"
DONE = Path(SCRATCH.name) / "done"


class Recorder(event.Listener):
    """Notes the compilations of kernels that Python calls: kernel, arguments, and how long."""

    def __init__(self) -> None:
        self.begun: list[float] = []
        self.rows: dict[str, dict] = {}
        self.within: dict[str, dict] = {}  # compiled for another kernel first: Python may call them later
        self.twice: list[str] = []

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
            self.within.setdefault(kernel, row)
            return
        print(f"{took:7.1f} s  {kernel}", flush=True)
        if kernel in self.rows:
            self.twice.append(kernel)
            return
        self.rows[kernel] = row


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


JOBS = {job.__name__: job for job in (post, planned, accurate, simulate, diagnose)}


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
    before = {row["kernel"]: row for row in json.loads(OUT.read_text())} if sys.argv[1:] else {}
    for name in asked:
        start, count = time.process_time(), len(recorder.rows)
        JOBS[name]()
        took = time.process_time() - start
        print(f"{name}: {took:.0f} s of processor, {len(recorder.rows) - count} kernels", flush=True)
        within = {name: row for name, row in recorder.within.items() if name in called}
        rows = sorted({**before, **within, **recorder.rows}.values(), key=lambda row: row["kernel"])
        OUT.write_text("[\n" + ",\n".join(json.dumps(row) for row in rows) + "\n]\n")
    if recorder.twice:
        sys.exit(f"compiled for more than one kind of arguments: {recorder.twice}")


if __name__ == "__main__":
    main()
