"""CL data of the APT family: NX CLSF, Creo NCL, CATIA aptsource, CAMWorks .apt and .clt, Makino, plain ISO APT.

`AptReader._vocabulary` lists what each word does; a word that is not in it and carries coordinates is a gap.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.witness.cl.curve import Curve
from camrob.witness.cl.drilling import UPWARD, Cycle, apt_cycle, drill, feed_unit
from camrob.witness.cl.offsets import Offsets
from camrob.witness.cl.placing import Placing
from camrob.witness.cl.source import Run, Source, Statement, number
from camrob.witness.cl.teller import Teller, unit
from camrob.witness.cl.words import CANCELS, CURVE, DRIVE, ENDS, HIDING, NO_AXIS, NOTHING, ONCE, STRANGE
from camrob.witness.happenings import Kind, Way
from camrob.witness.units import INCH_MM, mm_to_m

__all__ = ["AptReader"]

Array = NDArray[np.float64]

_REVERSED = ("nx-clsf", "makino")  # CIRCLE's axis is printed the other way round


class AptReader:
    """Tells what the statements of one file ask for."""

    def __init__(
        self, tell: Teller, dialect: str, units: str, fixed_units: bool, offsets: Offsets, tools: Mapping[int, float]
    ) -> None:
        self._offsets = offsets
        self._tell, self._dialect, self._fixed_units = tell, dialect, fixed_units
        self._place = Placing(tell, dialect, units)
        self._tools = tools  # diameters of the set-up's tools, m
        self._wide, self._number = 0.0, 0  # the cutter's diameter as the file has it, m; the tool's number
        self._rapid = False
        self._circle: tuple[Array, Array, int] | None = None  # centre and axis in the part, further full turns
        self._cycle: Cycle | None = None
        self._curve: Curve | None = None
        self._per = ""  # unit of the feed
        self._direction: Array | None = None  # INDIRV
        self._opened = 0  # the line of a TOOL PATH or OPFEATSTART that is not closed yet
        self._silenced: set[str] = set()  # words that SYN turns into comments
        self._unknown: dict[str, int] = {}
        self._words = self._vocabulary()

    @property
    def units(self) -> str:
        """Of the file: "mm" or "inch"."""
        return self._place.units

    def read(self, text: str) -> None:
        """Reads all of the text. Raises ToolpathError where it is no CL data."""
        source = Source(text)
        while not source.done:
            if not (self._cycle or self._rapid or self._circle or self._curve) and (run := source.run()):
                self._run(run)
                continue
            statement = source.statement()
            if statement is None:
                continue
            if statement.major in ("FINI", "END"):
                self._end_curve()
                self._rest(source)
                break
            try:
                self._read(statement)
            except ToolpathError as error:
                raise ToolpathError(error.what, hint=error.hint, line=error.line or statement.line) from None
        self._end_curve()
        if self._opened:
            what = f"the file ends inside the operation that line {self._opened} begins: it was cut off"
            raise ToolpathError(what, hint="get the whole file from the CAM system", line=len(source.lines))
        if self._unknown:
            words = ", ".join(f"{word} ({count})" for word, count in self._unknown.items())
            self._tell.note(f"words that are not known and carry no coordinates, skipped: {words}")

    def _rest(self, source: Source) -> None:
        behind = [
            i for i in range(source.at, len(source.lines)) if re.match(r"\s*(GOTO|CIRCLE)\s*/", source.lines[i], re.I)
        ]
        if behind:
            self._tell.gap(source.at + 1, "motions behind the end of the program", last=behind[-1] + 1)

    def _read(self, s: Statement) -> None:
        if s.major not in ("KNOT", "CNTRL", "$$"):
            self._end_curve()
        if s.major == "$$":
            self._place.comment(s)
            self._offsets.comment(s)
            if re.match(r"\$\$(-> FEATNO\b|\s*OPERATION NAME\b)", s.rest):
                self._tell.mark()
        elif s.major in self._silenced:
            return
        elif s.major in self._words:
            self._words[s.major](s)
        elif DRIVE.fullmatch(s.major):
            raise ToolpathError(
                f"{s.major}: an APT part program, not CL data", hint="run it through the APT processor first"
            )
        elif len(s.numbers) >= 2 and not s.major.startswith("CSI_SET_"):  # CAMWorks' own settings
            strange = len(s.numbers) >= 3 and any(s.numbers)  # as three numbers are a place
            self._tell.gap(s.line, f"{s.major}: {STRANGE if strange else 'not known'}", last=s.last)
        else:
            self._unknown[s.major] = self._unknown.get(s.major, 0) + 1

    def _vocabulary(self) -> dict[str, Callable[[Statement], None]]:
        place = self._place
        own = {
            "GOTO": self._goto, "FROM": self._from, "GOHOME": self._gohome, "GODLTA": self._godlta, "RAPID": self._set_rapid,
            "CIRCLE": self._set_circle, "INDIRV": self._indirv, "TLON,GOFWD": self._tlon, "CYCLE": self._set_cycle,
            "MSYS": place.msys, "CSYS": place.csys, "TRNTYP": place.trntyp, "TLAXIS": place.tlaxis, "ROTABL": place.rotabl,
            "ROTHED": place.rotabl, "CAMERA": place.camera, "UNITS": self._set_units, "UNIT": self._set_units,
            "SET": self._set_mode, "FEDRAT": self._fedrat, "SPINDL": self._spindl, "COOLNT": self._coolnt, "LOAD": self._load,
            "LOADTL": self._load, "TURRET": self._load, "DELAY": self._delay, "STOP": self._stop, "OPSTOP": self._stop,
            "CUTTER": self._cutter, "TOOL PATH": self._tool_path, "END-OF-PATH": self._end_of_path, "OPFEATSTART": self._feature,
            "OPFEATEND": self._end_of_path, "CUTCOM": self._offsets.cutcom, "INSERT": self._insert,
            "TLDATA": self._tldata, **dict.fromkeys(CURVE, self._nurbs),
            "TLCOMP": self._offsets.cutcom, "SYN": self._syn, "AUXFUN": self._auxfun, "PREFUN": self._auxfun,
        }  # fmt: skip
        return {
            **dict.fromkeys(NOTHING, lambda s: None),
            **dict.fromkeys(HIDING, self._hide),
            **dict.fromkeys(ENDS, self._end_hidden),
            **dict.fromkeys(ONCE, self._once),
            **own,
        }

    # -- where the tool is

    def _points(self, s: Statement) -> list[float] | None:
        """3 or 6 numbers, the axis kept; None (and a gap) for anything else."""
        read = [number(f) for f in s.fields]
        if None in read:
            what = f"{s.major} with {s.fields[read.index(None)]!r} where a number has to be"
            raise ToolpathError(what, hint="APT part programs have to go through the APT processor first")
        values = [v for v in read if v is not None]
        axis = unit(np.array(values[3:])) if len(values) == 6 else None
        if len(values) not in (3, 6) or (len(values) == 6 and axis is None):
            self._tell.gap(
                s.line, NO_AXIS if len(values) == 6 else f"{s.major} with neither 3 numbers nor 6", last=s.last
            )
            return None
        self._place.axis = self._place.axis if axis is None else axis
        return values[:3]

    def _goto(self, s: Statement) -> None:
        point = self._points(s)
        circle, way = self._circle, Way.RAPID if self._rapid else Way.FEED
        self._circle, self._rapid = None, False
        if point is None:
            return
        tip, axis = self._place.point(point), self._place.along()
        if self._cycle:
            drill(self._tell, self._cycle, tip, axis, s.line)
        elif circle:
            self._tell.arc(tip, axis, circle[0], circle[1], way, s.line, circle[2])
        else:
            self._tell.move(tip, axis, way, s.line)

    def _run(self, run: Run) -> None:
        axes = np.where(np.isnan(run.axes), self._place.axis, run.axes)
        self._place.axis = axes[-1] / np.linalg.norm(axes[-1])
        axes = axes @ self._place.part_R_points.T
        tips = self._place.part_p_points + (run.points * self._place.scale) @ self._place.part_R_points.T
        self._tell.run(tips, axes / np.linalg.norm(axes, axis=1, keepdims=True), run.line)

    def _from(self, s: Statement) -> None:
        if (point := self._points(s)) is not None:
            self._tell.stand(self._place.point(point), self._place.along(), s.line)

    def _gohome(self, s: Statement) -> None:
        self._rapid = False
        if len(s.numbers) not in (3, 6):
            self._tell.lose()
        elif (point := self._points(s)) is not None:
            self._tell.move(self._place.point(point), self._place.along(), Way.RAPID, s.line)

    def _godlta(self, s: Statement) -> None:
        way, delta, here = Way.RAPID if self._rapid else Way.FEED, s.numbers, self._tell.here
        self._rapid = False
        if here is None or len(delta) not in (1, 3) or s.words:
            self._tell.gap(s.line, "GODLTA from where the tool isn't known to be", last=s.last)
            return
        step = self._place.part_R_points @ np.array(delta) if len(delta) == 3 else delta[0] * self._place.along()
        self._tell.move(here + step * self._place.scale, self._place.along(), way, s.line)

    def _set_rapid(self, s: Statement) -> None:
        self._rapid = True

    def _set_circle(self, s: Statement) -> None:
        values, fields = s.numbers, s.fields
        normal = unit(np.array(values[3:6])) if len(values) >= 6 else None
        if normal is None:
            self._tell.gap(s.line, "CIRCLE that has no centre and axis", last=s.last)
            return
        times = number(fields[fields.index("TIMES") + 1]) if "TIMES" in fields[:-1] else 0.0
        turned = self._dialect in _REVERSED or (self._dialect == "apt" and len(values) >= 11)
        if self._dialect == "apt":
            hand = "left" if turned else "right"
            self._tell.note(f"arcs run {hand}-handed about the axis of CIRCLE: the file doesn't say whose it is")
        if "CLOCKWISE" in fields or "COUNTERCLOCKWISE" in fields:
            turned = "CLOCKWISE" in fields
        axis = self._place.part_R_points @ (-normal if turned else normal)
        self._circle = (self._place.point(values[:3]), axis, int(times or 0))

    def _indirv(self, s: Statement) -> None:
        values = s.numbers
        self._direction = self._place.part_R_points @ np.array(values) if len(values) == 3 else None

    def _tlon(self, s: Statement) -> None:
        """CATIA's arc: (CIRCLE/centre, radius),ON,[2,INTOF,](LINE/centre, end), which sets out along INDIRV."""
        found = re.fullmatch(
            r"\(CIRCLE/([^()]*)\),ON,(?:2,INTOF,)?\(LINE/([^()]*)\)", re.sub(r"\s", "", s.rest.upper())
        )
        parts = [[number(f) for f in text.split(",")] for text in found.groups()] if found else []
        circle, ends = ([v for v in part if v is not None] for part in parts or ([], []))
        if len(circle) != 4 or len(ends) != 6 or [len(p) for p in parts] != [4, 6]:
            what = "TLON,GOFWD with other curves than a circle and a line of numbers: an APT part program"
            raise ToolpathError(what, hint="run it through the APT processor first")
        way, self._rapid = Way.RAPID if self._rapid else Way.FEED, False
        place, here, side = self._place, self._tell.here, 0.0
        center, axis = place.point(circle[:3]), place.along()
        spoke = place.point(ends[3:]) - center
        end = center + spoke * (circle[3] * place.scale / max(float(np.linalg.norm(spoke)), 1e-12))
        if here is not None and self._direction is not None:
            side = float(np.cross(here - center, self._direction) @ axis)
        if not side:
            self._tell.gap(s.line, "an arc whose start or INDIRV is not known", last=s.last)
        else:
            self._tell.arc(end, axis, center, axis if side > 0.0 else -axis, way, s.line)

    def _nurbs(self, s: Statement) -> None:
        if s.major == "NURBS":
            self._curve = Curve(s.line)
        elif self._curve:
            self._curve.add(s)
        else:
            self._tell.gap(s.line, f"{s.major} without NURBS", last=s.last)

    def _end_curve(self) -> None:
        """A curve whose statements have come to an end, as a cut."""
        curve, self._curve = self._curve, None
        if curve:
            curve.tell(self._tell, self._place, free=not (self._rapid or self._circle or self._cycle))
            self._rapid, self._circle = False, None

    def _set_cycle(self, s: Statement) -> None:
        fields = s.fields
        if not fields or fields[0] in ("OFF", "NOMORE"):
            self._cycle = None
        elif fields not in (["ON"], ["INIT"]):
            self._cycle = apt_cycle(fields, self._place.scale, self._dialect == "catia", self._tell)
            depth = number(fields[fields.index("FEDTO") + 1]) if "FEDTO" in fields[:-1] else None
            if self._dialect == "nx-clsf" and depth is not None and depth > 0.0:  # NX counts depths upwards
                self._cycle = Cycle(problem=UPWARD)

    # -- frames and units

    def _set_units(self, s: Statement) -> None:
        if self._fixed_units:
            return
        word = next(iter(s.words), "")
        if not word.startswith(("MM", "MILLI", "IN")):
            raise ToolpathError(f"{s.major}/{word}: neither MM nor INCHES", hint="give the units")
        self._place.units = "inch" if word.startswith("IN") else "mm"

    # -- the process

    def _fedrat(self, s: Statement) -> None:
        values = s.numbers
        known = [w for w in s.words if feed_unit(w, 1.0)]
        if len(values) != len(s.fields) - len(known) or len(known) > 1 or len(values) > 1:
            self._tell.set_feed(0.0, "min")
            self._tell.gap(s.line, f"FEDRAT/{s.rest.strip()[:40]}: not understood", last=s.last, lost=False)
            return
        self._per = known[0] if known else self._per or "PERMIN"
        one, per = feed_unit(self._per, self._place.scale) or (0.0, "min")
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
        sense = next((w for w in ("CCLW", "CLW") if w in words), None)
        strange = {"SFPM", "CSS"} & words
        if {"OFF", "LOCK", "ORIENT", "NEUTRL"} & words or values == [0.0]:  # locked at an angle, it stands
            self._tell.spindle_off(s.line)
        elif {"SFM", "SMM"} & words and len(values) == 1:
            self._tell.spindle(s.line, min(self._turns(values[0], "SFM" in words), most), sense)
        elif strange or len(values) > 1 or not (values or {"ON", "CLW", "CCLW"} & words):
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
        self._tell.coolant(s.line, None if "OFF" in words else next((w for w in words if w != "ON"), ""))

    def _load(self, s: Statement) -> None:
        words = [w for w in s.words if w not in ("TOOL", "ADJUST", "MANUAL")]
        if s.major == "LOAD" and "TOOL" not in s.fields:
            self._unknown["LOAD"] = self._unknown.get("LOAD", 0) + 1
            return
        self._number = int(s.numbers[0]) if s.numbers else 0
        self._tell.tool(s.line, s.numbers[0] if s.numbers else 0.0, "" if s.numbers else next(iter(words), ""))

    def _tldata(self, s: Statement) -> None:
        if s.numbers and not {"TURN", "GROOVE", "THREAD"} & set(s.words):
            self._wide = s.numbers[0] * self._place.scale

    def _cutter(self, s: Statement) -> None:
        """The cutter's measures: where no statement names tools (.clt), other measures are another tool."""
        self._wide = s.numbers[0] * self._place.scale if s.numbers else 0.0
        if self._dialect == "camworks-clt":
            self._tell.tool(s.line, 0.0, "CUTTER " + " ".join(f"{value:g}" for value in s.numbers))

    def _feature(self, s: Statement) -> None:
        self._tell.mark()
        self._opened = s.line

    def _tool_path(self, s: Statement) -> None:
        self._tell.mark()
        self._opened = s.line
        self._cycle = self._circle = None
        name = [f.strip() for f in s.rest.split(",")]
        upper = [f.upper() for f in name]
        if "TOOL" in upper[:-1]:
            self._tell.tool(s.line, 0.0, name[upper.index("TOOL") + 1])

    def _end_of_path(self, s: Statement) -> None:
        self._cycle = self._circle = None
        self._rapid, self._opened = False, 0

    def _delay(self, s: Statement) -> None:
        values = s.numbers
        seconds = values[0] if len(values) == 1 else float("nan")
        if "REV" in s.words:
            seconds = seconds * 60.0 / self._tell.rpm if self._tell.rpm else float("nan")
        if not seconds >= 0.0:
            self._tell.gap(s.line, "DELAY of a time that is not known", lost=False)
        self._tell.event(Kind.DWELL, s.line, seconds)

    def _stop(self, s: Statement) -> None:
        self._tell.event(Kind.STOP, s.line)

    def _insert(self, s: Statement) -> None:
        """Text for the machine's operator and control; where it says STOP, the machine stops for him."""
        if s.rest.strip().upper().split()[:1] == ["STOP"]:
            self._tell.event(Kind.STOP, s.line)

    def _syn(self, s: Statement) -> None:
        """SYN/'WORD','$$*WORD' makes a comment of a word (ICAM); the lexer takes what follows $$ away."""
        if found := re.fullmatch(r"\s*'([^']+)'\s*,\s*'", s.rest):
            self._silenced.add(found[1].upper())

    def _auxfun(self, s: Statement) -> None:
        self._tell.gap(s.line, f"{s.major}: a code of the machine's own", last=s.last, lost=False)

    def _hide(self, s: Statement) -> None:
        if CANCELS & set(s.words):
            self._tell.hidden.pop(s.major, None)
        else:
            self._tell.hidden[s.major] = (s.line, f"{s.major}: points behind it are not where they are printed")

    def _end_hidden(self, s: Statement) -> None:
        if self._tell.hidden.pop(ENDS[s.major], None):
            self._tell.lose()

    def _set_mode(self, s: Statement) -> None:
        self._tell.hidden.pop("SET", None)
        if "INCR" in s.words:
            self._tell.hidden["SET"] = (s.line, "SET/MODE,INCR: points behind it are not where they are printed")

    def _once(self, s: Statement) -> None:
        self._tell.gap(s.line, f"{s.major}: not read", last=s.last)
