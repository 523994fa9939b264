"""What Heidenhain's TOOL CALL, its cycles' parameters and its cycles 8 and 10 say."""

from __future__ import annotations

import re

from camrob.witness.cl.foreign.foreign_words import UnreadError

__all__ = ["ARC_BY_MACHINE", "FEED_BY_TOOL", "NUMBER", "cycle_values", "feed_words", "tool_words"]

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"
"""A number, as a pattern."""
ARC_BY_MACHINE = "an arc, or a polar motion, by positions of the machine (M91, M92)"
FEED_BY_TOOL = "a feed per tooth, or one per turn behind another speed"
"""Of programs that camrob refuses, beside: nothing that is made of one can be right."""
_AT_ONCE = "99999"  # a feed that stands for FMAX


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


def cycle_values(rest: str, called_feed: str) -> dict[int, float]:
    """The parameters of a cycle by their Q numbers; FAUTO is TOOL CALL's feed, FMAX as fast as can be."""
    rest = re.sub(r"(?<==) ?F ?MAX\b", _AT_ONCE, rest)
    if called_feed:
        rest = re.sub(r"(?<==) ?F ?AUTO\b", called_feed, rest)
    return {int(k): float(v) for k, v in re.findall(rf"Q(\d+) ?= ?({NUMBER})(?![\d.])", rest)}
