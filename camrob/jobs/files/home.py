"""HOME, where every program begins and ends: what touches there, before anything is solved."""

from __future__ import annotations

from typing import Any

from camrob.bodies.bodies import JOB_GROUPS
from camrob.cell.cell import Cell
from camrob.checks.collisions import check_collisions
from camrob.errors import CollisionError
from camrob.jobs.files.inputs import JobInputs

__all__ = ["demand_free_home", "touches_at_home"]


def touches_at_home(cell: Cell) -> tuple[str, ...]:
    """What of a cell touches at its HOME, a sentence for each two groups of bodies: no place of a part can help then."""
    return tuple(f"{touch}: {cure}" for touch, cure in _touches(cell))


def demand_free_home(inputs: JobInputs) -> None:
    """Raise CollisionError where the cell with one of the job's tools, the part and the stock touches something at HOME."""
    for held in inputs.mounted:
        for touch, cure in _touches(held.cell, **inputs.bodies, tool=held.tool):
            raise CollisionError(f"the program was not released: {touch}; {cure}")


def _touches(cell: Cell, **job: Any) -> list[tuple[str, str]]:
    """What touches and what to do, for the first pair of bodies of each two groups; job: as `check_collisions` takes it."""
    if not cell.shapes:
        return []
    report = check_collisions(cell, cell.q_home[None], **job)
    first: dict[tuple[str, str], tuple[str, str]] = {}
    for found in report.pairs:
        if found.count:
            first.setdefault(found.groups, found.pair)
    own, jobs = (
        "change home_deg, or what is drawn of one of them",
        "place the part elsewhere (camrob place), or change home_deg",
    )
    return [
        (f"at HOME {one} touches {other}", jobs if set(groups) & set(JOB_GROUPS) else own)
        for groups, (one, other) in first.items()
    ]
