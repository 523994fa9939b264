"""What APT's words switch: feed, spindle, coolant, tools, dwells and stops."""

from __future__ import annotations

import math
from collections.abc import Mapping

from camrob.witness.cl.drilling import feed_unit
from camrob.witness.cl.placing import Placing
from camrob.witness.cl.source import Statement, number
from camrob.witness.cl.teller import Teller
from camrob.witness.happenings import Kind
from camrob.witness.units import INCH_MM, mm_to_m

__all__ = ["LATHE", "AptProcess"]

LATHE = "a turning tool, against which the part turns"
"""Of a file that no robot with a spindle can work."""

_LATHE = frozenset(("TURN", "GROOVE", "THREAD"))  # words of tools that a part turns against
_SENSES = {"CCLW": "CCLW", "CCW": "CCLW", "CLW": "CLW", "CW": "CLW"}


class AptProcess:
    """The process of one file. tools: diameters (m) of the set-up's by their numbers, 0 for any."""

    def __init__(self, tell: Teller, dialect: str, place: Placing, tools: Mapping[int, float]) -> None:
        self._tell, self._dialect, self._place, self._tools = tell, dialect, place, tools
        self._cut_by: tuple[float, ...] = ()  # the numbers of CUTTER
        self._wide, self._number = 0.0, 0  # the cutter's diameter as the file has it, m; the tool's number
        self._per = ""  # unit of the feed
        self._fixed_units = False  # the caller has said the unit, over what the file says
        self._by_number = False  # TOOLNO, or a cutter of another size, changes the tool: nothing else in the file does
        self._unknown: dict[str, int] = {}

    def _fedrat(self, s: Statement) -> None:
        values = s.numbers
        known = [w for w in s.words if feed_unit(w, 1.0)]
        if len(values) != len(s.fields) - len(known) or len(known) > 1 or len(values) > 1:
            self._tell.set_feed(0.0, "min")
            self._tell.gap(s.line, f"FEDRAT/{s.rest.strip()[:40]}: not understood", last=s.last, lost=False)
            return
        self._per = known[0] if known else self._per or "PERMIN"
        one, per = feed_unit(self._per, self._place.scale, forced=self._fixed_units) or (0.0, "min")
        if values:
            self._tell.set_feed(values[0] * one, per)

    def _spindl(self, s: Statement) -> None:
        fields, most = s.fields, math.inf
        for word in ("RANGE", "MAXRPM"):  # each takes the field behind it
            if word in fields:
                at = fields.index(word)
                most = (number(fields[at + 1]) or most) if word == "MAXRPM" and at + 1 < len(fields) else most
                del fields[at : at + 2]
        values = [v for v in map(number, fields) if v is not None]
        words = set(fields)
        sense = next((said for w, said in _SENSES.items() if w in words), None)
        strange = {"SFPM", "CSS", "INCR", "REVERSE"} & words
        if {"OFF", "NOMORE", "STOP", "LOCK", "ORIENT", "NEUTRL"} & words or values == [
            0.0
        ]:  # locked at an angle, it stands
            self._tell.spindle_off(s.line)
        elif {"SFM", "SMM"} & words and len(values) == 1:
            self._tell.spindle(s.line, min(self._turns(values[0], "SFM" in words), most), sense)
        elif strange or len(values) > 1 or not (values or {"ON", *_SENSES} & words):
            self._tell.spindle(s.line, float("nan"), sense)
        else:
            self._tell.spindle(s.line, min(values[0], most) if values else None, sense)

    def _turns(self, speed: float, feet: bool) -> float:
        """rev/min of a surface speed in feet or metres a minute: by the cutter, the set-up's tool, or the set-up's speed."""
        tools = self._tools
        size = self._wide or tools.get(self._number) or tools.get(0)
        if not size:
            return self._tell.default_rpm or math.nan
        return speed * (mm_to_m(12.0 * INCH_MM) if feet else 1.0) / (math.pi * size)

    def _coolnt(self, s: Statement) -> None:
        words = s.words
        self._tell.coolant(
            s.line, None if {"OFF", "NOMORE"} & set(words) else next((w for w in words if w != "ON"), "")
        )

    def _load(self, s: Statement) -> None:
        words = [w for w in s.words if w not in ("TOOL", "ADJUST", "MANUAL")]
        if (s.major == "LOAD" and "TOOL" not in s.fields) or (s.major == "TURRET" and not s.numbers):
            self._unknown[s.major] = self._unknown.get(s.major, 0) + 1  # TURRET/LEFT: which turret
            return
        self._number = int(s.numbers[0]) if s.numbers else 0
        self._tell.tool(s.line, s.numbers[0] if s.numbers else 0.0, "" if s.numbers else next(iter(words), ""))

    def _toolno(self, s: Statement) -> None:
        """A description, and the change itself where the file has no other word for it."""
        self._turns_the_part(s)
        if self._by_number and s.numbers:
            self._number = int(s.numbers[0])
            self._tell.tool(s.line, s.numbers[0])

    def _turns_the_part(self, s: Statement) -> None:
        """A tool that stands still while the part turns."""
        if _LATHE & set(s.words):
            self._tell.gap(s.line, LATHE, lost=False)

    def _unload(self, s: Statement) -> None:
        self._tell.unload(s.line)

    def _tldata(self, s: Statement) -> None:
        self._turns_the_part(s)
        if s.numbers and not _LATHE & set(s.words):
            self._wide = s.numbers[0] * self._place.scale

    def _cutter(self, s: Statement) -> None:
        """The cutter's measures: where no statement names tools (.clt, and others), other measures are another tool."""
        before, self._cut_by = self._cut_by, tuple(s.numbers)
        another = self._by_number and not self._number and any(before) and before != self._cut_by and self._tell.n > 0
        self._wide = s.numbers[0] * self._place.scale if s.numbers else 0.0
        if self._dialect == "camworks-clt" or another:
            self._tell.tool(s.line, 0.0, "CUTTER " + " ".join(f"{value:g}" for value in s.numbers))

    def _delay(self, s: Statement) -> None:
        values = s.numbers
        seconds = values[0] if len(values) == 1 and set(s.words) <= {"REV", "SEC"} else float("nan")
        if "REV" in s.words:
            seconds = seconds * 60.0 / self._tell.rpm if self._tell.rpm else float("nan")
        if not seconds >= 0.0:
            self._tell.gap(s.line, "DELAY of a time that is not known", lost=False)
        self._tell.event(Kind.DWELL, s.line, seconds)

    def _stop(self, s: Statement) -> None:
        self._tell.event(Kind.STOP, s.line)

    def _auxfun(self, s: Statement) -> None:
        """M codes by hand: those of spindle, coolant and stops are what they are anywhere."""
        code = s.numbers[0] if s.major == "AUXFUN" and len(s.numbers) == 1 and not s.words else math.nan
        if code in (3, 4, 13, 14):
            self._tell.spindle(s.line, None, "CLW" if code in (3, 13) else "CCLW")
        if code in (7, 8, 13, 14):
            self._tell.coolant(s.line, "MIST" if code == 7 else "FLOOD")
        if code in (5, 19):
            self._tell.spindle_off(s.line)
        elif code == 9:
            self._tell.coolant(s.line, None)
        elif code in (0, 1):
            self._tell.event(Kind.STOP, s.line)
        if code in (0, 1, 3, 4, 5, 7, 8, 9, 13, 14, 19):
            return
        self._tell.gap(s.line, f"{s.major}: a code of the machine's own", last=s.last, lost=False)
