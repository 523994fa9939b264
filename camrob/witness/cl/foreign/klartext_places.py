"""Where Heidenhain's polar motions end, and which of its M functions act before a motion, behind it, or not on the path."""

from __future__ import annotations

import math

from camrob.witness.cl.foreign.foreign_words import UnreadError
from camrob.witness.units import deg_to_rad, rad_to_deg

__all__ = ["FIRST", "LAST", "QUIET", "polar_end"]

FIRST = {"3": "M3", "4": "M4", "7": "M7", "8": "M8", "13": "M3M8", "14": "M4M8", "128": "M128"}
LAST = {"0": "M0", "1": "M1", "2": "M2", "30": "M30", "5": "M5", "9": "M9", "129": "M129"}
# how the path is run, and which way rotary axes go round
QUIET = frozenset("94 116 117 120 124 126 127 134 135 137 138 107 108 25 26".split())

_FULL = 360.0  # degrees


def polar_end(
    kind: str, words: dict[str, str], to: dict[str, float], pole: tuple[float, float], off: tuple[float, float]
) -> tuple[dict[str, float], list[str]]:
    """The end of CP or LP about the pole, `off` (X, Y) being where the tool is from it, and the word for full turns.

    Takes what it reads out of `words`. Raises UnreadError for an angle that isn't known.
    """
    cx, cy = pole
    radius, more = math.hypot(*off), list[str]()
    if "PR" in words:
        if kind == "CP":
            raise UnreadError("CP with PR")
        radius = float(words.pop("PR"))
    if "IPA" in words:
        way = float(words.pop("IPA"))
        angle = rad_to_deg(math.atan2(off[1], off[0])) + way
        more = [f"P{max(1, math.ceil(abs(way) / _FULL - 1e-9))}"] if kind == "CP" else []
    else:
        angle = float(words.pop("PA", "nan"))
    if not math.isfinite(angle) or (kind == "CP" and not more and abs(angle) > _FULL):
        raise UnreadError(f"{kind} whose angle is not known")
    ray = deg_to_rad(angle)
    return {**to, "X": cx + radius * math.cos(ray), "Y": cy + radius * math.sin(ray)}, more
