"""Before and after on samples that took no part, effect by effect and regime by regime."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from camrob.report.diagnosis.numbers import mm, share, to_mm
from camrob.report.page.html import escape
from camrob.report.page.parts import table

__all__ = ["careful_text", "regimes_table", "regimes_text", "sizes_table"]

Summary = Mapping[str, Any]

_FIGURES = ("rms", "p95", "max")
_WORTH_A_WORD = 20  # samples


def sizes_table(summary: Summary) -> str:
    """rms, 95 % and worst error without and with each claimed effect, alone and added last; all together; and the floor."""
    rows = []
    for e in summary["effects"]:
        if e["probability"] >= 0.5:
            for name, told in (("alone", e["alone"]), ("added last", e["added_last"])):
                rows.append([f"<b>{escape(e['effect'])}</b>", name, *_cells(told)])
    together = summary["together"]
    first = any(e["probability"] >= 0.5 and list(e["rungs"]) == ["program_to_setpoint"] for e in summary["effects"])
    taken = "all but what lies before the set-points" if first else "all that is claimed"
    rows.append(["<b>together</b>", taken, *_cells(together)])
    told = summary.get("compensable", {})
    if told.get("effects"):
        sizes = escape(to_mm(told["rms_before_mm"], told["rms_after_mm"]))
        gone = 1.0 - told["rms_after_mm"] / max(told["rms_before_mm"], 1e-12)
        rows.append(["<b>compensate</b>", "what a postprocessor can correct", sizes, "", "", escape(share(gone))])
    rows.append(["the instrument's noise", "the floor", escape(mm(summary["gap"]["noise_mm"])), "", "", ""])
    return table(("effect", "taken", "rms", "95 %", "worst", "shrinks by (90 %)"), rows, left=2, whole=True)


def _cells(told: Mapping[str, Any]) -> list[str]:
    sizes = [escape(to_mm(told[f"{k}_before_mm"], told[f"{k}_after_mm"])) for k in _FIGURES]
    low, high = told["shrink_interval"]
    return [*sizes, escape(f"{share(told['shrink'])} ({share(low)} to {share(high)})")]


def careful_text(summary: Summary) -> str:
    """What speaks against a claim on samples that took no part, and which of them were not asked; "" for nothing."""
    claimed = [e for e in summary["effects"] if e["probability"] >= 0.5]
    together = summary["together"]
    told = [
        f"adding {e['effect']} last makes it worse there, {to_mm(last['rms_before_mm'], last['rms_after_mm'])}"
        for e in claimed
        for last in (e["added_last"],)
        if last["shrink_interval"][1] < 0.0
    ]
    if claimed and together["shrink"] < 0.0:
        told.append(
            f"all together leave more than there was, {to_mm(together['rms_before_mm'], together['rms_after_mm'])}"
        )
    aside = together.get("left_aside", 0)
    if claimed and aside >= _WORTH_A_WORD:
        told.append(
            f"{aside} samples are left aside, taken before an axis had moved by its play: its side is not known then"
        )
    return "; ".join(told)


def regimes_text(summary: Summary) -> str:
    """How far it holds where nobody has looked, in a sentence or two; "" where no regime was withheld."""
    told = summary["together"].get("regimes_withheld", ())
    if not told:
        return ""
    least, most = (pick(told, key=lambda r: float(r["shrink"])) for pick in (min, max))
    worse = [r for r in told if r["worse"]]
    text = f"with one of {len(told)} regimes withheld whole, the gap there shrinks by {share(least['shrink'])} ({least['what']})"
    text += f" to {share(most['shrink'])} ({most['what']})" if len(told) > 1 else ""
    if worse:
        named = "; ".join(f"{r['what']}, {to_mm(r['rms_before_mm'], r['rms_after_mm'])}" for r in worse)
        text += f". Fitted to the rest it predicts worse than nothing on {named}: there, don't rely on it"
    return text + "."


def regimes_table(summary: Summary) -> str:
    """Every regime with what is left there when all the rest is fitted; "" for none."""
    told = summary["together"].get("regimes_withheld", ())
    if not told:
        return ""
    rows = []
    for r in told:
        low, high = r["shrink_interval"]
        shrinks = f"{share(r['shrink'])} ({share(low)} to {share(high)})"
        rows.append([
            escape(r["regime"]), escape(r["what"]) + (" <b>worse than nothing</b>" if r["worse"] else ""), str(r["samples"]),
            escape(to_mm(r["rms_before_mm"], r["rms_after_mm"])), escape(shrinks), escape(mm(r["doubt_mm"])),
        ])  # fmt: skip
    head = ("regime", "withheld", "samples", "rms", "shrinks by (90 %)", "the fit's own doubt there")
    note = (
        '<p class="caption">Each regime in turn takes no part in the fit, and its gap is then told. The set itself was chosen '
        "with all of it. Doubt: by how much the prediction there may be off, as the rest of the samples does not tell better.</p>"
    )
    return table(head, rows, left=2, whole=True) + note
