"""Figures of the tenth author's cases, by labels and answers alone; Wilson intervals of 95 %."""

from __future__ import annotations

import numpy as np

__all__ = ["claimed", "report", "scores", "wilson"]


def wilson(k: int, n: int) -> tuple[float, float]:
    """95 %."""
    if not n:
        return 0.0, 1.0
    z, p = 1.96, k / n
    mid, half = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return float(max(mid - half, 0.0) / (1 + z * z / n)), float((mid + half) / (1 + z * z / n))


def claimed(said: dict) -> list[dict]:
    """Effects that are claimed."""
    return [e for e in said.get("effects", []) if e["probability"] >= 0.5]


def _reported(said: dict) -> set[str]:
    """Names in the fewest alternatives that hold 95 %."""
    names, mass = set(), 0.0
    for other in sorted(said.get("alternatives", []), key=lambda x: -x["probability"]):
        if mass >= 0.95:
            break
        mass += other["probability"]
        names |= {e if isinstance(e, str) else e["effect"] for e in other["effects"]}
    return names


def _allowed(label: dict) -> set[str]:
    """Names that are no error in a case: what is wrong, and what it can't be told from."""
    return {x for c in label["causes"] for x in (c["cause"], *c["alike"])}


def _outcome(cause: dict, said: dict) -> str:
    names = {e["effect"] for e in claimed(said)}
    if cause["cause"] in names:
        return "right"
    if names & set(cause["alike"]):
        return "alike"
    return (
        "contained"
        if cause["cause"]
        in _reported(said) | {e["effect"] for e in said.get("effects", []) if e["probability"] >= 0.05}
        else "missed"
    )


def _axis_right(cause: dict, said: dict) -> bool:
    axes = {a for e in claimed(said) if e["effect"] == cause["cause"] for a in e["axes"]}
    return bool(axes & set(cause["axes"])) and len(axes - set(cause["axes"])) <= 1


def _place(cause: dict, said: dict) -> dict[str, bool | None]:
    """Is the place of what is unknown right: stage, axis (None where there is none), what it follows."""
    where = said.get("unknown", {}).get("where") or {}
    shapes = said.get("unknown", {}).get("shapes") or []
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


def _shares(labels: dict, answers: dict) -> dict:
    out: dict[str, list[int]] = {}

    def count(what, is_so):
        k, n = out.get(what, [0, 0])
        out[what] = [k + bool(is_so), n + 1]

    for n, label in labels.items():
        if n not in answers:
            continue
        said = answers[n]["diagnosis"]
        count("answered", bool(said))
        allowed = _allowed(label)
        foreign = [c for c in label["causes"] if c["foreign"]]
        for c in label["causes"]:
            if c["foreign"] or c["ratio"] < 0.5:
                continue
            kind = "named, twice the floor" if c["ratio"] >= 2 else "named, at the floor"
            outcome = _outcome(c, said)
            count(f"{kind}: claimed right", outcome == "right")
            count(f"{kind}: right or alike", outcome in ("right", "alike"))
            count(f"{kind}: contained", outcome != "missed")
            if outcome == "right" and c["axes"]:
                count("named: axis right where claimed", _axis_right(c, said))
        for e in claimed(said):
            wrong = e["effect"] not in allowed
            count("all claims: wrong", wrong)
            if e["probability"] > 0.8:
                count("claims above 0.8: wrong", wrong)
        unknown = said.get("unknown", {}).get("probability", 0.0)
        for c in foreign:
            place = _place(c, said)
            count("foreign: unknown said", unknown >= 0.5)
            count(
                "foreign: a name above 0.8 that isn't like it",
                any(e["effect"] not in allowed and e["probability"] > 0.8 for e in claimed(said)),
            )
            for what, right in place.items():
                if right is not None:
                    count(f"foreign: {what} right", right)
            count("foreign: place right in all", all(x is not False for x in place.values()))
        if not label["causes"]:
            count("nothing wrong: a cause claimed", bool(claimed(said)))
            count("nothing wrong: no gap said", said.get("status") == "no gap")
        if label["causes"] and not foreign and label["left_mm"] < 0.5 * label["noise_mm"]:
            count("leftover below half the noise: unknown said falsely", unknown >= 0.5)
        if label["left_mm"] >= 2 * label["noise_mm"]:
            count("leftover of twice the noise: unknown said", unknown >= 0.5)
        together = said.get("together") or {}
        if together.get("predicted_shrink") is not None and together.get("shrink") is not None:
            near = abs(together["predicted_shrink"] - together["shrink"]) <= 0.05
            count("foretold within 5 points of reached", near)
            if claimed(said):
                count("foretold within 5 points of reached, where anything is claimed", near)
        names = {c["cause"] for c in label["causes"] if not c["foreign"]}
        if names and names <= {e["effect"] for e in claimed(said)} and together.get("shrink") is not None:
            count(
                "reached within 5 points of the simulator's, where all are claimed",
                abs(together["shrink"] - label["removable"]) <= 0.05,
            )
    return out


def _calibration(labels: dict, answers: dict) -> float:
    said = [
        (e["probability"], e["effect"] in _allowed(labels[n]))
        for n, a in answers.items()
        for e in a["diagnosis"].get("effects", [])
    ]
    if not said:
        return 0.0
    p, right = np.array(said, float).T
    cell = np.minimum((p * 10).astype(int), 9)
    return float(sum(abs(p[cell == b].mean() - right[cell == b].mean()) * np.mean(cell == b) for b in set(cell)))


def scores(labels: dict, answers: dict) -> dict:
    """Shares as (k, n), calibration, seconds, what failed."""
    seconds = [a["seconds"] for a in answers.values()]
    return {
        "shares": _shares(labels, answers),
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
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for n, label in labels.items():
        if n not in answers:
            continue
        said = answers[n]["diagnosis"]
        causes = ", ".join(_cause_told(c, said) for c in label["causes"])
        says = ", ".join(f"{e['effect']} {'/'.join(e['axes'])} {e['probability']:.2f}" for e in claimed(said))
        shrink = (said.get("together") or {}).get("shrink")
        cells = [
            f"{label['machine']}: {label['title']}",
            causes,
            said.get("status", "refused"),
            says,
            _unknown_told(said),
        ]
        reached = f"{'' if shrink is None else round(shrink, 2)}, {label['removable']}"
        text.append("| " + " | ".join([str(n), *cells, reached]) + " |")
    return "\n".join(text) + "\n"


def _cause_told(cause: dict, said: dict) -> str:
    outcome = "foreign" if cause["foreign"] else _outcome(cause, said)
    return f"{cause['cause']} {'/'.join(cause['axes'])} ({cause['ratio']}, {outcome})"


def _unknown_told(said: dict) -> str:
    unknown = said.get("unknown", {})
    where = unknown.get("where") or {}
    parts = [f"{unknown.get('probability', 0):.2f}", where.get("rung") or "", "/".join(where.get("axes") or [])]
    return " ".join([*parts, "/".join(where.get("regimes") or [])])
