"""The feed of a post: what is written, what it takes, where it falls short and why, and the torques that it asks for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.controller.least_times import ShortBlocks
from camrob.dynamics.motion_torques import motion_torques
from camrob.dynamics.torques import JointTorques
from camrob.jobs.files.inputs import JobInputs
from camrob.jobs.solving.feed_within import CAUSE, HeldFeed, OffAtSpeed, held_feed
from camrob.jobs.solving.short_motions import MotionEnds, block_figures, short_motions
from camrob.progress import Share
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Solution
from camrob.summaries.feed_figures import (
    AxisTorque,
    Breaks,
    FeedFigures,
    LimitUse,
    LostFeed,
    TimeUnderLimits,
    Torques,
    WrittenFeedFigures,
)
from camrob.summaries.post_summary import ProgramTime
from camrob.timing.as_it_stands import AsItStands, program_as_it_stands
from camrob.timing.block_time import BLOCK_TIME
from camrob.timing.dips import WrittenFeed, written_feed
from camrob.timing.losses import FEED_KEPT, FeedLoss
from camrob.timing.optimal import FeedPlan, optimal_feed
from camrob.timing.timing import Timing, program_time
from camrob.units import m_s_to_mm_min

__all__ = ["FeedOutcome", "feed_outcome"]

Array = NDArray[np.float64]

_LISTED = 20  # losses in the summary, the dearest first
_SAMPLED = 20_000  # points at which torques are worked out


@dataclass(frozen=True, slots=True)
class FeedOutcome:
    """A path's feed. plan: None where the program keeps its own; held: what a tolerance made of it, None without one. stands:
    the program at its own feed; written: the one with the planned speeds, as the controller's model runs it, and `ordered`
    what that program holds: targets and speeds.

    sampled: (T,) points that `torques` (T, n) are worked out at, all of them on ordinary paths. blocks: motions that are shorter
    than the controller's block time, None where the cell doesn't say it.
    """

    timing: Timing
    plan: FeedPlan | None
    held: HeldFeed | None
    stands: AsItStands
    written: tuple[Timing, AsItStands] | None
    ordered: WrittenFeed | None
    sampled: NDArray[np.int64]
    torques: JointTorques
    blocks: ShortBlocks | None

    @property
    def speed(self) -> Array | None:
        """Speeds (N,) that replace the programmed feed at the targets to write (`targets`), m/s, or None."""
        if self.ordered is not None:
            return np.asarray(self.ordered.speed)
        return None if self.held is None else self.held.speed

    def targets(
        self, path: ToolPathInBase, solution: Solution, keep: NDArray[np.bool_]
    ) -> tuple[ToolPathInBase, Solution, NDArray[np.bool_]]:
        """The path with its solution, and which of its points to keep, for the program to write: with the plan's own points."""
        order = self.ordered
        if order is None:
            return path, solution, keep
        own = np.flatnonzero(~order.added)
        written = replace(
            solution,
            q=order.q,
            inv_kf=order.spread(np.asarray(solution.inv_kf)),
            path_digest=order.path.digest,
            revisions=tuple(replace(r, point=int(own[r.point])) for r in solution.revisions),
        )
        return order.path, written, order.spread(keep) | order.added

    def losses(self, cell: Cell, path: ToolPathInBase) -> tuple[FeedLoss, ...]:
        """Where the program, as it will be run, stays below the programmed feed."""
        run = self.timing if self.plan is None else self.plan
        return run.losses if self.held is None else self.held.losses(cell, path, run.at, run.cause, run.causes)

    @property
    def at(self) -> Array:
        """When the program, as it will be run, is at each point of the path (N,), s."""
        return np.asarray(self.timing.at if self.plan is None else self.plan.at)

    def reached(self, path: ToolPathInBase) -> Array:
        """Mean speed (N,) on the way to each point of cutting as it will be run, m/s; NaN elsewhere."""
        way, seconds = path.step, np.diff(self.at, prepend=0.0)
        moves = path.cutting & (seconds > 0.0) & (way > 0.0)
        return np.where(moves, way / np.where(moves, seconds, 1.0), np.nan)

    def times(self) -> ProgramTime:
        """What the program takes, and the plan."""
        return ProgramTime(
            program=float(self.timing.total), optimal=None if self.plan is None else float(self.plan.total)
        )

    def figures(self, cell: Cell, path: ToolPathInBase) -> FeedFigures:
        """How far the programmed feed is held, what is lost, and the limits that are taken and passed."""
        losses, stands, plan = self.losses(cell, path), self.stands, self.plan
        by_axis: dict[str, float] = {}
        for loss in losses:
            by = loss.axis or (loss.cause if loss.cause in (CAUSE, BLOCK_TIME) else "none")
            by_axis[by] = by_axis.get(by, 0.0) + loss.lost
        way = path.cut
        kept = self.reached(path) >= FEED_KEPT * path.feed
        air = float(self.timing.total) - float(np.sum(np.diff(self.timing.at, prepend=0.0)[path.cutting]))
        return FeedFigures(
            mode="program" if plan is None else "optimal",
            kept_percent=_short(100.0 * float(np.sum(way[kept])) / max(float(np.sum(way)), 1e-12)),
            lost_s=_short(sum(loss.lost for loss in losses)),
            lost_by_axis_s={axis: _short(s) for axis, s in sorted(by_axis.items(), key=lambda item: -item[1])},
            losses_count=len(losses),
            losses=tuple(_loss(loss) for loss in sorted(losses, key=_dearest)[:_LISTED]),
            compared=(
                TimeUnderLimits(
                    limits="speed and acceleration",
                    program_s=_short(self.timing.total),
                    planned_s=None if plan is None else _short(air + plan.unjerked),
                ),
                TimeUnderLimits(
                    limits="speed, acceleration and jerk",
                    program_s=_short(stands.total),
                    planned_s=None if plan is None else _short(plan.total),
                    override_percent_least=_short(100.0 * stands.override),
                ),
            ),
            program_breaks=Breaks(percent_of_cutting=_short(100.0 * stands.past), worst=_worst(stands)),
            planned_uses=None if plan is None else {k: _short(v) for k, v in plan.use.items()},
            written=self._written(),
            tolerance=None if self.held is None else self.held.figures(path),
            blocks=block_figures(self.blocks) if self.blocks is not None and self.blocks.short else None,
        )

    def _written(self) -> WrittenFeedFigures | None:
        """The written program as the controller's model runs it, where its feed was planned."""
        if self.written is None:
            return None
        timing, stands = self.written
        return WrittenFeedFigures(
            model_s=_short(timing.total),
            points_added=0 if self.ordered is None else int(np.count_nonzero(self.ordered.added)),
            percent_of_cutting=_short(100.0 * stands.past),
            worst=_worst(stands),
        )

    def torque_figures(self, cell: Cell, path: ToolPathInBase) -> Torques | None:
        """What the drives have to give; None for a cell without masses."""
        if not cell.masses:
            return None
        total, gravity = np.abs(self.torques.total), np.abs(self.torques.gravity)
        rows = {}
        for k in np.flatnonzero(total.max(axis=0, initial=0.0) > 0.0).tolist():
            worst = int(np.argmax(total[:, k]))
            most, still, line = total[worst, k], gravity[:, k].max(), int(path.line[self.sampled[worst]])
            rows[cell.names[k]] = (
                AxisTorque(max_n=_short(most), gravity_max_n=_short(still), line=line)
                if cell.joints[k].prismatic
                else AxisTorque(max_nm=_short(most), gravity_max_nm=_short(still), line=line)
            )
        masses = tuple(f"{m.name}: {m.mass:g} kg" for m in cell.masses)
        return Torques(masses=masses, provenance=_standing(cell), axes=rows)

    def arrays(self, cell: Cell, own: NDArray[np.bool_]) -> Mapping[str, NDArray[Any]]:
        """Entries of NAME.path.npz: torques and gravity's part (T, n), Nm (N of linear axes), and the rows they belong to.

        own: (N,) the points of the path that the file holds.
        """
        if not cell.masses:
            return {}
        rows, kept = np.cumsum(own) - 1, own[self.sampled]
        return {
            "torque": self.torques.total[kept],
            "torque_gravity": self.torques.gravity[kept],
            "torque_row": rows[self.sampled[kept]],
        }


