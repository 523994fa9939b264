"""What Heidenhain's TOOL CALL, its cycles' parameters and its cycles 8 and 10 say."""

from __future__ import annotations

import re

from camrob.witness.cl.foreign.foreign_words import UnreadError

__all__ = ["NUMBER", "cycle_values", "folded_by", "stands_still", "tool_words"]

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"
"""A number, as a pattern."""
_AT_ONCE = "99999"  # a feed that stands for FMAX


def tool_words(text: str) -> tuple[str | None, str | None, str | None]:
    """Tool (number or name in quotes), speed and feed of what stands behind TOOL CALL. Raises UnreadError for more than these."""
    found = re.fullmatch(
        rf"(\d+|\"[^\"]*\")?\s*(?:Z)?\s*(?:S\s?({NUMBER}))?\s*(?:F\s?({NUMBER}))?\s*(?:D[LR]2?[-+]?0*\.?0* ?)*", text
    )
    if found is None:
        raise UnreadError("TOOL CALL by a name, with another axis, or with an offset")
    return found[1], found[2], found[3]


def cycle_values(rest: str, called_feed: str) -> dict[int, float]:
    """The parameters of a cycle by their Q numbers; FAUTO is TOOL CALL's feed, FMAX as fast as can be."""
    rest = re.sub(r"(?<==) ?F ?MAX\b", _AT_ONCE, rest)
    if called_feed:
        rest = re.sub(r"(?<==) ?F ?AUTO\b", called_feed, rest)
    return {int(k): float(v) for k, v in re.findall(rf"Q(\d+) ?= ?({NUMBER})(?![\d.])", rest)}


def folded_by(cycle: str, rest: str, before: tuple[str, float]) -> tuple[str, float]:
    """Mirrored axes and angle (degrees) behind CYCL DEF 8.1, 10.1 or 11.1. Raises UnreadError for both at once, and a scale."""
    axes, angle = before
    if cycle == "8" and re.fullmatch(r"([XY]\s*)*", rest):
        axes = re.sub(r"\s", "", rest)
    elif cycle == "10" and (said := re.fullmatch(rf"(I?)ROT\s?({NUMBER})", rest)):
        angle = float(said[2]) + (angle if said[1] else 0.0)
    elif not (cycle == "11" and re.fullmatch(r"SCL\s?1(\.0*)?", rest)):
        raise UnreadError(f"CYCL DEF {cycle}.1 {rest[:16]}")
    if axes and angle:
        raise UnreadError("cycles 8 and 10 at once")
    return axes, angle


def stands_still(rest: str, shift: dict[str, float], scale: float) -> bool:
    """Whether the words of a datum shift, in units of `scale` m, say what holds already (m)."""
    found = re.findall(rf"(I?)([XYZ])\s?({NUMBER})", rest)
    return not any(float(v) - (0.0 if more else shift[axis] / scale) for more, axis, v in found)
