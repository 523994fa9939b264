"""CL data of every dialect as a toolpath: one interpreter over one APT grammar."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

import numpy as np

from camrob.errors import InputError, ToolpathError
from camrob.findings import Finding, Severity, collapse
from camrob.progress import Share
from camrob.toolpath.apt.dialects.registry import choose_dialect
from camrob.toolpath.apt.feed_units import FeedReader, unit_name
from camrob.toolpath.apt.goto_kernel import ROWS
from camrob.toolpath.apt.handlers import Interpreter
from camrob.toolpath.apt.lexer import Lexer
from camrob.toolpath.apt.state import Machine
from camrob.toolpath.defaults import Defaults, feed_finding, unit_finding, with_spindle
from camrob.toolpath.sampling import ANGLE_TOLERANCE, CHORD_TOLERANCE
from camrob.toolpath.split import split_at_turns
from camrob.toolpath.toolpath import Toolpath
from camrob.toolpath.toolpath_builder import clean_text
from camrob.units import m_to_mm

__all__ = ["read_cl"]

_HEAD = 65_536  # bytes in which a file gives itself away
_LARGEST_M = 3.0  # a part of this size, or a cutter of a tenth of it, makes one ask for the units
_UNITS = re.compile(rb"(?:^|;)[ \t]*UNITS?[ \t]*/", re.M | re.I)
_LOADS = re.compile(rb"(?:^|;)[ \t]*(?:LOADTL[ \t]*/|LOAD[ \t]*/[ \t]*TOOL)", re.M | re.I)
_FEED_IN = {
    unit: (words, re.compile(rb"(?:^|;)[ \t]*(?:FEDRAT|CYCLE)[ \t]*/[^\n]*?\b(?:%s)\b" % b"|".join(words), re.M | re.I))
    for unit, words in (("inch", (b"IPM", b"IPR")), ("mm", (b"MMPM", b"MMPR")))
}


def read_cl(
    path: Path,
    data: bytes,
    *,
    dialect: str | None = None,
    units: str | None = None,
    chord_tolerance: float = CHORD_TOLERANCE,
    angle_tolerance: float = ANGLE_TOLERANCE,
    defaults: Defaults | None = None,
    progress: Share | None = None,
) -> Toolpath:
    """The toolpath of one CL file's bytes, in the part's frame and in metres.

    `dialect` forces a dialect by name, `units` ("mm", "inch") overrides the file's; arcs, splines and helices become
    points within `chord_tolerance` (m) and `angle_tolerance` (rad). `defaults` are used where the file states no feed or
    starts no spindle. `progress` is called with the share done (0..1) about
    every hundredth. Raises ToolpathError, with path and line, for what can't be read or would make a wrong part.
    """
    try:
        return _read(path, data, dialect, units, chord_tolerance, angle_tolerance, defaults or Defaults(), progress)
    except InputError as error:
        raise error.at(path) from error


def _read(
    path: Path,
    data: bytes,
    dialect: str | None,
    units: str | None,
    chord: float,
    angle: float,
    defaults: Defaults,
    progress: Share | None,
) -> Toolpath:
    if not chord > 0.0 or not angle > 0.0:
        raise ToolpathError("chord and angle tolerance must be above zero", hint="choose 0.01 mm and 5 degrees")
    lexer = Lexer(data)
    chosen = choose_dialect(lexer.data[:_HEAD].decode("latin-1").replace("\r", ""), dialect)
    feeds = FeedReader(forced=None if units is None else unit_name(units), defaults=defaults)
    feeds.units = feeds.forced or "mm"
    machine = Machine(chosen, chord, angle, feeds)
    assumed = _look_ahead(machine, lexer.data.upper())
    interpreter = Interpreter(machine)
    _walk(lexer, interpreter, progress)
    interpreter.finish(lexer.line - 1, lexer.data.endswith((b"\n", b"\x1a")))
    if not any(len(r) for r in machine.regions):
        raise ToolpathError("the file holds no motion", hint="give a CL file with GOTO statements")
    findings = [unit_finding("units-assumed", assumed, feeds.units, machine.regions, 0)] if assumed else []
    if defaults.feed is not None and feeds.defaulted:
        findings.append(feed_finding(defaults.feed, feeds.defaulted))
    regions = tuple(part for region in machine.regions for part in split_at_turns(region))
    if defaults.spindle_rpm:
        regions, said = with_spindle(regions, defaults.spindle_rpm)
        findings += said
    toolpath = Toolpath(
        regions=regions,
        source=clean_text(path.name),
        sha256=hashlib.sha256(data).hexdigest(),
        dialect=chosen.name,
        units=feeds.units,
        tools=tuple(machine.tools.values()),
        findings=tuple(collapse([*findings, *machine.findings, *_doubts(machine)])),
        chord_tolerance=chord,
    )
    if progress is not None:
        progress(1.0)
    return toolpath


def _walk(lexer: Lexer, interpreter: Interpreter, progress: Share | None) -> None:
    """All statements in their order: runs of plain GOTO at once, everything else one by one."""
    machine = interpreter.m
    size, reported = max(len(lexer.data), 1), 0.0
    while True:
        rows, machine.rapid = lexer.gotos(machine.rapid)
        if rows is not None:
            still_rapid = machine.rapid
            interpreter.rows(rows)
            machine.rapid = still_rapid
        if rows is None or len(rows.lines) < ROWS:
            statement = lexer.next()
            if statement is None:
                return
            interpreter.statement(statement)
        if progress is not None and lexer.pos / size - reported >= 0.01:
            reported = min(lexer.pos / size, 1.0)
            progress(reported)


def _holds(capitals: bytes, pattern: re.Pattern[bytes], *words: bytes) -> bool:
    """Whether a pattern that takes one of `words` is in a file, which is in capitals: one without them is told at once."""
    return any(word in capitals for word in words) and pattern.search(capitals) is not None


def _look_ahead(machine: Machine, capitals: bytes) -> str:
    """What the whole file says of tools and of its unit, before it is read; why, where the unit is a guess."""
    machine.tool_by_number = not _holds(capitals, _LOADS, b"LOAD")
    return _guess_units(machine, capitals)


def _guess_units(machine: Machine, capitals: bytes) -> str:
    """The unit of length of a file that states none: as its feeds say, millimetres otherwise. Why, where that is a guess.

    Feeds in millimetres leave no doubt: it is what NX writes instead of a unit.
    """
    feeds = machine.feeds
    if feeds.forced is not None or _holds(capitals, _UNITS, b"UNIT"):
        return ""
    said = [unit for unit, (words, pattern) in _FEED_IN.items() if _holds(capitals, pattern, *words)]
    if not said:
        return "the file names no unit of length"
    if len(said) > 1:
        raise ToolpathError(
            "the file names no unit of length, and its feeds are in millimetres and in inches",
            hint="--units mm or inch",
        )
    feeds.units = said[0]
    return "the file names no unit of length, and its feeds are in inches" if feeds.units == "inch" else ""


def _doubts(machine: Machine) -> list[Finding]:
    """What the whole path makes one doubt: contradicting units, and a size that no part has."""
    found = [Finding("units-odd", text, Severity.WARNING, line) for text, line in machine.feeds.disagreements.items()]
    low = np.min([r.position.min(axis=0) for r in machine.regions], axis=0)
    high = np.max([r.position.max(axis=0) for r in machine.regions], axis=0)
    extent = float(np.max(high - low))
    widest = max((tool.diameter for tool in machine.tools.values()), default=0.0)
    if extent > _LARGEST_M or widest > 0.1 * _LARGEST_M or (machine.feeds.units == "inch" and widest > 0.1):
        sizes = f"the path spans {m_to_mm(extent):.0f} mm and the widest cutter {m_to_mm(widest):.1f} mm"
        text = f"{sizes}: is {machine.feeds.units} right?"
        found.append(Finding("units-odd", text, Severity.WARNING))
    return found
