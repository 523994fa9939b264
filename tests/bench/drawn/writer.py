"""A program being drawn: pieces that all controls have, in whose words a control's own file writes them.

Coordinates are whole counts of the program's grid (a thousandth of a millimetre, a ten-thousandth of an inch), so that what is
printed is exact. `frame` takes them into the part: three rows, mm, of what the program's frames do.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from random import Random

import numpy as np
from numpy.typing import NDArray

from camrob.witness.happenings import Kind
from drawn.reckoned import Reckoned

__all__ = ["UP", "Point", "Writer"]

Array = NDArray[np.float64]
Point = dict[str, int]
UP = np.array([0.0, 0.0, 1.0])
_INCH = 25.4


class Writer(ABC):
    """Draws one program. `lines` is its text, `told` what it must do."""

    suffix = ".nc"
    reading: dict[str, str]  # options that the reader is given

    def __init__(self, rng: Random) -> None:
        self.rng = rng
        self.told = Reckoned()
        self.reading = {}
        self.lines: list[str] = []
        self.behind: list[str] = []  # subprograms, behind the program's end
        self.inch = rng.random() < 0.2
        self.digits = 4 if self.inch else 3
        self.mm = _INCH if self.inch else 1.0
        self.matrix, self.origin = np.eye(3), np.zeros(3)
        self.at: Point = {}
        self.feed = 0.0  # in the program's unit, a minute
        self.fed = False  # the program has named it
        self.wet = False
        self.count = 0

    # -- numbers

    def grid(self, mm: float) -> int:
        """The count next to a length in mm."""
        return round(mm / self.mm * 10**self.digits)

    def unit(self, count: int) -> float:
        """What a count is in the program's unit."""
        return count / 10**self.digits

    def place(self, at: Point) -> Array:
        """The tip in the part, mm."""
        xyz = np.array([self.unit(at[k]) for k in "XYZ"]) * self.mm
        return self.matrix @ xyz + self.origin

    def plain(self, count: int) -> str:
        """A number as it is printed, never as a whole one."""
        text = f"{self.unit(count):.{self.digits}f}"
        if self.rng.random() < 0.5:
            text = text.rstrip("0")
        return "0." if text in ("-0.", "0.") else text.replace("-0.000", "0.") if float(text) == 0 else text

    # -- the program

    def draw(self) -> str:
        """The whole text."""
        self.begin()
        self.cuts()
        pieces = self.pieces()
        for _ in range(self.rng.randint(3, 8)):
            self.rng.choice(pieces)()
        self.end()
        return "\n".join([*self.lines, *self.behind]) + "\n"

    def pieces(self) -> list[Callable[[], None]]:
        """What may stand in it."""
        return [self.cuts, self.cuts, self.arcs, self.again, self.process, self.holes, self.framed]

    def cuts(self) -> None:
        """Over to somewhere, down, and on."""
        self.over(self.somewhere())
        for _ in range(self.rng.randint(1, 5)):
            if self.rng.random() < 0.25:
                self.new_feed()
            self.cut(self.near())
        self.up()

    def arcs(self) -> None:
        """Quarters of circles in the XY plane, with and without a rise."""
        self.over(self.somewhere())
        self.cut(self.near())
        for _ in range(self.rng.randint(1, 3)):
            r = self.grid(self.rng.uniform(2, 15))
            dx, dy = self.rng.choice(((r, 0), (-r, 0), (0, r), (0, -r)))
            quarters = self.rng.choice((1, 2, 3, 4)) * self.rng.choice((1, -1))
            rise = self.rng.choice((0, 0, self.grid(self.rng.uniform(-2, 2))))
            x, y = -dx, -dy
            for _ in range(quarters % 4):
                x, y = -y, x
            center = {"X": self.at["X"] + dx, "Y": self.at["Y"] + dy, "Z": self.at["Z"]}
            end = {"X": center["X"] + x, "Y": center["Y"] + y, "Z": self.at["Z"] + rise}
            self.write_arc(center, end, 90.0 * quarters)
            self.reckon_arc(center, end, 90.0 * quarters)
        self.up()

    def reckon_arc(self, center: Point, end: Point, turn: float) -> None:
        """The arc in the part: a mirrored frame turns it the other way, a scaled one leaves its angle."""
        factor = float(np.cbrt(abs(np.linalg.det(self.matrix))))
        sense = math.copysign(1.0, float(np.linalg.det(self.matrix)))
        normal = self.matrix @ UP / factor
        self.told.arc(self.place(end), self.place(center), normal, turn * sense, self.feed * self.mm)
        self.at = dict(end)

    def process(self) -> None:
        """Coolant, a dwell, another speed, a stop."""
        which = self.rng.choice(("wet", "dwell", "speed", "halt"))
        if which == "wet":
            self.wet = not self.wet
            self.write_coolant(self.wet)
            self.told.event(Kind.COOLANT_ON if self.wet else Kind.COOLANT_OFF)
        elif which == "dwell":
            seconds = self.rng.choice((0.25, 0.5, 1.5))
            self.write_dwell(seconds)
            self.told.event(Kind.DWELL, seconds)
        elif which == "speed":
            self.spindle(self.rng.choice((3000, 8000, 12000)))
        else:
            self.write_halt()
            self.told.event(Kind.STOP)

    def spindle(self, rpm: float) -> None:
        """The spindle turns at another speed, as it did."""
        self.write_speed(rpm)
        self.told.event(Kind.SPINDLE_ON, rpm, "CLW")

    def over(self, to: Point) -> None:
        """In rapid: up, across, and down to some height."""
        high = {**self.at, "Z": self.grid(60)}
        if self.at and self.at["Z"] < high["Z"]:
            self.rapid(high)
        self.rapid({"X": to["X"], "Y": to["Y"], "Z": self.grid(60)})
        self.rapid(to)

    def up(self) -> None:
        """In rapid above all that is drawn."""
        self.rapid({**self.at, "Z": self.grid(60)})

    def rapid(self, to: Point) -> None:
        """Write and note a rapid."""
        self.write_line(to, True)
        self.told.rapid(self.place(to))
        self.at = dict(to)

    def cut(self, to: Point) -> None:
        """Write and note a straight cut."""
        if not self.feed:
            self.new_feed()
        self.write_line(to, False)
        self.told.cut(self.place(to), self.feed * self.mm)
        self.at = dict(to)

    def new_feed(self) -> None:
        """Another feed from the next cut on."""
        self.feed = self.rng.choice((8.0, 12.5, 20.0, 33.0) if self.inch else (120.0, 333.5, 500.0, 900.0))
        self.fed = False

    def somewhere(self) -> Point:
        """A place over the part."""
        x, y, z = (self.grid(v) for v in (self.rng.uniform(-45, 45), self.rng.uniform(-45, 45), self.rng.uniform(3, 8)))
        return {"X": x, "Y": y, "Z": z}

    def before_corner(self) -> tuple[float, int, int, Point, Point]:
        """Down to a place; how large a break of a corner is to be, its senses in X and Y, the corner, and the end behind it."""
        self.over(self.somewhere())
        self.cut({**self.at, "Z": self.at["Z"] - self.grid(2)})
        size = self.grid(self.rng.uniform(1, 4))
        sx, sy = self.rng.choice((1, -1)), self.rng.choice((1, -1))
        corner = {**self.at, "X": self.at["X"] + sx * self.grid(12)}
        return size, sx, sy, corner, {**corner, "Y": corner["Y"] + sy * self.grid(12)}

    def tell_corner(
        self, corner: Point, end: Point, side: float, senses: tuple[int, int], rounded: bool, slow: float
    ) -> None:
        """Note the two cuts and what breaks the corner between them, `side` from it; slow: its feed, mm/min."""
        (sx, sy), feed = senses, self.feed * self.mm
        first, last = {**corner, "X": corner["X"] - sx * side}, {**corner, "Y": corner["Y"] + sy * side}
        self.told.cut(self.place(first), feed)
        if rounded:
            self.told.arc(self.place(last), self.place({**first, "Y": last["Y"]}), (0, 0, 1), 90.0 * sx * sy, slow)
        else:
            self.told.cut(self.place(last), slow)
        self.told.cut(self.place(end), feed)

    def near(self) -> Point:
        """A place not far from where the tool is: one, two or three coordinates change."""
        to = dict(self.at)
        for k in self.rng.sample("XYZ", self.rng.randint(1, 3)):
            to[k] += self.grid(self.rng.uniform(-15, 15) / (6 if k == "Z" else 1))
        return to

    def steps(self) -> list[tuple[int, int, int]]:
        """Steps of a stretch that is run several times."""
        return [
            (
                self.grid(self.rng.uniform(-6, 6)),
                self.grid(self.rng.uniform(-6, 6)),
                self.rng.choice((0, self.grid(-0.5))),
            )
            for _ in range(self.rng.randint(1, 3))
        ]

    def walk(self, steps: Sequence[tuple[int, int, int]], times: int) -> None:
        """Note what a stretch of steps does, run so many times."""
        for _ in range(times):
            for x, y, z in steps:
                self.at = {"X": self.at["X"] + x, "Y": self.at["Y"] + y, "Z": self.at["Z"] + z}
                self.told.cut(self.place(self.at), self.feed * self.mm)

    def use(self, matrix: Array, origin: Array) -> None:
        """Another frame, mm: the tool stays, and its coordinates are no grid's any more."""
        self.matrix, self.origin = matrix, origin
        self.at = {}

    # -- in the control's words

    @abstractmethod
    def begin(self) -> None:
        """Heading, units, tool, spindle, and the first rapid."""

    @abstractmethod
    def end(self) -> None:
        """The program's end."""

    @abstractmethod
    def write_line(self, to: Point, rapid: bool) -> None:
        """A straight motion."""

    @abstractmethod
    def write_arc(self, center: Point, end: Point, turn: float) -> None:
        """An arc in the XY plane."""

    @abstractmethod
    def write_coolant(self, on: bool) -> None:
        """Coolant on or off."""

    @abstractmethod
    def write_dwell(self, seconds: float) -> None:
        """A dwell."""

    @abstractmethod
    def write_speed(self, rpm: float) -> None:
        """Another speed."""

    @abstractmethod
    def write_halt(self) -> None:
        """A stop for the operator."""

    @abstractmethod
    def again(self) -> None:
        """A stretch that is run several times: a loop, a subprogram."""

    @abstractmethod
    def holes(self) -> None:
        """A drilling cycle at some places."""

    @abstractmethod
    def framed(self) -> None:
        """Cuts in another frame."""
