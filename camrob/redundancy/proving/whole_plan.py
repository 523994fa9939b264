"""A lower bound, proved, of the planner's objective over all plans of a path, its travel counted in.

For every waypoint and every cell of a lattice of the external axes there are planes below the price of a metre in any posture
that stands there (`bin_prices`); a node's price is the lowest that the planes of the cells beside have there. The cheapest way
through the nodes, its travel priced by `motion_steps`, is a lower bound of every plan, wherever between the nodes that stands:
take one number a, evenly of [0, 1), and put every coordinate x of every waypoint, in steps of the lattice, to the node below
x + a. Each waypoint then stands on corners of its own cell, on average at its own place, and pays on average no more than the
lowest plane there, as that is concave; a move of d steps becomes one of the two whole numbers beside d, on average d, and costs
what lies on the line between their prices. On average over a the plan on nodes is no dearer than the plan; so it is for some a.

Cells through which no way cheaper than `target` leads are left out, the others halved, level by level: either no plan is
below the target, or the last level's bound holds. Of a level the cells through which the cheapest ways lead are priced first;
those that there is no time for keep what the cells that they are halves of are known to cost. Left out of the price, so that the
bound holds for more than there is: collisions, limits of axes 1, 4 and 6 and of the roll, margins to limits, the part's error,
what the motion of roll and arm costs. Re-postures are at safe points; the arm may change its branch anywhere.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import monotonic, process_time

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import CellError
from camrob.progress import Share
from camrob.redundancy.clock import Clock
from camrob.redundancy.planning.freedoms import plan_space
from camrob.redundancy.planning.objective import MotionPrice, Objective
from camrob.redundancy.proving.arm_shape import ArmShape, arm_shape
from camrob.redundancy.proving.bin_prices import corner_prices
from camrob.redundancy.proving.bins_in_time import Priced, merged, priced_in_time
from camrob.redundancy.proving.motion_steps import step_prices
from camrob.redundancy.proving.relaxed import cheapest_through
from camrob.redundancy.proving.seen_bins import bins_of
from camrob.redundancy.proving.seen_from_arm import Lattice, seen_of_cells
from camrob.redundancy.proving.statement import Statement

__all__ = ["LEAN", "Level", "PlanProof", "Told", "leaning", "prove_plan"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Told = dict[str, Array | Ints]
"""What a level rests on: cells, the bin of each, bins, planes, and which cells are left."""

_PRISMATIC, _REVOLUTE = 0.075, 0.4  # m, rad of cells at first
LEAN = 0.1
"""Sine of the tool's angle against the turning axis from which on it leans."""
_LEANING = (1.0, 0.5)  # times those cells, where the tool leans
_STEPS = 10  # prices of steps that are told apart
_WIDTH = 1.2  # of bins, in halves of a cell of the finest axis
_PIECE = 2.0  # half a piece of the roll, in the same
_FEW = 64  # boxes that a rough piece is worth
_ROOM = 10_000_000  # cells at most: about 4 GB
_ROUNDING = 1e-9  # relative, of sums of prices
_AT_LEAST = 1.5  # times what a level takes beside its planes that there has to be left for one


@dataclass(frozen=True, slots=True)
class Level:
    """What a level came to: cells that were looked at and that were left, bins, planes, its bound in m, seconds of one core."""

    cells: int
    left: int
    bins: int
    planes: int
    bound: float
    seconds: float


@dataclass(frozen=True, slots=True)
class PlanProof:
    """What is proved: no plan costs less than `bound`, m."""

    bound: float
    levels: tuple[Level, ...]

    def gap(self, price: float) -> float:
        """How far, as a share of it, a plan of a price may be above the best that exists."""
        return 1.0 - self.bound / price


