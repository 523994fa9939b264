"""G-code text as blocks of words: comments off, one dictionary a block, everything that is no plain word refused."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Literal, NamedTuple

from camrob.errors import ToolpathError
from camrob.text import utf_16
from camrob.toolpath.gcode.corner import LEG, ROUND, Corner
from camrob.toolpath.gcode.program_frame import ProgramFrame

__all__ = [
    "ACCURACY",
    "POLAR_WORDS",
    "Block",
    "Plane",
    "Word",
    "assemble",
    "block_of",
    "decode",
    "lex",
    "strip_comments",
    "without_corner",
]

POLAR_WORDS = "polar words (@, ^: LinuxCNC) are not read"
_LONGEST_LINE = 10_000  # characters: real blocks stay under 256
_LARGEST = 1e9  # of any number in a block
_CONTROL = bytes(set(range(32)) - {9, 10, 13})
_NUMBER = r"[+-]?+[ \t]*+(?:[0-9]++\.?+[0-9]*+|\.[0-9]++)"  # possessive: a hostile line costs one pass
_BLOCK = re.compile(rf"(?:[A-Z][ \t]*+{_NUMBER}[ \t]*+)*+")
_WORD = re.compile(r"([A-Z])([-+.0-9]+)")
_COMMENT = re.compile(r"\(([^()]*+)\)|;(.*)")
_CORNER = re.compile(r",[ \t]*([RC])[ \t]*([0-9]++\.?[0-9]*+|\.[0-9]++)")
ACCURACY = re.compile(r"(?<=G61\.1)[ \t]*,[ \t]*K[ \t]*[0-9]++\.?+[0-9]*+")
"""How much Mazak slows at corners, a percentage behind G61.1."""
_NEWLINE = re.compile(r"\r\n|\n|\r")
_NAME = re.compile(r":[0-9]{1,8}|O?<[A-Z0-9_.+-]*>")
_LABEL = re.compile(r"N[0-9]++[ \t]*+")
_PROGRAMMING = re.compile(
    r"[#\[\]]|\bO[ \t]*+<|\b(?:WHILE|IF|GOTO|GOTOF|GOTOB|DO|END|CALL|SUB|ENDSUB|REPEAT|LOOP|FOR|ENDIF)"
)
_SHOWN = re.compile(r"M11[78](?![0-9.])(.*)")
"""What printers' controls show (Marlin, RepRapFirmware): M117 and M118 with a text."""

_SIEMENS = ((re.compile(r"\bTRAORI\b"), "M128 "), (re.compile(r"\bTRAFOOF\b"), "M129 "))
Word = tuple[str, float, bool]
"""A letter, its value, and whether it is written without a decimal point."""


Plane = tuple[tuple[float, ...], tuple[float, ...]] | None
"""A plane's axes in the part, (9,) row by row of part_R_plane, and its origin, (3,) in the program's unit; None: no plane."""


class Block(NamedTuple):
    """One block. `g` and `m` are codes in tenths (G43.4 is 434); `words` all other letters but N, as written."""

    line: int
    words: dict[str, float]
    g: tuple[int, ...] = ()
    m: tuple[int, ...] = ()
    comment: str = ""
    percent: bool = False  # a line that begins with %
    optional: bool = False  # block delete: a slash in front
    whole_p: bool = False  # the P word has no decimal point
    note: str = ""  # what a control's own word is taken for, to be said
    vector: tuple[float, ...] | None = None  # the tool's axis, tip to holder
    plane: Plane | Literal[False] = False  # a tilted plane from here on; None: none any more; False: nothing is said
    aligned: bool = False  # the control turns the tool onto that plane
    frame: ProgramFrame | None = (
        None  # a frame within it from here on, lengths in the program's unit; None: nothing is said
    )
    together: str = ""  # axes that the first block behind it has to name together
    again: bool = False  # the program would begin again here (M99 in a main program)
    corner: Corner | None = None  # at the end of its straight cut
    ways: tuple[tuple[str, str], ...] = ()  # rotary words that go their own way round: DC, ACP or ACN
    ready: float | None = None  # the tool that a second T behind the first makes ready (Mazak: T01 T02 M6)


