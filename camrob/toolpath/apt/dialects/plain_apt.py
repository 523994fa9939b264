"""Plain ISO or APT cutter data that no CAM system's habits give away."""

from __future__ import annotations

from camrob.toolpath.apt.cycles import Cycle, cycle_fields, keyed_cycle
from camrob.toolpath.apt.dialects.dialect import Dialect, message, score
from camrob.toolpath.apt.lexer import Statement

__all__ = ["APT", "apt_cycle"]


def _recognise(head: str) -> int:
    return score(head, {r"^[ \t]*GOTO[ \t]*/": 1})


def apt_cycle(statement: Statement) -> Cycle:
    """Values behind words where there are any; otherwise depth, then clearance. The depth's sign means nothing here."""
    name, fields, loose = cycle_fields(statement.args)
    depth = fields.get("FEDTO", fields.get("DEPTH"))
    if depth is None and loose:
        depth = loose.pop(0)
    if loose and not fields.keys() & {"RAPTO", "CLEAR"}:
        fields["CLEAR"] = loose.pop(0)
    return keyed_cycle(name, fields, None if depth is None else abs(depth), statement.line, loose)


APT = Dialect("apt", _recognise, apt_cycle, message, left_handed_arcs=None)
