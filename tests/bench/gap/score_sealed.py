"""What became of each cause of a sealed family's cases, and the page of its figures: for authors whose labels say what a log
can't tell apart (`alike`). Labels are theirs, diagnoses as diagnosis.json has them.
"""

from __future__ import annotations

import numpy as np

from gap.score import CLAIM

__all__ = ["claimed", "outcome", "page", "reported", "unknown_said"]

MOST = 0.95  # of the probability that a reported set holds


def claimed(d):
    """{name: its entry} of what is claimed."""
    return {e["effect"]: e for e in d["effects"] if e["probability"] >= CLAIM}


def unknown_said(d):
    """Whether something unknown is said to be there."""
    return d["unknown"]["probability"] >= CLAIM or d["status"] in ("unexplained", "partly explained")


def reported(d):
    """Names in the fewest alternatives that hold `MOST`."""
    sets = sorted(d["alternatives"], key=lambda a: -a["probability"])
    held = np.cumsum([a["probability"] for a in sets])
    return {n for a in sets[: int(np.searchsorted(held, MOST - 1e-9)) + 1] for n in a["effects"]}


def outcome(name, effect, truth, d):
    """Of one cause: right, alike (right up to what these logs can't tell apart), contained (in the reported set),
    unknown, wrong or missed."""
    said = claimed(d)
    if name in said:
        return "right"
    if any(n in effect["alike"] or name in (e.get("class") or []) for n, e in said.items()):
        return "alike"
    if name in reported(d):
        return "contained"
    if unknown_said(d):
        return "unknown"
    return "wrong" if set(said) - set(truth) else "missed"


def page(title, labels, answers, got):
    """A page of figures: shares, the calibration of names, the outcome of each cause, and cases without an answer."""
    lines = [f"# {title}", "", f"{len(answers)} of {len(labels)} cases were put to the diagnosis.", ""]
    lines += ["| figure | share | of | 95 % |", "| --- | --- | --- | --- |"]
    for name, value in got.items():
        if isinstance(value, dict) and value.get("count"):
            share, (low, high) = 100 * value["share"], (100 * x for x in value["interval"])
            lines.append(
                f"| {name} | {share:.0f} % | {value['hits']} of {value['count']} | {low:.0f} to {high:.0f} % |"
            )
    if got["calibration of names"]["error"] is not None:
        lines += ["", f"Calibration error of names: {got['calibration of names']['error']:.3f}."]
    lines += [
        "",
        "| case | log | cause | times the noise | leftover, mm | outcome |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    lines += [
        f"| {r['case']} | {r['log']} | {r['cause']} | {r['size']:.3g} | {r['left_mm']:.3g} | {r['outcome']} |"
        for r in got["outcomes"]
    ]
    lines += [
        f"\nCase {n} got no answer: {e.strip().splitlines()[-1] if e.strip() else 'no diagnosis.json'}"
        for n, e in got["no answer"].items()
    ]
    return "\n".join(lines) + "\n"
