"""Heidenhain's motions, as the blocks of ISO 6983 that they stand for."""

from __future__ import annotations

import re
from collections.abc import Iterator

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.controls.heidenhain_cycles import pattern_of
from camrob.toolpath.gcode.controls.heidenhain_defined import HeidenhainDefined
from camrob.toolpath.gcode.controls.heidenhain_words import (
    MACHINE,
    STARTING,
    Pole,
    corner_of,
    motion_words,
    offset_blocks,
    polar,
    unread,
)
from camrob.toolpath.gcode.lexer import Block
from camrob.units import INCH_MM

__all__ = ["HeidenhainMoves"]

_NOTHING_HERE = re.compile(r"BLK FORM|TOOL DEF|\*|FUNCTION MODE MILL|FUNCTION RESET|M94\b")
_TCPM = re.compile(r"FUNCTION TCPM F TCP AXIS POS(?: PATHCTRL (?:AXIS|VECTOR))?(?: REFPNT TIP-TIP| F[0-9]+)*")
_RETRACT = re.compile(r"(?:L )?((?:M[0-9]+ )*)M140 MB ?(?:MAX|[-+0-9.]+)(?: F ?[A-Z0-9.]+)?((?: M[0-9]+)*)")
_MOTION = re.compile(r"(?:L|LN|C|CR|CP|CT|LP|CYCL CALL) ")
_AWAY = re.compile(r"\bM(?:9[12]|140)\b")


