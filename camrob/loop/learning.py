"""Iterative learning over repeated laps, beside the tracker loop.

After lap j, with the loop's own correction u and the error e that it saw, the learned correction becomes

    w <- Q ( w + step (u + e(k + lead)) )

With the loop's closed-form quantities (see `analysis`), and D the error without any correction, the next lap's error is
Q (1 - step S (L + z^lead G z^-m)) E + S (1 - Q) D: what a lap leaves is known beforehand, frequency by frequency. Q, a Gaussian
over time in both directions, keeps out noise and what the joints can't follow.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from camrob.errors import JobError
from camrob.loop.analysis import JointLoop
from camrob.loop.loop import LoopLog

__all__ = ["best_lead", "contraction", "learned_after"]

Array = NDArray[np.float64]

_LONGEST = 80  # cycles of lead that are tried


def contraction(loop: JointLoop, gain: float, lead: int, smoothing: float, step: float, omega: Array) -> Array:
    """By what factor a lap multiplies the error at angular frequencies (F,), rad/s. `smoothing`: Q's width, s."""
    z = np.exp(1j * omega * loop.cycle)
    L = loop.open_loop(gain, omega)
    path = L * (1.0 - 1.0 / z) / gain  # G z^-m
    Q = np.exp(-0.5 * (omega * smoothing) ** 2)
    return np.asarray(Q * np.abs(1.0 - step * (L + z**lead * path) / (1.0 + L)))


def best_lead(loops: list[JointLoop], gain: float, smoothing: float, step: float) -> tuple[int, float]:
    """The lead, cycles, whose worst factor over joints and frequencies is least, and that factor.

    Raises JobError where none learns at every frequency.
    """
    omega = np.geomspace(1e-2, np.pi / loops[0].cycle, 800)
    worst = [
        max(float(contraction(loop, gain, lead, smoothing, step, omega).max()) for loop in loops)
        for lead in range(_LONGEST)
    ]
    best = int(np.argmin(worst))
    if worst[best] >= 1.0:
        raise JobError("no lead makes learning converge", value=worst[best], limit=1.0, unit="times the error a lap")
    return best, worst[best]


def learned_after(log: LoopLog, lead: int, smoothing: float, step: float) -> Array:
    """The learned correction (N, 6), m and rad, for the lap after this one."""
    cycle = float(log.run.path.time[1])
    seen, n = np.asarray(log.seen), len(log.run.path)
    early = np.concatenate([seen[lead:], np.repeat(seen[-1:], lead, axis=0)])
    before = np.zeros((n, 6)) if log.run.learned is None else np.asarray(log.run.learned)
    total = before + step * (np.asarray(log.correction) + early)
    return np.asarray(gaussian_filter1d(total, smoothing / cycle, axis=0, mode="nearest"))
