"""Siemens' patterns of holes: HOLES1, a row, HOLES2, a circle, CYCLE802, any places (840D sl, "Job planning", positions)."""

from __future__ import annotations

import math
from collections.abc import Sequence

from camrob.errors import ToolpathError
from camrob.units import deg_to_rad

__all__ = ["PATTERNS", "places"]

PATTERNS = {"HOLES1": "SPCA SPCO STA1 FDIS DBH NUM", "HOLES2": "CPA CPO RAD STA1 INDA NUM", "CYCLE802": ""}
_FREE = 18  # X0 Y0 to X8 Y8 of CYCLE802
_MOST = 1000  # holes of one pattern: more is a slip


def places(name: str, arguments: Sequence[float | None]) -> list[tuple[float, float]]:
    """X and Y of the holes, in the program's unit, in the order of the pattern. Raises ToolpathError for what makes none."""
    if name == "CYCLE802":
        return _free_places(arguments)
    names = PATTERNS[name].split()
    if any(arguments[len(names) :]):
        raise ToolpathError(
            f"{name} with more than {len(names)} values", hint="have the post-processor write the holes"
        )
    value = {k: v or 0.0 for k, v in zip(names, [*arguments, *[None] * len(names)], strict=False)}
    count = value["NUM"]
    if count != int(count) or not 1 <= count <= _MOST:
        raise ToolpathError(f"{name} of {count:g} holes", hint=f"a whole number up to {_MOST}")
    start = deg_to_rad(value["STA1"])
    if name == "HOLES1":
        along = [value["FDIS"] + k * value["DBH"] for k in range(int(count))]
        return [(value["SPCA"] + s * math.cos(start), value["SPCO"] + s * math.sin(start)) for s in along]
    if not value["RAD"] > 0.0:
        raise ToolpathError("HOLES2 without a radius", hint="name RAD")
    step = deg_to_rad(value["INDA"]) or math.tau / count
    angles = [start + k * step for k in range(int(count))]
    return [(value["CPA"] + value["RAD"] * math.cos(a), value["CPO"] + value["RAD"] * math.sin(a)) for a in angles]


def _free_places(arguments: Sequence[float | None]) -> list[tuple[float, float]]:
    """CYCLE802: how X and Y count (a digit each place, 1: absolute), the places, and modes, of which G17 is read."""
    ways, said, modes = arguments[:2], list(arguments[2 : 2 + _FREE]), arguments[2 + _FREE :]
    if any(set(f"{way or 0:.0f}") != {"1"} for way in ways) or not {*modes} <= {None, 0.0, 1.0}:
        raise ToolpathError("CYCLE802 by steps, or in another plane", hint="name each place absolutely, in G17")
    while said and said[-1] is None:
        del said[-1]
    if not said or len(said) % 2 or None in said:
        raise ToolpathError("CYCLE802 of places that name X or Y alone", hint="name both of each")
    return [(x, y) for x, y in zip(said[::2], said[1::2], strict=True) if x is not None and y is not None]
