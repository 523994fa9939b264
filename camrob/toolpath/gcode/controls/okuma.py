"""Okuma's OSP: blocks as ISO has them, but G15 H is the work offset, G56 H the tool's length along Z, and G53 ends that.

Only codes that mean on OSP what they mean in ISO 6983 are let through (Okuma, "Programming Manual", OSP-P300M): drilling cycles
return to G71's level (M53) or to R (M54) there, G54 to G59 are tool lengths along other axes, G11 moves the program's frame.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.controls.control import Control, State
from camrob.toolpath.gcode.controls.iso import check_points
from camrob.toolpath.gcode.lexer import Block, block_of, strip_comments

__all__ = ["OKUMA"]

_NAME = re.compile(r"\s*\$[\w.-]+%?\s*")
_MARKS = re.compile(r"\A\s*\$[\w.-]+\.(?:MIN|SSB|SUB|LIB|SDF)%?\s*$|^[ \t]*(?:N\d+[ \t]*)?G0*15[ \t]*H[ \t]*\d", re.M)
_OWN_LENGTH = re.compile(r"(?<=[\s\d])HA(?![A-Z\d=])", re.I)
_TCP = re.compile(r"G0*1(?:69|70)(?!\d)")
_COMPUTES = re.compile(r"=|\b(?:CALL|GOTO|IF|RTS|MODIN|MODOUT|COPYE?|NOEX|RTMDI)\b|^\s*[NO][A-Z]")
# tenths: moves, planes, units, the home position, no compensation or compensation, exact stop, no cycle, modes
_SAME = frozenset((0, 10, 20, 30, 90, 170, 180, 190, 200, 210, 300, 400, 410, 420, 610, 640, 800, 900, 910, 940, 950))
_OFFSET, _LENGTH, _NO_LENGTH = 150, 560, 530
_LEVEL = 710
# cycles read: what they are without a dwell
_DONE = {810: 810, 820: 810, 830: 830, 730: 730, 740: 740, 840: 840, 850: 850, 860: 860}
_CYCLES = frozenset((730, 740, 760, *range(810, 900, 10)))
_TO_LEVEL, _TO_R = 530, 540  # M53, M54
_EVEN = 1e-6  # of the program's unit
_OF_HOLES = frozenset("XYZRQF")
_OTHER_LENGTHS = frozenset((540, 550, 570, 580, 590))  # OSP: lengths along another axis than Z
_OTHER_M = frozenset((130, 140, 970, 980, 990))  # tenths: on other controls spindle and coolant, and calls
_PLAIN = "have the post write plain moves (G0 to G3)"


def _blocks(lines: list[str], path: Path, state: State) -> Iterator[Block]:
    """The blocks of a program, in ISO's words."""
    cycle = _Cycle(state)
    check_points(lines, path, "OSP takes it for {:g} where its unit is the micrometre")
    for number, raw in enumerate(lines, 1):
        if not raw.strip() or (_NAME.fullmatch(raw) and "$" in raw):
            continue
        try:
            bare = strip_comments(raw)[0].upper()
            if _TCP.search(bare):
                what = (
                    "G169 (OSP's tool centre point): what its words name, and which way A, B, C turn, is the machine's"
                )
                raise ToolpathError(
                    what, hint="post for a control with tool vectors (Siemens, Heidenhain), or as CL data"
                )
            if _COMPUTES.search(bare):
                what = "variables, calls, jumps and block names of OSP (VC1=, CALL, GOTO, IF, NAB1) are not read"
                raise ToolpathError(what, hint="have the path written out as plain blocks")
            own = bool(_OWN_LENGTH.search(bare))
            yield from cycle.blocks(
                block_of(_OWN_LENGTH.sub(" ", raw).strip() if own else raw.strip(), number), own=own
            )
        except ToolpathError as error:
            raise error.at(path, number) from None


