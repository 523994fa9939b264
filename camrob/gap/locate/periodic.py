"""Whether an error comes back with the time, or with an axis's position, and with what period."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import some_rows, whole_gap

__all__ = ["TIME", "Periodic", "periodic"]

Array = NDArray[np.float64]

TIME = "time"
"""The quantity's name where an error comes back with the time."""

_MOST_ROWS, _MOST_CYCLES = 1200, 120  # that are looked at: fewer rows than one cycle has to have can't show it
_FEWEST = 3.0  # cycles: with less of them it is a trend
_OVERSAMPLED = 4  # steps of a frequency that shift the last sample by a quarter of a cycle
_ROWS_A_CYCLE = 5.0
_HARMONICS = 3  # of a period, with the first: a flat on a roller is no sine
_FOLDS = 8
_STILL = 1e-3  # rad or m


@dataclass(frozen=True, slots=True)
class Periodic:
    """quantity: an axis or `TIME`; period: s, rad or m; share: of the energy beyond the noise that was withheld, by blocks."""

    quantity: str
    period: float
    share: float


def periodic(panels: Sequence[Panel], noise: float) -> Periodic | None:
    """What comes back most clearly in some logs' gap at the TCP, None where nothing can.

    A sine of one period with its harmonics, in any direction; its period is that of the highest peak of a least-squares
    periodogram (Lomb, Astrophys. Space Sci. 39, 1976, 447), and its size is fitted to the other blocks where a share is wanted.
    noise: m, 3-D rms.
    """
    parts = [_rows(p) for p in panels]
    gap, block = np.concatenate([g for g, _, _ in parts]), np.concatenate([b for _, b, _ in parts])
    gap = gap - gap.mean(axis=0)
    energy = float(np.sum(gap**2)) - len(gap) * noise**2
    if energy <= 0.0:
        return None
    found = []
    stand = any(p.scene.poses for p in panels)  # poses stand in no time
    for name in (*([] if stand else [TIME]), *panels[0].scene.axes):
        x = np.concatenate([signals[name] for _, _, signals in parts])
        span = float(np.ptp(x))
        if span < _STILL:
            continue
        cycles = min(_MOST_CYCLES, len(x) / _ROWS_A_CYCLE)
        rates = np.arange(_FEWEST, cycles, 1.0 / _OVERSAMPLED) / span
        if len(rates) == 0:
            continue
        best = _peak(rates, x, gap)
        share = _withheld(np.exp(2j * np.pi * best * np.outer(x, 1 + np.arange(_HARMONICS))), gap, block, energy)
        found.append(Periodic(name, 1.0 / best, share))
    return max(found, key=lambda f: f.share, default=None)


def _rows(panel: Panel) -> tuple[Array, NDArray[np.int64], dict[str, Array]]:
    """Gap, block, and what it may come back with, at some of a log's rows."""
    rows = some_rows(panel, _MOST_ROWS)
    scene = panel.scene
    signals = {a: scene.link[rows, k] for k, a in enumerate(scene.axes)}
    return whole_gap(panel)[rows], panel.block[rows], signals | {TIME: scene.t[rows]}


def _peak(rates: Array, x: Array, gap: Array) -> float:
    """The rate (cycles a unit of x) whose sine and cosine explain most of the gap (N, 3)."""
    turned = np.exp(2j * np.pi * np.outer(rates, x))
    turned = turned - turned.mean(axis=1, keepdims=True)
    # of sine and cosine together, whose correlation is small over some cycles
    power = np.sum(np.abs(turned @ gap) ** 2, axis=1) / np.maximum(np.sum(np.abs(turned) ** 2, axis=1), 1e-30)
    return float(rates[int(np.argmax(power))])


def _withheld(turned: NDArray[np.complex128], gap: Array, block: NDArray[np.int64], energy: float) -> float:
    """Share of the energy that sines (N, k) explain on blocks that their size was not fitted to."""
    X = np.concatenate([turned.real, turned.imag, np.ones((len(turned), 1))], axis=1)
    fold, gained = block % _FOLDS, 0.0
    for k in np.unique(fold):
        rows = fold == k
        if rows.all():
            return 0.0
        solved = np.linalg.lstsq(X[~rows], gap[~rows], rcond=1e-9)[0]
        gained += float(np.sum(gap[rows] ** 2) - np.sum((gap[rows] - X[rows] @ solved) ** 2))
    return max(0.0, gained / energy)
