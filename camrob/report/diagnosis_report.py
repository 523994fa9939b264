"""The report of a diagnosis: first a sentence, then pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from camrob.gap.diagnosis import PathError
from camrob.report.diagnosis_charts import charts_of
from camrob.report.diagnosis_words import compensable_text, sentence, standards_text
from camrob.report.html import escape, number, page

__all__ = ["diagnosis_report"]

Summary = Mapping[str, Any]


def diagnosis_report(summary: Summary, paths: Sequence[PathError]) -> str:
    """The page as text. summary: what diagnosis.json holds; paths: every log's errors, for the pictures."""
    charts = charts_of(summary, paths)
    body = "\n".join([
        "<main>",
        f"<header><h1>Diagnosis of {escape(summary.get('cell', 'the cell'))}</h1>"
        f"<p class=\"sub\">{escape(', '.join(summary.get('logs', [])))}</p></header>",
        f"<section><h2>{escape(str(summary.get('status', '')).capitalize())}</h2><p>{escape(sentence(summary))}</p></section>",
        *(_figure(c) for c in charts),
        _causes(summary), _where(summary), _directions(summary), _standards(summary), _residual(summary), _next(summary),
        "<footer>Made by camrob. Shrinkage is told on samples that took no part in choosing or fitting. This page loads "
        "nothing and sends nothing.</footer></main>",
    ])  # fmt: skip
    data = {"names": {}, "charts": [{k: c[k] for k in ("id", "traces", "layout")} for c in charts]}
    return page("diagnosis", body, data)


def _figure(chart: Mapping[str, Any]) -> str:
    height = int(chart["layout"]["height"])
    return (
        f'<section><h2>{escape(chart["title"])}</h2><div class="chart" id="{escape(chart["id"])}" '
        f'style="height:{height}px"></div><p class="caption">{escape(chart["caption"])}</p></section>'
    )


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{escape(h)}</th>" for h in headings)
    body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows)
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def _causes(summary: Summary) -> str:
    rows = []
    for e in summary.get("effects", []):
        values = ", ".join(
            f"{escape(n)} {number(v['value'], 4)} ± {number(v['std'], 4)}" for n, v in list(e["parameters"].items())[:8]
        )
        rivals = ", ".join(e["indistinguishable_from"]) or "none"
        low, high = e["shrink_interval"]
        alone, last = e["alone"], e["added_last"]
        rows.append([
            f"<b>{escape(e['effect'])}</b> {escape(', '.join(e['axes']))}", number(100.0 * e["probability"], 0, "%"),
            f"{number(e['rms_before_mm'], 3)} → {number(alone['rms_after_mm'], 3, 'mm')}",
            f"{number(last['rms_before_mm'], 3)} → {number(last['rms_after_mm'], 3, 'mm')}",
            f"{number(100.0 * e['shrink'], 0, '%')} ({number(100.0 * low, 0)} to {number(100.0 * high, 0, '%')})",
            values, escape(rivals) + escape(f"; {e['implausible']}" if e["implausible"] else ""),
        ])  # fmt: skip
    head = (
        "effect",
        "probability",
        "fitted alone",
        "added last",
        "shrinks the gap by",
        "values",
        "nearly the same shows",
    )
    table = _table(head, rows) if rows else "<p>No effect of the library is worth a line.</p>"
    sets = "".join(
        f"<li>{number(100.0 * a['probability'], 1, '%')}: {escape(', '.join(a['effects']) or 'nothing')}</li>"
        for a in summary.get("alternatives", [])[:6]
    )
    t = summary["together"]
    sizes = ", ".join(
        f"{name} {number(t[f'{key}_before_mm'], 3)} → {number(t[f'{key}_after_mm'], 3, 'mm')}"
        for key, name in (("rms", "rms"), ("p95", "95 %"), ("max", "worst"))
    )
    together = (
        f"<p><b>Together</b>, on samples that took no part ({escape(t['withheld'])}): {sizes}; the instrument's noise is "
        f"{number(summary['gap']['noise_mm'], 3, 'mm')}.</p>"
    )
    return f"<section><h2>Causes</h2>{table}{together}<p>Sets of effects that explain the data:</p><ul>{sets}</ul></section>"


