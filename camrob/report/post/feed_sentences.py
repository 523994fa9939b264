"""Feed, time and torque of a post in a few sentences, for the terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from camrob.report.words import shown_duration, shown_number

__all__ = ["feed_rows"]

Summary = Mapping[str, Any]

_AXES = 3


def feed_rows(summary: Summary) -> Iterator[tuple[str, str]]:
    """Labels and sentences: time like for like, limits passed, feed lost, torques; none for a summary without them."""
    feed = summary.get("feed")
    if isinstance(feed, Mapping):
        yield from _time(feed)
        yield "Feed", _lost(feed)
    torques = summary.get("torques")
    if isinstance(torques, Mapping) and torques.get("axes"):
        yield "Torques", _torques(torques["axes"])


def _time(feed: Summary) -> Iterator[tuple[str, str]]:
    """Program and plan under the same limits, one row a set of limits; what the program as it stands breaks."""
    for row in feed.get("compared") or []:
        override = row.get("override_percent_least")
        text = shown_duration(row.get("program_s"))
        if override is not None and override < 100.0:
            text += f" as it stands, each cut slowed evenly (to {shown_number(override, 0)} % at least)"
        else:
            text += " as it stands"
        if row.get("planned_s") is not None:
            text += f"; {shown_duration(row['planned_s'])} planned"
        yield "", f"within {row.get('limits')}: {text}"
    breaks = feed.get("program_breaks") or {}
    over = [w for w in breaks.get("worst") or [] if w.get("times_the_limit", 0.0) > 1.0]
    if over:
        worst = max(over, key=lambda w: w["times_the_limit"])
        yield (
            "",
            f"as it stands it takes {shown_number(worst['times_the_limit'])} times the limit of {worst['cause']} at line "
            f"{worst['line']}, and passes a limit on {shown_number(breaks.get('percent_of_cutting'))} % of its cutting",
        )


def _lost(feed: Summary) -> str:
    """Where the programmed feed is not held, and what causes it."""
    by_axis = {k: v for k, v in (feed.get("lost_by_axis_s") or {}).items() if v >= 0.05}
    axes = [
        f"{'stops and corners' if axis == 'none' else axis} {shown_number(s)} s"
        for axis, s in list(by_axis.items())[:_AXES]
    ]
    text = (
        f"held on {shown_number(feed.get('kept_percent'))} % of the cutting; {shown_number(feed.get('lost_s'))} s lost"
    )
    if axes:
        text += f" ({', '.join(axes)})"
    losses = feed.get("losses") or []
    if losses and losses[0].get("lost_s", 0.0) >= 0.05:
        worst = losses[0]
        text += f"; most at line {worst['first_line']}, by {worst['cause']}: {shown_number(worst['lost_s'], 2)} s"
    return text


def _torques(axes: Summary) -> str:
    """The axes that carry most."""
    turning = sorted(((row["max_nm"], row["gravity_max_nm"], axis) for axis, row in axes.items() if "max_nm" in row))[
        ::-1
    ]
    shown = [
        f"{axis} {shown_number(most, 0)} Nm (gravity {shown_number(still, 0)})" for most, still, axis in turning[:_AXES]
    ]
    return f"{', '.join(shown)}, with assumed masses"
