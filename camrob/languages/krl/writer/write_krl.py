"""The writer of KRL: a program in, the controller's files out."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from camrob.cell.controller_settings import ControllerSettings
from camrob.findings import Finding
from camrob.languages.krl.krl_text import NAME_LENGTH, krl_name
from camrob.languages.krl.writer.body import KrlBody
from camrob.languages.krl.writer.opening import opening_lines
from camrob.program.motion import Motion
from camrob.program.program import Program
from camrob.program.sub_programs import split_parts

__all__ = ["iter_krl"]

_HEADER = ("&ACCESS RVP", "&REL 1", "&PARAM TEMPLATE = C:\\KRC\\Roboter\\Template\\vorgabe", "&PARAM EDITMASK = *")


def iter_krl(
    program: Program,
    controller: ControllerSettings,
    *,
    max_lines: int | None,
    findings: list[Finding] | None = None,
) -> Iterator[tuple[str, bytes]]:
    """The files of a program one after another: NAME.src, NAME.dat, and where it is split NAME_001.src and so on.

    A program that passes `max_lines` motions (None: the cell's) or the cell's bytes a file is cut at safe retracts.
    NAME.src then sets everything up, runs the PTP motions that lead in, and calls the parts in turn; a part has no
    initialisation, it only says `$VEL.CP` before its first CP motion. 7-bit text, CRLF. Every number is the one in
    `program`, whose poses and axes must be rounded already (`rounding`); tool, base and speed are
    rounded here. Memory: one file at a time.
    `findings`, where given, receives a warning for every border that lies in a cut.

    Raises JobError where a motion passes the budget or a line gets longer than the controller takes,
    ValueError for a program that is no program (unrounded, not finite, CIRC without its end, unknown hook).
    """
    budget = controller.max_lines if max_lines is None else max_lines
    if budget < 1:
        raise ValueError(f"max_lines is {budget}")
    name = krl_name(program.name)
    body = KrlBody(program, controller)
    before, after = opening_lines(program, controller, body), body.hook("footer")
    sizes, counted = body.sizes(), program.kind != Motion.CIRC_VIA
    frame_bytes = sum(len(line) + 2 for line in (*before, *after, *_HEADER)) + 2 * NAME_LENGTH + 200
    if int(counted.sum()) <= budget and int(sizes.sum()) + frame_bytes <= controller.max_bytes:
        yield f"{name}.src", _source(name, (), [*before], body.text(0, len(program), last=True), after)
        yield f"{name}.dat", _data(name)
        return
    lead = _lead_in(program)
    overhead = 2 * controller.max_line_length + 400
    ends = split_parts(
        sizes,
        counted,
        program.safe,
        program.kind != Motion.CIRC_VIA,
        max_motions=budget,
        max_bytes=controller.max_bytes - overhead,
        line=program.line,
        start=lead,
    )
    if findings is not None:
        findings += [_cut_in_motion(program, end) for end in ends[:-1] if not program.safe[end - 1]]
    parts = _part_names(name, len(ends))
    calls = [f"{part} ( )" for part in parts]
    yield f"{name}.src", _source(name, parts, before, body.text(0, lead, last=False), [*calls, *after])
    yield f"{name}.dat", _data(name)
    for part, start, end in zip(parts, [lead, *ends[:-1]], ends, strict=True):
        yield f"{part}.src", _source(part, (), [], body.text(start, end, last=end == len(program)), [])


def _cut_in_motion(program: Program, end: int) -> Finding:
    """A file border in the middle of a cut."""
    text = "a file of the program ends in the middle of a cut, as no retract lies within the budget of a file"
    return Finding("split-in-cut", text, line=int(program.line[end - 1]), point=end - 1)


def _part_names(name: str, count: int) -> list[str]:
    """Names of the parts, all of one length, none of them the main program's."""
    digits = max(3, len(str(count)))
    stem = name[: NAME_LENGTH - 1 - digits].rstrip("_")
    if any(f"{stem}_{k + 1:0{digits}d}" == name for k in range(count)):
        stem = stem[:-1].rstrip("_") + "P"
    return [f"{stem}_{k + 1:0{digits}d}" for k in range(count)]


def _lead_in(program: Program) -> int:
    """How many motions lead in by PTP: they stay in the main program, where the block coincidence run belongs."""
    ptp = (program.kind == Motion.PTP_AXES) | (program.kind == Motion.PTP_POSE)
    lead = len(ptp) if ptp.all() else int(np.argmin(ptp))
    return lead if lead < len(ptp) else 0


def _source(name: str, parts: tuple[str, ...] | list[str], before: list[str], text: bytes, after: list[str]) -> bytes:
    """A .src file. The EXT declarations stand directly behind DEF."""
    head = [*_HEADER, f"DEF {name} ( )", *(f"EXT {part} ( )" for part in parts), *before]
    return _encoded(head) + text + _encoded([*after, "END"])


def _data(name: str) -> bytes:
    """The .dat file that belongs to the main program."""
    return _encoded([*_HEADER, f"DEFDAT {name}", "EXT BAS (BAS_COMMAND :IN,REAL :IN )", "ENDDAT"])


def _encoded(lines: list[str]) -> bytes:
    """Lines as the controller stores them."""
    return "".join(line + "\r\n" for line in lines).encode("ascii")
