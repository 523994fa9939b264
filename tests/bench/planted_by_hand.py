"""Faults planted by hand in programs that camrob wrote: does `verify --against` find every one, and pass what is legal?

    python tests/bench/planted_by_hand.py [--only WORD] [--round 1|2] [--legal] [--keep DIR] [--table]

Jobs are posted afresh, each edit is made on a copy, and the copy is judged without its manifest. Exit status 1 where a
fault is passed (`ok` true), a legal edit is not (`ok` false or null), or an edit no longer fits its program.
"""

from __future__ import annotations

import argparse
import shutil
import signal
import sys
import tempfile
from pathlib import Path

from planted.edits import Planted
from planted.faults_later import LATER
from planted.faults_more import MORE, NOT_LOADED
from planted.faults_motion import MOTION, OTHER_POSTURE
from planted.faults_process import PROCESS
from planted.faults_settings import SETTINGS
from planted.jobs import JOBS
from planted.legal import ARGUABLE, LEGAL

from camrob import post
from camrob.errors import CamrobError
from camrob.jobs.verify import verify

CELL = Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table"
PATIENCE = 90
"""Seconds after which a verdict no longer counts: a program that never ends must not hold up its judge."""


def _too_long(signum: int, frame: object) -> None:
    raise TimeoutError(f"no verdict within {PATIENCE} s")


def make(folder: Path, names: set[str]) -> None:
    """Post the jobs, each into a folder of its name."""
    for name in sorted(names):
        job = JOBS[name]
        home = folder / name
        home.mkdir(parents=True)
        (home / job.clfile).write_text(job.text)
        (home / "setup.toml").write_text(job.setup)
        post(home / job.clfile, cell=CELL, out=home / "out", report=False, **job.options)


def judged(folder: Path, planted: Planted, work: Path) -> tuple[str, str]:
    """ "true", "false", "null", "refused" (not readable) or "misfit", and the first thing said."""
    home, job = folder / planted.job, JOBS[planted.job]
    main = f"{planted.job}.src"
    names = [main, *sorted(p.name for p in (home / "out").glob("*.??[ct]") if p.name != main)]
    files = {name: (home / "out" / name).read_text(encoding="utf-8") for name in names}
    try:
        for edit in planted.edits:
            edit(files)
    except LookupError as error:
        return "misfit", str(error)
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    shutil.copy(home / "out" / f"{planted.job}.json", work)
    for name, text in files.items():
        (work / name).write_bytes(text.encode("utf-8"))
    signal.signal(signal.SIGALRM, _too_long)
    signal.alarm(PATIENCE)
    try:
        result = verify(work / main, cell=CELL, against=home / job.clfile, setup=home / "setup.toml", manifest=False)
    except CamrobError as error:
        return "refused", str(error)
    except Exception as error:
        return "crash", f"{type(error).__name__}: {error}"
    finally:
        signal.alarm(0)
    said = [e.text for e in result.summary.errors] or list(result.summary.not_judged)
    return {True: "true", False: "false", None: "null"}[result.ok], said[0] if said else ""


def write_table(rows: list[tuple[str, str, str]], kinds: dict[str, list[Planted]]) -> None:
    """planted_table.md of a whole run: for each edit what it is (fault, legal), its name and the verdict."""
    lines = [
        "# Faults planted by hand",
        "",
        "Made by `python tests/bench/planted_by_hand.py --table`: edits by somebody who had not read the witness, each judged by",
        "`verify --against --no-manifest`. `false`: something stands against the program; `null`: not judged; `refused`: not",
        "readable. A fault that is `true`, and a legal edit that is not, would be wrong.",
        "",
        "| kind | edits | true | false | null | refused |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for title, group in kinds.items():
        names = {(p.job, p.name) for p in group}
        found = [verdict for job, name, verdict in rows if (job, name) in names]
        counts = " | ".join(str(found.count(verdict)) for verdict in ("true", "false", "null", "refused"))
        lines.append(f"| {title} | {len(found)} | {counts} |")
    (Path(__file__).parent / "planted_table.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="faults whose name, job or reason holds this word")
    parser.add_argument("--round", type=int, choices=(1, 2), help="the first or the second round of faults alone")
    parser.add_argument("--legal", action="store_true", help="the legal edits alone")
    parser.add_argument("--keep", type=Path, help="work here, and leave the posted jobs")
    parser.add_argument("--table", action="store_true", help="write planted_table.md of what was run")
    options = parser.parse_args()
    first, second = [*SETTINGS, *MOTION, *PROCESS], [*MORE, *LATER]
    faults = {None: [*first, *second], 1: first, 2: second}[options.round]
    kinds = [
        ("fault", [] if options.legal else faults),
        ("legal", LEGAL),
        ("open", [*OTHER_POSTURE, *NOT_LOADED, *ARGUABLE]),
    ]
    chosen = [(kind, p) for kind, group in kinds for p in group if options.only in f"{p.job} {p.name} {p.why}"]
    bad, rows = 0, list[tuple[str, str, str]]()
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.keep or Path(scratch)
        make(folder, {p.job for _, p in chosen if not (folder / p.job).exists()})
        for kind, planted in chosen:
            verdict, said = judged(folder, planted, folder / "edited")
            wrong = verdict in {"misfit", "crash"} or (kind != "open" and (verdict == "true") == (kind == "fault"))
            bad += wrong
            rows.append((planted.job, planted.name, verdict))
            mark = {"fault": "PASSED", "legal": "REFUSED", "open": "FAILED"}[kind] if wrong else ""
            print(f"{kind:6}{verdict:8}{mark:9}{planted.job:6}{planted.name} | {said[:150]}", flush=True)
    print(f"{len(chosen)} judged, {bad} wrong")
    if options.table:
        titles = {
            "settings: frames, loads, speeds, roundings": SETTINGS,
            "motions": MOTION,
            "process, text, flow, data lists": PROCESS,
            "second round: names, hooks, ends, waits": MORE,
            "later rounds: arithmetic, templates, scope": LATER,
            "legal edits": LEGAL,
            "not counted: arguable, or never loaded": [*OTHER_POSTURE, *NOT_LOADED, *ARGUABLE],
        }
        write_table(rows, titles)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
