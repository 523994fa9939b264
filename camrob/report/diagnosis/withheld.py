"""Before and after on samples that took no part, effect by effect and regime by regime."""

from __future__ import annotations

from camrob.report.diagnosis.numbers import mm, share, to_mm
from camrob.report.diagnosis.sentences import only_first
from camrob.report.page.html import escape
from camrob.report.page.parts import table
from camrob.summaries.diagnosis_summary import DiagnosisSummary, Shrunk, Together

__all__ = ["careful_text", "regimes_table", "regimes_text", "sizes_table", "sizes_text"]

_WORTH_A_WORD = 20  # samples


def sizes_table(summary: DiagnosisSummary) -> str:
    """rms, 95 % and worst error without and with each claimed effect, alone and added last; all together; and the floor."""
    rows = []
    for e in summary.claimed:
        for name, shrunk in (("alone", e.alone), ("added last", e.added_last)):
            rows.append([f"<b>{escape(e.effect)}</b>", name, *_cells(shrunk)])
    first = any(only_first(e) for e in summary.claimed)
    taken = "all but what lies before the set-points" if first else "all that is claimed"
    rows.append(["<b>together</b>", taken, *_cells(summary.together)])
    told = summary.compensable
    if told.effects:
        sizes = escape(to_mm(told.rms_before_mm, told.rms_after_mm))
        gone = 1.0 - told.rms_after_mm / max(told.rms_before_mm, 1e-12)
        rows.append(["<b>compensate</b>", "what a postprocessor can correct", sizes, "", "", escape(share(gone))])
    rows.append(["the instrument's noise", "the floor", escape(mm(summary.gap.noise_mm)), "", "", ""])
    return table(("effect", "taken", "rms", "95 %", "worst", "shrinks by (90 %)"), rows, left=2, whole=True)


def _sizes(told: Shrunk | Together) -> list[str]:
    """rms, 95 % and worst error, before and after."""
    pairs = (
        (told.rms_before_mm, told.rms_after_mm),
        (told.p95_before_mm, told.p95_after_mm),
        (told.max_before_mm, told.max_after_mm),
    )
    return [to_mm(before, after) for before, after in pairs]


def sizes_text(told: Together) -> str:
    """Errors before and after in a line."""
    return ", ".join(f"{name} {size}" for name, size in zip(("rms", "95 %", "worst"), _sizes(told), strict=True))


def _cells(told: Shrunk | Together) -> list[str]:
    low, high = told.shrink_interval
    return [*map(escape, _sizes(told)), escape(f"{share(told.shrink)} ({share(low)} to {share(high)})")]


def careful_text(summary: DiagnosisSummary) -> str:
    """What speaks against a claim on samples that took no part, and which of them were not asked; "" for nothing."""
    claimed, together = summary.claimed, summary.together
    told = [
        f"adding {e.effect} last makes it worse there, {to_mm(last.rms_before_mm, last.rms_after_mm)}"
        for e in claimed
        for last in (e.added_last,)
        if last.shrink_interval[1] < 0.0
    ]
    if claimed and together.shrink < 0.0:
        told.append(f"all together leave more than there was, {to_mm(together.rms_before_mm, together.rms_after_mm)}")
    aside = together.left_aside
    if claimed and aside >= _WORTH_A_WORD:
        told.append(
            f"{aside} samples are left aside, taken before an axis had moved by its play: its side is not known then"
        )
    return "; ".join(told)


def regimes_text(summary: DiagnosisSummary) -> str:
    """How far it holds where nobody has looked, in a sentence or two; "" where no regime was withheld."""
    told = summary.together.regimes_withheld
    if not told:
        return ""
    least, most = (pick(told, key=lambda r: r.shrink) for pick in (min, max))
    worse = [r for r in told if r.worse]
    text = (
        f"with one of {len(told)} regimes withheld whole, the gap there shrinks by {share(least.shrink)} ({least.what})"
    )
    text += f" to {share(most.shrink)} ({most.what})" if len(told) > 1 else ""
    if worse:
        named = "; ".join(f"{r.what}, {to_mm(r.rms_before_mm, r.rms_after_mm)}" for r in worse)
        text += f". Fitted to the rest it predicts worse than nothing on {named}: there, don't rely on it"
    return text + "."


def regimes_table(summary: DiagnosisSummary) -> str:
    """Every regime with what is left there when all the rest is fitted; "" for none."""
    told = summary.together.regimes_withheld
    if not told:
        return ""
    rows = []
    for r in told:
        low, high = r.shrink_interval
        shrinks = f"{share(r.shrink)} ({share(low)} to {share(high)})"
        rows.append(
            [
                escape(r.regime),
                escape(r.what) + (" <b>worse than nothing</b>" if r.worse else ""),
                str(r.samples),
                escape(to_mm(r.rms_before_mm, r.rms_after_mm)),
                escape(shrinks),
                escape(mm(r.doubt_mm)),
            ]
        )
    head = ("regime", "withheld", "samples", "rms", "shrinks by (90 %)", "the fit's own doubt there")
    note = (
        '<p class="caption">Each regime in turn takes no part in the fit, and its gap is then told. The set itself was chosen '
        "with all of it. Doubt: by how much the prediction there may be off, as the rest of the samples does not tell better.</p>"
    )
    return table(head, rows, left=2, whole=True) + note