def decode(data: bytes, path: Path) -> list[str]:
    """The lines of a G-code file: UTF-8, or Latin-1 where it is none.

    Raises ToolpathError for an empty or binary file and for a line longer than 10 000 characters.
    """
    body = data.removeprefix(b"\xef\xbb\xbf").rstrip(b"\x1a")
    if not body.strip():
        raise ToolpathError("the file is empty", hint="export it again", path=path)
    if utf_16(data):
        raise ToolpathError("the file is in UTF-16", hint="save it as plain text (ASCII or UTF-8)", path=path)
    if len(body.translate(None, _CONTROL)) != len(body):
        place = next(i for i, byte in enumerate(body) if byte in _CONTROL)
        raise ToolpathError(
            "this is binary data, not G-code text",
            hint="hand over the text file that the machine's post-processor writes (ASCII or UTF-8)",
            path=path,
            line=body.count(b"\n", 0, place) + 1,
        )
    try:
        text = body.decode("utf-8")
    except UnicodeDecodeError:
        text = body.decode("latin-1")
    lines = _NEWLINE.split(text)
    for number, line in enumerate(lines, 1):
        if len(line) > _LONGEST_LINE:
            raise ToolpathError(
                f"a line of {len(line)} characters is not a G-code block",
                hint="check the file's line ends, or export it again",
                path=path,
                line=number,
            )
    return lines


def strip_comments(text: str) -> tuple[str, str]:
    """The line without comments, and their text. Comments in comments are taken as one.

    Raises ToolpathError for a parenthesis without its partner.
    """
    if "(" not in text and ")" not in text and ";" not in text:
        return text, ""
    found: list[str] = []

    def keep(match: re.Match[str]) -> str:
        found.append((match[1] if match[1] is not None else match[2]).strip())
        return " "

    bare = _COMMENT.sub(keep, text)
    if "(" in bare or ")" in bare:
        bare, found = _nested(text)
    return bare, " ".join(found)


def _nested(text: str) -> tuple[str, list[str]]:
    """`strip_comments` for parentheses in parentheses."""
    bare: list[str] = []
    inside: list[str] = []
    depth = 0
    for place, c in enumerate(text):
        if c == ";" and depth == 0:
            inside.append(" " + text[place + 1 :])
            break
        depth += c == "("
        (inside if depth else bare).append(c)
        depth -= c == ")"
        if depth < 0:
            break
    if depth:
        raise ToolpathError("a comment's parenthesis has no partner", hint="close the comment, or remove it")
    return "".join(bare), ["".join(inside).strip("() ")]


def lex(lines: list[str], path: Path) -> Iterator[Block]:
    """The blocks of a program, in order; blank lines are left out.

    Raises ToolpathError with its line for whatever is not a letter followed by a plain number.
    """
    for number, raw in enumerate(lines, 1):
        text = raw.strip()
        if not text:
            continue
        try:
            yield block_of(text, number)
        except ToolpathError as error:
            raise error.at(path, number) from None


def block_of(text: str, line: int) -> Block:
    """One line that is not blank as a block. Raises ToolpathError for whatever is not a letter followed by a plain number."""
    if text[0] == "%":
        return Block(line, {}, percent=True)
    bare, comment = strip_comments(text)
    if not bare.isascii():
        raise ToolpathError("a character that no G-code block has", hint="put operator text in parentheses")
    bare = bare.strip().upper()
    optional = bare[:1] == "/"
    if optional:
        bare = bare[1:].lstrip("0123456789 \t") if bare[1:2].isdigit() else bare[1:].lstrip()
    if _NAME.fullmatch(bare):  # a program's name or number, written otherwise
        bare = "O" + (bare[1:] if bare[0] == ":" else "0")
    bare, corner = without_corner(bare)
    if not _BLOCK.fullmatch(bare):
        said = _LABEL.sub("", bare, count=1).strip()
        if said == "MSG":
            return Block(line, {}, comment="MSG," + comment.strip('"'))
        if shown := _SHOWN.fullmatch(said):
            return Block(line, {}, comment="MSG," + shown[1].strip())
        for pattern, code in _SIEMENS:
            bare = pattern.sub(code, bare)
        if not _BLOCK.fullmatch(bare):
            raise _unreadable(bare)
    block = _words(bare.replace(" ", "").replace("\t", ""), line, comment, optional)
    return block if corner is None else block._replace(corner=corner)


def without_corner(bare: str) -> tuple[str, Corner | None]:
    """A block without Fanuc's ,R or ,C, and the corner that these ask for."""
    if "," in bare:
        bare = ACCURACY.sub("", bare)
    match = _CORNER.search(bare) if "," in bare else None
    if match is None:
        return bare, None
    size = float(match[2])
    corner = Corner(ROUND if match[1] == "R" else LEG, size) if size else None
    return (bare[: match.start()] + bare[match.end() :]).strip(), corner


def _words(bare: str, line: int, comment: str, optional: bool) -> Block:
    """The block of a line that is known to hold words only, without blanks."""
    found = [(letter, float(digits), "." not in digits) for letter, digits in _WORD.findall(bare)]
    return assemble(found, line, comment, optional)


