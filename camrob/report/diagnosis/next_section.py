"""The next experiment on a page: what to run, and the motions that show a person more than the same again."""

from __future__ import annotations

from camrob.report.diagnosis.numbers import mm
from camrob.report.page.html import escape
from camrob.report.page.parts import section, table
from camrob.summaries.diagnosis_summary import DiagnosisSummary, worth_running

__all__ = ["next_section", "next_words"]

_ENOUGH = 100.0  # sigmas: more of them say no more


def next_words(summary: DiagnosisSummary) -> str:
    """What to run next; where there is no gap, only for who wants to know of what is within it."""
    text = summary.next_experiment
    if summary.status != "no gap" or not summary.unknown.likely:
        return text
    within = "tolerance" if "tolerance" in summary.within.values() else "noise"
    return (
        f"None is needed. Who wants to know where what is within the {within} comes from: {text[:1].lower()}{text[1:]}"
    )


def next_section(summary: DiagnosisSummary) -> str:
    """The section, with those of the motions that were reckoned that are worth running, a row each, as HTML."""
    experiment, noise = summary.experiment, max(summary.gap.noise_mm, 1e-12)
    considered = () if experiment is None else experiment.considered or ()
    again = 0.0 if experiment is None else experiment.again_sigmas or 0.0
    rows = [
        [escape(c.text), escape(mm(c.separation_mm)), _sigmas(c.separation_sigmas)]
        for c in considered
        if worth_running(c.separation_mm / noise, c.separation_sigmas, again)
    ]
    alone = experiment is not None and ("unknown",) in experiment.rivals
    what = "shows of what is unexplained, rms" if alone else "sets the rivals' paths apart by, rms"
    shown = table(("run", what, "sigmas over all its samples"), rows) if rows else ""
    written = None if experiment is None else experiment.written
    note = f"<p>Written as a checked program: {escape(written.file)}.</p>" if written else ""
    return section("Next experiment", f"<p>{escape(next_words(summary))}</p>", shown, note)


def _sigmas(value: float) -> str:
    return f"{value:.0f}" if value <= _ENOUGH else f"over {_ENOUGH:.0f}"
