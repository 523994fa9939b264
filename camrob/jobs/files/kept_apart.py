"""External axes kept to where the bodies that they move without the arm touch nothing: carriage, table, part, floor.

No posture of the arm mends such a touch, so that no method is to look for its postures there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Joint, Role
from camrob.checks.collisions import check_collisions
from camrob.errors import JobError
from camrob.findings import Finding, Severity
from camrob.jobs.files.inputs import JobInputs

__all__ = ["Kept", "kept_apart"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_NODES = 4000  # values of the external axes, together, at most
_FINE = 41  # of one of them


class Kept(NamedTuple):
    """The cell with narrower ranges, and what is said of it: "" where they are the cell's own."""

    cell: Cell
    text: str

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What a solution within them has to say."""
        return (Finding("kept-apart", self.text, Severity.INFO),) if self.text else ()

    def named(self, error: JobError) -> JobError:
        """The same error, met within them, with what they are kept to."""
        return error.but(f"{error.what}; {self.text}") if self.text else error


def kept_apart(inputs: JobInputs) -> Kept:
    """The job's cell with its external axes kept to a box about HOME in which what they alone move touches nothing.

    Looked at on a grid of their values, and on the ways between its nodes. Where no such box is found, as where a table without
    limits takes part in it, the cell is as it was.
    """
    cell = inputs.cell
    moving = [i for i, joint in enumerate(cell.joints) if joint.role in (Role.WORKPIECE, Role.CARRIAGE)]
    frames = ("world", "base", "root", *(cell.joints[i].name for i in moving))
    shapes = tuple(shape for shape in cell.shapes if shape.frame in frames)
    if not any(not cell.joints[i].endless for i in moving) or not shapes:
        return Kept(cell, "")
    values = _values(cell, moving)
    hit, pair = _touched(inputs, replace(cell, shapes=shapes), moving, values)
    if not hit.any():
        return Kept(cell, "")
    home = tuple(int(np.argmin(np.abs(v - cell.q_home[i]))) for i, v in zip(moving, values, strict=True))
    box = _free_box(hit, home, [cell.joints[i].endless for i in moving])
    if box is None:
        return Kept(cell, "")
    joints, said = list(cell.joints), []
    for (low, high), i, v in zip(box, moving, values, strict=True):
        if (low, high) != (0, len(v) - 1):
            joints[i] = _narrowed(cell.joints[i], v[low], v[high], float(cell.q_home[i]))
            said.append(_range(joints[i]))
    text = f"{' and '.join(said)}: {pair[0]} would touch {pair[1]} outside, wherever the arm stands"
    return Kept(replace(cell, joints=tuple(joints)), text)


def _values(cell: Cell, moving: Sequence[int]) -> list[Array]:
    """Values of q of each external axis, ends included, HOME's among them."""
    each = int(min(_FINE, max(3.0, np.floor(_NODES ** (1.0 / len(moving))))))
    out = []
    for i in moving:
        joint, home = cell.joints[i], cell.q_home[i]
        low, high = (home - np.pi, home + np.pi) if joint.endless else (joint.q_lower, joint.q_upper)
        out.append(np.unique(np.append(np.linspace(low, high, each), home)))
    return out


def _touched(inputs: JobInputs, cell: Cell, moving: Sequence[int], values: list[Array]) -> tuple[Mask, tuple[str, str]]:
    """Which nodes touch something or lie at an end of a step that does, and the two bodies that do so first."""
    size = tuple(len(v) for v in values)
    nodes = _snake(size)
    q = np.tile(cell.q_home, (len(nodes), 1))
    for column, i in enumerate(moving):
        q[:, i] = values[column][nodes[:, column]]
    report = check_collisions(cell, q, **inputs.bodies)
    hit = np.zeros(size, np.bool_)
    at = np.array(report.hit)
    at[:-1] |= at[1:]
    hit[tuple(nodes[at].T)] = True
    met = [found for found in report.pairs if found.count]
    return hit, (met[0].pair if met else ("", ""))


def _snake(size: tuple[int, ...]) -> NDArray[np.int64]:
    """All nodes (M, k) of a grid in an order in which each differs from the one before it by one step of one axis."""
    nodes = np.zeros((1, 0), np.int64)
    for count in reversed(size):
        parts = []
        for k in range(count):
            rest = nodes if k % 2 == 0 else nodes[::-1]
            parts.append(np.concatenate([np.full((len(rest), 1), k), rest], axis=1))
        nodes = np.concatenate(parts)
    return nodes


def _free_box(hit: Mask, home: tuple[int, ...], endless: Sequence[bool]) -> list[tuple[int, int]] | None:
    """Ends of a box about HOME's node without a touch: side by side, what costs the fewest free nodes goes first."""
    box = [(0, n - 1) for n in hit.shape]
    while True:
        inside = hit[tuple(slice(low, high + 1) for low, high in box)]
        if not inside.any():
            return box
        best: tuple[float, int, tuple[int, int]] | None = None
        for axis, (low, high) in enumerate(box):
            layers = inside.sum(axis=tuple(k for k in range(inside.ndim) if k != axis))
            nodes = inside.size // len(layers)
            for end, cut in ((low, (low + 1, high)), (high, (low, high - 1))):
                if endless[axis] or not cut[0] <= home[axis] <= cut[1]:
                    continue
                layer = int(layers[end - low])
                lost = (nodes - layer) / nodes if layer else np.inf
                if best is None or lost < best[0]:
                    best = (lost, axis, cut)
        if best is None:
            return None
        box[best[1]] = best[2]


def _narrowed(joint: Joint, low: float, high: float, home: float) -> Joint:
    """The joint between two of its values of q, a HOME at their edge among them."""
    ends = np.sort(joint.axis_value(np.array([min(low, home), max(high, home)])))
    return replace(joint, lower=max(float(ends[0]), joint.lower), upper=min(float(ends[1]), joint.upper))


def _range(joint: Joint) -> str:
    low, high = joint.to_edge(joint.lower), joint.to_edge(joint.upper)
    return f"{joint.name} is kept to {low:.0f} to {high:.0f} {joint.unit_word}"
