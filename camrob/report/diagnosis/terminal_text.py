"""The terminal's summary of a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from camrob.report.diagnosis.drives import drives_texts
from camrob.report.diagnosis.grown_friction import friction_texts
from camrob.report.diagnosis.head import head_lines
from camrob.report.diagnosis.next_section import next_words
from camrob.report.diagnosis.numbers import mm, ordinary, share, sure, to_mm
from camrob.report.diagnosis.sentences import (
    between,
    by_size,
    compensable_text,
    plain_name,
    sentence,
    standards_text,
    unexplained,
    withheld_text,
)
from camrob.report.diagnosis.times import timing_texts
from camrob.report.diagnosis.to_do import compensate_command, to_do
from camrob.report.diagnosis.verdict_word import reading_text, verdict
from camrob.report.diagnosis.withheld import careful_text, regimes_text, sizes_text
from camrob.report.words import shown_text
from camrob.summaries.diagnosis_summary import DiagnosisSummary

__all__ = ["render_diagnosis"]

_MOST = 3  # axes and regimes that are shown


def render_diagnosis(summary: DiagnosisSummary) -> RenderableType:
    """The summary of `camrob diagnose` for a terminal: what, where and what to do first, then what that rests on."""
    parts: list[RenderableType] = [shown_text(verdict(summary)[0], "bold"), _head(summary), Text("")]
    if summary.effects:
        parts += [_causes(summary), shown_text(f"mm rms {withheld_text(summary)}, without → with the effect.", "dim")]
    for e in summary.claimed:
        if e.indistinguishable_from:
            rivals = " or ".join(map(plain_name, e.indistinguishable_from))
            parts.append(shown_text(f"On these logs {rivals} would show nearly the same as {plain_name(e.called)}."))
    parts += [Text(""), _facts(summary)]
    return Group(*parts)


def _head(summary: DiagnosisSummary) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), show_header=False)
    table.add_column(no_wrap=True, style="bold")
    table.add_column()
    for name, text in head_lines(summary):
        table.add_row(name.lower(), shown_text(text))
    return table


def _causes(summary: DiagnosisSummary) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    for heading in ("effect", "axes", "sure", "alone", "added last"):
        words = heading in ("effect", "axes")
        table.add_column(heading, justify="left" if words else "right", no_wrap=heading != "axes")
    for e in by_size(summary.effects):
        last = e.added_last
        table.add_row(
            shown_text(plain_name(e.called)),
            shown_text(", ".join(e.axes)),
            sure(e.probability),
            to_mm(e.rms_before_mm, e.alone.rms_after_mm),
            to_mm(last.rms_before_mm, last.rms_after_mm),
        )
    return table


def _facts(summary: DiagnosisSummary) -> Table:
    """What the sentence rests on, line by line."""
    where = summary.where
    table = Table(box=None, padding=(0, 2, 0, 0), show_header=False)
    table.add_column(no_wrap=True, style="bold")
    table.add_column()
    stages = [
        f"{between(k, summary).removeprefix('between ').replace(' and ', ' to ')} {'not logged' if v is None else mm(v)}"
        for k, v in where.stages.items()
    ]
    said = " ".join(one for one in (sentence(summary), reading_text(summary)) if one)
    rows = [("in full", said), ("by stage", ", ".join(stages))]
    if summary.status != "no gap":  # shares of noise say nothing
        rows += [
            ("by axis", _largest(where.axes, summary.blamed_axes)),
            ("by regime", _largest(where.regimes, summary.blamed_regimes)),
        ]
    rows += [("by drive", text) for text in (*drives_texts(summary), *friction_texts(summary))]
    if summary.claimed:
        rows.append(("together", f"{sizes_text(summary.together)}; the noise {mm(summary.gap.noise_mm)}"))
    rows += [("mind", text) for text in (careful_text(summary),) if text]
    rows += [("elsewhere", text) for text in (regimes_text(summary),) if text]
    sets = [
        f"{sure(a.probability)} {' + '.join(map(plain_name, a.effects)) or 'nothing in the library'}"
        for a in summary.alternatives[:_MOST]
        if a.probability >= 0.01
    ]
    rows += [("sets", "; ".join(sets))] if len(sets) > 1 else []
    rows += [("unexplained", text) for text in unexplained(summary)]
    rows += [("instrument", text) for text in summary.instrument.text.split("; ") if text]
    rows += [("lacking", text) for text in where.missing]
    rows += [("to do", f"{what}: {text}") for what, text in to_do(summary)]
    command = compensate_command(summary)
    rows += [("", f"{command[0]}: {command[1]}")] if command else []
    rows += [("normal", f"{plain_name(e.called)}: {text}") for e in summary.claimed if (text := ordinary(e.parameters))]
    rows += [("timing", text) for text in timing_texts(summary)]
    rows += [("standard", standards_text(one)) for one in summary.standards]
    rows += [("compensate", text.removeprefix("compensate ")) for text in (compensable_text(summary),) if text]
    rows.append(("run next", next_words(summary)))
    last = ""
    for what, text in rows:
        table.add_row("" if what == last else what, shown_text(text))
        last = what
    return table


def _largest(shares: Mapping[str, float], first: Sequence[str] = ()) -> str:
    """The largest shares of the gap's energy that one axis or regime explains alone; those named `first` before all others."""
    order = sorted(shares, key=lambda k: (k not in first, -shares[k]))[:_MOST]
    named = [f"{name} {share(shares[name])}" for name in order if shares[name] >= 0.05]
    return ", ".join(named) + " (each alone)" if named else "none stands out"
