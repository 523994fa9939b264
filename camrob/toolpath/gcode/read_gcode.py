"""Three-axis and five-axis G-code (tool centre point on, XYZAC or XYZBC) as a toolpath."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from camrob.errors import ToolpathError
from camrob.findings import Finding, Severity
from camrob.machine_tool import MachineTool
from camrob.toolpath.defaults import Defaults, check_unit, feed_finding, unit_finding, with_spindle
from camrob.toolpath.gcode.controls.control import Control
from camrob.toolpath.gcode.controls.registry import choose_control
from camrob.toolpath.gcode.coordinates import ToolFrame
from camrob.toolpath.gcode.cut_path import PathGrower
from camrob.toolpath.gcode.interpreter import Interpreter
from camrob.toolpath.gcode.language.called_files import Beside, with_called
from camrob.toolpath.gcode.lexer import decode
from camrob.toolpath.gcode.state import SCALES, Modal
from camrob.toolpath.gcode.turning import refuse_turning
from camrob.toolpath.recognise import GCODE_LINE
from camrob.toolpath.region import Region
from camrob.toolpath.toolpath import Tool, Toolpath
from camrob.toolpath.toolpath_builder import clean_text
from camrob.units import m_to_mm

__all__ = ["KINEMATICS", "read_gcode"]

_LARGE = 3.0  # m
_COMMENT = re.compile(r"\([^()\n]*+\)|;[^\n]*+")
_TOOL_CHANGE = re.compile(r"M[ \t]*+0*+6(?![0-9.])")
_NUMBERED = re.compile(r"\s*%[ \t]*[0-9]+[ \t]*\n(?!\s*[O:][0-9])")
_CLAMP = re.compile(r"M[ \t]*+0*+1[0-2](?![0-9.])")
_SPINDLE = re.compile(r"M[ \t]*+0*+[34](?![0-9.])")
_ANY_TCP = re.compile(r"G[ \t]*0*(?:43\.[45]|234)(?![0-9.])|M[ \t]*128(?![0-9.])|TRAORI")
_NO_AXES = re.compile(
    r"<[^>\n]*>|,[ \t]*C|^.*G[ \t]*0*(?:65|10|92)(?![0-9.]).*$", re.M
)  # names of parameters and labels, arguments of macros, zeros that are set
_LINUXCNC_TCP = re.compile(r"M[ \t]*428(?![0-9.])")
KINEMATICS = ("xyzac", "xyzbc", "xyzac-iso", "xyzbc-iso")
_MANY_DECIMALS = re.compile(r"[ABC][ \t]*+[-+]?+[ \t]*+[0-9]?\.[0-9]{9}")
_ROTARY_WORD = re.compile(r"[ABC][ \t]*+[-+]?+[ \t]*+[0-9.]")


def read_gcode(
    path: Path,
    data: bytes,
    *,
    units: str | None,
    chord_tolerance: float,
    angle_tolerance: float,
    kinematics: str | None = None,
    defaults: Defaults | None = None,
    machine_tool: MachineTool | None = None,
) -> Toolpath:
    """Read the bytes of a G-code program (`path` only names it) as regions in the part's frame.

    `units` "mm" or "inch" overrules G20 and G21; None takes them, and millimetres where the file has neither.
    `kinematics` "xyzac" or "xyzbc" says how rotary words turn the tool (see `rotary_axes`); None recognises it from
    the words used. `machine_tool`: the machine whose axes the program names. Arcs are cut into chords that leave them by at
    most `chord_tolerance` (m) and turn by at most `angle_tolerance` (rad); tool axes of neighbouring cut points differ by at most
    the latter. Feeds are speeds of the tip in m/s, also from inverse time (G93) and feed per revolution (G95). `defaults` are
    used where the program states no feed or starts no spindle. The dialect is "gcode-xyzac", "gcode-xyzbc" (with "-iso"),
    "gcode-3axis", or, where no machine is named for rotary words, the control's ("gcode", "gcode-siemens", ...). Raises
    ToolpathError with the line for anything that would make a wrong part.
    """
    if units not in (None, *SCALES):
        raise ToolpathError(f"units {units!r}", hint="mm or inch", path=path)
    if not (chord_tolerance > 0.0 and angle_tolerance > 0.0):
        raise ToolpathError(
            "chord or angle tolerance isn't above zero", hint="0.01 mm and 0.5 degrees are usual", path=path
        )
    lines = decode(data, path)
    control = choose_control(_bare(lines), path.suffix)
    defaults = defaults or Defaults()
    beside = with_called(lines, data, path, control.wanted)
    try:
        bare = _bare(beside.lines)
        refuse_turning(bare, path, plain=control.plain)
        machine = _kinematics(bare, kinematics, path, plain=control.plain, told=machine_tool is not None)
        grower = PathGrower(machine, chord_tolerance, angle_tolerance)
        modal = _modal(control, bare, machine, path, defaults)
        if units is not None:
            modal.scale, modal.forced = SCALES[units], True
        interpreter = Interpreter(grower, ToolFrame(machine, machine_tool), modal, defaults)
        return _toolpath(control, beside, path, machine, interpreter)
    except ToolpathError as error:
        raise beside.place(error) from None


def _bare(lines: list[str]) -> str:
    """A program without its comments, upper case."""
    return _COMMENT.sub("", "\n".join(lines)).upper()


def _toolpath(control: Control, beside: Beside, path: Path, machine: str, interpreter: Interpreter) -> Toolpath:
    """What the blocks of a program come to. Raises ToolpathError with its line, counted on into what it calls."""
    grower, modal = interpreter.path, interpreter.modal
    if interpreter.frame.machine is not None:
        grower.note("machine-axes", "rotary words turn the axes of the machine that the set-up names", 0, Severity.INFO)
    if beside.files:
        names = ", ".join(clean_text(name) for name, _ in beside.files)
        text = f"what it calls is read from files beside it: {names}; their lines are counted on from its last"
        grower.note("called-files", text, 0)
    _run(control, beside.lines, path, grower, interpreter)
    if machine != "3axis":
        _suspect_radians(_bare(beside.lines), grower)
    try:
        interpreter.finish()
        regions = grower.finish()
    except ToolpathError as error:
        raise error.at(path, error.line or len(beside.lines)) from None
    regions, findings = _with_defaults(regions, interpreter)
    _suspect_size(regions, grower)
    numbers = sorted({region.tool for region in regions if region.tool})
    return Toolpath(
        regions=regions,
        source=clean_text(path.name),
        sha256=beside.sha256,
        dialect=control.dialect if machine in ("unknown", "machine") else f"gcode-{machine}",
        units="inch" if modal.scale == SCALES["inch"] else "mm",
        tools=tuple(Tool(number) for number in numbers),
        findings=(*findings, *grower.findings()),
        chord_tolerance=grower.chord,
    )


def _modal(control: Control, bare: str, machine: str, path: Path, defaults: Defaults) -> Modal:
    """What holds when a control's program begins; bare: its text without comments, upper case."""
    return Modal(
        numbered=bool(_NUMBERED.match(bare)) and control.plain,
        tool_by_t=not _TOOL_CHANGE.search(bare),
        wear=defaults.wear,
        zero_edge=control.zero_edge,
        keeps_motion=control.keeps_motion,
        rereads=control.rereads or path.suffix.lower() == ".ngc",
        edges=control.edges,
        metric=control.metric,
        rolls=control.rolls and machine.endswith("-iso"),
        clamps=control.clamps and bool(_CLAMP.search(bare) and _SPINDLE.search(bare)),
    )


