"""Asks camrob of drawn cases: ``run.py FIRST LAST OUT.jsonl`` appends answers, ``run.py --score OUT.jsonl`` prints figures."""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from gap.before_after.draw import ALIKE, case
from gap.before_after.machine import cell_text

CELLS = {}


def cell_of(arm):
    """An arm's cell, read from its file."""
    from camrob.cell.read_cell import read_cell

    if arm not in CELLS:
        folder = Path(tempfile.mkdtemp())
        (folder / "cell.toml").write_text(cell_text(arm, arm))
        CELLS[arm] = read_cell(folder)
    return CELLS[arm]


def log_of(log):
    """A log as camrob reads it."""
    from camrob.measurement.log import MeasurementLog
    from camrob.measurement.log_info import read_info

    folder = Path(tempfile.mkdtemp())
    lines = [f"{k} = {json.dumps(v)}" for k, v in log["info"].items()]
    (folder / "log.toml").write_text("\n".join(lines) + "\n")
    return MeasurementLog(log["columns"], read_info(folder / "log.toml"), folder / log["name"])


def asked(seed):
    """Label and answer of a drawn case."""
    from camrob.gap.diagnose import diagnose

    c = case(seed)
    start = time.process_time()
    try:
        said = diagnose(
            [log_of(x) for x in c["logs"]], cell_of(c["arm"]), withheld=[log_of(x) for x in c["withheld"]]
        ).summary.to_json()
        said = json.loads(json.dumps(said))
    except Exception as error:  # what can't be asked is counted
        said = {"status": "refused", "why": repr(error), "effects": []}
    kept = {k: said.get(k) for k in ("status", "effects", "unknown", "together", "why", "changed")}
    return {"label": c["label"], "said": kept, "seconds": time.process_time() - start}


def outcome(label, said):
    """right, class, wrong axis, old (claimed as if it had always been so), wrong, none; of nothing: quiet or alarm."""
    claimed = [e for e in said["effects"] if e["probability"] >= 0.5]
    new = [e for e in claimed if e.get("since")]
    if label["nothing"]:
        return "alarm" if [e for e in new if e["of_machine"]] else "quiet"
    alike = ALIKE.get(label["kind"], set())
    hit = [e for e in new if e["effect"] == label["name"]]
    if hit and (label["axis"] is None or label["axis"] in hit[0]["axes"] or label["kind"] == "links"):
        return "right"
    if hit:
        return "wrong axis"
    if [e for e in new if e["effect"] in alike or label["name"] in e["indistinguishable_from"]]:
        return "class"
    if new:
        return "wrong"
    return "old" if [e for e in claimed if e["effect"] in {label["name"], *alike}] else "none"


def scored(rows):
    """Counts by kind."""
    by, sure = {}, 0
    for row in rows:
        label = row["label"]
        key = "nothing" if label["nothing"] else f"{label['kind']}{' within' if label['within'] else ''}"
        got = outcome(label, row["said"])
        by.setdefault(key, Counter())[got] += 1
        by.setdefault("all nothing" if label["nothing"] else "all changed", Counter())[got] += 1
        new = [e for e in row["said"]["effects"] if e["probability"] > 0.8 and e.get("since")]
        sure += got in ("wrong", "wrong axis", "alarm") and bool(new)
    return by, sure


def main():
    if sys.argv[1] == "--score":
        rows = [json.loads(x) for x in Path(sys.argv[2]).read_text().splitlines()]
        by, sure = scored(rows)
        for key in sorted(by):
            print(f"{key:16}", dict(by[key]))
        print("sure and wrong", sure, "of", len(rows), "median s", sorted(r["seconds"] for r in rows)[len(rows) // 2])
        return
    first, last, out = int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3])
    for seed in range(first, last):
        row = asked(seed)
        with out.open("a") as f:
            f.write(json.dumps(row) + "\n")
        names = [
            (e["effect"], bool(e.get("since")), e["axes"], round(e["probability"], 2))
            for e in row["said"]["effects"]
            if e["probability"] >= 0.5
        ]
        x = row["label"]
        print(
            seed,
            outcome(x, row["said"]),
            row["said"]["status"],
            f"{row['seconds']:.1f}",
            {k: x[k] for k in ("nothing", "name", "axis", "within", "old", "poses", "known", "n", "level")},
            names,
            row["said"].get("why") or "",
            flush=True,
        )


if __name__ == "__main__":
    main()
