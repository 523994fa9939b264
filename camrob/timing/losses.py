"""Where a program falls short of its feed, and what causes it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.path import ToolPathInBase

__all__ = ["BESIDE", "FEED_KEPT", "PROGRAMMED_FEED", "FeedLoss", "feed_losses", "lost_by_axis"]

Array = NDArray[np.float64]

BESIDE = "slower feed of the motion beside it"
"""What is said where a ramp to or from a slower motion keeps the feed from being reached."""
PROGRAMMED_FEED = "programmed feed"
"""The cause where nothing holds the tool back."""
FEED_KEPT = 0.98
"""Share of the programmed speed from which a piece, on average, counts as keeping its feed."""


@dataclass(frozen=True, slots=True)
class FeedLoss:
    """A run of points where the feed is not reached: points start .. stop (exclusive) and CL lines first .. last.

    `axis` is the axis that causes it ("" where none does), `cause` says it whole, e.g. "A4 acceleration" (never the feed itself
    that is not reached: a ramp to or from a slower motion is BESIDE). feed,
    reached: m/s, programmed and on average; lost: s more than at the programmed feed.
    """

    start: int
    stop: int
    first_line: int
    last_line: int
    axis: str
    cause: str
    feed: float
    reached: float
    lost: float


def feed_losses(
    path: ToolPathInBase,
    speed: Array,
    seconds: Array,
    mean: Array,
    cause: NDArray[np.int16],
    causes: Sequence[str],
    axes: Sequence[str],
) -> tuple[FeedLoss, ...]:
    """Runs of cutting points of one cause, region and feed, that the feed is not reached on.

    speed: (N,) m/s as programmed; seconds, mean: (N,) s and m/s on the way to each point. cause: (N,) index into `causes`
    and `axes`, the name of each cause and the axis that it lies with.
    """
    points = np.flatnonzero(path.cutting & (mean < FEED_KEPT * speed))
    if not len(points):
        return ()
    changes = (np.diff(points) > 1) | (np.diff(cause[points]) != 0) | (np.diff(path.region[points]) != 0)
    changes |= np.diff(speed[points]) != 0.0
    starts = np.concatenate([[0], np.flatnonzero(changes) + 1])
    way = np.add.reduceat((mean * seconds)[points], starts)
    taken = np.add.reduceat(seconds[points], starts)
    firsts = points[starts]
    lasts = points[np.append(starts[1:], len(points)) - 1]
    out = []
    for k, (first, last) in enumerate(zip(firsts.tolist(), lasts.tolist(), strict=True)):
        code, feed = int(cause[first]), float(speed[first])
        lines = int(path.line[first]), int(path.line[last])
        reached, lost = float(way[k] / taken[k]), float(taken[k] - way[k] / feed)
        why = BESIDE if causes[code] == PROGRAMMED_FEED else causes[code]
        out.append(FeedLoss(first, last + 1, *lines, axes[code], why, feed, reached, lost))
    return tuple(out)


def lost_by_axis(losses: Iterable[FeedLoss]) -> dict[str, float]:
    """Seconds lost by axis ("" where no axis causes the loss); most first."""
    sums: dict[str, float] = {}
    for loss in losses:
        sums[loss.axis] = sums.get(loss.axis, 0.0) + loss.lost
    return dict(sorted(sums.items(), key=lambda item: -item[1]))
