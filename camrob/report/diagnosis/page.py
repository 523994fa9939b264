"""The report of a diagnosis: first what, where and what to do, then pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from camrob.gap.diagnosis import PathError
from camrob.report.diagnosis.bars import axes_read, place_charts, rest_charts, shrink_charts
from camrob.report.diagnosis.charts import error_charts, residual_chart, space_clouds
from camrob.report.diagnosis.drives import drives_section
from camrob.report.diagnosis.grown_friction import friction_section
from camrob.report.diagnosis.head import head_lines
from camrob.report.diagnosis.next_section import next_section
from camrob.report.diagnosis.numbers import measure, mm, ordinary, share, sure, to_mm, values_of
from camrob.report.diagnosis.places import place_sections
from camrob.report.diagnosis.sentences import (
    by_size,
    compensable_text,
    noise_name,
    only_first,
    plain_name,
    sentence,
    unexplained,
    withheld_text,
)
from camrob.report.diagnosis.times import timing_section
from camrob.report.diagnosis.to_do import compensate_command, to_do
from camrob.report.diagnosis.verdict_word import reading_text, verdict
from camrob.report.diagnosis.withheld import careful_text, regimes_table, regimes_text, sizes_table, sizes_text
from camrob.report.page.cloud import Cloud
from camrob.report.page.html import escape, page
from camrob.report.page.parts import card_row, chart_box, page_body, section, table, verdict_lines
from camrob.summaries.diagnosis_summary import DiagnosisSummary
from camrob.units import s_to_ms

__all__ = ["diagnosis_report"]

Chart = Mapping[str, Any]

_INTERVALS = "Lines on the bars: 90 % intervals, by resampling whole stretches of the path."
_MOST_VALUES, _MOST_SETS = 6, 6  # a line's room; the JSON has all
_NONE = "none of these"
_SHOWN = 0.05  # share of what stays that a regime has to explain to be named


def diagnosis_report(
    summary: DiagnosisSummary, paths: Sequence[PathError], players: Mapping[str, str] | None = None
) -> str:
    """The page as text. paths: every log's errors, for the pictures; players: of a log's name the address of the page that plays
    its program, "" for none.
    """
    claimed = any(not only_first(e) for e in summary.claimed)
    space, along = space_clouds(paths, claimed=claimed), error_charts(summary.gap, paths, claimed=claimed)
    places, shrunk = place_charts(summary), shrink_charts(summary) if claimed else []
    rest = rest_charts(summary)
    stays, what = residual_chart(summary.gap, paths), "poses" if paths and all(p.poses for p in paths) else "path"
    word, level = verdict(summary)
    said = " ".join(one for one in (sentence(summary), reading_text(summary)) if one)
    body = page_body(
        f"Diagnosis of {escape(summary.cell)}",
        escape(_made_from(summary)),
        verdict_lines(level, escape(word), [(name, escape(text)) for name, text in head_lines(summary)]),
        _cards(summary),
        _to_do(summary),
        next_section(summary),
        section("In full", f"<p>{escape(said)}</p>"),
        _unexplained(summary),
        section(f"The {what}, coloured by the error", _clouds(space), _space_caption(summary, claimed=claimed)),
        section("Where the gap lies", _pair(places[:-2]), _caption(_INTERVALS), _alone(summary, [*places[-2:], *rest])),
        _instrument(summary),
        _missing(summary),
        _causes(summary),
        _shrunk(summary, shrunk),
        *(section(str(c["title"]), _chart(c)) for c in along[:1]),
        _residual(summary, stays),
        drives_section(summary),
        friction_section(summary),
        *place_sections(summary, paths, players or {}),
        timing_section(summary),
        *(section(str(c["title"]), _chart(c)) for c in along[1:]),
        note="Shrinkage is measured on samples that took no part in choosing or fitting; the pictures show those.",
    )
    charts = [*places, *rest, *shrunk, *along, stays]
    data = {"names": {}, "clouds": [cloud.data() for cloud in space]}
    data["charts"] = [{k: c[k] for k in ("id", "traces", "layout")} | {"ruler": c["id"]} for c in charts]
    return page("diagnosis", body, data)


def _chart(chart: Chart) -> str:
    return chart_box(chart["id"], escape(chart["title"]), int(chart["layout"]["height"]))


def _alone(summary: DiagnosisSummary, charts: Sequence[Chart]) -> str:
    """By axis and by regime, each by itself: not what is found, where something is."""
    title = "What one axis, or one regime, would explain by itself"
    note = (
        "No list of culprits: each bar is what one axis, or one regime, would take of the whole gap as diagnosed if all "
        "else were sound. The bars overlap and don't add up to 100 %. "
    )
    if summary.blamed_axes or summary.blamed_regimes:
        note += "What the verdict names is in colour and stands first; what is pale only looks alike in this log."
    else:
        note += "The verdict names none of them: a tall bar may only look alike in this log."
    if axes_read(summary):
        note += " Below an axis's name: how far its drive's log shows it off, in mm rms at the tool."
    else:
        note += " Below an axis's name: what its share alone would be, in mm rms at the tool."
    rest = _pair(charts[2:]) if len(charts) > 2 else ""  # three beside each other have no room for names
    return f'<div class="part"><h3>{escape(title)}</h3><p>{escape(note)}</p>{_pair(charts[:2])}{rest}</div>'


def _pair(charts: Sequence[Chart]) -> str:
    """Charts beside each other, as far as there is room."""
    cells = "".join(f"<div><h3>{escape(c['title'])}</h3>{_chart(c)}</div>" for c in charts)
    return f'<div class="pair">{cells}</div>'


def _clouds(clouds: Sequence[Cloud]) -> str:
    cells = "".join(f"<div><h3>{escape(c.title)}</h3>{c.html()}</div>" for c in clouds)
    return f'<div class="pair">{cells}</div>'


def _caption(text: str) -> str:
    return f'<p class="caption">{escape(text)}</p>'


def _bullets(words: Sequence[str]) -> str:
    return f"<ul>{''.join(f'<li>{escape(w)}</li>' for w in words)}</ul>" if words else ""


def _made_from(summary: DiagnosisSummary) -> str:
    """The logs, and what else the diagnosis went by."""
    logs, without = ", ".join(summary.logs), ", ".join(summary.without)
    taken = f" Taken out of the library: {without}." if without else ""
    return f"Diagnosed: {logs}. Withheld: {summary.together.withheld}.{taken}"


def _cards(summary: DiagnosisSummary) -> str:
    gap, t = summary.gap, summary.together
    left = f", {gap.outliers} more left out as outliers" if gap.outliers else ""
    after = (
        (
            "gap without → with what is claimed, rms",
            escape(to_mm(t.rms_before_mm, t.rms_after_mm)),
            withheld_text(summary),
        )
        if summary.claimed
        else ("after", "–", "nothing is claimed, so nothing is taken away")
    )
    return card_row(
        [
            (
                "gap as diagnosed, rms",
                escape(mm(gap.rms_mm)),
                f"95 % {mm(gap.p95_mm)}, worst {mm(gap.max_mm)}; {gap.samples:,} samples{left}",
            ),
            after,
            (noise_name(summary), escape(mm(gap.noise_mm)), "3-D rms: below it nothing can be seen"),
            _rest_card(summary),
        ]
    )


def _rest_card(summary: DiagnosisSummary) -> tuple[str, str, str]:
    """How much stays unexplained, and only then how sure it is that something unknown has a part in it."""
    unknown = summary.unknown
    chance = f"{sure(unknown.probability)} sure that a cause that the library lacks has a part in it"
    if not unknown.likely:
        return "stays unexplained", "nothing that shows", chance
    where = withheld_text(summary).partition(" (")[0]
    if summary.status == "no gap":
        chance = "within what the log tolerates" if "tolerance" in summary.within.values() else "within its noise"
    return "stays unexplained, rms", escape(mm(unknown.rms_mm)), f"{where}, besides the noise; {chance}"


def _unexplained(summary: DiagnosisSummary) -> str:
    sentences = unexplained(summary)
    if not sentences:
        return ""
    words = (
        "Where it shows and how it goes, found without physics: what the machine would have to do to look so, and not why. "
        "Another axis that moves at the same time may be the one."
    )
    note = _caption(words) if summary.unknown.shapes else ""
    return section("What is unexplained", _bullets(sentences), note)


def _to_do(summary: DiagnosisSummary) -> str:
    steps = [f"<li><b>{escape(what)}</b>: {escape(text)}.</li>" for what, text in to_do(summary)]
    command = compensate_command(summary)
    copied = f"<p>{escape(command[0])}:</p><pre><code>{escape(command[1])}</code></pre>" if command else ""
    return section("What to do", f"<ol>{''.join(steps)}</ol>", copied) if steps else ""


def _space_caption(summary: DiagnosisSummary, *, claimed: bool) -> str:
    shown = f"Shown is the gap {withheld_text(summary)}, {mm(summary.together.rms_before_mm)} rms"
    shown += f" ({mm(summary.gap.rms_mm)} in the logs diagnosed)."
    scale = f"{shown} " + (
        "Both pictures share one scale." if claimed else "No effect is claimed, so there is no picture of an after."
    )
    return _caption(f"Nominal TCP in the measured frame, to scale. Drag to turn it, or by the arrow keys. {scale}")


def _instrument(summary: DiagnosisSummary) -> str:
    """What is said of the instrument, and which rows are gross; nothing where nothing is."""
    said = [f"{one[0].upper()}{one[1:]}." for one in summary.instrument.text.split("; ") if one]
    return section("The instrument and its readings", _bullets(said)) if said else ""


def _missing(summary: DiagnosisSummary) -> str:
    sentences = [f"{m[0].upper()}{m[1:]}." for m in summary.where.missing]
    if not sentences:
        return section("What the logs lack", "<p>Nothing.</p>")
    return section("What the logs lack, and what that costs", _bullets(sentences))


def _causes(summary: DiagnosisSummary) -> str:
    rows = []
    for e in by_size(summary.effects):
        known, more = values_of(e.parameters, _MOST_VALUES)
        values = "<br>".join(escape(v) for v in known) + (f"<br>and {more} more in diagnosis.json" if more else "")
        called = escape(plain_name(e.called))
        name = f"<b>{called}</b>" if e.claimed else called
        axes = f"<br>{escape(', '.join(e.axes))}" if e.axes else ""
        rivals = escape(", ".join(map(plain_name, e.indistinguishable_from)) or "none")
        refused = f"<br>not plausible: {escape(e.implausible)}" if e.implausible else ""
        last = e.added_last
        shrinks = (
            f"alone {to_mm(e.rms_before_mm, e.alone.rms_after_mm)}",
            f"added last {to_mm(last.rms_before_mm, last.rms_after_mm)}",
        )
        normal = ordinary(e.parameters) if e.claimed else ""
        values += f"<br>{escape(normal)}" if normal else ""
        values += f"<br>seldom so large: {escape(e.unusual)}" if e.unusual else ""
        what = f'<p class="caption">{escape(e.physics)}</p>' if e.claimed and e.physics else ""
        cells = (f"{name}{axes}<br>{escape(sure(e.probability))} sure{what}", values, "<br>".join(map(escape, shrinks)))
        rows.append([*cells, rivals + refused])
    head = ("effect", "values", "rms without and with it", "would show nearly the same")
    shown = table(head, rows, left=4) if rows else "<p>No effect of the library is worth a line.</p>"
    note = _caption(
        f"Bold: claimed. Sizes {withheld_text(summary)}. Alone: nothing else is fitted; added last: to all else that the best "
        "set holds. No effect is called more than 97 % sure: that is how often clear answers were right on simulated cells."
    )
    return section("Causes", shown, note if rows else "", _sets(summary))


def _sets(summary: DiagnosisSummary) -> str:
    """The sets of effects that were compared, and what can't be told apart at all."""
    sets = [
        f"{sure(a.probability)}: {', '.join(map(plain_name, a.effects)) or _NONE}"
        for a in summary.alternatives[:_MOST_SETS]
        if a.probability >= 0.01
    ]
    doubts = any(a.effects for a in summary.alternatives) and any(not a.effects for a in summary.alternatives)
    note = _caption(
        "As far as a name is in doubt, its set's share goes to the set without it, in the end to the set of none: such a set is "
        "no finding of its own. How sure it is that a cause is at work that the library lacks is another question: "
        f"{sure(summary.unknown.probability)}."
    )
    groups = [" = ".join(map(plain_name, g)) for g in summary.aliases]
    alike = f"<p>What these logs can't tell apart at all: {escape('; '.join(groups))}.</p>" if groups else ""
    title = "<h3>How the evidence divides among whole sets of effects</h3>"
    return f'<div class="part">{title}{_bullets(sets)}{note if doubts else ""}{alike}</div>'


