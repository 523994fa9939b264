"""A job's path, resolved: postures along it, held to its promise by forward kinematics."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.checks.rooms import job_room
from camrob.errors import InputError, JobError, VerificationError
from camrob.jobs.files.inputs import JobInputs
from camrob.jobs.files.kept_apart import kept_apart
from camrob.jobs.release.release import named_region
from camrob.jobs.solving.device import batch_score
from camrob.jobs.solving.plan_obstacles import free_routes, job_leads, job_obstacles
from camrob.jobs.solving.sought import Sought
from camrob.progress import Share
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.published.beginnings import resolve_begun_elsewhere, resolve_published
from camrob.redundancy.solution import Solution
from camrob.redundancy.stretches import Stretch, joined_solutions
from camrob.units import m_to_mm

if TYPE_CHECKING:  # few jobs are planned under a force
    from camrob.prediction.force_model import CuttingForces

__all__ = ["BEGUN", "ELSEWHERE", "METHODS", "PUBLISHED", "Residual", "ResolvedJob", "check_method", "resolve_job"]

Array = NDArray[np.float64]
Residual = tuple[Array, Array]

TRACKING_TOLERANCE = 1e-9  # m and rad: the solver's promise before rounding, 1e-6 mm and 1e-6 rad


def _planned(cell: Cell, path: ToolPathInBase, **options: Any) -> Solution:
    """`resolve_planned`, loaded where something is planned."""
    from camrob.redundancy.planned import resolve_planned

    return resolve_planned(cell, path, **options)


BEGUN = PUBLISHED, ELSEWHERE = "published", "begun elsewhere"
"""Ways that begin without a plan; the second one is for paths on which the first one touches something."""
METHODS: Mapping[str, Mapping[str, Callable[..., Solution]]] = {
    "vjm": {PUBLISHED: resolve_published, ELSEWHERE: resolve_begun_elsewhere},
    "planned": {
        "knee": partial(_planned, mode="knee"),
        "still": partial(_planned, mode="still"),
        "flowing": partial(_planned, mode="flowing"),
        PUBLISHED: resolve_published,
        ELSEWHERE: resolve_begun_elsewhere,
    },
}
"""The ways of each method, tried in turn until one keeps free of collisions."""


@dataclass(frozen=True, slots=True)
class ResolvedJob:
    """A solution, what it leaves of the poses (m, rad), and the inputs with the path that it belongs to."""

    inputs: JobInputs
    solution: Solution
    residual: Residual


def check_method(method: str) -> None:
    """Raise InputError for a method that there isn't."""
    if method not in METHODS:
        raise InputError(f"--method {method!r} is unknown", hint=f"use {' or '.join(METHODS)}")


def resolve_job(
    inputs: JobInputs,
    method: str,
    way: str,
    progress: Share,
    device: str = "cpu",
    sought: Sought | None = None,
    seconds: float | None = None,
    further: Mapping[str, float] | None = None,
) -> ResolvedJob:
    """A solution by one of METHODS' ways, held to its promise by forward kinematics; the stretches between tool changes one
    after the other.

    sought: what a plan for accuracy goes by; seconds: how long plans are bettered, shared out by points; further: by joint, what
    the published method keeps from its limits. Raises JobError and its kin, VerificationError where the promise is broken.
    """
    resolve = METHODS[method][way]
    made: list[Stretch] = []
    residuals: list[Residual] = []
    last: Array | None = None
    total = len(inputs.path)
    forces = _forces(inputs, sought)
    for k, where in enumerate(inputs.path.stretches):
        here = inputs.of_stretch(k, last)

        def share(done: float, begin: int = where.start, size: int = where.stop - where.start) -> None:
            progress((begin + done * size) / total)

        kept = kept_apart(here)
        try:
            own = None if seconds is None else seconds * (where.stop - where.start) / total
            found = _solved(replace(here, cell=kept.cell), resolve, share, device, sought, forces, own, further)
        except JobError as e:
            if resolve is resolve_begun_elsewhere:  # what stands against the first way is what is said
                raise
            raise named_region(kept.named(e), inputs) from None
        solution = replace(found, cell_digest=here.cell.digest, findings=(*found.findings, *kept.findings))
        path = here.path if solution.path is None else solution.path
        solution = free_routes(here, path, solution)
        position, axis = solution.residual(here.cell, path)
        if max(position.max(initial=0.0), axis.max(initial=0.0)) > TRACKING_TOLERANCE:
            off = m_to_mm(float(position.max()))
            raise VerificationError(f"the solver deviates by {off:.2e} mm; please report this file")
        made.append(Stretch(path, solution))
        residuals.append((position, axis))
        last = here.cell.to_axis_values(np.asarray(solution.q[-1]))
    path, solution = joined_solutions(inputs.cell, made)
    position, axis = (np.concatenate(column) for column in zip(*residuals, strict=True))
    return ResolvedJob(replace(inputs, path=path), solution, (position, axis))


def _forces(inputs: JobInputs, sought: Sought | None) -> CuttingForces | None:
    """What pushes on the job's tools. Raises InputError where that is said of one of several, or not of all."""
    if sought is None or sought.force is None:
        return None
    from camrob.prediction.read_force import read_forces

    forces = read_forces(sought.force)
    forces.on(list(dict.fromkeys(held.tool.number for held in inputs.mounted)), inputs.toolpath.source)
    return forces


def _solved(
    inputs: JobInputs,
    resolve: Callable[..., Solution],
    progress: Share,
    device: str,
    sought: Sought | None,
    forces: CuttingForces | None,
    seconds: float | None,
    further: Mapping[str, float] | None,
) -> Solution:
    """The solution of one stretch."""
    if resolve is resolve_published:
        return resolve_published(inputs.cell, inputs.path, further=further, progress=progress)
    from camrob.jobs.solving.plan_run import job_run

    score = batch_score(inputs.cell, device)
    errors = None
    if sought is not None:
        from camrob.jobs.solving.machine_errors import (
            machine_errors,  # reads calibrations and diagnoses: few ask for it
        )
        from camrob.jobs.solving.surface_of_path import surface_of_path

        force = None if forces is None else forces.on([inputs.tool.number], inputs.toolpath.source)[0]
        errors = machine_errors(sought, inputs.cell, surface_of_path(inputs), force)
    return resolve(
        inputs.cell,
        inputs.path,
        obstacles=job_obstacles(inputs),
        room=job_room(inputs.cell, **inputs.bodies, tool=inputs.tool),
        leads=job_leads(inputs),
        score=score,
        errors=errors,
        run=job_run(inputs.cell, inputs.rapid_speed),
        seconds=seconds,
        progress=progress,
    )
