"""Figures from labels and answers: `figures.py LABELS.jsonl ANSWERS.jsonl --title TEXT --out REPORT.md`."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from gap.score import calibration, of

CLAIM = 0.5
SIZES = ((0.0, 0.5), (0.5, 2.0), (2.0, np.inf))
OUTCOMES = ("right", "contained", "wrong", "unknown", "missed")


class Case:
    """One case: its label and its answer."""

    def __init__(self, label, said):
        self.label, self.said = label, said
        for cause in label["causes"]:  # a lag that all axes share is the clock's, where no encoder is logged
            if cause["name"] == "servo_lag" and not label["log"]["encoders"]:
                cause["alike"] = [*cause["alike"], "latency"]
        self.own = [c for c in label["causes"] if not c["foreign"]]
        self.foreign = [c for c in label["causes"] if c["foreign"]]
        self.noise, self.leftover = label["noise_mm"], label["leftover_mm"]
        self.floor = self.leftover or self.noise
        self.claims = [e for e in said["effects"] if e["probability"] >= CLAIM]
        status = said["status"] in ("unexplained", "partly explained")
        self.flagged = said["unknown"]["probability"] >= CLAIM or status

    def is_true(self, effect):
        """A listed effect is at work, or looks here like one that is."""
        names = {effect["effect"], *(effect.get("class") or ())}
        for cause in self.label["causes"]:
            if (not cause["foreign"] and cause["name"] in names) or effect["effect"] in cause["alike"]:
                return True
        return False

    def wrong(self, least=CLAIM):
        """Claims above `least` of what is neither at work nor alike."""
        return [e for e in self.claims if e["probability"] > least - 1e-12 and not self.is_true(e)]

    def told(self, hold=0.95):
        """The fewest alternatives that hold so much."""
        likely = sorted(self.said["alternatives"], key=lambda a: -a["probability"])
        return likely[: int(np.searchsorted(np.cumsum([a["probability"] for a in likely]), hold - 1e-9)) + 1]

    def outcome(self, cause):
        """What became of one cause that the contract has a name for."""
        good = {cause["name"], *cause["alike"]}
        if any(e["effect"] in good or cause["name"] in (e.get("class") or ()) for e in self.claims):
            return "right"
        if any(good & set(a["effects"]) for a in self.told()):
            return "contained"
        if self.wrong():
            return "wrong"
        return "unknown" if self.flagged else "missed"

    def place(self):
        """Stage, axis, and what it follows, of a foreign cause that is alone: each said first."""
        (cause,) = self.foreign
        where = self.said["unknown"]["where"] or {"rung": None, "axes": [], "regimes": []}
        axes, regimes = where["axes"][:1], where["regimes"][:1]
        return {
            "stage": where["rung"] == cause["stage"],
            "axis": axes[0] in cause["axes"] if axes else not cause["axes"],
            "what it follows": bool(regimes) and regimes[0] in cause["follows"],
        }


def agreed(cases):
    """Of causes claimed by their own name: whether the axes are the true ones, and each parameter of a shared name is."""
    axes, values = [], []
    for c in cases:
        for k in c.own:
            claim = next((e for e in c.claims if e["effect"] == k["name"]), None)
            if claim is None:
                continue
            if k["axes"]:
                axes.append(set(claim["axes"]) == set(k["axes"]))
            for key, found in claim["parameters"].items():
                true = k["params"].get(key)
                if isinstance(true, float) and isinstance(found, dict):
                    values.append(abs(found["value"] - true) <= max(0.2 * abs(true), 3 * found["std"]))
    return axes, values


def words(record):
    """A share in words."""
    if record["share"] is None:
        return "no case"
    low, high = record["interval"]
    return f"{100 * record['share']:.0f} % ({100 * low:.0f} to {100 * high:.0f}; {record['hits']} of {record['count']})"


def by_size(cases):
    """Rows of outcomes by size against the floor."""
    rows = []
    for low, high in SIZES:
        sizes = [c.outcome(k) for c in cases for k in c.own if low <= k["size_mm"] / c.floor < high]
        name = f"{low:g} to {high:g} times" if np.isfinite(high) else f"{low:g} times and more"
        rows.append([name, str(len(sizes)), *(words(of(o == what for o in sizes)) for what in OUTCOMES)])
    return rows


def figures(cases):
    """[(what, aim, figure)] of one group of cases."""
    claims = [(c, e) for c in cases for e in c.claims]
    wrong = [(c, e) for c, e in claims if not c.is_true(e)]
    sure = [(c, e) for c, e in claims if e["probability"] > 0.8]
    said = [(e["probability"], c.is_true(e)) for c in cases for e in c.said["effects"]]
    strong = [(c, k) for c in cases for k in c.own if k["size_mm"] >= c.floor]
    alone = [c for c in cases if c.foreign and not c.own]
    places = [c.place() for c in alone]
    off = [
        100 * (c.said["together"]["predicted_shrink"] - c.said["together"]["shrink"])
        for c in cases
        if c.claims and None not in (c.said["together"]["predicted_shrink"], c.said["together"]["shrink"])
    ]
    rough = [c for c in cases if c.leftover >= 2 * c.noise]
    clean = [c for c in cases if not c.leftover and not c.foreign]
    quiet = [c for c in cases if not c.label["causes"]]
    held = [c.outcome(k) in ("right", "contained") for c, k in strong]
    curve = calibration(said) if said else {"error": None}
    error = "-" if curve["error"] is None else f"{curve['error']:.3f} ({len(said)} said)"
    named = [c.flagged or (bool(c.claims) and not c.wrong()) for c in alone]
    excused = [e["effect"] in c.label.get("leftover_alike", []) for c, e in wrong]
    axes, values = agreed(cases)
    return [
        ("claims", "600", str(len(claims))),
        ("... wrong", "-", words(of(not c.is_true(e) for c, e in claims))),
        ("... of them what the leftover alone looks like here", "-", words(of(excused))),
        ("claims above 0.8 that are wrong", "0.5 %", words(of(not c.is_true(e) for c, e in sure))),
        ("truth (at least the floor) claimed or in the reported set", "98 %", words(of(held))),
        ("axes, where the cause's own name is claimed", "-", words(of(axes))),
        ("... parameters of the label's names within 20 % or 3 sigma", "-", words(of(values))),
        ("mean size of the reported set", "2", f"{np.mean([len(c.told()) for c in cases]):.1f}" if cases else "-"),
        ("calibration error of effects", "0.05", error),
        ("predicted within 5 points of reached shrinkage", "90 %", words(of(abs(x) <= 5 for x in off))),
        ("unknown said, leftover at least twice the noise", "95 %", words(of(c.flagged for c in rough))),
        ("unknown said, no leftover and no foreign cause", "5 %", words(of(c.flagged for c in clean))),
        ("a name claimed where no cause is", "-", words(of(bool(c.claims) for c in quiet))),
        ("foreign cause alone: unknown said, or what looks like it", "95 %", words(of(named))),
        *((f"foreign cause alone: {k}", "-", words(of(p[k] for p in places))) for k in ("stage", "axis", "what it follows")),
        ("foreign cause alone: place right in all three", "90 %", words(of(all(p.values()) for p in places))),
    ]  # fmt: skip


def table(head, rows):
    """A table of Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(r) + " |" for r in rows)]) + "\n"