def assemble(found: Iterable[Word], line: int, comment: str = "", optional: bool = False) -> Block:
    """The block of these words. Raises ToolpathError for a word that is said twice or out of all proportion."""
    words: dict[str, float] = {}
    g: list[int] = []
    m: list[int] = []
    whole_p = False
    tools: list[float] = []
    for letter, value, is_whole in found:
        if not -_LARGEST < value < _LARGEST:
            raise ToolpathError(f"{letter}{value:.6g} is out of all proportion", hint="check the exported number")
        if letter == "G":
            g.append(_code("G", value))
        elif letter == "M":
            m.append(_code("M", value))
        elif letter == "N":
            if g or m or words.keys() - {"O"}:
                raise ToolpathError(
                    f"N{value:g} behind other words: a jump, a call or how often to repeat on some controls (Fagor, NUM)",
                    hint="put a block's number in front, or have the CAM system write the path out",
                )
        elif letter == "T" and len(tools) < 2:
            tools.append(value)
            words.setdefault("T", value)
        elif letter in words:
            if 62 in g:
                raise ToolpathError("a NURBS curve (G6.2)", hint="export lines and arcs")
            raise ToolpathError(f"the word {letter} appears twice in one block", hint="split the block")
        else:
            words[letter] = value
            whole_p = whole_p or (letter == "P" and is_whole)
    if len(tools) > 1 and 60 not in m:
        raise ToolpathError("the word T appears twice in one block", hint="split the block")
    if 1870 in g:  # Haas: how smoothly the path is run, G187 P2 E0.05
        words.pop("E", None)
    if "E" in words and {670, 680} & set(m):  # LinuxCNC: an analog output, E its number and Q its value
        words = {letter: value for letter, value in words.items() if letter not in "EQ"}
    if "E" in words:
        raise ToolpathError(
            "an E word (a fixture offset on Fadal's controls, the filament of a printer), or a number with an exponent",
            hint="export plain decimal numbers; post for Fanuc",
        )
    ready = tools[1] if len(tools) > 1 else None
    return Block(line, words, tuple(g), tuple(m), comment, False, optional, whole_p, ready=ready)


def _code(letter: str, value: float) -> int:
    """A G or M number in tenths."""
    tenths = round(value * 10.0) if 0.0 <= value < 10_000.0 else -1  # a number of 308 digits times ten is no number
    if abs(tenths - value * 10.0) > 1e-6 or not 0 <= tenths < 100_000:
        raise ToolpathError(f"{letter}{value:g} is not a {letter} code", hint="check the block")
    return tenths


def _unreadable(bare: str) -> ToolpathError:
    """Why a line is not a plain block, as an error to be raised."""
    if _PROGRAMMING.search(bare):
        return ToolpathError(
            "variables, expressions, loops and subprograms (#, [ ], O-words, WHILE, IF) are not read",
            hint="have the CAM system or a G-code expander write the path out as plain blocks",
        )
    if "=" in bare:
        return ToolpathError(
            "an assignment (=) is not read", hint="have the post-processor write plain words like X10.5"
        )
    match = _BLOCK.match(bare)
    rest = bare[match.end() if match else 0 :]
    if re.match(r",[ \t]*[RC]", rest):
        return ToolpathError(
            "a rounded or chamfered corner (,R or ,C) is not read",
            hint="have the CAM system write the corner out as moves",
        )
    if rest[:1] == ",":
        return ToolpathError(f"a comma in a number ({rest[:12]!r})", hint="write decimals with a point")
    if rest[:1] in ("@", "^"):
        return ToolpathError(POLAR_WORDS, hint="write the points out in X and Y")
    if bare[:1] in ("$", "?", "!", "~"):
        return ToolpathError(
            f"{rest[:16]!r} is a command to the control itself (Grbl), no block of a program", hint="take it out"
        )
    if re.match(r"E[A-Z][-+.0-9]", rest):
        return ToolpathError(
            f"{rest[:2]} in {rest[:16]!r}: a word of NUM's controls, which is not read",
            hint="post for Fanuc, or write the moves out",
        )
    if re.match(r"G[ \t]+[XYZ]", rest):
        return ToolpathError(
            f"G without a number in {rest[:16]!r}: G0 on some controls (Selca)", hint="write the number"
        )
    if rest[:1].isalpha() and not re.match(r"[A-Z][ \t]*[-+.0-9]", rest):
        return ToolpathError(
            f"no number follows {rest[:1]} in {rest[:16]!r}", hint="every word is a letter and a number"
        )
    return ToolpathError(
        f"{rest[:16]!r} is not a G-code word", hint="every word is a letter and a plain decimal number"
    )
