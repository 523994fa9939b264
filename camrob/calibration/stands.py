"""Where instruments stood and reflectors sat, and which logs say that theirs was another log's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.align import align, laid_by_part
from camrob.calibration.error_model import ErrorModel
from camrob.calibration.measurements import Measurements, sampled_rows
from camrob.calibration.terms import SIDES
from camrob.cell.cell import Cell
from camrob.errors import LogError

__all__ = ["LEAST_POSES", "Stand", "owner_of", "placed", "placed_together", "with_others_known"]

Array = NDArray[np.float64]

_SAMPLE = 2000  # rows that suffice to see where an instrument stands
LEAST_POSES = 8
"""Of a set, for its instrument to be placed."""


@dataclass(frozen=True, slots=True)
class Stand:
    """Where an instrument stands, or a reflector sits: its place (4, 4), and how far a fit moved it from there, by name."""

    place: Array
    moved: dict[str, float] = field(default_factory=dict)


def _named(data: Measurements, side: str) -> str:
    return data.same_frame_as if side == "base" else data.same_target_as


def _known(data: Measurements, side: str) -> bool:
    return data.frame_known if side == "base" else data.target_known


def owner_of(sets: Sequence[Measurements], k: int, side: str) -> int:
    """The set whose frame (or reflector) a set has: the one that it names as having its own, and so on; itself where that is not
    among these, or where frame and reflector are the cell's.
    """
    passed = {k}
    while not _known(sets[k], side):
        named = next((i for i, s in enumerate(sets) if s.name and s.name == _named(sets[k], side)), k)
        if named in passed:
            break
        passed.add(named)
        k = named
    return k


def with_others_known(sets: Sequence[Measurements]) -> list[Measurements]:
    """The sets, of which those know frame and reflector that name a set as theirs which knows them."""
    out = []
    for k, data in enumerate(sets):
        frame, target = (sets[owner_of(sets, k, side)] for side in SIDES)
        in_base = frame.in_base if frame.frame_known else data.in_base
        out.append(replace(data, frame_known=frame.frame_known, target_known=target.target_known, in_base=in_base))
    return out


def placed_together(cell: Cell, sets: Sequence[Measurements]) -> list[tuple[Array, Array]]:
    """Of each set, where its instrument stands and its reflector sits; one place of those who say so. Raises LogError for too few
    poses, SingularError where they don't tell.
    """
    stands: dict[tuple[str, int], Stand] = {}
    found = []
    for k, data in enumerate(sets):
        own = [(side, owner_of(sets, k, side)) for side in SIDES]
        left, right = placed(cell, data, *(stands.get(key) for key in own))
        for key, place in zip(own, (left, right), strict=True):
            stands.setdefault(key, Stand(place))
        found.append((left, right))
    return found


def placed(cell: Cell, data: Measurements, base: Stand | None = None, tool: Stand | None = None) -> tuple[Array, Array]:
    """Where a set's instrument stands and its reflector sits, one of which may be known by another set."""
    if base is not None and tool is not None:
        return base.place, tool.place
    if len(data) < LEAST_POSES:
        raise LogError(
            f"holds {len(data)} whole poses", hint=f"measure at least {LEAST_POSES}, better 50", path=data.name
        )
    plain = ErrorModel.of(cell, (), in_base=data.in_base)
    index = sampled_rows(len(data), _SAMPLE)
    nominal, measured = plain.poses(np.zeros(0), data.q[index]), np.asarray(data.frames[index])
    if base is not None:
        measured = np.linalg.inv(base.place) @ measured
    if tool is not None:
        nominal = nominal @ tool.place
    if data.sight is not None:
        free = not data.frame_known and base is None
        return (
            base.place if base else laid_by_part(nominal[:, :3, 3], data.sight.select(index)) if free else np.eye(4)
        ), (tool.place if tool else np.eye(4))
    left, right = align(
        nominal,
        measured,
        oriented=data.oriented,
        frame_known=data.frame_known or base is not None,
        target_known=data.target_known or tool is not None,
    )
    return (left if base is None else base.place), (right if tool is None else tool.place)
