"""CL data of the APT family: NX CLSF, Creo NCL, CATIA aptsource, CAMWorks .apt and .clt, Makino, plain ISO APT.

`AptReader._vocabulary` lists what each word does; a word that is not in it and carries coordinates is a gap.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from camrob.errors import ToolpathError
from camrob.witness.cl.apt_process import AptProcess
from camrob.witness.cl.copying import copies_of, matrix_of, turns_right
from camrob.witness.cl.curve import Curve, tlon
from camrob.witness.cl.drilling import UPWARD, Cycle, apt_cycle, drill, renewed
from camrob.witness.cl.foreign.autodesk import CONTOURS, TRUEPATH, autodesk_cycle, movarc, sweep
from camrob.witness.cl.offsets import Offsets
from camrob.witness.cl.placing import Placing
from camrob.witness.cl.source import Run, Source, Statement, number
from camrob.witness.cl.teller import Teller, unit
from camrob.witness.cl.words import (
    ACTS,
    CANCELS,
    CURVE,
    DRIVE,
    ENDS,
    HIDING,
    NO_AXIS,
    NOTHING,
    ONCE,
    STRANGE,
    TO_MACHINE,
)
from camrob.witness.happenings import Kind, Way

__all__ = ["AptReader"]

Array = NDArray[np.float64]

_REVERSED = ("nx-clsf", "makino", TRUEPATH)  # CIRCLE's axis is printed the other way round


class AptReader(AptProcess):
    """Tells what the statements of one file ask for."""

    def __init__(
        self, tell: Teller, dialect: str, units: str, fixed_units: bool, offsets: Offsets, tools: Mapping[int, float]
    ) -> None:
        super().__init__(tell, dialect, Placing(tell, dialect, units), tools)
        self._offsets, self._fixed_units = offsets, fixed_units
        self._rapid = False
        self._angle: tuple[float, bool] | None = None  # of MOVARC, degrees, and whether its normal says the sense
        self._circle: tuple[Array, Array, int] | None = None  # centre and axis in the part, further full turns
        self._cycle: Cycle | None = None
        self._asked: list[str] = []  # what the last CYCLE says
        self._curve: Curve | None = None
        self._direction: Array | None = None  # INDIRV
        self._opened = 0  # the line of a TOOL PATH or OPFEATSTART that is not closed yet
        self._index: dict[int, tuple[int, Array]] = {}  # behind which line a stretch begins, and the axis there
        self._source: Source | None = None
        self._moved_by = np.zeros(3)  # TRANS, m
        self._silenced: set[str] = set()  # words that SYN turns into comments
        self._words = self._vocabulary()

    @property
    def units(self) -> str:
        """Of the file: "mm" or "inch"."""
        return self._place.units

    def read(self, text: str) -> None:
        """Reads all of the text. Raises ToolpathError where it is no CL data."""
        source = Source(text)
        self._source = source
        self._by_number = not re.search(r"^[ \t]*(LOADTL[ \t]*/|LOAD[ \t]*/[ \t]*TOOL)", text, re.I | re.M)
        self._all(source)
        self._end_curve()
        if self._opened:
            what = f"the file ends inside the operation that line {self._opened} begins: it was cut off"
            raise ToolpathError(what, hint="get the whole file from the CAM system", line=len(source.lines))
        if self._unknown:
            words = ", ".join(f"{word} ({count})" for word, count in self._unknown.items())
            self._tell.note(f"words that are not known and carry no coordinates, skipped: {words}")

    def _all(self, source: Source) -> None:
        """The statements of a text, to its end or the program's."""
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
        own = {
            "GOTO": self._goto, "FROM": self._from, "GOHOME": self._gohome, "GODLTA": self._godlta, "RAPID": self._set_rapid,
            "CIRCLE": self._set_circle, "INDIRV": self._indirv, "TLON,GOFWD": self._tlon_circle, "CYCLE": self._set_cycle,
            "UNITS": self._set_units, "UNIT": self._set_units,
            "SET": self._set_mode, "FEDRAT": self._fedrat, "SPINDL": self._spindl, "COOLNT": self._coolnt, "LOAD": self._load,
            "LOADTL": self._load, "TURRET": self._load, "DELAY": self._delay, "DWELL": self._delay, "STOP": self._stop,
            "OPSTOP": self._stop, "CUTTER": self._cutter, "TOOL PATH": self._tool_path, "END-OF-PATH": self._end_of_path,
            "OPFEATSTART": self._feature, "OPFEATEND": self._end_of_path, "CUTCOM": self._offsets.cutcom,
            **dict.fromkeys(("INSERT", "INTCOD", "PPWORD", "CSI_INSERT_CUSTOM_GCODE"), self._insert),
            "TLDATA": self._tldata, **dict.fromkeys(CURVE, self._nurbs),
            "UNLOAD": self._unload, "TOOLNO": self._toolno, "TLCOMP": self._offsets.cutcom, "INDEX": self._set_index,
            "COPY": self._copy, "TRACUT": self._tracut, "TRANS": self._trans, "MOVARC": self._movarc,
            "SYN": self._syn, "AUXFUN": self._auxfun, "PREFUN": self._auxfun,
        }  # fmt: skip
        return {
            **dict.fromkeys(NOTHING, lambda s: None),
            **dict.fromkeys(HIDING, self._hide),
            **dict.fromkeys(ENDS, self._end_hidden),
            **dict.fromkeys(ONCE, self._once),
            **self._place.words(),
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
        values = values[:6] if s.major == "GOTO" and len(values) == 9 else values  # of the surface, or ahead
        axis = unit(np.array(values[3:])) if len(values) == 6 else None
        if len(values) not in (3, 6) or (len(values) == 6 and axis is None):
            self._tell.gap(
                s.line, NO_AXIS if len(values) == 6 else f"{s.major} with neither 3 numbers nor 6", last=s.last
            )
            return None
        if axis is not None:
            self._place.prints(axis)
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
            normal = self._sense(tip, circle[0], circle[1])
            if normal is None:
                self._tell.gap(s.line, "an arc whose angle doesn't say which way round it goes")
                return
            self._tell.arc(tip, axis, circle[0], normal, way, s.line, circle[2])
        else:
            self._tell.move(tip, axis, way, s.line)

    def _sense(self, tip: Array, center: Array, normal: Array) -> Array | None:
        """The normal about which the arc goes right-handedly: as it is but for MOVARC, which names an angle, too."""
        named, self._angle = self._angle, None
        if named is None:
            return normal
        here = self._tell.here
        right = None if here is None else turns_right(here, tip, center, normal, named[0], signed=named[1])
        return None if right is None else normal if right else -normal

    def _movarc(self, s: Statement) -> None:
        """Autodesk's arc to the next GOTO."""
        if (arc := movarc(s, self._dialect)) is None:
            self._tell.gap(s.line, "MOVARC that has no centre, normal and angle", last=s.last)
            return
        self._set_circle(arc[0])
        self._angle = arc[1]

    def _set_index(self, s: Statement) -> None:
        if len(s.numbers) == 1 and not s.words:
            self._index[int(s.numbers[0])] = (s.last, self._place.axis)
        else:
            self._once(s)

    def _copy(self, s: Statement) -> None:
        """The stretch behind an INDEX again, in other frames."""
        if CANCELS & set(s.words):
            return
        place = self._place
        base, axis = (place.part_R_points, place.part_p_points), place.axis
        found = copies_of(s, place.scale, base)
        first = None if found is None else self._index.get(found[0])
        if found is None or first is None or self._source is None:
            self._once(s)
            return
        index, self._index = self._index, {}
        stretch = "\n" * first[0] + (self._source.lines.stretch(first[0], s.line - 1) or "\n")
        for frame in found[1]:
            place.by_matrix(frame, s.line)
            place.axis = first[1]
            self._all(Source(stretch))
        place.by_matrix(base, s.line)
        self._index, place.axis = index, axis

    def _tracut(self, s: Statement) -> None:
        found = (np.eye(3), np.zeros(3)) if CANCELS & set(s.words) else matrix_of(s.numbers, self._place.scale)
        if found is None:
            self._hide(s)
        else:
            self._place.by_matrix(found, s.line)

    def _trans(self, s: Statement) -> None:
        """Behind motions: what is printed from here on lies that much farther. A second one may replace or add to the first."""
        by = [0.0] * 3 if CANCELS & set(s.words) else s.numbers
        place = self._place
        own = np.allclose(place.part_R_points, np.eye(3)) and np.allclose(place.part_p_points, self._moved_by)
        more = not CANCELS & set(s.words) and bool(self._moved_by.any())
        if more or (s.words and any(by)) or len(by) != 3 or (any(by) and (not self._tell.n or not own)):
            self._hide(s)
            return
        self._tell.hidden.pop("TRANS", None)
        if own:
            self._moved_by = place.part_p_points = np.array(by) * place.scale

    def _run(self, run: Run) -> None:
        tips, axes = self._place.points(run.points, run.axes)
        self._tell.run(tips, axes, run.line)

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
        self._rapid = not CANCELS & set(s.words)
        if s.fields and self._rapid:
            self._tell.gap(s.line, f"RAPID/{s.rest.strip()[:40]}: not read", last=s.last)

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
        axis = self._place.hand * self._place.part_R_points @ (-normal if turned else normal)
        self._circle, self._angle = (self._place.point(values[:3]), axis, int(times or 0)), sweep(s, self._dialect)

    def _indirv(self, s: Statement) -> None:
        values = s.numbers
        self._direction = self._place.part_R_points @ np.array(values) if len(values) == 3 else None

    def _tlon_circle(self, s: Statement) -> None:
        tlon(self._tell, self._place, s, self._direction, Way.RAPID if self._rapid else Way.FEED)
        self._rapid = False

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
        fields = renewed(self._asked, s.fields, by_values=self._dialect == "nx-clsf")
        if not fields or fields[0] in ("OFF", "NOMORE"):
            self._cycle = None
        elif fields != ["INIT"]:
            self._asked = fields
            if self._dialect in CONTOURS:
                self._cycle = autodesk_cycle(s, self._dialect, self._place, self._tell, forced=self._fixed_units)
                return
            self._cycle = apt_cycle(
                fields, self._place.scale, self._dialect == "catia", self._tell, forced=self._fixed_units
            )
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

    def _insert(self, s: Statement) -> None:
        """Text for the machine's operator and control; where it says STOP, the machine stops for him."""
        if s.rest.strip().upper().split()[:1] == ["STOP"]:
            self._tell.event(Kind.STOP, s.line)
        if ACTS.fullmatch(s.rest):
            self._tell.gap(s.line, f"{s.major}: codes of the machine's that move or switch", lost=False)
        if TO_MACHINE.search(s.rest):
            self._tell.hidden[s.major] = (s.line, f"{s.major}: a code of the machine's that moves the points behind it")

    def _syn(self, s: Statement) -> None:
        """SYN/'WORD','$$*WORD' makes a comment of a word (ICAM); the lexer takes what follows $$ away."""
        if found := re.fullmatch(r"\s*'([^']+)'\s*,\s*'", s.rest):
            self._silenced.add(found[1].upper())

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
