"""The planner's objective, in metres: a posture's price for each metre that is cut in it, and what motion costs beside.

For waypoints k that stand for l_k m of cutting each (in air for AIR_SHARE of their travel), with x = 1/k_F,

    J =   sum l_k conditioning (x_0 / x_k)^power                                     conditioning
        + sum l_k margin sum_i (2 - d_i/m)+^2 (+ 10 (1 - d_i/m)+^2)                    limit margins
        + sum travel (revolute |dE|, prismatic |dE|) * scale                            external travel
        + sum smoothness |dE|^2 / ds                                                   its smoothness
        + sum speed (|dE| / (speed_share v_max dt) - 1)+^2 ds                          external speed at the programmed feed
        + sum arm_step |dA|^2 / ds                                                     steps of the arm's joints
        + sum turning |dA| in cuts                                                     of axes that leave marks (`part_error`)
        + re-postures * reposture                                                       re-postures in void motions

x_0 is the cell's own threshold on 1/k_F; (x_0/x)^power is convex in x, so that poor places weigh more than good ones gain.
d_i is a joint's distance to its limit, m the margin wanted (margin_deg, margin_mm). What keeps the arm clear of obstacles
stands beside the objective and is no part of it: BLOCKED_PRICE (1 - r / BLOCKED_REACH)^2 a metre where a posture that was
found to touch something there lies r < BLOCKED_REACH away, measured in `posture_features`. The weights are numbers of the
cell, `[resolve.planned]`:

    conditioning 1      power 1         margin 1           margin_deg degrees     margin_mm mm
    travel_revolute m a rad             travel_prismatic m a m                    smoothness m2 a rad2 or m2
    speed 1             speed_share 1   arm_step m2 a rad2                        reposture m
    accuracy 1          (see `part_error`; 0: the part's error is not looked at)
    knee_share 1        the share of its bound that the mean 1/k_F has to keep at the knee (see `planned`)
    knee_travel 1       the share of the published method's external travel that it may cost there
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.compiled import kernel, part
from camrob.errors import CellError
from camrob.redundancy.accuracy.part_error import NO_ERRORS, SHARE, ErrorNumbers, expected_square
from camrob.redundancy.planning.freedoms import PlanSpace, PlanWork, conditioning, plan_work
from camrob.units import deg_to_rad, mm_to_m

__all__ = [
    "AIR_SHARE",
    "BEYOND",
    "BLOCKED_PRICE",
    "BLOCKED_REACH",
    "MOTION_TERMS",
    "POSTURE_TERMS",
    "MotionPrice",
    "Moves",
    "Objective",
    "PlanWeights",
    "blocked_price",
    "error_price",
    "motion_price",
    "plan_prices",
    "plan_weights",
    "posture_features",
    "posture_price",
]

Array = NDArray[np.float64]

AIR_SHARE = 0.1
"""What a metre in air counts of a metre of cutting, for postures and for travel."""
BLOCKED_REACH, BLOCKED_PRICE = 0.35, 30.0
"""How far about a touching posture is avoided, and its price a metre."""
BEYOND = 100.0
"""Price of a metre where no posture exists."""


@dataclass(frozen=True, slots=True)
class PlanWeights:
    """The cell's numbers, `[resolve.planned]`; see the module for what they weigh and their units."""

    conditioning: float = 1.0
    power: float = 4.0
    margin: float = 1.0
    margin_deg: float = 5.0
    margin_mm: float = 20.0
    travel_revolute: float = 0.04
    travel_prismatic: float = 0.02
    smoothness: float = 0.0002
    speed: float = 1.0
    speed_share: float = 0.8
    arm_step: float = 0.0001
    reposture: float = 0.2
    accuracy: float = 0.0
    knee_share: float = 0.96
    knee_travel: float = 0.25


def plan_weights(cell: Cell) -> PlanWeights:
    """The weights that the cell gives. Raises CellError for a name that the planner does not know."""
    known = {f.name for f in fields(PlanWeights)}
    for key in cell.resolve.planned:
        if key not in known:
            raise CellError(
                f"resolve.planned.{key} is not a weight of the planner",
                hint=f"use {', '.join(sorted(known))}",
                path=cell.folder / "cell.toml",
            )
    return PlanWeights(**dict(cell.resolve.planned))


