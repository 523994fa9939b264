"""What Heidenhain's TOOL CALL, its cycles' parameters and its cycles 8 and 10 say."""

from __future__ import annotations

import math
import re

from camrob.witness.cl.foreign.computed_values import Values
from camrob.witness.cl.foreign.foreign_cycles import Hole, klartext_hole
from camrob.witness.cl.foreign.foreign_words import UnreadError
from camrob.witness.cl.foreign.klartext_old import OldValues
from camrob.witness.units import deg_to_rad

__all__ = [
    "ARC_BY_MACHINE",
    "FEED_BY_TOOL",
    "NUMBER",
    "CycleInForce",
    "feed_words",
    "pattern_places",
    "statements",
    "tool_words",
]

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"
"""A number, as a pattern."""
ARC_BY_MACHINE = "an arc, or a polar motion, by positions of the machine (M91, M92)"
FEED_BY_TOOL = "a feed per tooth, or one per turn behind another speed"
"""Of programs that camrob refuses, beside: nothing that is made of one can be right."""
_AT_ONCE = "99999"  # a feed that stands for FMAX
_FIRST_OF_CYCLES = 200  # parameters from here on are those of cycles
_PATTERNS = {
    "POS": (),
    "ROW": ("D", "NUM", "ROT"),
    "CIRC": ("D", "START", "NUM"),
    "PITCHCIRC": ("D", "START", "STEP", "NUM"),
}  # what each kind has to name besides X, Y and Z
_MOST_PLACES = 10_000


def statements(text: str) -> list[tuple[int, str]]:
    """Statements with their lines: block numbers, comments and a sheet before the program off, lines of one joined."""
    rows: list[tuple[int, str]] = []
    goes_on = cycle = remark = False
    for i, raw in enumerate(text.split("\n"), 1):
        going = raw.rstrip().endswith("~")
        if remark or (going and re.match(r"\s*(\d+\s+)?;", raw)):
            remark = going  # a comment that goes on in the next line
            continue
        row = re.sub(r"(?<=\d),(?=\d)", ".", " ".join(raw.partition(";")[0].split()).upper())
        if re.match(
            r"/? ?(N?\d+ )?/? ?(LN?|C[CPRT]?|LP|M\d+|RND|CHF)\b", row
        ):  # brackets mean nothing there but a remark
            row = re.sub(r"\([^()]*\)?", "", row).strip()
        cycle = cycle and bool(re.match(r"Q[2-4]\d\d ?= ?\S+$", row))  # values of a cycle, a line each
        if (goes_on or cycle) and rows:
            rows[-1] = (rows[-1][0], f"{rows[-1][1]} {row.rstrip('~ ')}")
        elif row := re.sub(r"^/? ?(?:N?\d+(?: |$))?/? ?", "", row.rstrip("~ ")):
            rows.append((i, _joined_signs(row)))
            cycle = bool(re.match(r"CYCL DEF [2-4]\d\d\b(?!\.)", row)) and "=" not in row
        goes_on = going
    first = next((k for k, (_, row) in enumerate(rows) if row.startswith("BEGIN PGM")), 0)
    return [row for k, row in enumerate(rows) if k >= first or row[1][0] != "("]


def _joined_signs(row: str) -> str:
    """X + 90 as X+90, where no formula and no parameter of a cycle stands; 7.1 without axes for a shift that ends."""
    row = "TRANS DATUM AXIS X+0 Y+0 Z+0" if row == "TRANS DATUM RESET" else row
    if row.startswith(("FN", "Q", "*", "BLK")) or "=" in row:
        return row
    return re.sub(r"(?<=[A-Z])\s?([-+])\s?(?=[.\dQ])", r"\1", row).replace("DR -", "DR-").replace("DR +", "DR+")


def tool_words(text: str) -> tuple[str | None, str | None, str | None]:
    """Tool (number or name in quotes), speed and feed of what stands behind TOOL CALL. Raises UnreadError for more than these."""
    found = re.fullmatch(
        rf"(\d+|\"[^\"]*\")?\s*(?:Z)?\s*(?:S\s?({NUMBER}))?\s*(?:F\s?({NUMBER}))?\s*(?:D[LR]2?[-+]?0*\.?0* ?)*",
        re.sub(rf"\b(F\s?{NUMBER})\s+(S\s?{NUMBER})", r"\2 \1", text),
    )
    if re.search(r"\bF[UZ]", text):
        raise UnreadError(FEED_BY_TOOL)
    if found is None:
        raise UnreadError("TOOL CALL by a name, with another axis, or with an offset")
    return found[1], found[2], found[3]


def feed_words(words: dict[str, str], turns: float | None) -> tuple[list[str], bool]:
    """F of a motion as a word, none where it names none, and whether it is one of FU; takes it out of `words`.

    turns: of the spindle a minute. Raises UnreadError for FZ, and for FU without a speed.
    """
    if "FZ" in words:
        raise UnreadError(FEED_BY_TOOL)
    if "FU" not in words:
        return ([f"F{words.pop('F')}"] if "F" in words else []), False
    if not turns or "F" in words:
        raise UnreadError("FU without a speed")
    return [f"F{float(words.pop('FU')) * turns:.9f}"], True


