"""An effect that was taken out, given back as a cell's own effect file: `python tests/bench/gap/given_back.py --of DIR`.

DIR holds a run of `taken_out`. Of every case whose effect formulas can say, the logs are made again, and diagnosed by the library
without the effect and by the same with the cell's `effects/own_NAME.toml`. DIR/given_back.md holds, a row a case: the share of
the withheld gap's energy that was said to be unknown, and the share that the file then took of it beyond what was named before.
A formula says what a technician would write down; where it is coarser than the cause, it takes less.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

from gap.benchmark import CELL, make, read_lines

ARM = ("A1", "A2", "A3", "A4", "A5", "A6")
WIDE = 50.0  # times the usual size: what is still plausible
TRIES = {"try": "seconds", "from": 0.01, "to": 0.3, "count": 12}
WIDTHS = {"try": "width", "from": 0.01, "to": 0.3, "count": 12}


def placed(owner):
    """A place that is elsewhere and turned."""
    return [(f"{owner}.{p}", "1", 0.03 if p.startswith("r") else 0.3) for p in ("x", "y", "z", "rx", "ry", "rz")]


def links(axes, by="1", shift=0.3, turn=0.02, parts=("x", "y", "rx", "ry")):
    """Axes that stand elsewhere in their links."""
    return [(f"{a}.{p}", by, turn if p.startswith("r") else shift) for a in axes for p in parts]


def bent():
    """A track of another scale, and a bow over its travel."""
    bows = [(f"root.{p}", f"(E1 / 500) ** {k}", 0.2) for p in "xz" for k in (1, 2, 3, 4)]
    return [("root.y", "E1 / 1000", 0.2), *bows]


def pushed():
    """Foot, A2 and A3, by force."""
    turned = [(a, f"f{p} / 100", 0.01) for a in ("A2", "A3") for p in "xyz"]
    return [(f"root.{p}", f"f{p} / 100", 0.1) for p in "xyz"] + turned


def warm():
    """Foot and links, by what the log has as temperature."""
    foot = [(f"root.{p}", "temp - 21", 0.01) for p in "xyz"]
    return foot + links(("A2", "A3", "A4"), "temp - 21", 0.01, parts=("x", "y"))


# regimes, what is chosen among, and by parameter what moves, by which formula, and how much is usual (mm or degrees)
FORMS = {
    "frame_base": (["position"], {}, placed("root")),
    "frame_tool": (["position"], {}, placed("tool")),
    "joint_offset": (["position"], {}, [(a, "1", 0.05) for a in ARM]),
    "geometry": (["position"], {}, links(("A2", "A4", "A6"))),
    "track": (["position"], {}, bent()),
    "joint_compliance": (["load", "position"], {}, [(a, f"T_{a} / 1000", 0.2) for a in ARM]),
    "wrist_coupling": (["position"], {}, [("A5", "A4", 1e-3), ("A6", "A4", 1e-3), ("A6", "A5", 1e-3)]),
    "backlash": (["direction"], WIDTHS, [(a, f"play({a}, width)", 0.02) for a in ARM]),
    "servo_lag": (["speed"], TRIES, [(f"drive {a}", f"lag({a}, seconds) - {a}", 1.0) for a in ARM]),
    "friction": (["direction", "speed"], {}, [(f"drive {a}", f"-tanh(d{a} / 0.1)", 0.01) for a in ARM]),
    "acceleration_error": (["acceleration"], {}, [(a, f"dd{a}", 3e-4) for a in ARM]),
    "thermal_drift": (["time"], {}, warm()),
    "cutting_force": (["force"], {}, pushed()),
    "latency": (["speed"], {}, [(a, f"-d{a}", 0.01) for a in ARM]),
}


def written(name):
    """The effect's file."""
    regimes, tried, parts = FORMS[name]
    lines = [
        f'name = "own_{name}"',
        f'physics = "What {name} would do, as a technician writes it down"',
        'experiment = "as of the effect that it stands for"',
        f"regimes = {json.dumps(regimes)}",
    ]
    if tried:
        lines += ["[try]", f'name = "{tried["try"]}"', *(f"{k} = {tried[k]}" for k in ("from", "to", "count"))]
    for n, (moves, by, usual) in enumerate(parts):
        turns = moves.removeprefix("drive ") in ARM or moves.rpartition(".")[2].startswith("r")
        lines += [
            "[[parameter]]",
            f'name = "p{n}"',
            f'moves = "{moves}"',
            f'by = "{by}"',
            f'unit = "{"deg" if turns else "mm"}"',
            f"usual = {usual:g}",
            f"lower = {-WIDE * usual:g}",
            f"upper = {WIDE * usual:g}",
        ]
    return "\n".join(lines) + "\n"


