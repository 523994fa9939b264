"""The words of Heidenhain's motions, and what R0, RL and RR among them ask for."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.corner import LEG, ROUND, Corner
from camrob.toolpath.gcode.lexer import Block

__all__ = ["ToolCall", "corner_of", "motion_words", "offset_blocks", "tool_call"]

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
    at, text = 0, _SHOWN.sub("", text.replace("F MAX", "FMAX").replace("FAUTO", "F AUTO"))
    while at < len(text):
        match = _WORD.match(text, at)
        if match is None or match.end() == at:
            raise ToolpathError(f"{text[at : at + 16]!r} is not a word of a motion", hint="check the block")
        at = match.end()
        name, value = match[1], match[2] or ""
        if name == "M" and not value.isdigit():
            raise ToolpathError(f"M{value} is not an M function", hint="check the block")
        if name == "M":
            codes.append(int(value))
            if value == "140":
                raise ToolpathError("M140 in a motion", hint="give it a block of its own")
        elif name in words:
            raise ToolpathError(f"the word {name} appears twice in one block", hint="split the block")
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


class ToolCall(NamedTuple):
    """What TOOL CALL says: `changes` the tool or only speed and feed; `number` None where it is the set-up's (`note`)."""

    changes: bool
    number: float | None
    speed: float | None
    feed: float | None
    note: str = ""


def tool_call(text: str, *, one_name: bool) -> ToolCall:
    """What stands behind TOOL CALL. Raises ToolpathError for offsets, other tool axes, and one of several names."""
    match = re.match(r'("[^"]*"|[0-9]+(?:\.[0-9]+)?)?', text)
    name = match[0] if match else ""
    rest = text[len(name) :]
    for key, value in re.findall(r"\b(D[LR]2?)([-+]?[0-9.]+)", rest):
        if float(value):
            raise ToolpathError(
                f"TOOL CALL with {key}{value}: an offset of the path", hint="put it into the CAM system"
            )
    axis = re.search(r" ([XYZ])\b", f" {rest.strip()}")
    if axis and axis[1] != "Z":
        raise ToolpathError(f"a tool along {axis[1]}", hint="post with the tool along Z")
    speed, feed = (re.search(rf"\b{letter} ?([0-9.]+)", rest) for letter in "SF")
    number: float | None = None
    note = ""
    if name.startswith('"') and not name.strip('"').isdigit():
        if not one_name:
            raise ToolpathError(
                f"TOOL CALL {name[:40]}: several tools by their names",
                hint="call tools by numbers, as the set-up does",
            )
        note = f"TOOL CALL {name[:40]} is the file's only tool: it is taken for the one of the set-up"
    elif name:
        number = float(name.strip('"'))
    return ToolCall(bool(name), number, float(speed[1]) if speed else None, float(feed[1]) if feed else None, note)
