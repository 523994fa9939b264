"""Words that no code of their block takes, and by which other controls move or limit the spindle: refused, not passed over."""

from __future__ import annotations

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.cycles import CYCLES
from camrob.toolpath.gcode.lexer import Block

__all__ = ["refuse_strays"]

_LINES = (None, 0, 10)  # motions of a block, in tenths: none yet, G0, G1
_ARCS = (20, 30)
# Codes that take no R, Q, I, J, K: planes, units, dimensions, feed modes, return levels, work offsets, tool length
_PLAIN = frozenset(
    (0, 10, 20, 30, 170, 180, 190, 200, 210, 430, 440, 490, *range(540, 600, 10), 900, 910, 940, 950, 980, 990)
)
_LIMITS = frozenset((250, 260, 500, 920))  # G50 S, G92 S (lathes, Mitsubishi), G25 S, G26 S
_SHIFTS = frozenset((520, 590))
_AREAS = frozenset((220, 250, 260))
_PLACES = frozenset("XYZABCIJKUVW")
_AXES = frozenset("XYZABC")
_ASKED = frozenset("RQIJKSLP")


def refuse_strays(block: Block, motion: int | None, *, vectors: bool, numbered: bool) -> None:
    """Raises ToolpathError for such words; motion: the code in force, in tenths; vectors: I, J, K are the tool's axis (G43.5).

    numbered: the file begins with % and a number, as NUM's do.
    """
    words = block.words
    if numbered and not _SHIFTS.isdisjoint(block.g) and not _AXES.isdisjoint(words):
        raise ToolpathError(
            "G52 or G59 with axes in a file that begins as NUM's do: places of the machine, or a shift there",
            hint="take it out, or begin the file with % alone where it is not NUM's",
        )
    if 80 in block.g and "P" not in words and not _AXES.isdisjoint(words):
        raise ToolpathError(
            "G8 with axes: an arc that goes on from the way before it on Fagor's controls", hint="export arcs as G2, G3"
        )
    if 490 in block.g and words.keys() >= {"X", "Y", "Z"} and not {0, 10, *_ARCS} & set(block.g):
        raise ToolpathError(
            "G49 with X, Y and Z and no G0 or G1: an inclined plane on Fagor's controls, a move to there on others",
            hint="name the motion in the block, or take G49 out",
        )
    if not _AREAS.isdisjoint(block.g) and not _PLACES.isdisjoint(words):
        raise ToolpathError(
            "G22, G25 or G26 with axes: they fence the working area and move nothing (Fanuc, Siemens), which is not read",
            hint="take the block out",
        )
    if vectors or _ASKED.isdisjoint(words):
        return
    if "S" in words and not _LIMITS.isdisjoint(block.g):
        raise ToolpathError(
            "S in a block of G25, G26, G50 or G92: a limit of the spindle's speed (Fanuc), or its speed (Mach, Grbl)",
            hint="take it out where it is a limit, and name the speed by S in a block of its own",
        )
    if motion in CYCLES and not {"I", "J"}.isdisjoint(words):
        raise ToolpathError(
            "I or J in a drilling cycle: bites that get shorter (Haas), a shift or a chip break on other controls",
            hint="bite by Q, or have the CAM system write the moves out",
        )
    if block.m or not _PLAIN.issuperset(block.g):
        return
    if ("L" in words and motion not in CYCLES) or (words.keys() <= {"P", "N"} and "P" in words and not block.g):
        raise ToolpathError(
            "L or P in a block that has no use for it: a subprogram is called (Siemens' L10 P3), or a block repeated",
            hint="append the subprogram as that control has it, or have the path written out as plain blocks",
        )
    strange = set(words) & set("RQIJK" if motion in _LINES else "Q" if motion in _ARCS else "")
    if motion == 10 and not _AXES.isdisjoint(words):
        strange &= {"Q"}  # the others are refused as a corner
    if strange:
        raise ToolpathError(
            f"{', '.join(sorted(strange))} of a block that has no use for it: on some controls (Fagor) a place in polar "
            "coordinates by R and Q, or about I and J",
            hint="export X, Y, Z, or take the word out where it means nothing",
        )
