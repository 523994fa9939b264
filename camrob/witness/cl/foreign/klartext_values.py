"""What Heidenhain's TOOL CALL, its cycles' parameters and its cycles 8 and 10 say."""

from __future__ import annotations

import re

from camrob.witness.cl.foreign.computed_values import Values
from camrob.witness.cl.foreign.foreign_cycles import Hole, klartext_hole
from camrob.witness.cl.foreign.foreign_words import UnreadError

__all__ = ["ARC_BY_MACHINE", "FEED_BY_TOOL", "NUMBER", "CycleInForce", "feed_words", "joined_signs", "tool_words"]

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"
"""A number, as a pattern."""
ARC_BY_MACHINE = "an arc, or a polar motion, by positions of the machine (M91, M92)"
FEED_BY_TOOL = "a feed per tooth, or one per turn behind another speed"
"""Of programs that camrob refuses, beside: nothing that is made of one can be right."""
_AT_ONCE = "99999"  # a feed that stands for FMAX
_FIRST_OF_CYCLES = 200  # parameters from here on are those of cycles


def joined_signs(row: str) -> str:
    """X + 90 as X+90, where no formula and no parameter of a cycle stands; 7.1 without axes for a shift that ends."""
    row = "TRANS DATUM AXIS X+0 Y+0 Z+0" if row == "TRANS DATUM RESET" else row
    if row.startswith(("FN", "Q", "*", "BLK")) or "=" in row:
        return row
    return re.sub(r"(?<=[A-Z])\s?([-+])\s?(?=[.\dQ])", r"\1", row).replace("DR -", "DR-").replace("DR +", "DR+")


def tool_words(text: str) -> tuple[str | None, str | None, str | None]:
    """Tool (number or name in quotes), speed and feed of what stands behind TOOL CALL. Raises UnreadError for more than these."""
    found = re.fullmatch(
        rf"(\d+|\"[^\"]*\")?\s*(?:Z)?\s*(?:S\s?({NUMBER}))?\s*(?:F\s?({NUMBER}))?\s*(?:D[LR]2?[-+]?0*\.?0* ?)*", text
    )
    if re.search(r"\bF[UZ]", text):
        raise UnreadError(FEED_BY_TOOL)
    if found is None:
        raise UnreadError("TOOL CALL by a name, with another axis, or with an offset")
    return found[1], found[2], found[3]


def feed_words(words: dict[str, str], turns: float | None) -> tuple[list[str], bool]:
    """F of a motion as a word, none where it names none, and whether it is one of FU; takes it out of `words`.

    turns: of the spindle a minute. Raises UnreadError for FZ, and for FU without a speed.
    """
    if "FZ" in words:
        raise UnreadError(FEED_BY_TOOL)
    if "FU" not in words:
        return ([f"F{words.pop('F')}"] if "F" in words else []), False
    if not turns or "F" in words:
        raise UnreadError("FU without a speed")
    return [f"F{float(words.pop('FU')) * turns:.9f}"], True


class CycleInForce:
    """The cycle that a call runs, by parameters that are the program's own: what one is given behind the definition holds."""

    def __init__(self, computed: Values) -> None:
        self._computed = computed
        self._number, self._q = "", dict[int, float]()
        self._taken: dict[int, float] = {}

    def take(self, rest: str, called_feed: str) -> None:
        """The parameters that a CYCL DEF names; FAUTO is TOOL CALL's feed, FMAX as fast as can be."""
        for name in re.findall(r"\bQ\d+(?= ?=)", rest):
            self._computed.forget(name)
        plain = {int(k): float(v) for k, v in re.findall(rf"\bQ(\d+) ?= ?({NUMBER})(?![\d.])", rest)}
        for number, value in plain.items():
            self._computed.put(f"Q{number}", value)
        feeds = {"MAX": float(_AT_ONCE)} | ({"AUTO": float(called_feed)} if called_feed else {})
        words = re.findall(r"\bQ(\d+) ?= ?F ?(MAX|AUTO)\b", rest)
        self._taken = plain | {int(k): feeds[word] for k, word in words if word in feeds}

    def hole(self, number: str) -> Hole:
        """That of the parameters taken last. Raises UnreadError for cycles that aren't read."""
        self._number, self._q = number, self._taken
        return klartext_hole(number, self._q)

    def given(self, name: str) -> Hole | None:
        """What Q201 = ... makes of the cycle in force, None where there is none. Raises UnreadError as above."""
        if not self._number or not name[1:].isdigit() or int(name[1:]) < _FIRST_OF_CYCLES:
            return None
        self._q = self._q | {int(name[1:]): self._computed.of(name)}
        return klartext_hole(self._number, self._q)
