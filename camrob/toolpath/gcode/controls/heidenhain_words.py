"""The words of Heidenhain's motions, what R0, RL and RR among them ask for, and the frames of its cycles 8 and 10."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.corner import LEG, ROUND, Corner
from camrob.toolpath.gcode.lexer import Block
from camrob.toolpath.gcode.program_frame import PLAIN, ProgramFrame, euler, mirrored, turned
from camrob.units import deg_to_rad, rad_to_deg

__all__ = [
    "CALLS",
    "MACHINE",
    "MODES",
    "SILENT",
    "STARTING",
    "VALUE",
    "Frames",
    "Pole",
    "ToolCall",
    "corner_of",
    "motion_words",
    "offset_blocks",
    "placed",
    "polar",
    "shifts",
    "spatial",
    "tool_call",
    "unread",
]

MACHINE = frozenset((91, 92))
"""M functions whose block names positions of the machine."""
CALLS = frozenset((89, 99))
"""M functions that call a cycle."""
STARTING = frozenset((3, 4, 13, 14, 8, 7))
"""M functions that act before a motion."""
SILENT = frozenset((94, 116, 117, 120, 124, 126, 127, 134, 135, 137, 138, 107, 108, 25, 26))
"""M functions that say how the control runs the path, or which way round a rotary axis goes in rapid."""
MODES = frozenset((97, 98, 101, 102, 103, 109, 110, 111, 118, 130, 136, 140, 141, 143, 144, 145, 148, 149, 197))
"""M functions that change the path or its feed."""

VALUE = r"[-+]?(?:[0-9.]+|Q[LR]?[0-9]+)"
"""A number or a parameter, as a pattern."""

_WORD = re.compile(
    r"(I?PA|I?PR|I?[XYZABC]|[NT][XYZ]|DR(?=[-+]?(?: |$|[A-Z]))|FMAX|F AUTO|F[UZ]|F|M|R0(?![0-9.])|RL|RR|R(?=[-+0-9Q])|R(?= |$)|S)"
    r" ?([-+]?(?:Q[LR]?[0-9]+|[0-9]*\.?[0-9]+\.?)|[-+](?= |$|[A-Z]))? ?"
)


_CORNER = re.compile(rf"(RND R|CHF) ?({VALUE})(?: F ?({VALUE}))?")
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
        if name in ("R", "F", "M") and not value:
            continue  # left empty: compensation and feed stay as they are, and there is no function
        if name == "M" and not value.isdigit():
            raise ToolpathError(f"M{value} is not an M function", hint="check the block")
        if name == "M":
            codes.append(int(value))
            if value == "140":
                raise ToolpathError("M140 in a motion", hint="give it a block of its own")
        elif name == "F" and 103 in codes:
            raise ToolpathError("M103 F changes the feed of plunges, and is not read", hint="post without it")
        elif name in words:
            raise ToolpathError(f"the word {name} appears twice in one block", hint="split the block")
        else:
            words[name] = value
    return words, codes


def placed(words: dict[str, str], at: dict[str, float | None], value: Callable[[str], float]) -> dict[str, float]:
    """X, Y, Z, A, B, C of a motion, absolute; `at`: where it begins. Raises ToolpathError for steps from an unknown place."""
    out: dict[str, float] = {}
    for name, text in words.items():
        letter = name[-1]
        if name not in (letter, f"I{letter}") or letter not in "XYZABC":
            continue
        if not text:
            raise ToolpathError(f"{name} without a number", hint="check the block")
        to = value(text)
        if name[0] == "I":
            before = at.get(letter)
            if before is None:
                raise ToolpathError(f"{name} from a place that is not known", hint=f"name {letter} before it")
            to += before
        out[letter] = to
    return out


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


class Pole:
    """The centre that CC names, and the plane in which circles and polar motions run by it: X/Y, Y/Z or Z/X, whose angles count
    from the first of the two to the second (TNC 640, 6.5). `letters`: its axes; `place`: None as long as none is named.
    """

    def __init__(self) -> None:
        self.letters = "XY"
        self.place: tuple[float, float] | None = None

    @property
    def code(self) -> int:
        """The plane as a G code in tenths."""
        return {"XY": 170, "YZ": 190, "ZX": 180}[self.letters]

    def name(self, to: dict[str, float], at: dict[str, float | None]) -> None:
        """CC; alone it is where the program has sent the tool last. Raises ToolpathError where an axis is not known."""
        if not to and self.letters == "XY":
            to = {letter: value for letter in "XY" if (value := at[letter]) is not None}
        letters = next((pair for pair in ("XY", "YZ", "ZX") if set(to) == set(pair)), self.letters)
        if not to or not set(to) <= set(letters):
            raise ToolpathError(
                "a centre (CC) of no plane, or where the tool is not known to be", hint="name two of X, Y and Z"
            )
        old = self.place if self.place and letters == self.letters else (None, None)
        first, second = (to.get(letter, value) for letter, value in zip(letters, old, strict=True))
        if first is None or second is None:
            raise ToolpathError("a centre (CC) of which only one axis is known", hint="name two of X, Y and Z")
        self.letters, self.place = letters, (first, second)

    def from_here(self, at: dict[str, float | None]) -> dict[str, float]:
        """I, J, K of an arc that begins at `at`. Raises ToolpathError where no centre is named."""
        if self.place is None:
            raise ToolpathError("a circle without a centre", hint="put CC before it")
        return {
            "IJK"["XYZ".index(letter)]: value - (at[letter] or 0.0)
            for letter, value in zip(self.letters, self.place, strict=True)
        }


def polar(
    kind: str,
    words: dict[str, str],
    at: tuple[float | None, float | None],
    pole: tuple[float, float] | None,
    value: Callable[[str], float],
) -> tuple[float, float, int]:
    """Where CP or LP ends in the plane of the pole, and the turns that it takes, the broken one included; `at`: where it begins.

    Raises ToolpathError where pole, beginning or angle is not known.
    """
    if pole is None:
        raise ToolpathError(f"{kind} without a pole", hint="put CC before it")
    (x, y), (cx, cy) = at, pole
    if (x is None or y is None) and not ("PA" in words and "PR" in words):
        raise ToolpathError(f"{kind} from an unknown place", hint="name X and Y before it")
    here = 0.0 if x is None or y is None else rad_to_deg(math.atan2(y - cy, x - cx))
    radius = value(words["PR"]) if words.get("PR") else math.hypot((x or 0.0) - cx, (y or 0.0) - cy)
    if words.get("IPR"):
        radius += value(words["IPR"])
    if kind == "CP" and {"PR", "IPR"} & set(words):
        raise ToolpathError("CP with PR", hint="CP keeps the radius of its start")
    turns = 1
    if "IPA" in words:
        way = value(words["IPA"])
        angle = here + way
        if kind == "CP":
            sense = words.get("DR", "")[:1]
            if way and (way > 0.0) != (sense == "+"):
                raise ToolpathError("CP with IPA and DR of two senses", hint="check the block")
            turns = max(1, math.ceil(abs(way) / 360.0 - 1e-9))  # degrees of a turn
    elif "PA" in words:
        angle = value(words["PA"])
        if kind == "CP" and abs(angle) > 360.0:  # degrees: whether full turns are meant
            raise ToolpathError("CP with PA beyond a full turn", hint="use IPA")
    else:
        raise ToolpathError(f"{kind} without PA", hint="name the angle")
    a = deg_to_rad(angle)
    return cx + radius * math.cos(a), cy + radius * math.sin(a), turns


def offset_blocks(words: dict[str, str], line: int) -> Iterator[Block]:
    """R0, RL and RR as G40, G41 and G42."""
    for word, code in (("R0", 400), ("RL", 410), ("RR", 420)):
        if word in words:
            yield Block(line, {}, (code,))


def shifts(text: str) -> list[tuple[str, str, str]]:
    """A datum shift's steps ("I" or nothing), axes and values. Raises ToolpathError for one that says more than these."""
    if "#" in text:
        raise ToolpathError("a datum of the machine's table", hint="shift by X, Y, Z")
    if re.fullmatch(rf"(?:I?[XYZABC] ?{VALUE} ?)*", text) is None:
        raise ToolpathError(f"a datum shift by {text[:24]!r} is not read", hint="shift by X, Y, Z")
    return re.findall(rf"(I?)([XYZABC]) ?({VALUE})", text)


