"""Figures of the eleventh author's cases, by labels and answers alone; Wilson intervals of 95 %."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

__all__ = ["allowed", "claims", "outcome", "place", "report", "scores", "wilson"]


def wilson(k: int, n: int) -> tuple[float, float]:
    """95 %."""
    if not n:
        return 0.0, 1.0
    z, p = 1.96, k / n
    mid, half = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return float(max(mid - half, 0.0) / (1 + z * z / n)), float((mid + half) / (1 + z * z / n))


def claims(said: dict) -> list[dict]:
    """Effects that are claimed: probability of 0.5 and more."""
    return [e for e in said.get("effects", []) if e["probability"] >= 0.5]


def allowed(label: dict) -> set[str]:
    """Names that are no error in a case: what is wrong, and what such a log can't tell it from."""
    return {x for c in label["causes"] for x in (c["cause"], *c["alike"])}


def _held(said: dict) -> set[str]:
    """Names in the fewest alternatives that hold 95 %, and all of at least 0.05."""
    names, mass = {e["effect"] for e in said.get("effects", []) if e["probability"] >= 0.05}, 0.0
    for other in sorted(said.get("alternatives", []), key=lambda x: -x["probability"]):
        if mass >= 0.95:
            break
        mass += other["probability"]
        names |= {e if isinstance(e, str) else e["effect"] for e in other["effects"]}
    return names


def outcome(cause: dict, said: dict) -> str:
    """Of a cause with a name: right, alike, contained or missed."""
    names = {e["effect"] for e in claims(said)}
    if cause["cause"] in names:
        return "right"
    if names & set(cause["alike"]):
        return "alike"
    return "contained" if cause["cause"] in _held(said) else "missed"


def _axis_right(cause: dict, said: dict) -> bool:
    axes = {a for e in claims(said) if e["effect"] == cause["cause"] for a in e["axes"]}
    return bool(axes & set(cause["axes"])) and len(axes - set(cause["axes"])) <= 1


def place(cause: dict, said: dict) -> dict[str, bool | None]:
    """Is the place of what is unknown right: stage, axis (None where there is none), what it follows."""
    unknown = said.get("unknown", {})
    where, shapes = unknown.get("where") or {}, unknown.get("shapes") or []
    regimes = where.get("regimes") or []
    first = next(iter(regimes), None) if not isinstance(regimes, dict) else max(regimes, key=regimes.get, default=None)
    follows = {str(first)} | {str(s.get("follows", "")) for s in shapes[:1]}
    if any(f.startswith("from ") for f in follows):
        follows.add("time")
    if any(axis in f and "speed" not in f for axis in cause["axes"] for f in follows):
        follows.add("position")
    axes = where.get("axes") or []
    return {
        "stage": where.get("rung") == cause["stage"],
        "axis": None if not cause["axes"] else bool(axes) and next(iter(axes)) in cause["axes"],
        "follows": any(want in f for want in cause["follows"] for f in follows),
    }


def _of_causes(label: dict, said: dict, count) -> None:
    for c in label["causes"]:
        if c["foreign"] or c["ratio"] < 0.5:
            continue
        kind = "twice the floor and more" if c["ratio"] >= 2 else "0.5 to 2 times the floor"
        found = outcome(c, said)
        count(f"named, {kind}: right", found == "right")
        count(f"named, {kind}: right or alike", found in ("right", "alike"))
        count(f"named, {kind}: contained", found != "missed")
        if c["ratio"] >= 2:
            count(
                f"of {'one cause' if len(label['causes']) == 1 else 'several causes'}, twice the floor: right",
                found == "right",
            )
            count(
                f"{'poses' if label['poses'] else 'drives' if label['see'] == 'nothing' else 'paths'}, twice the floor: right",
                found == "right",
            )
            if label["correlated"]:
                count("instrument wanders, twice the floor: right", found == "right")
        if found == "right" and c["axes"]:
            count("named: axis right where claimed", _axis_right(c, said))


def _of_claims(label: dict, said: dict, count) -> None:
    fine = allowed(label)
    for e in claims(said):
        wrong = e["effect"] not in fine
        count("all claims: wrong", wrong)
        if e["probability"] > 0.8:
            count("claims above 0.8: wrong", wrong)
    if not label["causes"]:
        count("nothing wrong: a cause claimed", bool(claims(said)))
        count("nothing wrong: no gap said", said.get("status") == "no gap")