def feed_outcome(
    inputs: JobInputs,
    q: Array,
    *,
    optimal: bool,
    keep: NDArray[np.bool_] | None = None,
    motions: MotionEnds | None = None,
    off: OffAtSpeed | None = None,
    progress: Share | None = None,
) -> FeedOutcome:
    """Time a path with postures q (N, n), plan its feed where asked to, and judge it.

    motions: from a path and which of its points are kept (N,) to where its program's motions end (N,), for the controller's block
    time; keep: (N,). None: everywhere. off: from postures and times (N,) to what the machine's speed carries the tool off its
    way, (N,) m: the feed is held to the set-up's tolerance.
    """
    cell, path = inputs.cell, inputs.path
    commanded = programmed = path.commanded_speed(inputs.rapid_speed)
    keep = np.ones(len(path), np.bool_) if keep is None else keep
    ends = keep if motions is None else motions(path, keep)

    def planned(speed: Array) -> FeedPlan:
        slower = replace(path, feed=np.where(path.cutting, speed, path.feed))
        return optimal_feed(cell, slower, q, rapid_speed=inputs.rapid_speed, motion_ends=ends, progress=progress)

    def timed(speed: Array) -> Timing:
        return program_time(cell, path, q, speed=speed, motion_ends=ends)

    held, tolerance = None, inputs.setup.tolerance
    timing: Timing | None = None
    plan: FeedPlan | None = None
    if off is not None and tolerance is not None:
        if optimal:
            held, plan = held_feed(path, programmed, tolerance, planned, lambda at: off(q, at))
        else:
            held, timing = held_feed(path, programmed, tolerance, timed, lambda at: off(q, at))
        programmed = held.speed
    timing = timing or timed(programmed)
    order, written = None, None
    if optimal:
        plan = plan or planned(programmed)
        order = written_feed(cell, path, q, plan, cells=tuple(m.cell for m in inputs.mounted), motion_ends=ends)
        said, whole = np.asarray(order.speed), np.asarray(order.spread(programmed))
        own = order.spread(keep) | order.added
        own = own if motions is None else motions(order.path, own)
        ran = program_time(cell, order.path, order.q, speed=said, motion_ends=own)
        written = (
            ran,
            program_as_it_stands(cell, order.path, order.q, ran, speed=said, programmed=whole, motion_ends=own),
        )
    stands = program_as_it_stands(cell, path, q, timing, speed=programmed, plan=plan, motion_ends=ends)
    blocks = short_motions(cell, path, q, commanded, ends)
    # an axis gives no more than its limit, whatever the model of the program's own feed asks
    most = np.where(np.isfinite(cell.limits_of("acceleration")), cell.limits_of("acceleration"), 0.0)
    points = np.linspace(0, len(path) - 1, min(len(path), _SAMPLED)).astype(np.int64)
    worst = [int(np.argmax(np.minimum(np.abs(a), top))) for a, top in zip(stands.acceleration.T, most, strict=True)]
    sampled = np.unique(np.concatenate([points, np.array(worst, np.int64)]))
    # of a long path's motion no more is kept than is asked for
    stands = replace(stands, speed=stands.speed[sampled], acceleration=stands.acceleration[sampled])
    torques = _torques(inputs, q, stands.speed, np.clip(stands.acceleration, -most, most), sampled)
    return FeedOutcome(timing, plan, held, stands, written, order, sampled, torques, blocks)


