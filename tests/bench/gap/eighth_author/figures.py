"""Figures of the eighth author's cases, from labels and diagnosis.json; intervals and calibration are the house's."""

from __future__ import annotations

from gap.score import calibration, of
from gap.score_sealed import claimed, outcome, page, unknown_said

FOUND = ("right", "alike")


def place(effect, d):
    """Whether stage, axis and what is followed are right, each where it is said first; axis None where the cause has none."""
    where = d["unknown"]["where"]
    axis = (where["axes"] or [""])[0] in effect["axes"] if effect["axes"] else None
    return {
        "stage": where["rung"] == effect["stage"],
        "axis": axis,
        "what it follows": bool(set(where["regimes"][:1]) & set(effect["follows"])),
    }


def _allowed(label):
    return set(label["effects"]) | {x for e in label["effects"].values() for x in e["alike"]}


def _of_named(known):
    each = [(n, k, e, outcome(k, e, t["effects"], d), t) for n, t, d in known for k, e in t["effects"].items()]

    def at(times, good=FOUND):
        return of(o in good for _, _, e, o, t in each if e["rms_mm"] >= times * (t["left_mm"] or t["noise_mm"]))

    out = {
        "named: right by name": of(o == "right" for *_, o, _ in each),
        "named: right up to its like": of(o in FOUND for *_, o, _ in each),
        "named: right up to its like, at the floor and more": at(1),
        "named: right up to its like, at twice the floor": at(2),
        "named: right, alike or in the reported set, at the floor": at(1, (*FOUND, "contained")),
        "named: exact sets by name": of(set(claimed(d)) == set(t["effects"]) for _, t, d in known),
        "named: right axes, of those claimed by name": of(
            set(claimed(d)[k]["axes"]) == set(e["axes"])
            for _, t, d in known
            for k, e in t["effects"].items()
            if k in claimed(d) and e["axes"]
        ),
        "unknown said where the leftover is twice the noise": of(
            unknown_said(d) for _, t, d in known if t["left_mm"] >= 2 * t["noise_mm"]
        ),
        "unknown said where there is no leftover": of(unknown_said(d) for _, t, d in known if not t["left_mm"]),
    }
    for word, kind in (("white", False), ("correlated", True)):
        out[f"named: right up to its like, {word} noise, logs with a tracker's path"] = of(
            o in FOUND for *_, o, t in each if t["log"] == "path" and bool(t["correlated_s"]) is kind
        )
    return out, each


def _of_foreign(foreign):
    each = [(e, d) for _, t, d in foreign for e in t["effects"].values()]
    places = [place(e, d) for e, d in each]
    return {
        "foreign: said to be unknown": of(unknown_said(d) for _, d in each),
        "foreign: a name above 0.8 that isn't like it": of(
            any(p["probability"] > 0.8 and p["effect"] not in e["alike"] for p in d["effects"]) for e, d in each
        ),
        "foreign: place right in all": of(all(v is not False for v in p.values()) for p in places),
        **{f"foreign: {k} right": of(p[k] for p in places if p[k] is not None) for k in ("stage", "axis", "what it follows")},
    }  # fmt: skip


def figures(labels, answers):
    """All figures, of cases by number that have a diagnosis."""
    rows = [(n, labels[n], a["diagnosis"]) for n, a in sorted(answers.items()) if "diagnosis" in a]
    known = [r for r in rows if r[1]["kind"] in ("one", "two", "three")]
    foreign = [r for r in rows if r[1]["kind"] == "outside"]
    nothing = [r for r in rows if r[1]["kind"] == "none"]
    named, each = _of_named(known)
    claims = [(k, e["probability"], k in _allowed(t)) for _, t, d in rows for k, e in claimed(d).items()]
    stated = [
        (e["probability"], e["effect"] in t["effects"] and t["kind"] != "outside")
        for _, t, d in rows
        for e in d["effects"]
    ]
    moved = [(d["together"]["shrink"], d["together"]["predicted_shrink"]) for _, _, d in rows if claimed(d)]
    out = {
        "no answer": {n: a["error"] for n, a in answers.items() if "diagnosis" not in a},
        "answered": of("diagnosis" in a for a in answers.values()),
        "nothing wrong: false alarms": of(bool(claimed(d)) or d["status"] != "no gap" for _, _, d in nothing),
        **_of_foreign(foreign),
        **named,
        "claims that are wrong": of(not right for *_, right in claims),
        "claims above 0.8 that are wrong": of(not right for _, p, right in claims if p > 0.8),
        "predicted within 5 points of reached, where anything is claimed": of(abs(a - b) <= 0.05 for a, b in moved),
        "calibration of names": calibration(stated),
        "shrinkage reached, and possible": {
            str(n): [d["together"]["shrink"], 1 - t["perfect"]["rms_after_mm"] / t["perfect"]["rms_before_mm"]]
            for n, t, d in known
        },
    }  # fmt: skip
    out["outcomes"] = [
        {"case": n, "cause": k, "size": e["size"], "left_mm": t["left_mm"], "log": t["log"], "outcome": o}
        for n, k, e, o, t in each
    ]
    return out


def report(labels, answers):
    """A page, and the figures behind it."""
    got = figures(labels, answers)
    return page("An eighth author's cases: what was reached", labels, answers, got), got
