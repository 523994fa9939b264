"""Figures of the gap benchmark, from sealed labels and answers. A hit "up to its group" is one that the path can't separate."""

from __future__ import annotations

from collections import defaultdict
from functools import cached_property

import numpy as np

from gap.draws import MARKERS
from gap.separable import LIMIT, Separation

CLAIM = 0.5
BANDS = ((0.5, 1.0), (1.0, 2.0), (2.0, 5.0), (5.0, 20.01))
REGIMES = {
    "backlash": {"direction"},
    "friction": {"direction", "speed"},
    "servo_lag": {"speed"},
    "latency": {"speed"},
    "acceleration_error": {"acceleration"},
    "joint_compliance": {"load", "position"},
    "payload": {"load", "position"},
    "lean": {"load", "position"},
    "thermal_drift": {"time", "position"},
}
# of what is outside the library: what it follows, and the axes that may be named where the label names none
PLACES = {
    "bent_axis": ({"position"}, ()),
    "rack_pitch": ({"position"}, ()),
    "hose": ({"position"}, ()),
    "wrist_curve": ({"position"}, ()),
    "creep": ({"direction", "speed"}, ()),
    "slip": ({"time"}, ()),
    "vibration": ({"time"}, ()),
    "loose_tool": ({"position"}, ("A6",)),
}


def share(hits, count):
    """A share with its 95 % Wilson interval, as a record."""
    if count == 0:
        return {"hits": 0, "count": 0, "share": None, "interval": None}
    p, z = hits / count, 1.96
    mid = (p + z * z / (2 * count)) / (1 + z * z / count)
    half = z * np.sqrt(p * (1 - p) / count + z * z / (4 * count**2)) / (1 + z * z / count)
    return {
        "hits": int(hits),
        "count": int(count),
        "share": p,
        "interval": [max(0.0, mid - half), min(1.0, mid + half)],
    }


def of(flags):
    """The share of true ones."""
    flags = list(flags)
    return share(sum(flags), len(flags))


def upper_bound(hits, count):
    """One-sided 95 % upper bound (Clopper and Pearson)."""
    from scipy.stats import beta

    return 1.0 if hits >= count else float(beta.ppf(0.95, hits + 1, count - hits))


class Row:
    """One case: its label and the answer."""

    def __init__(self, group, task, label, said):
        self.group, self.task, self.label, self.said = group, task, label, said
        self.kind, self.truth = (
            label["kind"],
            frozenset(label["effects"]) if label["kind"] != "outside" else frozenset(),
        )
        self.sizes = {n: e["size"] for n, e in label["effects"].items()}

    @cached_property
    def claims(self):
        """Names claimed."""
        return frozenset(e["effect"] for e in self.said["effects"] if e["probability"] >= CLAIM)

    @property
    def first(self):
        """The name that leads, "" where none is listed."""
        return self.said["effects"][0]["effect"] if self.said["effects"] else ""

    @property
    def flagged(self):
        """Something unknown was said to be there."""
        return self.said["unknown"]["probability"] >= CLAIM or self.said["status"] in (
            "unexplained",
            "partly explained",
        )

    @cached_property
    def _separation(self):
        task = self.task
        return Separation(
            task["seed"],
            task.get("kind"),
            task.get("only"),
            tuple(task["sizes"]) if task.get("sizes") else None,
            tuple(task.get("on", ())),
        )

    def same(self, claim):
        """A set is the true one, or one that the path can't separate from it."""
        claim = frozenset(claim)
        if claim == self.truth:
            return True
        return bool(self.truth) and bool(claim) and len(claim) <= len(self.truth) and self._separation.same(claim)

    def within(self):
        """What lies outside the library looks, on this path, like what was claimed."""
        names = list(self._separation.true)
        return bool(self.claims) and all(self._separation.angle(n, self.claims) < LIMIT for n in names)

    @cached_property
    def sets(self):
        """[(set, probability, is or is alike the truth)] of the reported alternatives."""
        out = []
        for a in self.said["alternatives"]:
            names = frozenset(a["effects"])
            if self.kind == "outside":
                hit = not names  # nothing of the library: the unknown alone
            else:
                hit = "unknown" not in names and self.same(names)
            out.append((names, a["probability"], hit))
        return out

    def told(self, hold=0.95):
        """The fewest of `sets` that hold so much of the probability."""
        likely = sorted(self.sets, key=lambda s: -s[1])
        return likely[: int(np.searchsorted(np.cumsum([p for _, p, _ in likely]), hold - 1e-9)) + 1]

    @cached_property
    def groups(self):
        """[(probability, hit)]: sets that can't be told apart from the truth count as one, all with the unknown as one."""
        hits = sum(p for _, p, h in self.sets if h)
        unknown = sum(p for n, p, h in self.sets if "unknown" in n and not h)
        rest = [(p, False) for n, p, h in self.sets if not h and "unknown" not in n]
        return ([(hits, True)] if hits else []) + ([(unknown, False)] if unknown else []) + rest


