"""Heidenhain's tools, planes, datums and cycles, and what of them holds between statements, as blocks of ISO 6983."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.controls.heidenhain_cycles import CYCLES, REASONS, Cycle, Places, places_of
from camrob.toolpath.gcode.controls.heidenhain_feeds import Feeds
from camrob.toolpath.gcode.controls.heidenhain_old_cycles import OLD_CYCLES
from camrob.toolpath.gcode.controls.heidenhain_tangent import Heading
from camrob.toolpath.gcode.controls.heidenhain_words import (
    CALLS,
    MACHINE,
    MODES,
    SILENT,
    STARTING,
    Frames,
    Pole,
    placed,
    shifts,
    spatial,
    tool_call,
)
from camrob.toolpath.gcode.corner import Corner
from camrob.toolpath.gcode.lexer import Block, Plane

__all__ = ["HeidenhainDefined"]

_UPRIGHT = re.compile(r"19\.(?:0 .*|0|1(?: ?[ABC] ?[-+]?0*\.?0*)*)")  # a working plane that turns nothing


class HeidenhainDefined:
    """value: of a number or Q parameter; number_of: a tool's by its name; keep: a cycle gives a Q this."""

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
        self._modal = False  # M89: the cycle in force is called behind every motion
        self._corner: Corner | None = None  # at the end of the next straight cut
        self._rounded = False  # the last one has taken it

    def _lose(self, letters: str = "XYZABC") -> None:
        self._at |= dict.fromkeys(letters)
        self._heading.lost()

    # -- words -------------------------------------------------------------------------------------------------

    def _place(self, words: dict[str, str]) -> dict[str, float]:
        return placed(words, self._at, self._value)

    def _ways(self, words: dict[str, str]) -> tuple[tuple[str, str], ...]:
        """Rotary axes that go the shorter way round to a place (M126); a step goes as it says."""
        return tuple((letter, "DC") for letter in "ABC" if self._shortest and letter in words)

    def _behind(self, codes: list[int], line: int, moved: Collection[str] = ()) -> Iterator[Block]:
        """What M functions do behind a motion of the axes `moved`, or without one: M99 calls the cycle in force where the tool
        stands, M89 behind this motion and those that follow, up to M99 or another cycle (TNC 640, 9.1).
        """
        if 89 in codes and not moved:
            raise ToolpathError("M89 in a block without a place", hint="put it into the block of the first hole")
        self._modal = self._modal or 89 in codes
        if self._modal and "Z" in moved:
            raise ToolpathError(
                "a way along Z while M89 calls a cycle behind each motion", hint="end it before, by M99"
            )
        if 99 in codes or (self._modal and moved):
            self._modal = self._modal and 99 not in codes
            yield from self._drill(line)
        yield from self._codes(codes, line)

    def _codes(self, codes: list[int], line: int) -> Iterator[Block]:
        """What M functions switch."""
        if 89 in codes:
            yield Block(
                line, {}, note="M89 is taken for a cycle call behind every motion, as a machine parameter may change"
            )
        for code in codes:
            if code in MODES:
                raise ToolpathError(f"M{code} changes the path or its feed, and is not read", hint="post without it")
            if code in (126, 127):
                self._shortest = code == 126
        kept = tuple(c * 10 for c in codes if c not in SILENT | MACHINE | CALLS)
        if kept:
            yield Block(line, {}, m=kept)
            if {128, 129} & set(codes):
                self._lose("XYZ")
                self._tcp = 129 not in codes

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
            self._modal = False
            self.cycle.define(int(main), rest)
        elif main.isdigit() and int(main) in OLD_CYCLES and number != main:
            self._modal = False
            self.cycle.define_old(int(main), int(number.partition(".")[2]), rest)
        elif main in ("220", "221"):
            yield from self._drill_at(self.cycle.again(int(main), rest), line)
            self.cycle.placed()
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
        self._at["Z"] = self.cycle.left_at(self._at["Z"])
