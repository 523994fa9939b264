"""Heidenhain's drilling cycles as the moves that they stand for (TNC 640, "Machining Cycles")."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence

from camrob.errors import ToolpathError
from camrob.toolpath.gcode.controls.heidenhain_old_cycles import BACK, OldCycle
from camrob.toolpath.gcode.controls.heidenhain_words import VALUE
from camrob.toolpath.gcode.lexer import Block
from camrob.units import deg_to_rad

__all__ = ["CYCLES", "RAPID", "REASONS", "Cycle", "Places", "pattern_of", "places_of"]

Places = list[dict[str, float]]
"""X and Y of places at which a cycle is done, in the program's unit."""

# Q numbers: 200 clearance, 201 depth, 202 bite, 203 surface, 204 second clearance, 206 feed, 208 feed out, 212 decrement,
# 239 pitch of a thread, 257 infeed for breaking chips, 258 and 259 how far above the first and the last bite a rapid back ends
_NEEDED = {
    200: (200, 201, 202, 203, 204, 206),
    201: (200, 201, 203, 204, 206, 208),
    203: (200, 201, 202, 203, 204, 206, 208, 212, 213, 205),
    205: (200, 201, 202, 203, 204, 205, 206, 212, 257, 258, 259),
    206: (200, 201, 203, 204, 206),
    207: (200, 201, 203, 204, 239),
    240: (200, 201, 203, 204, 206, 343),
}
CYCLES = frozenset(_NEEDED)
_INSIDE = "how the control cuts it depends on the tool's radius in its table, and on steps of its own"
_HELD = "the spindle is held at an angle while the tool is drawn off the wall, which a robot's spindle can't be told"
REASONS: dict[str, str] = {
    **dict.fromkeys(("202", "204"), _HELD),
    **dict.fromkeys(
        ("3", "4", "5", "208", "251", "252", "253", "254", "256", "257", "258", "233", "230", "232", "262", "263"),
        _INSIDE,
    ),
    "12": "another program that CYCL CALL then runs as a cycle",
    "13": _HELD,
    "18": "a thread that the spindle's angle is coupled to",
    "241": "the control switches the spindle's speed, its sense and the coolant inside the hole",
    **dict.fromkeys(("209",), "a tap that is turned back and forth to break chips, coupled to the spindle's angle"),
    **dict.fromkeys(
        ("6", "14", "15", "16", "20", "21", "22", "23", "24", "25", "27", "28", "270", "275"),
        "a contour that the control itself clears",
    ),
}
"""Why cycles are not read, by their numbers."""
_MOST_PLACES = 10_000  # of a pattern
_MOST_PECKS = 2000  # of one hole: a slip of the decimal point has more
_EVEN = 1e-9  # of the program's unit
RAPID = 99999.0
"""What FMAX is written as where a feed stands."""
_BREAK = 0.2  # mm: Q256 where it is left out