def rows_of(labels, answers):
    """Rows of all cases that were answered."""
    out = []
    for key, a in answers.items():
        if key not in labels:
            continue
        label = labels[key]
        out.append(Row(key.rpartition(" ")[0], label["task"], label["label"], a["said"]))
    return out


def calibration(pairs):
    """Expected calibration error and curve [(said, true, count)] of (probability, hit)."""
    if not pairs:
        return {"error": None, "curve": []}
    p, y = (np.array(x, float) for x in zip(*pairs, strict=True))
    bins = np.clip((p * 10).astype(int), 0, 9)
    curve = [[float(p[bins == b].mean()), float(y[bins == b].mean()), int((bins == b).sum())] for b in np.unique(bins)]
    return {"error": sum(n * abs(a - c) for a, c, n in curve) / len(p), "curve": curve}


def _several(rows):
    hit = sum(len(r.truth & r.claims) for r in rows)
    return {
        "recall": share(hit, sum(len(r.truth) for r in rows)),
        "precision": share(hit, sum(len(r.claims) for r in rows)),
        "exact": of(r.truth == r.claims for r in rows),
        "exact up to groups": of(r.same(r.claims) for r in rows),
    }


def _localised(rows):
    rung, axes, regime = [], [], []
    for r in rows:
        if len(r.truth) != 1:
            continue
        (name,), rungs = r.truth, r.said["rungs"]
        if r.label["lacks"] == "" and not r.label["poses"] and max(r.sizes.values()) >= 1.0:
            servo = name in MARKERS["setpoint_to_encoder"]
            inner = np.hypot(rungs["encoder_to_tcp"], 0.0) ** 2 - r.said["noise_mm"] ** 2
            rung.append((rungs["setpoint_to_encoder"] ** 2 > max(inner, 0.0)) == servo)
        if "axes" in r.label["effects"][name] and name in r.claims:
            entry = next(e for e in r.said["effects"] if e["effect"] == name)
            axes.append(set(entry["axes"]) == set(r.label["effects"][name]["axes"]))
        if r.sizes[name] >= 2.0 and not r.label["poses"]:
            most = max(r.said["regimes"], key=lambda k: r.said["regimes"][k] or 0.0)
            regime.append(most in REGIMES.get(name, {"position"}))
    return {
        "rung": of(rung),
        "axes, where the effect was claimed": of(axes),
        "regime that leads, at >= 2x noise": of(regime),
    }


def placed(row):
    """Whether stage, axis, and what it follows are said rightly of what is outside the library, each where it is said first."""
    ((kind, facts),) = row.label["effects"].items()
    follows, others = PLACES[kind]
    where = row.said["unknown"].get("where", {"rung": None, "axes": [], "regimes": []})
    axes = where["axes"][:1]
    own = facts.get("axes")
    return {
        "stage": where["rung"] == "encoder_to_tcp",
        "axis": bool(axes) and axes[0] in own if own else not axes or axes[0] in others,
        "what it follows": bool(where["regimes"]) and where["regimes"][0] in follows,
    }


def _places(rows):
    told = [placed(r) for r in rows]
    parts = {k: of(t[k] for t in told) for k in ("stage", "axis", "what it follows")}
    return {"all three": of(all(t.values()) for t in told), **parts}


def _confusion(rows):
    table = defaultdict(lambda: defaultdict(int))
    for r in rows:
        if r.kind == "one" and r.truth:
            said = r.first if r.first in r.claims else ("unknown" if r.flagged else "nothing")
            table[next(iter(r.truth))][said] += 1
        elif r.kind in ("none", "outside"):
            said = r.first if r.first in r.claims else ("unknown" if r.flagged else "nothing")
            table["nothing" if r.kind == "none" else "outside: " + (next(iter(r.sizes), "-"))][said] += 1
    return {k: dict(v) for k, v in sorted(table.items())}


def _left_out(rows):
    out = {}
    for name in sorted({r.task["only"] for r in rows}):
        own = [r for r in rows if r.task["only"] == name]
        covered = [r for r in own if not r.flagged and r.within()]
        out[name] = {
            "cases": len(own),
            "flagged unknown": sum(r.flagged for r in own),
            "said to be what looks the same": len(covered),
            "a wrong name above 0.8, nor does it look the same": sum(
                any(e["probability"] > 0.8 for e in r.said["effects"]) and not r.within() for r in own
            ),
        }
    return out