def _with_defaults(regions: tuple[Region, ...], interpreter: Interpreter) -> tuple[tuple[Region, ...], list[Finding]]:
    """The regions with a spindle where the program starts none, and what was assumed where it is silent."""
    modal, process, motions = interpreter.modal, interpreter.process, interpreter.motions
    findings: list[Finding] = []
    if modal.unit_line:
        reason = f"neither {'G70 nor G71' if modal.metric else 'G20 nor G21'} stands before the first move"
        check_unit(reason, regions, modal.unit_line, metric=modal.metric)
        findings.append(unit_finding("units-not-stated", reason, "mm", regions, modal.unit_line))
    if motions.defaults.feed is not None and motions.defaulted:
        findings.append(feed_finding(motions.defaults.feed, motions.defaulted))
    if process.given_speed:
        regions, said = with_spindle(regions, process.given_speed, of_file=process.speed_of_file)
        findings += said
    return regions, findings


def _refuse_rest(lines: list[str], line: int) -> None:
    """Raises ToolpathError where a program goes on behind a % that no M2 or M30 stands before: the control would not run that."""
    if any(GCODE_LINE.match(text.encode()) for text in lines[line:]):
        raise ToolpathError(
            "the program ends at this %, without M2 or M30, and more blocks follow",
            hint="take the % out, or what is behind it",
            line=line,
        )


