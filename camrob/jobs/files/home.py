"""HOME, where every program begins and ends: what touches there, before anything is solved."""

from __future__ import annotations

import json
from typing import Any

from camrob.bodies.bodies import JOB_GROUPS
from camrob.cell.cell import Cell
from camrob.checks.collisions import check_collisions
from camrob.checks.other_home import OtherHome, other_home
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
    touching = [found for found in report.pairs if found.count]
    if not touching:
        return []
    other = other_home(cell, **job)
    first: dict[tuple[str, str], tuple[str, str]] = {}
    for found in sorted(touching, key=lambda found: found.pair not in other.always):
        first.setdefault(found.groups, found.pair)
    return [(f"at HOME {one} touches {two}", _cure(groups, (one, two), other)) for groups, (one, two) in first.items()]


def _cure(groups: tuple[str, str], pair: tuple[str, str], other: OtherHome) -> str:
    """What to do about two bodies that touch at HOME."""
    of_job = bool(set(groups) & set(JOB_GROUPS))
    if pair in other.always:
        cure = "place the part elsewhere (camrob place)"
        if not of_job:
            ignored = f"add {json.dumps(groups[0])} to ignore of {pair[1]!r}"
            cure = f"draw one of them smaller, or, where they are neighbours, let them ({ignored})"
        return f"they touch in all of {other.looked} postures that were looked at: {cure}"
    if of_job:
        cure = "place the part elsewhere (camrob place), or change home_deg"
    else:
        cure = "change home_deg, or what is drawn of one of them"
    if not other.changed:
        return f"{cure}; in none of {other.looked} other postures of the arm that were looked at is it free"
    values = ", ".join(f"{name} {value + 0.0:g}" for name, value in other.changed.items())
    return f"{cure}: with {values} nothing {'else ' if other.always else ''}touches there"
