"""Files that people hand over and that are no CL data: what they are, and what to export in their place."""

from __future__ import annotations

import re

from camrob.errors import ToolpathError

__all__ = ["refuse_foreign"]

_HEAD = 65_536  # bytes that are looked at
_POST = "post the part as G-code or CL data (APT) instead"
_KLARTEXT = "have it posted as plain language (.h)"
_OTHER = "post the part for Fanuc, Siemens or Heidenhain, or as CL data (APT)"
_BOARD = "have a program for circuit boards (FlatCAM, pcb2gcode) make G-code of it"
_PATH = "make a toolpath of it in the CAM system, and output that as CL data (APT) or G-code"
_PROGRAM = "give the CL file that it was made from; 'camrob verify' judges programs"
# what a file begins with, or holds; what it is called; what to do
_KINDS: tuple[tuple[re.Pattern[bytes], str, str], ...] = tuple(
    (re.compile(pattern, re.I | re.M), what, hint)
    for pattern, what, hint in (
        (rb"\A\s*(?:&ACCESS|DEF(?:DAT)?[ \t]+\w+[ \t]*\()", "a KRL program", _PROGRAM),
        (rb"\A(?:\s*%%%[^%]*%%%)?\s*MODULE[ \t]+\w+", "an ABB RAPID program", _PROGRAM),
        (rb"\A\s*/JOB\b", "a Yaskawa job", _PROGRAM),
        (rb"\A\s*/PROG\b", "a FANUC robot program", _PROGRAM),
        (
            rb"\A\s*%(?:MPF|SPF)[ \t]*\d|^[ \t]*(?:N\d+[ \t]*)?@\d{3}[ \t]+[RKP]",
            "a program for Siemens' older controls (Sinumerik 805 to 880: %MPF, L100, @ commands, cycles by R)",
            _OTHER,
        ),
        (
            rb"^[ \t]*(?:N\d+[ \t]*)?G9[89](?:[ \t]*[XYZIJK][-+]?[\d.]+){6}",
            "a program for MAHO's or Philips' controls (G98 and G99 with X Y Z I J K are what the screen shows)",
            _OTHER,
        ),
        (rb"^[ \t]*:[ \t]*[GT]\d", "a program for Cincinnati's controls (Acramatic: a colon begins a block)", _OTHER),
        (
            rb'^[ \t]*(?:N\d+[ \t]*)?M98[ \t]*P[ \t]*"',
            "a program for RepRapFirmware (Duet) that calls a file of the machine's by M98",
            "put that file's blocks in the place of the call",
        ),
        (
            # no Z in the whole file, and G38 and G39 alone, M functions of wire and generator, or Sodick's tables of conditions
            rb"\A(?![\s\S]*?^[^(;\n]*Z[ \t]*[-+]?[\d.])(?:(?=[\s\S]*?^[ \t]*(?:N\d+[ \t]*)?G38[ \t]*\r?$)"
            rb"(?=[\s\S]*?^[ \t]*(?:N\d+[ \t]*)?G39[ \t]*\r?$)|(?=[\s\S]*?^[^(;\n]*G4[12](?!\d))(?=[\s\S]*?^[^(;\n]*M82(?!\d))"
            rb"(?=[\s\S]*?^[^(;\n]*M84(?!\d))"
            rb"|(?=[\s\S]*?^[^(;\n]*M60(?!\d))(?=[\s\S]*?^[^(;\n]*M50(?!\d))|(?=[\s\S]*?^C\d{3}[ \t]*=[ \t]*\d))",
            "a program for wire erosion (no Z, and words of its wire and generator)",
            "a wire has no tool's tip: mill the part's contour by a milling program",
        ),
        (rb"\A\s*%\S+[ \t]+G7[01][ \t]*\*", "a program in Heidenhain's DIN/ISO", _KLARTEXT),
        (
            rb"\A\s*(?:\d+[ \t]+)?L[ \t]+(?:I?[XYZ][-+]?\d\S*[ \t]+)+(?:R0[ \t]*)?F(?:MAX|AUTO|[ \t]*\d)",
            "a piece of a Heidenhain program, without BEGIN PGM and the tool",
            "give the program that calls it, with this file beside it, or put BEGIN PGM, TOOL CALL and END PGM round it",
        ),
        (
            rb"\A\s*%PM\d*[ \t]*\r?$|^[ \t]*N\d+[ \t]+G7[ \t][^\n(]*\b[ABC][56]=",
            "a program for Heidenhain's MillPlus",
            _OTHER,
        ),
        (
            rb"\A\s*%@MACRO\b|^[ \t]*(?:N\d+[ \t]*)?(?:END_IF\b|END_WHILE\b|(?:IF|WHILE)[ \t]*\[@\d)",
            "a macro program of a control of Syntec's kind (@1, END_IF)",
            "have the path written out as plain blocks",
        ),
        (
            rb"^[ \t]*(?:N\d+[ \t]*)?(?:#(?:RTCP|CS|MCS|TRAFO|KIN|VAR)\b(?! *=)|V\.[A-Z]\.\w)",
            "a program in the language of Fagor's 8070 or of ISG's kernel (#RTCP, #CS, V.P.)",
            _OTHER,
        ),
        (
            rb"\A[ \t]*\d{1,4}[ \t]*\r?\n(?:[ \t]*[-+.\d]+){5,}[ \t]*\r?\n[ \t]*\d{1,4}[ \t]*\r?\n",
            "a Mastercam NCI file",
            _POST,
        ),
        (
            rb"\A\s*M48[ \t]*\r?$[\s\S]{0,9999}?^T\d+(?:F\d+)?(?:S\d+)?C[\d.]",
            "a circuit board's drill file (Excellon)",
            _BOARD,
        ),
        (rb"^%FS[LTD][AI]X\d\dY\d\d\*%|^%MO(?:MM|IN)\*%", "a circuit board's drawing (Gerber)", _BOARD),
        (rb"\A\s*(?:IN|DF|SP\d|P[UDA][-\d,]*)[ \t]*;[ \t]*(?:IN|SP|P[UDA]|VS|\r?\n)", "a plotter's file (HPGL)", _POST),
        (rb"\A\s*ISO-10303-21;", "a STEP file: a shape, no path", _PATH),
        (rb"\A.{72}S {6}1", "an IGES file: a shape, no path", _PATH),
        (rb"\A\s*solid\b[^\n]*\n\s*facet\b", "an STL mesh: a shape, no path", _PATH),
        (rb"\Aply\r?\n", "a PLY mesh: a shape, no path", _PATH),
        (rb"\A\s*0\r?\n\s*SECTION\r?\n", "a DXF drawing: a shape, no path", _PATH),
        (rb"\A\s*<(?:!DOCTYPE|html|\?xml|svg)", "XML or HTML", "save the CL file itself, not the page that shows it"),
        (rb"\A%PDF-", "a PDF document", _PATH),
        (rb"\APK\x03\x04|\A\x1f\x8b|\A7z\xbc\xaf", "a packed archive", "unpack it, and give the CL file in it"),
    )
)
_GEOMETRY = re.compile(rb"^\s*\w+\s*=\s*(?:POINT|LINE|CIRCLE|PLANE|VECTOR|PATERN)\s*/", re.I | re.M)
_POINTS = re.compile(rb"^\s*GOTO\s*/\s*[-+.\d]", re.I | re.M)


def refuse_foreign(data: bytes) -> None:
    """Raises ToolpathError for the bytes of a file that is known to be something else than CL data or G-code."""
    head = data[:_HEAD]
    for pattern, what, hint in _KINDS:
        if pattern.search(head):
            raise ToolpathError(f"this is {what}", hint=hint)
    if _GEOMETRY.search(head) and not _POINTS.search(head):
        raise ToolpathError(
            "this is APT source, a part program with its geometry, not the path that a processor makes of it",
            hint="run it through the APT processor, and give its CLDATA as text",
        )
