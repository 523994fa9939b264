"""Figures of the gap benchmark where a smooth field stands beside every effect: the unknown is then part of every true answer."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gap.score import CLAIM, calibration, of, upper_bound

SURE = 0.8
# times the field
BANDS = ((0.0, 0.2), (0.2, 0.4), (0.4, 1.0), (1.0, 2.0), (2.0, 20.01))
# rows of the log that was fitted
LENGTHS = ((0, 500), (500, 1000), (1000, 2500), (2500, 5000), (5000, 20000))


def _wrong(row, least):
    """Names said with so much probability that are neither true nor, on this path, the same as what is."""
    said = {e["effect"] for e in row.said["effects"] if e["probability"] >= least} - row.truth
    if not said:
        return set()
    if row.kind == "outside":
        return set() if row.within() else said
    return set() if row.same(row.claims) else said


def field_figures(rows):
    """Figures by name of `rows`, every one of which has a field."""
    rows = [r for r in rows if "error" not in r.said]
    inside = [r for r in rows if r.truth]
    named = [(r.sizes[n] / r.label["field"], n in r.claims) for r in inside for n in r.truth]
    quiet = [bool(r.claims) for r in rows if not r.truth]
    off = [
        100.0 * (r.said["together"]["predicted_shrink"] - r.said["together"]["shrink"])
        for r in rows
        if r.claims and r.said["together"].get("predicted_shrink") is not None
    ]
    pairs = [(e["probability"], e["effect"] in r.truth) for r in rows for e in r.said["effects"]]
    seconds = np.array([[r.said["rows"], r.said["seconds"]] for r in rows])
    lengths = [(a, b, seconds[(seconds[:, 0] >= a) & (seconds[:, 0] < b), 1]) for a, b in LENGTHS]
    return {
        "cases": len(rows),
        "errors": [f"{r.task['seed']}: {r.said['error']}" for r in rows if "error" in r.said],
        "something unknown said": of(r.flagged for r in rows),
        "true effects claimed, by size against the field": {
            f"{a:g} to {b:.3g}": of(hit for size, hit in named if a <= size < b) for a, b in BANDS
        },
        "leads, where one effect is as large as the field or larger": of(
            r.first in r.truth for r in inside if r.kind == "one" and max(r.sizes.values()) >= r.label["field"]
        ),
        "claims that are true": of(n in r.truth for r in rows for n in r.claims),
        "cases with a wrong claim": of(bool(_wrong(r, CLAIM)) for r in rows),
        "cases with a wrong name above 0.8": of(bool(_wrong(r, SURE)) for r in rows),
        "a claim where no effect of the library is": of(quiet)
        | {"upper 95 % bound": upper_bound(sum(quiet), len(quiet))},
        "truth in the reported sets (up to groups)": of(any(h for _, _, h in r.told()) for r in inside),
        "calibration of effects": calibration(pairs),
        "predicted shrinkage within 5 points of reached": of(abs(x) <= 5.0 for x in off),
        "wrong names": [
            f"{r.task['seed']}: {', '.join(sorted(_wrong(r, CLAIM)))} for {', '.join(r.label['effects']) or 'the field alone'}"
            for r in rows
            if _wrong(r, CLAIM)
        ],
        "seconds by rows": {
            f"{a} to {b}": [len(s), float(np.median(s)), float(np.quantile(s, 0.95))] for a, b, s in lengths if len(s)
        },
    }


def _share(record):
    if not record["count"]:
        return "no case"
    low, high = record["interval"]
    return f"{100 * record['share']:.1f} % ({100 * low:.0f} to {100 * high:.0f}; {record['hits']} of {record['count']})"


def write_field_report(figures, folder: Path, field: float):
    """Write report.md of `field_figures`; field: its size, times the instrument's noise."""
    f = figures
    aims = {
        "something unknown said": "100 %",
        "truth in the reported sets (up to groups)": "98 %",
        "cases with a wrong name above 0.8": "none",
        "predicted shrinkage within 5 points of reached": "90 %",
    }
    rows = [(k, aims.get(k, "-"), _share(v)) for k, v in f.items() if isinstance(v, dict) and "hits" in v]
    rows += [("calibration error of effects", "0.05", f"{f['calibration of effects']['error']:.3f}")]
    lines = [
        f"# `camrob diagnose` beside a smooth field of {field:g} times the noise",
        "",
        "The cases of the report without a field (the same maker, other seeds), and beside their effects a field over posture",
        "that no effect of the library can be: so part of every gap is unknown, and saying so is right. Sizes are against the",
        "field. A wrong name is one that is neither true nor looks, on that path, within 6 degrees like what is. Intervals are",
        "95 % (Wilson).",
        "",
        f"Cases: {f['cases']}. SHA-256 of the labels: `{f['sha256 of the labels']}`.",
        "",
        "| measure | aim | reached |",
        "| --- | --- | --- |",
        *(f"| {name} | {aim} | {said} |" for name, aim, said in rows),
        "",
        "| size of the effect, times the field | claimed by name |",
        "| --- | --- |",
        *(f"| {k} | {_share(v)} |" for k, v in f["true effects claimed, by size against the field"].items()),
        "",
        "| rows fitted | cases | seconds of one core, median | 95 % |",
        "| --- | --- | --- | --- |",
        *(f"| {k} | {n} | {m:.1f} | {p:.1f} |" for k, (n, m, p) in f["seconds by rows"].items()),
        "",
        "Calibration (probability said, share true, number of answers): "
        + "; ".join(f"{a:.2f}, {b:.2f}, {n}" for a, b, n in f["calibration of effects"]["curve"])
        + ".",
        "",
        "Wrong claims, by seed:",
        "",
        *(f"- {x}" for x in f["wrong names"]),
        *(f"- ended with an error: {x}" for x in f["errors"]),
        "",
    ]
    (folder / "report.md").write_text("\n".join(lines))
