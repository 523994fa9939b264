"""Heidenhain's CALL PGM: the program of that name that lies as a file beside, put in the place of its call.

Its Q parameters are those of the program that calls it; one with labels or QL, which are its own, is left as it is called.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from camrob.errors import ToolpathError
from camrob.witness.cl.running.ordered import Row
from camrob.witness.cl.source import read_text

__all__ = ["with_programs"]

_CALL = re.compile(r"CALL PGM ?(\"[^\"]*\"|\S+)")
_OWN = re.compile(r"(CALL )?LBL\b|.*\bQL\d|.*\bM0*(2|30)\b|FN ?(9|10|11|12)\b")
_ENDINGS = ("", ".h", ".nc", ".txt")
_MOST_ROWS = 200_000  # more than any program of a part has
_NESTED = 8  # programs in one another


def with_programs(rows: list[Row], file: Path | None, statements: Callable[[str], list[Row]]) -> list[Row]:
    """The rows with what they call, each at its call's line; `statements` reads a program's text."""
    if file is None or not any(_CALL.fullmatch(row) for _, row in rows):
        return rows
    unit = next((row.split()[-1] for _, row in rows if row.startswith("BEGIN PGM")), "")
    for _ in range(_NESTED):
        out: list[Row] = []
        for line, row in rows:
            call = _CALL.fullmatch(row)
            body = _body(call[1], file, unit, statements) if call else []
            out += [(line, text) for text in body] or [(line, row)]
            if len(out) > _MOST_ROWS:
                return rows
        if out == rows:
            break
        rows = out
    return rows


def _body(called: str, file: Path, unit: str, statements: Callable[[str], list[Row]]) -> list[str]:
    """The statements of one file between BEGIN PGM and END PGM; none where it isn't sure."""
    name = re.sub(r"\.[^.]*$", "", re.sub(r".*[\\/:]", "", called.strip('"'))).lower()
    try:
        there = [
            p for p in file.parent.iterdir() if p.name != file.name and p.name.lower() in [name + e for e in _ENDINGS]
        ]
        found = [row for _, row in statements(read_text(there[0]))] if len(there) == 1 else []
    except (OSError, ToolpathError):
        return []
    if len(found) < 3 or not found[0].startswith("BEGIN PGM") or found[0].split()[-1] != unit:
        return []
    inner = found[1:-1]
    return [] if not found[-1].startswith("END PGM") or any(_OWN.match(row) for row in inner) else inner
