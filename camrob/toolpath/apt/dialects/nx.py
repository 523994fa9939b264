"""Siemens NX: CLSF."""

from __future__ import annotations

from camrob.toolpath.apt.cycles import Cycle, cycle_fields, keyed_cycle
from camrob.toolpath.apt.dialects.dialect import Dialect, message, score
from camrob.toolpath.apt.lexer import Statement

__all__ = ["NX"]


def _recognise(head: str) -> int:
    return score(head, {r"^TOOL PATH\s*/": 10, r"^TLDATA/": 5, r"^PAINT/": 5, r"^MSYS/": 5, r"^END-OF-PATH": 5})


def _cycle(statement: Statement) -> Cycle:
    """FEDTO is the depth relative to the GOTO's point, negative into the part; RAPTO and RTRCTO lie above it."""
    name, fields, loose = cycle_fields(statement.args)
    if name == "DRILL":
        name = next((word for word in ("DEEP", "BRKCHP") if word in statement.words), name)
    if name == "BORE" and "DRAG" in statement.words:  # the spindle stands while the tool is drawn out in rapid (G86)
        name = "DRAG"
    depth = -fields["FEDTO"] + 0.0 if "FEDTO" in fields else loose.pop(0) if loose else None
    return keyed_cycle(name, fields, depth, statement.line, loose)


NX = Dialect("nx-clsf", _recognise, _cycle, message, left_handed_arcs=True, on="values", msys=True)
