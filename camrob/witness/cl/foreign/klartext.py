"""Heidenhain's plain language: L, LN under M128, arcs, TOOL CALL, labels, Q parameters, some cycles and planes.

Heidenhain, "TNC 640 User's Manual, Klartext Programming". Everything else ends what is read.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from camrob.witness.cl.circles import Wanted
from camrob.witness.cl.foreign import klartext_places, klartext_values
from camrob.witness.cl.foreign.computed_values import Values
from camrob.witness.cl.foreign.foreign_cycles import spatial_plane
from camrob.witness.cl.foreign.foreign_words import UnreadError
from camrob.witness.cl.foreign.klartext_beside import with_programs
from camrob.witness.cl.foreign.klartext_calls import CALL, CycleCalls
from camrob.witness.cl.foreign.klartext_places import FIRST, LAST, QUIET, Pole, formula_of, polar_end, smooth_arc
from camrob.witness.cl.foreign.klartext_values import NUMBER
from camrob.witness.cl.framing import mirror, stands_still, turning
from camrob.witness.cl.running.label_run import LabelRun
from camrob.witness.cl.running.ordered import Ordered, Row

__all__ = ["KlartextReader"]

_TOKEN = re.compile(
    rf"(?P<name>FMAX|R0(?![\d.])|RL|RR|(?:I?PA|I?PR|I?[XYZABC]|[NT][XYZ]|F[UZ]|[FMR]))\s?(?P<value>{NUMBER})?\s?|DR(?P<sense>[-+])\s?"
)
_NOTHING = re.compile(r"(M94\b|BLK FORM|TOOL DEF|\*|END PGM)")


class KlartextReader(CycleCalls):
    """Tells what the statements of one file ask for. file: beside which the programs lie that it calls."""

    file: Path | None = None

    def read(self, text: str) -> None:
        """Reads the text up to its end, or to the first statement that is not read."""
        self._here = {}
        named = {name.upper() for name in re.findall(r"TOOL CALL\s+(\"[^\"]*\"|\d+)", re.sub(r";.*", "", text), re.I)}
        self._lone = len(named) == 1
        self._computed = Values()
        self._in_force = klartext_values.CycleInForce(self._computed)
        self._folded: tuple[str, float] = ("", 0.0)  # mirrored axes (8) and angle (10) in force
        self._preset = ""  # the datum of the machine's table (247)
        self._called_feed = ""  # of TOOL CALL, which F AUTO means
        self._per_turn = False  # the feed in force is one of FU
        self._pattern = ()
        self._datum: dict[str, float] | None = None  # the shift that holds again behind a plane, m
        self._unsure = self._shortest = self._modal = False  # it has ended within the plane; M126; M89
        self._pole: Pole | None = None
        self._going: complex | None = None  # X + iY: which way the last cut goes where it ends
        super().read(text)

    def _statements(self, text: str) -> list[tuple[int, str]]:
        return with_programs(klartext_values.statements(text), self.file, klartext_values.statements)

    def _order(self, rows: list[Row]) -> Ordered:
        return LabelRun(rows, self._computed.of)

    def _line(self, row: str, line: int) -> None:
        self._ended = self._ended or row.startswith("END PGM")  # what stands behind it only labels reach
        if given := re.fullmatch(r"(?:FN ?[0-7] ?: ?)?(Q[LR]?\d+) ?= ?(.+)", row):
            self._computed.keep(given[1], formula_of(given[1], given[2], row))
            self._in_force.given(given[1])
            return
        if turned := re.fullmatch(r"L((?: ?[ABC] ?[-+]?Q12[0-2])+)(?: R0)?(?: F ?MAX| F ?\d+)?((?: M\d+)*)", row):
            self._turn_along(re.findall(r"M0*(\d+)", turned[2]), line)
            return
        row = re.sub(r"(?<=[A-Z=])([-+]?)(Q[LR]?\d+)", self._number_of, row)
        if (
            self._unsure
            and re.match(r"(L|LN|C|CR|CP|CT|LP|CYCL CALL) ", row)
            and not re.search(r"\bM(9[12]|140)\b", row)
        ):
            raise UnreadError("a motion in a tilted plane whose datum shift has ended")
        row = "CYCL CALL" if row == "M99" else row
        head, _, rest = row.partition(" ")
        if row.startswith("BEGIN PGM"):
            if self._tell.n or not row.endswith((" MM", " INCH")):
                raise UnreadError("a second program, or one without units")
            self._block(["G20" if row.endswith("INCH") else "G21", "G17", "G90", "G94"], line)
        elif head in ("L", "LN") or "M140" in row:
            self._straight(rest if head in ("L", "LN") else row, line)
        elif head in ("C", "CR", "CP", "CT", "LP"):
            self._round(head, rest, line)
        elif corner := re.fullmatch(rf"(RND R|CHF) ?({NUMBER})(?: F ?({NUMBER}))?", row):
            self._round_off(corner, line)
        elif head == "CC":
            self._set_pole(rest)
        elif row.startswith("PLANE"):
            self._plane_of(row)
        elif found := CALL.fullmatch(row):
            self._call(found, line)
        elif row.startswith("TOOL CALL"):
            self._tool(row[9:].strip(), line)
        elif row.startswith("PATTERN DEF"):
            self._pattern = klartext_values.pattern_places(row)
        elif row.startswith(("CYCL DEF", "TRANS DATUM AXIS ")):
            self._defined(row.replace("TRANS DATUM AXIS", "7.1").removeprefix("CYCL DEF").strip(), line)
        elif re.fullmatch(r"STOP( M\d+)*|(M\d+ ?)+|M128 F ?[A-Z\d.]+", row):
            codes = re.findall(r"M0*(\d+)", row)
            self._due(codes, ())
            for first in (True, False):
                self._switch(codes, line, first=first)
            self._block(["M0"] if head == "STOP" and not self._ended else [], line)
        elif re.fullmatch(r"FUNCTION TCPM F TCP AXIS POS( PATHCTRL (AXIS|VECTOR))?( REFPNT TIP-TIP| F\d+)*", row):
            self._switch(["128"], line, first=True)
        elif row.startswith("FUNCTION RESET TCPM"):
            self._switch(["129"], line, first=False)
        elif not _NOTHING.match(row):
            raise UnreadError(f"{row[:24]}, of Heidenhain's language")

    def _number_of(self, found: re.Match[str]) -> str:
        """A Q parameter behind a letter or an equals sign, as its number."""
        return f"{self._computed.of(found[1] + found[2]):+.9f}"

    def _round_off(self, found: re.Match[str], line: int) -> None:
        """RND and CHF between the last motion and the next one; a chamfer is as long as its sides."""
        size, feed = float(found[2]) * self._scale, None if found[3] is None else float(found[3]) * self._scale / 60.0
        want = Wanted(radius=size, feed=feed) if found[1] == "RND R" else Wanted(side=size, feed=feed)
        self._going = None
        self._tell.corner(want, self._stand.about(np.array([0.0, 0.0, 1.0])), line)

    def _plane_of(self, row: str) -> None:
        """PLANE SPATIAL and PLANE RESET that turn the tool along."""
        said = re.fullmatch(rf"PLANE SPATIAL SPA ?({NUMBER}) SPB ?({NUMBER}) SPC ?({NUMBER}) (MOVE|TURN|STAY)\b.*", row)
        if said is None and not re.fullmatch(r"PLANE RESET (MOVE|TURN|STAY)\b.*", row):
            raise UnreadError(f"{row[:24]}, of Heidenhain's language")
        stand, self._here = self._stand, {}
        if self._folded != ("", 0.0):
            raise UnreadError("PLANE while cycle 8 or 10 is in force")
        if said is None and "STAY" in row and not stand.tilted:
            return
        self._unsure = False
        if self._datum is None:
            self._datum = dict(stand.shift)
        if said is None:
            angles = {letter: stand.at[letter] for letter in "ABC"}
            self._unswivel()
            if "STAY" in row:  # the rotary axes, too
                stand.at.update(angles)
            stand.shift, self._datum = self._datum, None
            return
        stand.untilt()
        stand.shift = dict.fromkeys("XYZ", 0.0)
        plane = spatial_plane([float(said[k]) for k in (1, 2, 3)]), np.array([self._datum[k] for k in "XYZ"])
        if said[4] == "STAY":
            stand.lay(*plane)
        else:
            self._swivel(*plane)

    def _turn_along(self, codes: list[str], line: int) -> None:
        """A, B, C to what PLANE has left in Q120 to Q122: the tool onto the plane."""
        if not self._stand.align():
            raise UnreadError("Q120 to Q122 without a plane")
        self._tell.lose()
        self._here = {}
        for first in (True, False):
            self._switch(codes, line, first=first)

    # -- words

    def _parts(self, text: str) -> tuple[dict[str, str], list[str], bool]:
        """Words, M functions, and whether it is a rapid."""
        words: dict[str, str] = {}
        codes: list[str] = []
        if self._called_feed:
            text = re.sub(r"F ?AUTO", f"F{self._called_feed}", text)
        at, text = 0, re.sub(r" ?\bM94( [ABC](?![-+\d]))?(?!\d)", "", text.replace("F MAX", "FMAX"))
        while at < len(text):
            token = _TOKEN.match(text, at)
            if token is None or token.end() == at:
                raise UnreadError(f"{text[at : at + 20]}, of Heidenhain's language")
            at = token.end()
            if token["sense"]:
                words["DR"] = token["sense"]
            elif token["name"] in ("R", "F", "M") and token["value"] is None:
                continue  # left empty: as compensated and as fast as before, and no function
            elif token["name"] == "M":
                codes.append(f"{float(token['value']):g}")
            elif token["name"] in words or (token["value"] is None and token["name"] not in ("FMAX", "R0", "RL", "RR")):
                raise UnreadError(f"{token['name']} twice, or without a number")
            else:
                words[token["name"]] = token["value"] or ""
        return words, codes, words.pop("FMAX", None) is not None

    def _switch(self, codes: list[str], line: int, *, first: bool) -> None:
        """The M functions that act before a motion, or behind it."""
        table = FIRST if first else LAST
        for code in codes:
            if code in table:
                for word in re.findall(r"M\d+", table[code]):
                    self._block([word], line)
                if code in ("128", "129"):
                    self._here = {}
            elif code in ("126", "127"):
                self._shortest = code == "126"  # the shorter way round
            elif code not in QUIET and code not in (*FIRST, *LAST, "91", "92"):
                raise klartext_places.unread_code(code)

    def _fed(self, words: dict[str, str]) -> list[str]:
        """F, or FU: so much a turn of the spindle."""
        feed, per_turn = klartext_values.feed_words(words, self._tell.rpm)
        self._per_turn = per_turn if feed else self._per_turn
        return feed

    def _sided(self, words: dict[str, str], line: int) -> None:
        for word, code in (("R0", "40"), ("RL", "41"), ("RR", "42")):
            if words.pop(word, None) is not None:
                self._offsets.block([code], [], {}, line)

    def _ends(self, words: dict[str, str], *, rapid: bool = False) -> dict[str, float]:
        """Where the axes go, absolute."""
        to: dict[str, float] = {}
        for name in [w for w in words if re.fullmatch(r"I?[XYZABC]", w)]:
            value, letter = float(words.pop(name)), name[-1]
            if name[0] == "I":
                at = self._stand.turn(letter) if letter in "ABC" else self._here.get(letter, math.nan)
                if math.isnan(at):
                    raise UnreadError(f"{name} from where the axis isn't known to be")
                value += at
            elif self._shortest and letter in "ABC" and not self._stand.wind(letter, value, "DC") and not rapid:
                raise UnreadError(f"{letter} under M126, which may be either way round")
            to[letter] = value
        return to

    # -- motions

    def _straight(self, text: str, line: int) -> None:
        if self._retracted(text, line):
            return
        words, codes, rapid = self._parts(text)
        self._sided(words, line)
        calls, codes = codes, [code for code in codes if code != "99"]
        self._switch(codes, line, first=True)
        feed = self._fed(words)
        vector = None
        if {"TX", "TY", "TZ"} & set(words):
            vector = tuple(float(words.pop(name, "0")) for name in ("TX", "TY", "TZ"))
        elif {"NX", "NY", "NZ"} & set(words):
            raise UnreadError("LN with a normal, and no tool axis")
        words = {name: value for name, value in words.items() if name not in ("NX", "NY", "NZ")}
        to = self._ends(words, rapid=rapid)
        if words:
            raise UnreadError(f"{', '.join(words)} in a straight motion")
        block = [*(f"{letter}{value:.9f}" for letter, value in to.items()), *feed]
        if {"91", "92"} & set(codes):
            self._here = {letter: value for letter, value in self._here.items() if letter not in to}
            self._block(["G53", "G0" if rapid else "G1", *block], line)
        elif to or vector:
            self._block(["G0" if rapid else "G1", *block], line, vector)
            ends = self._here | to
            flat = not rapid and {"X", "Y"} <= self._here.keys()
            self._going = complex(ends["X"] - self._here["X"], ends["Y"] - self._here["Y"]) or None if flat else None
            self._here |= {letter: value for letter, value in to.items() if letter in "XYZ"}
        elif feed:
            self._block(feed, line)
        if self._due(calls, to):
            self._hole([], line)
        self._switch(codes, line, first=False)

    def _set_pole(self, text: str) -> None:
        words, _, _ = self._parts(text)
        to = self._ends(words)
        if not text.strip() and (self._pole is None or self._pole.axes == "XY"):  # where the tool has been sent last
            to = {axis: self._here[axis] for axis in "XY" if axis in self._here}
        self._pole = Pole.named(to, self._pole)
        if words:
            raise UnreadError(f"{', '.join(words)} of a centre (CC)")

    def _round(self, kind: str, text: str, line: int) -> None:
        words, codes, rapid = self._parts(text)
        self._sided(words, line)
        calls, codes = codes, [code for code in codes if code != "99"]
        if {"91", "92"} & set(codes):
            raise UnreadError(klartext_values.ARC_BY_MACHINE)
        self._switch(codes, line, first=True)
        feed = self._fed(words)
        to, more, sense = self._ends(words, rapid=rapid), list[str](), words.pop("DR", "")
        pole = (None if kind in ("CR", "CT") else self._pole) or Pole("XY", (0.0, 0.0))
        first, second = pole.axes[0], pole.axes[1]
        begun = {first, second} <= self._here.keys() or (kind == "LP" and {"PR", "PA"} <= words.keys())
        bare = kind in ("CR", "CT")
        if not begun or (not bare and self._pole is None) or (bool(sense) == (kind == "CT") and kind != "LP"):
            raise UnreadError(f"{kind} from where the tool isn't known to be, or without its pole or sense")
        x, y = self._here.get(first, 0.0), self._here.get(second, 0.0)
        cx, cy = pole.at
        if kind in ("CP", "LP"):
            to, more = polar_end(kind, words, to, pole, (x - cx, y - cy))
        if kind == "CR":
            more = [f"R{words.pop('R', 'nan')}"]
        elif kind == "CT":
            by, sense = smooth_arc(self._going, complex(to.get("X", x) - x, to.get("Y", y) - y))
            more = [f"I{by.real:.9f}", f"J{by.imag:.9f}"]
        elif kind != "LP":
            more += [f"{'IJK'['XYZ'.index(k)]}{by:.9f}" for k, by in ((first, cx - x), (second, cy - y))]
        if words or "nan" in more[0:1]:
            raise UnreadError(f"{', '.join(words)} in {kind}")
        to = {first: x, second: y} | to
        ends = [f"{letter}{value:.9f}" for letter, value in to.items()]
        motion = ("G0" if rapid else "G1") if kind == "LP" else "G3" if sense == "+" else "G2"
        self._block([pole.plane, motion, *ends, *more, *feed], line)
        self._block(["G17"], line)
        self._going = None
        if kind not in ("LP", "CR") and pole.axes == "XY":
            ray = complex(to["X"] - x, to["Y"] - y) - (by if kind == "CT" else complex(cx - x, cy - y))
            self._going = ray * (1j if sense == "+" else -1j)
        self._here |= to
        if self._due(calls, to):
            self._hole([], line)
        self._switch(codes, line, first=False)

    # -- tools and cycles

    def _tool(self, text: str, line: int) -> None:
        number, speed, feed = klartext_values.tool_words(text)
        if number and number.startswith('"'):
            number = str(self.numbers.get(number.strip('" ').casefold(), number))
        if number and number.startswith('"'):
            if not (self._lone or number.strip('"').isdigit()):
                raise UnreadError("several tools by their names")
            self._here, self._called_feed = {}, feed or ""
            number = number.strip('"') if number.strip('"').isdigit() else None
        if number or feed:
            self._called_feed = feed or ""
        if speed and not feed and self._per_turn:
            raise UnreadError(klartext_values.FEED_BY_TOOL)
        self._per_turn = self._per_turn and not feed
        words = [f"S{speed}"] * bool(speed) + [f"F{feed}"] * bool(feed)
        if number:
            self._here = {}
        self._block(([f"T{number}", "M6"] if number else []) + words, line)

    def _mirrored_or_turned(self, cycle: str, rest: str) -> None:
        """CYCL DEF 8.1 with axes or none, 10.1 ROT or IROT: about the datum, one of the two at a time."""
        axes, angle = klartext_places.folded_by(cycle, rest, self._folded)
        if (axes, angle) == self._folded:
            return
        self._folded = (axes, angle)
        self._stand.frame((mirror(axes) if axes else turning(angle)) if axes or angle else None, "XY")
        for letter in "XY":
            self._here.pop(letter, None)

    def _defined(self, text: str, line: int) -> None:
        """Datum shift (7), dwell (9), and cycles that move nothing (32, 247)."""
        number, _, rest = re.sub(r"^(\d+) \.", r"\1.", text).partition(" ")
        main = number.partition(".")[0]
        shift = re.fullmatch(rf"(?:I?[XYZ]\s?{NUMBER}\s?)+", rest)
        time = re.fullmatch(rf"(?:[A-Z]+\.?\s?)*({NUMBER})", rest)
        taken = self._in_force.take(rest, self._called_feed)
        if re.fullmatch(r"19\.(0( .*)?|1( ?[ABC] ?[-+]?0*\.?0*)*)", text) and not self._stand.tilted:
            return
        if main in ("200", "201", "203", "205", "206", "207", "240", "1", "2", "17"):
            self._modal = False
            if old := re.fullmatch(r"(1|2|17)\.(\d)", number):
                self._in_force.define_old(old[1], old[2], rest.strip(), self._scale)
            else:
                self._in_force.define(main, taken)
        elif main in ("220", "221"):
            self._holes(self._in_force.again(main, taken), line)
            self._in_force.places_done()
        elif self._datum is not None and main == "7" and shift and not re.search(r"I[XYZ]|[1-9]", rest):
            self._datum |= dict.fromkeys(re.findall("[XYZ]", rest), 0.0)
            self._unsure = True
        elif self._datum is not None and main == "7":
            if number != "7.0" and not (shift and stands_still(rest, self._datum, self._scale)):
                raise UnreadError("a datum shift in a plane")
        elif main == "7" and number != "7.0" and shift:
            if self._folded != ("", 0.0):
                if not stands_still(rest, self._stand.shift, self._scale):
                    raise UnreadError("a datum shift while cycle 8 or 10 is in force")
                return
            named = {
                letter: float(value) + (self._stand.shift[letter] / self._scale if more else 0.0)
                for more, letter, value in re.findall(rf"(I?)([XYZ])\s?({NUMBER})", rest)
            }
            self._block(["G52", *(f"{letter}{value:.9f}" for letter, value in named.items())], line)
            self._here = {}
        elif main == "9" and number != "9.0" and time:
            self._block(["G4", f"P{float(time[1]):.6f}"], line)
        elif main == "247":
            preset = re.search(rf"Q339 ?= ?({NUMBER})", rest)
            if self._tell.n and (preset is None or preset[1] != self._preset):
                raise UnreadError("another datum of the machine's table (247)")
            self._preset = preset[1] if preset else ""
        elif main in ("8", "10", "11"):
            if not number.endswith(".0"):
                self._mirrored_or_turned(main, rest.strip())
        elif not (number in ("7.0", "9.0") or main in ("32", "392")):
            raise UnreadError(f"CYCL DEF {number}, a cycle of Heidenhain's")