class Objective(NamedTuple):
    """The weights for the kernels. margin (6,), u_margin (F,): what the joints shall keep, SI; travel (F,): price of external
    travel (0 for the roll); u_speed (F,): the share of their speeds that may be used; u_smooth (F,). blocked (K, 9): features of
    postures that are forbidden, and from where to where along the path (`replanning`); wrist_zero: the fifth joint's angle at
    which the axes of the fourth and sixth are one; errors: what the part's error is reckoned from.
    """

    power: float
    threshold: float
    conditioning: float
    margin_price: float
    margin: Array
    u_margin: Array
    travel: Array
    u_smooth: Array
    u_speed: Array
    speed: float
    arm_step: float
    reposture: float
    blocked: Array
    wrist_zero: float
    errors: ErrorNumbers = NO_ERRORS

    @classmethod
    def of(cls, cell: Cell, space: PlanSpace, weights: PlanWeights) -> Objective:
        """The objective of a cell."""
        F = len(space.free)
        external = F - space.roll
        travel, margin, smooth = np.zeros(F), np.zeros(F), np.full(F, weights.smoothness)
        for i in range(external):
            travel[i] = weights.travel_prismatic if space.prismatic[i] else weights.travel_revolute
            margin[i] = mm_to_m(weights.margin_mm) if space.prismatic[i] else deg_to_rad(weights.margin_deg)
        speed = weights.speed_share * np.asarray(cell.limits_of("speed"))[space.free]
        return cls(
            weights.power,
            cell.resolve.threshold,
            weights.conditioning,
            weights.margin,
            np.full(6, deg_to_rad(weights.margin_deg)),
            margin,
            travel,
            smooth,
            speed,
            weights.speed,
            weights.arm_step,
            weights.reposture,
            np.zeros((0, 9)),
            _wrist_zero(space),
        )


@part
def _margin_price(d: float, m: float) -> float:
    """The barrier of a joint that lies d inside its limit and shall keep m."""
    if m <= 0.0 or d >= 2.0 * m:
        return 0.0
    soft = 2.0 - d / m
    hard = max(0.0, 1.0 - d / m)
    return float(soft * soft + 10.0 * hard * hard)


def _wrist_zero(space: PlanSpace) -> float:
    """The fifth joint's angle at which it turns the sixth axis onto the fourth."""
    h = space.arm.h
    return float(np.arctan2(h[4] @ np.cross(h[5], h[3]), h[5] @ h[3] - (h[4] @ h[5]) * (h[4] @ h[3])))


@kernel
def posture_features(wrist_zero: float, q: Array) -> Array:
    """What an arm's posture q (6,) looks like (7,), A1 apart: alike for whole turns and for both wrists of one pose."""
    bend = q[4] - wrist_zero
    s = np.sin(bend)
    return np.array([q[1], q[2], np.cos(bend), s * np.cos(q[3]), s * np.sin(q[3]), s * np.cos(q[5]), s * np.sin(q[5])])


@part
def posture_price(space: PlanSpace, objective: Objective, u: Array, q: Array, value: float) -> tuple[float, float]:
    """Price of a metre cut in a posture u (F,), q (6,) whose 1/k_F is `value`: its conditioning, its limit margins."""
    x = max(value, 0.02)
    margins = 0.0
    for i in range(6):
        margins += _margin_price(min(q[i] - space.lower[i], space.upper[i] - q[i]), objective.margin[i])
    for i in range(u.shape[0]):
        if not space.u_endless[i]:
            margins += _margin_price(min(u[i] - space.u_lower[i], space.u_upper[i] - u[i]), objective.u_margin[i])
    return objective.conditioning * (objective.threshold / x) ** objective.power, objective.margin_price * margins


@part
def blocked_price(objective: Objective, q: Array, here: NDArray[np.bool_]) -> float:
    """Price of a metre for being near a forbidden posture; here (K,): which of the objective's hold at this place."""
    total = 0.0
    if np.any(here):
        feature = posture_features(objective.wrist_zero, q)
        for b in range(here.shape[0]):
            square = 0.0
            for i in range(7):
                square += (feature[i] - objective.blocked[b, i]) ** 2
            if here[b] and square < BLOCKED_REACH * BLOCKED_REACH:
                near = 1.0 - np.sqrt(square) / BLOCKED_REACH
                total += BLOCKED_PRICE * near * near
    return total


@part
def error_price(objective: Objective, u: Array, q: Array, push: Array) -> float:
    """Price of a metre cut for the part's error in a posture u (F,), q (6,) under a push (PUSH,)."""
    if push[SHARE] == 0.0:
        return 0.0
    weight = objective.errors.weight * push[SHARE]
    return float(weight * expected_square(objective.errors, u, q, push, np.empty(6)))


