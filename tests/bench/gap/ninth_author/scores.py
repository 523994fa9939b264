"""Figures from labels and diagnoses, by the rules of the issue; nothing of another scorer, nothing of camrob.

A name counts as true where it is a cause of the case, or one that the case's logs can't tell from a cause (`alike`). It is
claimed from a probability of 0.5 on; the reported set is the fewest `alternatives` that hold 95 %; unknown is said from 0.5 on.
"""

from __future__ import annotations

from math import sqrt

__all__ = ["outcomes", "report", "scores", "wilson"]

AS_WELL = {"force": ("load",)}  # the contract's regimes have no force


def wilson(hits: int, count: int, z: float = 1.96):
    """The share's interval of 95 %; the whole of 0 to 1 of nothing."""
    if not count:
        return 0.0, 1.0
    p, n = hits / count, count
    middle, half = p + z * z / (2 * n), z * sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return max(0.0, (middle - half) / (1 + z * z / n)), min(1.0, (middle + half) / (1 + z * z / n))


def _true(told) -> set:
    return {n for name, cause in told["causes"].items() for n in (name, *cause["alike"])}


def _claims(said) -> list:
    return [e for e in said.get("effects", []) if e["probability"] >= 0.5]


def _reported(said) -> set:
    """Names of the fewest alternatives that hold 95 %."""
    out, held = set(), 0.0
    for a in sorted(said.get("alternatives", []), key=lambda a: -a["probability"]):
        if held >= 0.95:
            break
        held += a["probability"]
        out |= set(a["effects"])
    return out


def _unknown(said) -> float:
    return (said.get("unknown") or {}).get("probability") or 0.0


def outcomes(told, said) -> list:
    """A row a named cause: its size's class, what became of it, whether its place was right."""
    rows = []
    if told["kind"] in ("foreign", "none"):
        return rows
    claims, reported = _claims(said), _reported(said)
    named = {e["effect"]: e for e in claims}
    for name, cause in told["causes"].items():
        mine = {name, *cause["alike"]}
        hit = next((n for n in (name, *cause["alike"]) if n in named), None)
        ratio = cause["ratio"]
        rows.append(
            {
                "number": told["number"],
                "name": name,
                "ratio": ratio,
                "class": "twice the floor" if ratio >= 2 else "at the floor" if ratio >= 0.5 else "below",
                "outcome": "right" if hit == name else "alike" if hit else "contained" if mine & reported else "missed",
                "contained": bool(mine & (reported | set(named))),
                "instead": sorted(set(named) - _true(told)),
                "place": bool(hit) and bool(set(named[hit].get("axes") or []) & set(cause["axes"]))
                if cause["axes"]
                else None,
            }
        )
    return rows


def _place(told, said):
    """(rung, axis, follows) of the unknown, each right, wrong or None where the label names none."""
    (cause,) = told["causes"].values()
    where = (said.get("unknown") or {}).get("where") or {}
    rung = None if cause["stage"] == "instrument" else where.get("rung") == cause["stage"]
    axis = bool(set(where.get("axes") or []) & set(cause["axes"])) if cause["axes"] else None
    follows = {w for f in cause["follows"] for w in (f, *AS_WELL.get(f, ()))}
    return rung, axis, bool(set(where.get("regimes") or []) & follows)


def _share(hits, count):
    low, high = wilson(hits, count)
    return {"hits": hits, "count": count, "low": round(low, 3), "high": round(high, 3)}


def _of(flags):
    flags = [f for f in flags if f is not None]
    return _share(sum(map(bool, flags)), len(flags))


def _calibration(pairs):
    """Mean distance between what was said and how often it was true, ten bins, weighed by their counts."""
    error = 0.0
    for k in range(10):
        inside = [(p, t) for p, t in pairs if k / 10 <= p < (k + 1) / 10 or (k == 9 and p >= 1)]
        if inside:
            error += abs(sum(p for p, _ in inside) - sum(t for _, t in inside))
    return round(error / len(pairs), 3) if pairs else None


def _reached(told, said):
    """Whether the claims take off the withheld log what the simulator loses without these causes; None: no such sum."""
    claimed = {e["effect"] for e in _claims(said)}
    if not claimed or not claimed <= set(told["causes"]):
        return None
    if claimed == set(told["causes"]):
        want = told["removable"]
    elif len(claimed) == 1:
        want = told["causes"][claimed.pop()]["removable"]
    else:
        return None
    shrink = (said.get("together") or {}).get("shrink")
    return None if shrink is None else abs(shrink - want) <= 0.05


def _predicted(said):
    together = said.get("together") or {}
    shrink, foretold = together.get("shrink"), together.get("predicted_shrink")
    return None if shrink is None or foretold is None else abs(shrink - foretold) <= 0.05


