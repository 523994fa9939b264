"""Tools, coolant, dwell, retracts and RAPID in CL text."""

from __future__ import annotations

from camrob.errors import ToolpathError
from camrob.findings import Severity
from camrob.toolpath.apt.lexer import Statement
from camrob.toolpath.apt.policy import is_off
from camrob.toolpath.apt.state import Machine
from camrob.toolpath.region import EventKind
from camrob.units import m_to_mm

__all__ = [
    "coolnt",
    "cutter",
    "delay",
    "load",
    "machin",
    "partno",
    "rapid",
    "retrct",
    "stop",
    "tldata",
    "toolname",
    "toolno",
    "tprint",
    "turret",
    "unload",
]


_LATHE = frozenset(("TURN", "GROOVE", "THREAD"))
"""Minor words of a tool that stands still while the part turns."""


def machin(m: Machine, s: Statement) -> None:
    """The post-processor that the file is for; Creo calls those for lathes UNCL."""
    if s.text.strip().upper().startswith("UNCL"):
        raise ToolpathError(
            "a turning file (MACHIN/UNCL...): no part turns against a tool at rest here",
            hint="give the milling operations a CL file of their own",
            line=s.line,
        )


def retrct(m: Machine, s: Statement) -> None:
    """RETRCT: the tool is taken out, how far isn't said."""
    if is_off(s):
        return
    if "ON" in s.words:
        raise ToolpathError(
            f"{s.word}/ON may retract the tool anywhere behind it", hint="output the retracts as GOTO", line=s.line
        )
    m.find("home", f"{s.word} names no point: the tool is taken out by the cell's own retract", s.line, Severity.INFO)
    m.lose()
    m.rapid = False


def rapid(m: Machine, s: Statement) -> None:
    """RAPID holds for the next motion. Raises ToolpathError where it says more than that."""
    if not is_off(s) and s.args:
        hint = "output RAPID alone, before each motion in rapid"
        raise ToolpathError(f"RAPID/{s.text.strip()[:40]}: what it asks for is not known", hint=hint, line=s.line)
    m.rapid = not is_off(s)


def stop(m: Machine, s: Statement) -> None:
    """STOP, OPSTOP: the machine waits for its operator."""
    m.event(EventKind.STOP, 0.0, "" if s.word == "STOP" else s.word, s.line)


def tprint(m: Machine, s: Statement) -> None:
    """TPRINT: the name of the tool that is loaded next."""
    m.next_tool_name = s.text.split(",")[0].strip()


def partno(m: Machine, s: Statement) -> None:
    """PARTNO: the part's name."""
    m.program = s.text.strip()


def toolname(m: Machine, name: str, line: int) -> None:
    """A tool known by its name alone (NX's TOOL PATH): a change where the name is another one."""
    if name != m.tool_name:
        m.change_tool(0, name, line)


def load(m: Machine, s: Statement) -> None:
    """LOAD/TOOL,n or LOADTL/n: a change, unless that tool is in the spindle already."""
    if s.word == "LOAD" and "TOOL" not in s.words:
        hint = "say LOAD/TOOL,n for a tool, or delete the line where it means nothing"
        raise ToolpathError(f"LOAD/{s.text.strip()[:40]} loads something else than a tool", hint=hint, line=s.line)
    if not s.numbers:
        raise ToolpathError(f"{s.word} names no tool number", hint="give the tool a number in the CAM", line=s.line)
    _change(m, s.numbers[0], s.line)


def turret(m: Machine, s: Statement) -> None:
    """TURRET/n: the turret brings tool n; without a number it only says which turret."""
    if s.numbers:
        _change(m, s.numbers[0], s.line)


def toolno(m: Machine, s: Statement) -> None:
    """TOOLNO/n,...: a description, and the change itself in a file that has no other word for it."""
    _refuse_turning(s)
    if s.numbers and m.tool_by_number:
        _change(m, s.numbers[0], s.line)


def unload(m: Machine, s: Statement) -> None:
    """UNLOAD/TOOL: the tool is put away; the next one must be loaded before a cut."""
    m.find("tool-unloaded", "UNLOAD puts the tool away: that is left to the operator", s.line, Severity.INFO)
    m.tool_number, m.tool_name, m.unloaded = 0, "", s.line


def _change(m: Machine, value: float, line: int) -> None:
    """A change to the tool of that number, unless it is in the spindle already."""
    number = int(value)
    if number != value or number < 0:
        raise ToolpathError(f"{value:g} is not a tool number", hint="a whole number from 0", line=line)
    m.unloaded = 0
    name, m.next_tool_name = m.next_tool_name, ""
    for n, (kind, _, text, first) in enumerate(m.pending):
        if kind == EventKind.TOOL_CHANGE and m.tool_number == 0:  # NX names it first and numbers it here
            m.pending[n] = (kind, float(number), text or name, first)
            m.tool_number, m.tool_name = number, m.tool_name or name
            return
    if number == m.tool_number:
        m.announce("")
        return
    m.change_tool(number, name, line, name if m.dialect.insert_names_tool else "")


def cutter(m: Machine, s: Statement) -> None:
    """CUTTER/d[,r,e,f,a,b,h]: the cutter's size; where dialect or file has no LOAD, another size is another tool."""
    v = [*s.numbers, *([0.0] * 7)][:7]
    size = (v[0] * m.scale, v[1] * m.scale, v[6] * m.scale)
    another = m.tool_by_number and not m.tool_number and any(m.cutter) and bool(len(m.builder) or m.regions)
    if (m.dialect.cutter_is_tool or another) and size != m.cutter:
        m.change_tool(0, f"D{m_to_mm(size[0]):g} R{m_to_mm(size[1]):g}", s.line)
    m.cutter, m.cutter_line = size, s.line


def tldata(m: Machine, s: Statement) -> None:
    """NX: TLDATA/MILL,diameter,corner radius,length,..."""
    _refuse_turning(s)
    v = [*s.numbers, 0.0, 0.0, 0.0]
    m.cutter, m.cutter_line = (v[0] * m.scale, v[1] * m.scale, v[2] * m.scale), s.line


def _refuse_turning(s: Statement) -> None:
    """Raises ToolpathError where the statement describes a lathe's tool."""
    if _LATHE & set(s.words):
        raise ToolpathError(
            f"a turning operation ({s.word} of a turning tool): no part turns against a tool at rest here",
            hint="give the milling operations a CL file of their own",
            line=s.line,
        )


def coolnt(m: Machine, s: Statement) -> None:
    """COOLNT/OFF, or on in some way."""
    if is_off(s):
        m.event(EventKind.COOLANT_OFF, 0.0, "", s.line)
    else:
        m.event(EventKind.COOLANT_ON, 0.0, s.words[0] if s.words else "ON", s.line)


def delay(m: Machine, s: Statement) -> None:
    """DELAY/seconds, or DELAY/n,REV: n revolutions of the spindle. Some posts call it DWELL."""
    if len(s.numbers) != 1 or not s.numbers[0] >= 0.0 or not set(s.words) <= {"REV", "SEC"}:
        raise ToolpathError(
            f"{s.word}/{s.text.strip()[:40]} is no time in seconds or REV", hint="give it in seconds", line=s.line
        )
    seconds = s.numbers[0]
    if "REV" in s.words:
        if not m.rpm > 0.0:
            raise ToolpathError(
                f"{s.word} in revolutions without a spindle speed", hint="give it in seconds", line=s.line
            )
        seconds = 60.0 * seconds / m.rpm
    m.event(EventKind.DWELL, seconds, "", s.line)
