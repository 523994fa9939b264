"""The page of a program's run on the ideal controller: how long, what holds it back, the run itself, speeds and axes along it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Solution
from camrob.report.page.html import escape, number, page
from camrob.report.page.parts import card_row, chart_place, page_body, place_link, section, table, verdict_bar
from camrob.report.page.path_charts import (
    Along,
    Chart,
    axis_chart,
    conditioning_chart,
    external_chart,
    feed_chart,
    shown_charts,
)
from camrob.report.page.timeline import Run
from camrob.report.page.viewer import scene_data
from camrob.report.post.player_section import player_section
from camrob.report.words import shown_blocks, shown_duration
from camrob.summaries.simulate_summary import SimulateSummary

__all__ = ["simulate_report"]

Array = NDArray[np.float64]

_MOST = 200  # warnings, as many as somebody reads; the JSON has all
_NEAR = 0.8  # share of a limit from which a card calls an axis busy
_LINKED = "Zoom in one chart and all follow; click in a chart to bring the robot there."


def simulate_report(
    summary: SimulateSummary, cell: Cell, path: ToolPathInBase, postures: Solution, run: Run, reached: Array
) -> str:
    """The page as text.

    path, postures: the run, a point a row (where the tool is led, `path.cutting`); run: its times and the program's lines;
    reached (N,): m/s of the tool on the way to each point.
    """
    names = {0: summary.program}
    threshold = 0.0 if cell.resolve_section is None else cell.resolve.threshold
    scene = scene_data(
        cell, path, postures, names, run, part_mesh=None, base_T_part=np.eye(4), threshold=threshold or 0.5
    )
    charts = _charts(cell, path, postures, names, reached, threshold)
    body = page_body(
        f"Run of {escape(summary.program)}",
        f"by the ideal controller, on the cell <b>{escape(cell.name)}</b>: {escape(cell.title)}. {summary.motions:,} motions.",
        _verdict(summary),
        _cards(summary),
        _warnings(summary),
        player_section(cell, scene, with_part=False),
        _lost(summary),
        *(chart_place(chart) for chart in charts),
        note="The ideal controller keeps speeds and accelerations, rounds corners as the program allows, and knows neither jerk "
        "nor what an arm does that is not as designed.",
    )
    data = {
        "names": {"0": summary.program},
        "charts": [{key: c[key] for key in ("id", "traces", "layout")} for c in charts],
        "scene": scene,
    }
    return page(f"Run of {summary.program}", body, data)


def _verdict(summary: SimulateSummary) -> str:
    count = len(summary.warnings)
    level, word = ("warn", "It runs; read the warnings.") if count else ("good", "It runs.")
    lost = summary.feed.lost_s
    text = f"In {shown_duration(summary.duration_s)}, the ways from and to HOME and waits included, "
    text += f"{lost:.1f} s of it lost against" if lost >= 0.05 else "at"
    text += " the programmed speed." if lost >= 0.05 else " the programmed speed throughout."
    return verdict_bar(level, word, escape(text))


def _cards(summary: SimulateSummary) -> str:
    rounded, limits = summary.approximation, summary.limits
    cards = [
        ("Takes", shown_duration(summary.duration_s), f"{summary.rows:,} rows, every {summary.cycle_ms:g} ms"),
        (
            "Corners rounded",
            f"{rounded.corners:,}",
            "none leaves its corner"
            if not rounded.deviation_mm_max
            else f"at most {rounded.deviation_mm_max:.3f} mm off, at program line {rounded.line}",
        ),
    ]
    for title, shares in (("speed", limits.speed_share_max), ("acceleration", limits.acceleration_share_max)):
        if shares:
            name = max(shares, key=lambda axis: shares[axis])
            busy = [axis for axis, share in shares.items() if share >= _NEAR]
            note = f"of {name}'s limit" + (f"; above {100 * _NEAR:.0f} %: {', '.join(busy)}" if len(busy) > 1 else "")
            cards.append((f"Highest {title} of an axis", f"{100.0 * shares[name]:.0f} %", note))
    return card_row(cards)


def _warnings(summary: SimulateSummary) -> str:
    rows = [
        [
            f'<span class="tag warning">{escape(w.code)}</span>',
            f"{escape(w.text)}{f' ({w.count} times)' if (w.count or 1) > 1 else ''}",
            place_link(w.line, of="program-line") if w.line else "",
        ]
        for w in summary.warnings[:_MOST]
    ]
    return section("To read", table(("", "what", "program line"), rows, left=2)) if rows else ""


def _lost(summary: SimulateSummary) -> str:
    rows = [[escape(cause), number(seconds, 2, "s")] for cause, seconds in summary.feed.by_cause.items()]
    if not rows:
        return ""
    short = summary.blocks
    blocks = f" {escape(shown_blocks(short))}." if short is not None and short.short else ""
    note = (
        '<p class="caption">Where the tool is led along a line or an arc; moves by axes run as fast as the axes can.'
        f"{blocks}</p>"
    )
    return section("What holds the tool back", table(("cause", "time lost"), rows), note)


def _charts(
    cell: Cell, path: ToolPathInBase, postures: Solution, names: Mapping[int, str], reached: Array, threshold: float
) -> list[Chart]:
    along = Along.of(path, names)
    values = cell.to_axis_values(postures.q)
    conditioning = None
    if threshold:
        conditioning = conditioning_chart(along, postures, threshold=threshold, comparison={}, bound=None)
    return shown_charts(
        (
            "feed",
            "Speed of the tool",
            feed_chart(along, path, reached),
            f"As programmed and as it is run, where the tool is led; gaps are moves by axes. {_LINKED}",
        ),
        (
            "conditioning",
            "How well conditioned the arm is: 1/k<sub>F</sub>",
            conditioning,
            f"The higher, the farther from a singular posture; below the red line ({threshold:g}) the arm is close to one.",
        ),
        (
            "axes",
            "Axes of the arm against their limits",
            axis_chart(cell, along, values),
            "Each chart spans the axis's whole range of travel; the red ends are beyond its limits.",
        ),
        (
            "external",
            f"External axes: {', '.join(escape(n) for n in cell.external_names)}",
            external_chart(cell, along, values),
            "Steps are moves of track or table while the tool rests.",
        ),
    )
