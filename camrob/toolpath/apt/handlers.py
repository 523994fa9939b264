"""What every APT word does to the machine: one handler a word, and a policy for the words that nobody knows."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from camrob.errors import ToolpathError
from camrob.findings import Finding, Severity
from camrob.toolpath.apt.coordinates import Table, camera, csys, matrix_rows, msys, tracut, trans, trntyp
from camrob.toolpath.apt.copies import Copies
from camrob.toolpath.apt.curves import Nurbs, circle, indirv, tlon
from camrob.toolpath.apt.cycles import anchored, changed, check_words
from camrob.toolpath.apt.lexer import Rows, Statement, number_of
from camrob.toolpath.apt.policy import IGNORED, Strangers, is_off
from camrob.toolpath.apt.spindle import auxfun, spindl
from camrob.toolpath.apt.state import Machine
from camrob.toolpath.apt.tools import (
    coolnt,
    cutter,
    delay,
    load,
    machin,
    partno,
    rapid,
    retrct,
    stop,
    tldata,
    toolname,
    toolno,
    tprint,
    turret,
    unload,
)
from camrob.toolpath.apt.word_checks import all_numbers, coordinates, holds_codes, in_range, placed
from camrob.toolpath.cutter_offset import offset_by_control
from camrob.toolpath.region import EventKind, Move

__all__ = ["Interpreter"]

_TEXT = frozenset(("$$", "PPRINT", "PARTNO", "INSERT", "TPRINT"))
_NAMING = _TEXT | set("END-OF-PATH OPFEATSTART OPFEATEND SETUP GOTO SYN CSI_TOOL_PATH OPNAME".split()) | {"TOOL PATH"}
_INSERTS = ("INSERT", "INTCOD", "PPWORD", "CSI_INSERT_CUSTOM_GCODE")
_BREAKS_ARC = frozenset(("CIRCLE", "FROM", "GOHOME", "GODLTA", "CYCLE", "TOOL PATH", "END-OF-PATH", "FINI", "NURBS"))
_MOTION = frozenset(("GOTO", "CIRCLE", "MOVARC", "COPY", "GODLTA", "NURBS", "CNTRL", "TLON,GOFWD", "FROM", "GOHOME"))


class Interpreter:
    """Feeds statements and runs of GOTO to a `Machine`; `finish` checks that nothing was left open."""

    def __init__(self, machine: Machine) -> None:
        self.m = machine
        self.table = Table(machine) if machine.dialect.table_radians else None
        self.nurbs: Nurbs | None = None
        self.matrix: list[list[float]] | None = None
        self._drilling: Statement | None = None  # the last CYCLE
        self.strangers = Strangers()
        self.silenced: set[str] = set()
        self.compensated: set[int] = set()
        self.profile = False  # Creo writes the part's contour, not the path of the tool's centre
        self.copies = Copies()
        self.ended = 0
        self.handlers: dict[str, Callable[[Statement], None]] = {
            "$$": self._comment, "GOTO": self._goto, "FEDRAT": self._fedrat, "FROM": self._from,
            "GOHOME": self._gohome, "GODLTA": self._godlta, "CYCLE": self._cycle, "CUTCOM": self._cutcom,
            "TLCOMP": self._cutcom, "TLAXIS": self._tlaxis, "ROTABL": self._rotabl, "TOOL PATH": self._tool_path,
            "END-OF-PATH": self._close, "OPFEATSTART": self._feature, "OPFEATEND": self._close, "SETUP": self._setup,
            "PPRINT": self._pprint, **dict.fromkeys(_INSERTS, self._insert),
            "NURBS": self._nurbs, "KNOT": self._nurbs, "CNTRL": self._nurbs, "SYN": self._syn, "SET": self._set,
            "MODE": self._set, "UNITS": self._units, "UNIT": self._units, "FINI": self._end, "END": self._end,
            "MULTAX": self._multax,
            "COPY": lambda s: self.copies.run(s, self.m, self._take, self.rows),
            "INDEX": lambda s: self.copies.index(s, self.m.axis_raw),
        }  # fmt: skip
        plain = {
            "CIRCLE": circle, "TLON,GOFWD": tlon, "INDIRV": indirv, "MSYS": msys, "CSYS": csys, "TRNTYP": trntyp,
            "CAMERA": camera, "SPINDL": spindl, "COOLNT": coolnt, "DELAY": delay, "DWELL": delay, "LOAD": load,
            "LOADTL": load, "CUTTER": cutter, "TLDATA": tldata, "TOOLNO": toolno, "TURRET": turret, "UNLOAD": unload,
            "AUXFUN": auxfun, "TRACUT": tracut, "TRANS": trans, "STOP": stop, "OPSTOP": stop, "PARTNO": partno,
            "TPRINT": tprint, "MACHIN": machin, "RETRCT": retrct, "RETRACT": retrct, "RAPID": rapid,
        }  # fmt: skip
        for word, verb in {**plain, **machine.dialect.words}.items():
            self.handlers[word] = lambda s, verb=verb: verb(self.m, s)  # type: ignore[misc]

    # -- entry points -------------------------------------------------------------------------------------------

    def rows(self, rows: Rows) -> None:
        """A run of GOTO."""
        self.copies.keep(rows, False)
        self._after_end("GOTO", int(rows.lines[0]))
        self._leave_blocks("GOTO")
        if self.m.takes_rows:
            self.m.goto_rows(rows)
            return
        for n in range(len(rows.lines)):
            self.m.rapid = bool(rows.rapids[n])
            line = int(rows.lines[n])
            try:
                self.m.goto(rows.values[n, : rows.counts[n]].tolist(), line)
            except ToolpathError as error:
                raise placed(error, line) from error

    def statement(self, s: Statement) -> None:
        """One statement. Raises ToolpathError, with its line, for what can't be read honestly."""
        try:
            self._take(s)
        except ToolpathError as error:
            raise placed(error, s.line) from error

    def _take(self, s: Statement) -> None:
        word = s.word
        if word not in ("$$", "COPY"):
            self.copies.keep(s, self.m.rapid)
        if word != "$$":
            self._leave_blocks(word)
            self._after_end(word, s.line)
            if word in self.silenced:
                return
        if self.m.curve is not None and word in _BREAKS_ARC:
            self._check_arc()
        handler = self.handlers.get(word)
        if handler is not None:
            if word not in _TEXT:
                in_range(s.numbers)
            if word not in _NAMING:
                all_numbers(s)
            handler(s)
        elif word not in IGNORED and not word.startswith("CSI_SET_") and not self.ended:
            self.strangers.take(s)

    def finish(self, last_line: int, ends_in_line: bool) -> None:
        """The file is read. Raises ToolpathError where it was cut off."""
        m = self.m
        self._leave_blocks("")
        self._check_arc()
        if m.sections:
            text, line = m.sections[-1]
            raise ToolpathError(
                f"the file ends before {text} of line {line} is closed: it was cut off",
                hint="get the whole file from the CAM system",
                line=last_line,
            )
        if not self.ended and m.dialect.must_end:
            cutting = len(m.builder) > 0 and m.builder.last_move == Move.CUT
            if cutting or not ends_in_line:
                raise ToolpathError(
                    "the file ends while cutting, without FINI: it was cut off",
                    hint="get the whole file",
                    line=last_line,
                )
            m.find("no-end", "the file ends without FINI: it may have been cut off", last_line)
        m.finish()
        for word, (count, line) in self.strangers.seen.items():
            text = f"{word} is not known to camrob and was skipped"
            m.findings.append(Finding("unknown-word", text, Severity.WARNING, line, count=count))

    # -- blocks that other words close --------------------------------------------------------------------------

    def _leave_blocks(self, word: str) -> None:
        if self.nurbs is not None and word not in ("KNOT", "CNTRL"):
            nurbs, self.nurbs = self.nurbs, None
            nurbs.finish(self.m)
        if self.matrix is not None:
            if self.matrix:
                raise ToolpathError("CATIA0 has less than three rows of four numbers", hint="output the file again")
            self.matrix = None

    def _check_arc(self) -> None:
        if self.m.curve is not None:
            raise ToolpathError(
                "CIRCLE has no GOTO behind it that says where it ends",
                hint="the file was cut; get it again",
                line=self.m.curve_line,
            )

    def _after_end(self, word: str, line: int) -> None:
        if self.ended and word in _MOTION:
            raise ToolpathError(
                f"there is motion after the program's end in line {self.ended}",
                hint="give one program a file",
                line=line,
            )

    # -- motion -------------------------------------------------------------------------------------------------

    def _goto(self, s: Statement) -> None:
        values = coordinates(s, (3, 6, 9))
        if len(values) > 6:
            self.m.find("second-vector", "GOTO names a second vector, which is not used", s.line, Severity.INFO)
        self.m.goto(values[:6], s.line)

    def _fedrat(self, s: Statement) -> None:
        self.m.feeds.fedrat(s)

    def _settled(self, line: int) -> None:
        if self.m.settle is not None:
            self.m.settle(line)

    def _from(self, s: Statement) -> None:
        m = self.m
        values = coordinates(s, (3, 6))
        self._settled(s.line)
        if len(values) == 6:
            m.set_axis(np.array(values[3:]), s.line)
        point, axis = m.to_part(np.array(values[:3])), m.tool_axis(s.line)
        if m.position is not None and (np.max(np.abs(point - m.position)) > 0.0 or (axis != m.position_axis).any()):
            m.lose()  # nothing says how the tool comes from where it was to where it is now
        elif len(m.builder):
            m.announce(m.operation, hard=True)
        m.position, m.position_axis, m.position_line = point, axis, s.line

    def _gohome(self, s: Statement) -> None:
        m = self.m
        if s.numbers:
            values = coordinates(s, (3, 6))
            self._settled(s.line)
            m.move(m.to_part(np.array(values[:3])), m.tool_axis(s.line), Move.RAPID, s.line)
        else:
            m.find("home", "GOHOME without a point is left to the robot's own way home", s.line, Severity.INFO)
            m.lose()
        m.rapid = False

    def _godlta(self, s: Statement) -> None:
        m = self.m
        values = coordinates(s, (1, 3))
        if m.cycle is not None:
            raise ToolpathError("GODLTA in a drilling cycle", hint="output the holes as GOTO", line=s.line)
        self._settled(s.line)
        if m.position is None:
            raise ToolpathError("GODLTA has no point to start from", hint="put FROM or GOTO before it", line=s.line)
        axis = m.tool_axis(s.line)
        step = axis * values[0] if len(values) == 1 else m.part_R_cl @ np.array(values)
        rapid, m.rapid = m.rapid, False
        feed = 0.0 if rapid else m.cut_feed(s.line)
        m.move(m.position + step * m.scale, axis, Move.RAPID if rapid else Move.CUT, s.line, feed)

    def _cycle(self, s: Statement) -> None:
        m = self.m
        first = s.words[0].split()[0] if s.words else ""
        if first in ("OFF", "NOMORE"):
            m.cycle = None
        elif first != "INIT" and not (first == "ON" and self._drilling is None and m.dialect.on == "heading"):
            self._drilling = s = s if first != "ON" else changed(self._drilling, s, by_values=m.dialect.on == "values")
            check_words(s)
            m.cycle = anchored(m.dialect.cycle(s), s, m)
            if not m.cycle.depth > 0.0:
                m.find("cycle-depth", "a cycle has no depth: the tool only touches the hole's point", s.line)

    def _nurbs(self, s: Statement) -> None:
        if s.word == "NURBS":
            if self.m.rapid:
                raise ToolpathError("a NURBS in rapid", hint="output it as GOTO, or with a feed", line=s.line)
            self.nurbs = Nurbs(s.line)
        elif self.nurbs is None:
            raise ToolpathError(f"{s.word}/ stands outside a NURBS", hint="output the path again", line=s.line)
        else:
            self.nurbs.add(s)

    # -- axis, frame, mode --------------------------------------------------------------------------------------

    def _comment(self, s: Statement) -> None:
        text = s.text.strip()
        if text.startswith("*CATIA"):
            self.matrix = []
        elif self.matrix is not None:
            row = [number_of(t) for t in text.split()]
            values = [v for v in row if v is not None]
            if len(row) == 4 and len(values) == 4:
                in_range(values)
                self.matrix.append(values)
            if len(self.matrix) == 3:
                matrix, self.matrix = self.matrix, None
                matrix_rows(self.m, matrix, s.line)
        elif text.startswith("->"):
            self._creo(text[2:].strip(), s.line)
        elif text.upper().startswith("OPERATION NAME"):
            self.m.announce(text.partition(":")[2])

    def _creo(self, text: str, line: int) -> None:
        word, _, minor = text.partition("/")
        inner = Statement(word.strip().upper(), minor, line)
        if inner.word == "FEATNO":
            self.m.announce(f"{self.m.program} feature {minor.strip()}")
        elif inner.word == "CUTTER" and inner.numbers:
            in_range(inner.numbers)
            cutter(self.m, inner)
        elif inner.word == "CUTCOM_GEOMETRY_TYPE":
            self.profile = "PROFILE" in minor.upper()
        elif inner.word == "CSYS" and inner.numbers != np.eye(3, 4).ravel().tolist():
            self.m.find("csys-comment", "the comment CSYS is not applied: the points hold it", line, Severity.INFO)

    def _multax(self, s: Statement) -> None:
        """Behind MULTAX/OFF points carry no axis: a tilted one must not be taken along."""
        if is_off(s) and self.m.axis_raw[2] < 1.0 - 1e-9:
            self.m.axis_lost = True

    def _tlaxis(self, s: Statement) -> None:
        if self.table is not None:
            self.table.axis(s)
        else:
            self.m.set_axis(np.array(coordinates(s, (3,))), s.line)

    def _rotabl(self, s: Statement) -> None:
        if self.table is not None:
            self.table.turn(s)
        elif not s.numbers or any(s.numbers):
            raise ToolpathError(
                "ROTABL turns the table, and this dialect does not say in which frame the points are then",
                hint="output i, j, k in each GOTO instead of table turns",
                line=s.line,
            )

    def _syn(self, s: Statement) -> None:
        names = re.findall(r"'([^']*)'", s.text)
        if len(names) == 2 and names[1].startswith("$$"):
            self.silenced.add(names[0].strip().upper())

    def _set(self, s: Statement) -> None:
        if "INCR" in s.words:
            raise ToolpathError("incremental points are not read", hint="output absolute points", line=s.line)
        if not set(s.words) <= {"MODE", "ABSOL", "MILL"}:
            self.strangers.take(s)

    def _units(self, s: Statement) -> None:
        if s.words:
            self.m.feeds.set_units(s.words[0], s.line)

    # -- operations and text ------------------------------------------------------------------------------------

    def _tool_path(self, s: Statement) -> None:
        name, _, rest = s.text.partition(",TOOL,")
        self.m.sections = [(f"TOOL PATH {name.strip()[:60]}", s.line)]
        self.m.announce(name)
        self.m.axis_inherited = bool(self.m.axis_raw[2] < 1.0 - 1e-9)
        if rest.strip():
            toolname(self.m, rest.strip(), s.line)

    def _close(self, s: Statement) -> None:
        self.m.sections = self.m.sections[:-1]

    def _feature(self, s: Statement) -> None:
        self.m.sections = [(f"OPFEATSTART {s.text.strip()[:60]}", s.line)]
        self.m.announce(s.text)
        if self.table is not None:
            self.table.reset()

    def _setup(self, s: Statement) -> None:
        if "START" in s.words:
            self.m.announce("")

    def _pprint(self, s: Statement) -> None:
        m = self.m
        head, _, tail = s.text.partition(",")
        if head.strip() == "BEGIN-SECTION":
            m.sections.append((f"BEGIN-SECTION {tail.strip()[:60]}", s.line))
        elif head.strip() == "END-SECTION" and m.sections:
            m.sections.pop()
        meaning = m.dialect.pprint(s.text.strip())
        if meaning is not None and meaning[0] == "operation":
            m.announce(meaning[1])
        elif meaning is not None and meaning[1]:
            m.event(EventKind.MESSAGE, 0.0, meaning[1], s.line)

    def _insert(self, s: Statement) -> None:
        text = s.text.strip()
        if text.upper().split()[:1] == ["STOP"]:
            self.m.event(EventKind.STOP, 0.0, text, s.line)
        elif self.m.dialect.insert_names_tool and not text.startswith("Stock Size"):
            self.m.next_tool_name = text
        elif text:
            self.m.event(EventKind.MESSAGE, 0.0, text, s.line)
            if holds_codes(s):
                self.m.find("insert-text", "INSERT holds codes of the machine's, which are not carried out", s.line)

    def _cutcom(self, s: Statement) -> None:
        """CL data is where the tool is, so that a compensation behind it is for wear, but where the file says otherwise."""
        if any(word.startswith("NORM") for word in s.words):
            what = (
                f"CUTCOM/{s.words[0]}, compensation in space: the points may be where the cutter touches, not its tip"
            )
            raise ToolpathError(what, hint="output the tip of the tool, without compensation", line=s.line)
        if not {"LEFT", "RIGHT", "ON"} & set(s.words) or "LENGTH" in s.words:
            return
        if (self.profile or self.m.dialect.contour_behind_cutcom) and not self.m.feeds.defaults.wear:
            raise offset_by_control("CUTCOM, and OUTPUT_ON_PROFILE in the file" if self.profile else "CUTCOM")
        operation = self.m.mark.name if self.m.mark is not None else self.m.operation
        where = f"operation {operation}" if operation else "the path"
        if self.m.announced not in self.compensated:
            self.compensated.add(self.m.announced)
            self.m.find("cutcom", f"cutter radius compensation (CUTCOM) is not applied: {where} runs as it is", s.line)

    def _end(self, s: Statement) -> None:
        self.ended = self.ended or s.line
