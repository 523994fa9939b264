"""Programs in Heidenhain's plain language (TNC 640, "Klartext Programming" and "Machining Cycles")."""

from __future__ import annotations

import math
from collections.abc import Callable
from random import Random

import numpy as np

from camrob.witness.happenings import Kind
from drawn.turns import about
from drawn.writer import Point, Writer

__all__ = ["Klartext"]


class Klartext(Writer):
    """L, C, CR, CP, LP, IX, Q parameters, labels, cycles 7, 8, 10, 200, 201, 203, PLANE SPATIAL, M128 with LN."""

    suffix = ".h"

    def __init__(self, rng: Random) -> None:
        super().__init__(rng)
        self.said: Point = {}
        self.labels = 0
        self.q = 9

    def pieces(self) -> list[Callable[[], None]]:
        """Vectors, corners and a plane, too."""
        return [*super().pieces(), self.vectors, self.corners, self.plane, self.home, self.helix]

    def draw(self) -> str:
        rows = super().draw().rstrip("\n").split("\n")
        return "\n".join(f"{n} {row}" for n, row in enumerate(rows)) + "\n"

    def block(self, *words: str) -> None:
        """A statement."""
        self.lines.append(" ".join(words))

    def signed(self, count: int) -> str:
        """A number with its sign."""
        text = self.plain(count).rstrip(".")
        return text if text.startswith("-") else "+" + text

    def word(self, letter: str, count: int) -> str:
        """X+12.5, IX+3, X+Q12."""
        how, before = self.rng.random(), self.said.get(letter)
        if how < 0.75:
            return letter + self.signed(count)
        if how < 0.88 and before is not None:
            return f"I{letter}{self.signed(count - before)}"
        self.q = 10 + (self.q - 9) % 60
        part = self.grid(self.rng.uniform(-9, 9))
        if self.rng.random() < 0.5:
            self.block(f"Q{self.q} = {self.signed(count)}")
        else:
            self.block(f"FN 1: Q{self.q} = {self.signed(count - part)} + {self.signed(part)}")
        return f"{letter}+Q{self.q}"

    def begin(self) -> None:
        self.block("BEGIN PGM DRAWN", "INCH" if self.inch else "MM")
        if self.rng.random() < 0.5:
            self.lines += ["BLK FORM 0.1 Z X-60 Y-60 Z-20", "BLK FORM 0.2 X+60 Y+60 Z+10"]
        tool, rpm = self.rng.randint(1, 20), self.rng.choice((2000, 9000))
        self.block(f"TOOL CALL {tool} Z S{rpm}")
        self.told.event(Kind.TOOL, tool)
        spot = self.somewhere()
        self.block("L", f"Z{self.signed(self.grid(60))}", "R0 FMAX M3")
        self.told.event(Kind.SPINDLE_ON, rpm, "CLW")
        self.said = {}
        self.over(spot)

    def end(self) -> None:
        self.up()
        self.block("M5")
        self.told.event(Kind.SPINDLE_OFF)
        self.block("M30")
        self.lines += self.behind
        self.behind = []
        self.block("END PGM DRAWN", "INCH" if self.inch else "MM")

    def write_line(self, to: Point, rapid: bool) -> None:
        named = [k for k in "XYZ" if self.said.get(k) != to[k] or self.rng.random() < 0.1]
        axes = [self.word(k, to[k]) for k in named]
        self.said = dict(to)
        if axes:
            self.block(
                "L", *axes, *(["R0"] if self.rng.random() < 0.1 else []), *(["FMAX"] if rapid else self.fed_word())
            )

    def fed_word(self) -> list[str]:
        """F where the feed is another, and now and then again."""
        if self.fed and self.rng.random() < 0.9:
            return []
        self.fed = True
        return [f"F{self.feed:g}"]

    def write_arc(self, center: Point, end: Point, turn: float) -> None:
        sense = "DR+" if turn > 0 else "DR-"
        flat = end["Z"] == self.at["Z"]
        if not flat or (self.rng.random() < 0.3):
            self.block("CC", f"X{self.signed(center['X'])}", f"Y{self.signed(center['Y'])}")
            rise = [] if flat else [f"IZ{self.signed(end['Z'] - self.at['Z'])}"]
            self.block("CP", f"IPA{turn:+g}", *rise, sense, *self.fed_word())
        elif abs(turn) in (90.0, 270.0) and self.rng.random() < 0.5:
            radius = max(abs(center[k] - self.at[k]) for k in "XY")
            r = self.signed(radius if abs(turn) < 180.0 else -radius)
            self.block("CR", f"X{self.signed(end['X'])}", f"Y{self.signed(end['Y'])}", f"R{r}", sense, *self.fed_word())
        else:
            self.block("CC", f"X{self.signed(center['X'])}", f"Y{self.signed(center['Y'])}")
            axes = [f"{k}{self.signed(end[k])}" for k in "XY"]
            self.block("C", *axes, sense, *self.fed_word())
        self.said = dict(end)

    def write_coolant(self, on: bool) -> None:
        self.block("M8" if on else "M9")

    def write_dwell(self, seconds: float) -> None:
        self.lines += ["CYCL DEF 9.0 DWELL TIME", f"CYCL DEF 9.1 DWELL {seconds:g}"]

    def write_speed(self, rpm: float) -> None:
        self.block(f"TOOL CALL S{rpm:g}")

    def write_halt(self) -> None:
        self.block(self.rng.choice(("STOP", "M0")))

    def helix(self) -> None:
        """Several turns downwards."""
        self.over(self.somewhere())
        self.cut({**self.at, "Z": self.at["Z"] - self.grid(2)})
        r, turns = self.grid(self.rng.uniform(3, 9)), self.rng.randint(2, 4)
        center = {**self.at, "X": self.at["X"] - r}
        end = {**self.at, "Z": self.at["Z"] - self.grid(turns)}
        sense = self.rng.choice((1, -1))
        self.block("CC", f"X{self.signed(center['X'])}", f"Y{self.signed(center['Y'])}")
        z = f"IZ{self.signed(end['Z'] - self.at['Z'])}" if self.rng.random() < 0.5 else f"Z{self.signed(end['Z'])}"
        self.block("CP", f"IPA{360 * turns * sense:+d}", z, f"DR{'+' if sense > 0 else '-'}", *self.fed_word())
        self.said = dict(end)
        self.reckon_arc(center, end, 360.0 * turns * sense)
        self.up()

    def again(self) -> None:
        self.over(self.somewhere())
        self.cut(self.near())
        steps, times = [s for s in self.steps() if any(s)], self.rng.randint(1, 4)
        body = ["L " + " ".join(f"I{k}{self.signed(v)}" for k, v in zip("XYZ", s, strict=True) if v) for s in steps]
        self.labels += 1
        name = self.rng.choice((str(self.labels), f'"PART{self.labels}"'))
        which = self.rng.choice(("rep", "goto", "sub"))
        if which == "rep" and times > 1:
            self.lines += [f"LBL {name}", *body, f"CALL LBL {name} REP{times - 1}"]
        elif which == "goto":
            self.lines += [
                "FN 0: Q1 = +0",
                f"LBL {name}",
                *body,
                "Q1 = Q1 + 1",
                f"FN 12: IF +Q1 LT +{times} GOTO LBL {name}",
            ]
        else:
            self.lines += [f"CALL LBL {name}"] * times
            self.behind += [f"LBL {name}", *body, "LBL 0"]
        self.walk(steps, times)
        self.said = {}
        self.up()

    def framed(self) -> None:
        """CYCL DEF 7, and within it 8 or 10."""
        by = [self.grid(self.rng.uniform(-8, 8)) for _ in "XYZ"] if self.rng.random() < 0.7 else [0, 0, 0]
        if any(by):
            self.block("CYCL DEF 7.0 DATUM SHIFT")
            self.lines += [
                f"CYCL DEF 7.{n} {k}{self.signed(v)}" for n, (k, v) in enumerate(zip("XYZ", by, strict=True), 1)
            ]
        matrix, kind = np.eye(3), self.rng.choice("mrn")
        if kind == "m":
            axes = self.rng.choice(("X", "Y", "X Y"))
            self.lines += ["CYCL DEF 8.0 MIRROR IMAGE", f"CYCL DEF 8.1 {axes}"]
            matrix = np.diag([-1.0 if k in axes else 1.0 for k in "XYZ"])
        elif kind == "r":
            angle = self.rng.choice((30.0, -45.0, 90.0, 12.5))
            self.lines += ["CYCL DEF 10.0 ROTATION", f"CYCL DEF 10.1 ROT{angle:+g}"]
            matrix = about(2, math.radians(angle))
        self.use(matrix, np.array([self.unit(v) for v in by]) * self.mm)
        self.said = {}
        self.rng.choice((self.cuts, self.arcs, self.holes))()
        if kind == "m":
            self.lines += ["CYCL DEF 8.0 MIRROR IMAGE", "CYCL DEF 8.1"]
        elif kind == "r":
            self.lines += ["CYCL DEF 10.0 ROTATION", "CYCL DEF 10.1 ROT+0"]
        if any(by):
            self.lines += ["CYCL DEF 7.0 DATUM SHIFT", "CYCL DEF 7.1 X+0 Y+0 Z+0"]
        self.use(np.eye(3), np.zeros(3))
        self.said = {}
        self.over(self.somewhere())

    def plane(self) -> None:
        """PLANE SPATIAL, with a datum of its own or none."""
        by = [self.grid(self.rng.uniform(-8, 8)) for _ in "XYZ"] if self.rng.random() < 0.6 else [0, 0, 0]
        angles = [self.rng.choice((0.0, 10.0, -15.0)), self.rng.choice((12.0, -20.0)), self.rng.choice((0.0, 30.0))]
        self.up()
        if any(by):
            words = " ".join(f"{k}{self.signed(v)}" for k, v in zip("XYZ", by, strict=True))
            self.lines += ["CYCL DEF 7.0 DATUM SHIFT", f"CYCL DEF 7.1 {words}"]
        said = " ".join(f"SP{k}{v:+g}" for k, v in zip("ABC", angles, strict=True))
        self.block(f"PLANE SPATIAL {said}", self.rng.choice(("MOVE DIST50 FMAX", "TURN FMAX")))
        a, b, c = (math.radians(v) for v in angles)
        matrix = about(2, c) @ about(1, b) @ about(0, a)
        self.use(matrix, np.array([self.unit(v) for v in by]) * self.mm)
        self._placed(matrix[:, 2])
        self.rng.choice((self.cuts, self.arcs, self.holes))()
        self.block("PLANE RESET", self.rng.choice(("MOVE DIST50 FMAX", "TURN FMAX")))
        if any(by):
            self.lines += ["CYCL DEF 7.0 DATUM SHIFT", "CYCL DEF 7.1 X+0 Y+0 Z+0"]
        self.use(np.eye(3), np.zeros(3))
        self._placed(np.array([0.0, 0.0, 1.0]))

    def _placed(self, axis: np.ndarray) -> None:
        self.told.lose()
        self.told.axis = axis
        self.at, self.said = {}, {}
        self.over(self.somewhere())

    def vectors(self) -> None:
        """M128 and LN with the tool along one vector."""
        self.up()
        self.block("M128")
        vector = [round(self.rng.uniform(-0.4, 0.4), 6), round(self.rng.uniform(-0.4, 0.4), 6)]
        vector.append(round(math.sqrt(1.0 - vector[0] ** 2 - vector[1] ** 2), 6))
        tool = " ".join(f"T{k}{v:+.6f}" for k, v in zip("XYZ", vector, strict=True))
        spot = self.somewhere()
        self.block("LN", *(f"{k}{self.signed(spot[k])}" for k in "XYZ"), tool, "FMAX")
        self.told.axis = np.array(vector) / float(np.linalg.norm(vector))
        self.told.rapid(self.place(spot))
        self.at, self.said = dict(spot), dict(spot)
        if not self.feed:
            self.new_feed()
        for _ in range(self.rng.randint(1, 4)):
            to = self.near()
            normal = "NX+0 NY+0 NZ+1 " if self.rng.random() < 0.3 else ""
            self.block("LN", *(f"{k}{self.signed(to[k])}" for k in "XYZ"), normal + tool, *self.fed_word())
            self.told.cut(self.place(to), self.feed * self.mm)
            self.at, self.said = dict(to), dict(to)
        self.up()
        self.block("M129")
        self.block("L Z+300 R0 FMAX M91")
        self.block("L A+0 C+0 FMAX")
        self._placed(np.array([0.0, 0.0, 1.0]))

    def home(self) -> None:
        """To a machine position, and back."""
        self.up()
        self.block(self.rng.choice(("L Z-5 R0 FMAX M91", "M140 MB MAX", "L M140 MB MAX")))
        self._placed(self.told.axis)

    def corners(self) -> None:
        """RND and CHF between two straight cuts at right angles."""
        size, sx, sy, corner, end = self.before_corner()
        rounded = self.rng.random() < 0.5
        slow = self.feed * self.mm
        self.block("L", f"X{self.signed(corner['X'])}", *self.fed_word())
        own = ""
        if self.rng.random() < 0.4:
            slow, own = slow / 2.0, f" F{self.feed / 2.0:g}"
        self.block((f"RND R{self.plain(size)}" if rounded else f"CHF {self.plain(size)}").rstrip(".") + own)
        self.block("L", f"Y{self.signed(end['Y'])}")
        self.said = dict(end)
        self.tell_corner(corner, end, size, (sx, sy), rounded, slow)
        self.at = end
        self.up()

    def holes(self) -> None:
        """Cycles 200, 201 and 203, called by M99 or CYCL CALL."""
        self.over(self.somewhere())
        number = self.rng.choice((200, 200, 201, 203))
        feed, back = (4.0, 6.0) if self.inch else (120.0, 300.0)
        surface = self.at["Z"] - self.grid(self.rng.uniform(2, 3))
        gap, level, deep = self.grid(1), self.grid(self.rng.uniform(3, 8)), self.grid(self.rng.uniform(3, 9))
        bite = self.grid(self.rng.uniform(1, 3)) if number == 200 and self.rng.random() < 0.5 else deep
        dwell = self.rng.choice((0.0, 0.5))
        q = {
            200: self.plain(gap),
            201: self.signed(-deep),
            206: f"{feed:g}",
            203: self.signed(surface),
            204: self.plain(level),
        }
        if number != 201:
            q |= {202: self.plain(bite), 210: "0"}
        if number == 203:
            q |= {212: "0", 213: "0", 205: "0", 208: f"{back:g}", 256: "0.2"}
        if number == 201:
            q[208] = f"{back:g}"
        q[211] = f"{dwell:g}"
        rows = [f"Q{k}={v.rstrip('.')}" for k, v in q.items()]
        self.lines.append(f"CYCL DEF {number} DRILLING ~")
        self.lines += [f"  {row} ~" for row in rows[:-1]] + [f"  {rows[-1]}"]
        top = surface + level
        for _ in range(self.rng.randint(1, 3)):
            spot = {**self.near(), "Z": self.at["Z"]}
            words = [f"{k}{self.signed(spot[k])}" for k in "XY"]
            if self.rng.random() < 0.5:
                self.block("L", *words, "FMAX M99")
            else:
                self.block("L", *words, "FMAX")
                self.block("CYCL CALL")
            self.told.rapid(self.place(spot))
            clear = {**spot, "Z": surface + gap}
            self.told.rapid(self.place(clear))
            bitten = self.unit(bite) * self.mm if bite < deep else 0.0
            self.told.hole(self.place({**spot, "Z": surface - deep}), feed * self.mm, bitten)
            if dwell:
                self.told.event(Kind.DWELL, dwell)
            if number in (201, 203):
                self.told.cut(self.place(clear), back * self.mm)
            self.told.rapid(self.place({**spot, "Z": top}))
            self.at = {**spot, "Z": top}
        self.said = {}
        self.fed = False
        if not self.feed:
            self.new_feed()
        self.up()