def _listed(cases):
    lines = []
    for c in cases:
        for e in c.wrong(0.8):
            truth = (
                ", ".join(f"{k['name']} {' '.join(k['axes'])} {k['size_mm']:.3f} mm" for k in c.label["causes"])
                or "none"
            )
            axes = " ".join(e["axes"])
            claim = f"{e['effect']} {axes} ({e['probability']:.2f})"
            sizes = [f"{c.leftover:.3f}", f"{c.noise:.3f}"]
            lines.append([str(c.label["seed"]), c.label["robot"], claim, truth, *sizes])
    return lines


def by_name(cases):
    """How often each cause was right, contained, ..."""
    out = []
    for name in sorted({k["name"] for c in cases for k in c.own}):
        found = [c.outcome(k) for c in cases for k in c.own if k["name"] == name]
        out.append([name, str(len(found)), *(str(found.count(o)) for o in OUTCOMES)])
    return out


def foreign_rows(cases):
    """One row a foreign cause."""
    out = []
    for c in cases:
        for k in c.foreign:
            where = c.said["unknown"]["where"] or {}
            axes, regimes = (" ".join(where.get(part) or []) or "-" for part in ("axes", "regimes"))
            said = f"{where.get('rung')}, {axes}, {regimes}"
            claims = " ".join(f"{e['effect']} ({e['probability']:.2f})" for e in c.claims) or "-"
            truth = f"{k['name']}: {k['stage']}, {' '.join(k['axes']) or '-'}, {' '.join(k['follows'])}"
            out.append([str(c.label["seed"]), truth, f"{k['size_mm']:.3f}", f"{c.floor:.3f}", said, claims])
    return out


