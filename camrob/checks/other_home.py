"""Another HOME, where something touches at the cell's own: the nearest posture that is free, or which bodies touch in all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.checks.collisions import TOUCH, check_collisions
from camrob.checks.rooms import pair_rooms

__all__ = ["OtherHome", "other_home"]

Array = NDArray[np.float64]

_ROUND = 5.0  # degrees: what is proposed is a multiple of it
_DRAWN = 1500  # postures beside those that differ from HOME in one axis
_STAYS = 0.4  # of the axes of a drawn one, so that little is to be written
_FAR = 180.0  # degrees from HOME that an axis is tried
_FROM_LIMITS = 0.05  # of an axis's range that HOME keeps from its ends
_ROOM = 0.02  # m that each two bodies keep, or half of the most that they ever have
_TRIED = 8  # postures that the check itself looks at, the nearest first


@dataclass(frozen=True, slots=True)
class OtherHome:
    """always: names of each two bodies that touch in all of the `looked` postures. changed: axis values in degrees, by name, with
    which nothing else touches; none where no such posture was found.
    """

    changed: dict[str, float]
    always: tuple[tuple[str, str], ...]
    looked: int


def other_home(cell: Cell, **job: Any) -> OtherHome:
    """The free posture of the arm nearest to HOME by the sum of its axes' ways, external axes as they are; job: meshes, pose and
    tool as `check_collisions` takes them.

    Postures that differ from HOME in one axis by multiples of 5 degrees are looked at, and drawn ones: 0.2 to 2 s.
    """
    home, values = cell.to_axis_values(np.asarray(cell.q_home)), _candidates(cell)
    q = cell.to_q(values, roll=float(cell.q_home[-1]) if cell.indices(Role.ROLL) else 0.0)
    rooms = pair_rooms(cell, q, **job, touch=TOUCH)
    most = rooms.distance.max(axis=1, initial=0.0)
    apart = most > TOUCH
    always = tuple(pair for pair, ever in zip(rooms.names, apart, strict=True) if not ever)
    distance = rooms.distance[apart]
    free = (distance > TOUCH).all(axis=0)
    roomy = free & (distance >= np.minimum(_ROOM, 0.5 * most[apart])[:, None]).all(axis=0)
    for k in [*np.flatnonzero(roomy)[:_TRIED], *np.flatnonzero(free)[:_TRIED]]:
        report = check_collisions(cell, q[k : k + 1], **job)
        if all(found.pair in always for found in report.pairs if found.count):
            moved = {n: float(v) for n, v, own in zip(cell.axis_names, values[k], home, strict=True) if v != own}
            return OtherHome(moved, always, len(q))
    return OtherHome({}, always, len(q))


def _candidates(cell: Cell) -> Array:
    """Axis values (K, axes) of postures of the arm about HOME, in degrees and mm, the nearest first."""
    names, home = cell.axis_names, cell.to_axis_values(np.asarray(cell.q_home))
    arm = np.array([names.index(cell.joints[i].name) for i in cell.indices(Role.ARM) if not cell.joints[i].prismatic])
    ends = np.sort([cell.to_axis_values(np.asarray(limit)) for limit in (cell.q_lower, cell.q_upper)], axis=0)
    lower, upper = np.clip(ends[:, arm], home[arm] - _FAR, home[arm] + _FAR)
    inside = _FROM_LIMITS * (upper - lower)
    lower, upper = np.ceil((lower + inside) / _ROUND) * _ROUND, np.floor((upper - inside) / _ROUND) * _ROUND
    found = []
    for i, low, high in zip(arm, lower, upper, strict=True):
        alone = np.arange(low, high + 0.5 * _ROUND, _ROUND)
        found.append(np.tile(home, (len(alone), 1)))
        found[-1][:, i] = alone
    rng = np.random.default_rng(0)
    drawn, middle = np.tile(home, (_DRAWN, 1)), np.clip(home[arm], lower, upper)
    share = rng.uniform(0.1, 1.0, (_DRAWN, 1))  # of the way to the limits: half of them are near HOME
    some = middle + share * (rng.uniform(lower, upper, (_DRAWN, len(arm))) - middle)
    stays = rng.uniform(size=some.shape) < _STAYS
    drawn[:, arm] = np.where(stays, home[arm], np.round(some / _ROUND) * _ROUND)
    values = np.concatenate([*found, drawn])
    return np.asarray(values[np.argsort(np.abs(values - home).sum(axis=1), kind="stable")])
