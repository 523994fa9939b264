"""What a control is to the reader of G-code: how its files are known, and the blocks that one of its programs gives."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from camrob.toolpath.gcode.lexer import Block

__all__ = ["Control", "State"]

State = Callable[[str], float | None]
"""What the program has set so far, by name (see `Interpreter.state`); None where the file doesn't say."""


class Control(NamedTuple):
    """A control, or a family of them. `recognise` scores a text (0: none of its programs); `blocks` runs a program.

    `blocks` gives plain blocks in the words of ISO 6983 as camrob reads them (see `modes`), whatever the control calls them;
    `title` names it for people.
    """

    name: str
    title: str
    recognise: Callable[[str], int]
    blocks: Callable[[list[str], Path, State], Iterator[Block]]
