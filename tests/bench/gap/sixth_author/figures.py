"""A thin adapter to the house's `gap.score`, and figures of this author's own, from labels and answers."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from gap import score

WORLDS = ("frame_base", "measurement_frame")


def said_of(diagnosis, rows, seconds):
    """What the scorer reads, from diagnosis.json."""
    together, noise = dict(diagnosis.get("together") or {}), diagnosis["gap"]["noise_mm"] or 0.0
    before, after = together.get("rms_before_mm"), together.get("rms_after_mm")
    room = before - noise if before else 0.0
    together["removable_removed"] = (before - after) / room if room > 0 and after is not None else None
    together.setdefault("shrink", 0.0)
    return {
        "status": diagnosis["status"],
        "effects": [{k: e.get(k) for k in ("effect", "probability", "axes", "class")} for e in diagnosis["effects"]],
        "alternatives": [{k: a[k] for k in ("effects", "probability")} for a in diagnosis["alternatives"]],
        "unknown": diagnosis["unknown"],
        "together": together,
        "rungs": diagnosis["where"]["rungs"],
        "regimes": diagnosis["where"]["regimes"],
        "noise_mm": noise,
        "rows": rows,
        "seconds": seconds,
    }


class Row(score.Row):
    """A case whose look-alikes were reckoned by its maker and stand in its label."""

    def _as_good(self, said, true):
        return said == true or said in self.label["effects"].get(true, {}).get("alike", ())

    def same(self, claim):
        claim = sorted(claim)
        if set(claim) == self.truth:
            return True
        if not claim or not self.truth or len(claim) > len(self.truth):
            return False
        return all(any(self._as_good(c, t) for t in self.truth) for c in claim) and all(
            any(self._as_good(c, t) for c in claim) for t in self.truth
        )

    def within(self):
        return False  # no cause without a name is said to look like one that has one

    def right(self, name):
        """A claimed name is a true one, or one that these logs can't tell from it."""
        return any(self._as_good(name, t) for t in self.truth)

    def claimed(self, true):
        """A true name, or what these logs can't tell from it, was claimed."""
        return any(self._as_good(c, true) for c in self.claims)


def rows_of(labels, answers):
    """Rows of the cases that were answered."""
    for label in labels.values():
        for name, facts in label["label"]["foreign"].items():
            axes = ("A6", "A7") if "axes" not in facts else ()
            score.PLACES.setdefault(name, (set(facts["follows"]), axes))
    keys = [k for k in answers if k in labels]
    return [Row("mix", {**labels[k]["task"], "only": None}, labels[k]["label"], answers[k]["said"]) for k in keys]


def _place(row):
    """Stage, axis and what it follows of a foreign cause, each where it is said first."""
    (facts,) = row.label["foreign"].values()
    where = row.said["unknown"].get("where") or {}
    axes, follows = list(where.get("axes") or []), list(where.get("regimes") or [])
    own = facts.get("axes")
    if own and len(own) > 3:
        own = None
    stage = "encoder_to_tcp" if facts["stage"] == "instrument" else facts["stage"]
    return {
        "stage": where.get("rung") == stage,
        "axis": (not axes if not own else bool(axes) and axes[0] in own),
        "what it follows": bool(follows) and follows[0] in facts["follows"],
    }


