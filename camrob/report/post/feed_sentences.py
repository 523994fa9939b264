"""Feed, time and torque of a post in a few sentences, for the terminal."""

from __future__ import annotations

from collections.abc import Iterator

from camrob.report.words import shown_blocks, shown_duration, shown_number
from camrob.summaries.feed_figures import BlockTime, FeedFigures, HeldToTolerance, Torques

__all__ = ["block_sentence", "feed_rows", "tolerance_sentence"]

_AXES = 3  # as many as a sentence carries


def feed_rows(feed: FeedFigures, torques: Torques | None) -> Iterator[tuple[str, str]]:
    """Labels and sentences: time like for like, limits passed, feed lost, torques."""
    yield from _time(feed)
    yield "Feed", _lost(feed)
    if feed.tolerance is not None:
        yield "", tolerance_sentence(feed.tolerance)
    if feed.blocks is not None:
        yield "", block_sentence(feed.blocks)
    if torques is not None and torques.axes:
        yield "Torques", _torques(torques)


def _time(feed: FeedFigures) -> Iterator[tuple[str, str]]:
    """Program and plan under the same limits, one row a set of limits; what the program as it stands breaks."""
    for row in feed.compared:
        override = row.override_percent_least
        text = shown_duration(row.program_s)
        if override is not None and override < 100.0:
            text += f", each cut slowed evenly (to {shown_number(override, 0)} % at least)"
        else:
            text += " by the controller's model"
        if row.planned_s is not None:
            text += f"; {shown_duration(row.planned_s)} planned"
        yield "", f"within {row.limits}: {text}"
    breaks = feed.program_breaks
    over = [w for w in breaks.worst if w.times_the_limit > 1.0]
    if over:
        worst = max(over, key=lambda w: w.times_the_limit)
        yield (
            "",
            f"at its own feed it takes {shown_number(worst.times_the_limit)} times the limit of {worst.cause} at line "
            f"{worst.line}, and passes a limit on {shown_number(breaks.percent_of_cutting)} % of its cutting",
        )


def _lost(feed: FeedFigures) -> str:
    """Where the programmed feed is not held, and what causes it."""
    by_axis = {k: v for k, v in feed.lost_by_axis_s.items() if v >= 0.05}
    axes = [
        f"{'stops and corners' if axis == 'none' else axis} {shown_number(s)} s"
        for axis, s in list(by_axis.items())[:_AXES]
    ]
    text = f"held on {shown_number(feed.kept_percent)} % of the cutting; {shown_number(feed.lost_s)} s lost"
    if axes:
        text += f" ({', '.join(axes)})"
    if feed.losses and feed.losses[0].lost_s >= 0.05:
        worst = feed.losses[0]
        text += f"; most at line {worst.first_line}, by {worst.cause}: {shown_number(worst.lost_s, 2)} s"
    return text


def tolerance_sentence(held: HeldToTolerance) -> str:
    """What the machine's speed leaves of the path, and what was slowed for it."""
    text = (
        f"the machine's speed leaves {shown_number(held.off_mm, 3)} mm across the way at the most, line {held.line} "
        f"(tolerance {held.tolerance_mm:g} mm)"
    )
    if held.slowest_mm_min is None:
        return f"{text}: nothing had to be slowed"
    return (
        f"{text}; {shown_number(held.off_before_mm, 3)} mm at the programmed feed: {shown_number(held.slowed_percent)} % of the "
        f"cutting is slowed, to {shown_number(held.slowest_mm_min, 0)} mm/min at the least"
    )


def block_sentence(blocks: BlockTime) -> str:
    """How many motions are shorter than the controller takes for one."""
    return shown_blocks(blocks, "motions of cutting")


def _torques(torques: Torques) -> str:
    """The axes that carry most."""
    rows = (
        (row.max_nm, row.gravity_max_nm or 0.0, axis) for axis, row in torques.axes.items() if row.max_nm is not None
    )
    turning = sorted(rows)[::-1]
    shown = [
        f"{axis} {shown_number(most, 0)} Nm (gravity {shown_number(still, 0)})" for most, still, axis in turning[:_AXES]
    ]
    return f"{', '.join(shown)}, with {torques.provenance}"