def pattern_places(row: str) -> list[tuple[float, float]]:
    """X and Y of PATTERN DEF's places: single ones, a row, a circle, a part of one. Raises UnreadError for others."""
    out: list[tuple[float, float]] = []
    rest = row.removeprefix("PATTERN DEF").strip()
    while rest:
        head = re.match(rf"({'|'.join(_PATTERNS)})\d+\s?\(([^()]*)\)\s?", rest)
        if head is None:
            raise UnreadError(f"{row[:24]}, of Heidenhain's language")
        rest = rest[head.end() :]
        said = {name: float(value) for name, value in re.findall(rf"([A-Z]+)\s?({NUMBER})", head[2])}
        needed = {"X", "Y", *_PATTERNS[head[1]]}
        if not needed <= said.keys() or said.get("Z") != 0.0 or not _countable(said.get("NUM", 1.0)):
            raise UnreadError(f"{row[:24]}, of Heidenhain's language")
        x, y, count = said["X"], said["Y"], int(said.get("NUM", 1.0))
        if head[1] == "POS":
            out.append((x, y))
        elif head[1] == "ROW":
            along = deg_to_rad(said["ROT"])
            out += [(x + k * said["D"] * math.cos(along), y + k * said["D"] * math.sin(along)) for k in range(count)]
        else:
            out += _on_circle((x, y), said["D"], said["START"], said.get("STEP", 360.0 / count), count)
    return out


def _countable(number: float) -> bool:
    """Whether so many places can be meant."""
    return 1.0 <= number <= _MOST_PLACES and number % 1.0 == 0.0


def _on_circle(
    middle: tuple[float, float], across: float, first: float, step: float, count: int
) -> list[tuple[float, float]]:
    rays = [deg_to_rad(first + k * step) for k in range(count)]
    return [(middle[0] + across / 2.0 * math.cos(ray), middle[1] + across / 2.0 * math.sin(ray)) for ray in rays]


class CycleInForce:
    """The cycle that a call runs, by parameters that are the program's own: what one is given behind the definition holds."""

    def __init__(self, computed: Values) -> None:
        self._computed = computed
        self._number, self._q = "", dict[int, float]()
        self._hole: Hole | None = None
        self._old: OldValues | None = None

    @property
    def hole(self) -> Hole:
        """What a call does. Raises UnreadError where nothing is in force."""
        if self._hole is None:
            raise UnreadError("a cycle call without a cycle that is read")
        return self._hole

    def take(self, rest: str, called_feed: str) -> dict[int, float]:
        """The parameters that a CYCL DEF names; FAUTO is TOOL CALL's feed, FMAX as fast as can be."""
        rest = re.sub(r"= ?([-+]) ", r"=\1", rest)
        for name in re.findall(r"\bQ\d+(?= ?=)", rest):
            self._computed.forget(name)
        plain = {int(k): float(v) for k, v in re.findall(rf"\bQ(\d+) ?= ?({NUMBER})(?![\d.])", rest)}
        for number, value in plain.items():
            self._computed.put(f"Q{number}", value)
        feeds = {"MAX": float(_AT_ONCE)} | ({"AUTO": float(called_feed)} if called_feed else {})
        words = re.findall(r"\bQ(\d+) ?= ?(?:F ?)?(MAX|AUTO)\b", rest)
        return plain | {int(k): feeds[word] for k, word in words if word in feeds}

    def define(self, number: str, q: dict[int, float]) -> None:
        """A cycle is in force from here on. Raises UnreadError for one that isn't read."""
        self._number, self._q, self._old = number, q, None
        self._hole = klartext_hole(number, q)

    def define_old(self, number: str, line: str, rest: str, scale: float) -> None:
        """A line of cycle 1, 2 or 17; scale: metres in one of the program's units. Raises UnreadError for another line."""
        if line == "0":
            self._number, self._q, self._hole, self._old = number, {}, None, OldValues(number, scale)
        elif self._old is None or self._old.number != number:
            raise UnreadError(f"CYCL DEF {number}.{line} without {number}.0")
        else:
            self._old.say(int(line), rest, self._computed.of)

    def hole_from(self, height: float | None) -> Hole:
        """What a call does where the tool stands so high. Raises UnreadError as `hole`, and for an old cycle from nowhere."""
        if self._hole is not None or self._old is None:
            return self.hole
        if height is None:
            raise UnreadError("a cycle from a height that isn't known")
        return self._old.hole(height)

    def places_done(self) -> None:
        """An old cycle counts its heights from where the tool stands again."""
        if self._old is not None:
            self._hole = None

    def again(self, number: str, q: dict[int, float]) -> list[tuple[float, float]]:
        """Where cycles 220 and 221 have the cycle before them done, which has the heights that they name from here on.

        Raises UnreadError without one, and for parameters left out.
        """
        names = (216, 217, 241, 244, 245, 247) if number == "220" else (224, 225, 226, 237, 238, 242, 243)
        known = self._number and {*names, 200, 203, 204} <= q.keys()
        counts = [q.get(name, 1.0) for name in (241, 242, 243)]
        countable = all(map(_countable, (*counts, math.prod(counts[1:]))))
        if not known or not countable or (number == "220" and (not q[247] or q.get(365))):
            raise UnreadError(f"CYCL DEF {number} without a cycle, or its values")
        if number == "220":
            places = _on_circle((q[216], q[217]), q[244], q[245], q[247], int(q[241]))
        else:
            columns, rows, ray = int(q[242]), int(q[243]), deg_to_rad(q[224])
            grid = [(k if row % 2 == 0 else columns - 1 - k, row) for row in range(rows) for k in range(columns)]
            flat = [complex(k * q[237], row * q[238]) * complex(math.cos(ray), math.sin(ray)) for k, row in grid]
            places = [(q[225] + z.real, q[226] + z.imag) for z in flat]
        if self._old is not None:
            self._hole = self._old.placed(q)
        else:
            self.define(self._number, self._q | {name: q[name] for name in (200, 203, 204)})
        return places

    def given(self, name: str) -> None:
        """Q201 = ... changes the cycle in force. Raises UnreadError as above."""
        if self._number and self._old is None and name[1:].isdigit() and int(name[1:]) >= _FIRST_OF_CYCLES:
            self.define(self._number, self._q | {int(name[1:]): self._computed.of(name)})