def _torques(
    inputs: JobInputs, q: Array, speed: Array, acceleration: Array, sampled: NDArray[np.int64]
) -> JointTorques:
    """Torques (T, n) at the points `sampled` (T,) of q (N, n), by the speeds and accelerations (T, n) there, each with the tool
    of its stretch.
    """
    total, gravity = np.zeros((2, len(sampled), q.shape[1]))
    for k, mounted in enumerate(inputs.mounted):
        rows = inputs.path.stretch[sampled] == k if len(inputs.mounted) > 1 else np.ones(len(sampled), np.bool_)
        part = motion_torques(mounted.cell, q[sampled[rows]], speed[rows], acceleration[rows])
        total[rows], gravity[rows] = part.total, part.gravity
    return JointTorques(total, gravity)


def _standing(cell: Cell) -> str:
    """The masses in words, by their provenance: those of the arm are a maker's or a guess, seldom both."""
    kinds = {kind for key, kind in cell.provenance.items() if key.startswith("mass[")}
    return "assumed masses" if "assumed" in kinds or not kinds else "the masses of cell.toml"


def _short(value: float) -> float:
    """Five digits: what such a figure is good for, and the same on every machine."""
    return float(f"{value:.5g}") if abs(value) > 1e-9 else 0.0


def _worst(stands: AsItStands) -> tuple[LimitUse, ...]:
    """The limits that a program takes most of."""
    return tuple(
        LimitUse(quantity=w.kind, times_the_limit=_short(w.times), cause=w.cause, axis=w.axis, line=w.line)
        for w in stands.worst
    )


def _dearest(loss: FeedLoss) -> tuple[float, int]:
    """Order of losses: the dearest first, alike ones as they come."""
    return -_short(loss.lost), loss.start


def _loss(loss: FeedLoss) -> LostFeed:
    return LostFeed(
        first_line=loss.first_line,
        last_line=loss.last_line,
        axis=loss.axis,
        cause=loss.cause,
        feed_mm_min=_short(float(m_s_to_mm_min(loss.feed))),
        reached_mm_min=_short(float(m_s_to_mm_min(loss.reached))),
        lost_s=_short(loss.lost),
    )
