"""The spindle in CL text: SPINDL in any order of speed, unit and sense, and the M codes of AUXFUN."""

from __future__ import annotations

import math

from camrob.errors import ToolpathError
from camrob.toolpath.apt.lexer import Statement
from camrob.toolpath.apt.state import Machine
from camrob.toolpath.region import EventKind
from camrob.units import mm_to_m

__all__ = ["auxfun", "spindl"]

_FOOT_MM = 304.8  # twelve inches
_SENSES = {"CLW": "CLW", "CW": "CLW", "CCLW": "CCLW", "CCW": "CCLW"}
_OFF = frozenset(("OFF", "NOMORE", "STOP", "NEUTRL", "LOCK", "ORIENT"))
_OWN_NUMBER = frozenset(("RANGE", "MAXRPM", "RADIUS", "GEAR", "ORIENT", "LOCK"))  # the number behind them is no speed
_KNOWN = frozenset((*_SENSES, *_OFF, *_OWN_NUMBER, "RPM", "SFM", "SMM", "ON", "LOW", "MEDIUM", "HIGH", "AUTO"))
_COOLANT = {7: "MIST", 8: "FLOOD", 13: "FLOOD", 14: "FLOOD"}
_TURNING = {3: "CLW", 4: "CCLW", 13: "CLW", 14: "CCLW"}  # 13 and 14 with coolant


def spindl(m: Machine, s: Statement) -> None:
    """SPINDL/OFF, or on: a speed that isn't stated is the last one, and so is the sense; surface speed needs a cutter.

    Raises ToolpathError for a word that isn't known, a negative speed, several speeds, and a spindle that is switched on
    without any speed.
    """
    words = s.words
    for word in words:
        if word[0] in "+-.0123456789":
            raise ToolpathError(f"the spindle speed is {word[:20]!r}", hint="correct SPINDL", line=s.line)
        if word not in _KNOWN:
            hint = "output SPINDL with a speed in RPM, SFM or SMM, and CLW, CCLW or OFF"
            raise ToolpathError(f"SPINDL/{s.text.strip()[:40]}: {word[:20]} is not known", hint=hint, line=s.line)
    if not _OFF.isdisjoint(words):
        m.spindle_off(s.line)
        return
    speeds, most = _speeds(s)
    if words == ["MAXRPM"] and not speeds:
        raise ToolpathError("SPINDL/MAXRPM without a speed", hint="output the speed with its limit", line=s.line)
    if len(speeds) > 1 or any(v < 0.0 for v in speeds):
        text = " and ".join(f"{v:g}" for v in speeds)
        raise ToolpathError(f"the spindle speed is {text}", hint="correct SPINDL", line=s.line)
    sense = next((_SENSES[w] for w in words if w in _SENSES), m.spindle or "CLW")
    if speeds == [0.0]:
        m.find("spindle-zero", "SPINDL states 0 rev/min: the spindle stands", s.line)
        m.feeds.rpm, m.spindle = 0.0, sense
        m.spindle_off(s.line)
        return
    if speeds and ("SFM" in words or "SMM" in words):
        m.spindle_on(min(_surface(m, s, speeds[0]), most), sense, s.line)
    else:
        m.spindle_on(min(speeds[0], most) if speeds else 0.0, sense, s.line)


def _speeds(s: Statement) -> tuple[list[float], float]:
    """The numbers that are speeds, and the most rev/min that MAXRPM allows."""
    speeds: list[float] = []
    most, before = math.inf, ""
    for arg in s.args:
        if isinstance(arg, str):
            before = arg
            continue
        if before == "MAXRPM":
            most = arg
        elif before not in _OWN_NUMBER:
            speeds.append(arg)
        before = ""
    return speeds, most


def _surface(m: Machine, s: Statement, speed: float) -> float:
    """rev/min of a surface speed (feet or metres a minute), by cutter or set-up's tool; else the set-up's own."""
    diameter = m.cutter[0] or m.feeds.defaults.diameter(m.tool_number)
    if diameter > 0.0:
        return (speed * mm_to_m(_FOOT_MM) if "SFM" in s.words else speed) / (math.pi * diameter)
    rpm = m.feeds.defaults.spindle_rpm
    if not rpm:
        raise ToolpathError(
            "the spindle's surface speed needs a cutter diameter, which is missing",
            hint="output the speed in rev/min, or put diameter_mm of [tool] or spindle_rpm into setup.toml",
            line=s.line,
        )
    m.find(
        "spindle-speed-from-setup",
        f"the surface speed needs a cutter diameter, which is missing: spindle_rpm of the set-up is used, {rpm:g} rev/min",
        s.line,
    )
    return rpm


def auxfun(m: Machine, s: Statement) -> None:
    """AUXFUN/n: an M code written by hand; those of spindle, coolant and stop are done.

    Raises ToolpathError for those that change the tool, call a subprogram, mirror or end the program.
    """
    if len(s.numbers) != 1 or s.words:
        hint = "output one AUXFUN a code"
        raise ToolpathError(f"AUXFUN/{s.text.strip()[:40]} is not one code", hint=hint, line=s.line)
    code = s.numbers[0]
    if code in _TURNING:
        m.spindle_on(0.0, _TURNING[int(code)], s.line)
    if code in _COOLANT:
        m.event(EventKind.COOLANT_ON, 0.0, _COOLANT[int(code)], s.line)
    if code in _TURNING or code in _COOLANT:
        return
    if code in (5, 19):  # 19 stops it at an angle
        m.spindle_off(s.line)
    elif code == 9:
        m.event(EventKind.COOLANT_OFF, 0.0, "", s.line)
    elif code in (0, 1):
        m.event(EventKind.STOP, 0.0, f"M{code:g}", s.line)
    elif code in (2, 6, 21, 22, 23, 30, 98, 99):
        raise ToolpathError(
            f"AUXFUN/{code:g} writes M{code:g}, which is not read",
            hint="say it in APT words (LOADTL, FINI)",
            line=s.line,
        )
    else:
        m.find("unknown-word", f"AUXFUN/{code:g} has no meaning here and was skipped", s.line)
