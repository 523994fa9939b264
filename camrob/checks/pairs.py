"""Which bodies are followed against which, where along the path, and which pairs are left out for what reason."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.bodies import JOB_GROUPS, TOOL_GROUP, Body, slimmer
from camrob.checks.air import AirRuns

__all__ = ["Pair", "plan_pairs"]

PART, STOCK = JOB_GROUPS


@dataclass(frozen=True, slots=True)
class Pair:
    """Bodies (indices) that may not touch: `far` rides at least as far out on the chain as `near`.

    active: (K,) where the motion into a point of the dense path counts. in_clearance: whether the room between them
    says anything (that of tool and part ends at every cut).
    """

    far: int
    near: int
    active: NDArray[np.bool_]
    in_clearance: bool = True


def plan_pairs(
    bodies: tuple[Body, ...], air: AirRuns, touch: float
) -> tuple[tuple[Body, ...], tuple[Pair, ...], tuple[str, ...]]:
    """The bodies, with slimmer tools for contacts allowed up to `touch` (m), the pairs, and what is left out."""
    every = np.ones(len(air.q), bool)
    more = list(bodies)
    pairs: list[Pair] = []
    skipped: dict[str, None] = {}
    for i, one in enumerate(bodies):
        for j in range(i):
            other = bodies[j]
            far, near = (i, j) if one.link >= other.link else (j, i)
            groups = {one.group, other.group}
            if len(groups) == 1:
                continue
            if TOOL_GROUP in groups and PART in groups:
                tool = far if bodies[far].group == TOOL_GROUP else near
                for active, rounded in ((air.free, False), (air.near, True)):
                    if active.any():
                        more.append(slimmer(bodies[tool], touch, rounded=rounded))
                        swap = len(more) - 1
                        pairs.append(Pair(swap, near, active, False) if tool == far else Pair(far, swap, active, False))
                continue
            reason = _reason(one, other)
            if reason:
                skipped[f"{other.group} and {one.group}: {reason}"] = None
            else:
                pairs.append(Pair(far, near, every))
    return tuple(more), tuple(pairs), tuple(skipped)


def _reason(one: Body, other: Body) -> str:
    """Why two bodies of different groups needn't be followed; "" where they must."""
    if {one.group, other.group} == {TOOL_GROUP, STOCK}:
        return "the tool cuts the stock"
    if other.group in one.ignore or one.group in other.ignore:
        return "the cell lets them touch"
    if one.link == other.link:
        return "they don't move against each other"
    return ""
