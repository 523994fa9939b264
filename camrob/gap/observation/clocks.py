"""Clocks: one latency between controller and instrument, with its interval."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camrob.gap.observation.noise import plain_gap
from camrob.gap.observation.scene import Scene
from camrob.summaries.diagnosis_summary import Latency

__all__ = ["Alignment", "align"]

_BLOCKS = 10  # a log, for the interval
_ONE_CLOCK = 0.02  # s: of logs that are farther apart each has its own
_LEAST_SPEED = 1e-4  # m/s: without motion a latency doesn't show


@dataclass(frozen=True, slots=True)
class Alignment:
    """latency: s by which the instrument's rows trail the axis values; std: its standard error; NaN where it doesn't show."""

    latency: float
    std: float

    def later(self, delays: Sequence[float]) -> Alignment:
        """The same with what the clocks of the logs were brought together by before; nothing that is the same for all shows
        where that differs.
        """
        apart = float(np.ptp(delays)) if len(delays) else 0.0
        if apart > _ONE_CLOCK:
            return Alignment(math.nan, math.nan)
        return Alignment(self.latency + float(np.mean(delays)), self.std) if any(delays) else self

    @property
    def summary(self) -> Latency:
        """Value and 95 % interval, None where it doesn't show."""
        if not math.isfinite(self.latency):
            return Latency(value=None, interval=None)
        interval = (self.latency - 1.96 * self.std, self.latency + 1.96 * self.std)
        return Latency(value=self.latency, interval=interval)


def align(scenes: Sequence[Scene]) -> Alignment:
    """The latency that explains most of the gap along the motion, beside a constant twist; its spread over blocks of time."""
    estimates = []
    for scene in scenes:
        if scene.poses:
            continue
        v = scene.told(scene.velocity(scene.nominal[:, :3, 3]))
        if float(np.sqrt(np.mean(v**2))) < _LEAST_SPEED:
            continue
        gap = plain_gap(scene)[:, :3]
        for rows in np.array_split(np.arange(len(scene)), _BLOCKS):
            if len(rows) < 20:
                continue
            dv, dg = v[rows] - v[rows].mean(axis=0), gap[rows] - gap[rows].mean(axis=0)
            power = float(np.sum(dv**2))
            if power > 0.0:
                estimates.append((-float(np.sum(dv * dg)) / power, power))
    if len(estimates) < 3:
        return Alignment(math.nan, math.nan)
    value, weight = (np.array(x) for x in zip(*estimates, strict=True))
    mean = float(np.sum(weight * value) / weight.sum())
    spread = float(np.sum(weight**2 * (value - mean) ** 2)) ** 0.5 / float(weight.sum())
    return Alignment(mean, spread)