def report(labels, answers, title):
    """The report's text."""
    given = [(labels[a["seed"]], a["said"]) for a in answers if a["seed"] in labels]
    broken = [(label, said) for label, said in given if "status" not in said]
    cases = [Case(label, said) for label, said in given if "status" in said]
    groups = {
        "all": cases,
        "with a leftover": [c for c in cases if c.leftover],
        "without": [c for c in cases if not c.leftover],
        "KR15": [c for c in cases if c.label["robot"] == "kr15"],
        "other cells": [c for c in cases if c.label["robot"] != "kr15"],
    }
    seconds = [said["seconds"] for _, said in given]
    rows = [sum(label["rows"]) for label, _ in given]
    per = [figures(g) for g in groups.values()]
    lines = [f"# {title}", "", f"{len(given)} cases answered, {len(broken)} of them with a refusal or an error.", ""]
    lines += [
        f"- {label['seed']} ({label['robot']}, {label['log']['show']}): {said.get('refused') or said.get('error')}"
        for label, said in broken
    ]
    middle, high = np.quantile(seconds, [0.5, 0.95])
    least = f"Processor seconds: median {middle:.1f}, 95 % {high:.1f}, worst {max(seconds):.1f}; "
    lines += ["", least + f"rows of a case: median {np.median(rows):.0f}, at most {max(rows)}.", "", "## Figures", ""]
    heads = ["", "aim", *(f"{name} ({len(g)})" for name, g in groups.items())]
    lines.append(table(heads, [[what, aim, *(p[k][2] for p in per)] for k, (what, aim, _) in enumerate(per[0])]))
    for name, group in groups.items():
        lines += [f"## By size against the leftover, where there is none against the noise: {name}", ""]
        lines.append(table(["size", "causes", *OUTCOMES], by_size(group)))
    lines += ["## By name", "", table(["cause", "drawn", *OUTCOMES], by_name(cases))]
    lines += [
        "## Foreign causes",
        "",
        table(["seed", "truth", "mm", "floor, mm", "said: stage, axes, follows", "claimed"], foreign_rows(cases)),
    ]
    lines += [
        "## Wrong claims above 0.8",
        "",
        table(["seed", "cell", "claimed", "truth", "leftover, mm", "noise, mm"], _listed(cases)),
    ]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("labels", type=Path)
    parser.add_argument("answers", type=Path)
    parser.add_argument("--title", default="A second author's cases")
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    labels = {d["seed"]: d for d in map(json.loads, given.labels.read_text().splitlines())}
    answers = [json.loads(line) for line in given.answers.read_text().splitlines()]
    given.out.write_text(report(labels, answers, given.title))


if __name__ == "__main__":
    main()
