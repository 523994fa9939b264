"""What Autodesk's posts for APT write in their own way: arcs that name their angle, and cycles whose heights are the frame's."""

from __future__ import annotations

from dataclasses import replace

from camrob.witness.cl.drilling import Cycle, apt_cycle
from camrob.witness.cl.placing import Placing
from camrob.witness.cl.source import Statement, number
from camrob.witness.cl.teller import Teller

__all__ = ["CONTOURS", "FUSION", "MORI", "TRUEPATH", "autodesk_cycle", "movarc", "sweep"]

FUSION, TRUEPATH, MORI = "fusion-apt", "camplete-apt", "mori-apt"
CONTOURS = (FUSION, TRUEPATH, MORI)
"""Whose points behind CUTCOM are the part's contour."""

_KEYED = ["CENTER", "AXIS", "RADIUS"]


def movarc(s: Statement, dialect: str) -> tuple[Statement, tuple[float, bool] | None] | None:
    """The arc as CIRCLE would have it; and its angle in degrees, with whether its normal is signed, where it names one.

    The edition that signs its normals writes a point in every number. None where the statement isn't understood.
    """
    keyed = dialect == MORI
    if s.words != (_KEYED if keyed else ["ANGLE"]) or len(s.numbers) != (7 if keyed else 8):
        return None
    plain = Statement("CIRCLE", ",".join(map(repr, s.numbers[:7])), s.line, s.last)
    return plain, None if keyed else (abs(s.numbers[7]), all("." in part for part in s.rest.split(",")[:6]))


def sweep(s: Statement, dialect: str) -> tuple[float, bool] | None:
    """The angle that a CIRCLE for TruePath names behind its radius, None elsewhere."""
    return (s.numbers[7], True) if dialect == TRUEPATH and len(s.numbers) > 7 else None


def autodesk_cycle(s: Statement, dialect: str, place: Placing, tell: Teller, *, forced: bool) -> Cycle:
    """A drilling cycle. TruePath's RAPTO, RTRCTO and FEDTO count from the hole's top, CLEAR is a height of the frame's."""
    if dialect != TRUEPATH:
        return Cycle(problem="CYCLE of Autodesk's, whose heights count in its own way")
    fields = list(s.fields)
    said: dict[str, float] = {}
    for word in ("CLEAR", "RETURN", "PITCH"):
        if word in fields[:-1]:
            at = fields.index(word)
            value = number(fields[at + 1])
            if value is None:
                return Cycle(problem=f"CYCLE with {word} that has no number")
            said[word] = value
            del fields[at : at + 2]
    if fields[:1] == ["RIGID"] and "PITCH" in said:
        fields[:1] = ["TAP", "PERREV", repr(said["PITCH"])]
    elif "PITCH" in said:
        return Cycle(problem="CYCLE with PITCH")
    if "RTRCTO" not in fields and "CLEAR" not in said:
        return Cycle(problem="CYCLE that names no height to go back to")
    cycle = apt_cycle(
        [*fields, *([] if "RAPTO" in fields else ["RAPTO", "0"])], place.scale, False, tell, forced=forced
    )
    if cycle.problem or "RTRCTO" in fields:
        return cycle
    return replace(cycle, start=place.point([0.0, 0.0, said["CLEAR"]]))