class Cycle:
    """The cycle in force. Its parameters are Q parameters of the program: what one is given behind the definition holds from the
    next call on, but not what the ones that it was defined by are given (TNC 640, "Machining Cycles", 2.1).

    worth: of a number, a parameter, FAUTO or FMAX. keep: what a Q parameter holds from then on, None where it is no number.
    """

    def __init__(self, worth: Callable[[str], float], keep: Callable[[int, float | None], None]) -> None:
        self._worth, self._keep = worth, keep
        self.mm = 1.0  # in one of the program's units
        self._number = 0
        self._q: dict[int, float] = {}
        self._old: OldCycle | None = None

    @property
    def level(self) -> float:
        """The height at which a hole ends. Raises ToolpathError without a cycle, and where it names no surface."""
        self._is_there()
        if not self._q:
            raise ToolpathError(
                f"cycle {self._number} at a place: it names no surface", hint="position by L, and call with M99"
            )
        return _level(self._q)

    def _is_there(self) -> None:
        if not self._number:
            raise ToolpathError("a cycle call without a cycle", hint="define it before")

    def parameters(self, text: str) -> dict[int, float]:
        """Those that a CYCL DEF gives, by their Q numbers; the program's hold them from then on."""
        text = re.sub(r"(?<=[-+]) (?=[.0-9Q])", "", text)
        found = {int(k): v for k, v in re.findall(rf"\bQ([0-9]+) ?= ?({VALUE}|(?:F ?)?(?:AUTO|MAX)\b)", text)}
        values = {k: self._worth(f"F{v}" if v in ("AUTO", "MAX") else v) for k, v in found.items()}  # Fusion: Q208=MAX
        for k, v in values.items():
            self._keep(k, None if found[k].endswith(("AUTO", "MAX")) else v)
        return values

    def define(self, number: int, text: str) -> None:
        """CYCL DEF of one of CYCLES. Raises ToolpathError where its parameters make no hole, or one that isn't certain."""
        self._number, self._q, self._old = number, self.parameters(text), None
        _check(number, self._q)

    def define_old(self, number: int, line: int, text: str) -> None:
        """CYCL DEF 1.0, 1.1, ... of one of OLD_CYCLES. Raises ToolpathError for a line that is not read."""
        if line == 0:
            self._number, self._q, self._old = number, {}, OldCycle(number)
        elif self._old is None or self._old.number != number:
            raise ToolpathError(f"CYCL DEF {number}.{line} without {number}.0", hint="check the cycle's lines")
        else:
            self._old.say(line, text, self._worth)

    def given(self, number: int, value: float) -> None:
        """The program gives a Q parameter a value. Raises ToolpathError as above."""
        if self._number and self._old is None:
            self._q[number] = value
            _check(self._number, self._q)

    def again(self, number: int, text: str) -> Places:
        """CYCL DEF 220 or 221: where the cycle in force is done at once, with the heights that they name."""
        if not self._number:
            raise ToolpathError(f"cycle {number} without a cycle before it", hint="define it before")
        said = self.parameters(text)
        places = _repeated(number, said)
        if self._old is not None:
            self._number, self._q = self._old.placed(said, self.mm)
        self._q |= {name: said[name] for name in (200, 203, 204)}
        _check(self._number, self._q)
        return places

    def drill(self, z: float | None, line: int, speed: float | None) -> Iterator[Block]:
        """The blocks of one hole from height `z`; `speed` is TOOL CALL's.

        Raises ToolpathError without a cycle, from an unknown height, or from below the clearance.
        """
        self._is_there()
        if self._old is None or self._q:
            yield from _drilled(self._number, self._q, z, line, speed)
            return
        if z is None:
            raise ToolpathError(f"cycle {self._number} from an unknown height", hint="name Z before it")
        number, q = self._old.twin(z, self.mm)
        _check(number, q)
        yield from _drilled(number, q, z, line, speed)

    def left_at(self, z: float | None) -> float | None:
        """The height at which a hole that was begun at `z` has left the tool: an old cycle's, where it began."""
        return z if self._old is not None and not self._q else self.level

    def placed(self) -> None:
        """The places of cycle 220 or 221 are done: an old cycle counts from where the tool stands again."""
        if self._old is not None:
            self._number, self._q = self._old.number, {}


def _check(number: int, q: Mapping[int, float]) -> None:
    """Raises ToolpathError where the parameters, by their Q numbers, make no hole, or one that isn't certain."""
    _complete(number, q, _NEEDED[number])
    if q.get(395) or q.get(343):
        raise ToolpathError(
            f"cycle {number} with Q395 or Q343: its depth by the tool's tip angle", hint="name the depth of the tip (0)"
        )
    bite = q.get(202, 0.0)
    if number == 205 and q.get(379):
        raise ToolpathError(
            "cycle 205 with Q379: a start inside the hole", hint="have the CAM system write the motions out"
        )
    least = max(q[205], 0.0) if number in (203, 205) and q[212] > 0.0 else bite
    endless = bite > 0.0 and (not least > 0.0 or -q[201] / least > _MOST_PECKS)
    broken = q.get(257, 0.0)
    stops = min(q.get(258, 0.0), q.get(259, 0.0), broken) < 0.0 or 0.0 < broken * _MOST_PECKS < -q[201]
    if stops or q[201] >= 0.0 or q[200] < 0.0 or q.get(212, 0.0) < 0.0 or q.get(208, 0.0) < 0.0 or endless:
        raise ToolpathError(
            f"cycle {number} with a depth or bite that makes no hole",
            hint="check Q200, Q201, Q202, Q205, Q208, Q212, Q257, Q258 and Q259",
        )


def _complete(number: int, q: Mapping[int, float], needed: Sequence[int]) -> None:
    missing = [name for name in needed if name not in q]
    if missing:
        raise ToolpathError(f"cycle {number} without Q{missing[0]}", hint="name all its parameters")


def _level(q: Mapping[int, float]) -> float:
    """The height at which a hole ends."""
    return q[203] + max(q[200], q[204])