def _run(control: Control, lines: list[str], path: Path, grower: PathGrower, interpreter: Interpreter) -> None:
    """Carry the blocks out up to the program's end; refuse a file that is cut off."""
    opened = closed = False
    blocks = 0
    for block in control.blocks(lines, path, interpreter.state):
        if block.percent:
            closed = blocks > 0
            opened = True
            if closed:
                break
            continue
        blocks += bool(block.words or block.g or block.m)
        try:
            interpreter.run(block)
        except ToolpathError as error:
            raise error.at(path, block.line) from None
        if interpreter.ended:
            return
    if not blocks:
        raise ToolpathError("no G-code in the file", hint="export it again", path=path)
    if closed:
        _refuse_rest(lines, block.line)
        return
    if opened or lines[-1].strip():
        raise ToolpathError(
            "the program has no end (M2, M30 or %), the file seems to be cut off",
            hint="export it again, or end it with M30",
            path=path,
            line=len(lines),
        )
    grower.note(
        "no-program-end", "the program has no M2 or M30 at its end: check that the file is complete", len(lines)
    )


def _kinematics(bare: str, wanted: str | None, path: Path, *, plain: bool, told: bool) -> str:
    """Which machine the rotary words belong to: xyzac, xyzbc, either with "-iso", 3axis, "machine" where it is told, or unknown.

    LinuxCNC's M428 names its own tables; what G43.4, G234, M128 or TRAORI is programmed for, nobody says but the user.
    `plain`: the program's words are ISO's.
    """
    if wanted not in (None, *KINEMATICS):
        raise ToolpathError(f"kinematics {wanted!r} is not known", hint="one of " + ", ".join(KINEMATICS), path=path)
    if told and wanted is not None:
        raise ToolpathError(
            f"the set-up describes the machine, and the dialect names {wanted}", hint="keep one of the two", path=path
        )
    if told:
        return "machine"
    if not plain:
        return wanted or "unknown"
    bare = _NO_AXES.sub(" ", bare)
    present = {a for a in "ABC" if re.search(rf"{a}[ \t]*+[-+]?+[ \t]*+[0-9.#\[]", bare)}
    moving = {a for a in "AB" if re.search(rf"{a}[ \t]*+[-+]?+[ \t]*+(?:[0.]*+[1-9]|[#\[])", bare)}
    if moving == {"A", "B"}:
        raise ToolpathError(
            "A and B both turn: a kinematics that is not known here",
            hint="post for an XYZAC or XYZBC machine with TCP on, or export CL data",
            path=path,
        )
    if wanted is not None:
        stranger = "B" if wanted.startswith("xyzac") else "A"
        if stranger in moving:
            raise ToolpathError(f"{stranger} words in a program for {wanted}", hint="check the kinematics", path=path)
        return wanted
    if _ANY_TCP.search(bare) and not _LINUXCNC_TCP.search(bare):
        return "unknown"
    if "B" in moving or (not moving and "B" in present and "A" not in present):
        return "xyzbc"
    return "xyzac" if present else "3axis"


def _suspect_size(regions: tuple[Region, ...], grower: PathGrower) -> None:
    """Say so where the path is larger than a part that one robot cuts."""
    low = np.min([region.position.min(axis=0) for region in regions], axis=0)
    high = np.max([region.position.max(axis=0) for region in regions], axis=0)
    extent = float(np.max(high - low))
    if extent > _LARGE:
        grower.note(
            "size-implausible",
            f"the path is {m_to_mm(extent):.0f} mm long or wide: check the units",
            regions[0].first_line,
        )


def _suspect_radians(bare: str, grower: PathGrower) -> None:
    """Say so where rotary words look like radians: below 2 pi, with nine decimals or more."""
    words = len(_ROTARY_WORD.findall(bare))
    fine = len(_MANY_DECIMALS.findall(bare))
    if words >= 4 and 2 * fine > words and not re.search(r"[ABC][ \t]*+[-+]?+[ \t]*+(?:[7-9]|0*+[1-9][0-9])", bare):
        grower.note(
            "rotary-in-radians", "rotary words look like radians (all below 7, many decimals): read as degrees", 0
        )
