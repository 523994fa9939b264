"""What is often wrong in a cell that was written for a log: the convention of its rows, radians or metres in them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Joint, Role, dh_after, dh_before
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["corrected_cells"]

Array = NDArray[np.float64]
_Row = tuple[float, float, float, float]  # alpha, a, theta, d

_CLOSE = 1e-9  # rad and m: rows that are read back so are the ones that were written


def corrected_cells(cell: Cell) -> Iterator[tuple[str, Cell]]:
    """Each mistake in words, and the cell as if it had not been made; none for a chain of no Denavit-Hartenberg rows."""
    arm = [j for j in cell.joints if j.role is Role.ARM]
    standard, modified = ([reads(j) for j in arm] for reads in (_standard, _modified))
    for rows, build, other, name in (
        (standard, _as_standard, _as_modified, "modified"),
        (modified, _as_modified, _as_standard, "standard"),
    ):
        if (known := [r for r in rows if r is not None]) and len(known) == len(arm):
            yield from _mended(cell, arm, known, build, other, name)
            return


def _mended(
    cell: Cell,
    arm: list[Joint],
    rows: list[_Row],
    build: Callable[[Joint, _Row], Joint],
    other: Callable[[Joint, _Row], Joint],
    name: str,
) -> Iterator[tuple[str, Cell]]:
    """Rows read as they stand by `build`: by the `other` convention, in degrees, in mm."""

    def made(each: Callable[[Joint, _Row], Joint], changed: Callable[[_Row], _Row]) -> Cell:
        joints = {j.name: each(j, changed(r)) for j, r in zip(arm, rows, strict=True)}
        return replace(cell, joints=tuple(joints.get(j.name, j) for j in cell.joints))

    yield (
        f'the rows of its cell are of the other convention (convention = "{name}" in [arm])',
        made(other, lambda r: r),
    )
    yield (
        "alpha and theta of its cell's rows are in radians, where degrees are asked for",
        made(build, lambda r: (rad_to_deg(r[0]), r[1], rad_to_deg(r[2]), r[3])),
    )
    longer = made(build, lambda r: (r[0], m_to_mm(r[1]), r[2], m_to_mm(r[3])))
    tool = np.array(cell.flange_T_tool)
    tool[:3, 3] = m_to_mm(tool[:3, 3])
    words = "a and d of its cell's rows are in metres, where mm are asked for"
    yield words, longer
    yield f"{words} (and so is its tool)", longer.with_tool(tool)


def _turned(R: Array) -> float:
    """The angle of a turn about z."""
    return float(np.arctan2(R[1, 0], R[0, 0]))


def _tilted(R: Array) -> float:
    """The angle of a turn about x."""
    return float(np.arctan2(R[2, 1], R[2, 2]))


def _as_standard(joint: Joint, row: _Row) -> Joint:
    alpha, a, theta, d = row
    return replace(joint, before=dh_before(theta=theta, d=d), after=dh_after(a=a, alpha=alpha))


def _as_modified(joint: Joint, row: _Row) -> Joint:
    alpha, a, theta, d = row
    return replace(joint, before=dh_after(a=a, alpha=alpha) @ dh_before(theta=theta, d=d), after=np.eye(4))


def _standard(joint: Joint) -> _Row | None:
    """A joint's row, where it was made of one of the standard convention."""
    row = _tilted(joint.after), float(joint.after[0, 3]), _turned(joint.before), float(joint.before[2, 3])
    return _row_of(joint, row, _as_standard)


def _modified(joint: Joint) -> _Row | None:
    """A joint's row, where it was made of one of the modified convention."""
    T = joint.before
    alpha = float(np.arctan2(-T[1, 2], T[2, 2]))
    row = (
        alpha,
        float(T[0, 3]),
        float(np.arctan2(-T[0, 1], T[0, 0])),
        float(T[2, 3] * np.cos(alpha) - T[1, 3] * np.sin(alpha)),
    )
    return _row_of(joint, row, _as_modified)


def _row_of(joint: Joint, row: _Row, build: Callable[[Joint, _Row], Joint]) -> _Row | None:
    again = build(joint, row)
    same = np.allclose(again.before, joint.before, atol=_CLOSE) and np.allclose(again.after, joint.after, atol=_CLOSE)
    return row if same else None
