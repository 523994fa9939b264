"""A path that can't be followed where the part is: by how much the part would have to be moved."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.table_plate import table_plate
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.errors import (
    CellError,
    CollisionError,
    JobError,
    LimitError,
    SetupError,
    SingularError,
    UnreachableError,
    VerificationError,
)
from camrob.jobs.files.inputs import JobInputs
from camrob.jobs.files.mounting import one_frame
from camrob.jobs.solving.place_trial import TRIAL_POINTS, off_table, try_placement
from camrob.jobs.solving.thinned import thinned
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_tool
from camrob.product_grid import product_grid
from camrob.redundancy.following.nearest_miss import IN_REACH
from camrob.redundancy.planned import resolve_planned
from camrob.redundancy.planning.placement import place_part
from camrob.redundancy.published.beginnings import resolve_begun_elsewhere, resolve_published
from camrob.redundancy.solution import Solution
from camrob.se3 import mm_deg_from_frame
from camrob.units import m_to_mm

__all__ = ["with_a_place"]

Array = NDArray[np.float64]
Way = Callable[..., Solution]

# m that the part is moved by along each axis: what clamping and a table leave
_FAR = (0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8)
_PLANS = 2  # of the likely ones for which a plan is made where the published method follows none: some seconds each
# of processor that shifts are looked at, and tried: some arms take a second each where nothing is in reach
_SECONDS = 20.0
_NEAREST, _LIKELY = 2, 6  # placements on which the path is followed: half a second each on a thinned path
_NEARER = 0.5  # of 1/k_F, lowest and mean summed, that a likely one is worse for each metre that it is nearer
_APART = 0.15  # m between two likely ones
_BELOW = np.array([0.0, 0.1, 0.2])  # m that the path's middle comes to lie below the tip at HOME
_ROUND = 0.01  # m


def with_a_place(error: JobError, inputs: JobInputs, *, planned: bool = False) -> JobError:
    """The same error with the plan that gets there where the part is, or with the nearest shift of the part, followed on trial
    without touching anything, or that none is; of a program that was judged unfit with what may lie beneath.

    planned: it was met in a plan, so that to plan is no advice.
    """
    if isinstance(error, VerificationError):
        doubt = _upside_down(inputs)
        return error.but(f"{error.what}; {doubt}") if doubt else error
    if not isinstance(error, CollisionError | UnreachableError | LimitError | SingularError):
        return error
    lost = isinstance(error, UnreachableError) and not error.reasons.get(IN_REACH)
    doubt = "; ".join(filter(None, (_units(inputs), _upside_down(inputs))))
    plan, serves = ("", False) if planned or lost or doubt else _plan_here(inputs)
    return error.but("; ".join(filter(None, [error.what, doubt, plan, "" if serves or doubt else _advice(inputs)])))


def _plannable(cell: Cell) -> list[str]:
    """The freedoms that a plan chooses, by name; none where the arm has no closed form."""
    names = [joint.name for joint in cell.joints if joint.role is not Role.ARM]
    return [] if Arm.of(cell).searched else names


def _plan_here(inputs: JobInputs) -> tuple[str, bool]:
    """What became of a plan where the part is, made on trial after the published method found no way, and whether it serves."""
    names = _plannable(inputs.cell)
    if not names:
        return "", False
    path = thinned(inputs.path, TRIAL_POINTS)
    made = try_placement(inputs, path, np.asarray(inputs.setup.base_T_part), resolve_planned, clear=True)
    tried = f"which chooses {', '.join(names)} over the whole path"
    if isinstance(made, str) or made[0].method != "planned":
        return f"nor does --method planned, {tried}, find a way where the part is", False
    on = f"(tried on {len(path)} of its points)"
    if made[1].count:
        what = made[1].findings[0].text
        return f"--method planned, {tried}, follows it where the part is {on}, but on trial {what}", False
    return f"--method planned, {tried}, follows it where the part is and touches nothing {on}", True


def _units(inputs: JobInputs) -> str:
    """The doubt about units: the path is wider than parts are that somebody draws in inches, or its place is in metres."""
    return "; ".join(f.text for f in inputs.urgent if f.code in ("path-in-inches", "part-in-metres"))


def _upside_down(inputs: JobInputs) -> str:
    """A doubt about how the part lies, or about the sense of the tool axes, where all of them point down."""
    up = np.asarray(inputs.setup.base_T_part)[2, :3]
    axes = np.concatenate([np.asarray(region.axis) @ up for region in inputs.toolpath.regions])
    if not len(axes) or axes.max() >= 0.0:
        return ""
    return (
        "all tool axes point down as the part lies: turn it over (part_in_base with 180 as its last number), "
        "or they are reversed in the file, where i, j, k point from the tip to the spindle"
    )


def _advice(inputs: JobInputs) -> str:
    shifts, begun = _shifts(inputs), time.process_time()
    farthest = f"by up to {m_to_mm(max(_FAR)):.0f} mm"
    try:
        one_frame(inputs.mounted, inputs.setup, "a placement is looked for with one")
        found = place_part(inputs.cell, inputs.path, np.asarray(inputs.setup.base_T_part), shifts, seconds=_SECONDS)
    except UnreachableError:
        if time.process_time() - begun > _SECONDS:
            return f"the nearest shifts of the part, looked at for {_SECONDS:.0f} s, bring not the whole path in reach"
        return f"no shift of the part {farthest} along the axes of base, nor to the tool's HOME, brings the whole path in reach"
    except (CellError, SetupError):
        return ""  # no closed form, or frames that one shift does not suit
    verdicts = off_table(inputs, table_plate(inputs.cell), np.asarray(found.base_T_part))
    path = thinned(inputs.path, TRIAL_POINTS)
    whole, shifts = len(shifts), shifts[: len(found.mean) - 1]
    if len(shifts) < whole:
        farthest = f"among the {len(shifts)} nearest"
    good = [k + 1 for k in range(len(shifts)) if found.value[k + 1] > 0.0 and not verdicts[k + 1]]
    likely = _likely(good, shifts, np.asarray(found.value))
    if not inputs.cell.shapes:  # nothing keeps the part out of the robot: where the tool is at HOME it has room
        likely = sorted(good, key=lambda k: float(np.linalg.norm(shifts[k - 1] - _to_home(inputs))))[:_LIKELY]
    first = dict.fromkeys([*(good[:_NEAREST] if inputs.cell.shapes else ()), *likely])
    trials: list[tuple[int, Way]] = [(k, way) for k in first for way in (resolve_published, resolve_begun_elsewhere)]
    if _plannable(inputs.cell):
        trials += [(k, resolve_planned) for k in dict.fromkeys([*list(first)[:1], *likely[:_PLANS]])]
    begun, met = time.process_time(), Counter[str]()
    for k, resolve in trials:
        if time.process_time() > begun + _SECONDS:
            break
        place = np.asarray(found.base_T_part[k])
        made = try_placement(inputs, path, place, resolve, clear=resolve is not resolve_published)
        if not isinstance(made, str) and not made[1].count:
            by = " by --method planned" if resolve is resolve_planned else ""
            bare = "" if made[1].checked else ", the robot's body is not drawn"
            return (
                f"with the part moved by {_mm(shifts[k - 1])} mm it can be followed{by} and touches nothing (tried on "
                f"{len(path)} of its points{bare}): part_in_base = {_printed(place)}"
            )
        if resolve is not resolve_begun_elsewhere:
            met[made if isinstance(made, str) else made[1].findings[0].text] += 1
    if met:
        why, times = met.most_common(1)[0]
        return (
            f"with the part moved by {_mm(shifts[good[0] - 1])} mm every pose is in reach, but there and elsewhere the path "
            f"could not be followed clear of everything in {met.total()} trials (in {times} {why}): `camrob place` tries more"
        )
    return f"no shift of the part {farthest} keeps it on the table and the whole path in reach"


def _likely(good: list[int], shifts: Array, value: Array) -> list[int]:
    """Those of the placements in reach that have the best postures, near ones first where it is all the same, apart from each
    other.
    """
    chosen: list[int] = []
    for k in sorted(good, key=lambda k: float(_NEARER * np.linalg.norm(shifts[k - 1]) - value[k])):
        if all(np.linalg.norm(shifts[k - 1] - shifts[j - 1]) >= _APART for j in chosen):
            chosen.append(k)
        if len(chosen) == _LIKELY:
            break
    return chosen


def _shifts(inputs: JobInputs) -> Array:
    """(S, 3) m, the nearest first, and of equally near ones those along fewer axes; those that bring the path's middle before the
    tool as it is at HOME among them, where the arm has room.
    """
    ways = product_grid([np.array([-1.0, 0.0, 1.0])] * 3)
    grid = [far * ways[np.any(ways != 0.0, axis=1)] for far in _FAR]
    way = _to_home(inputs)
    before = np.round(way / _ROUND + np.outer(_BELOW / _ROUND, [0.0, 0.0, -1.0])) * _ROUND
    level = before[:1] * [1.0, 1.0, 0.0]
    shifts = np.concatenate([*grid, before, level])
    shifts = shifts[np.any(shifts != 0.0, axis=1)]
    return np.asarray(shifts[np.argsort(np.linalg.norm(shifts, axis=1), kind="stable")])


def _to_home(inputs: JobInputs) -> Array:
    """(3,) m from the middle of the cuts to the tip at HOME."""
    tips = np.asarray(inputs.path.base_T_tip)[:, :3, 3]
    cut = tips[inputs.path.cutting] if inputs.path.cutting.any() else tips
    home = base_T_tool(inputs.cell, np.asarray(inputs.cell.q_home))[:3, 3]
    return np.asarray(home - 0.5 * (cut.min(axis=0) + cut.max(axis=0)))


def _mm(shift: Array) -> str:
    return ", ".join(f"{axis} {m_to_mm(float(v)):+.0f}" for axis, v in zip("XYZ", shift, strict=True) if v)


def _printed(base_T_part: Array) -> str:
    return "[" + ", ".join(f"{v + 0.0:.6g}" for v in np.round(mm_deg_from_frame(base_T_part), 4)) + "]"