def asked(task):
    """(without, with the file) what is said of a case."""
    from camrob.cell.read_cell import read_cell
    from camrob.gap.cell_effects import cell_effects
    from camrob.gap.diagnose import diagnose
    from camrob.measurement.read_log import read_log

    with tempfile.TemporaryDirectory() as folder:
        make(folder, task)
        home = Path(folder) / "cell"
        shutil.copytree(CELL, home)
        (home / "effects").mkdir(exist_ok=True)
        (home / "effects" / f"own_{task['only']}.toml").write_text(written(task["only"]))
        cell = read_cell(home)
        log, withheld = (read_log(Path(folder) / f"{task['seed']}{end}.csv") for end in ("", "_withheld"))
        extras = ((), cell_effects(home, cell))
        return [
            diagnose([log], cell, withheld=[withheld], without=task["without"], extra=e).summary.to_json()
            for e in extras
        ]


def judged(task):
    """A row of the table."""
    first, then = asked(task)
    own = {e["effect"]: e["probability"] for e in then["effects"]}.get(f"own_{task['only']}", 0.0)
    (before, left), (_, after) = (
        (s["together"]["rms_before_mm"], s["together"]["rms_after_mm"]) for s in (first, then)
    )
    named = ", ".join(f"{e['effect']} {e['probability']:.2f}" for e in first["effects"] if e["probability"] >= 0.5)
    return {
        "effect": task["only"],
        "seed": task["seed"],
        "named": named,
        "unknown": first["unknown"]["probability"],
        "predicted": first["unknown"]["share"],
        "own": own,
        "reached": (left**2 - after**2) / before**2,
        "before_mm": before,
        "after_mm": after,
        "noise_mm": then["gap"]["noise_mm"],
    }


def table(rows):
    """A row a case."""
    lines = [
        "| given back | seed | named without it | unknown | its share | own file sure | took | gap, mm | left, mm | noise, mm |",
        "| --- |" + " --- |" * 9,
    ]
    for r in rows:
        lines.append(
            f"| {r['effect']} | {r['seed']} | {r['named']} | {r['unknown']:.2f} | {100 * r['predicted']:.0f} % | {r['own']:.2f} "
            f"| {100 * r['reached']:.0f} % | {r['before_mm']:.3f} | {r['after_mm']:.3f} | {r['noise_mm']:.3f} |"
        )
    near = sum(abs(r["predicted"] - r["reached"]) <= 0.05 for r in rows)
    found = sum(r["own"] > 0.5 for r in rows)
    return [
        *lines,
        "",
        f"{found} of {len(rows)} files are claimed; in {near} the share that they took is within 5 points of the unknown's.",
    ]


def main() -> None:
    """Ask, and write the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--of", type=Path, required=True, help="where a run of taken_out stands")
    parser.add_argument("--each", type=int, default=1, help="cases of every effect, at the most")
    arguments = parser.parse_args()
    rows, met = [], dict.fromkeys(FORMS, 0)
    for line in read_lines(arguments.of / "sealed" / "labels.jsonl").values():
        task = line["task"]
        if (
            not task.get("without")
            or met.get(task["only"], arguments.each) >= arguments.each
            or not line["label"]["effects"]
        ):
            continue
        met[task["only"]] += 1
        rows.append(judged(task))
        sys.stderr.write(json.dumps(rows[-1]) + "\n")
    (arguments.of / "given_back.md").write_text("\n".join(table(rows)) + "\n")


if __name__ == "__main__":
    main()
