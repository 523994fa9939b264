"""Figures from labels and answers, with Wilson intervals. A name is claimed from a probability of 0.5 on."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
KINDS = ((20, "poses"), (31, "paths"), (39, "drives"), (99, "beside a foreign one"))


def wilson(hits, of):
    """(low, high) of a share, 95 %."""
    if not of:
        return 0.0, 1.0
    z, p = 1.96, hits / of
    middle, half = p + z * z / (2 * of), z * np.sqrt(p * (1 - p) / of + z * z / (4 * of * of))
    return max(0.0, (middle - half) / (1 + z * z / of)), min(1.0, (middle + half) / (1 + z * z / of))


def claims(said):
    return [e for e in said.get("effects", []) if e["probability"] >= 0.5]


def reported(said):
    """Names in the fewest alternatives that hold 95 %."""
    names, held = set(), 0.0
    for s in sorted(said.get("alternatives", []), key=lambda a: -a["probability"]):
        if held >= 0.95:
            break
        names.update(s["effects"])
        held += s["probability"]
    return names


def outcome(cause, said):
    """right, alike, contained or missed; a foreign cause has none."""
    named = claims(said)
    if any(e["effect"] == cause["name"] for e in named):
        return "right"
    if any(e["effect"] in cause["alike"] for e in named):
        return "alike"
    wide = reported(said).union(
        *[set(e.get("class") or []) | set(e.get("indistinguishable_from") or []) for e in named] or [set()]
    )
    return "contained" if cause["name"] in wide else "missed"


def axis_right(cause, said):
    for e in claims(said):
        if e["effect"] == cause["name"]:
            return not cause["axes"] or not e["axes"] or e["axes"][0] in cause["axes"]
    return None


def place(cause, said):
    """Whether stage, axis and what it follows are those of a foreign cause."""
    where = (said.get("unknown") or {}).get("where") or {}
    axes, regimes = where.get("axes") or [], where.get("regimes") or []
    if cause["place"]:
        axis = bool(axes) and axes[0] in cause["place"]
    else:  # no axis's own, or that of all drives
        axis = not axes or (cause["stage"] == "setpoint_to_encoder" and len(axes) > 1)
    return {
        "stage": where.get("rung") == cause["stage"],
        "axis": axis,
        "follows": bool(set(regimes) & set(cause["follows"])),
    }


def wrong(claim, label, by_name=False):
    """Whether a claim is at odds with its label; what is alike by physics is no error unless judged by names alone."""
    good = {c["name"] for c in label["causes"]}
    if not by_name:
        for c in label["causes"]:
            good.update(c["alike"])
    return claim["effect"] not in good


class Tally(dict):
    def add(self, name, hit):
        hits, of = self.get(name, (0, 0))
        self[name] = (hits + bool(hit), of + 1)


def _causes(tally, label, said):
    kind = (
        "poses"
        if label["key"] < 20
        else "paths"
        if label["key"] < 31
        else "drives"
        if label["key"] < 39
        else "beside a foreign one"
    )
    named = [c for c in label["causes"] if not c["foreign"]]
    for c in named:
        got = outcome(c, said)
        band = "twice the floor and more" if c["ratio"] >= 1.99 else "below twice the floor"
        tally.add(f"named, {band}: right", got == "right")
        tally.add(f"named, {band}: right or alike", got in ("right", "alike"))
        tally.add(f"named, {band}: contained", got != "missed")
        if c["ratio"] >= 1.99:
            tally.add(f"{kind}, twice the floor: right", got == "right")
            tally.add(
                f"{'several causes' if len(label['causes']) > 1 else 'one cause'}, twice the floor: right",
                got == "right",
            )
            if label["wander"]:
                tally.add("instrument wanders, twice the floor: right", got == "right")
            if label["left_mm"] >= 2 * label["noise_mm"]:
                tally.add("leftover of twice the noise, twice the floor: right", got == "right")
        if axis_right(c, said) is not None:
            tally.add("named: axis right where claimed", axis_right(c, said))


def _whole(tally, label, said):
    named = claims(said)
    for e in named:
        tally.add("all claims: wrong by the name alone", wrong(e, label, True))
        tally.add("all claims: wrong", wrong(e, label))
        if e["probability"] > 0.8:
            tally.add("claims above 0.8: wrong by the name alone", wrong(e, label, True))
            tally.add("claims above 0.8: wrong", wrong(e, label))
    unknown = ((said.get("unknown") or {}).get("probability") or 0) >= 0.5
    foreign = [c for c in label["causes"] if c["foreign"]]
    for c in foreign:
        got = place(c, said)
        tally.add("foreign: unknown said", unknown)
        for name, hit in got.items():
            tally.add(f"foreign: {name} right", hit)
        tally.add("foreign: place right in all", all(got.values()))
        tally.add("foreign: a wrong name claimed", any(wrong(e, label) for e in named))
        tally.add("foreign: a wrong name above 0.8", any(wrong(e, label) and e["probability"] > 0.8 for e in named))
    if not label["causes"]:
        tally.add("nothing wrong: no gap said", said["status"] == "no gap")
        tally.add("nothing wrong: a cause claimed", bool(named))
    elif not foreign:
        big = label["left_mm"] >= 2 * label["noise_mm"]
        tally.add(
            "leftover of twice the noise: unknown said" if big else "leftover below twice the noise: unknown said",
            unknown,
        )
        if not label["left_mm"]:
            tally.add("no leftover at all: unknown said falsely", unknown)
    together = said.get("together") or {}
    shrink, foretold = together.get("shrink"), together.get("predicted_shrink")
    if shrink is not None and foretold is not None:
        tally.add("foretold within 5 points of reached", abs(shrink - foretold) <= 0.05)
        if named:
            tally.add("foretold within 5 points, where anything is claimed", abs(shrink - foretold) <= 0.05)
    named_causes = [c for c in label["causes"] if not c["foreign"]]
    if shrink is not None and named_causes and all(outcome(c, said) in ("right", "alike") for c in named_causes):
        tally.add(
            "reached within 5 points of the simulator's, where all are claimed",
            abs(shrink - label["removable"]) <= 0.05,
        )


def calibration(pairs, bins=10):
    """Mean distance between what was said and how often it was right, by bins."""
    said, true = np.array([p for p, _ in pairs]), np.array([t for _, t in pairs], float)
    where = np.minimum((said * bins).astype(int), bins - 1)
    return sum(abs(said[where == b].mean() - true[where == b].mean()) * np.mean(where == b) for b in np.unique(where))


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


def _case_row(label, said):
    causes = ", ".join(
        f"{c['name']} {'/'.join(c['axes'])} ({c['ratio']}, {'foreign' if c['foreign'] else outcome(c, said)})"
        for c in label["causes"]
    )
    named = ", ".join(f"{e['effect']} {'/'.join(e['axes'])} {e['probability']:.2f}" for e in claims(said))
    unknown = said.get("unknown") or {}
    where = unknown.get("where") or {}
    parts = [where.get("rung") or "", "/".join(where.get("axes") or []), "/".join(where.get("regimes") or [])]
    there = " ".join([f"{unknown.get('probability') or 0:.2f}", *parts])
    reached = (said.get("together") or {}).get("shrink")
    reached = "" if reached is None else f"{reached:.2f}"
    title = f"{label['machine']}: {label['title']}"
    return f"| {label['key']} | {title} | {causes} | {said['status']} | {named} | {there} | {reached}, {label['removable']} |"


def page(labels, answers):
    """Tables in Markdown."""
    tally, error, seconds, refused = figures(labels, answers)
    rows = ["| | | share | interval |", "| --- | --- | --- | --- |"]
    for name in sorted(tally):
        hits, of = tally[name]
        low, high = wilson(hits, of)
        rows.append(f"| {name} | {hits} of {of} | {100 * hits / of:.0f} % | {100 * low:.0f} to {100 * high:.0f} % |")
    spent = f"Seconds of processor: median {np.median(seconds):.1f}, most {max(seconds):.1f}."
    rows += ["", f"Calibration error {error:.3f}. Refused: {refused}. {spent}"]
    verdicts = steps()
    if verdicts:
        rows += ["", "| first step of the page | | share | interval |", "| --- | --- | --- | --- |"]
        for verdict in ("right", "half", "wrong", "refused"):
            hits = sum(v == verdict for v, _ in verdicts.values())
            low, high = wilson(hits, len(verdicts))
            share = 100 * hits / len(verdicts)
            rows.append(
                f"| {verdict} | {hits} of {len(verdicts)} | {share:.0f} % | {100 * low:.0f} to {100 * high:.0f} % |"
            )
        rows += ["", "| case | | why |", "| --- | --- | --- |"]
        rows += [f"| {k} | {v} | {why} |" for k, (v, why) in sorted(verdicts.items()) if v != "right"]
    rows += [
        "",
        "| case | what it is | causes (by the floor) | status | claimed | unknown, its place | reached, simulator's |",
    ]
    rows += ["| --- | --- | --- | --- | --- | --- | --- |"] + [
        _case_row(label, answers[label["key"]]) for label in labels
    ]
    return "\n".join(rows) + "\n"
