"""The CL side of the witness: what a CL file asks for, from its text alone."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from camrob.errors import ToolpathError
from camrob.witness.cl.apt import AptReader
from camrob.witness.cl.foreign.autodesk import CONTOURS, FUSION, MORI, TRUEPATH
from camrob.witness.cl.offsets import Offsets
from camrob.witness.cl.source import read_text
from camrob.witness.cl.teller import Teller
from camrob.witness.happenings import Story
from camrob.witness.machine_tool import MachineTool

if TYPE_CHECKING:
    from camrob.witness.cl.gcode import GcodeReader

__all__ = ["read_story"]

_HEAD = 200_000  # characters in which a file shows whose it is
_APT = re.compile(
    r"^[ \t]*(GOTO[ \t]*/|(FROM|CIRCLE|FEDRAT|SPINDL|TOOL PATH|PARTNO|CUTTER|LOADTL|UNITS?|PPRINT|MACHIN)[ \t]*(/|[ \t]\w))",
    re.I | re.M,
)
_GCODE = re.compile(r"^[ \t/]*(N\d+)?[ \t]*[GXYZMTSF][ \t]*[-+]?[\d.#\[]", re.I | re.M)
_MARKS = (
    ("makino", r"APTCL-SPEC,MAKINO"),
    (TRUEPATH, r"^\s*MCS\s*/"),
    (MORI, r"^\s*MCSYS\s*/\s*NUM\b"),
    ("freecad-apt", r"^\$\$ CL data of FreeCAD, written by camrob_post"),
    ("camworks-clt", r"^\s*OPFEATSTART\s*/"),
    ("camworks-apt", r"^\s*(CSI_SET_\w+|TRNTYP)\s*/"),
    ("creo-ncl", r"PRO/CLFILE"),
    ("catia", r"CATIA APT VERSION|\$\$\*CATIA0|^\$\$ *(Start generation of|OPERATION NAME) *:"),
    ("nx-clsf", r"^\s*(TOOL PATH|TLDATA|PAINT)\s*/"),
    (FUSION, r"^PARTNO/ ?'[^\n]*'\s*$"),
)
# programs that look like G-code
_KLARTEXT = re.compile(r"^[ \t]*(N?\d+[ \t]+)?BEGIN PGM ", re.I | re.M)
_SINUMERIK = (
    r"\b(G7[01]0|CYCLE8\d+|ORIWKS|ORIMKS|ORIVECT|SUPA|COMPCAD|FFWON|G64[0-5]|STOPRE|MCALL|GOTO[FB])\b|^%_N_"
    r"|\bA?(TRANS|ROT|MIRROR|SCALE)[ \t]+[XYZ]|\b(POCKET\d?|LONGHOLE|SLOT[12]|HOLES[12]|CIP|WORKPIECE|CYCLE[67]\d)\b"
    r"|\b(RND|CH[RF]|AP|RP)[ \t]*=|^[ \t]*(N\d+[ \t]+)?REPEATB?[ \t]+[A-Z_]"
    r"|\b(DEF[ \t]+(REAL|INT)|R\d+[ \t]*=)|\b([XYZABC]|[ABC]3|CR|TURN|T)[ \t]*=[ \t]*[-+(\dR\"A-Z]"
)
_NAMES = {
    "nx": "nx-clsf",
    "clsf": "nx-clsf",
    "creo": "creo-ncl",
    "ncl": "creo-ncl",
    "catia": "catia",
    "camworks": "camworks-apt",
    "solidworks": "camworks-apt",
    "camworks-clt": "camworks-clt",
    "clt": "camworks-clt",
    "makino": "makino",
    "apt": "apt",
    "iso-apt": "apt",
    "freecad": "freecad-apt",
    "fusion": FUSION,
    "camplete": TRUEPATH,
    "mori": MORI,
    "gcode": "gcode",
    "g-code": "gcode",
}


def _named(dialect: str) -> str:
    """Our name of a dialect that the caller names."""
    name = dialect.lower().replace("_", "-")
    for start in sorted(_NAMES, key=len, reverse=True):
        if name.startswith(start):
            return _NAMES[start]
    raise ToolpathError(f"unknown dialect {dialect!r}", hint=f"one of {', '.join(sorted(set(_NAMES.values())))}")


def _recognised(text: str) -> str:
    """Whose file it is, by what only that system writes."""
    head = text[:_HEAD]
    if _KLARTEXT.search(head):
        return "gcode"
    if not _APT.search(head):
        if _GCODE.search(head):
            return "gcode"
        raise ToolpathError("neither CL data nor G-code", hint="name a CL file, or say its dialect")
    return next((name for name, mark in _MARKS if re.search(mark, head, re.I | re.M)), "apt")


def _assumed_units(text: str, tell: Teller) -> str:
    """Units of an APT file that states none: by its feeds, else mm."""
    upper = text.upper()
    if re.search(r"^[ \t]*UNITS?[ \t]*/", upper[:_HEAD], re.M) or not ("IPM" in upper or "IPR" in upper):
        return "mm"
    feeds = re.findall(r"^[ \t]*(?:FEDRAT|CYCLE)[ \t]*/.*\b(IPM|IPR|MMPM|MMPR)\b", upper, re.M)
    if feeds and all(word.startswith("IP") for word in feeds):
        tell.note("the file states no units: inches, since all its feeds are in inches")
        return "inch"
    return "mm"


def _program_reader(
    text: str,
    file: Path,
    tell: Teller,
    units: str | None,
    offsets: Offsets,
    *,
    by_tool: bool,
    machine: MachineTool | None,
    numbers: Mapping[str, int],
) -> GcodeReader:
    """What reads a program of G-code, or of a control whose programs look like it: loaded for these alone."""
    from camrob.witness.cl.foreign.foreign_words import ForeignReader
    from camrob.witness.cl.foreign.klartext import KlartextReader
    from camrob.witness.cl.foreign.osp import OSP, OspReader
    from camrob.witness.cl.foreign.sinumerik import SinumerikReader
    from camrob.witness.cl.gcode import GcodeReader
    from camrob.witness.cl.running.text_beside import text_beside

    bare = re.sub(r"\([^()\n]*\)|;[^\n]*", "", text)  # comments, and values of calls
    plain = SinumerikReader if file.suffix.lower() in (".mpf", ".spf") else GcodeReader
    others = ((KlartextReader, _KLARTEXT), (OspReader, OSP), (SinumerikReader, re.compile(_SINUMERIK, re.I | re.M)))
    language = next((reader for reader, mark in others if mark.search(bare)), plain)
    reader = language(tell, units, offsets, by_tool=by_tool, machine=machine)
    if language in (GcodeReader, SinumerikReader):
        reader.ngc = file.suffix.lower() == ".ngc"
        reader.beside = text_beside(text, file, siemens=language is SinumerikReader)
    if isinstance(reader, KlartextReader):
        reader.file = file
    if isinstance(reader, ForeignReader):
        reader.numbers = numbers
    return reader


def read_story(
    file: Path,
    *,
    dialect: str | None = None,
    units: str | None = None,
    default_feed: float | None = None,
    default_rpm: float | None = None,
    tools: Mapping[int, float] | None = None,
    wear: bool = False,
    numbers: Mapping[str, int] | None = None,
    machine: MachineTool | None = None,
) -> Story:
    """What the CL file asks for.

    dialect: "nx-clsf", "creo-ncl", "catia", "camworks-apt", "camworks-clt", "makino", "apt", "gcode", or None to recognise it.
    units: "mm" or "inch", over what the file says. default_feed (m/s), default_rpm: where the file states none.
    tools: diameters (m) by the tools' numbers, 0 for any, for surface speeds where the file names no cutter.
    wear: paths with cutter radius compensation are the tool centre's. numbers: of the set-up's tools by names in lower case.
    machine: whose own axes a G-code program names.
    Raises ToolpathError for a file that can't be read at all; what can't be read of it otherwise is in `Story.gaps`.
    """
    if units not in (None, "mm", "inch"):
        raise ToolpathError(f"units {units!r}", hint="mm or inch")
    for value in (default_feed, default_rpm):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise ToolpathError(f"a default of {value}", hint="a number above 0")
    text = read_text(file)
    tell = Teller(default_feed, default_rpm)
    try:
        kind = _named(dialect) if dialect else _recognised(text)
        reader: AptReader | GcodeReader
        if kind == "gcode":
            by_tool = bool(dialect) and str(dialect).endswith("-iso")
            offsets, known = Offsets(tell, wear), numbers or {}
            reader = _program_reader(text, file, tell, units, offsets, by_tool=by_tool, machine=machine, numbers=known)
        else:
            offsets = Offsets(tell, wear, contour=kind in CONTOURS)
            reader = AptReader(tell, kind, units or _assumed_units(text, tell), units is not None, offsets, tools or {})
        reader.read(text)
        story = tell.story(kind, reader.units)
        if story is None:
            why = "".join(f" (line {gap.first_line}: {gap.text})" for gap in tell.gaps[:1])
            raise ToolpathError(
                f"no motion that can be read{why}", hint="name a CL file with GOTO or G1 motions in numbers"
            )
    except ToolpathError as error:
        raise error.at(file) from None
    return story