def _where(summary: Summary) -> str:
    where = summary["where"]
    worst = sorted(where["segments"], key=lambda s: -float(s["rms_mm"]))[:6]
    rows = [
        [escape(s["log"]), f"{s['from_line']} to {s['to_line']}", number(s["rms_mm"], 3, "mm"),
         number(s["contour_mm"], 3, "mm"), number(s["tangential_mm"], 3, "mm")]
        for s in worst
    ]  # fmt: skip
    missing = "".join(f"<li>{escape(m)}</li>" for m in where["missing"])
    table = _table(("log", "program lines", "rms", "across the path", "along it"), rows)
    return f"<section><h2>Worst stretches</h2>{table}{f'<ul>{missing}</ul>' if missing else ''}</section>"


def _directions(summary: Summary) -> str:
    """Rungs, directions, axes and regimes as numbers, with their intervals."""
    where = summary["where"]
    rows = []
    for kind, values, intervals, unit in (
        ("rung", where["rungs"], where["rung_intervals"], "mm"),
        ("direction", where["directions"], where["direction_intervals"], "mm"),
        ("axis", where["axes"], where["axis_intervals"], "%"),
        ("regime", {**where["regimes"], **where["further_regimes"]}, where["regime_intervals"], "%"),
    ):
        for name, value in values.items():
            if value is None or not max(abs(value), *map(abs, intervals[name])):
                continue
            factor, digits = (100.0, 0) if unit == "%" else (1.0, 3)
            low, high = (number(factor * v, digits) for v in intervals[name])
            shown = f"{number(factor * value, digits, unit)} ({low} to {high})"
            rows.append([escape(kind), escape(name.replace("_", " ")), shown])
    note = (
        '<p class="caption">rms in mm, or the share of the gap\'s energy that this alone would explain on withheld stretches; in '
        "brackets 90 % intervals, whole stretches of the path drawn anew. Shares overlap and need not add up.</p>"
    )
    return f"<section><h2>Where, in numbers</h2>{_table(('what', 'which', 'how much'), rows)}{note}</section>"


def _standards(summary: Summary) -> str:
    lines = "".join(f"<li>{escape(standards_text(one))}</li>" for one in summary.get("standards", []))
    if not lines:
        return ""
    note = '<p class="caption">Before, and without the effects found; see camrob.gap.path_standards for the definitions.</p>'
    return f"<section><h2>By the standards</h2><ul>{lines}</ul>{note}</section>"


def _next(summary: Summary) -> str:
    told = summary.get("experiment", {})
    rows = [
        [escape(c["text"]), number(c["separation_mm"], 3, "mm"), number(c["separation_sigmas"], 0)]
        for c in told.get("considered", [])
    ]
    table = _table(("run", "sets the rivals apart by", "sigmas"), rows) if rows else ""
    written = told.get("written")
    note = f"<p>Written as a checked program: {escape(written['file'])}.</p>" if written else ""
    words = escape(summary.get("next_experiment", ""))
    return f"<section><h2>Next experiment</h2><p>{words}</p>{table}{note}</section>"


def _residual(summary: Summary) -> str:
    left = summary["residual"]
    unknown = summary["unknown"]
    where = f" {escape(unknown['where'])}." if unknown["where"] else ""
    latency = summary["latency_s"]["value"]
    clock = "not visible" if latency is None else number(latency, 4, "s")
    return (
        f"<section><h2>What stays</h2><p>{number(left['rms_mm'], 3, 'mm')} rms, of which the instrument's noise is "
        f"{number(left['noise_mm'], 3, 'mm')} and {number(left['structured_mm'], 3, 'mm')} hangs together. "
        f"Probability that something unknown is at work: {number(100.0 * unknown['probability'], 0, '%')}.{where} "
        f"Latency along the motion: {clock}.</p><p>{escape(compensable_text(summary))}</p></section>"
    )
