"""Heidenhain's cycle 200 (drilling) as the moves that it stands for (TNC 640, "Programming of Machining Cycles", 4.3)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.lexer import Block

__all__ = ["check_200", "cycle_200"]

_NEEDED = (200, 201, 202, 203, 204, 206)  # Q numbers: clearance, depth, bite, surface, second clearance, feed
_MOST_PECKS = 2000  # of one hole: a slip of the decimal point has more
_EVEN = 1e-9  # of the program's unit


def check_200(q: Mapping[int, float]) -> None:
    """Raises ToolpathError where the parameters, by their Q numbers, make no hole."""
    missing = [number for number in _NEEDED if number not in q]
    if missing:
        raise ToolpathError(f"cycle 200 without Q{missing[0]}", hint="name all its parameters")
    if q[201] >= 0.0 or q[200] < 0.0 or (q[202] > 0.0 and -q[201] / q[202] > _MOST_PECKS):
        raise ToolpathError("cycle 200 with a depth or bite that makes no hole", hint="check Q200, Q201 and Q202")


def cycle_200(q: Mapping[int, float], z: float | None, line: int) -> Iterator[Block]:
    """The blocks of one hole from height `z`: bites of Q202 from the surface Q203, out to the clearance Q200 between them.

    Raises ToolpathError from an unknown height, or from below the clearance.
    """
    top, depth, bite = q[203] + q[200], q[203] + q[201], q[202]
    if z is None or z < top - _EVEN:
        raise ToolpathError("cycle 200 from an unknown height, or from below its clearance", hint="name Z before it")
    yield Block(line, {"Z": top}, (0,))
    at = q[203]
    while at > depth + _EVEN:
        at = max(depth, at - bite) if bite > 0.0 else depth
        yield Block(line, {"Z": at, "F": q[206]}, (10,))
        if at > depth + _EVEN:
            yield Block(line, {"Z": top}, (0,))
            if q.get(210):
                yield Block(line, {"P": q[210]}, (40,))
            yield Block(line, {"Z": at + q[200]}, (0,))
    if q.get(211):
        yield Block(line, {"P": q[211]}, (40,))
    yield Block(line, {"Z": max(top, q[203] + q[204])}, (0,))
