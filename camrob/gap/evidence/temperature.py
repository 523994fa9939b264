"""How many rows one independent row stands for: what an effect's and the discrepancy's descriptions leave hangs together.

Rows that are close in time or posture repeat one another's rest, so that their count says nothing of how much they know: a log
with ten times as many rows on the same way must not be ten times as sure. Evidence is weighed by independent rows instead (the
design effect of cluster sampling; Kish, Survey Sampling, 1965, section 5.4).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.neighbourhoods import neighbours_in_row

__all__ = ["cooled", "independent_share", "lowered", "temperatures"]

Array = NDArray[np.float64]

_LAGS = 40  # samples of a path over which what is left may hang together from one to the next
_FEWEST = 64  # neighbourhoods that tell a scatter among them: its error is then a tenth
_SIGMAS = 2.0  # standard errors by which their scatter has to exceed that of independent rows


def temperatures(panels: Sequence[Panel], mean: Array, weights: Array) -> tuple[float, float, float]:
    """How much more the residual speaks than white noise would, in positions, turns and servo errors: its size, times the rows
    over which it hangs together.

    mean: (K,) of the parameters; weights: (M, 6) of the discrepancy's functions.
    """
    worst = [1.0, 1.0, 1.0]
    for p in panels:
        smooth = 0.0 if p.smooth is None else p.smooth @ weights
        r = (p.y_tcp - p.twists(mean) - smooth) * p.w_tcp
        parts = [(r[:, :3], p.w_tcp[:, :3]), (r[:, 3:], p.w_tcp[:, 3:])]
        if p.servo is not None and p.y_servo is not None and p.w_servo is not None:
            parts.append(((p.y_servo - p.errors(mean)) * p.w_servo, p.w_servo))
        order = neighbours_in_row(p.scene)
        for k, (part, w) in enumerate(parts):
            energy, rows = float(np.sum(part**2)), float(np.count_nonzero(w)) * (1.0 if k else p.scene.share)
            lagged = 0.0 if p.scene.poses else _lagged(part)
            together = max(1.0 + 2.0 * max(lagged, 0.0) / max(energy, 1e-300), 1.0 / independent_share(part[order]))
            worst[k] = max(worst[k], energy * together / max(rows, 1.0))
    return worst[0], worst[1], worst[2]


def _lagged(rest: Array) -> float:
    """Sum of the products of rows (N, d) with those up to `_LAGS` less one before them."""
    sums = np.cumsum(np.concatenate([np.zeros((_LAGS, rest.shape[1])), rest]), axis=0)
    return float(np.sum(rest * (sums[_LAGS - 1 : -1] - sums[:-_LAGS])))


def independent_share(rest: Array) -> float:
    """Share of rows (N, d), neighbours beside each other, that are as good as independent: 1 for white noise.

    Sums over neighbourhoods scatter by as much more than those of independent rows would, at the size where that is most.
    """
    energy, count = float(np.sum(rest**2)), len(rest)
    most, cells = 1.0, _FEWEST
    while 2 * cells <= count and energy > 0.0:
        at = (np.arange(count) * cells) // count
        sums = np.stack([np.bincount(at, x, cells) for x in rest.T])
        # a sum of squares of that many sums has this standard error where rows are independent
        error = np.sqrt(2.0 / (cells * rest.shape[1]))
        most = max(most, float(np.sum(sums**2)) / energy / (1.0 + _SIGMAS * error))
        cells *= 2
    return 1.0 / most


def lowered(heat: float, turned: float, servo: float) -> tuple[float, float]:
    """Factors by which the weights of turns and of servo errors are lowered to the positions' temperature."""
    return float(np.sqrt(heat / max(turned, heat))), float(np.sqrt(heat / max(servo, heat)))


def cooled(panels: Sequence[Panel], turned: float, servo: float) -> tuple[Panel, ...]:
    """The panels with the weights of turns and of servo errors lowered by factors."""
    w = np.array([1.0, 1.0, 1.0, *[turned] * 3])
    return tuple(
        replace(p, w_tcp=p.w_tcp * w, w_servo=None if p.w_servo is None else p.w_servo * servo) for p in panels
    )
