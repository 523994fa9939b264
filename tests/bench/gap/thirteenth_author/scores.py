"""The twelfth author's figures, of these labels: what is right, contained or wrong is judged by that author's own functions."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from gap.twelfth_author.scores import Tally, axis_right, calibration, claims, outcome, place, wilson, wrong

HERE = Path(__file__).parent
KINDS = {"poses": "poses", "paths": "paths", "drives": "drives", "foreign": "beside a foreign one"}


def _causes(tally, label, said):
    for c in [c for c in label["causes"] if not c["foreign"]]:
        got = outcome(c, said)
        loud = c["ratio"] >= 1.99
        band = "twice the floor and more" if loud else "below twice the floor"
        tally.add(f"named, {band}: right", got == "right")
        tally.add(f"named, {band}: right or alike", got in ("right", "alike"))
        tally.add(f"named, {band}: contained", got != "missed")
        if loud:
            several = "several causes" if len(label["causes"]) > 1 else "one cause"
            for name in (KINDS[label["kind"]], several):
                tally.add(f"{name}, twice the floor: right", got == "right")
            if label["wander"]:
                tally.add("instrument wanders, twice the floor: right", got == "right")
            if label["left_mm"] >= 2 * label["noise_mm"]:
                tally.add("leftover of twice the noise, twice the floor: right", got == "right")
            if c["since"]:
                tally.add("since a moment or a service, twice the floor: right", got == "right")
        if axis_right(c, said) is not None:
            tally.add("named: axis right where claimed", axis_right(c, said))


def _foreign(tally, label, said, unknown):
    named = claims(said)
    for c in [c for c in label["causes"] if c["foreign"]]:
        got = place(c, said)
        tally.add("foreign: unknown said", unknown)
        for name, hit in got.items():
            tally.add(f"foreign: {name} right", hit)
        tally.add("foreign: place right in all", all(got.values()))
        tally.add("foreign: a wrong name claimed", any(wrong(e, label) for e in named))
        tally.add("foreign: a wrong name above 0.8", any(wrong(e, label) and e["probability"] > 0.8 for e in named))


def _whole(tally, label, said):
    named = claims(said)
    for e in named:
        for name in ["all claims"] + ["claims above 0.8"] * (e["probability"] > 0.8):
            tally.add(f"{name}: wrong by the name alone", wrong(e, label, True))
            tally.add(f"{name}: wrong", wrong(e, label))
    unknown = ((said.get("unknown") or {}).get("probability") or 0) >= 0.5
    _foreign(tally, label, said, unknown)
    if not label["causes"]:
        tally.add("nothing wrong: no gap said", said["status"] == "no gap")
        tally.add("nothing wrong: a cause claimed", bool(named))
    elif not any(c["foreign"] for c in label["causes"]):
        big = label["left_mm"] >= 2 * label["noise_mm"]
        tally.add(f"leftover {'of' if big else 'below'} twice the noise: unknown said", unknown)
        if not label["left_mm"]:
            tally.add("no leftover at all: unknown said falsely", unknown)
    together = said.get("together") or {}
    shrink, foretold = together.get("shrink"), together.get("predicted_shrink")
    if shrink is not None and foretold is not None:
        near = abs(shrink - foretold) <= 0.05
        tally.add("foretold within 5 points of reached", near)
        if named:
            tally.add("foretold within 5 points, where anything is claimed", near)
    usual = [c for c in label["causes"] if not c["foreign"]]
    if shrink is not None and usual and all(outcome(c, said) in ("right", "alike") for c in usual):
        tally.add(
            "reached within 5 points of the simulator's, where all are claimed",
            abs(shrink - label["removable"]) <= 0.05,
        )


def steps():
    """Verdicts of first steps, read by a person: key to (verdict, why)."""
    file = HERE / "steps.csv"
    if not file.is_file():
        return {}
    with file.open(encoding="utf-8", newline="") as rows:
        return {int(r["case"]): (r["verdict"], r["why"]) for r in csv.DictReader(rows)}


def figures(labels, answers):
    """Tally, calibration error, seconds, refused cases."""
    tally, pairs, seconds, refused = Tally(), [], [], []
    for label in labels:
        said = answers[label["key"]]
        tally.add("answered", said["status"] != "refused")
        if said["status"] == "refused":
            refused.append(label["key"])
        else:
            seconds.append(said["seconds"])
            pairs += [(e["probability"], not wrong(e, label)) for e in said["effects"]]
        _causes(tally, label, said)
        _whole(tally, label, said)
    return tally, calibration(pairs) if pairs else 0.0, seconds, refused


def _shares(counts, title):
    rows = [f"| {title} | | share | interval |", "| --- | --- | --- | --- |"]
    for name, (hits, of) in counts:
        low, high = wilson(hits, of)
        rows.append(f"| {name} | {hits} of {of} | {100 * hits / of:.0f} % | {100 * low:.0f} to {100 * high:.0f} % |")
    return rows


def _case_row(label, said):
    def told(c):
        return f"{c['name']} {'/'.join(c['axes'])} ({c['ratio']}, {'foreign' if c['foreign'] else outcome(c, said)})"

    named = ", ".join(f"{e['effect']} {'/'.join(e['axes'])} {e['probability']:.2f}" for e in claims(said))
    unknown = said.get("unknown") or {}
    where = unknown.get("where") or {}
    there = [f"{unknown.get('probability') or 0:.2f}", where.get("rung") or ""]
    there += ["/".join(where.get(n) or []) for n in ("axes", "regimes")]
    reached = (said.get("together") or {}).get("shrink")
    reached = "" if reached is None else f"{reached:.2f}"
    cells = [
        str(label["key"]),
        f"{label['machine']}: {label['title']}",
        ", ".join(map(told, label["causes"])),
        said["status"],
    ]
    return "| " + " | ".join([*cells, named, " ".join(there), f"{reached}, {label['removable']}"]) + " |"


def page(labels, answers):
    """Tables in Markdown."""
    tally, error, seconds, refused = figures(labels, answers)
    rows = _shares(sorted(tally.items()), "")
    spent = f"Seconds of processor: median {np.median(seconds):.1f}, most {max(seconds):.1f}."
    rows += ["", f"Calibration error {error:.3f}. Refused: {refused}. {spent}"]
    verdicts = steps()
    if verdicts:
        count = [
            (v, (sum(v == x for x, _ in verdicts.values()), len(verdicts)))
            for v in ("right", "half", "wrong", "refused")
        ]
        rows += ["", *_shares(count, "first step of the page"), "", "| case | | why |", "| --- | --- | --- |"]
        rows += [f"| {k} | {v} | {why} |" for k, (v, why) in sorted(verdicts.items()) if v != "right"]
    rows += [
        "",
        "| case | what it is | causes (by the floor) | status | claimed | unknown, its place | reached, simulator's |",
    ]
    rows += ["| --- | --- | --- | --- | --- | --- | --- |"] + [_case_row(x, answers[x["key"]]) for x in labels]
    return "\n".join(rows) + "\n"
