"""Words of Siemens' that need no reading: those that move nothing, and those that are refused, with what they are."""

from __future__ import annotations

import re

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.corner import BASE, LEG, ROUND, Corner

__all__ = [
    "CODES",
    "CORNERS",
    "REFUSED",
    "REFUSED_G",
    "SILENT_CALLS",
    "SILENT_G",
    "cornered",
    "fixed_point",
    "keyword_of",
    "no_word",
    "with_brackets",
]

CORNERS = {"RND": ROUND, "CHR": LEG, "CHF": BASE}
CODES = {70: 20, 700: 20, 71: 21, 710: 21}  # inch and metric
# how fast and how exactly the path is run, compressors, feed forward: not where it goes
SILENT_G = frozenset((9, 60, 64, 450, 451, 601, 602, 603, 641, 642, 643, 644, 645, 460, 461, 462, 290, 94.1))
_SILENT = frozenset(
    "SOFT BRISK DRIVE FFWON FFWOF COMPON COMPOF COMPCURV COMPCAD COMPSURF UPATH SPATH CUT2D CUT2DF STOPRE DYNNORM DYNPOS "
    "DYNROUGH DYNSEMIFIN DYNFINISH DYNPREC ORIWKS ORIMKS ORIAXES ORIVECT ORIPLANE ORISON ORISOF CDOF CDOF2 CDON WALIMON WALIMOF "
    "RTLION RTLIOF CFIN CFC CFTCP DIAMOF FENDNORM PTPG0 SAVE DISPLOF ADISPOS KONT NORM SBLON SBLOF FNORM "
    "FIFOCTRL TOFFOF CUTCONOF TCOFR TCOABS".split()
)
_DONE = ("TRAORI", "TRAFOOF", "SUPA", "RET", "CIP", "CT")
SILENT_CALLS = frozenset(
    "CYCLE832 FGROUP FGREF MSG GROUP_BEGIN GROUP_END GROUP_ADDEND WORKPIECE EXTERN WRITE SETMS".split()
)
# threads, limits, a turned table's centring, soft approaches
REFUSED_G = frozenset((5, 7, 25, 26, 33, 63, 147, 148, 247, 248, 291, 331, 332))
REFUSED = {
    "ROT": "a turned frame (ROT about X or Y)",
    "AROT": "a turned frame (AROT about X or Y)",
    "CASE": "a branch by CASE",
    "RNDM": "rounding of all corners (RNDM)",
    "FB": "a feed of one block (FB)",
    "FRC": "a feed of corners (FRC)",
    "FRCM": "a feed of corners (FRCM)",
    "ROTS": "a turned frame (ROTS)",
    "CROTS": "a turned frame",
    "AROTS": "a turned frame",
    "RPL": "a turned frame",
    "MIRROR": "mirroring",
    "AMIRROR": "mirroring",
    "SCALE": "scaling",
    "ASCALE": "scaling",
    "BSPLINE": "a spline",
    "ASPLINE": "a spline",
    "CSPLINE": "a spline",
    "POLY": "a polynomial",
    "CUT3DC": "3-D cutter compensation",
    "CUT3DF": "3-D cutter compensation",
    "CUT3DFF": "3-D cutter compensation",
    "CUT3DFS": "3-D cutter compensation",
    "CUT3DCC": "3-D cutter compensation",
    "TRANSMIT": "polar transformation",
    "TRACYL": "a cylinder's surface",
    "ORIRPY": "orientation by angles",
    "ORIRPY2": "orientation by angles",
    "ORIEULER": "orientation by angles",
    "ORIVIRT1": "orientation by angles",
    "ORIVIRT2": "orientation by angles",
    "ORIPATH": "orientation against the path",
    "ORIPATHS": "orientation against the path",
    "ORICURVE": "orientation by a second curve",
    "DIAMON": "diameter programming",
    "ORICONCW": "orientation on a cone",
    "ORICONCCW": "orientation on a cone",
    "ORICONIO": "orientation on a cone",
    "ORICONTO": "orientation on a cone",
    "DIAM90": "diameter programming",
    "TOROT": "a frame from the tool (TOROT)",
    "TOROTOF": "a frame from the tool (TOROTOF)",
    "TOFRAME": "a frame from the tool",
    "PAROT": "a frame from the workpiece",
    "PTP": "axis motion (PTP)",
    "TCARR": "a tool carrier (TCARR)",
    "TOFFON": "a tool length by a variable",
    "OFFN": "an offset of the contour (OFFN)",
    "ISD": "3-D cutter compensation (ISD)",
    "OEMIPO1": "an interpolation of the maker's",
    **dict.fromkeys(("A2", "B2", "C2"), "the tool's axis by angles (A2=, B2=, C2=)"),
    **dict.fromkeys(("A4", "B4", "C4", "A5", "B5", "C5"), "the tool's axis by the surface's normal"),
    **dict.fromkeys(("LEAD", "TILT"), "the tool's axis against the path (LEAD=, TILT=)"),
}
_GIVEN = frozenset("A2 B2 C2 A4 B4 C4 A5 B5 C5 LEAD TILT".split())  # with an equals sign: A2.5 is an angle of A