def scores(labels: dict, answers: dict) -> dict:
    """All figures, of the cases that were answered: {"diagnosis": ..., "seconds": ...}, the diagnosis {} where it failed."""
    pairs = [(labels[n], answers[n]["diagnosis"]) for n in sorted(labels) if n in answers]
    rows = [r for told, said in pairs for r in outcomes(told, said)]
    out = {"cases": len(pairs), "failed": [t["number"] for t, s in pairs if not s], "rows": rows}
    for size in ("twice the floor", "at the floor"):
        of = [r for r in rows if r["class"] == size]
        out[f"named, {size}: claimed right"] = _of([r["outcome"] == "right" for r in of])
        out[f"named, {size}: right or alike"] = _of([r["outcome"] in ("right", "alike") for r in of])
        out[f"named, {size}: contained"] = _of([r["contained"] for r in of])
    out["named: axis right where claimed"] = _of([r["place"] for r in rows if r["outcome"] in ("right", "alike")])
    claims = [(e["probability"], e["effect"] in _true(t), t["kind"]) for t, s in pairs for e in _claims(s)]
    known = [c for c in claims if c[2] not in ("foreign", "none")]
    out["claims of known causes that are wrong"] = _of([not c[1] for c in known])
    out["claims above 0.8 that are wrong"] = _of([not c[1] for c in claims if c[0] > 0.8])
    out["calibration error"] = _calibration(
        [(e["probability"], e["effect"] in _true(t)) for t, s in pairs for e in s.get("effects", [])]
    )
    foreign = [(t, s) for t, s in pairs if t["kind"] == "foreign"]
    left = [(t, s) for t, s in pairs if t["kind"] != "foreign" and t["left_mm"] >= 2 * t["noise_mm"]]
    clean = [(t, s) for t, s in pairs if t["kind"] not in ("foreign", "none") and not t["left_mm"]]
    out["foreign: unknown said"] = _of([_unknown(s) >= 0.5 for _, s in foreign])
    out["leftover of twice the noise: unknown said"] = _of([_unknown(s) >= 0.5 for _, s in left])
    out["no leftover: unknown said falsely"] = _of([_unknown(s) >= 0.5 for _, s in clean])
    out["foreign: a name above 0.8"] = _of([any(e["probability"] > 0.8 for e in _claims(s)) for _, s in foreign])
    places = [_place(t, s) for t, s in foreign]
    for k, what in enumerate(("rung", "axis", "what it follows")):
        out[f"foreign: {what} right"] = _of([p[k] for p in places])
    out["foreign: place right in all"] = _of([all(x is not False for x in p) for p in places])
    nothing = [s for t, s in pairs if t["kind"] == "none"]
    out["nothing wrong: a cause claimed"] = _of([bool(_claims(s)) for s in nothing])
    out["nothing wrong: no gap said"] = _of([s.get("status") == "no gap" for s in nothing])
    out["foretold within 5 points of reached"] = _of([_predicted(s) for _, s in pairs])
    out["reached within 5 points of the simulator's"] = _of([_reached(t, s) for t, s in pairs])
    times = sorted(answers[t["number"]].get("seconds", 0.0) for t, _ in pairs)
    out["seconds"] = {"median": times[len(times) // 2], "most": times[-1]} if times else None
    return out


def report(found: dict, labels: dict, answers: dict) -> str:
    """The page of figures: shares, causes one by one, cases one by one."""
    lines = [f"# The ninth author's cases: {found['cases']} answered", ""]
    lines += ["Wilson intervals of 95 %.", "", "| | | share | interval |", "| --- | --- | --- | --- |"]
    for name, v in found.items():
        if isinstance(v, dict) and "hits" in v:
            share = f"{100 * v['hits'] / v['count']:.0f} %" if v["count"] else ""
            lines.append(
                f"| {name} | {v['hits']} of {v['count']} | {share} | {100 * v['low']:.0f} to {100 * v['high']:.0f} % |"
            )
    lines += ["", f"Calibration error {found['calibration error']}. Failed: {found['failed'] or 'none'}.", ""]
    lines += [f"Seconds: {found['seconds']}.", "", "## Causes with a name", ""]
    lines += ["| case | cause | by the floor | outcome | claimed instead |", "| --- | --- | --- | --- | --- |"]
    for r in found["rows"]:
        lines.append(f"| {r['number']} | {r['name']} | {r['ratio']:g} | {r['outcome']} | {', '.join(r['instead'])} |")
    lines += ["", "## Cases", "", "| case | what it is | causes | status | claimed | unknown |"]
    lines += ["| --- | --- | --- | --- | --- | --- |"]
    for n in sorted(answers):
        t, s = labels[n], answers[n]["diagnosis"]
        said = ", ".join(f"{e['effect']} {'/'.join(e.get('axes') or [])} {e['probability']:.2f}" for e in _claims(s))
        what = f"{t['kind']}, {t['machine']}, {t['log']}"
        lines.append(
            f"| {n} | {what} | {', '.join(t['causes'])} | {s.get('status', 'failed')} | {said} | {_unknown(s):.2f} |"
        )
    return "\n".join(lines) + "\n"
