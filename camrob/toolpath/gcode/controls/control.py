"""What a control is to the reader of G-code: how its files are known, and the blocks that one of its programs gives."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from camrob.toolpath.gcode.language.called_files import Wanted
from camrob.toolpath.gcode.lexer import Block

__all__ = ["Control", "State"]

State = Callable[[str], float | None]
"""What the program has set so far, by name (see `Interpreter.state`); None where the file doesn't say."""


class Control(NamedTuple):
    """A control, or a family of them. `recognise` scores a text (0: none of its programs); `blocks` runs a program.

    `blocks` gives plain blocks in the words of ISO 6983 as camrob reads them (see `modes`), whatever the control calls them;
    `title` names it for people. What follows is how the control differs where its blocks alone don't say so.
    """

    name: str
    title: str
    recognise: Callable[[str], int]
    blocks: Callable[[list[str], Path, State], Iterator[Block]]
    dialect: str = "gcode"  # of the toolpath, where no machine is named for its rotary words
    plain: bool = (
        False  # its texts are ISO's words: lathes and machines are recognised by them as they stand in the file
    )
    zero_edge: bool = True  # D0 means no radius
    keeps_motion: bool = False  # G80 leaves the motion that stood beside a cycle in force
    rereads: bool = False  # a drilling cycle's R and Z are counted anew where G90 and G91 change
    suffixes: frozenset[str] = frozenset()  # of files that are its programs, where the text leaves it open
    edges: bool = False  # D names an edge of the tool, with its length
    metric: bool = False  # it is shipped so that programs begin with millimetres (G71)
    rolls: bool = False  # whether rotary axes roll over at 360 degrees is a parameter of the machine's
    clamps: bool = False  # M13 and M14 clamp rotary axes where the file has M10 to M12, and M3 or M4 for the spindle
    wanted: Callable[[list[str]], list[Wanted]] = lambda lines: []  # programs that a text calls and does not hold
