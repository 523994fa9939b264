"""The words of a Siemens block, as the blocks of ISO 6983 that they stand for."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.controls.control import State
from camrob.toolpath.gcode.controls.siemens_cycles import CYCLES, NOT_DONE, TAPS, Hole, hole_of
from camrob.toolpath.gcode.controls.siemens_frames import PART, Frame, swivel
from camrob.toolpath.gcode.controls.siemens_grammar import GRAMMAR, signed
from camrob.toolpath.gcode.controls.siemens_patterns import PATTERNS, places
from camrob.toolpath.gcode.controls.siemens_shapes import KEYS, Shapes
from camrob.toolpath.gcode.controls.siemens_vocabulary import (
    CODES,
    CORNERS,
    REFUSED,
    REFUSED_G,
    SILENT_CALLS,
    SILENT_G,
    cornered,
    fixed_point,
    keyword_of,
    no_word,
    with_brackets,
)
from camrob.toolpath.gcode.corner import Corner
from camrob.toolpath.gcode.language.formulas import Reader, whole
from camrob.toolpath.gcode.lexer import Block, Word, assemble
from camrob.units import INCH_MM

__all__ = ["SiemensWords"]

_TOLERANCE = re.compile(r"\b(?:[CO]TOL|ADIS(?:POS)?)=[-+0-9.]+")  # of the compressor, and of smoothed corners
_CALL = re.compile(r"([A-Z_][A-Z0-9_]*)\(")
_NAME = re.compile(r"[A-Z_][A-Z0-9_]*")
_ADDRESS = re.compile(rf"((?:A3|B3|C3|CR|TURN|S1|M1|RND|CHR|CHF|{'|'.join(KEYS)})(?==)|[A-Z])(=)?")
_FRAME = re.compile(r"(A?(?:TRANS|ROT|MIRROR|SCALE))(?=$|[ XYZ])(?!MIT)")


class SiemensWords:
    """Turns blocks of words into ISO's. `one_name`: the file names one tool, and no more; `moved`: a block has given axes."""

    grammar = GRAMMAR

    def __init__(self, reader: Callable[[str], Reader], state: State) -> None:
        self._reader, self._state = reader, state
        self.one_name = False
        self.moved = False
        self._goes = False  # the block moves axes
        self._hole: Hole | None = None  # MCALL
        self._frame = Frame()
        self._swivelled = False  # CYCLE800
        self._shapes = Shapes(state)

    def number_of(self, name: str) -> float | None:
        """The number of the set-up's tool of that name."""
        return self._state(f"tool {name}")

    def blocks(self, text: str, line: int, *, optional: bool) -> Iterator[Block]:
        """The blocks that one block of words stands for. Raises ToolpathError for what is not read."""
        text = with_brackets(_TOLERANCE.sub("", text).strip())
        if text == "MCALL":
            self._hole = None
            return
        modal = text.startswith("MCALL ")
        text = text.removeprefix("MCALL ")
        call = _CALL.match(text)
        if call and call[1] in NOT_DONE:
            raise ToolpathError(f"{call[1]}: {NOT_DONE[call[1]]}", hint="bore with CYCLE85 or CYCLE89")
        if modal and not (call and call[1] in CYCLES):
            raise ToolpathError(
                f"MCALL {text[:20]}: a modal call that is not read",
                hint="have the post-processor write the motions out",
            )
        if call and call[1] in CYCLES and text.endswith(")"):
            hole = hole_of(call[1], self._arguments(text[call.end() : -1]))
            if modal:
                self._hole = hole
            else:
                yield from self._drilled(hole, line)
            return
        if call and call[1] in PATTERNS and text.endswith(")") and self._hole is not None:
            yield from self._pattern(call[1], self._arguments(text[call.end() : -1]), line)
            return
        if call and text.endswith(")") and call[1] not in ("TRAORI",):
            yield from self._call(call[1], text[call.end() : -1], line)
            return
        if kind := _FRAME.match(text):
            yield from self._framed(kind[1], text, line)
            return
        if away := fixed_point(text):
            motion = self._state("motion")
            yield from self._plain(away, line, optional)
            yield Block(line, {}, () if motion is None else (int(motion * 10.0),))
            return
        self._goes = False
        yield from self._plain(text, line, optional)
        if self._hole is not None and self._goes:
            yield from self._drilled(self._hole, line)

    def _pattern(self, name: str, arguments: Sequence[float | None], line: int) -> Iterator[Block]:
        """HOLES1 or HOLES2: the modal cycle at each of its places."""
        if self._hole is None:
            return
        motion, distance = self._state("motion"), self._state("distance")
        for x, y in places(name, arguments):
            yield Block(line, {"X": x, "Y": y}, (900, 0))
            yield from self._drilled(self._hole, line)
        yield Block(line, {}, tuple(int(c * 10) for c in (distance, motion) if c is not None))

    def _drilled(self, hole: Hole, line: int) -> Iterator[Block]:
        """One hole where the tool stands; motion, G90 or G91 and F are behind it what they were before."""
        motion, distance, feed = (self._state(name) for name in ("motion", "distance", "F"))
        if hole.name in TAPS and self._state("units") == 20.0:
            raise ToolpathError(f"{hole.name} in inches: whose unit its pitch is in", hint="post in millimetres (G71)")
        if self._state("plane") != 17.0:
            raise ToolpathError(f"{hole.name} in G18 or G19 drills along Y or X, not along the tool", hint="use G17")
        yield Block(line, {}, (900,))
        yield from hole.blocks(feed, line, self._state("S"), INCH_MM if self._state("units") == 20.0 else 1.0)
        yield Block(
            line, {} if feed is None else {"F": feed}, tuple(int(c * 10) for c in (distance, motion) if c is not None)
        )

    # -- calls and frames --------------------------------------------------------------------------------------

    def _call(self, name: str, inner: str, line: int) -> Iterator[Block]:
        if name == "CYCLE800":
            if not self._frame.plain:
                raise ToolpathError("CYCLE800 on top of TRANS or ROT", hint="put the shift into CYCLE800's X0, Y0, Z0")
            values = [0.0 if value is None else value for value in self._arguments(inner)]
            plane = swivel(values)
            self._swivelled = plane not in (None, PART)
            self._shapes.reframed()
            yield Block(line, {}, plane=plane, aligned=True)
        elif name not in SILENT_CALLS:
            raise ToolpathError(
                f"{name}(...) is called: a cycle or subprogram that is not read",
                hint="have the post-processor write the motions out",
            )
        elif name == "FGROUP" and re.search(r"[ABC]", inner):
            yield Block(line, {}, note="FGROUP with rotary axes: the feed is taken as the tip's")

    def _arguments(self, inner: str) -> list[float | None]:
        """Numbers between commas; texts and empty places are None. Raises ToolpathError for what has no value."""
        out: list[float | None] = []
        for part in inner.split(",") if inner else []:
            reader = self._reader(part)
            if not part or part.startswith('"'):
                out.append(None)
                continue
            value = reader.expression()
            if reader.rest or value is None:
                raise reader.fail()
            out.append(value)
        return out

    def _framed(self, kind: str, text: str, line: int) -> Iterator[Block]:
        """TRANS, ROT, MIRROR, SCALE and what adds to them."""
        if self._swivelled and not kind.startswith("A"):
            raise ToolpathError(
                f"{kind} on top of CYCLE800: whether its plane stays is the machine's",
                hint=f"use A{kind}, which adds to it",
            )
        rest = text.removeprefix(kind).strip()
        if kind.endswith("ROT"):
            frame = self._frame.by_angle(kind, rest, self._state("plane"), self._arguments)
        else:
            frame = self._frame.by_axes(kind, {letter: value for letter, value, _ in self._found(rest)})
        self._shapes.reframed()
        yield Block(line, {}, frame=frame)

    # -- plain words -------------------------------------------------------------------------------------------

    def _plain(self, text: str, line: int, optional: bool) -> Iterator[Block]:
        self._machine, self._note, self._center, self._relative = False, "", set[str](), set[str]()
        self._absolute, self._ways = set[str](), dict[str, str]()
        said = re.findall(r"\bG9([01])(?![0-9.])", text)
        self._distance = 90.0 + float(said[-1]) if said else self._state("distance")
        self._vector: dict[str, float] = {}
        self._corner: Corner | None = None
        self._own, self._kind = dict[str, float](), ""
        found = self._found(text)
        if (rest := self._shapes.pole(found, self._own)) is not None:
            found, self._own = rest, {}
        if self._shapes.said(found, self._kind) or self._own:
            found = self._shaped(found)
        if self.one_name:
            found = [w for w in found if w[:2] != ("M", 6.0)]
        letters = {letter for letter, _, _ in found}
        if self._machine and letters & set("XYZABC"):
            motion = self._state("motion")
            back = (
                motion if motion in (2.0, 3.0) and not {0.0, 1.0} & _g(found) else None
            )  # no arc leads to a machine position
            found += [("G", 53.0, True), *([] if back is None else [("G", 0.0, True)])]
        else:
            back = None
        axes = letters & set("XYZABC")
        self.moved, self._goes = self.moved or bool(axes), bool(axes) and not self._machine
        if (self._relative or self._absolute) and said:  # G90 or G91 holds for the blocks behind this one
            yield Block(line, {}, (910 if self._distance == 91.0 else 900,))
            found = [w for w in found if w[:2] not in (("G", 90.0), ("G", 91.0))]
        if self._center and self._center != letters & set("IJK"):
            raise ToolpathError("AC for some of a centre's words", hint="write I, J, K of a block alike")
        before = mode = self._distance
        if self._relative or self._absolute:
            steps = self._relative | (axes - self._absolute if before == 91.0 else set())
            mode = 91.0 if steps == axes else 90.0
            found = found if steps == axes else [self._stepped(w) if w[0] in steps else w for w in found]
        if mode != before:
            yield Block(line, {}, (910 if mode == 91.0 else 900,))
        if self._center:
            yield Block(line, {}, (901,))
        block = assemble(found, line, "", optional)
        vector = None
        if self._vector:
            vector = tuple(self._vector.get(k, 0.0) for k in ("A3", "B3", "C3"))
        ways = tuple((letter, how) for letter, how in self._ways.items() if letter in block.words)
        self._shapes.begins()
        yield block._replace(vector=vector, note=self._note, corner=self._corner, ways=ways)
        if axes or (self._center | set(block.words)) & set("IJK"):
            sure = self._goes and self._corner is None and not self._center and mode == before
            self._shapes.ends(block.words, sure=sure)
        if self._center:
            yield Block(line, {}, (911,))
        if mode != before:
            yield Block(line, {}, (900 if before == 90.0 else 910,))
        if back is not None:
            yield Block(line, {}, (int(back * 10.0),))

    def _shaped(self, found: list[Word]) -> list[Word]:
        """Words of which some say in Siemens' own ways where the block leads to."""
        if self._machine or (self._distance == 91.0 and self._absolute | self._center):
            raise ToolpathError(
                "a polar motion, AR=, ANG=, CIP or CT with AC in G91, or by the machine", hint="use G90"
            )
        found = [self._stepped(w) if w[0] in self._relative else w for w in found]
        found = [(k, v - self._at("XYZ"["IJK".index(k)]), w) if k in self._center else (k, v, w) for k, v, w in found]
        self._relative, self._absolute, self._center = set(), set(), set()
        return self._shapes.shaped(found, self._own, steps=self._distance == 91.0)

    def _at(self, letter: str) -> float:
        at = self._state(f"at {letter}")
        if at is None:
            raise ToolpathError(
                f"IC of {letter} from a place that is not known", hint="write all of a block's axes alike"
            )
        return at

    def _stepped(self, word: tuple[str, float, bool]) -> tuple[str, float, bool]:
        """A step of one axis in a block whose others name places, as the place that it leads to."""
        letter, step, point = word
        return letter, self._at(letter) + step, point

    def _found(self, text: str) -> list[Word]:
        """The words of a text."""
        reader = self._reader(text)
        found: list[Word] = []
        while reader.rest:
            if reader.take(" "):
                continue
            rest = reader.rest
            name = _NAME.match(rest)
            keyword = keyword_of(rest) if name else ""
            if keyword:
                reader.at += len(keyword)
                self._said(keyword, found, reader)
                continue
            match = _ADDRESS.match(rest)
            if match is None:
                raise no_word(rest)
            reader.at += match.end()
            self._address(match[1], match[2] is not None, reader, found)
        return found

    def _said(self, keyword: str, found: list[Word], reader: Reader) -> None:
        if keyword in REFUSED:
            raise ToolpathError(f"{REFUSED[keyword]} is not read", hint="have the CAM system write the path without it")
        if keyword == "TRAORI":
            match = re.match(r"\(1?(?:,[^)]*)?\)", reader.rest)
            reader.at += match.end() if match else 0
            found.append(("M", 128.0, True))
        elif keyword == "TRAFOOF":
            found.append(("M", 129.0, True))
        elif keyword == "ORIAXES":
            self._note = (
                "ORIAXES: between two tool vectors rotary axes would turn evenly; here the tool takes the great arc"
            )
        elif keyword in ("CIP", "CT"):
            self._kind = keyword
        elif keyword == "SUPA":
            self._machine = True
        elif keyword == "RET":
            found.append(("M", 30.0, True))

    def _address(self, name: str, equals: bool, reader: Reader, found: list[Word]) -> None:
        if name == "T" and equals and reader.rest.startswith('"'):
            self._tool(reader, found)
            return
        how = re.match(r"(IC|AC|DC|ACP|ACN)\(", reader.rest) if equals else None
        before = reader.at
        if how:
            reader.at += len(how[1])
        value = reader.expression() if equals else signed(reader)
        if value is None or math.isnan(value):
            raise reader.fail(f"no value behind {name}")
        if how and how[1] == "IC" and name in ("I1", "J1", "K1") and self._distance == 90.0:
            value, how = value + self._at("XYZ"["IJK".index(name[0])]), None
        if how:
            self._mode(how[1], name, value)
        is_whole = "." not in reader.text[before : reader.at]
        if name in ("A3", "B3", "C3"):
            self._vector[name] = value
        elif name in KEYS:
            self._own[name] = value
        elif name == "G":
            self._code(value, found)
        elif name in CORNERS:
            self._corner = cornered(name, value, self._corner)
        elif name == "CR":
            found.append(("R", value, is_whole))
        elif name == "TURN":
            found.append(("P", whole(value, "TURN") + 1.0, True))
        elif name in ("S1", "M1"):
            found.append((name[0], value, is_whole))
        elif name == "M" and value == 17.0:
            found.append(("M", 30.0, True))
        elif name in ("H", "N"):
            return
        elif name in "LP":
            raise ToolpathError("a subprogram call (L, P) that is not read", hint="put its motions into the program")
        elif name in "UVWOQRE":
            raise ToolpathError(f"{name}{value:g} is not a word that is read here", hint="export X, Y, Z, A, B, C")
        else:
            found.append((name, value, is_whole))

    def _mode(self, how: str, name: str, value: float) -> None:
        """IC, AC, DC, ACP, ACN behind an address."""
        if name in "IJK" and how == "AC":
            self._center.add(name)
        elif name in "XYZABC" and how == ("AC" if self._distance == 90.0 else "IC"):
            return  # as the modal state has it
        elif name in "XYZABC" and how == "AC":
            self._absolute.add(name)
        elif name in "XYZABC" and how == "IC":
            self._relative.add(name)
        elif name in "ABC":  # DC, ACP, ACN
            self._absolute.add(name)
            self._ways[name] = how
        elif name in ("I1", "J1", "K1") and how == ("AC" if self._distance == 90.0 else "IC"):
            return
        else:
            raise ToolpathError(f"{name}={how}(...) is not read", hint=f"write {name} as a plain value")

    def _tool(self, reader: Reader, found: list[Word]) -> None:
        match = re.match(r'"([^"]*)"', reader.rest)
        if match is None:
            raise reader.fail("a tool's name without its end")
        reader.at += match.end()
        number = float(match[1]) if match[1].isdigit() else self.number_of(match[1])
        if number is not None:
            found.append(("T", number, True))
        elif self.one_name:
            self._note = f'T="{match[1][:40]}" is the file\'s only tool: it is taken for the one of the set-up'
        else:
            raise ToolpathError(
                f'T="{match[1][:40]}": several tools by their names',
                hint="give each a [[tool]] with its number and this name in setup.toml, or call them by numbers",
            )

    def _code(self, value: float, found: list[Word]) -> None:
        if value in SILENT_G:
            return
        if value in (53.0, 153.0):
            self._machine = True
        elif value in (58.0, 59.0):
            raise ToolpathError(
                f"G{value:g} of Siemens shifts the frame by its words, and is not read",
                hint="write it as TRANS or ATRANS",
            )
        elif value in REFUSED_G:
            raise ToolpathError(
                f"G{value:g} of Siemens is not read", hint="have the post-processor write the motions out"
            )
        else:
            if value == 70.0:
                self._note = "G70: feeds are taken in inches a minute, as with G700"
            found.append(("G", float(CODES.get(int(value), value)), True))


def _g(found: list[Word]) -> set[float]:
    return {value for letter, value, _ in found if letter == "G"}