@kernel(nogil=True)
def _posture_prices(
    space: PlanSpace, objective: Objective, u: Array, q: Array, weight: Array, push: Array, work: PlanWork
) -> Array:
    """Prices (3,) of postures u (W, F), q (W, 6): conditioning, margins, the part's error; see `plan_prices`."""
    out = np.zeros(3)
    for k in range(u.shape[0]):
        a, b = posture_price(space, objective, u[k], q[k], conditioning(space, q[k], work))
        out[0] += weight[k] * a
        out[1] += weight[k] * b
        if objective.errors.weight > 0.0:
            out[2] += weight[k] * error_price(objective, u[k], q[k], push[k])
    return out


class Moves(NamedTuple):
    """The moves to waypoints: ds (W,) m, dt (W,) s; share (W,): 1 of a cut, AIR_SHARE in air; cuts_on (W,): 1 where a cut that
    counts for the part's error goes on over the waypoint before.
    """

    ds: Array
    dt: Array
    share: Array
    cuts_on: Array


class MotionPrice(NamedTuple):
    """Price of the move to each waypoint, by how far d the coordinates go in it (the F freedoms, then the arm's axes):

        sum rate |d| + square d^2 + haste (|d| / top - 1)+^2

    rate, square, top (W, F + 6); haste (W,). What is searched, refined and reported is priced by it alone.
    """

    rate: Array
    square: Array
    top: Array
    haste: Array

    def paid(self, u: Array, q: Array, joined: NDArray[np.bool_]) -> float:
        """For postures u (W, F), q (W, 6), in m; joined (W,): False where the posture may jump before the waypoint."""
        d = np.abs(np.diff(np.hstack([u, q]), axis=0))[joined[1:]]
        rate, square, top = (x[1:][joined[1:]] for x in (self.rate, self.square, self.top))
        over = np.maximum(d / top - 1.0, 0.0)
        return float(np.sum(rate * d + square * d * d) + np.sum(over * over * self.haste[1:][joined[1:], None]))


def _travel(objective: Objective, moves: Moves, price: MotionPrice) -> None:
    price.rate[:, : len(objective.travel)] += moves.share[:, None] * objective.travel


def _smoothness(objective: Objective, moves: Moves, price: MotionPrice) -> None:
    price.square[:, : len(objective.travel)] += objective.u_smooth / moves.ds[:, None]


def _speed(objective: Objective, moves: Moves, price: MotionPrice) -> None:
    price.top[:, : len(objective.travel)] = objective.u_speed * moves.dt[:, None]
    price.haste[:] = objective.speed * moves.ds


def _arm_steps(objective: Objective, moves: Moves, price: MotionPrice) -> None:
    price.square[:, len(objective.travel) :] += objective.arm_step / moves.ds[:, None]


def _turned_back(objective: Objective, moves: Moves, price: MotionPrice) -> None:
    price.rate[:, len(objective.travel) :] += moves.cuts_on[:, None] * objective.errors.turning


MOTION_TERMS: Mapping[str, Callable[[Objective, Moves, MotionPrice], None]] = MappingProxyType(
    {
        "travel": _travel,
        "smoothness": _smoothness,
        "speed": _speed,
        "arm_steps": _arm_steps,
        "turned_back": _turned_back,
    }
)
"""What motion costs: each adds its own to a price. One of them may price haste, which has one top for each coordinate."""
POSTURE_TERMS = ("conditioning", "margins", "part_error")
_OF_ERRORS = ("part_error", "turned_back")  # reported where a plan looks at the part's error


def motion_price(objective: Objective, moves: Moves, *names: str) -> MotionPrice:
    """The price of moves by the terms named, or by all of them."""
    shape = (len(moves.ds), len(objective.travel) + len(objective.margin))
    price = MotionPrice(np.zeros(shape), np.zeros(shape), np.full(shape, np.inf), np.zeros(len(moves.ds)))
    for name in names or MOTION_TERMS:
        MOTION_TERMS[name](objective, moves, price)
    return price


def plan_prices(
    space: PlanSpace,
    objective: Objective,
    u: Array,
    q: Array,
    weight: Array,
    push: Array,
    moves: Moves,
    joined: NDArray[np.bool_],
) -> dict[str, float]:
    """The objective's terms, m, of postures u (W, F), q (W, 6), re-postures apart.

    weight (W,): m that each waypoint stands for; push (W, PUSH), read where the objective looks at the part's error; moves:
    to the waypoints; joined (W,): False where the posture may jump before the waypoint.
    """
    own = _posture_prices(space, objective, u, np.ascontiguousarray(q), weight, push, plan_work())
    terms = dict(zip(POSTURE_TERMS, own.tolist(), strict=True))
    terms |= {name: motion_price(objective, moves, name).paid(u, q, joined) for name in MOTION_TERMS}
    return {n: v for n, v in terms.items() if objective.errors.weight > 0.0 or n not in _OF_ERRORS}
