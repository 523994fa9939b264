"""The gain by analysis: what a run without correction lets one expect of the loop at any gain, before it is tried.

At one posture the joints' loops are separate (see `analysis`), so a recorded error is taken to the joints, filtered by each
joint's own loop, and taken back. The tracker's noise is smoothed away beforehand, and the variance of it that the loop lets
through is added.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from camrob.cell.cell import Cell
from camrob.errors import JobError
from camrob.frozen import locked
from camrob.kinematics.frames import tool_jacobians
from camrob.loop.analysis import JointLoop, Margins
from camrob.loop.case import TrackerCase
from camrob.loop.identified_joints import JointLags, joint_errors
from camrob.loop.loop import LoopLog

__all__ = ["GainChoice", "GainNeed", "check_gain", "choose_gain", "gain_needs", "joint_loops", "worst_margins"]

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


class GainNeed(NamedTuple):
    """The best `gain` where the measurement is `latency` cycles old and has `noise`, m, in a coordinate, and the `rms` error to
    expect, m; both None where no gain keeps the bounds.
    """

    latency: int
    noise: float
    gain: float | None
    rms: float | None


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
            axis=f"A{worst + 1}",
            value=gain,
            limit=limits[worst],
        )


def worst_margins(loops: Sequence[JointLoop], gain: float) -> Margins:
    """The least margins, and the greatest peak and noise, over the joints."""
    all_ = [loop.margins(gain) for loop in loops]
    return Margins(
        min(m.gain for m in all_),
        min(m.phase for m in all_),
        min(m.delay for m in all_),
        max(m.peak for m in all_),
        min(m.bandwidth for m in all_),
        max(m.noise for m in all_),
    )


def choose_gain(cell: Cell, case: TrackerCase, logs: Sequence[LoopLog], lags: JointLags) -> GainChoice:
    """The best gain for errors recorded without correction. Raises JobError where no gain keeps the bounds."""
    curves = _curves(cell, logs, joint_loops(case, lags.lag(case)), aligned=False)
    at = curves.best(case.noise.position)
    if at is None:
        raise JobError("no gain keeps the tracker loop's margins: the robot or the tracker is too late")
    noise = curves.noise * case.noise.position
    return GainChoice(
        _GAINS, curves.with_noise(case.noise.position), noise, curves.peak, curves.room, float(_GAINS[at])
    )


def gain_needs(
    cell: Cell,
    case: TrackerCase,
    logs: Sequence[LoopLog],
    lags: JointLags,
    latencies: Sequence[int],
    noises: Sequence[float],
) -> tuple[GainNeed, ...]:
    """The best gain for every latency, cycles, and noise of a coordinate, m, with the set-point of the measured instant."""
    out = []
    for latency in latencies:
        curves = _curves(cell, logs, joint_loops(case, lags.lag(case), latency), aligned=True)
        for noise in noises:
            at = curves.best(noise)
            rms = None if at is None else float(np.sqrt(np.mean(curves.with_noise(noise)[at] ** 2)))
            out.append(GainNeed(latency, noise, None if at is None else float(_GAINS[at]), rms))
    return tuple(out)


class _Curves(NamedTuple):
    """By gain: expected error (G, paths), m, noise left aside; noise (G,) as a share of the measurement's; peak and room (G,)."""

    expected: Array
    noise: Array
    peak: Array
    room: Array

    def with_noise(self, sigma: float) -> Array:
        """Expected error (G, paths), m, with the noise of three coordinates."""
        return np.asarray(np.sqrt(self.expected**2 + 3.0 * (sigma * self.noise[:, None]) ** 2))

    def best(self, sigma: float) -> int | None:
        """Which gain has the least of it within the bounds; None where none keeps them."""
        kept = (self.peak <= PEAK) & (self.room >= GAIN_MARGIN)
        total = np.where(kept, np.sqrt(np.mean(self.with_noise(sigma) ** 2, axis=1)), np.inf)
        return int(np.argmin(total)) if kept.any() else None


def _curves(cell: Cell, logs: Sequence[LoopLog], loops: Sequence[JointLoop], *, aligned: bool) -> _Curves:
    room = min(loop.limit() for loop in loops) / _GAINS
    peak = np.array([max(loop.peak(float(g)) for loop in loops) for g in _GAINS])
    usable = room > 1.0
    noise = np.full(len(_GAINS), np.inf)
    noise[usable] = np.sqrt([max(loop.noise(float(g)) for loop in loops) for g in _GAINS[usable]])
    expected = np.full((len(_GAINS), len(logs)), np.inf)
    for k, log in enumerate(logs):
        expected[usable, k] = _expected(cell, log, loops, _GAINS[usable], aligned)
    return _Curves(expected, noise, peak, room)


def _expected(cell: Cell, log: LoopLog, loops: Sequence[JointLoop], gains: Array, aligned: bool) -> Array:
    """Root mean square (G,), m, of the tool's error under way, noise left aside, for loops of any latency."""
    path, smooth, n = log.run.path, _SMOOTHING / loops[0].cycle, len(log.run.path)
    seen = gaussian_filter1d(np.asarray(log.seen), smooth, axis=0, mode="nearest")
    wanted, m, late = np.asarray(path.wanted), log.run.latency, loops[0].latency

    def at(values: Array, shift: int) -> Array:
        return values[np.clip(np.arange(n) + shift, 0, n - 1)]

    true = at(seen, m) - (at(wanted, m) - wanted)  # the error of the instant that was measured
    before = joint_errors(cell, path, true)
    taken = at(true, -late) if aligned else at(true, -late) + wanted - at(wanted, -late)
    entering = joint_errors(cell, path, taken)
    J = tool_jacobians(cell, np.asarray(path.q))[:, :3]
    out = np.empty(len(gains))
    for g, gain in enumerate(gains):
        moved = np.column_stack([loop.motion(float(gain), entering[:, i]) for i, loop in enumerate(loops)])
        left = np.einsum("nij,nj->ni", J, before - moved)
        out[g] = np.sqrt(np.mean(np.sum(left[path.moving] ** 2, axis=1)))
    return out
