"""Which of a tool's lengths is in force: Fanuc's H and those alike, and the edge, D, of Siemens.

How far two lengths of one tool lie apart stands in the machine's table. A robot has one tool centre point a tool, so that a
program that cuts with two of them, or with one and then without any (H0, D0), makes another part than the file says.
"""

from __future__ import annotations

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.lexer import Block
from camrob.toolpath.gcode.state import Modal

__all__ = ["refuse_other_length", "take_length"]

_OTHER_H = frozenset((100, 150, 160))  # G10, and Okuma's G15 and G16, whose H are other things


def take_length(block: Block, modal: Modal) -> None:
    """Take note of the length that a block names; a change of tools brings Siemens' D1 along."""
    if modal.edges and (60 in block.m or (modal.tool_by_t and "T" in block.words)):
        modal.length = 1.0
    letter = "D" if modal.edges else "H"
    if letter in block.words and _OTHER_H.isdisjoint(block.g):
        modal.length = block.words[letter]


def refuse_other_length(modal: Modal, tool: int) -> None:
    """Before a cut. Raises ToolpathError where the tool has cut with another length before."""
    if modal.length is None:
        return
    first = modal.lengths.setdefault(tool, modal.length)
    if first != modal.length:
        letter = "D" if modal.edges else "H"
        raise ToolpathError(
            f"a cut with {letter}{modal.length:g} behind cuts of the same tool with {letter}{first:g}: how its lengths lie to "
            "each other only the machine's table says",
            hint="give what belongs to each a tool, or a program, of its own",
        )
