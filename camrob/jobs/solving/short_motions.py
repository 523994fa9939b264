"""Motions of a program that are shorter than its controller takes for one, and what leaving points out would give."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.controller.least_times import ShortBlocks
from camrob.findings import Finding, Severity
from camrob.jobs.files.inputs import JobInputs
from camrob.program.decimate import decimated
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Solution
from camrob.summaries.feed_figures import BlockTime
from camrob.timing.block_time import BLOCK_TIME, motion_lengths
from camrob.timing.losses import FeedLoss
from camrob.timing.straight_pieces import path_rates
from camrob.toolpath.sampling import CHORD_TOLERANCE
from camrob.units import m_to_mm, ms_to_s, s_to_ms

__all__ = ["MotionEnds", "block_figures", "block_findings", "short_motions"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
MotionEnds: TypeAlias = Callable[[ToolPathInBase, Mask], Mask]

_THINNED = 0.7  # of the short motions: where thinning leaves more it is no advice
_WORTH = 0.002  # of the program's time: what is lost below it is not worth a word


def block_figures(found: ShortBlocks | None) -> BlockTime | None:
    """How a summary tells of motions that are too short for the controller."""
    if found is None:
        return None
    return BlockTime(
        block_ms=s_to_ms(found.block),
        motions=found.count,
        short=found.short,
        shortest_ms=float(f"{s_to_ms(found.shortest):.4g}"),
    )


def short_motions(cell: Cell, path: ToolPathInBase, q: Array, speed: Array, ends: Mask) -> ShortBlocks | None:
    """The cutting's motions of a path with postures q (N, n) at `speed` (N,), m/s, that end at `ends` (N,).

    None without a block time.
    """
    block = ms_to_s(cell.controller.block_ms)
    if block <= 0.0:
        return None
    rates = path_rates(cell, path, q)
    at = rates.translates & path.cutting[rates.end] & ends[rates.end]
    seconds = motion_lengths(rates, ends)[at] / speed[rates.end[at]]
    if not len(seconds):
        return ShortBlocks(block, 0, 0, 0.0)
    return ShortBlocks(block, len(seconds), int(np.sum(seconds < block)), float(seconds.min()))


def block_findings(
    inputs: JobInputs,
    solution: Solution,
    found: ShortBlocks | None,
    losses: tuple[FeedLoss, ...],
    seconds: float,
    motions: MotionEnds,
) -> list[Finding]:
    """What there is to say of motions that are too short: the time they cost, and what `decimate_mm` would make of them.

    seconds: that the program takes.
    """
    here = [loss for loss in losses if loss.cause == BLOCK_TIME]
    lost = sum(loss.lost for loss in here)
    if found is None or not here or lost < _WORTH * seconds:
        return []
    share = 100.0 * found.short / found.count
    text = (
        f"{share:.0f} % of the cutting's {found.count} motions would take less than the {s_to_ms(found.block):g} ms that the "
        f"controller takes for one: they are run slower and cost {lost:.1f} s"
    )
    if not inputs.setup.decimate:
        tolerance = inputs.setup.chord_tolerance or CHORD_TOLERANCE
        keep = motions(inputs.path, decimated(inputs.path, solution, tolerance))
        commanded = inputs.path.commanded_speed(inputs.rapid_speed)
        then = short_motions(inputs.cell, inputs.path, np.asarray(solution.q), commanded, keep)
        if then is not None and then.short < _THINNED * found.short:
            text += (
                f"; decimate_mm = {m_to_mm(tolerance):g} in the set-up would leave {then.count} motions, "
                f"{100.0 * then.short / max(then.count, 1):.0f} % of them too short"
            )
    return [Finding("block-time", text, Severity.WARNING, line=here[0].first_line, value=lost, unit="s")]
