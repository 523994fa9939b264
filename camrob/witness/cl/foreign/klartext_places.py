"""Where Heidenhain's polar motions end, and which of its M functions act before a motion, behind it, or not on the path."""

from __future__ import annotations

import cmath
import math
import re
from typing import NamedTuple

from camrob.witness.cl.foreign.foreign_words import UnreadError
from camrob.witness.cl.foreign.klartext_values import NUMBER
from camrob.witness.units import deg_to_rad, rad_to_deg

__all__ = [
    "FIRST",
    "LAST",
    "MODAL_CALL",
    "QUIET",
    "Pole",
    "folded_by",
    "formula_of",
    "polar_end",
    "smooth_arc",
    "unread_code",
]

FIRST = {"3": "M3", "4": "M4", "7": "M7", "8": "M8", "13": "M3M8", "14": "M4M8", "128": "M128"}
LAST = {"0": "M0", "1": "M1", "2": "M2", "30": "M30", "5": "M5", "9": "M9", "129": "M129"}
# how the path is run, and which way rotary axes go round
QUIET = frozenset("89 94 116 117 120 124 134 135 137 138 107 108 25 26".split())

MODAL_CALL = "M89 without a place, or a way along Z while it calls a cycle behind every motion"
"""Of a program that camrob refuses: nothing that is made of it can be right."""
_FULL = 360.0  # degrees
_PLANES = {"XY": "G17", "YZ": "G19", "ZX": "G18"}  # angles count from the first axis to the second


class Pole(NamedTuple):
    """What CC names: two axes, and where on them."""

    axes: str
    at: tuple[float, float]

    @property
    def plane(self) -> str:
        """The plane as ISO calls it."""
        return _PLANES[self.axes]

    @classmethod
    def named(cls, to: dict[str, float], before: Pole | None) -> Pole:
        """CC with these values, `before` being the one in force. Raises UnreadError where an axis of its plane is left open."""
        if len(to) == 2 and (axes := next((pair for pair in _PLANES if set(pair) == set(to)), "")):
            return cls(axes, (to[axes[0]], to[axes[1]]))
        if len(to) != 1 or before is None or not set(to) <= set(before.axes):
            raise UnreadError("a centre (CC) of which only one axis is named")
        first, second = (to.get(axis, kept) for axis, kept in zip(before.axes, before.at, strict=True))
        return cls(before.axes, (first, second))


def polar_end(
    kind: str, words: dict[str, str], to: dict[str, float], pole: Pole, off: tuple[float, float]
) -> tuple[dict[str, float], list[str]]:
    """The end of CP or LP about the pole, `off` being where the tool is from it in its plane, and the word for full turns.

    Takes what it reads out of `words`. Raises UnreadError for an angle that isn't known.
    """
    cx, cy = pole.at
    radius, more = math.hypot(*off), list[str]()
    if "IPR" in words and kind == "LP":
        radius += float(words.pop("IPR"))
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
    first, second = pole.axes[0], pole.axes[1]
    return {**to, first: cx + radius * math.cos(ray), second: cy + radius * math.sin(ray)}, more


def smooth_arc(going: complex | None, chord: complex) -> tuple[complex, str]:
    """CT: its centre as seen from where it begins, and its sense; going: the way of the cut before it.

    The chord stands at half the arc's angle to the way. Raises UnreadError where there is no such arc.
    """
    if going is None or not chord:
        raise UnreadError("CT behind no cut whose way is known, or to where it begins")
    half = cmath.phase(chord / going)
    if abs(math.sin(half)) < 1e-6:
        raise UnreadError("CT to a place straight ahead")
    return 1j * going / abs(going) * abs(chord) / (2.0 * math.sin(half)), "+" if half > 0.0 else "-"


def formula_of(name: str, text: str, row: str) -> str:
    """What Q1 = ..., or FN 0 to FN 4, gives a parameter, in brackets where Heidenhain's functions have none.

    Raises UnreadError for a parameter of the control's own, and for FN with more than two values.
    """
    text = text.replace(" DIV ", "/")
    if re.search(r"\b(?:SIN|COS|TAN|SQRT|SQ|ABS|INT|FRAC|NEG)\b(?! ?\()", text):
        text = re.sub(r"\b(SIN|COS|TAN|SQRT|SQ|ABS|INT|FRAC|NEG) ?([-+]?(?:Q[LR]?\d+|[\d.]+))", r"\1(\2)", text)
    many = re.match(r"FN ?[1-4]", row) and re.search(r"[-+*/][-+ ]*[-+*/][^Q\d]", text)
    if (name[1:].isdigit() and int(name[1:]) in range(100, 200)) or many:
        raise UnreadError(f"{row[:24]}, computed")
    return text


def unread_code(code: str) -> UnreadError:
    """An M function that is not read."""
    return UnreadError(f"M{code} of Heidenhain's")


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