class HeidenhainMoves(HeidenhainDefined):
    """Statements as blocks."""

    def corner_ahead(self, text: str) -> None:
        """Take note of the statement behind the next one: RND and CHF change how that one ends."""
        self._corner = corner_of(text, self._value)

    def blocks(self, text: str, line: int) -> Iterator[Block]:
        """The blocks that one statement stands for. Raises ToolpathError for what is not read."""
        if self._unsettled and _MOTION.match(text) and not _AWAY.search(text):
            raise ToolpathError(
                "a motion in a tilted plane whose datum shift has ended", hint="put PLANE RESET before it"
            )
        if text.startswith("BEGIN PGM"):
            yield from self._begin(text, line)
        elif text.startswith("END PGM"):
            yield Block(line, {}, m=(300,))
        elif retract := _RETRACT.fullmatch(text):
            yield from self._away(retract[1] + retract[2], line)
        elif re.match(r"(?:L|LN) ", text):
            yield from self._straight(text.partition(" ")[2], line)
        elif text.startswith("CC"):
            self._set_center(text[2:])
        elif re.match(r"(?:C|CR|CP|CT|LP) ", text):
            yield from self._round(text, line)
        elif text.startswith("TOOL CALL"):
            yield from self._tool(text[9:].strip(), line)
        elif text.startswith("PLANE"):
            yield from self._set_plane(text, line)
        elif text.startswith("CYCL DEF"):
            yield from self._define(text[8:].strip(), line)
        elif text.startswith(("TRANS DATUM AXIS ", "TRANS DATUM RESET")):
            yield from self._datum(text[17:].strip() or "X0 Y0 Z0", line)
        elif text.startswith("CYCL CALL"):
            yield from self._called(text, line)
        elif text.startswith("PATTERN DEF"):
            self._pattern = pattern_of(text[11:], self._value)
        elif _TCPM.fullmatch(text) or text.startswith("FUNCTION RESET TCPM"):
            self._tcp = "RESET" not in text
            yield Block(line, {}, m=(1280 if self._tcp else 1290,))
            self._lose("XYZ")
        elif re.fullmatch(r"STOP(?: M[0-9]+)*", text):  # the operator comes when what it switches off stands
            yield from self._codes([int(n) for n in re.findall(r"M([0-9]+)", text)], line)
            yield Block(line, {}, m=(0,))
        elif text.startswith(("RND", "CHF")):
            self._close_corner()
        elif re.fullmatch(r"M128 F ?(?:MAX|AUTO|[0-9.]+)|(?:M[0-9]+ ?)+", text):  # F: of what makes up for turning
            yield from self._behind([int(n) for n in re.findall(r"M([0-9]+)", text)], line)
        elif text.startswith("TCH PROBE"):
            raise ToolpathError(
                f"{text[:24]}: a touch probe's cycle, which measures the part", hint="measure before, and take it out"
            )
        elif not _NOTHING_HERE.match(text):
            raise unread(text)

    def _close_corner(self) -> None:
        """RND or CHF itself, which the cut before it has taken in."""
        if not self._rounded:
            raise ToolpathError(
                "RND or CHF behind no straight cut", hint="have the CAM system write the corner out as moves"
            )
        self._rounded = False

    def _begin(self, text: str, line: int) -> Iterator[Block]:
        if self._begun:
            raise ToolpathError("a second program in the same file", hint="give each program a file of its own")
        self._begun = True
        unit = text.split()[-1]
        if unit not in ("MM", "INCH"):
            raise ToolpathError("BEGIN PGM without MM or INCH", hint="export it again")
        self.cycle.mm = 1.0 if unit == "MM" else INCH_MM
        yield Block(line, {}, (210 if unit == "MM" else 200, 900, 940, 170))

    # -- motions -----------------------------------------------------------------------------------------------

    def _straight(self, text: str, line: int) -> Iterator[Block]:
        """L and LN."""
        words, codes = motion_words(text)
        if "R" in words:
            raise ToolpathError("R+ or R-: a place offset by the tool's radius", hint="post the path of its centre")
        if self._tcp and {"NX", "NY", "NZ"} & set(words) and not {"TX", "TY", "TZ"} & set(words):
            raise ToolpathError(
                "LN with a normal and no tool axis under M128", hint="post TX, TY, TZ, which say how the tool stands"
            )
        feed = self._feeds.of_motion(words, moves=any(name[-1] in "XYZABC" for name in words))
        yield from offset_blocks(words, line)
        turned = [words[k] for k in "ABC" if k in words]
        if self._plane is not None and turned and all(re.fullmatch(r"[-+]?Q12[0-2]", t) for t in turned):
            yield Block(line, {}, plane=self._plane, aligned=True)
            self._lose()
            yield from self._behind(codes, line, "ABC")
            return
        before = tuple(c for c in codes if c in (*STARTING, 126, 127, 128))
        yield from self._codes(list(before), line)
        to = self._place(words)
        vector = None
        if {"TX", "TY", "TZ"} & set(words):
            vector = tuple(self._value(words.get(k) or "0") for k in ("TX", "TY", "TZ"))
        motion = 0 if self._feeds.rapid else 10
        if codes and MACHINE & set(codes):
            yield Block(line, {**to, **feed}, (530, motion))
            self._lose("".join(to))
        elif to or vector is not None:
            corner = self._corner if motion else None
            self._rounded, self._moved = corner is not None, True
            yield Block(line, {**to, **feed}, (motion,), vector=vector, corner=corner, ways=self._ways(words))
            self._heading.straight(self._at, to, sure=motion == 10 and corner is None)
            self._at |= to
            if vector is not None:
                self._lose("ABC")
        elif feed:
            yield Block(line, feed)
        yield from self._behind([c for c in codes if c not in before], line, to)

    def _set_center(self, text: str) -> None:
        words, _ = motion_words(text.strip())
        self._pole.name(self._place(words), self._at)

    def _round(self, text: str, line: int) -> Iterator[Block]:
        """C, CR, CP, CT and LP."""
        kind, _, rest = text.partition(" ")
        words, codes = motion_words(rest)
        feed = self._feeds.of_motion(words)
        yield from offset_blocks(words, line)
        if MACHINE & set(codes):
            raise ToolpathError(f"M91 or M92 in {kind}: an arc, or a polar motion, by the machine", hint="use L for it")
        before = [c for c in codes if c in (*STARTING, 126, 127, 128)]
        yield from self._codes(before, line)
        to, pole = self._place(words), Pole() if kind in ("CR", "CT") else self._pole
        first, second = pole.letters[0], pole.letters[1]
        begun, turns = (self._at[first], self._at[second]), 1
        if kind in ("CP", "LP"):
            u, v, turns = polar(kind, words, begun, pole.place, self._value)
            to |= {first: u, second: v}
        if kind == "LP":
            motion = 0 if self._feeds.rapid else 10
            corner = self._corner if motion and pole.letters == "XY" else None
            self._rounded = corner is not None
            yield Block(line, {**to, **feed}, (motion,), corner=corner, ways=self._ways(words))
            self._heading.lost()
        else:
            sense = words.get("DR", "")[:1]
            if (sense in ("+", "-")) == (kind == "CT"):
                raise ToolpathError(f"{kind} with or without DR", hint="name the sense of C, CR and CP, and none of CT")
            if begun[0] is None or begun[1] is None or any(self._at[k] is None for k in set(to) & set("XYZ")):
                raise ToolpathError("an arc from an unknown place", hint="name X, Y and Z in an L before it")
            to = {first: begun[0], second: begun[1]} | to
            if kind == "CR":
                round_ = {"R": self._value(words["R"])} if words.get("R") else {}
            elif kind == "CT":
                (i, j), left = self._heading.arc((begun[0], begun[1]), (to[first], to[second]))
                round_, sense = {"I": i, "J": j}, "+" if left else "-"
            else:
                round_ = pole.from_here(self._at)
            self._heading.round((begun[0], begun[1]), (to[first], to[second]), round_, left=sense == "+")
            if turns > 1:
                round_["P"] = float(turns)
            sense_code = 30 if sense == "+" else 20
            yield Block(line, {**to, **round_, **feed}, (pole.code, sense_code), ways=self._ways(words))
            if pole.code != 170:
                yield Block(line, {}, (170,))
        self._at |= to
        yield from self._behind([c for c in codes if c not in before], line, to)

    def _away(self, codes: str, line: int) -> Iterator[Block]:
        """M140: the tool goes back along its axis, how far only the machine knows; `codes`: the block's other M functions."""
        numbers = [int(n) for n in re.findall(r"M([0-9]+)", codes)]
        yield from self._behind([n for n in numbers if n in STARTING], line)
        self._lose("XYZ")
        yield Block(line, {"X": 0.0, "Y": 0.0, "Z": 0.0}, (530, 0))
        yield from self._behind([n for n in numbers if n not in STARTING], line)