def spatial(text: str, value: Callable[[str], float]) -> tuple[tuple[float, ...], bool]:
    """The turn of PLANE SPATIAL, row by row, and whether the rotary axes go along. Raises ToolpathError for other planes."""
    match = re.match(rf"PLANE SPATIAL ((?:SP[ABC] ?{VALUE} ?){{3}})(.*)$", text)
    if match is None:
        raise ToolpathError(f"{text[:24]!r} is not read", hint="post with PLANE SPATIAL SPA SPB SPC")
    angles = {k: deg_to_rad(value(v)) for k, v in re.findall(rf"SP([ABC]) ?({VALUE})", match[1])}
    if re.search(r"\bCOORD ROT\b|\bTABLE ROT\b", match[2]) is None and set(angles) != set("ABC"):
        raise ToolpathError("PLANE SPATIAL without its three angles", hint="name SPA, SPB and SPC")
    rotation = euler("321", (angles["C"], angles["B"], angles["A"]))
    return tuple(rotation.ravel().tolist()), not re.search(r"\bSTAY\b", match[2])


class ToolCall(NamedTuple):
    """What TOOL CALL says: `changes` the tool or only speed and feed; `number` None where it is the set-up's (`note`)."""

    changes: bool
    number: float | None
    speed: float | None
    feed: float | None
    note: str = ""


