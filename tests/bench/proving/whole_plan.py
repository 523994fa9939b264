"""A lower bound, proved, of the planner's objective over all plans of a path, its travel counted in.

For every waypoint and every cell of a lattice of the external axes there are planes below the price of a metre in any posture
that stands there (`bin_prices`); a node's price is the lowest that the planes of the cells beside have there. The cheapest way
through the nodes, its travel priced by `motion_steps`, is a lower bound of every plan, wherever between the nodes that stands:
take one number a, evenly of [0, 1), and put every coordinate x of every waypoint, in steps of the lattice, to the node below
x + a. Each waypoint then stands on corners of its own cell, on average at its own place, and pays on average no more than the
lowest plane there, as that is concave; a move of d steps becomes one of the two whole numbers beside d, on average d, and costs
what lies on the line between their prices. On average over a the plan on nodes is no dearer than the plan; so it is for some a.

Cells through which no way cheaper than `target` leads are left out, the others halved, level by level: either no plan is
below the target, or the last level's bound holds. Left out of the price, so that the bound holds for more than there is:
collisions, limits of axes 1, 4 and 6 and of the roll, margins to limits, the part's error, what the motion of roll and arm costs.
Re-postures are at safe points; the arm may change its branch anywhere.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import process_time

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import CellError
from camrob.redundancy.planning.course import moves_along, waypoint_weights
from camrob.redundancy.planning.freedoms import plan_space
from camrob.redundancy.planning.objective import MotionPrice, Objective, motion_price
from camrob.redundancy.planning.waypoints import Waypoints
from proving.arm_shape import ArmShape, arm_shape
from proving.bin_prices import corner_prices, planes_of_bins
from proving.motion_steps import step_prices
from proving.relaxed import cheapest_through
from proving.seen import Lattice, seen_of_cells
from proving.seen_bins import bins_of

__all__ = ["Level", "PlanProof", "dearest", "prove_plan"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_PRISMATIC, _REVOLUTE = 0.075, 0.4  # m, rad of cells at first
_LEANING, _LEAN = (
    (0.5, 0.25),
    0.1,
)  # times that, where the tool leans against the turning axis by a sine of more than that
_STEPS = 10  # prices of steps that are told apart
_WIDTH = 1.2  # of bins, in halves of a cell of the finest axis
_PIECE = 2.0  # half a piece of the roll, in the same
_FEW = 64  # boxes that a rough piece is worth
_ROOM = 10_000_000  # cells at most: about 4 GB
_LEAST_VALUE = 0.02  # 1/k_F below which no posture gets dearer, as `objective.posture_price` has it
_ROUNDING = 1e-9  # relative, of sums of prices


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
    w: Waypoints,
    most: Array,
    target: float,
    *,
    levels: int = 5,
    say: Callable[[Level], None] | None = None,
    told: list[dict[str, Array | Ints]] | None = None,
) -> PlanProof:
    """A lower bound of the objective over all plans through waypoints, m.

    told: gets what each level rests on (cells, bins, planes, which cells are left), for a certificate.
    most (W,): price of a metre above which it doesn't matter how dear a place is; target: no bound above it is looked for.
    Raises CellError for a cell that the enclosures don't cover.
    """
    if objective.power < 2.0:  # the price is then not convex in k_F^2, and tangents are not below it
        raise CellError(
            f"cell {cell.name}: resolve.planned.power is {objective.power:g}, and the proof needs 2 or more"
        )
    most = np.minimum(most, dearest(objective))
    shape = arm_shape(cell, w.base_T_tip[:, :3, 2].sum(axis=0))
    space = plan_space(cell)
    motion = motion_price(objective, moves_along(w, np.arange(len(w))), "travel", "smoothness", "speed")
    leap = np.where(w.safe, objective.reposture, np.inf)
    count, endless = _first_lattice(shape, space.u_endless, np.asarray(w.base_T_tip[:, :3, 2]))
    k, where = _all_cells(len(w), count)
    shown, known = np.inf, 0.0
    done: list[Level] = []
    for _level in range(levels):
        start = process_time()
        lattice = _lattice(shape, count)
        found = {"count": count.copy(), "k": k, "where": where}
        k, where, corner, bins, planes = _priced(shape, objective, w, most, lattice, k, where, found)
        steps = np.stack([_steps(motion, lattice, i, len(endless)) for i in range(2)], axis=1)
        price, through = cheapest_through(
            count + ~_both(endless),
            _both(endless),
            most,
            np.searchsorted(k, np.arange(len(w) + 1)),
            where,
            corner,
            waypoint_weights(w),
            steps,
            leap,
        )
        bound = min(shown, price * (1.0 - _ROUNDING))
        known = max(known, bound)
        rest = through * (1.0 - _ROUNDING) < target
        if told is not None:
            found["rest"] = np.flatnonzero(found.pop("live"))[rest]
            told.append(found)
        done.append(Level(len(rest), int(rest.sum()), bins, planes, bound, process_time() - start))
        if say is not None:
            say(done[-1])
        halves = 2 ** len(endless)
        if not rest.any() or halves * rest.sum() > _ROOM:
            break
        if not rest.all():
            shown = target
        k = np.repeat(k[rest], halves)
        where = 2 * np.repeat(where[rest], halves, axis=0) + np.tile(_corners(len(endless)), (int(rest.sum()), 1))
        count = np.where(np.arange(2) < len(endless), 2 * count, count)
    return PlanProof(known, tuple(done))


def dearest(objective: Objective) -> float:
    """The price of a metre for its conditioning alone in the worst of postures."""
    return float(objective.conditioning * (objective.threshold / _LEAST_VALUE) ** objective.power)


def _priced(
    shape: ArmShape,
    objective: Objective,
    w: Waypoints,
    most: Array,
    lattice: Lattice,
    k: Ints,
    where: Ints,
    found: dict[str, Array | Ints],
) -> tuple[Ints, Ints, Array, int, int]:
    """The cells that may be cheaper than the most, with the prices at their corners (M, 4); bins and planes that it took.

    found <- each cell's bin (-1: too near axis 1), bins, planes, and which cells are live.
    """
    frames = np.asarray(w.base_T_tip)
    tip, axis = np.ascontiguousarray(frames[:, :3, 3]), np.ascontiguousarray(frames[:, :3, 2])
    seen = seen_of_cells(shape, tip, axis, lattice, k, where)
    near = np.isnan(seen[:, 0, 0])
    corner = np.full((len(k), 4), objective.conditioning * objective.threshold**objective.power)  # 1/k_F is 1 at most
    fine = float(lattice.half[lattice.half > _ROUNDING].min()) if np.any(lattice.half > _ROUNDING) else 0.01
    some = np.flatnonzero(~near)
    bins = bins_of(seen[some], _WIDTH * fine)
    dearest = np.zeros(len(bins.frame))
    np.maximum.at(dearest, bins.own, most[k[some]])
    cap = objective.threshold * (objective.conditioning / dearest) ** (1.0 / objective.power) * (1.0 - 1e-12)
    offset, planes = planes_of_bins(
        shape, objective.power, objective.threshold, bins.frame, bins.box, cap, _PIECE * fine, _FEW
    )
    corner[some] = corner_prices(
        seen[some], bins.own, bins.frame, bins.box, offset, objective.conditioning * planes, most[k[some]]
    )
    live = corner.min(axis=1) < most[k]
    own = np.full(len(k), -1)
    own[some] = bins.own
    found |= {
        "own": own,
        "frame": bins.frame,
        "box": bins.box,
        "cap": cap,
        "offset": offset,
        "planes": planes,
        "live": live,
    }
    return k[live], where[live], np.ascontiguousarray(corner[live]), len(bins.frame), len(planes)


def _first_lattice(shape: ArmShape, u_endless: NDArray[np.bool_], axis: Array) -> tuple[Ints, NDArray[np.bool_]]:
    """Cells (2,) along each external axis at first, one along none, and which of the axes there are (E,) are endless."""
    count = np.ones(2, np.int64)
    lean = np.linalg.norm((axis @ shape.before.T)[:, :2], axis=1).max()
    for i in range(len(shape.after)):
        step = _PRISMATIC if shape.prismatic[i] else _REVOLUTE
        if lean > _LEAN:
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


def _steps(motion: MotionPrice, lattice: Lattice, i: int, external: int) -> Array:
    """(W, _STEPS) prices of steps along external axis i, none where there is no such axis."""
    if i >= external:
        return np.zeros((len(motion.haste), _STEPS))
    return step_prices(motion, i, float(lattice.step[i]), _STEPS)


def _all_cells(count: int, cells: Ints) -> tuple[Ints, Ints]:
    """Every cell for each of `count` waypoints."""
    every = np.stack(np.meshgrid(np.arange(cells[0]), np.arange(cells[1]), indexing="ij"), axis=-1).reshape(-1, 2)
    return np.repeat(np.arange(count), len(every)), np.tile(every, (count, 1))


def _corners(external: int) -> Ints:
    """What to add to twice a cell for the cells that it falls into."""
    pairs = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    return pairs if external == 2 else pairs[[0, 2]] if external == 1 else pairs[:1]
