"""The sealed benchmark of the diagnosis: `python tests/bench/gap/benchmark.py --out DIR` runs all of it and writes DIR/report.md.

Cases come from `gap.maker`, which shares no code with camrob; makers and diagnoses are processes of their own. A maker
hands the logs to a folder, and the label to DIR/sealed, which no diagnosis is told of and which is opened by the scorer,
once every case has been diagnosed. A run that was stopped goes on where it stood. `--score` only scores what is there; what
DIR/preface.md says is put before the figures.

`--on LOG.csv [--on-withheld OTHER.csv]` asks how well the diagnosis would do on your own path: all cases are then made on the
motion of that log (its set-points, its clock, its instrument's noise, its columns), the withheld run on that of the other.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

CELL = Path(__file__).resolve().parents[3] / "cells" / "kr15_track_table"
ALL = (
    "frame_base",
    "frame_tool",
    "frame_table",
    "measurement_frame",
    "joint_offset",
    "geometry",
    "track",
    "lean",
    "joint_compliance",
    "payload",
    "backlash",
    "servo_lag",
    "acceleration_error",
    "friction",
    "gear_ripple",
    "wrist_coupling",
    "thermal_drift",
    "latency",
    "early_reading",
    "cutting_force",
)
KEPT = ("status", "effects", "together", "alternatives", "unknown", "aliases", "residual", "next_experiment")


def make(folder: str, task: dict) -> dict:
    """Write a case's logs; gives the label."""
    from gap.maker import write_case

    sizes = tuple(task["sizes"]) if task.get("sizes") else None
    on, field = tuple(task.get("on", ())), task.get("field", 0.0)
    return write_case(Path(folder), task["seed"], task.get("kind"), task.get("only"), sizes, on, field)


def answer(folder: str, seed: int, without: tuple[str, ...]) -> dict:
    """Diagnose a case, knowing its logs alone."""
    from camrob.cell.read_cell import read_cell
    from camrob.gap.diagnose import diagnose
    from camrob.measurement.read_log import read_log

    files = [Path(folder) / f"{seed}.csv", Path(folder) / f"{seed}_withheld.csv"]
    cell, (log, withheld) = read_cell(CELL), [read_log(f) for f in files]
    begin = time.process_time()
    try:
        found = diagnose([log], cell, withheld=[withheld], without=without).summary.to_json()
        said = {k: found[k] for k in KEPT} | {"rungs": found["where"]["rungs"], "regimes": found["where"]["regimes"]}
        said["noise_mm"] = found["gap"]["noise_mm"]
    except Exception as error:
        said = {"error": f"{type(error).__name__}: {error}"}
    said |= {"seconds": time.process_time() - begin, "rows": len(log)}
    for f in files:
        f.unlink()
        f.with_suffix(".toml").unlink()
    return said


def motions_of(arguments: argparse.Namespace) -> list[str]:
    """Logs on whose motions the cases are to be, the one to fit and the withheld one; [] for drawn ones."""
    on, withheld = getattr(arguments, "on", None), getattr(arguments, "on_withheld", None)
    return [str(m.resolve()) for m in (on, withheld or on) if m is not None]


def tasks_of(arguments: argparse.Namespace) -> list[dict]:
    """Every case to be made: the mix, more of nothing, every effect alone at twice the noise, every effect taken out.

    All four go on side by side, so that a run that is stopped has its share of each.
    """
    first, motions, names = arguments.first, motions_of(arguments), ALL
    if motions:
        from gap.maker import names_on

        names = names_on(motions[0])
    groups = [
        [{"key": f"mix {first + k}", "seed": first + k} for k in range(arguments.cases)],
        [
            {"key": f"nothing {seed}", "seed": seed, "kind": "none"}
            for seed in range(first + 3_000_000, first + 3_000_000 + arguments.nothing)
        ],
    ]
    for group, start, count, more in (
        ("each", 1_000_000, arguments.each, {"sizes": [2.0, 2.5]}),
        ("left out", 2_000_000, arguments.left_out, {"sizes": [2.0, 20.0]}),
    ):
        tasks = []
        for n in range(count):
            for k, name in enumerate(names):
                if name not in (getattr(arguments, "only", None) or names):
                    continue
                seed = first + start + 1000 * k + n
                without = {"without": [name]} if group == "left out" else {}
                tasks.append({"key": f"{group} {seed}", "seed": seed, "only": name, **more, **without})
        groups.append(tasks)
    for task in (t for g in groups for t in g if motions):
        task["on"] = motions
    for task in (t for g in groups for t in g if getattr(arguments, "field", 0.0) > 0.0):
        task["field"] = arguments.field
    placed = [((k + 0.5) / len(g), i, t) for i, g in enumerate(groups) for k, t in enumerate(g)]
    return [t for _, _, t in sorted(placed, key=lambda x: x[:2])]