def places_of(text: str, pattern: Places | None, value: Callable[[str], float]) -> tuple[list[int], Places | None]:
    """The M functions of CYCL CALL, and X and Y of CYCL CALL POS, or those of `pattern` for CYCL CALL PAT, else None.

    Raises ToolpathError for what is not read. Z of CYCL CALL POS shifts the cycle, and is read as 0 only.
    """
    codes = [int(n) for n in re.findall(r"\bM([0-9]+)", text)]
    if re.fullmatch(r"CYCL CALL(?: F[^ ]+| M[0-9]+)*", text):
        return codes, None
    call = re.match(rf"CYCL CALL P(?:OS((?: [XYZ] ?{VALUE})+)|AT)((?: F ?[A-Z0-9.]+| R0| M[0-9]+)*)$", text)
    if call is None:
        raise ToolpathError(f"{text[:20]!r} is not read", hint="position by L, and call with CYCL CALL or M99")
    if "FMAX" not in call[2].replace(" ", ""):
        raise ToolpathError(f"{text[:13]} at a feed", hint="call with FMAX")
    if call[1] is None:
        if pattern is None:
            raise ToolpathError("CYCL CALL PAT without a pattern", hint="put PATTERN DEF before it")
        return codes, pattern
    to = {k: value(v) for k, v in re.findall(rf"([XYZ]) ?({VALUE})", call[1])}
    if to.pop("Z", None) != 0.0:
        raise ToolpathError("CYCL CALL POS with another Z than 0", hint="Z+0 FMAX, the surface by Q203")
    return codes, [to]


_PATTERN = re.compile(r" ?(POS|ROW|CIRC|PITCHCIRC)[0-9]+ ?\(([^()]*)\)")
_OF_PATTERN = {
    "POS": "X Y Z",
    "ROW": "X Y D NUM ROT Z",
    "CIRC": "X Y D START NUM Z",
    "PITCHCIRC": "X Y D START STEP NUM Z",
}


def pattern_of(text: str, value: Callable[[str], float]) -> Places:
    """The places of PATTERN DEF (TNC 640, "Machining Cycles", 2.3). Raises ToolpathError for fields, and for another Z."""
    out: Places = []
    at = 0
    while at < len(text):
        found = _PATTERN.match(text, at)
        words = re.findall(rf"([A-Z]+) ?({VALUE})", found[2]) if found else []
        if found is None or [name for name, _ in words] != _OF_PATTERN[found[1]].split():
            raise ToolpathError(f"PATTERN DEF{text[at : at + 24]} is not read", hint="post each place by itself")
        at, said = found.end(), {name: value(given) for name, given in words}
        if said["Z"]:
            raise ToolpathError("PATTERN DEF with another Z than 0", hint="name the surface by Q203")
        if found[1] == "POS":
            out.append({"X": said["X"], "Y": said["Y"]})
        elif found[1] == "ROW":
            out += _grid((said["X"], said["Y"]), (said["D"], 0.0), (_count(said["NUM"]), 1), said["ROT"])
        else:
            count = _count(said["NUM"])
            out += _ring((said["X"], said["Y"]), said["D"], said["START"], said.get("STEP", 360.0 / count), count)
    return out


def _count(number: float) -> int:
    if number % 1.0 or not 1.0 <= number <= _MOST_PLACES:
        raise ToolpathError(f"a pattern of {number:g} places", hint="check the number")
    return int(number)


def _ring(center: tuple[float, float], diameter: float, start: float, step: float, count: int) -> Places:
    angles = [deg_to_rad(start + step * i) for i in range(count)]
    return [
        {"X": center[0] + 0.5 * diameter * math.cos(a), "Y": center[1] + 0.5 * diameter * math.sin(a)} for a in angles
    ]


def _grid(start: tuple[float, float], steps: tuple[float, float], counts: tuple[int, int], turned: float) -> Places:
    """Row by row, every second one from its far end; turned about the first place."""
    c, s = math.cos(deg_to_rad(turned)), math.sin(deg_to_rad(turned))
    out: Places = []
    for row in range(counts[1]):
        across = range(counts[0]) if row % 2 == 0 else range(counts[0] - 1, -1, -1)
        for i in across:
            u, v = steps[0] * i, steps[1] * row
            out.append({"X": start[0] + c * u - s * v, "Y": start[1] + s * u + c * v})
    return out


def _repeated(number: int, q: Mapping[int, float]) -> Places:
    """Where cycles 220 (a circle) and 221 (rows) have the cycle before them done. Raises ToolpathError for values left out."""
    needed = (216, 217, 244, 245, 247, 241) if number == 220 else (225, 226, 237, 238, 242, 243, 224)
    _complete(number, q, (*needed, 200, 203, 204))
    if number == 221:
        counts = _count(q[242]), _count(q[243])
        _count(q[242] * q[243])
        return _grid((q[225], q[226]), (q[237], q[238]), counts, q[224])
    if q[247] == 0.0 and q[241] > 1.0:
        raise ToolpathError("cycle 220 by its last angle (Q247=0)", hint="name the step, Q247")
    if q.get(365):
        raise ToolpathError("cycle 220 with rapids along the circle (Q365)", hint="post each place by itself")
    return _ring((q[216], q[217]), q[244], q[245], q[247], _count(q[241]))