def prove_plan(
    cell: Cell,
    objective: Objective,
    stated: Statement,
    target: float,
    *,
    levels: int = 5,
    clock: Clock | None = None,
    say: Callable[[Level], None] | None = None,
    told: list[Told] | None = None,
    progress: Share | None = None,
) -> PlanProof:
    """A lower bound of the objective over all plans of a statement's waypoints, m.

    target: no bound above it is looked for. clock: until when; what there is no time for counts for what is known of wider cells
    about it, at first for the least that any posture costs, and a level that shows no more than the one before is left out.
    told: gets what the bound rests on, level by level. progress: called with the share of the present level that is done.
    Raises CellError for a cell that isn't covered.
    """
    if objective.power < 2.0:  # the price is then not convex in k_F^2, and tangents are not below it
        raise CellError(
            f"cell {cell.name}: resolve.planned.power is {objective.power:g}, and the proof needs 2 or more",
            hint="set it to 2 or more, or do without --prove",
        )
    shape, space = arm_shape(cell, stated.axis.sum(axis=0)), plan_space(cell)
    watch = _Watch(clock or Clock(None), progress)
    count, endless = _first_lattice(shape, space.u_endless, stated.axis)
    k, where = _all_cells(len(stated.weight), count)
    shown, known = np.inf, 0.0
    done: list[Level] = []
    rests: list[Told] = []
    before: _Before | None = None
    for _level in range(levels):
        start, begun = process_time(), monotonic()
        lattice = _lattice(shape, count)
        found: Told = {"count": count.copy(), "k": k, "where": where}
        corner, priced, bins, spent = _priced(shape, objective, stated, lattice, found, watch, before)
        live = np.asarray(found.pop("live"), np.int64)
        price, through = _through(stated, lattice, count, endless, k[live], where[live], corner[live])
        bound = min(shown, price * (1.0 - _ROUNDING))
        cheap = through * (1.0 - _ROUNDING) < target
        rest: Ints = live[cheap]
        found["rest"] = rest
        done.append(Level(len(live), len(rest), bins, len(priced.planes), bound, process_time() - start))
        if say is not None:
            say(done[-1])
        rests.append(found)
        if told is not None and bound > known:
            told[:] = rests
        known = max(known, bound)
        halves = 2 ** len(endless)
        beside = (
            (monotonic() - begun - spent) * halves * len(rest) / len(k)
        )  # s that the next level takes without its planes
        if not len(rest) or halves * len(rest) > _ROOM or watch.late_after(_AT_LEAST * beside):
            break
        if len(rest) < len(live):
            shown = target
        own = np.asarray(found["own"], np.int64)[rest]
        before = _Before(priced, np.repeat(own, halves), np.repeat(through[cheap], halves))
        k = np.repeat(k[rest], halves)
        where = 2 * np.repeat(where[rest], halves, axis=0) + np.tile(_corners(len(endless)), (len(rest), 1))
        count = np.where(np.arange(2) < len(endless), 2 * count, count)
    return PlanProof(known, tuple(done))


@dataclass(frozen=True, slots=True)
class _Before:
    """What is known of the cells that a level's cells are parts of: bins; own (M,): the bin of each, -1 for none; through (M,):
    what the cheapest way through it costs, m.
    """

    priced: Priced
    own: Ints
    through: Array


def _through(
    stated: Statement, lattice: Lattice, count: Ints, endless: NDArray[np.bool_], k: Ints, where: Ints, corner: Array
) -> tuple[float, Array]:
    """`cheapest_through` for cells where (M, 2) of waypoints k (M,), in their order, and prices at their corners (M, 4)."""
    price, through = cheapest_through(
        count + ~_both(endless),
        _both(endless),
        stated.most,
        np.searchsorted(k, np.arange(len(stated.weight) + 1)),
        where,
        np.ascontiguousarray(corner),
        stated.weight,
        np.stack([_steps(stated, lattice, i) for i in range(2)], axis=1),
        stated.leap,
    )
    return float(price), through


@dataclass(frozen=True, slots=True)
class _Watch:
    """Until when, and who is told how much of a level is done."""

    clock: Clock
    progress: Share | None

    def done(self, share: float) -> bool:
        """Say so; whether the time is over."""
        if self.progress is not None:
            self.progress(share)
        return self.clock.up

    def late_after(self, seconds: float) -> bool:
        """Whether the time will be over then."""
        left = self.clock.left
        return left is not None and left < seconds


def leaning(cell: Cell, axis: Array) -> NDArray[np.bool_]:
    """Which of the tool's axes (W, 3) in `base` lean against the external axis that turns."""
    shape = arm_shape(cell, axis.sum(axis=0))
    return np.asarray(np.linalg.norm((axis @ shape.before.T)[:, :2], axis=1) > LEAN)