class _Cycle:
    """The drilling cycle in force: each hole as ISO's cycle that ends at R, and on to G71's level."""

    def __init__(self, state: State) -> None:
        self._state = state
        self._level: float | None = None  # G71's, in the program's unit
        self._code = 0
        self._words: dict[str, float] = {}
        self._rises = self._steps = False  # M53; G91

    def blocks(self, block: Block, *, own: bool) -> Iterator[Block]:
        """A block in ISO's words. Raises ToolpathError for what OSP means otherwise, or alone."""
        codes = set(block.g)
        self._steps = (self._steps and 900 not in codes) or 910 in codes
        if codes & {0, 10, 20, 30, 800}:
            self._code = 0
        if _LEVEL in codes:
            if codes != {_LEVEL} or set(block.words) != {"Z"} or self._steps:
                raise ToolpathError("G71 with more than its level Z, or in G91", hint="G90, and G71 Z50 alone")
            self._level = block.words["Z"]
            return
        found = codes & _CYCLES
        if found:
            self._begin(found.pop(), block)
        elif not (self._code and _OF_HOLES & set(block.words)):
            yield _plain(block, own=own)
            return
        if self._steps or set(block.words) - _OF_HOLES:
            what = f"G{self._code // 10} of OSP in G91, or with a dwell P or words (I, J, D, L) of its own"
            raise ToolpathError(what, hint=_PLAIN)
        self._words |= {k: v for k, v in block.words.items() if k not in "XY"}
        place = {k: v for k, v in block.words.items() if k in "XY"}
        plain = _plain(block._replace(g=tuple(c for c in block.g if c not in _CYCLES), words={}), own=own)
        kept = tuple(code for code in block.m if code not in (_TO_LEVEL, _TO_R))
        yield plain._replace(m=kept, g=(*plain.g, 990, _DONE[self._code]), words=self._words | place)
        if self._rises and self._level is not None:
            yield Block(block.line, {"Z": self._level}, (0,))

    def _begin(self, code: int, block: Block) -> None:
        """A cycle's first block. Raises ToolpathError for one whose heights or steps are not known here."""
        if code not in _DONE:
            raise ToolpathError(f"G{code // 10}, a drilling cycle of OSP, is not read", hint=_PLAIN)
        if not {_TO_LEVEL, _TO_R} & set(block.m) or (_TO_LEVEL in block.m and self._level is None):
            what = "without M53 and a level by G71, or M54: it returns to the machine's upper limit"
            raise ToolpathError(f"G{code // 10}, a drilling cycle of OSP, {what}", hint="G71 Z50, and M53 in the cycle")
        self._code, self._words, self._rises = code, {}, _TO_LEVEL in block.m
        if self._rises and self._level is not None and self._level < block.words.get("R", -math.inf):
            raise ToolpathError("G71's level lies below R", hint="check G71 and R")
        height = self._state("Z")
        if self._rises and self._level is not None and height is not None and height < self._level - _EVEN:
            what = f"G{code // 10} of OSP from below G71's level: whether the tool goes up first is not known here"
            raise ToolpathError(what, hint=f"go to Z{self._level:g} before it")


def _plain(block: Block, *, own: bool) -> Block:
    """A block in ISO's words. own: HA, the tool's own length. Raises ToolpathError for what OSP means otherwise, or alone."""
    codes, words = list(block.g), dict(block.words)
    for code in block.g:
        if code in _OTHER_LENGTHS:
            raise ToolpathError(
                f"G{code // 10}, on OSP a tool's length along another axis than Z",
                hint="use G56 for the length along Z",
            )
        if code == _OFFSET:
            if "H" not in words or _LENGTH in block.g:
                raise ToolpathError("G15 without an H of its own", hint="G15 H1 names the work offset")
            codes[codes.index(code)] = 541
            words["P"] = words.pop("H")
        elif code == _LENGTH:
            if not (own or words.get("H")):
                raise ToolpathError("G56 without an H, or with H0", hint="G56 H1 names the tool's length")
            codes[codes.index(code)] = 430
        elif code == _NO_LENGTH:
            if set(words) & set("XYZABC"):
                raise ToolpathError("G53 with axes: on OSP it ends the tool's length, alone", hint="take the axes out")
            codes[codes.index(code)] = 490
        elif code not in _SAME:
            raise ToolpathError(f"G{code / 10:g} of OSP is not read", hint=_PLAIN)
    if other := next((code for code in block.m if code in _OTHER_M), 0):
        raise ToolpathError(f"M{other // 10} of OSP is not read", hint="take it out, or use M3, M4, M5, M8, M9")
    return block._replace(g=tuple(codes), words=words)


OKUMA = Control(
    "okuma",
    "Okuma's OSP",
    lambda text: 3 * bool(_MARKS.search(text)),
    _blocks,
    dialect="gcode-okuma",
    plain=True,
    suffixes=frozenset({".min"}),
)
