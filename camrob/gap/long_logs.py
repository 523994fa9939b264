"""Logs of more rows than a diagnosis needs: stretches of them, spread over all of their time, stand for the rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.measurement.log import MeasurementLog

__all__ = ["left_out_of", "shortened"]

_MOST = 20_000  # rows of all logs together: half a minute of one core; more tell hardly more
_STRETCHES = 25  # of a log: each as long as it can be, as drives, gears and drift show in runs of rows


def shortened(logs: Sequence[MeasurementLog]) -> tuple[MeasurementLog, ...]:
    """The logs, of no more than 20 000 rows together: of longer runs stretches of neighbouring rows, evenly over their time; of
    poses some, evenly. Others are as they were.
    """
    total = sum(len(log) for log in logs)
    if total <= _MOST:
        return tuple(logs)
    return tuple(_stretches(log, max(1, len(log) * _MOST // total)) for log in logs)


def _stretches(log: MeasurementLog, most: int) -> MeasurementLog:
    """About `most` rows of a log."""
    count = len(log)
    parts = most if log.info.poses else min(_STRETCHES, most)
    long = most // parts
    starts = np.round(np.linspace(0, count - long, parts)).astype(np.int64)
    return log.select(np.unique((starts[:, None] + np.arange(long)).ravel()))


def left_out_of(logs: Sequence[MeasurementLog], taken: Sequence[MeasurementLog]) -> list[str]:
    """A sentence for every log of which `shortened` took less than half, in words."""
    said = []
    for log, part in zip(logs, taken, strict=True):
        if 2 * len(part) < len(log):
            name = log.name
            how = "some of them, evenly" if log.info.poses else f"{_STRETCHES} stretches of them, evenly over its time"
            said.append(f"{name} holds {len(log)} rows: {len(part)} stand for all, {how}")
    return said