def _of_unknown(label: dict, said: dict, count) -> None:
    unknown = said.get("unknown", {}).get("probability", 0.0)
    foreign = [c for c in label["causes"] if c["foreign"]]
    for c in foreign:
        right = place(c, said)
        count("foreign: unknown said", unknown >= 0.5)
        other = any(e["effect"] not in allowed(label) and e["probability"] > 0.8 for e in claims(said))
        count("foreign: a wrong name above 0.8", other)
        for what, x in right.items():
            if x is not None:
                count(f"foreign: {what} right", x)
        count("foreign: place right in all", all(x is not False for x in right.values()))
    if label["causes"] and not foreign and label["left_mm"] < 0.5 * label["noise_mm"]:
        count("no leftover: unknown said falsely", unknown >= 0.5)
    if label["left_mm"] >= 2 * label["noise_mm"]:
        count("leftover of twice the noise: unknown said", unknown >= 0.5)


def _of_shrinkage(label: dict, said: dict, count) -> None:
    together = said.get("together") or {}
    shrink, foretold = together.get("shrink"), together.get("predicted_shrink")
    if shrink is not None and foretold is not None:
        near = abs(foretold - shrink) <= 0.05
        count("foretold within 5 points of reached", near)
        if claims(said):
            count("foretold within 5 points, where anything is claimed", near)
    names = {c["cause"] for c in label["causes"] if not c["foreign"]}
    if names and shrink is not None and names <= {e["effect"] for e in claims(said)}:
        count(
            "reached within 5 points of the simulator's, where all are claimed",
            abs(shrink - label["removable"]) <= 0.05,
        )


def _calibration(labels: dict, answers: dict) -> float:
    said = [
        (e["probability"], e["effect"] in allowed(labels[n]))
        for n, a in answers.items()
        for e in a["diagnosis"].get("effects", [])
    ]
    if not said:
        return 0.0
    p, right = np.array(said, float).T
    cell = np.minimum((p * 10).astype(int), 9)
    return float(sum(abs(p[cell == b].mean() - right[cell == b].mean()) * np.mean(cell == b) for b in set(cell)))


def scores(labels: dict, answers: dict, steps: dict | None = None) -> dict:
    """Shares as (k, n), calibration, seconds, what failed. `steps`: first steps as judged by hand."""
    shares: dict[str, list[int]] = defaultdict(lambda: [0, 0])

    def count(what, is_so):
        shares[what][0] += bool(is_so)
        shares[what][1] += 1

    for n, label in labels.items():
        if n not in answers:
            continue
        said = answers[n]["diagnosis"]
        count("answered", bool(said))
        for of in (_of_causes, _of_claims, _of_unknown, _of_shrinkage):
            of(label, said, count)
        if steps and n in steps:
            for kind in ("right", "half", "wrong"):
                count(f"first step {kind}", steps[n] == kind)
    seconds = [a["seconds"] for a in answers.values()]
    return {
        "shares": dict(shares),
        "calibration": round(_calibration(labels, answers), 3),
        "seconds": {"median": float(np.median(seconds)), "most": float(max(seconds))} if seconds else {},
        "failed": [n for n, a in answers.items() if not a["diagnosis"]],
    }


def report(found: dict, labels: dict, answers: dict) -> str:
    """Tables for people."""
    text = ["| | | share | interval |", "| --- | --- | --- | --- |"]
    for what, (k, n) in sorted(found["shares"].items()):
        low, high = wilson(k, n)
        text.append(f"| {what} | {k} of {n} | {100 * k / n:.0f} % | {100 * low:.0f} to {100 * high:.0f} % |")
    text += [
        "",
        f"Calibration error {found['calibration']}. Failed: {found['failed'] or 'none'}. Seconds: {found['seconds']}.",
        "",
    ]
    text += [
        "| case | what it is | causes (by the floor) | status | claimed | unknown, its place | reached, simulator's |",
        "| " + "--- | " * 7,
    ]
    for n, label in labels.items():
        if n in answers:
            text.append(_row(n, label, answers[n]["diagnosis"]))
    return "\n".join(x.rstrip() for x in text) + "\n"


def _row(n: int, label: dict, said: dict) -> str:
    causes = ", ".join(
        f"{c['cause']} {'/'.join(c['axes'])} ({c['ratio']}, {'foreign' if c['foreign'] else outcome(c, said)})"
        for c in label["causes"]
    )
    says = ", ".join(f"{e['effect']} {'/'.join(e['axes'])} {e['probability']:.2f}" for e in claims(said))
    unknown = said.get("unknown", {})
    where = unknown.get("where") or {}
    at = " ".join(
        [
            f"{unknown.get('probability', 0):.2f}",
            where.get("rung") or "",
            "/".join(where.get("axes") or []),
            "/".join(where.get("regimes") or []),
        ]
    )
    shrink = (said.get("together") or {}).get("shrink")
    reached = f"{'' if shrink is None else round(shrink, 2)}, {label['removable']}"
    return (
        "| "
        + " | ".join(
            [str(n), f"{label['machine']}: {label['title']}", causes, said.get("status", "refused"), says, at, reached]
        )
        + " |"
    )