def _shrunk(summary: DiagnosisSummary, charts: Sequence[Chart]) -> str:
    t = summary.together
    title = "How far it shrinks, on data that took no part"
    if not charts:
        return section(title, "<p>Nothing is claimed, so nothing is taken away and nothing shrinks.</p>")
    low, high = t.shrink_interval
    removed = t.removable_removed
    part = "" if removed is None else f" Of what stands out of the noise, {share(removed)} is gone."
    text = f"Together, {withheld_text(summary)}: {sizes_text(t)}. It shrinks by {share(t.shrink)}"
    text += f" ({share(low)} to {share(high)}).{part}"
    careful, regimes = (words[:1].upper() + words[1:] for words in (careful_text(summary), regimes_text(summary)))
    held = f"<p>{escape(careful)}.</p>" if careful else ""
    held += f"<p>{escape(regimes)}</p>{regimes_table(summary)}" if regimes else ""
    return section(
        title,
        f"<p>{escape(text)}</p>",
        _pair(charts),
        f"<p>{escape(compensable_text(summary))}</p>",
        sizes_table(summary),
        held,
    )


def _residual(summary: DiagnosisSummary, chart: Chart) -> str:
    left, latency, interval = summary.residual, summary.latency_s.value, summary.latency_s.interval
    follows = [
        f"{one.regime} ({share(one.share)})" for one in left.structure if one.p_value < 0.05 and one.share > _SHOWN
    ]
    text = (
        f"{withheld_text(summary).capitalize()} {mm(left.rms_mm)} rms stay, where {noise_name(summary)} is "
        f"{mm(left.noise_mm)}"
    )
    if summary.status != "no gap":
        text += f"; it is {sure(summary.unknown.probability)} sure that something unknown has a part in it"
    text += "."
    if 0.0 < left.structured_mm <= left.rms_mm:
        text += f" {mm(left.structured_mm)} of what remains are correlated from sample to sample."
    text += f" What stays still follows: {', '.join(follows)} of its own energy, not of the gap's." if follows else ""
    clock = "" if latency is None else f" Latency of the instrument: {measure(s_to_ms(latency), 'ms', 2)}"
    if latency is not None and interval is not None:
        low, high = (measure(s_to_ms(v), "ms", 2) for v in interval)
        clock += f" (95 %: {low} to {high})"
    words = (
        "Bars to the right of where the curve has ended are more than noise. Where most bars stand left of its peak, the noise "
        "of the greater part of this run is less than the figure, and a few places hold the rest."
    )
    note = _caption(f"{words}{clock and f'{clock}.'}")
    return section("What remains, besides the noise", f"<p>{escape(text)}</p>", _chart(chart), note)
