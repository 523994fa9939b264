"""Targets of motions: what an aggregate names, and what it leaves as it was."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from camrob.errors import KrlError
from camrob.languages.krl.reader.expressions import Aggregate, Value
from camrob.languages.krl.reader.rows import KrlRows
from camrob.languages.krl.reader.tokens import shown
from camrob.se3 import abc_to_rotation
from camrob.units import deg_to_rad

__all__ = ["Target", "merged", "standing", "stepped", "target_of"]

_POSE = ("X", "Y", "Z", "A", "B", "C")
_AXES = ("A1", "A2", "A3", "A4", "A5", "A6")
_EXTERNAL = ("E1", "E2", "E3", "E4", "E5", "E6")
_POSE_TYPES = {"E6POS": (*_POSE, *_EXTERNAL, "S", "T"), "POS": (*_POSE, "S", "T"), "FRAME": _POSE}
_AXIS_TYPES = {"E6AXIS": (*_AXES, *_EXTERNAL), "AXIS": (*_AXES, *_EXTERNAL)}


@dataclass(frozen=True, slots=True)
class Target:
    """Components that a target names: `pose` or `axes` (the other is None), and `external`; S and T, -1 if absent."""

    pose: dict[str, float] | None
    axes: dict[str, float] | None
    external: dict[str, float]
    status: int
    turn: int


def target_of(aggregate: Aggregate, word: str, rows: KrlRows) -> Target:
    """The target of motion `word`. Raises KrlError, without a place, where the aggregate is no target for it."""
    fields = aggregate.fields
    axes = aggregate.type in _AXIS_TYPES or any(name in _AXES for name in fields)
    if not aggregate.type and not any(name in (*_AXES, *_POSE) for name in fields):
        axes = word == "PTP" and rows.axes is not None
    types = _AXIS_TYPES if axes else _POSE_TYPES
    if aggregate.type and aggregate.type not in types:
        raise KrlError(f"{shown(aggregate.type)} is not a type of a target", hint="write E6POS or E6AXIS")
    allowed = types[aggregate.type or ("E6AXIS" if axes else "E6POS")]
    for name in fields:
        if name not in allowed:
            raise KrlError(f"a target has no component {shown(name)}", hint="the components are " + ", ".join(allowed))
    if axes and word != "PTP":
        raise KrlError(f"{word} to axis values", hint="only PTP runs to axis values")
    main = {name: _number(name, fields[name]) for name in (_AXES if axes else _POSE) if name in fields}
    external = {name: _number(name, fields[name]) for name in _EXTERNAL if name in fields}
    status, turn = (_bits(name, fields[name]) if name in fields else -1 for name in ("S", "T"))
    return Target(None if axes else main, main if axes else None, external, status, turn)


def standing(rows: KrlRows, *, axes: bool) -> Aggregate | None:
    """Where the robot stands, as $POS_ACT gives it, or $AXIS_ACT (axes); None where the program doesn't hold that."""
    names, values = (_AXES, rows.axes) if axes else (_POSE, rows.pose)
    if values is None or rows.framed is None or (not axes and rows.framed != (rows.modal.tool, rows.modal.base)):
        return None
    external = {name: v for name, v in zip(_EXTERNAL, rows.external, strict=True) if not math.isnan(v)}
    return Aggregate("E6AXIS" if axes else "E6POS", {**dict(zip(names, values, strict=True)), **external})


def stepped(rows: KrlRows, step: Target, word: str, *, by_tool: bool = False) -> Target:
    """Where a step by `step` leads from the last target, along the axes of $BASE, or of the tool.

    Raises KrlError where the last target isn't known in that base and with that tool, and for a step that turns the tool.
    """
    given = step.pose if step.axes is None else step.axes
    before = rows.pose if step.axes is None else rows.axes
    names = _POSE if step.axes is None else _AXES
    if before is None or rows.framed != (rows.modal.tool, rows.modal.base):
        raise KrlError(
            f"{word}_REL from a place that the program doesn't hold", hint="give the target before it, in the same base"
        )
    if step.axes is None and any((given or {}).get(name) for name in "ABC"):
        raise KrlError(f"{word}_REL that turns the tool by angles", hint="write the target itself")
    if by_tool:
        given = _along_tool(given, step, before, word)
    sums = {name: value + (given or {}).get(name, 0.0) for name, value in zip(names, before, strict=True)}
    external = {name: value + rows.external[_EXTERNAL.index(name)] for name, value in step.external.items()}
    if any(math.isnan(value) for value in external.values()):
        raise KrlError(f"{word}_REL of an external axis whose place the program doesn't hold", hint="name it before")
    pose, axes = (sums, None) if step.axes is None else (None, sums)
    return Target(pose, axes, external, step.status, step.turn)


def _along_tool(given: dict[str, float] | None, step: Target, before: tuple[float, ...], word: str) -> dict[str, float]:
    """A step along the axes that the tool has at `before`, as one along those of $BASE."""
    if step.axes is not None or step.external:
        raise KrlError(f"{word}_REL of axes along the tool (#TOOL)", hint="write the target itself")
    turn = abc_to_rotation(deg_to_rad(np.array(before[3:])))
    moved = turn @ np.array([(given or {}).get(name, 0.0) for name in _POSE[:3]])
    return dict(zip(_POSE[:3], moved.tolist(), strict=True))


def merged(rows: KrlRows, target: Target, word: str, *, elsewhere: bool, needed: str = "XYZABC") -> None:
    """Makes the target the current one in `rows`; a component that it doesn't name keeps its value.

    Raises KrlError where that value is not known: before the first target, or where the last one was of the other kind, or, for
    `needed` ones of a pose, `elsewhere`: in another base, with another tool, or where an arc has not ended at it.
    """
    names, given, before = (_POSE, target.pose, rows.pose) if target.axes is None else (_AXES, target.axes, rows.axes)
    given = given or {}
    values = []
    for index, name in enumerate(names):
        if name not in given and elsewhere and target.axes is None and before is not None and name in needed:
            raise KrlError(
                f"{word} gives no {name}, and the robot stands at no target of this base and tool",
                hint=f"give {names[0]} to {names[-1]}",
            )
        if name not in given and before is None:
            raise KrlError(f"{word} gives no {name} and none is known", hint=f"give {names[0]} to {names[-1]}")
        values.append(given[name] if name in given else (before or ())[index])
    rows.pose, rows.axes = (tuple(values), None) if target.axes is None else (None, tuple(values))
    if target.external:
        old = rows.external
        rows.external = tuple(target.external.get(name, old[k]) for k, name in enumerate(_EXTERNAL))


def _number(name: str, value: Value) -> float:
    """The component as a number. Raises KrlError where it is none."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise KrlError(f"{name} has no number that is in the program", hint="write a number")
    return float(value)


def _bits(name: str, value: Value) -> int:
    """S or T. Raises KrlError where it is no such number."""
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, bool) or not isinstance(value, int) or not -1 <= value < 2**15:
        raise KrlError(f"{name} is not a whole number", hint=f"write {name} as a number or as bits, 'B010'")
    return value
