"""The page of placements: move the part or leave it, what the trials came to, and the map."""

from __future__ import annotations

from camrob.report.page.html import escape, number, page
from camrob.report.page.parts import page_body, section, table, verdict_bar
from camrob.report.place.terminal_text import remarks
from camrob.summaries.place_summary import Placement, PlaceSummary

__all__ = ["place_report"]


def place_report(summary: PlaceSummary, picture: str) -> str:
    """The page as text; picture: the map, SVG of our own."""
    body = page_body(
        f"Where to put {escape(summary.program)}",
        f"on the cell <b>{escape(summary.cell)}</b>",
        _verdict(summary),
        _trials(summary),
        section("The map", f'<div style="overflow:auto">{picture}</div>', _caption(summary)),
        _refused(summary),
    )
    return page(f"Where to put {summary.program}", body, {"names": {}})


def _verdict(summary: PlaceSummary) -> str:
    best = summary.best
    if summary.stays:
        text = f"None of the {len(summary.others)} other placements that were followed and touch nothing is better."
        return verdict_bar("good", "Leave it where it is.", text)
    gain = ""
    if summary.now.trial is not None and best.trial is not None:
        before, after = summary.now.trial, best.trial
        gain = (
            f" The mean 1/k<sub>F</sub> rises from {number(before.inv_kf_mean, 3)} to {number(after.inv_kf_mean, 3)}, the lowest "
            f"from {number(before.inv_kf_min, 3)} to {number(after.inv_kf_min, 3)}."
        )
        room, was = after.clearance_min_mm, before.clearance_min_mm
        if room is not None and was is not None and room < was:
            gain += f" The least clearance falls from {number(was, 1)} to {number(room, 1, 'mm')}."
    where = ", ".join(f"{value:g}" for value in best.part_in_base)  # to be copied into setup.toml
    gain = gain or f" As it is: {escape(summary.now.standing)}."
    beside = "".join(f" {escape(text)}." for text in remarks(summary) if summary.border)
    text = f"<code>part_in_base = [{where}]</code> in setup.toml, mm and degrees.{gain}{beside}"
    return verdict_bar("info", "Move it.", text)


def _trials(summary: PlaceSummary) -> str:
    """What each placement came to that was followed, the best first, and the one as it is."""
    named = [("proposed", summary.best)] if not summary.stays else []
    named += [("as it is", summary.now), *(("tried", other) for other in summary.others)]
    rows = [[escape(name), *_figures(placement)] for name, placement in named]
    heads = ("", "X mm", "Y mm", "Z mm", "1/k_F mean", "lowest", "clearance mm", "bound, mean", "bound, lowest")
    note = (
        '<p class="caption">Followed by the published method on a thinned path. The bounds are what the best postures at each '
        "place would give: they rank the placements, the trials decide. 1/k<sub>F</sub>: 0 is singular, 1 ideal.</p>"
    )
    return section("What was tried", table(heads, rows), note)


def _figures(placement: Placement) -> list[str]:
    trial = placement.trial
    tried = (
        [escape(placement.standing), "", ""]
        if trial is None
        else [
            number(trial.inv_kf_mean, 3),
            number(trial.inv_kf_min, 3),
            number(trial.clearance_min_mm, 1) if trial.collisions_checked else "not checked",
        ]
    )
    bounds = [number(placement.inv_kf_bound_mean, 3), number(placement.inv_kf_bound_min, 3)]
    return [*(number(v, 1) for v in placement.part_in_base[:3]), *tried, *bounds]


def _caption(summary: PlaceSummary) -> str:
    return (
        f'<p class="caption">{summary.placements:,} placements, {summary.in_reach:,} of them in reach, {summary.tried:,} '
        f"of the best tried. Table: {escape(summary.table)}. Point at a square for its numbers and what stands against it.</p>"
    )


def _refused(summary: PlaceSummary) -> str:
    if not summary.refused:
        return ""
    rows = [[escape(reason), number(count, 0)] for reason, count in summary.refused.items()]
    return section("Refused", table(("why", "placements"), rows))
