"""PTC Creo and Pro/ENGINEER: NCL files."""

from __future__ import annotations

from camrob.toolpath.apt.cycles import Cycle, cycle_fields, keyed_cycle
from camrob.toolpath.apt.dialects.dialect import Dialect, message, score
from camrob.toolpath.apt.lexer import Statement

__all__ = ["CREO"]


def _recognise(head: str) -> int:
    weights = {
        r"^\$\$\*\s+Pro/CLfile": 20,
        r"^REMARK\s*\*?\s*PRO/CLFILE": 20,
        r"^\$\$->": 8,
        r"^MACHIN / UNCX": 4,
        r"^GOTO / ": 1,
    }
    return score(head, weights)


def _cycle(statement: Statement) -> Cycle:
    """DEPTH is positive into the part, from the GOTO's point; CLEAR and RETURN lie above it."""
    name, fields, loose = cycle_fields(statement.args)
    return keyed_cycle(name, fields, fields.get("DEPTH"), statement.line, loose)


CREO = Dialect("creo-ncl", _recognise, _cycle, message, must_end=True)
