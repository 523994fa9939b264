"""Tools, spindle, coolant and dwell in CL text."""

from __future__ import annotations

import math

from camrob.errors import ToolpathError
from camrob.toolpath.apt_lexer import Statement
from camrob.toolpath.apt_machine import Machine
from camrob.toolpath.region import EventKind
from camrob.units import m_to_mm, mm_to_m

__all__ = ["coolnt", "cutter", "delay", "load", "spindl", "tldata", "toolname"]

_FOOT_MM = 304.8


def toolname(m: Machine, name: str, line: int) -> None:
    """A tool known by its name alone (NX's TOOL PATH): a change where the name is another one."""
    if name != m.tool_name:
        m.tool_name, m.tool_number = name, 0
        m.announce("", hard=True)
        m.event(EventKind.TOOL_CHANGE, 0.0, name, line)


def load(m: Machine, s: Statement) -> None:
    """LOAD/TOOL,n or LOADTL/n: a change, unless that tool is in the spindle already."""
    if s.word == "LOAD" and "TOOL" not in s.words:
        return
    if not s.numbers:
        raise ToolpathError(f"{s.word} names no tool number", cure="give the tool a number in the CAM", line=s.line)
    number = int(s.numbers[0])
    name, m.next_tool_name = m.next_tool_name, ""
    for n, (kind, _, text, line) in enumerate(m.pending):
        if kind == EventKind.TOOL_CHANGE and m.tool_number == 0:  # NX names it first and numbers it here
            m.pending[n] = (kind, float(number), text or name, line)
            m.tool_number, m.tool_name = number, m.tool_name or name
            return
    if number == m.tool_number:
        m.announce("")
        return
    m.tool_number, m.tool_name = number, name
    m.announce(m.tool_name if m.dialect.insert_names_tool else "", hard=True)
    m.event(EventKind.TOOL_CHANGE, float(number), name, s.line)


def cutter(m: Machine, s: Statement) -> None:
    """CUTTER/d[,r,e,f,a,b,h]: the cutter's size; where the dialect has no LOAD, another size is another tool."""
    v = [*s.numbers, *([0.0] * 7)][:7]
    size = (v[0] * m.scale, v[1] * m.scale, v[6] * m.scale)
    if m.dialect.cutter_is_tool and size != m.cutter:
        m.tool_name = f"D{m_to_mm(size[0]):g} R{m_to_mm(size[1]):g}"
        m.announce("", hard=True)
        m.event(EventKind.TOOL_CHANGE, 0.0, m.tool_name, s.line)
    m.cutter = size


def tldata(m: Machine, s: Statement) -> None:
    """NX: TLDATA/MILL,diameter,corner radius,length,..."""
    if {"TURN", "GROOVE", "THREAD"} & set(s.words):
        m.find("turning-tool", "the tool is a turning tool; its shape is not read", s.line)
        return
    v = [*s.numbers, 0.0, 0.0, 0.0]
    m.cutter = (v[0] * m.scale, v[1] * m.scale, v[2] * m.scale)


def spindl(m: Machine, s: Statement) -> None:
    """SPINDL in any order of speed, unit and sense; surface speed needs the cutter's diameter."""
    words = s.words
    if "OFF" in words:
        m.event(EventKind.SPINDLE_OFF, 0.0, "", s.line)
        return
    speed = s.numbers[0] if s.numbers else 0.0
    if not 0.0 <= speed < math.inf:
        raise ToolpathError(f"the spindle speed is {speed:g}", cure="correct SPINDL", line=s.line)
    sense = "CCLW" if "CCLW" in words else "CLW" if "CLW" in words else m.spindle or "CLW"
    if "SFM" in words or "SMM" in words:
        if not m.cutter[0] > 0.0:
            m.find("surface-speed", "the spindle's surface speed needs a cutter diameter, which is missing", s.line)
            m.feeds.rpm = 0.0
            return
        per_minute = speed * mm_to_m(_FOOT_MM) if "SFM" in words else speed
        m.feeds.rpm = per_minute / (math.pi * m.cutter[0])
    elif s.numbers:
        m.feeds.rpm = speed
    m.spindle = sense
    m.event(EventKind.SPINDLE_ON, m.feeds.rpm, sense, s.line)


def coolnt(m: Machine, s: Statement) -> None:
    """COOLNT/OFF, or on in some way."""
    if "OFF" in s.words:
        m.event(EventKind.COOLANT_OFF, 0.0, "", s.line)
    else:
        m.event(EventKind.COOLANT_ON, 0.0, s.words[0] if s.words else "ON", s.line)


def delay(m: Machine, s: Statement) -> None:
    """DELAY/seconds, or DELAY/n,REV: n revolutions of the spindle."""
    if not s.numbers or not s.numbers[0] >= 0.0:
        raise ToolpathError("DELAY needs a time", cure="give it in seconds", line=s.line)
    seconds = s.numbers[0]
    if "REV" in s.words:
        if not m.rpm > 0.0:
            raise ToolpathError("DELAY in revolutions without a spindle speed", cure="give it in seconds", line=s.line)
        seconds = 60.0 * seconds / m.rpm
    m.event(EventKind.DWELL, seconds, "", s.line)