_FIXED = re.compile(r"\bG7[45](?![0-9])")


def with_brackets(text: str) -> str:
    """A call of CYCLE800 or CYCLE832 without parameters, which needs no brackets."""
    return f"{text}()" if text in ("CYCLE800", "CYCLE832") else text


def fixed_point(text: str) -> str:
    """The block that G74 or G75 stands for, "" for others: in rapid to a place of the machine, whatever its words' values."""
    if not _FIXED.search(text):
        return ""
    rest = re.sub(r"\b(?:FP|POS)=[0-9]+", "", _FIXED.sub("", text))
    return "G0 SUPA " + re.sub(r"([XYZABC])1=", r"\1=", rest)


def cornered(name: str, value: float, before: Corner | None) -> Corner | None:
    """The corner that RND, CHR or CHF makes, of a block that has `before` already; None for one without a size."""
    if value < 0.0 or before is not None:
        raise ToolpathError(f"{name}={value:g}: no corner, or one of two", hint="check the block")
    return Corner(CORNERS[name], value) if value else None


def keyword_of(rest: str) -> str:
    """The longest keyword that stands here, "" where none does. Raises ToolpathError for a word that nobody knows."""
    names = [k for k in (*_SILENT, *REFUSED, *_DONE) if _stands(k, rest)]
    name = max(names, key=len, default="")
    whole_word = re.match(r"[A-Z_]{3,}[A-Z0-9_]*", rest)
    if not name and whole_word and not re.match(r"(?:TURN|RND|CHR|CHF|ANG)=", rest):
        raise ToolpathError(
            f"{whole_word[0]} is not known here: a subprogram that is not in this file, or a word of the control",
            hint="append the subprogram behind a line %_N_NAME_SPF, or have the post-processor write plain blocks",
        )
    return name if len(name) > 1 else ""


def _stands(word: str, rest: str) -> bool:
    """Whether the word begins `rest`, and no longer one does."""
    if word in _GIVEN:
        return rest.startswith(f"{word}=")
    return rest.startswith(word) and not re.match(r"[A-Z0-9_]*[A-Z_](?![-+=.0-9])|[0-9]", rest[len(word) :])


def no_word(rest: str) -> ToolpathError:
    """Why a block's rest begins with no word, as an error to be raised."""
    if rest.startswith("$"):
        name = re.split(r"[\[=(, ]", rest, maxsplit=1)[0]
        return ToolpathError(f"{name}, a variable of the control's own: the machine's state", hint="post without it")
    return ToolpathError(f"{rest[:16]!r} is not a word of a block", hint="check the block")
