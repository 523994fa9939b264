"""Every file of the corpus that the published method posts, posted with plans too, and verified against its CL file:
python tests/bench/bench_corpus.py [--only PART_OF_NAME] [--json OUT.json]

Each part is centred on the table with its lowest point at 200 mm. Prints one row of a table a file: the mean and the lowest
1/k_F of both methods and of the bound, external travel, seconds, or why a method refuses.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from camrob import post
from camrob.errors import CamrobError
from camrob.jobs.verify import verify
from camrob.toolpath.read import read_toolpath
from camrob.units import m_to_mm

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"
CORPUS = ROOT.parent / "shared" / "corpus"
LOWEST_MM = 200.0
FEED_MM_MIN = 900.0


def setup_of(clfile: Path, folder: Path) -> Path:
    """A setup.toml that centres the part on the table."""
    toolpath = read_toolpath(clfile, units="mm")
    points = np.concatenate([r.position for r in toolpath.regions if len(r)])
    middle = m_to_mm(0.5 * (points.min(axis=0) + points.max(axis=0)))
    low = m_to_mm(float(points[:, 2].min()))
    file = folder / "setup.toml"
    file.write_text(
        f"part_in_base = [{-middle[0]:.3f}, {-middle[1]:.3f}, {LOWEST_MM - low:.3f}, 0.0, 0.0, 0.0]\n"
        f'units = "mm"\nfeed_mm_min = {FEED_MM_MIN}\nspindle_rpm = 12000\n'
    )
    return file


def outcome(clfile: Path, method: str, folder: Path) -> dict[str, Any]:
    """What a method makes of a file."""
    start = time.perf_counter()
    try:
        setup = setup_of(clfile, folder)
        made = post(clfile, cell=CELL, out=folder / method, setup=setup, name="corpus", method=method, report=False)
        checked = verify(folder / method / "corpus.src", cell=CELL, against=clfile, setup=setup)
    except CamrobError as error:
        return {"refused": f"{type(error).__name__}: {error}"[:220], "seconds": time.perf_counter() - start}
    summary = made.summary
    return {
        "points": summary.points,
        "method": summary.method,
        "mean": summary.conditioning.inv_kf_mean,
        "least": summary.conditioning.inv_kf_min,
        "bound": summary.conditioning.inv_kf_bound_mean,
        "travel": dict(summary.external_travel),
        "margin": {k: v for k, v in summary.limits.margin_min.items() if v is not None},
        "plan": None if summary.plan is None else {k: v for k, v in summary.plan.to_json().items() if k != "curve"},
        "notes": [w.text for w in summary.warnings if w.code.startswith(("plan", "retract"))],
        "verified": checked.ok,
        "resolve": (summary.seconds or {})["resolve"],
        "seconds": time.perf_counter() - start,
    }


def row(name: str, found: dict[str, dict[str, Any]]) -> str:
    """One row of the table."""
    plain, planned = found["vjm"], found["planned"]
    if "refused" in plain:
        return (
            f"| {name} | refused by both: {plain['refused']} |"
            if "refused" in planned
            else f"| {name} | only planned |"
        )
    if "refused" in planned:
        beside = f"{plain['points']} | {plain['mean']:.3f} ({plain['least']:.3f})"
        return f"| {name} | {beside} | PLANNED REFUSES: {planned['refused']} |"
    moved = [
        f"{next(iter(f['travel'].values()), 0.0):.0f} / {list(f['travel'].values())[-1]:.0f}" for f in (plain, planned)
    ]
    plan = planned["plan"]
    how = (
        "published"
        if plan is None
        else f"{plan['chosen']}, {plan['repostures']} re-postures, {plan['retracts']} retracts"
    )
    bound = "-" if planned["bound"] is None else f"{planned['bound']:.3f}"
    means = [f"{f['mean']:.3f} ({f['least']:.3f})" for f in (plain, planned)]
    good = "yes" if plain["verified"] and planned["verified"] else "NO"
    return (
        f"| {name} | {plain['points']} | {means[0]} | {means[1]} "
        f"| {bound} | {moved[0]} | {moved[1]} | {how} | {good} | {planned['seconds']:.0f} |"
    )


def main() -> None:
    """Post them all."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--only", default="")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    files = [f for kind in ("cldata", "gcode") for f in sorted((CORPUS / kind).glob("*")) if options.only in f.name]
    if not files:
        raise SystemExit(f"no corpus files {options.only} in {CORPUS}")
    print(
        "| file | points | vjm 1/k_F mean (lowest) | planned | bound | travel vjm mm / deg | planned | how | verified | s |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    everything = {}
    for clfile in files:
        with tempfile.TemporaryDirectory() as folder:
            found = {method: outcome(clfile, method, Path(folder)) for method in ("vjm", "planned")}
        everything[clfile.name] = found
        print(row(clfile.name, found), flush=True)
        if options.json is not None:
            options.json.write_text(json.dumps(everything, indent=1) + "\n")


if __name__ == "__main__":
    main()
