"""Which placements can be proposed: on the table's plate, and free of collisions on trial."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.table_plate import TablePlate
from camrob.checks.collision_report import CollisionReport, joined_collisions
from camrob.errors import CollisionError, JobError, LimitError, SingularError, UnreachableError
from camrob.jobs.files.inputs import JobInputs
from camrob.jobs.solving.plan_obstacles import job_collisions, job_obstacles
from camrob.jobs.solving.thinned import thinned
from camrob.progress import Share
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planning.placement import Placements
from camrob.redundancy.published.beginnings import resolve_published
from camrob.redundancy.solution import Solution
from camrob.redundancy.stretches import Stretch, joined_solutions
from camrob.se3 import inverse

__all__ = [
    "BELOW",
    "FREE",
    "OUT_OF_REACH",
    "OVER_EDGE",
    "TRIAL_POINTS",
    "UNTRIED",
    "Trial",
    "Tried",
    "off_table",
    "try_placement",
    "try_placements",
]

Array = NDArray[np.float64]

OUT_OF_REACH = "a pose is out of reach"
OVER_EDGE = "hangs over the table's edge"
BELOW = "sinks into the table"
UNTRIED = ""
"""Nothing against it so far: it ranks below the proposal and was not tried."""
FREE = "free"
_UNFOLLOWED = {
    UnreachableError: "the follower meets a pose out of reach",
    LimitError: "the follower meets an axis limit",
    SingularError: "the follower meets a singular posture",
}
_TRIALS = 5  # beside the placement as it is: each takes as long as a post
_APART = 0.15  # of the freedom's diagonal that two trials lie apart at least: neighbours differ in little
_SLACK = 0.001  # m that a part may hang over or sink in: a drawing's and a float's rounding
_EDGE = 2e-4  # rad: a posture nearer to a limit is past it when the program's rounded pose is read back
# times an axis's top speed that a motion may ask for: the witness's own, who judges what is posted
_CUT, _IN_AIR = 1.05, 4.0
_STILL = 1e-5  # m of less the rounding of axis values says nothing
TRIAL_POINTS = 2000
"""Of the cutting points, so many are followed on trial."""


@dataclass(frozen=True, slots=True)
class Tried:
    """A placement followed by the published method over a thinned path, and what it touches: nothing."""

    solution: Solution
    collisions: CollisionReport

    @property
    def value(self) -> float:
        """Mean and worst 1/k_F, summed: what placements are ranked by, here of postures that were found."""
        inv_kf = np.asarray(self.solution.inv_kf)
        return float(inv_kf.mean() + inv_kf.min())


@dataclass(frozen=True, slots=True)
class Trial:
    """The proposal among placements, and what stands against each that was refused.

    best: its index. verdicts: for each placement why it was refused, FREE or UNTRIED. tried: how many were resolved and checked
    for collisions. free: the trials of those that touch nothing, by their index, the proposal's among them.
    """

    best: int
    verdicts: tuple[str, ...]
    tried: int
    free: Mapping[int, Tried]

    @property
    def refused(self) -> dict[str, int]:
        """How many placements were refused, by reason, the commonest first."""
        return _tally(self.verdicts)


def off_table(inputs: JobInputs, plate: TablePlate | None, base_T_part: Array) -> tuple[str, ...]:
    """For each placement (P, 4, 4) why it does not lie on the table's plate, or UNTRIED.

    What must lie on it: part and stock, seen from above, or the tips of all cuts where the set-up names neither. Bodies must not
    reach below the plate's top either. Nothing is refused where the cell has no plate.
    """
    if plate is None:
        return (UNTRIED,) * len(base_T_part)
    meshes = [mesh.reshape(-1, 3) for mesh in (inputs.part, inputs.stock) if mesh is not None]
    part_T_base = inverse(np.asarray(inputs.setup.base_T_part))
    cuts = np.asarray(inputs.path.base_T_tip)[inputs.path.cutting, :3, 3]
    points = np.concatenate(meshes) if meshes else cuts @ part_T_base[:3, :3].T + part_T_base[:3, 3]
    out = []
    for placed in base_T_part if len(points) else base_T_part[:0]:
        there = points @ placed[:3, :3].T + placed[:3, 3]
        if plate.beyond(there) > _SLACK:
            out.append(OVER_EDGE)
        else:
            out.append(BELOW if meshes and there[:, 2].min() < plate.top - _SLACK else UNTRIED)
    return tuple(out) or (UNTRIED,) * len(base_T_part)


def try_placements(
    inputs: JobInputs, found: Placements, verdicts: tuple[str, ...], progress: Share | None = None
) -> Trial:
    """Try the placement as it is, and others down the ranking and apart from each other, until `_TRIALS` of them resolve (vjm)
    and touch nothing; the proposal is the best by its trial, so that a part stays where no trial is better. `verdicts` names
    those out already.

    Raises CollisionError, or UnreachableError where none of them collides, with the tally, where no placement is left.
    """
    reasons = [
        OUT_OF_REACH if value <= 0.0 else before for value, before in zip(found.value.tolist(), verdicts, strict=True)
    ]
    path = thinned(inputs.path, TRIAL_POINTS)
    order = [k for k in found.ranking.tolist() if reasons[k] == UNTRIED and k != found.here]
    place = np.asarray(found.base_T_part)[:, :3, 3]
    apart = _APART * float(np.linalg.norm(np.ptp(place, axis=0)))
    free: dict[int, Tried] = {}
    tried, collided = 0, False
    for k in [*([found.here] if reasons[found.here] == UNTRIED else []), *order]:
        others = [place[j] for j in free if j != found.here]
        if any(float(np.linalg.norm(place[k] - there)) < apart for there in others):
            continue
        made = try_placement(inputs, path, np.asarray(found.base_T_part[k]))
        tried += 1
        if isinstance(made, str):
            reasons[k] = made
        elif made[1].count:
            reasons[k], collided = made[1].findings[0].text, True
        else:
            reasons[k], free[k] = FREE, Tried(*made)
        new = len(free) - (found.here in free)
        if progress is not None:
            progress(max(new / _TRIALS, tried / (len(order) + 1)))
        if new == _TRIALS:
            break
    if not free:
        error = CollisionError if collided else UnreachableError
        raise error(
            "no placement within the given freedom can be proposed; give more freedom or another set-up",
            reasons=_tally(reasons),
        )
    return Trial(max(free, key=lambda k: free[k].value), tuple(reasons), tried, free)


def try_placement(
    inputs: JobInputs,
    path: ToolPathInBase,
    base_T_part: Array,
    resolve: Callable[..., Solution] = resolve_published,
    *,
    clear: bool = False,
) -> tuple[Solution, CollisionReport] | str:
    """A placement's solution and what it touches, or why it can't be followed by that method; clear: which is told what to keep
    clear of.
    """
    part_T_tip = inverse(np.asarray(inputs.setup.base_T_part)) @ np.asarray(path.base_T_tip)
    path = replace(path, base_T_tip=base_T_part @ part_T_tip)
    moved = replace(inputs, path=path, setup=replace(inputs.setup, base_T_part=base_T_part))
    made: list[Stretch] = []
    touched: list[CollisionReport] = []
    last: Array | None = None
    for k in range(len(path.stretches)):
        here = moved.of_stretch(k, last)
        solution = _followed(here, resolve, clear=clear)
        if isinstance(solution, str):
            return solution
        way = here.path if solution.path is None else solution.path
        touched.append(job_collisions(here, way, solution))
        made.append(Stretch(way, solution))
        last = here.cell.to_axis_values(np.asarray(solution.q[-1]))
    return joined_solutions(inputs.cell, made)[1], joined_collisions(touched)


def _followed(inputs: JobInputs, resolve: Callable[..., Solution], *, clear: bool) -> Solution | str:
    """The solution of one stretch, or why there is none that a program could be made of."""
    try:
        solution = resolve(inputs.cell, inputs.path, **({"obstacles": job_obstacles(inputs)} if clear else {}))
    except JobError as error:
        return next(
            (text for kind, text in _UNFOLLOWED.items() if isinstance(error, kind)), "the follower can't follow"
        )
    path = inputs.path if solution.path is None else solution.path
    arm = inputs.cell.arm_slice
    q = np.asarray(solution.q)[:, arm]
    if np.minimum(q - inputs.cell.q_lower[arm], inputs.cell.q_upper[arm] - q).min() < _EDGE:
        return "an axis of the arm stands at its limit"
    return _too_fast(inputs, path, np.asarray(solution.q)) or solution


def _too_fast(inputs: JobInputs, path: ToolPathInBase, q: Array) -> str:
    """The axis that would have to run farthest beyond its speed for the tool to keep the file's feed, as a refusal, or ""."""
    cell = inputs.cell
    length = np.linalg.norm(np.diff(np.asarray(path.base_T_tip)[:, :3, 3], axis=0), axis=1)
    led = length > _STILL
    seconds = length[led] / path.commanded_speed(inputs.rapid_speed)[1:][led]
    own = [cell.index(name) for name in cell.axis_names]
    allowed = np.where(path.cutting[1:][led], _CUT, _IN_AIR)[:, None] * cell.limits_of("speed")[own]
    share = np.abs(np.diff(q, axis=0))[led][:, own] / seconds[:, None] / allowed
    if not len(share) or share.max() <= 1.0:
        return ""
    return f"{cell.axis_names[int(np.argmax(share.max(axis=0)))]} would have to run faster than it can"


def _tally(verdicts: list[str] | tuple[str, ...]) -> dict[str, int]:
    reasons = [s for s in verdicts if s not in (FREE, UNTRIED)]
    return dict(sorted(((r, reasons.count(r)) for r in dict.fromkeys(reasons)), key=lambda item: -item[1]))
