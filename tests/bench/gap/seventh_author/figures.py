"""Figures of the seventh author's cases, from labels and diagnosis.json; intervals and calibration are the house's."""

from __future__ import annotations

from gap.score import calibration, of
from gap.score_sealed import claimed, outcome, page, unknown_said


def floor(label):
    """What stays where all that has a name is taken off: leftover, or noise."""
    return label["left_mm"] or label["noise_mm"]


def of_the_issue(rows, known, foreign, each):
    """What the issue asks of every family, in its own terms."""
    sure = [(n, t, d, e) for n, t, d in rows for e in d["effects"] if e["probability"] > 0.8]
    right = {n: set(t["effects"]) | {x for e in t["effects"].values() for x in e["alike"]} for n, t, _ in known}
    said = [(n, k) for n, _, d in rows for k in claimed(d)]

    def large(times):
        return [(o, t) for _, _, e, o, t in each if e["rms_mm"] >= times * floor(t)]

    def reached(d):
        return d["together"]["shrink"], d["together"]["predicted_shrink"]

    moved = [reached(d) for _, _, d in rows if claimed(d)]
    return {
        "claimed right at twice the floor": of(o in ("right", "alike") for o, _ in large(2)),
        "claimed right at the floor and more": of(o in ("right", "alike") for o, _ in large(1)),
        "claimed or in the reported set at the floor": of(o in ("right", "alike", "contained") for o, _ in large(1)),
        "claims that are wrong": of(k not in right.get(n, ()) for n, k in said),
        "claims above 0.8 that are wrong": of(e["effect"] not in right.get(n, ()) for n, _, _, e in sure),
        "unknown said where the leftover is twice the noise": of(
            unknown_said(d) for _, t, d in known if t["left_mm"] >= 2 * t["noise_mm"]
        ),
        "foreign: the place right in stage, axis and what it follows": of(
            placed(e, d["unknown"]["where"]) for _, t, d in foreign for e in t["effects"].values()
        ),
        "predicted within 5 points of reached, where anything is claimed": of(abs(a - b) <= 0.05 for a, b in moved),
    }


def placed(effect, where):
    """Whether stage, axis (where the cause has one) and what is followed are all right."""
    axis = not effect["axes"] or (where["axes"] or [""])[0] in effect["axes"]
    return where["rung"] == effect["stage"] and axis and effect["follows"] in where["regimes"][:1]


def figures(labels, answers):
    rows = [(n, labels[n], a["diagnosis"]) for n, a in sorted(answers.items()) if "diagnosis" in a]
    known = [(n, t, d) for n, t, d in rows if t["kind"] in ("one", "two", "three")]
    foreign = [(n, t, d) for n, t, d in rows if t["kind"] == "outside"]
    quiet = [(n, t, d) for n, t, d in rows if t["kind"] == "none"]
    each = [(n, k, e, outcome(k, e, t["effects"], d), t) for n, t, d in known for k, e in t["effects"].items()]
    like = {n: set(t["effects"]) | {x for e in t["effects"].values() for x in e["alike"]} for n, t, _ in known}
    stated = [
        (e["probability"], e["effect"] in t["effects"])
        for _, t, d in rows
        for e in d["effects"]
        if t["kind"] != "outside"
    ]
    stated += [(e["probability"], False) for _, _, d in foreign for e in d["effects"]]
    shrinks = {
        n: (d["together"]["shrink"], 1 - t["perfect"]["rms_after_mm"] / t["perfect"]["rms_before_mm"])
        for n, t, d in known
    }
    out = {
        "no answer": {n: a["error"] for n, a in answers.items() if "diagnosis" not in a},
        "answered": of("diagnosis" in a for a in answers.values()),
        "false alarms, nothing wrong": of(bool(claimed(d)) or d["status"] != "no gap" for _, _, d in quiet),
        "foreign: said to be unknown": of(unknown_said(d) for _, _, d in foreign),
        "foreign: a name above 0.8 that doesn't look the same": of(
            any(p["probability"] > 0.8 and p["effect"] not in e["alike"] for p in d["effects"])
            for _, t, d in foreign
            for e in t["effects"].values()
        ),
        "foreign: the right axis first, where it has one": of(
            (d["unknown"]["where"]["axes"] or [""])[0] in e["axes"]
            for _, t, d in foreign
            for e in t["effects"].values()
            if e["axes"]
        ),
        "foreign: the right thing followed": of(
            e["follows"] in d["unknown"]["where"]["regimes"][:1] for _, t, d in foreign for e in t["effects"].values()
        ),
        "recall by name": of(o == "right" for *_, o, _ in each),
        "recall up to its like": of(o in ("right", "alike") for *_, o, _ in each),
        "in the reported set, or alike": of(o in ("right", "alike", "contained") for *_, o, _ in each),
        "precision by name": of(k in t["effects"] for _, t, d in known for k in claimed(d)),
        "precision up to its like": of(k in like[n] for n, _, d in known for k in claimed(d)),
        "right axes, of those claimed by name": of(
            set(claimed(d)[k]["axes"]) == set(e["axes"])
            for _, t, d in known
            for k, e in t["effects"].items()
            if k in claimed(d) and e["axes"]
        ),
        "exact sets by name": of(set(claimed(d)) == set(t["effects"]) for _, t, d in known),
        "unknown said where a leftover at least as large as the noise is": of(
            unknown_said(d) for _, t, d in known if t["left_mm"] >= t["noise_mm"]
        ),
        "unknown said where none is": of(unknown_said(d) for _, t, d in known if not t["left_mm"]),
        **of_the_issue(rows, known, foreign, each),
        "calibration of names": calibration(stated),
        "shrinkage reached and possible": {str(n): s for n, s in shrinks.items()},
    }
    out["outcomes"] = [
        {"case": n, "cause": k, "size": e["size"], "left_mm": t["left_mm"], "log": t["log"], "outcome": o}
        for n, k, e, o, t in each
    ]
    return out


def report(labels, answers):
    """A page and the figures behind it."""
    got = figures(labels, answers)
    return page("A seventh author's cases: what was reached", labels, answers, got), got
