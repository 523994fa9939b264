"""Dassault CATIA V5: aptsource."""

from __future__ import annotations

from camrob.toolpath.apt.cycles import FEED_WORDS, Cycle, behind_or_next, cycle_fields, keyed_cycle
from camrob.toolpath.apt.dialects.dialect import Dialect, score
from camrob.toolpath.apt.lexer import Statement

__all__ = ["CATIA"]


def _recognise(head: str) -> int:
    weights = {
        r"^\$\$.*CATIA APT VERSION": 20,
        r"^\$\$\*CATIA": 15,
        r"^TLON,GOFWD/": 6,
        r"^PPRINT OPERATION NAME": 4,
        r"^\$\$ OPERATION NAME": 4,
    }
    return score(head, weights)


def _cycle(statement: Statement) -> Cycle:
    """Positional: depth, then clearance; a feed stands before its unit, or behind it where a word owns the number before."""
    args: list[float | str] = []
    for arg in statement.args:
        loose = len(args) > 2 and isinstance(args[-1], float) and isinstance(args[-2], float)
        if isinstance(arg, str) and arg in FEED_WORDS and loose:
            args[-1:] = [arg, args[-1]]  # 300.,MMPM as MMPM,300.
        else:
            args.append(arg)
    name, fields, others = cycle_fields(args)
    name = "DEEP" if name == "DEEPHL" else name
    depth = behind_or_next(fields, others, "DEPTH")
    clear = behind_or_next(fields, others, "CLEAR")
    if clear is not None:
        fields["CLEAR"] = clear
    return keyed_cycle(name, fields, depth, statement.line, others)


def _pprint(text: str) -> tuple[str, str] | None:
    head, colon, name = text.partition(":")
    if colon and head.strip().upper() == "OPERATION NAME":
        return ("operation", name.strip())
    return ("message", text)


CATIA = Dialect("catia-apt", _recognise, _cycle, _pprint, must_end=True)
