"""Heidenhain's motions, tools, planes and cycle 200, as the blocks of ISO 6983 that they stand for."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.controls.heidenhain_cycles import CYCLES, REASONS, Cycle, Places, pattern_of, places_of
from camrob.toolpath.gcode.controls.heidenhain_feeds import Feeds
from camrob.toolpath.gcode.controls.heidenhain_tangent import Heading
from camrob.toolpath.gcode.controls.heidenhain_words import (
    MACHINE,
    MODES,
    SILENT,
    STARTING,
    Frames,
    Pole,
    corner_of,
    motion_words,
    offset_blocks,
    placed,
    polar,
    shifts,
    spatial,
    tool_call,
    unread,
)
from camrob.toolpath.gcode.corner import Corner
from camrob.toolpath.gcode.lexer import Block, Plane

__all__ = ["HeidenhainMoves"]

_NOTHING_HERE = re.compile(r"BLK FORM|TOOL DEF|\*|FUNCTION MODE MILL|FUNCTION RESET|M94\b")
_TCPM = re.compile(r"FUNCTION TCPM F TCP AXIS POS(?: PATHCTRL (?:AXIS|VECTOR))?(?: REFPNT TIP-TIP| F[0-9]+)*")
_MOTION = re.compile(r"(?:L|LN|C|CR|CP|CT|LP|CYCL CALL) ")
_AWAY = re.compile(r"\bM(?:9[12]|140)\b")
_UPRIGHT = re.compile(r"19\.(?:0 .*|0|1(?: ?[ABC] ?[-+]?0*\.?0*)*)")  # a working plane that turns nothing


class HeidenhainMoves:
    """Statements as blocks. value: of a number or Q parameter; number_of: a tool's by its name; keep: a cycle gives a Q this."""

    def __init__(
        self,
        value: Callable[[str], float],
        number_of: Callable[[str], float | None],
        keep: Callable[[int, float | None], None],
    ) -> None:
        self._value, self._number_of = value, number_of
        self.one_name = False  # the file names one tool, by its name, and no more
        self._at: dict[str, float | None] = dict.fromkeys("XYZABC")
        self._pole, self._heading = Pole(), Heading()
        self._feeds = Feeds(value)
        self._shift = dict.fromkeys("XYZ", 0.0)
        self._plane: Plane = None
        self._unsettled = False  # within it the datum shift has ended
        self.cycle = Cycle(self._feeds.of_cycle, keep)
        self._pattern: Places | None = None
        self._frames = Frames()
        self._preset: float | None = None  # the datum of the machine's table (247)
        self._moved = False  # the program has named a place of the part's
        self._begun = self._tcp = False
        self._shortest = False  # M126: rotary axes go the shorter way round
        self._corner: Corner | None = None  # at the end of the next straight cut
        self._rounded = False  # the last one has taken it

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
        elif text.startswith("M140"):
            yield self._away(line)
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
        yield Block(line, {}, (210 if unit == "MM" else 200, 900, 940, 170))

    def _lose(self, letters: str = "XYZABC") -> None:
        self._at |= dict.fromkeys(letters)
        self._heading.lost()

    # -- words -------------------------------------------------------------------------------------------------

    def _place(self, words: dict[str, str]) -> dict[str, float]:
        return placed(words, self._at, self._value)

    def _ways(self, words: dict[str, str]) -> tuple[tuple[str, str], ...]:
        """Rotary axes that go the shorter way round to a place (M126); a step goes as it says."""
        return tuple((letter, "DC") for letter in "ABC" if self._shortest and letter in words)

    def _behind(self, codes: list[int], line: int) -> Iterator[Block]:
        """What M functions do behind a motion, or without one: M99 calls the cycle in force where the tool stands."""
        if 99 in codes:
            yield from self._drill(line)
        yield from self._codes(codes, line)

    def _codes(self, codes: list[int], line: int) -> Iterator[Block]:
        """What M functions switch."""
        if 89 in codes:
            raise ToolpathError("M89, a modal cycle call", hint="call with M99")
        for code in codes:
            if code in MODES:
                raise ToolpathError(f"M{code} changes the path or its feed, and is not read", hint="post without it")
            if code in (126, 127):
                self._shortest = code == 126
        kept = tuple(c * 10 for c in codes if c not in SILENT | MACHINE and c != 99)
        if kept:
            yield Block(line, {}, m=kept)
            if {128, 129} & set(codes):
                self._lose("XYZ")
                self._tcp = 129 not in codes

    # -- motions -----------------------------------------------------------------------------------------------

    def _straight(self, text: str, line: int) -> Iterator[Block]:
        """L and LN."""
        if re.fullmatch(r"M140 MB ?(?:MAX|[-+0-9.]+)(?: F ?[A-Z0-9.]+)?", text):
            yield self._away(line)
            return
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
            yield from self._behind(codes, line)
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
        yield from self._behind([c for c in codes if c not in before], line)

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
        yield from self._behind([c for c in codes if c not in before], line)

    def _away(self, line: int) -> Block:
        """M140: the tool goes back along its axis, how far only the machine knows."""
        self._lose("XYZ")
        return Block(line, {"X": 0.0, "Y": 0.0, "Z": 0.0}, (530, 0))

    # -- tools, planes, cycles ---------------------------------------------------------------------------------

    def _tool(self, text: str, line: int) -> Iterator[Block]:
        call = tool_call(text, self._number_of, self._value, one_name=self.one_name)
        words = self._feeds.of_call(call)
        if call.changes:
            self._lose()
        if call.number is not None:
            yield Block(line, {"T": call.number, **words}, m=(60,))
        elif words or call.note:
            yield Block(line, words, note=call.note)

    def _set_plane(self, text: str, line: int) -> Iterator[Block]:
        if self._frames.set:
            raise ToolpathError("PLANE while cycle 8 or 10 mirrors or turns", hint="cancel that cycle before it")
        self._unsettled = False
        if text.startswith("PLANE RESET"):
            self._plane = None
            self._lose()
            moves = not re.search(r"\bSTAY\b", text)
            yield Block(line, {}, plane=None)
            if moves:  # the rotary axes go to zero
                yield Block(line, dict.fromkeys("ABC", 0.0), (0,))
            if any(self._shift.values()):
                yield Block(line, dict(self._shift), (520,))
            return
        turn, moves = spatial(text, self._value)
        self._plane = (turn, tuple(self._shift.values()))
        if any(self._shift.values()):
            yield Block(line, dict.fromkeys("XYZ", 0.0), (520,))
        yield Block(line, {}, plane=self._plane, aligned=moves)
        self._lose()

    def _define(self, text: str, line: int) -> Iterator[Block]:
        number, _, rest = text.partition(" ")
        main = number.partition(".")[0]
        if number in ("7.0", "8.0", "10.0", "11.0"):
            return  # a heading
        if main == "7":
            yield from self._datum(rest.strip(), line)
        elif main == "392":  # how fast the machine may be with its load
            self.cycle.parameters(rest)
        elif main == "32" or (self._plane is None and _UPRIGHT.fullmatch(text)):
            return
        elif main == "247":
            self._preset_by(rest)
        elif main == "9":
            time = re.search(r"([0-9]+\.?[0-9]*)\s*$", rest) if number != "9.0" else None
            if time:
                yield Block(line, {"P": float(time[1])}, (40,))
        elif main in ("8", "10", "11"):
            frame = self._frames.defined(main, rest, self._value)
            if frame is not None:
                self._at |= {"X": None, "Y": None}
                yield Block(line, {}, frame=frame, together="XY")
        elif main.isdigit() and int(main) in CYCLES:
            self.cycle.define(int(main), rest)
        elif main in ("220", "221"):
            yield from self._drill_at(self.cycle.again(int(main), rest), line)
        elif main == "19":
            raise ToolpathError(
                "CYCL DEF 19 with angles: a machine parameter says whether they are the plane's or the axes' own",
                hint="post with PLANE SPATIAL",
            )
        else:
            why = f": {REASONS[main]}" if main in REASONS else ""
            raise ToolpathError(f"CYCL DEF {number} is not read{why}", hint="have the CAM system write the motions out")

    def _preset_by(self, rest: str) -> None:
        """CYCL DEF 247: a datum of the machine's table, the same throughout."""
        number = self.cycle.parameters(rest).get(339)
        if self._moved and number != self._preset:
            raise ToolpathError(
                "another datum of the machine's table (CYCL DEF 247) behind motions: how the two lie only the machine knows",
                hint="give what belongs to each datum a program of its own",
            )
        self._preset = number

    def _datum(self, rest: str, line: int) -> Iterator[Block]:
        """CYCL DEF 7.1 X+10, or all in one."""
        found = shifts(rest)
        if self._plane is not None and all(not more and not self._value(text) for more, _, text in found):
            self._shift |= {letter: 0.0 for _, letter, _ in found if letter in self._shift}
            self._unsettled = True  # which goes first doesn't count where nothing moves before the plane's end
            return
        if (self._plane is not None or self._frames.set) and any(
            (self._value(text) if more else self._value(text) - self._shift.get(k, 0.0)) for more, k, text in found
        ):
            raise ToolpathError(
                "a datum shift in a tilted plane, or in a mirrored or turned frame",
                hint="shift before PLANE SPATIAL, cycle 8 or 10",
            )
        if self._plane is not None:
            return
        for incremental, letter, text in found:
            value = self._value(text)
            if letter in "ABC":
                if value:
                    raise ToolpathError("a datum shift of a rotary axis", hint="shift X, Y, Z only")
                continue
            before = self._shift[letter]
            self._shift[letter] = value + (before if incremental else 0.0)
            if self._at[letter] is not None:
                self._at[letter] += before - self._shift[letter]  # type: ignore[operator]
        yield Block(line, dict(self._shift), (520,))

    def _called(self, text: str, line: int) -> Iterator[Block]:
        """CYCL CALL, or CYCL CALL POS: in rapid at the second clearance, or as high as the tool stands above it."""
        codes, places = places_of(text, self._pattern, self._value)
        yield from self._codes([c for c in codes if c in STARTING], line)
        yield from self._drill(line) if places is None else self._drill_at(places, line)
        yield from self._codes([c for c in codes if c not in STARTING], line)

    def _drill_at(self, places: Places, line: int) -> Iterator[Block]:
        """The cycle in force at each place."""
        for to in places:
            up = self.cycle.level
            if self._at["Z"] is None or self._at["Z"] < up:
                yield Block(line, {"Z": up}, (0,))
                self._at["Z"] = up
            yield Block(line, to, (0,))
            self._at.update(to)
            yield from self._drill(line)

    def _drill(self, line: int) -> Iterator[Block]:
        """The cycle in force where the tool stands."""
        yield from self.cycle.drill(self._at["Z"], line, self._feeds.speed)
        yield from self._feeds.behind_cycle(line)
        self._heading.lost()
        self._at["Z"] = self.cycle.level