def read_lines(path: Path) -> dict[str, dict]:
    """Records by key; a line that was cut short is left aside."""
    found = {}
    if path.exists():
        for line in path.read_text().splitlines():
            try:
                record = json.loads(line)
            except json.JSONDecodeError:
                continue
            found[record["key"]] = record
    return found


def run(arguments: argparse.Namespace) -> None:
    """Make and diagnose every case that has no answer yet."""
    sealed, answers = arguments.out / "sealed" / "labels.jsonl", arguments.out / "answers.jsonl"
    sealed.parent.mkdir(parents=True, exist_ok=True)
    done = read_lines(answers)
    waiting = [t for t in tasks_of(arguments) if t["key"] not in done]
    begin = time.time()
    with (
        tempfile.TemporaryDirectory() as folder,
        sealed.open("a") as labels,
        answers.open("a") as said,
        ProcessPoolExecutor(arguments.workers) as makers,
        ProcessPoolExecutor(arguments.workers) as doctors,
    ):
        for start in range(0, len(waiting), 4 * arguments.workers):
            some = waiting[start : start + 4 * arguments.workers]
            pending = []
            for task, made in [(t, makers.submit(make, folder, t)) for t in some]:
                label = made.result()
                labels.write(json.dumps({"key": task["key"], "task": task, "label": label}, default=float) + "\n")
                pending.append((task, doctors.submit(answer, folder, task["seed"], tuple(task.get("without", ())))))
            labels.flush()
            for task, job in pending:
                said.write(json.dumps({"key": task["key"], "said": job.result()}, default=float) + "\n")
            said.flush()
            sys.stderr.write(f"{start + len(some)} of {len(waiting)}, {time.time() - begin:.0f} s\n")


def main() -> None:
    """Run, then score."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--cases", type=int, default=2000, help="of the mix: 15, 35, 25, 10, 15 %%")
    parser.add_argument("--nothing", type=int, default=0, help="further cases of nothing, for the false alarms alone")
    parser.add_argument("--each", type=int, default=10, help="cases of every effect alone, at twice the noise")
    parser.add_argument("--left-out", type=int, default=5, help="cases of every effect, taken out of the library")
    parser.add_argument(
        "--field", type=float, default=0.0, help="times the noise that a smooth field over posture adds to every case"
    )
    parser.add_argument("--first", type=int, default=100_000, help="the first seed")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--score", action="store_true", help="only score what is there")
    parser.add_argument("--on", type=Path, help="a log of the KR15 cell, on whose motion all cases are made")
    parser.add_argument(
        "--on-withheld", type=Path, help="the log whose motion the withheld runs have; --on again without it"
    )
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    try:
        from gap.motions import read_motion

        for motion in motions_of(arguments):
            read_motion(motion)
    except (OSError, ValueError) as error:
        parser.error(str(error))
    if not arguments.score:
        run(arguments)
    from gap.beside_field import field_figures, write_field_report
    from gap.report import write_report
    from gap.score import rows_of, score

    sealed = arguments.out / "sealed" / "labels.jsonl"
    labels, answers = read_lines(sealed), read_lines(arguments.out / "answers.jsonl")
    text = "".join(json.dumps(labels[k]["label"], sort_keys=True) for k in sorted(labels) if k in answers)
    rows = rows_of(labels, answers)
    figures = field_figures(rows) if arguments.field > 0.0 else score(rows)
    figures["sha256 of the labels"] = hashlib.sha256(text.encode()).hexdigest()
    (arguments.out / "figures.json").write_text(json.dumps(figures, indent=1, default=float))
    if arguments.field > 0.0:
        write_field_report(figures, arguments.out, arguments.field)
        return
    preface = arguments.out / "preface.md"
    told = preface.read_text() if preface.exists() else ""
    if arguments.on is not None:
        names = " and ".join(f"`{Path(m).name}`" for m in dict.fromkeys(motions_of(arguments)))
        told = (
            f"**All cases here are on the motion of {names}**, with its clock, noise and columns; what is said below of drawn "
            f"paths, rates and instruments does not hold.\n\n{told}"
        )
    write_report(figures, arguments.out, told)


if __name__ == "__main__":
    main()