def _priced(
    shape: ArmShape,
    objective: Objective,
    stated: Statement,
    lattice: Lattice,
    found: Told,
    watch: _Watch,
    before: _Before | None,
) -> tuple[Array, Priced, int, float]:
    """Prices (M, 4) at the corners of the cells `found`; their bins; how many of these were worked out, and the seconds for that.

    found <- each cell's bin (-1: too near axis 1), bins, planes, and which cells are live: may be cheaper than the most.
    """
    k, where, most = np.asarray(found["k"], np.int64), np.asarray(found["where"], np.int64), stated.most
    seen = seen_of_cells(shape, stated.tip, stated.axis, lattice, k, where)
    near = np.isnan(seen[:, 0, 0])
    corner = np.full((len(k), 4), objective.conditioning * objective.threshold**objective.power)  # 1/k_F is 1 at most
    fine = float(lattice.half[lattice.half > _ROUNDING].min()) if np.any(lattice.half > _ROUNDING) else 0.01
    some = np.flatnonzero(~near)
    bins = bins_of(seen[some], _WIDTH * fine)
    dearest, first = np.zeros(len(bins.frame)), np.full(len(bins.frame), np.inf)
    np.maximum.at(dearest, bins.own, most[k[some]])
    cap = objective.threshold * (objective.conditioning / dearest) ** (1.0 / objective.power) * (1.0 - 1e-12)
    np.minimum.at(first, bins.own, k[some] if before is None else before.through[some])
    begun = monotonic()
    new, told = priced_in_time(
        shape, objective, bins, cap, np.argsort(first, kind="stable"), (_PIECE * fine, _FEW), watch.done
    )
    spent = monotonic() - begun
    priced, own_some = (
        (new, bins.own) if before is None else merged(seen[some], bins.own, new, told, before.priced, before.own[some])
    )
    corner[some] = corner_prices(
        seen[some],
        own_some,
        priced.frame,
        priced.box,
        priced.offset,
        objective.conditioning * priced.planes,
        most[k[some]],
    )
    own = np.full(len(k), -1)
    own[some] = own_some
    found |= {"own": own, "live": np.flatnonzero(corner.min(axis=1) < most[k]), **priced._asdict()}
    return corner, priced, int(told.sum()), spent


def _first_lattice(shape: ArmShape, u_endless: NDArray[np.bool_], axis: Array) -> tuple[Ints, NDArray[np.bool_]]:
    """Cells (2,) along each external axis at first, one along none, and which of the axes there are (E,) are endless."""
    count = np.ones(2, np.int64)
    lean = np.linalg.norm((axis @ shape.before.T)[:, :2], axis=1).max()
    for i in range(len(shape.after)):
        step = _PRISMATIC if shape.prismatic[i] else _REVOLUTE
        if lean > LEAN:
            step *= _LEANING[0] if shape.prismatic[i] else _LEANING[1]
        count[i] = max(3, int(np.ceil((shape.upper[i] - shape.lower[i]) / step)))
    return count, np.asarray(u_endless[: len(shape.after)])


def _both(endless: NDArray[np.bool_]) -> NDArray[np.bool_]:
    return np.append(endless, np.zeros(2 - len(endless), np.bool_))


def _lattice(shape: ArmShape, count: Ints) -> Lattice:
    low, step = np.zeros(2), np.zeros(2)
    for i in range(len(shape.after)):
        low[i], step[i] = shape.lower[i], (shape.upper[i] - shape.lower[i]) / count[i]
    return Lattice(low, step, 0.5 * step * (1.0 + 1e-12) + 1e-12)


def _steps(stated: Statement, lattice: Lattice, i: int) -> Array:
    """(W, _STEPS) prices of steps along external axis i, none where there is no such axis."""
    if i >= stated.rate.shape[1]:
        return np.zeros((len(stated.haste), _STEPS))
    motion = MotionPrice(stated.rate, stated.square, stated.top, stated.haste)
    return step_prices(motion, i, float(lattice.step[i]), _STEPS)


def _all_cells(count: int, cells: Ints) -> tuple[Ints, Ints]:
    """Every cell for each of `count` waypoints."""
    every = np.stack(np.meshgrid(np.arange(cells[0]), np.arange(cells[1]), indexing="ij"), axis=-1).reshape(-1, 2)
    return np.repeat(np.arange(count), len(every)), np.tile(every, (count, 1))


def _corners(external: int) -> Ints:
    """What to add to twice a cell for the cells that it falls into."""
    pairs = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    return pairs if external == 2 else pairs[[0, 2]] if external == 1 else pairs[:1]
