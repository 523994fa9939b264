"""The written parts of a report: verdict, warnings, summary cards, table of regions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from camrob.cell.cell import Cell
from camrob.findings import Finding, Severity, collapse
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Solution
from camrob.report.page.html import duration, escape, number, prose
from camrob.report.page.parts import place_link, verdict_bar
from camrob.report.page.path_charts import axis_limits
from camrob.report.words import many
from camrob.summaries.post_summary import PostSummary
from camrob.units import m_to_mm

__all__ = ["cards", "made_from", "regions_table", "verdict", "warnings_table"]

_METHODS = {"vjm": "virtual-joint method (as published)", "planned": "planned postures"}
_RANK = {Severity.ERROR: 0, Severity.WARNING: 1, Severity.INFO: 2}
_MOST_REGIONS = 500  # rows of a table that a browser still scrolls easily; the JSON has all
_MOST_WARNINGS = 200  # as many as somebody reads; the JSON has all
_NEAREST = 3  # as many as a card has room for


def made_from(summary: PostSummary, cell: Cell) -> str:
    """What was made from what, and how (HTML)."""
    source, method = summary.source, summary.method
    return (
        f"Program made from <b>{escape(source.file)}</b> ({escape(source.dialect)}, {escape(source.units)}) "
        f"for the cell <b>{escape(cell.name)}</b>: {escape(cell.title)}. "
        f"Redundancy resolved by <b>{escape(_METHODS.get(method, method))}</b>. "
        f"Source SHA-256 <code>{escape(source.sha256[:16])}…</code>"
    )


def _at_most(value: float | None, decimals: int, unit: str) -> str:
    """A deviation, of which nobody wants to know more than so many decimals."""
    least = 10.0**-decimals
    return (
        f"below {number(least, decimals, unit)}"
        if value is not None and value < least
        else number(value, decimals, unit)
    )


def verdict(summary: PostSummary, findings: Sequence[Finding]) -> str:
    """One line: is the program verified, by what, and how far is it off at worst."""
    verified, tracking = summary.verified, summary.tracking
    errors = sum(f.severity is Severity.ERROR for f in findings)
    warned = sum(f.severity is Severity.WARNING for f in findings)
    faults = [
        (summary.limits.violations, "axis limit violation", "axis limit violations"),
        (summary.collisions.count, "collision", "collisions"),
        (summary.singular, "singular point", "singular points"),
        (errors, "error below", "errors below"),
    ]
    wrong = [many(count, one, several) for count, one, several in faults if count]
    if wrong:
        level, word = "bad", "Do not run"
        text = ", ".join(wrong) + "."
    else:
        whole = summary.witness.complete
        level = "warn" if warned or not whole else "good"
        word = ("Verified" if whole else "Verified in part") + (", with warnings" if warned else "")
        text = "" if whole else "The witness could not judge all of the CL file: see the first warning."
    text += (
        f" Read back and replayed by {escape(verified.by)}: {number(verified.points, 0)} points, "
        f"worst deviation from the CL data {_at_most(verified.position_error_mm_max, 5, 'mm')} and "
        f"{_at_most(verified.axis_error_deg_max, 5, '°')}. The solver's own error before rounding: "
        f"{_at_most(tracking.position_error_mm_max, 6, 'mm')}, {_at_most(tracking.axis_error_deg_max, 6, '°')}."
    )
    return verdict_bar(level, word, text)


def warnings_table(findings: Iterable[Finding], names: Mapping[int, str]) -> str:
    """Findings, the worst first, one row a kind with its count and first place; a line that there are none."""
    kinds = sorted(collapse(findings), key=lambda f: _RANK[f.severity])
    if not kinds:
        return "<section><h2>Warnings</h2><p>None: nothing was left out, guessed or close to a limit.</p></section>"
    rows = []
    for f in kinds[:_MOST_WARNINGS]:
        place = [place_link(f.line, words=f"CL line {f.line}")] if f.line > 0 else []
        place += [escape(names.get(f.region, f"region {f.region}"))] if f.region >= 0 else []
        value = number(f.value, 3, f.unit) if f.value is not None else ""
        limit = f" (limit {number(f.limit, 3, f.unit)})" if f.limit is not None else ""
        rows.append(
            f'<tr><td><span class="tag {f.severity.value}">{f.severity.value}</span></td>'
            f'<td class="text">{prose(f.text)}</td><td class="n">{value}{limit}</td>'
            f'<td class="n">{f.count:,}</td><td class="place">{", ".join(place) or "–"}</td>'
            f'<td class="place"><code>{escape(f.code)}</code></td></tr>'
        )
    more = len(kinds) - _MOST_WARNINGS
    rest = f'<p class="caption">{more:,} more kinds are in the summary file.</p>' if more > 0 else ""
    return (
        f"<section><h2>Warnings ({many(len(kinds), 'kind')})</h2>"
        '<div class="scroll"><table><thead><tr><th>Severity</th><th>What</th><th class="n">Value</th>'
        '<th class="n">Count</th><th>First at</th><th>Code</th></tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table></div>{rest}</section>"
    )


def _card(what: str, value: str, note: str, level: str = "") -> str:
    return (
        f'<div class="card {level}"><div class="what">{what}</div><div class="value">{value}</div>'
        f'<div class="note">{note}</div></div>'
    )


def _margins(summary: PostSummary, cell: Cell) -> tuple[str, str, str]:
    """The axis that comes closest to its limit, the next ones, and a level for the card."""
    limits = axis_limits(cell)
    known = []
    for name, margin in summary.limits.margin_min.items():
        if margin is not None and name in limits and np.isfinite(limits[name]).all():
            lower, upper = limits[name]
            known.append((margin / (upper - lower), name, margin))
    if not known:
        return "–", "no axis with limits", ""
    units = {name: "mm" if cell.joints[cell.index(name)].prismatic else "°" for name in limits}
    known.sort()
    texts = [f"{escape(name)} {number(margin, 1, units[name])}" for _, name, margin in known[:_NEAREST]]
    level = "bad" if known[0][2] < 0 else "warn" if known[0][0] < 0.02 else ""
    others = f"then {', '.join(texts[1:])}; " if len(texts) > 1 else ""
    return texts[0], f"{others}ways from and to HOME included", level


def cards(summary: PostSummary, cell: Cell, path: ToolPathInBase, *, threshold: float) -> str:
    """The figures of the job."""
    conditioning, collisions = summary.conditioning, summary.collisions
    low, bound = conditioning.inv_kf_min < threshold, conditioning.inv_kf_bound_mean
    kf_note = f"mean {number(conditioning.inv_kf_mean, 3)}; threshold {threshold:g}" + (
        f"; bound's mean {number(bound, 3)}" if bound else ""
    )
    nearest, others, near_level = _margins(summary, cell)
    count, clearance = collisions.count, collisions.clearance_min_mm
    clear_note = "clearance was not measured"
    if clearance is not None:
        clear_note = f"closest {number(clearance, 1, 'mm')}: {escape(' and '.join(collisions.clearance_pair))}"
    hits = (f"{count:,}" if count else "none", clear_note, "bad" if count else "")
    optimal = summary.time_s.optimal
    time_note = (
        "at the programmed feeds, without waits and the ways from and to HOME"
        if optimal is None
        else f"{duration(optimal)} planned, jerk kept: see Feed"
    )
    parts = [
        (escape(key.split("_")[0]), number(value, 0, "mm" if key.endswith("_mm") else "°"))
        for key, value in summary.external_travel.items()
    ]
    revised = sum(r.revised for r in summary.regions)
    length = number(float(path.length[-1]), 1, "m") if len(path) else "–"
    items = [
        _card("CL points", number(summary.points, 0), f"{length} of path, {len(path):,} points with travel"),
        _card(
            "Regions",
            f"{len(summary.regions):,}",
            f"posture revised before {revised:,} of them" if revised else "no posture revision",
        ),
        _card("Time", duration(summary.time_s.program), time_note),
        _card("Lowest 1/k<sub>F</sub>", number(conditioning.inv_kf_min, 3), kf_note, "warn" if low else ""),
        _card("Closest to a limit", nearest, others, near_level),
        _card("External travel", " · ".join(f"{n} {v}" for n, v in parts[:2]) or "–", "summed over the program"),
        _card("Collisions", *(hits if collisions.checked else ("not checked", "no bodies were given", "warn"))),
        _card(
            "Worst deviation",
            number(summary.verified.position_error_mm_max, 5, "mm"),
            "between the CL data and the program, read back",
        ),
    ]
    return f'<div class="cards">{"".join(items)}</div>'


def _per_region(path: ToolPathInBase, solution: Solution, count: int) -> tuple[Any, Any, Any]:
    """Lowest and mean 1/k_F and length of cutting, mm, of each of the regions 0..count-1."""
    inside = (path.region >= 0) & (path.region < count)
    region, kf = path.region[inside], solution.inv_kf[inside]
    lowest = np.full(count, np.inf)
    np.minimum.at(lowest, region, kf)
    points = np.bincount(region, minlength=count)
    mean = np.bincount(region, weights=kf, minlength=count) / np.maximum(points, 1)
    return lowest, mean, m_to_mm(np.bincount(region, weights=path.cut[inside], minlength=count).astype(float))


def regions_table(summary: PostSummary, path: ToolPathInBase, solution: Solution, *, threshold: float) -> str:
    """One row a region: where it comes from, how long it is, how well the arm stands in it."""
    regions = summary.regions
    count = max([r.index + 1 for r in regions], default=0)
    lowest, mean, length_mm = _per_region(path, solution, count)
    rows = []
    for r in regions[:_MOST_REGIONS]:
        k = r.index
        low = "low" if lowest[k] < threshold else ""
        change = f"{number(r.inv_kf_before, 3)} → {number(r.inv_kf_after, 3)}" if r.revised else "–"
        rows.append(
            f'<tr><td class="n">{k + 1}</td><td class="text">{escape(r.name)}</td>'
            f'<td class="n">{place_link(r.first_line, words=f"{r.first_line} – {r.last_line}")}</td>'
            f'<td class="n">{number(r.points, 0)}</td><td class="n">{number(float(length_mm[k]), 0)}</td>'
            f'<td class="n {low}">{number(float(lowest[k]), 3)}</td><td class="n">{number(float(mean[k]), 3)}</td>'
            f'<td class="n">{change}</td></tr>'
        )
    more = len(regions) - _MOST_REGIONS
    rest = f" The first {_MOST_REGIONS} are shown, {more:,} more are in the summary file." if more > 0 else ""
    return (
        '<section><h2>Regions</h2><div class="scroll"><table><thead><tr><th class="n">No.</th><th>Name</th>'
        '<th class="n">CL lines</th><th class="n">Points</th><th class="n">Cutting [mm]</th>'
        '<th class="n">1/k<sub>F</sub> lowest</th><th class="n">1/k<sub>F</sub> mean</th>'
        '<th class="n">Revision: before → after</th>'
        f"</tr></thead><tbody>{''.join(rows)}</tbody></table></div>"
        '<p class="caption">A region is one operation, or a run of cutting between retracts. Red: the arm falls below '
        f"the threshold {threshold:g} there. Revision: 1/k<sub>F</sub> at the region's first point without and with "
        f"the table and track moved before it.{rest}</p></section>"
    )
