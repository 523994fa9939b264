"""The words of Heidenhain's motions, and what R0, RL and RR among them ask for."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.corner import LEG, ROUND, Corner
from camrob.toolpath.gcode.lexer import Block

__all__ = ["corner_of", "motion_words", "offset_blocks"]

_WORD = re.compile(
    r"(I?PA|PR|I?[XYZABC]|[NT][XYZ]|DR(?=[-+]?(?: |$|[A-Z]))|FMAX|F AUTO|F|M|R0(?![0-9.])|RL|RR|R(?=[-+0-9Q])|S)"
    r" ?([-+]?(?:Q[0-9]+|[0-9]*\.?[0-9]+\.?)|[-+](?= |$|[A-Z]))? ?"
)


_CORNER = re.compile(r"(RND R|CHF) ?([-+]?[0-9.]+|[-+]?Q[0-9]+)(?: F ?([0-9.]+|Q[0-9]+))?")
_SHOWN = re.compile(r" ?\bM94(?: [ABC](?![-+0-9]))?(?![0-9])")  # M94: a rotary axis is shown within one turn


def motion_words(text: str) -> tuple[dict[str, str], list[int]]:
    """The words of a motion, and its M functions."""
    words: dict[str, str] = {}
    codes: list[int] = []
    at, text = 0, _SHOWN.sub("", text.replace("F MAX", "FMAX"))
    while at < len(text):
        match = _WORD.match(text, at)
        if match is None or match.end() == at:
            raise ToolpathError(f"{text[at : at + 16]!r} is no word of a motion", hint="check the block")
        at = match.end()
        name, value = match[1], match[2] or ""
        if name == "M" and not value.isdigit():
            raise ToolpathError(f"M{value} is no M function", hint="check the block")
        if name == "M":
            codes.append(int(value))
            if value == "140":
                raise ToolpathError("M140 in a motion", hint="give it a block of its own")
        elif name in words:
            raise ToolpathError(f"the word {name} stands twice in one block", hint="split the block")
        else:
            words[name] = value
    return words, codes


def corner_of(text: str, value: Callable[[str], float]) -> Corner | None:
    """The corner that RND or CHF asks for, None for another statement, or a size of 0; `value` is that of a number or parameter.

    A chamfer's length is that of its sides, along the contour.
    """
    match = _CORNER.fullmatch(text)
    if match is None:
        return None
    size = value(match[2])
    if size < 0.0:
        raise ToolpathError(f"{text[:24]!r}: a corner of a negative size", hint="check the block")
    feed = None if match[3] is None else value(match[3])
    return Corner(ROUND if match[1] == "RND R" else LEG, size, feed) if size else None


def offset_blocks(words: dict[str, str], line: int) -> Iterator[Block]:
    """R0, RL and RR as G40, G41 and G42."""
    for word, code in (("R0", 400), ("RL", 410), ("RR", 420)):
        if word in words:
            yield Block(line, {}, (code,))
