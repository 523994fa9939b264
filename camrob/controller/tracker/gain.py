"""The gain by analysis: what a run without correction lets one expect of the loop at any gain, before it is tried.

At one posture the joints' loops are separate (see `analysis`), so a recorded error is taken to the joints, filtered by each
joint's own loop, and taken back. The tracker's noise is smoothed away beforehand, and the variance of it that the loop lets
through is added.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from camrob.cell.cell import Cell
from camrob.controller.tracker.analysis import JointLoop, Margins
from camrob.controller.tracker.case import TrackerCase
from camrob.controller.tracker.identify import JointLags, joint_errors, path_jacobians
from camrob.controller.tracker.loop import LoopLog
from camrob.errors import JobError
from camrob.frozen import locked

__all__ = ["GainChoice", "check_gain", "choose_gain", "joint_loops", "worst_margins"]

Array = NDArray[np.float64]

PEAK, GAIN_MARGIN = 1.5, 4.0  # what the chosen gain has to keep: |S| at most this, room to grow at least that
_GAINS = np.array([float(f"{g:.2g}") for g in np.geomspace(0.002, 0.2, 33)])
_SMOOTHING = 0.02  # s


@dataclass(frozen=True, slots=True)
class GainChoice:
    """Gains (G,) with what is expected of them: `expected` (G, paths), m, root mean square of the tool's error; `noise` (G,), m,
    the part of it that the tracker's noise makes in a coordinate; `peak` (G,) of |S| and `room` (G,), the factor to
    instability, of the worst joint. `chosen`: the least expected error within the bounds on peak and room.
    """

    gains: Array
    expected: Array
    noise: Array
    peak: Array
    room: Array
    chosen: float

    def __post_init__(self) -> None:
        for name in ("gains", "expected", "noise", "peak", "room"):
            object.__setattr__(self, name, locked(getattr(self, name), name=name))


def joint_loops(case: TrackerCase, lag: Array, latency: int | None = None) -> list[JointLoop]:
    """One loop a joint, with lags (6,), s; `latency` cycles, the case's by default."""
    late = case.latency if latency is None else latency
    return [JointLoop(float(t), case.robot.delay, late, case.law.cycle_s) for t in lag]


def check_gain(loops: Sequence[JointLoop], gain: float) -> None:
    """Raises JobError for a gain at which one of the joints' loops is unstable."""
    limits = [loop.limit() for loop in loops]
    worst = int(np.argmin(limits))
    if gain >= limits[worst]:
        raise JobError(
            "with this gain the tracker loop is unstable; give a smaller one",
            axis=f"A{worst + 1}", value=gain, limit=limits[worst],
        )  # fmt: skip


def worst_margins(loops: Sequence[JointLoop], gain: float) -> Margins:
    """The least margins, and the greatest peak and noise, over the joints."""
    all_ = [loop.margins(gain) for loop in loops]
    return Margins(
        min(m.gain for m in all_), min(m.phase for m in all_), min(m.delay for m in all_), max(m.peak for m in all_),
        min(m.bandwidth for m in all_), max(m.noise for m in all_),
    )  # fmt: skip


def choose_gain(cell: Cell, case: TrackerCase, logs: Sequence[LoopLog], lags: JointLags) -> GainChoice:
    """The best gain for errors recorded without correction. Raises JobError where no gain keeps the bounds."""
    loops = joint_loops(case, lags.lag(case))
    peak = np.array([max(loop.margins(g).peak for loop in loops) for g in _GAINS])
    room = np.array([min(loop.limit() for loop in loops) / g for g in _GAINS])
    noise = np.sqrt([max(loop.noise(g) for loop in loops) for g in _GAINS]) * case.noise.position
    usable = room > 1.0
    expected = np.full((len(_GAINS), len(logs)), np.inf)
    for k, log in enumerate(logs):
        expected[usable, k] = _expected(cell, log, loops, _GAINS[usable])
    expected = np.where(usable[:, None], np.sqrt(expected**2 + 3.0 * noise[:, None] ** 2), np.inf)
    kept = (peak <= PEAK) & (room >= GAIN_MARGIN)
    if not kept.any():
        raise JobError("no gain keeps the tracker loop's margins: the robot or the tracker is too late")
    total = np.where(kept, np.sqrt(np.mean(expected**2, axis=1)), np.inf)
    return GainChoice(_GAINS, expected, noise, peak, room, float(_GAINS[int(np.argmin(total))]))


def _expected(cell: Cell, log: LoopLog, loops: Sequence[JointLoop], gains: Array) -> Array:
    """Root mean square (G,), m, of the tool's error under way, noise left aside."""
    path, seen = log.run.path, np.asarray(log.seen)
    seen = gaussian_filter1d(seen, _SMOOTHING / loops[0].cycle, axis=0, mode="nearest")
    m, n = log.run.latency, len(path)
    held = np.concatenate([np.asarray(path.wanted), np.repeat(path.wanted[-1:], m, axis=0)])
    later = np.concatenate([seen, np.repeat(seen[-1:], m, axis=0)])
    true = later[m : m + n] - (held[m : m + n] - held[:n])  # the error of the instant that was measured
    before, entering = joint_errors(cell, path, true), joint_errors(cell, path, seen)
    J = path_jacobians(cell, np.asarray(path.q))[:, :3]
    out = np.empty(len(gains))
    for g, gain in enumerate(gains):
        moved = np.column_stack([loop.motion(float(gain), entering[:, i]) for i, loop in enumerate(loops)])
        left = np.einsum("nij,nj->ni", J, before - moved)
        out[g] = np.sqrt(np.mean(np.sum(left[path.moving] ** 2, axis=1)))
    return out
