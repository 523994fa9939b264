"""The line of a TOML file on which a key stands: the parser keeps none, so a file that is wrong is looked through again."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

__all__ = ["Place", "key_line"]

Place = tuple[str | int, ...]  # keys from the top of the file; behind that of an array, which of its tables, from 0

_MOST_BYTES = 1_000_000  # of a file that is looked through
_MOST_ENDS = 200  # of lines at which a value of many lines may end
_ENDS = ("]", "}", '"""', "'''")


def key_line(path: Path, place: Sequence[str | int]) -> int:
    """The line on which the deepest part of a place is stated; 0 where no part is, or the file can't be looked through."""
    best, line = 0, 0
    try:
        if path.stat().st_size > _MOST_BYTES:
            return 0
        text = path.read_bytes().decode("utf-8-sig")
    except (OSError, UnicodeDecodeError):
        return 0
    for at, stated in _statements(text.replace("\r\n", "\n").split("\n")):
        alike = next(
            (k for k, (a, b) in enumerate(zip(stated, place, strict=False)) if a != b), min(len(stated), len(place))
        )
        if alike > best:
            best, line = alike, at
    return line


def _statements(rows: Sequence[str]) -> Iterator[tuple[int, Place]]:
    """Line and place of each header and each key, as far as the text is TOML."""
    tables: dict[Place, int] = {}  # how many an array has so far
    table: Place = ()
    at = 0
    while at < len(rows):
        row = rows[at].strip()
        if not row or row.startswith("#"):
            at += 1
            continue
        end, said = _whole(rows, at)
        if said is None:
            return
        keys = _keys(said)
        if row.startswith("["):
            place = _resolved(keys[:-1], tables)
            place = (*place, keys[-1]) if row.startswith("[[") else _resolved(keys, tables)
            if row.startswith("[["):
                tables[place] = tables.get(place, 0) + 1
                place = (*place, tables[place] - 1)
            table = place
            yield at + 1, table
        else:
            yield at + 1, (*table, *keys)
        at = end


def _whole(rows: Sequence[str], at: int) -> tuple[int, dict[str, Any] | None]:
    """The first line behind a statement, and what it says; None where it has no end."""
    tried = 0
    for end in range(at, len(rows)):
        if end > at and "#" not in rows[end] and not rows[end].rstrip().endswith(_ENDS):
            continue
        try:
            return end + 1, tomllib.loads("\n".join(rows[at : end + 1]))
        except (ValueError, RecursionError):
            tried += 1
        if tried > _MOST_ENDS:
            break
    return len(rows), None


def _keys(said: Any) -> tuple[str, ...]:
    """The keys of a statement, those of inline tables that hold one key among them."""
    found: list[str] = []
    while isinstance(said, dict) and len(said) == 1:
        ((key, said),) = said.items()
        found.append(key)
    return tuple(found)


def _resolved(keys: Sequence[str], tables: dict[Place, int]) -> Place:
    """The place of a header's keys: of an array its last table."""
    place: Place = ()
    for key in keys:
        place = (*place, key)
        if place in tables:
            place = (*place, tables[place] - 1)
    return place
