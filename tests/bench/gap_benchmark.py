"""The sealed benchmark of the diagnosis: `python tests/bench/gap_benchmark.py --cases 200 --out DIR`.

Cases come from `gap_generator`, which shares no code with camrob. Labels go to a file outside of the cases' folder and
are opened by the scorer, once every case has been diagnosed. Writes results.json and report.md.
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

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

CELL = Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table"


def one_case(
    folder: str, seed: int, kind: str | None, exclude: tuple[str, ...], without: tuple[str, ...]
) -> tuple[dict, dict]:
    """Make and diagnose one case: the label and what the diagnosis says."""
    from gap_generator import write_case

    label = write_case(Path(folder), seed, kind, exclude)
    from camrob.cell.read_cell import read_cell
    from camrob.gap.diagnose import diagnose
    from camrob.measure.read_log import read_log

    log = read_log(Path(folder) / f"{seed}.csv")
    begin = time.perf_counter()
    try:
        said = dict(diagnose([log], read_cell(CELL), without=without).summary)
    except Exception as error:
        said = {"error": f"{type(error).__name__}: {error}"}
    said["seconds"] = time.perf_counter() - begin
    said["rows"] = len(log)
    (Path(folder) / f"{seed}.csv").unlink()
    return label, said


def interval(hits: int, count: int) -> str:
    """Share with its 95 % Wilson interval."""
    if count == 0:
        return "-"
    p, z = hits / count, 1.96
    mid = (p + z * z / (2 * count)) / (1 + z * z / count)
    half = z * np.sqrt(p * (1 - p) / count + z * z / (4 * count**2)) / (1 + z * z / count)
    return f"{100 * p:.1f} % ({100 * max(0, mid - half):.0f} to {100 * min(1, mid + half):.0f}; {hits} of {count})"


def score(labels: list[dict], said: list[dict]) -> dict:
    """All figures."""
    out: dict = {"cases": len(labels), "errors": sum("error" in s for s in said)}
    rows = [(lab, s) for lab, s in zip(labels, said, strict=True) if "error" not in s]
    claims = lambda s: [e for e in s["effects"] if e["probability"] >= 0.5]  # noqa: E731
    none = [s for lab, s in rows if lab["kind"] == "none"]
    out["false alarms on no-effect data (aim <= 1 %)"] = interval(
        sum(bool(claims(s)) or s["status"] != "no gap" for s in none), len(none)
    )

    def alike(entry: dict, truth: set) -> bool:
        return entry["effect"] in truth or bool(set(entry["indistinguishable_from"]) & truth)

    single = [(set(lab["effects"]), s) for lab, s in rows if len(lab["effects"]) == 1 and lab["kind"] == "one"]
    strong = [
        (set(lab["effects"]), s)
        for lab, s in rows
        if lab["kind"] == "one" and any(e["size"] >= 2 for e in lab["effects"].values())
    ]
    first = lambda t, s: bool(s["effects"]) and s["effects"][0]["effect"] in t  # noqa: E731
    out["one effect at >= 2x noise: right first (aim 95 %)"] = interval(
        sum(first(t, s) for t, s in strong), len(strong)
    )
    out["... up to its stated alias group (aim 99 %)"] = interval(
        sum(bool(s["effects"]) and alike(s["effects"][0], t) for t, s in strong), len(strong)
    )
    out["one effect, any size: exact set"] = interval(
        sum({e["effect"] for e in claims(s)} == t for t, s in single), len(single)
    )
    inside = [(set(lab["effects"]), s) for lab, s in rows if lab["kind"] in ("one", "two", "three") and lab["effects"]]

    def reported(s: dict) -> list[set]:
        total, sets = 0.0, []
        for a in s["alternatives"]:
            sets.append(set(a["effects"]) - {"unknown"})
            total += a["probability"]
            if total >= 0.98:
                break
        return sets

    out["truth in the reported set (aim 98 %)"] = interval(
        sum(any(t == r for r in reported(s)) for t, s in inside), len(inside)
    )
    out["mean size of the reported set (aim <= 1.5)"] = (
        f"{np.mean([len(reported(s)) for _, s in inside]):.2f}" if inside else "-"
    )
    for kind, aim in (("two", "95, 93, 85 %"), ("three", "-, -, 65 %")):
        some = [(set(lab["effects"]), s) for lab, s in rows if lab["kind"] == kind]
        found = [(t, {e["effect"] for e in claims(s)}) for t, s in some]
        hit, total, said_n = (
            sum(len(t & f) for t, f in found),
            sum(len(t) for t, _ in found),
            sum(len(f) for _, f in found),
        )
        out[f"{kind} effects: recall, precision, exact (aim {aim})"] = (
            f"{interval(hit, total)}; {interval(hit, said_n)}; {interval(sum(t == f for t, f in found), len(found))}"
        )
    outside = [s for lab, s in rows if lab["kind"] == "outside" and lab["effects"]]
    flagged = lambda s: s["unknown"]["probability"] >= 0.5 or s["status"] in ("unexplained", "partly explained")  # noqa: E731
    out["outside the library: flagged (aim 90 %)"] = interval(sum(flagged(s) for s in outside), len(outside))
    out["... some name above 0.8 (aim none)"] = interval(
        sum(any(e["probability"] > 0.8 for e in s["effects"]) for s in outside), len(outside)
    )
    out["false unknowns (aim <= 5 %)"] = interval(sum(flagged(s) for _, s in inside), len(inside))
    pairs = [(e["probability"], e["effect"] in lab["effects"]) for lab, s in rows for e in s["effects"]]
    if pairs:
        p, y = np.array([x for x, _ in pairs]), np.array([x for _, x in pairs], float)
        bins = np.clip((p * 10).astype(int), 0, 9)
        curve = [
            (float(p[bins == b].mean()), float(y[bins == b].mean()), int((bins == b).sum())) for b in np.unique(bins)
        ]
        out["calibration error of claims (aim <= 0.05)"] = f"{sum(n * abs(a - c) for a, c, n in curve) / len(p):.3f}"
        out["calibration curve (said, true, count)"] = [[round(a, 2), round(c, 2), n] for a, c, n in curve]
    removed = [
        s["together"]["removable_removed"]
        for lab, s in rows
        if lab["kind"] in ("one", "two", "three") and s["together"]["removable_removed"] is not None
    ]
    if removed:
        out["removable gap removed on withheld blocks: median, 10th percentile (aim 97 %, 90 %)"] = (
            f"{100 * np.median(removed):.1f} %, {100 * np.quantile(removed, 0.1):.1f} %"
        )
    axes = [
        (lab["effects"][e["effect"]]["axes"], e["axes"])
        for lab, s in rows
        for e in claims(s)
        if "axes" in lab["effects"].get(e["effect"], {})
    ]
    out["axes named exactly, where the effect was (aim 92 %)"] = interval(
        sum(set(a) == set(b) for a, b in axes), len(axes)
    )
    seconds = [s["seconds"] for _, s in rows]
    out["seconds a case: median, worst"] = (
        f"{np.median(seconds):.1f}, {np.max(seconds):.1f} (median of {np.median([s['rows'] for _, s in rows]):.0f} rows)"
    )
    by: dict = {}
    for lab, s in rows:
        for name, e in lab["effects"].items():
            band = "0.5 to 2" if e["size"] < 2 else "2 to 20"
            hit = any(c["effect"] == name for c in claims(s)) if lab["kind"] != "outside" else flagged(s)
            by.setdefault(name, {}).setdefault(band, []).append(bool(hit))
    out["found, by effect and size"] = {
        n: {b: f"{sum(v)} of {len(v)}" for b, v in d.items()} for n, d in sorted(by.items())
    }
    wrong: dict = {}
    for lab, s in rows:
        for e in claims(s):
            if e["effect"] not in lab["effects"]:
                key = f"{' + '.join(sorted(lab['effects'])) or 'nothing'} -> {e['effect']}"
                wrong[key] = wrong.get(key, 0) + 1
    out["wrongly claimed (truth -> claim)"] = dict(sorted(wrong.items(), key=lambda x: -x[1]))
    return out


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--kind", choices=["none", "one", "two", "three", "outside"])
    parser.add_argument(
        "--without", action="append", default=[], help="take an effect out of the library; cases have just it"
    )
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    labels, said = [], []
    begin = time.time()
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor(arguments.workers) as workers:
        seeds = range(arguments.first, arguments.first + arguments.cases)
        jobs = [workers.submit(one_case, folder, s, arguments.kind, (), tuple(arguments.without)) for s in seeds]
        for k, job in enumerate(jobs):
            label, answer = job.result()
            labels.append(label)
            said.append(answer)
            sys.stderr.write(f"\r{k + 1} of {arguments.cases}, {time.time() - begin:.0f} s ")
    sealed = json.dumps(labels, sort_keys=True, default=float)
    figures = {"labels sha256": hashlib.sha256(sealed.encode()).hexdigest(), **score(labels, said)}
    everything = [{"label": lab, "said": s} for lab, s in zip(labels, said, strict=True)]
    (arguments.out / "results.json").write_text(json.dumps(everything, default=float))
    lines = ["# Sealed benchmark of `camrob diagnose`", ""]
    for name, value in figures.items():
        if isinstance(value, dict):
            lines += [f"- {name}:", *(f"  - {k}: {v}" for k, v in value.items())]
        else:
            lines.append(f"- {name}: {value}")
    (arguments.out / "report.md").write_text("\n".join(lines) + "\n")
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
