"""A path that can't be followed where the part is: by how much the part would have to be moved."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.table_plate import table_plate
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.checks.collision_report import CollisionReport
from camrob.errors import (
    CellError,
    CollisionError,
    JobError,
    LimitError,
    SingularError,
    UnreachableError,
    VerificationError,
)
from camrob.jobs.files.inputs import JobInputs
from camrob.jobs.solving.place_trial import TRIAL_POINTS, off_table, try_placement
from camrob.jobs.solving.thinned import thinned
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_tool
from camrob.product_grid import product_grid
from camrob.progress import Share
from camrob.redundancy.following.nearest_miss import IN_REACH
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planned import resolve_planned
from camrob.redundancy.planning.freedoms import plan_space
from camrob.redundancy.planning.placement import place_stretches
from camrob.redundancy.published.beginnings import resolve_begun_elsewhere, resolve_published
from camrob.se3 import mm_deg_from_frame
from camrob.units import m_to_mm

__all__ = ["with_a_place"]

Array = NDArray[np.float64]

# m that the part is moved by along each axis: what clamping and a table leave
_FAR = (0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8)
_SECONDS = 14.0  # of processor for all that is looked at and tried, but for a trial that has begun
_LOOKED = 6.0  # of them at most for which places are in reach: some arms take a second each where nothing is
_POSES = 10  # of the path that have to be in reach of a place that is tried
_PLANS = 2  # of the likely ones for which a plan is made where the published method follows none: some seconds each
_NEAREST, _LIKELY = 3, 6  # placements on which the path is followed: half a second each on a thinned path
_NEARER = 0.5  # of 1/k_F, lowest and mean summed, that a likely one is worse for each metre that it is nearer
_APART, _NEAR_APART = 0.15, 0.08  # m between two likely ones, and between two of the nearest
_BELOW = np.array([0.0, 0.1, 0.2])  # m that the path's middle comes to lie below the tip at HOME
_ROUND = 0.01  # m


def with_a_place(
    error: JobError, inputs: JobInputs, *, planned: bool = False, progress: Share | None = None
) -> JobError:
    """The same error with the plan that gets there where the part is, or with a shift of the part that was followed on trial
    without touching anything, or that none was found; of a program that was judged unfit with what may lie beneath.

    planned: it was met in a plan, so that to plan is no advice. progress: called with the share of its time that is over.
    """
    if isinstance(error, VerificationError):
        doubt = _upside_down(inputs)
        return error.but(f"{error.what}; {doubt}") if doubt else error
    if not isinstance(error, CollisionError | UnreachableError | LimitError | SingularError):
        return error
    doubt = "; ".join(filter(None, (_units(inputs), _upside_down(inputs))))
    if doubt:
        return error.but(f"{error.what}; {doubt}")
    lost = isinstance(error, UnreachableError) and not error.reasons.get(IN_REACH)
    sunk = any(finding.code == "part-in-table" for finding in inputs.urgent)
    search = _Search(inputs, progress)
    said, found = [error.what], ""
    # where something touches, a place beside it is found sooner than a plan; where an axis ends, a plan may do without
    if isinstance(error, CollisionError):
        found = search.at_once(lost=lost)
    if not (found or planned or lost or sunk):
        plan, serves = _plan_here(inputs)
        said.append(plan)
        if serves:
            return error.but("; ".join(said))
    return error.but("; ".join(filter(None, [*said, found or search.at_once(lost=lost) or search.further()])))


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


class _Search:
    """Places for the part, looked for and tried until one serves or the time is over."""

    def __init__(self, inputs: JobInputs, progress: Share | None) -> None:
        self._inputs, self._progress = inputs, progress
        self._begun = time.process_time()
        self._here = np.asarray(inputs.setup.base_T_part)
        self._path = thinned(inputs.path, TRIAL_POINTS)
        self._shifts, self._searched = np.empty((0, 3)), False
        self._tried: dict[bytes, None] = {}
        self._met = Counter[str]()
        try:
            plan_space(inputs.cell)
        except CellError:  # no closed form
            return
        shifts = _shifts(inputs)
        verdicts = off_table(inputs, table_plate(inputs.cell), self._placed(shifts))
        self._shifts, self._searched = shifts[[not verdict for verdict in verdicts]], True

    def at_once(self, *, lost: bool) -> str:
        """The first that serves of the nearest places, and of those before the tool as it is at HOME, without a look at what
        is in reach; lost: the part lies beyond the arm, so that the nearest come last. "" where none does, or all were tried.
        """
        near = self._apart(range(len(self._shifts)), _NEAREST, _NEAR_APART)
        away = np.linalg.norm(self._shifts - _to_home(self._inputs), axis=1)
        home = self._apart(np.argsort(away, kind="stable").tolist(), _NEAREST, _NEAR_APART)
        # nothing keeps the part out of a robot without bodies: where the tool is at HOME it has room
        bare = not self._inputs.cell.shapes
        return self._first(dict.fromkeys([*home, *near] if lost or bare else [*near, *home]))

    def further(self) -> str:
        """The first that serves of all places in reach, the likely ones before others, or that none was found."""
        farthest = f"by up to {m_to_mm(max(_FAR)):.0f} mm"
        axes = "along the axes of base, nor to the tool's HOME,"
        if not len(self._shifts):
            return f"no shift of the part {farthest} {axes} keeps it on the table" if self._searched else ""
        try:
            found = place_stretches(
                self._inputs.by_stretch(),
                self._here,
                self._shifts,
                seconds=min(_LOOKED, self._left()),
                poses=_POSES,
            )
        except UnreachableError:
            if self._left() <= _SECONDS - _LOOKED:
                return "the nearest shifts of the part, as far as there was time to look, bring not the whole path in reach"
            return f"no shift of the part {farthest} {axes} brings the whole path in reach"
        if len(found.mean) - 1 < len(self._shifts):
            farthest = f"among the {len(found.mean) - 1} nearest"
        value = np.asarray(found.value)[1:]
        good = np.flatnonzero(value > 0.0).tolist()
        if not good:
            return f"no shift of the part {farthest} keeps it on the table and the whole path in reach"
        likely = sorted(good, key=lambda k: float(_NEARER * np.linalg.norm(self._shifts[k]) - value[k]))
        likely = self._apart(likely, _LIKELY, _APART)
        served = self._first(dict.fromkeys([*good[:1], *likely])) or (
            self._first(dict.fromkeys([*good[:1], *likely[:_PLANS]]), planned=True)
            if _plannable(self._inputs.cell)
            else ""
        )
        if served or not self._met:
            return served
        why, times = self._met.most_common(1)[0]
        return (
            f"with the part moved by {_mm(self._shifts[good[0]])} mm every pose is in reach, but there and elsewhere the path "
            f"could not be followed clear of everything in {self._met.total()} trials (in {times} {why}): "
            "`camrob place` tries more"
        )

    def _apart(self, order: Iterable[int], most: int, apart: float) -> list[int]:
        """The first `most` shifts, by their index, that lie `apart` m from each other."""
        chosen: list[int] = []
        for k in order:
            if all(np.linalg.norm(self._shifts[k] - self._shifts[j]) >= apart for j in chosen):
                chosen.append(k)
            if len(chosen) == most:
                break
        return chosen

    def _first(self, order: Iterable[int], *, planned: bool = False) -> str:
        """The first shift, by its index, at which the path is followed without touching anything, in words; "" where none is."""
        for k in order:
            mark = self._shifts[k].tobytes() + bytes(planned)
            if mark in self._tried:
                continue
            if self._left() <= 0.0:
                break
            self._tried[mark] = None
            place = self._placed(self._shifts[k : k + 1])[0]
            made = _followed(self._inputs, self._path, place, planned=planned)
            if isinstance(made, str):
                self._met[made] += 1
                continue
            by = " by --method planned" if planned else ""
            bare = "" if made.checked else ", the robot's body is not drawn"
            return (
                f"with the part moved by {_mm(self._shifts[k])} mm it can be followed{by} and touches nothing (tried on "
                f"{len(self._path)} of its points{bare}): part_in_base = {_printed(place)}"
            )
        return ""

    def _placed(self, shifts: Array) -> Array:
        """(S, 4, 4) base_T_part of shifts (S, 3)."""
        placed = np.repeat(self._here[None], len(shifts), axis=0)
        placed[:, :3, 3] += shifts
        return placed

    def _left(self) -> float:
        """Seconds of processor."""
        spent = time.process_time() - self._begun
        if self._progress is not None:
            self._progress(min(spent / _SECONDS, 1.0))
        return _SECONDS - spent


def _followed(inputs: JobInputs, path: ToolPathInBase, base_T_part: Array, *, planned: bool) -> CollisionReport | str:
    """The report of a placement on which the path is followed and touches nothing, or why it isn't: by a plan, or by the
    published method, begun elsewhere where the arm touches something as it comes from HOME.
    """
    made = try_placement(inputs, path, base_T_part, resolve_planned if planned else resolve_published, clear=planned)
    if not isinstance(made, str) and made[1].count and not planned:
        begun = try_placement(inputs, path, base_T_part, resolve_begun_elsewhere, clear=True)
        made = made if isinstance(begun, str) or begun[1].count else begun
    if isinstance(made, str):
        return made
    return made[1].findings[0].text if made[1].count else made[1]


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