def _tapped(number: int, q: Mapping[int, float], line: int, speed: float | None) -> Iterator[Block]:
    """Cycles 206 and 207, as a tap in a floating holder goes: G84 or, for a left-hand thread, G74."""
    pitch = q.get(239, 0.0)
    if number == 207 and not (pitch and speed):
        raise ToolpathError("cycle 207 without its pitch Q239, or a speed in TOOL CALL", hint="name both")
    words = {"Z": q[203] + q[201], "R": q[203] + q[200], "F": abs(pitch) * (speed or 0.0) if number == 207 else q[206]}
    if q.get(211):
        words["P"] = q[211]
    yield Block(line, words, (990, 740 if pitch < 0.0 else 840))


def _drilled(number: int, q: Mapping[int, float], z: float | None, line: int, speed: float | None) -> Iterator[Block]:
    """The blocks of one hole from height `z`: bites from the surface Q203, out to the clearance Q200 between them.

    `speed` is TOOL CALL's. Raises ToolpathError from an unknown height, or from below the clearance.
    """
    top = q[203] + q[200]
    if z is None or z < top - _EVEN:
        raise ToolpathError(
            f"cycle {number} from an unknown height, or from below its clearance", hint="name Z before it"
        )
    yield Block(line, {"Z": top}, (0,))
    if number in (206, 207):
        yield from _tapped(number, q, line, speed)
        yield Block(line, {"Z": _level(q)}, (0,))
        return
    yield from _down(number, q, line)
    yield from _dwell(q.get(211), line)
    if number in (201, 203) or (number == 205 and 208 in q):
        yield _out(q, top, line)
    yield Block(line, {"Z": _level(q)}, (0,))


def _down(number: int, q: Mapping[int, float], line: int) -> Iterator[Block]:
    """To the depth, bite by bite; cycles 203 and 205 take Q212 off each, 203 breaks the chip Q213 times before it comes out."""
    if number == 205:
        yield from _universal(q, line)
        return
    top, depth, bite, breaks = q[203] + q[200], q[203] + q[201], q.get(202, 0.0) if number in (200, 203) else 0.0, 0
    at = q[203]
    while at > depth + _EVEN:
        at = max(depth, at - bite) if bite > 0.0 else depth
        yield Block(line, {"Z": at, "F": q[206]}, (10,))
        if at <= depth + _EVEN:
            return
        breaks += 1
        if number == 203 and breaks <= q[213]:
            yield Block(line, {"Z": min(top, at + (q.get(256) or _BREAK))}, (0,))
        else:
            breaks = 0
            yield _out(q, top, line) if number == 203 else Block(line, {"Z": top}, (0,))
            yield from _dwell(q.get(210), line)
            yield Block(line, {"Z": min(top, at + q.get(BACK, q[200]))}, (0,))
        if number == 203:
            bite = _next_bite(q, bite)


def _next_bite(q: Mapping[int, float], bite: float) -> float:
    return max(bite - q[212], min(q[205], bite)) if q[212] > 0.0 else bite


def _universal(q: Mapping[int, float], line: int) -> Iterator[Block]:
    """Cycle 205: out in rapid behind each bite, and back to Q258 above the first, Q259 above the last but one, evenly between.

    Within a bite the chip is broken every Q257 by drawing back Q256; 0: not at all.
    """
    top, depth, bite = q[203] + q[200], q[203] + q[201], q[202]
    ends = [q[203] - bite] if 0.0 < bite < -q[201] - _EVEN else [depth]
    while ends[-1] > depth + _EVEN:
        bite = _next_bite(q, bite)
        ends.append(max(depth, ends[-1] - bite))
    for i, end in enumerate(ends):
        begun = ends[i - 1] if i else q[203]
        for k in range(1, math.ceil((begun - end - _EVEN) / q[257]) if q[257] else 0):
            at = begun - k * q[257]
            yield Block(line, {"Z": at, "F": q[206]}, (10,))
            yield Block(line, {"Z": min(top, at + (q.get(256) or _BREAK))}, (0,))
        yield Block(line, {"Z": end, "F": q[206]}, (10,))
        if i + 1 < len(ends):
            share = i / max(len(ends) - 2, 1)
            yield Block(line, {"Z": top}, (0,))
            yield Block(line, {"Z": min(top, end + q[258] + share * (q[259] - q[258]))}, (0,))


def _out(q: Mapping[int, float], top: float, line: int) -> Block:
    """Out to the clearance at Q208, or at the feed in where that is 0."""
    feed = q[208] or q[206]
    return Block(line, {"Z": top}, (0,)) if feed >= RAPID else Block(line, {"Z": top, "F": feed}, (10,))


def _dwell(seconds: float | None, line: int) -> Iterator[Block]:
    if seconds:
        yield Block(line, {"P": seconds}, (40,))
