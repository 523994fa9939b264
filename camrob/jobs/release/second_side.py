"""A part that its file works from two sides on a set-up that has one: what to write into the set-up."""

from __future__ import annotations

from itertools import groupby

import numpy as np

from camrob.errors import JobError
from camrob.jobs.files.inputs import JobInputs
from camrob.toolpath.region import Region

__all__ = ["asking_for_clampings", "from_two_sides"]

_MOST = 4  # clampings that are written out


def asking_for_clampings(error: JobError, inputs: JobInputs) -> JobError:
    """The error with the clampings to write into the set-up, where some operations come from below the part and others don't:
    no machine that does one side reaches the other, and the part is turned over for it.
    """
    if not from_two_sides(inputs):
        return error
    sides = _sides(inputs)
    first, beginning = 1, []
    for k, (below, regions) in enumerate(sides[:_MOST]):
        last = int(sides[k + 1][1][0].first_line) - 1 if k + 1 < len(sides) else max(int(r.line.max()) for r in regions)
        place = "[X, Y, Z, A, B, C of the part turned over]" if below else "[X, Y, Z, A, B, C]"
        beginning.append(f'{{name = "side{k + 1}", lines = [{first}, {last}], part_in_base = {place}}}')
        first = last + 1
    more = ", ..." if len(sides) > _MOST else ""
    turned = next(regions[0] for below, regions in sides if below)
    text = (
        f"{turned.operation or turned.name} (line {turned.first_line}) comes from below the part and others don't: where the "
        f"part is turned over for it, give the set-up, instead of part_in_base, clamping = [{', '.join(beginning)}{more}]"
    )
    fault = error.what.partition("; ")[0]  # what follows advises for a part that is worked as it lies
    return error.but(f"{fault}; {text}")


def from_two_sides(inputs: JobInputs) -> bool:
    """Whether the file works the part from two sides, and the set-up doesn't say that it is turned over."""
    return not inputs.setup.clampings and len(_sides(inputs)) > 1


def _sides(inputs: JobInputs) -> list[tuple[bool, list[Region]]]:
    """Operations in their order, those from one side together, and whether that is from below."""
    worked = [region for region in inputs.toolpath.regions if len(region)]
    return [(below, list(regions)) for below, regions in groupby(worked, key=_from_below)]


def _from_below(region: Region) -> bool:
    """Whether the tool points up at the part all along."""
    return bool(np.asarray(region.axis)[:, 2].max() < 0.0)