_CALLED = re.compile(rf"(?: ?(?:[XYZ]\b|[SF] ?{VALUE}|F[UZ] ?{VALUE}|D[LR]2? ?{VALUE}))*")


def tool_call(
    text: str, number_of: Callable[[str], float | None], value: Callable[[str], float], *, one_name: bool
) -> ToolCall:
    """What stands behind TOOL CALL; `number_of` is the set-up's by a tool's name, `value` what a number or parameter is worth.

    Raises ToolpathError for offsets, other tool axes, and one of several names that the set-up doesn't have.
    """
    match = re.match(r'("[^"]*"|Q[LR]?[0-9]+|[0-9]+(?:\.[0-9]+)?)?', text)
    name = match[0] if match else ""
    rest = text[len(name) :]
    if _CALLED.fullmatch(rest) is None:
        raise ToolpathError(f"TOOL CALL {text[:40]} is not read", hint="name the tool, Z, S and F")
    for key, given in re.findall(rf"\b(D[LR]2?) ?({VALUE})", rest):
        if value(given):
            raise ToolpathError(
                f"TOOL CALL with {key}{given}: an offset of the path", hint="put it into the CAM system"
            )
    axis = re.search(r" ([XYZ])\b", f" {rest.strip()}")
    if axis and axis[1] != "Z":
        raise ToolpathError(f"a tool along {axis[1]}", hint="post with the tool along Z")
    if per := re.search(r"\bF[UZ]", rest):
        raise ToolpathError(
            f"TOOL CALL with {per[0]}: a feed per tooth or per turn for all that follows",
            hint="post the feed in mm/min",
        )
    speed, feed = (
        None if found is None else value(found[1])
        for found in (re.search(rf"\b{letter} ?({VALUE})", rest) for letter in "SF")
    )
    number: float | None = None
    note = ""
    if name.startswith('"') and not name.strip('"').isdigit():
        number = number_of(name.strip('"'))
        if number is None and not one_name:
            raise ToolpathError(
                f"TOOL CALL {name[:40]}: several tools by their names",
                hint="give each a [[tool]] with its number and this name in setup.toml, or call them by numbers",
            )
        if number is None:
            note = f"TOOL CALL {name[:40]} is the file's only tool: it is taken for the one of the set-up"
    elif name:
        number = value(name.strip('"'))
    return ToolCall(bool(name), number, speed, feed, note)


_MIRRORED = re.compile(r"(?:[XYZ](?: |$))*")
_ANGLE = re.compile(rf"(I?)ROT ?({VALUE})")
_SCALE = re.compile(rf"SCL ?({VALUE})")


class Frames:
    """Cycles 8 (mirror) and 10 (rotation), about the datum that cycle 7 has shifted (TNC 640, "Machining Cycles").

    One of them at a time, since of both the order would count.
    """

    def __init__(self) -> None:
        self._letters = ""
        self._angle = 0.0

    @property
    def set(self) -> bool:
        """Whether either is in force."""
        return bool(self._letters or self._angle)

    def defined(self, cycle: str, rest: str, value: Callable[[str], float]) -> ProgramFrame | None:
        """The frame from CYCL DEF 8.1, 10.1 or 11.1 on, None where nothing changes. Raises ToolpathError for what is not read."""
        rest = rest.strip()
        if cycle == "8" and _MIRRORED.fullmatch(rest):
            return self._change("".join(rest.split()), self._angle)
        if cycle == "10" and (match := _ANGLE.fullmatch(rest)):
            return self._change(self._letters, value(match[2]) + (self._angle if match[1] else 0.0))
        if cycle == "11" and (match := _SCALE.fullmatch(rest)) and value(match[1]) == 1.0:
            return None
        raise ToolpathError(
            f"CYCL DEF {cycle}.1 {rest[:16]} is not read", hint="have the CAM system mirror, turn or scale the path"
        )

    def _change(self, letters: str, angle: float) -> ProgramFrame | None:
        if (letters, angle) == (self._letters, self._angle):
            return None
        if letters and angle:
            raise ToolpathError("cycles 8 and 10 at once: which comes first", hint="have the CAM system do one of them")
        self._letters, self._angle = letters, angle
        if not self.set:
            return PLAIN
        return ProgramFrame(mirrored(letters) if letters else turned(deg_to_rad(angle)), np.zeros(3))


def unread(text: str) -> ToolpathError:
    """That a statement is not read, and where that can be told why, as an error to be raised."""
    why, cure = "", "have the CAM system write the motions out"
    if re.match(r"(?:APPR|DEP) ", text):
        why = ": the way onto or off a contour that the control offsets by the tool's radius"
        cure = "have the CAM system write the path of the tool's centre, with its way in and out"
    return ToolpathError(f"{text[:28]!r} is not read{why}", hint=cure)
