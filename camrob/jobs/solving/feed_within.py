"""A feed low enough that what the machine's speed does to the path stays within the set-up's tolerance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.findings import Finding, Severity
from camrob.jobs.files.inputs import JobInputs
from camrob.jobs.solving.sought import Sought
from camrob.redundancy.path import ToolPathInBase
from camrob.summaries.feed_figures import HeldToTolerance
from camrob.timing.losses import FeedLoss, feed_losses
from camrob.timing.optimal import coarsen
from camrob.units import m_s_to_mm_min, m_to_mm

__all__ = ["CAUSE", "HeldFeed", "OffAtSpeed", "held_feed", "off_at_speed", "tolerance_findings"]

Array = NDArray[np.float64]
OfPoints: TypeAlias = Callable[[Array], Array]
OffAtSpeed: TypeAlias = Callable[[Array, Array], Array]


class _Timed(Protocol):
    """A path that is timed: `at` (N,), s at each point."""

    @property
    def at(self) -> Array: ...


T = TypeVar("T", bound=_Timed)

CAUSE = "tolerance"
"""What holds the feed back, beside limits of axes and of the controller."""
_ROUNDS = 6  # of slowing: an error that grows with acceleration takes more than one
_AIM = 0.97  # of the tolerance: what rounding speeds leaves
_MEMORY = 0.05  # s of way before and after what is off, that are slowed with it: drives follow over some hundredths
_STAIR = 0.05  # of a speed that neighbours may differ by and be written as one
_SLOWEST = 0.05  # of the programmed feed: below it nobody would cut


@dataclass(frozen=True, slots=True)
class HeldFeed:
    """speed: (N,) m/s commanded on the way to each point. before, after: (N,) m that the tool is off across its
    way at the most while cutting, by the speed alone, at the programmed feed and at `speed`; tolerance: m.
    """

    programmed: Array
    speed: Array
    before: Array
    after: Array
    tolerance: float

    @property
    def slowed(self) -> NDArray[np.bool_]:
        """(N,) where the commanded speed is below the programmed one."""
        return self.speed < self.programmed

    def figures(self, path: ToolPathInBase) -> HeldToTolerance:
        """For the summary."""
        way = path.cut
        slow = np.asarray(self.speed)[self.slowed]
        return HeldToTolerance(
            tolerance_mm=m_to_mm(self.tolerance),
            off_before_mm=round(m_to_mm(float(self.before.max(initial=0.0))), 4),
            off_mm=round(m_to_mm(float(self.after.max(initial=0.0))), 4),
            line=int(path.line[int(np.argmax(self.after))]),
            slowed_percent=float(f"{100.0 * np.sum(way[self.slowed]) / max(float(np.sum(way)), 1e-12):.4g}"),
            slowest_mm_min=float(f"{m_s_to_mm_min(float(slow.min())):.5g}") if len(slow) else None,
        )

    def losses(
        self, cell: Cell, path: ToolPathInBase, at: Array, cause: NDArray[np.int16], causes: tuple[str, ...]
    ) -> tuple[FeedLoss, ...]:
        """Where a path that is at its points at `at` (N,) s falls short of the programmed feed; cause (N,): the number among
        `causes` of what holds it back on the way to each, commanded at `speed`: 0 the feed itself.
        """
        seconds, way = np.diff(at, prepend=0.0), path.step
        mean = np.divide(way, seconds, out=np.full(len(way), np.nan), where=(way > 0.0) & (seconds > 0.0))
        why = np.where((cause == 0) & self.slowed, len(causes), cause).astype(np.int16)
        axes = [name if (name := c.split()[0]) in cell.names else "" for c in causes]
        return feed_losses(path, self.programmed, seconds, mean, why, (*causes, CAUSE), (*axes, ""))


def tolerance_findings(held: HeldFeed | None, path: ToolPathInBase) -> list[Finding]:
    """What there is to say of the set-up's tolerance: it is passed still, or nobody knows (None) what the speed does."""
    if held is None:
        text = "tolerance_mm holds the feed where a diagnosis says what the machine's speed does: give --diagnosis"
        return [Finding("tolerance", text, Severity.INFO)]
    worst = int(np.argmax(held.after))
    if held.after[worst] <= held.tolerance:
        return []
    off, most = m_to_mm(float(held.after[worst])), m_to_mm(held.tolerance)
    text = f"the machine's speed leaves {off:.3g} mm across the way, where {most:g} mm was asked for: the feed was lowered, "
    text += f"but nowhere below {100 * _SLOWEST:g} % of the programmed one"
    return [Finding("tolerance", text, Severity.WARNING, line=int(path.line[worst]), value=off, limit=most, unit="mm")]


def held_feed(
    path: ToolPathInBase, programmed: Array, tolerance: float, timed: Callable[[Array], T], off: OfPoints
) -> tuple[HeldFeed, T]:
    """The feed of a path, held to a tolerance (m), and how that is timed. programmed: (N,) m/s.

    timed: from commanded speeds (N,) to the times at each point; off: from times (N,) to m off across the way.
    """
    cutting = np.asarray(path.cutting)
    way = path.step
    speed, run = programmed.copy(), timed(programmed)
    at = np.asarray(run.at)
    before = after = off(at) * cutting
    for _round in range(_ROUNDS):
        if after.max(initial=0.0) <= tolerance:
            break
        seconds = np.diff(at, prepend=at[0])
        reached = np.divide(way, seconds, out=np.full(len(way), np.inf), where=seconds > 0.0)
        share = np.where(after > tolerance, _AIM * tolerance / np.maximum(after, 1e-12), 1.0)
        ceiling = _round_about(at, np.where(share < 1.0, share * np.minimum(reached, speed), np.inf))
        lower = np.maximum(np.minimum(speed, ceiling), _SLOWEST * programmed)
        speed = _stairs(np.where(cutting & (lower < speed), lower, speed), programmed)
        run = timed(speed)
        at = np.asarray(run.at)
        after = off(at) * cutting
    return HeldFeed(programmed, speed, before, after, tolerance), run


def _round_about(at: Array, ceiling: Array) -> Array:
    """The least ceiling (N,) within _MEMORY seconds of each point."""
    low, out = np.flatnonzero(np.isfinite(ceiling)), ceiling.copy()
    first = np.searchsorted(at, at[low] - _MEMORY)
    last = np.searchsorted(at, at[low] + _MEMORY, side="right")
    for k, a, b in zip(low.tolist(), first.tolist(), last.tolist(), strict=True):
        out[a:b] = np.minimum(out[a:b], ceiling[k])
    return out


def _stairs(speed: Array, programmed: Array) -> Array:
    """Speeds (N,) in few steps where they are lower than programmed, and never above themselves."""
    out, slow = speed.copy(), speed < programmed
    edges = np.flatnonzero(np.diff(np.concatenate([[False], slow, [False]]).astype(np.int8)))
    for a, b in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        out[a:b] = coarsen(speed[a:b], _STAIR)
    return out


def off_at_speed(held: Sought | None, inputs: JobInputs) -> OffAtSpeed | None:
    """What the machine's speed does, where the feed is held to a tolerance and a diagnosis knows the machine."""
    if held is None or held.diagnosis is None:
        return None
    from camrob.jobs.solving.machine_at_speed import machine_at_speed

    return machine_at_speed(held, inputs)