def own(rows):
    """Figures beside the house's, as the issue asks for them."""
    good = [r for r in rows if "error" not in r.said]
    named = [r for r in good if r.label["kind"] in ("one", "two", "three", "mixed")]
    left = [(r, r.label["discrepancy"]["rms_mm"]) for r in named]
    pairs = [(r, n, r.label["effects"][n]["rms_mm"] / max(d, r.label["noise_mm"])) for r, d in left for n in r.truth]
    odd = [r for r in good if r.label["foreign"]]
    calm = [r for r in named if r.label["discrepancy"]["times_noise"] >= 2]
    loud = [(r, e) for r in good for e in r.said["effects"] if e["probability"] > 0.8]
    claims = [(r, e) for r in good for e in r.said["effects"] if e["probability"] >= score.CLAIM]
    off = [100 * (r.said["together"]["shrink"] - r.label["perfect"]["shrink"]) for r in named]
    by_name = defaultdict(list)
    for r, n, _ in pairs:
        by_name[n].append(r.claimed(n))
    bands = {"0.3 to 1": (0.0, 1.0), "1 to 2": (1.0, 2.0), "2 and more": (2.0, 1e9)}
    whole = [r for r in named if r.label["kind"] != "mixed"]
    large = [
        r for r in whole if all(e["rms_mm"] >= r.label["discrepancy"]["rms_mm"] for e in r.label["effects"].values())
    ]
    return {
        "errors": [f"{r.task['key']}: {r.said['error']}" for r in rows if "error" in r.said],
        "claimed, up to look-alikes, by size over the larger of discrepancy and noise": {
            band: score.of(r.claimed(n) for r, n, x in pairs if low <= x < high) for band, (low, high) in bands.items()
        },
        "claims that are wrong": score.of(not (e["effect"] in r.truth or r.right(e["effect"])) for r, e in claims),
        "claims above 0.8 that are wrong": score.of(
            not (e["effect"] in r.truth or r.right(e["effect"])) for r, e in loud
        ),
        "truth in the reported set, all effects at least the discrepancy": score.of(
            any(h for _, _, h in r.told()) for r in large
        ),
        "unknown said where a foreign cause is": score.of(r.flagged for r in odd),
        "unknown said where the discrepancy is twice the noise or more": score.of(r.flagged for r in calm),
        "unknown said where nothing is but names": score.of(
            r.flagged for r in whole if r.label["discrepancy"]["times_noise"] == 0
        ),
        "a false alarm where nothing is": score.of(
            bool(r.claims) or r.said["status"] != "no gap" for r in good if r.label["kind"] == "none"
        ),
        "place of a foreign cause": {
            part: score.of(_place(r)[part] for r in odd) for part in ("stage", "axis", "what it follows")
        },
        "place, all three": score.of(all(_place(r).values()) for r in odd),
        "reached less perfect shrinkage, points: median, 10 %, 90 %": [
            float(x) for x in np.quantile(off, [0.5, 0.1, 0.9])
        ]
        if off
        else None,
        "calibration of claims, error": score.calibration(
            [
                (e["probability"], e["effect"] in r.truth or r.right(e["effect"]))
                for r in good
                for e in r.said["effects"]
            ]
        )["error"],
        "found, by name": {n: score.of(x) for n, x in sorted(by_name.items())},
    }


def _lines(name, value, depth=0):
    pad = "  " * depth
    if isinstance(value, dict) and "share" in value and "hits" in value:
        if value["share"] is None:
            return [f"{pad}- {name}: no case"]
        low, high = value["interval"]
        shown = (
            f"{100 * value['share']:.0f} % ({value['hits']} of {value['count']}; {100 * low:.0f} to {100 * high:.0f})"
        )
        return [f"{pad}- {name}: {shown}"]
    if isinstance(value, dict):
        return [f"{pad}- {name}:", *(line for k, v in value.items() for line in _lines(k, v, depth + 1))]
    if isinstance(value, float):
        return [f"{pad}- {name}: {value:.3f}"]
    return [f"{pad}- {name}: {value}"]


def table(rows):
    """Case by case: what was, what was said."""
    out = ["| case | machine | true (times the noise) | beside | said | unknown | seconds |", "| --- " * 7 + "|"]
    for r in rows:
        true = (
            ", ".join(f"{n} {e['size']:.1f}" for n, e in {**r.label["effects"], **r.label["foreign"]}.items())
            or "nothing"
        )
        if "error" in r.said:
            out.append(f"| {r.task['key']} | {r.label['machine']} | {true} | | error | | |")
            continue
        said = ", ".join(
            f"{e['effect']} {100 * e['probability']:.0f}" for e in r.said["effects"] if e["probability"] >= 0.3
        )
        beside, unknown = r.label["discrepancy"]["times_noise"], r.said["unknown"]["probability"]
        cells = (r.task["key"], r.label["machine"], true, f"{beside:.1f}", said or "-", f"{100 * unknown:.0f}")
        out.append(f"| {' | '.join(cells)} | {r.said['seconds']:.1f} |")
    return out


def report(rows, title, digest):
    """Markdown, and all figures."""
    ours = own(rows)
    good = [r for r in rows if "error" not in r.said]
    house = score.score(rows) if good else {}
    text = [f"# {title}", "", f"{len(rows)} cases. SHA-256 of the labels: `{digest}`.", "", "## As the issue asks", ""]
    text += [line for k, v in ours.items() for line in _lines(k, v)]
    keep = (
        "cases",
        "one effect at >= 2x noise",
        "one effect, any size",
        "two effects",
        "three effects",
        "false unknowns",
    )
    keep += ("truth in the reported set", "size of the reported set", "outside the library", "localised", "seconds")
    text += ["", "## As the house's scorer has it", ""] + [
        line for k in keep if k in house for line in _lines(k, house[k])
    ]
    text += ["", "## Case by case", "", *table(rows), ""]
    return "\n".join(text), {"own": ours, "house": house}
