"""The writer of RAPID: a program in, the controller's modules out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from camrob.cell.controller_settings import ControllerSettings
from camrob.errors import JobError
from camrob.findings import Finding
from camrob.languages.rapid.rapid_numbers import (
    ANGLE_DECIMALS,
    EXTERNAL_DECIMALS,
    FRAME_DECIMALS,
    LENGTH_DECIMALS,
    LOAD_DECIMALS,
    QUATERNION_DECIMALS,
    SPEED_DECIMALS,
    quaternions,
)
from camrob.languages.rapid.rapid_settings import RapidSettings, rapid_settings
from camrob.languages.rapid.rapid_text import NAME_LENGTH, comment_text, rapid_name, row
from camrob.languages.rapid.writer.body import INDENT, Names, RapidBody
from camrob.program.motion import Motion
from camrob.program.printed import fixed_decimals
from camrob.program.program import Program
from camrob.program.sub_programs import split_parts

__all__ = ["check_rapid", "iter_rapid", "opening_statements"]

_NO_FRAME = "[[0,0,0],[1,0,0,0]]"
_LEAST_PART_DIGITS = 3  # NAME_001


def check_rapid(program: Program, controller: ControllerSettings) -> None:
    """Raise ValueError for a program without a meaning in RAPID, JobError for one that ABB does not take."""
    names = Names(rapid_name(program.name))
    body = RapidBody(program, controller, names)
    _opening(program, controller, body, names)
    body.hook("footer")
    body.sizes()  # prints every line once


def iter_rapid(
    program: Program,
    controller: ControllerSettings,
    *,
    max_lines: int | None,
    findings: list[Finding] | None = None,
) -> Iterator[tuple[str, bytes]]:
    """The files of a program one after another: NAME.mod, NAME_001.mod and so on where it is split, NAME.pgf that lists them.

    A program that passes `max_lines` motions (None: the cell's) or the cell's bytes a file is cut at safe retracts. NAME.mod
    then holds tools, work object and settings, the motions that lead in, and calls the parts in turn. Every motion names its
    tool, work object, speed and zone itself, so that a part stands for itself. 7-bit text, CRLF.
    `findings`, where given, receives a warning for every border that lies in a cut.

    Raises JobError where a motion passes the budget or a line gets longer than the controller takes, or where RAPID has no word
    for it, ValueError for a program that is no program.
    """
    budget = controller.max_lines if max_lines is None else max_lines
    if budget < 1:
        raise ValueError(f"max_lines is {budget}")
    name = rapid_name(program.name)
    body = RapidBody(program, controller, Names(name))
    before, after = _opening(program, controller, body, Names(name)), body.hook("footer")
    sizes, counted = body.sizes(), program.kind != Motion.CIRC_VIA
    frame_bytes = sum(len(line) + 2 for line in (*before, *after)) + 4 * NAME_LENGTH + 200  # what a module has round it
    if int(counted.sum()) <= budget and int(sizes.sum()) + frame_bytes <= controller.max_bytes:
        yield f"{name}.mod", _module(name, [*before, *_text(body, 0, len(program), last=True), *after])
        yield f"{name}.pgf", _listing([name])
        return
    ptp = program.kind < Motion.LIN
    lead = 0 if ptp.all() else int(np.argmin(ptp))  # motions that lead in by PTP stay in the main module
    ends = split_parts(
        sizes,
        counted,
        program.safe,
        counted,
        max_motions=budget,
        max_bytes=controller.max_bytes - 4 * NAME_LENGTH - 200,
        line=program.line,
        start=lead,
    )
    if findings is not None:
        findings += [_cut_in_motion(program, end) for end in ends[:-1] if not program.safe[end - 1]]
    parts = _part_names(name, len(ends))
    calls = [f"{INDENT}{INDENT}p_{part};" for part in parts]
    yield f"{name}.mod", _module(name, [*before, *_text(body, 0, lead, last=False), *calls, *after])
    for part, start, end in zip(parts, [lead, *ends[:-1]], ends, strict=True):
        lines = _text(body, start, end, last=end == len(program))
        yield f"{part}.mod", _module(part, [f"{INDENT}PROC p_{part}()", *lines])
    yield f"{name}.pgf", _listing([name, *parts])


def opening_statements(controller: ControllerSettings, settings: RapidSettings, loadless: Iterable[str]) -> list[str]:
    """The statements that a program opens with; `loadless`: its tooldata whose load is the controller's own."""
    acceleration = fixed_decimals(controller.acc_cp, 4)  # decimals of m/s2
    said = [f"ActUnit {unit};" for unit in settings.active_units]
    said += [
        "PDispOff;",
        "EOffsOff;",
        "ConfJ\\On;",
        "ConfL\\Off;",
        "SingArea\\Off;",
        "CirPathMode\\ObjectFrame;",
        "AccSet 100,100;",
        "VelSet 100,5000;",
        f"PathAccLim TRUE\\AccMax:={acceleration},TRUE\\DecelMax:={acceleration};",
    ]
    return said + [f"{tool}.tload:={settings.tool_data}.tload;" for tool in loadless]


def _opening(program: Program, controller: ControllerSettings, body: RapidBody, names: Names) -> list[str]:
    """What the main module says before it moves: data, then the procedure's beginning."""
    settings = rapid_settings(controller)
    longest = controller.max_line_length
    lines = [
        f"{INDENT}! Made by camrob, rounded to {LENGTH_DECIMALS} decimals (mm), {QUATERNION_DECIMALS} (q1..q4), "
        f"{ANGLE_DECIMALS} (deg), {EXTERNAL_DECIMALS} (eax)"
    ]
    lines += [f"{INDENT}! " + comment_text(text, longest - len(INDENT) - 2) for text in program.comment]
    tools = list(zip(body.mounted.frames, body.mounted.loads, strict=True))
    loadless = [names.tool(k) for k, (_, load) in enumerate(tools) if load is None]
    if loadless and not settings.tool_data:
        what = "RAPID's tooldata states what hangs on the flange, and nobody says what it weighs"
        raise JobError(
            f"{what}; state mass and centre of the tool in the set-up, or tool_data in the cell's [controller]"
        )
    for k, (frame, load) in enumerate(tools):
        lines.append(f"{INDENT}PERS tooldata {names.tool(k)}:=[TRUE,{_pose(frame)},{_load(load)}];")
    unit = settings.mechanical_unit
    how = f'FALSE,"{unit}"' if unit else 'TRUE,""'
    lines.append(f"{INDENT}PERS wobjdata {names.wobj}:=[FALSE,{how},{_NO_FRAME},{_pose(program.base)}];")
    lines.append(f"{INDENT}CONST zonedata {names.zone}:={_zone(controller.apo_cdis_mm)};")
    lines.append(f"{INDENT}CONST speeddata {names.joint_speed}:={row(settings.ptp_speed, SPEED_DECIMALS)};")
    lines.append(f"{INDENT}PROC main()")
    lines += [INDENT * 2 + said for said in opening_statements(controller, settings, loadless)]
    for line in lines:
        body.check_length(line)
    return [*lines, *body.hook("header")]


def _pose(xyzabc: np.ndarray) -> str:
    """`[[x,y,z],[q1,q2,q3,q4]]`."""
    turn = quaternions(xyzabc[3:])
    return f"[{row(xyzabc[:3].tolist(), FRAME_DECIMALS)},{row(turn.tolist(), QUATERNION_DECIMALS)}]"


def _load(load: np.ndarray | None) -> str:
    """A loaddata, its axes the flange's; the one of ABB's tool0 until the opening sets the controller's own."""
    if load is None:
        return "[0.001,[0,0,0.001],[1,0,0,0],0,0,0]"
    mass, *moments = (fixed_decimals(float(v), LOAD_DECIMALS) for v in (load[0], *load[4:]))
    heavy = ",".join(moments if load[4:].any() else "000")
    return f"[{mass},{row(load[1:4].tolist(), LOAD_DECIMALS)},[1,0,0,0],{heavy}]"


def _zone(distance_mm: float) -> str:
    """A zonedata: one distance for tool and external axes, a tenth of it in degrees, as ABB's own z0 and z1 have it."""
    mm, degrees = fixed_decimals(distance_mm, 3), fixed_decimals(0.1 * distance_mm, 4)  # decimals
    return f"[FALSE,{mm},{mm},{mm},{degrees},{mm},{degrees}]"


def _cut_in_motion(program: Program, end: int) -> Finding:
    """A file border in the middle of a cut."""
    text = "a file of the program ends in the middle of a cut, as no retract lies within the budget of a file"
    return Finding("split-in-cut", text, line=int(program.line[end - 1]), point=end - 1)


def _part_names(name: str, count: int) -> list[str]:
    """Names of the parts, all of one length, none of them the main program's."""
    digits = max(_LEAST_PART_DIGITS, len(str(count)))
    stem = name[: NAME_LENGTH - 1 - digits].rstrip("_")
    if any(f"{stem}_{k + 1:0{digits}d}" == name for k in range(count)):
        stem = stem[:-1].rstrip("_") + "P"
    return [f"{stem}_{k + 1:0{digits}d}" for k in range(count)]


def _text(body: RapidBody, start: int, end: int, *, last: bool) -> list[str]:
    return [line for _, line in body.lines(start, end, last=last)]


def _module(name: str, lines: list[str]) -> bytes:
    """A module with one procedure, which `lines` begin within."""
    return _encoded([f"MODULE {name}", *lines, f"{INDENT}ENDPROC", "ENDMODULE"])


def _listing(modules: list[str]) -> bytes:
    """The .pgf file that a controller opens as the program."""
    listed = [f"{INDENT}<Module>{module}.mod</Module>" for module in modules]
    return _encoded(['<?xml version="1.0" encoding="ISO-8859-1" ?>', "<Program>", *listed, "</Program>"])


def _encoded(lines: list[str]) -> bytes:
    """Lines as the controller stores them."""
    return "".join(line + "\r\n" for line in lines).encode("ascii")