def score(rows):
    """All figures by name."""
    errors = [f"{r.task['seed']}: {r.said['error']}" for r in rows if "error" in r.said]
    rows = [r for r in rows if "error" not in r.said]
    mix = [r for r in rows if r.group == "mix"]
    kinds = {
        k: [r for r in mix if r.kind == k and (r.truth or k in ("none", "outside"))]
        for k in ("none", "one", "two", "three", "outside")
    }
    kinds["outside"] = [r for r in kinds["outside"] if r.sizes]
    quiet = kinds["none"] + [r for r in rows if r.group == "nothing"]
    alarms = [bool(r.claims) or r.said["status"] != "no gap" for r in quiet]
    strong = [r for r in kinds["one"] if max(r.sizes.values()) >= 2.0]
    inside = kinds["one"] + kinds["two"] + kinds["three"]
    removed = [r.said["together"]["removable_removed"] for r in inside]
    removed = [x for x in removed if x is not None]
    off = [
        100.0 * (r.said["together"]["predicted_shrink"] - r.said["together"]["shrink"])
        for r in inside
        if r.claims and r.said["together"].get("predicted_shrink") is not None
    ]
    sized = [(r, n) for r in inside for n in r.truth]
    outside = sorted({n for r in kinds["outside"] for n in r.sizes})
    seconds, lengths = np.array([[r.said["seconds"], r.said["rows"]] for r in rows]).T
    return {
        "errors": errors,
        "cases": {k: len(v) for k, v in kinds.items()},
        "false alarms": {**of(alarms), "upper 95 % bound": upper_bound(sum(alarms), len(alarms))},
        "one effect at >= 2x noise": {
            "right first": of(r.first in r.truth for r in strong),
            "right first, up to its group": of(
                r.first in r.truth or r.same({r.first}) for r in strong if r.first or True
            ),
        },
        "one effect, any size": {
            "exact": of(r.claims == r.truth for r in kinds["one"]),
            "exact up to groups": of(r.same(r.claims) for r in kinds["one"]),
        },
        "two effects": _several(kinds["two"]),
        "three effects": _several(kinds["three"]),
        "truth in the reported set": of(any(h for _, _, h in r.told()) for r in inside),
        "truth in the reported set, by name": of(any(n == r.truth for n, _, _ in r.told()) for r in inside),
        "size of the reported set": {
            "groups": float(np.mean([len({(h, n if not h else 0) for n, _, h in r.told()}) for r in inside]))
            if inside
            else None,
            "names": float(np.mean([len(r.told()) for r in inside])) if inside else None,
        },
        "outside the library": {
            "flagged": of(r.flagged for r in kinds["outside"]),
            "flagged, or what the path can't separate": of(r.flagged or r.within() for r in kinds["outside"]),
            "one name above 0.8": of(any(e["probability"] > 0.8 for e in r.said["effects"]) for r in kinds["outside"]),
            "one name above 0.8 that the path could separate": of(
                any(e["probability"] > 0.8 for e in r.said["effects"]) and not r.within() for r in kinds["outside"]
            ),
            "place right": _places(kinds["outside"]),
            "by kind": {
                n: {"flagged": of(r.flagged for r in own), "or inseparable": of(r.flagged or r.within() for r in own)}
                for n, own in ((n, [r for r in kinds["outside"] if n in r.sizes]) for n in outside)
            },
        },
        "false unknowns": of(r.flagged for r in inside),
        "calibration of sets": calibration([g for r in mix for g in r.groups]),
        "calibration of effects": calibration(
            [(e["probability"], e["effect"] in r.truth) for r in mix for e in r.said["effects"]]
        ),
        "removable gap removed on the withheld run": {
            "median": float(np.median(removed)) if removed else None,
            "10th percentile": float(np.quantile(removed, 0.1)) if removed else None,
            "cases": len(removed),
        },
        "predicted less reached shrinkage, points": {
            "within 5": of(abs(x) <= 5.0 for x in off),
            "median": float(np.median(off)) if off else None,
            "5 to 95 %": [float(x) for x in np.quantile(off, [0.05, 0.95])] if off else None,
        },
        "localised": _localised(kinds["one"]),
        "found, by effect and size": {
            n: {
                f"{a:g} to {b:.0f}": of(n in r.claims for r, m in sized if m == n and a <= r.sizes[n] < b)
                for a, b in BANDS
            }
            for n in sorted({n for _, n in sized})
        },
        "confusion": _confusion(mix),
        "each alone at twice the noise": {
            n: {
                "right first": of(r.first in r.truth for r in rows if r.group == "each" and r.task["only"] == n),
                "exact up to groups": of(r.same(r.claims) for r in rows if r.group == "each" and r.task["only"] == n),
            }
            for n in sorted({r.task["only"] for r in rows if r.group == "each"})
        },
        "left out": _left_out([r for r in rows if r.group == "left out"]),
        "seconds": {
            "median": float(np.median(seconds)),
            "95 %": float(np.quantile(seconds, 0.95)),
            "worst": float(seconds.max()),
            "rows, median": float(np.median(lengths)),
            "rows, most": float(lengths.max()),
        },
    }
