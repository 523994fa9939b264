"""Before and after on samples that took no part, effect by effect and regime by regime."""

from __future__ import annotations

from camrob.report.diagnosis.numbers import mm, share, to_mm
from camrob.report.diagnosis.sentences import by_size, noise_name, only_first, plain_name
from camrob.report.page.html import escape
from camrob.report.page.parts import table
from camrob.summaries.diagnosis_summary import DiagnosisSummary, Shrunk, Together

__all__ = ["careful_text", "regimes_table", "regimes_text", "sizes_table", "sizes_text"]

_NO_WORD = ", more than the gap: proves nothing there"
_WORTH_A_WORD = 20  # samples


def sizes_table(summary: DiagnosisSummary) -> str:
    """rms, 95 % and worst error without and with each claimed effect, alone and added last; all together; and the floor."""
    rows = []
    for e in by_size(summary.claimed):
        for name, shrunk in (("alone", e.alone), ("added last", e.added_last)):
            rows.append([f"<b>{escape(plain_name(e.called))}</b>", name, *_cells(shrunk)])
    first = any(only_first(e) for e in summary.claimed)
    taken = "all but what lies before the set-points" if first else "all that is claimed"
    rows.append(["<b>together</b>", taken, *_cells(summary.together)])
    compensable = summary.compensable
    if compensable.effects:
        sizes = escape(to_mm(compensable.rms_before_mm, compensable.rms_after_mm).removesuffix(" mm"))
        gone = 1.0 - compensable.rms_after_mm / max(compensable.rms_before_mm, 1e-12)
        rows.append(["<b>compensate</b>", "what it corrects by constants", sizes, "", "", escape(share(gone))])
    rows.append([noise_name(summary), "the floor", escape(mm(summary.gap.noise_mm).removesuffix(" mm")), "", "", ""])
    return table(("effect", "taken", "rms mm", "95 % mm", "worst mm", "shrinks by (90 % interval)"), rows, left=2)


def _sizes(shrunk: Shrunk | Together) -> list[str]:
    """rms, 95 % and worst error, before and after."""
    pairs = (
        (shrunk.rms_before_mm, shrunk.rms_after_mm),
        (shrunk.p95_before_mm, shrunk.p95_after_mm),
        (shrunk.max_before_mm, shrunk.max_after_mm),
    )
    return [to_mm(before, after) for before, after in pairs]


def sizes_text(together: Together) -> str:
    """Errors before and after in a line."""
    return ", ".join(f"{name} {size}" for name, size in zip(("rms", "95 %", "worst"), _sizes(together), strict=True))


def _cells(shrunk: Shrunk | Together) -> list[str]:
    low, high = shrunk.shrink_interval
    return [
        *(escape(size.removesuffix(" mm")) for size in _sizes(shrunk)),
        escape(f"{share(shrunk.shrink)} ({share(low)} to {share(high)})"),
    ]


def careful_text(summary: DiagnosisSummary) -> str:
    """What speaks against a claim on samples that took no part, and which of them were not asked; "" for nothing."""
    claimed, together = summary.claimed, summary.together
    warnings = [
        f"adding {plain_name(e.called)} last makes it worse there, {to_mm(last.rms_before_mm, last.rms_after_mm)}"
        for e in claimed
        for last in (e.added_last,)
        if last.shrink_interval[1] < 0.0
    ]
    if claimed and together.shrink < 0.0:
        warnings.append(
            f"all together leave more than there was, {to_mm(together.rms_before_mm, together.rms_after_mm)}"
        )
    aside = together.left_aside
    if claimed and aside >= _WORTH_A_WORD:
        warnings.append(
            f"{aside} samples are left out, taken before an axis had moved by its play: its side is not known then"
        )
    return "; ".join(warnings)


def regimes_text(summary: DiagnosisSummary) -> str:
    """How far it holds where nobody has looked, in a sentence or two; "" where no regime was withheld."""
    regimes = summary.together.regimes_withheld
    if not regimes:
        return ""
    least, most = (pick(regimes, key=lambda r: r.shrink) for pick in (min, max))
    worse = [r for r in regimes if r.worse]
    text = f"with one of {len(regimes)} regimes withheld whole, the gap there shrinks by {share(least.shrink)} ({least.what})"
    text += f" to {share(most.shrink)} ({most.what})" if len(regimes) > 1 else ""
    if worse:
        named = "; ".join(f"{r.what}, {to_mm(r.rms_before_mm, r.rms_after_mm)}" for r in worse)
        text += f". Fitted to the rest it predicts worse than nothing on {named}: there, don't rely on it"
    return text + "."


def regimes_table(summary: DiagnosisSummary) -> str:
    """Every regime with what is left there when all the rest is fitted; "" for none."""
    regimes = summary.together.regimes_withheld
    if not regimes:
        return ""
    rows = []
    for r in regimes:
        low, high = r.shrink_interval
        shrinks = f"{share(r.shrink)} ({share(low)} to {share(high)})"
        rows.append(
            [
                escape(r.regime),
                escape(r.what) + (" <b>worse than nothing</b>" if r.worse else ""),
                str(r.samples),
                escape(to_mm(r.rms_before_mm, r.rms_after_mm)),
                escape(shrinks),
                escape(mm(r.doubt_mm) + (_NO_WORD if r.doubt_mm > r.rms_before_mm else "")),
            ]
        )
    head = ("regime", "withheld", "samples", "rms", "shrinks by (90 % interval)", "the fit's own doubt there")
    note = (
        '<p class="caption">Each regime in turn takes no part in the fit, and its gap is then predicted. The set of effects was '
        "chosen with all of them. Doubt: how far that prediction may be off, as the other samples can't say more.</p>"
    )
    return table(head, rows, left=2) + note
