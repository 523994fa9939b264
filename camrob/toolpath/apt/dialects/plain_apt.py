"""Plain ISO or APT cutter data that no CAM system's habits give away."""

from __future__ import annotations

from camrob.toolpath.apt.cycles import Cycle, behind_or_next, cycle_fields, keyed_cycle
from camrob.toolpath.apt.dialects.dialect import Dialect, message, score
from camrob.toolpath.apt.lexer import Statement

__all__ = ["APT", "apt_cycle"]


def _recognise(head: str) -> int:
    return score(head, {r"^[ \t]*GOTO[ \t]*/": 1})


def apt_cycle(statement: Statement) -> Cycle:
    """Values behind words where there are any; otherwise depth, then clearance. The depth's sign means nothing here."""
    name, fields, loose = cycle_fields(statement.args)
    depth = behind_or_next(fields, loose, "FEDTO", "DEPTH")
    clear = behind_or_next(fields, loose, "RAPTO", "CLEAR")
    if clear is not None:
        fields["CLEAR"] = clear
    return keyed_cycle(name, fields, None if depth is None else abs(depth), statement.line, loose)


APT = Dialect("apt", _recognise, apt_cycle, message, left_handed_arcs=None)
