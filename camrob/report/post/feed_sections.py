"""The feed and the torques of a post in its report: times like for like, limits that are passed, losses, torques."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.dynamics.torques import JointTorques
from camrob.report.page.html import duration, escape, number
from camrob.report.page.parts import place_link
from camrob.report.page.path_charts import Along, Chart
from camrob.report.post.feed_sentences import block_sentence, tolerance_sentence
from camrob.summaries.feed_figures import FeedFigures, LostFeed, Torques

__all__ = ["feed_section", "torque_chart", "torque_section"]

_ROWS = 15  # as many as one reads; the JSON has all
_CAPTION = (
    "The controller’s model knows speed and acceleration of tool and axes, approximate positioning and look-ahead, but no "
    "jerk. How often a limit is taken is judged on the smooth curve that the rounding of corners leaves, which may ask for more "
    "acceleration than the model does motion by motion; what the corners of the model’s own ramps add is not counted. Of the "
    "plan’s speeds the programmed feed is a limit too. Program and plan round corners a little differently, which is worth "
    "about a hundredth of the time. Moves through air take the same time in every row."
)
_COLORS = ("#2b7de9", "#e08a1e", "#1a9c6b", "#d1495b", "#8a63d2", "#6b7785", "#b5651d", "#0aa3a3")


def feed_section(feed: FeedFigures) -> str:
    """Times beside each other under the same limits, what the program as it stands breaks, and where feed is lost."""
    return (
        f"<section><h2>Feed: time, limits and losses</h2>{_compared(feed)}{_breaks(feed)}{_losses(feed)}"
        f'<p class="caption">{_CAPTION}</p></section>'
    )


def _compared(feed: FeedFigures) -> str:
    rows, planned = [], feed.mode == "optimal"
    for row in feed.compared:
        override = row.override_percent_least
        how = (
            "by the controller’s model"
            if override is None
            else f"each cut slowed evenly, down to {number(override, 0, '%')}"
        )
        plan = f'<td class="n">{duration(row.planned_s)}</td>' if planned else ""
        rows.append(
            f'<tr><td class="text">{escape(row.limits)}</td><td class="n">{duration(row.program_s)}</td>'
            f"<td>{how}</td>{plan}</tr>"
        )
    head = '<th class="n">planned feed</th>'
    note = "" if planned else '<p class="caption">Post with --feed optimal to have the feed planned.</p>'
    return (
        '<div class="scroll"><table><thead><tr><th>limits that are kept</th><th class="n">program</th><th></th>'
        f"{head if planned else ''}</tr></thead><tbody>{''.join(rows)}</tbody></table></div>{note}"
    )


def _breaks(feed: FeedFigures) -> str:
    breaks, uses = feed.program_breaks, feed.planned_uses or {}
    rows = []
    for worst in breaks.worst:
        low = " low" if worst.times_the_limit > 1.0 else ""
        use = uses.get(worst.quantity)
        plan = f'<td class="n">{"–" if use is None else number(use, 4)}</td>' if uses else ""
        rows.append(
            f'<tr><td>{escape(worst.quantity)}</td><td class="n{low}">{number(worst.times_the_limit, 2)}</td>'
            f'<td>{escape(worst.cause)}</td><td class="n">{place_link(worst.line)}</td>{plan}</tr>'
        )
    head = '<th class="n">planned feed: times the limit</th>'
    text = f"At its own feed the program passes a limit on {number(breaks.percent_of_cutting, 1, '%')} of its cutting path."
    written = feed.written
    if written is not None:
        text += (
            " The plan itself passes none. It is written as speeds, point by point "
            f"({number(written.points_added, 0)} of them added where a move slows on its way), and the ramps between stay "
            f"the controller’s: as its model runs the written program, it takes {duration(written.model_s)} and passes "
            f"a limit on {number(written.percent_of_cutting, 2, '%')} of the cutting."
        )
    return (
        '<div class="scroll"><table><thead><tr><th>limit on</th><th class="n">program at its own feed: times the limit</th>'
        '<th>worst</th><th class="n">CL line</th>'
        f"{head if uses else ''}</tr></thead>"
        f"<tbody>{''.join(rows)}</tbody></table></div><p>{text}</p>"
    )


def _losses(feed: FeedFigures) -> str:
    losses = feed.losses
    shares = ", ".join(
        f"{'stops and corners' if axis == 'none' else escape(axis)} {number(lost, 2, 's')}"
        for axis, lost in feed.lost_by_axis_s.items()
    )
    kept = (
        f"<p>The programmed feed is held on {number(feed.kept_percent, 1, '%')} of the cutting path; "
        f"{number(feed.lost_s, 1, 's')} are lost in {number(feed.losses_count, 0)} places"
        f"{': ' + shares if shares else ''}.</p>"
    )
    if feed.tolerance is not None:
        kept += f"<p>With the diagnosis given, {escape(tolerance_sentence(feed.tolerance))}.</p>"
    if feed.blocks is not None:
        kept += f"<p>{escape(block_sentence(feed.blocks))}.</p>"
    if not losses:
        return kept
    rows = "".join(
        f'<tr><td class="n">{_lines(loss)}</td><td>{escape(loss.cause)}</td>'
        f'<td class="n">{number(loss.feed_mm_min, 0)}</td><td class="n">{number(loss.reached_mm_min, 0)}</td>'
        f'<td class="n">{number(loss.lost_s, 3, "s")}</td></tr>'
        for loss in losses[:_ROWS]
    )
    return (
        f'{kept}<div class="scroll"><table><thead><tr><th class="n">CL lines</th><th>held back by</th><th class="n">feed '
        '[mm/min]</th><th class="n">reached on average</th><th class="n">time lost</th></tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )


def _lines(loss: LostFeed) -> str:
    first, last = loss.first_line, loss.last_line
    return place_link(first, words=first if first == last else f"{first} – {last}")


def torque_section(torques: Torques | None) -> str:
    """The largest torques, axis by axis, and where the masses come from; nothing for a cell without masses."""
    if torques is None:
        return ""
    rows = []
    for axis, row in torques.axes.items():
        unit, most, gravity = (
            ("Nm", row.max_nm, row.gravity_max_nm) if row.max_n is None else ("N", row.max_n, row.gravity_max_n)
        )
        place = place_link(row.line) if row.line else "travel"
        rows.append(
            f'<tr><td>{escape(axis)}</td><td class="n">{number(most, 1, unit)}</td><td class="n">{number(gravity, 1, unit)}</td>'
            f'<td class="n">{place}</td></tr>'
        )
    masses = "; ".join(escape(m) for m in torques.masses)
    return (
        '<section><h2>Largest torques</h2><div class="scroll"><table><thead><tr><th>axis</th><th class="n">torque</th>'
        f'<th class="n">gravity alone</th><th class="n">CL line</th></tr></thead><tbody>{"".join(rows)}</tbody></table></div>'
        f'<p class="caption">With {escape(torques.provenance)} ({masses}): good for comparing postures, not for a drive’s '
        "rating. A table’s own drive is left out: what it turns is not known.</p></section>"
    )


def torque_chart(cell: Cell, along: Along, sampled: NDArray[np.int64], torques: JointTorques) -> Chart | None:
    """Torques at the points `sampled`, gravity's part dotted; None where the cell has no masses."""
    here = along.at(sampled)
    traces: list[Chart] = []
    shown = np.flatnonzero(np.abs(torques.total).max(axis=0, initial=0.0) > 0.0)
    turning = [k for k in shown.tolist() if not cell.joints[k].prismatic]
    if not turning:
        return None
    for color, k in enumerate(turning):
        name, paint = cell.names[k], _COLORS[color % len(_COLORS)]
        template = f"{name} %{{y:,.0f}} Nm<extra></extra>"
        traces.append(here.curve(torques.total[:, k], name, template=template, color=paint, legendgroup=name))
        dotted: dict[str, Any] = {"line": {"width": 1.1, "dash": "dot"}, "legendgroup": name, "showlegend": False}
        template = f"{name} %{{y:,.0f}} Nm, gravity alone<extra></extra>"
        traces.append(here.curve(torques.gravity[:, k], f"{name}, gravity", template=template, color=paint, **dotted))
    end = float(along.s_mm[-1]) if len(along.s_mm) else 1.0
    layout = {
        "height": 380,
        "hovermode": "closest",
        "xaxis": {
            "range": [0.0, end or 1.0],
            "title": {"text": "path length of the tool tip [mm]"},
            "tickformat": ",~f",
        },
        "yaxis": {"title": {"text": "torque [Nm]"}},
        "shapes": along.bands([""]),
        "annotations": along.band_names(),
        "legend": {"orientation": "h", "y": -0.2, "yanchor": "top", "x": 0},
        "margin": {"t": 54, "r": 20, "l": 70, "b": 60},
    }
    return {"traces": traces, "layout": layout}
