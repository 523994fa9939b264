"""The words of Heidenhain's motions, and what R0, RL and RR among them ask for."""

from __future__ import annotations

import re
from collections.abc import Iterator

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.lexer import Block

__all__ = ["motion_words", "offset_blocks"]

_WORD = re.compile(
    r"(I?PA|PR|I?[XYZABC]|[NT][XYZ]|DR(?=[-+]?(?: |$|[A-Z]))|FMAX|F AUTO|F|M|R0(?![0-9.])|RL|RR|R(?=[-+0-9Q])|S)"
    r" ?([-+]?(?:Q[0-9]+|[0-9]*\.?[0-9]+\.?)|[-+](?= |$|[A-Z]))? ?"
)


def motion_words(text: str) -> tuple[dict[str, str], list[int]]:
    """The words of a motion, and its M functions."""
    words: dict[str, str] = {}
    codes: list[int] = []
    at, text = 0, text.replace("F MAX", "FMAX")
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


def offset_blocks(words: dict[str, str], line: int) -> Iterator[Block]:
    """R0, RL and RR as G40, G41 and G42."""
    for word, code in (("R0", 400), ("RL", 410), ("RR", 420)):
        if word in words:
            yield Block(line, {}, (code,))
