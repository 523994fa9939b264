"""A TOML table read with a watchful eye: every key used, every number with its provenance, every error with its key."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from camrob.errors import CellError, InputError
from camrob.toml.key_line import Place, key_line

__all__ = ["PROVENANCES", "Faults", "TableReader"]

T = TypeVar("T")

_ALIKE = 0.8  # share of letters that a mistyped key has in common with the right one: two swapped or lost of ten
_MOST_FAULTS = 7  # things that are wrong, beside the first

PROVENANCES = ("datasheet", "paper", "measured", "assumed")


def _range(lower: float, upper: float) -> str:
    """What to give for a number that is not within bounds, one of which may be none."""
    return f"give a number from {lower:g} " + ("up" if upper == math.inf else f"to {upper:g}")


def _finite(value: Any) -> bool:
    """True for a number that float64 can hold."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # TOML's integers have no end
        return False


def _short(text: str) -> str:
    """Text cut to a length that a message bears."""
    return text if len(text) <= 60 else text[:57] + "..."


def _alike(key: str, among: Sequence[str]) -> str:
    """The key that one may be a slip of the pen for, "" where there is none."""
    from difflib import get_close_matches  # only a wrong key needs it

    near = get_close_matches(key, among, n=1, cutoff=_ALIKE)
    return near[0] if near else ""


def _shown(value: Any) -> str:
    """A wrong value as a message shows it."""
    try:
        return _short(repr(value))
    except ValueError:  # an integer too long to print
        return "a number with thousands of digits"


class TableReader:
    """Reads one table of a TOML file; `key` is its dotted place, `error` what is raised when something is wrong.

    Keys that nobody asked for are found by `finish`, which names those that somebody asked for, there or not. A number's
    provenance is that of the longest name in the file's `standing` that the key begins with; it is collected in `provenance`,
    which tables below share. `stated`: what the table above says of this one. With `needs_provenance`, every number below the
    file's top needs one. `spot`: where the table stands in the file, so that an error names its line; or `line`, where the data
    come from one line of a file that is no TOML.
    """

    def __init__(
        self,
        data: Mapping[str, Any],
        path: Path,
        key: str = "",
        *,
        error: type[InputError] = CellError,
        provenance: dict[str, str] | None = None,
        stated: str | Mapping[str, str] | None = None,
        needs_provenance: bool = False,
        spot: Place = (),
        line: int = 0,
    ) -> None:
        self.path = path
        self.spot = spot
        self.key = key
        self.error = error
        self.provenance = {} if provenance is None else provenance
        self._data = data
        self._used: set[str] = set()
        self._asked: set[str] = set()
        self._stated: str | Mapping[str, str] | None = stated
        self._needs_provenance = needs_provenance
        self._line = line
        if "standing" in data:
            self._stated = self._checked(data["standing"])
            self._used.add("standing")

    def _checked(self, value: Any) -> str | Mapping[str, str]:
        values = value.values() if isinstance(value, Mapping) else [value]
        for v in values:
            if isinstance(v, Mapping):
                raise self.fail(
                    "standing",
                    "names numbers within a table",
                    "give that table its own: key = { ..., standing = { ... } }",
                )
            if v not in PROVENANCES:
                raise self.fail("standing", f"{_shown(v)} is not a provenance", f"use one of {', '.join(PROVENANCES)}")
        result: str | Mapping[str, str] = value
        return result

    def place(self, key: str) -> str:
        """The dotted name of a key, of the table itself for ""."""
        return f"{self.key}.{key}" if self.key and key else self.key or key

    def fail(self, key: str, what: str, hint: str, *, stands: Place | None = None) -> InputError:
        """The error to raise for a key, with its line, or that of its table where the key is not there; stands: where in the
        table, where that is not the key itself.
        """
        keys: Place = (key,) if key in self._data else tuple(key.split("."))
        return self._error(key, what, hint, keys if stands is None else stands)

    def _error(self, key: str, what: str, hint: str, stands: Place) -> InputError:
        """The error to raise for a key; stands: where in this table."""
        line = self._line or key_line(self.path, (*self.spot, *stands))
        return self.error(f"{self.place(key)}: {what}", hint=hint, path=self.path, line=line)

    def __contains__(self, key: str) -> bool:
        self._asked.add(key)
        return key in self._data

    def _take(self, key: str, kind: str) -> Any:
        if key not in self._data:
            near = _alike(key, sorted(set(self._data) - self._used))
            meant = f"; is {_short(near)} meant for it?" if near else ""
            raise self._error(key, "is missing", f"give {kind}{meant}", (near or key,))
        self._used.add(key)
        return self._data[key]

    def _note_provenance(self, key: str) -> None:
        stated = self._stated
        if stated is None:
            if self._needs_provenance and self.key:
                raise self.fail(
                    key, "has no provenance", f'write standing = "..." beside it: {" or ".join(PROVENANCES)}'
                )
            return
        if isinstance(stated, Mapping):
            fits = [name for name in stated if key == name or key.startswith((name + "_", name + "."))]
            if not fits:
                raise self.fail(key, "has no provenance", f"name it in `standing`: one of {', '.join(PROVENANCES)}")
            stated = stated[max(fits, key=len)]
        self.provenance[self.place(key)] = str(stated)

    def number(self, key: str, *, lower: float = -math.inf, upper: float = math.inf) -> float:
        """A finite number within [lower, upper]."""
        value = self._take(key, "a number")
        if not _finite(value):
            raise self.fail(key, f"is {_shown(value)}", "give a finite number")
        if not lower <= value <= upper:
            raise self.fail(key, f"is {value:g}", _range(lower, upper))
        self._note_provenance(key)
        return float(value)

    def integer(self, key: str, *, lower: int, upper: int) -> int:
        """A whole number within [lower, upper]."""
        value = self.number(key, lower=lower, upper=upper)
        if value != int(value):
            raise self.fail(key, f"is {value:g}", "give a whole number")
        return int(value)

    def flag(self, key: str) -> bool:
        """True or false."""
        value = self._take(key, "true or false")
        if not isinstance(value, bool):
            raise self.fail(key, f"is {_shown(value)}", "give true or false")
        return value

    def text(self, key: str, *, choices: tuple[str, ...] = ()) -> str:
        """A text of one line, one of `choices` where there are some."""
        value = self._take(key, "a text")
        if not isinstance(value, str) or not all(c.isprintable() for c in value):
            raise self.fail(key, f"is {_shown(value)}", "give a text of one line")
        if choices and value not in choices:
            raise self.fail(key, f"is {_shown(value)}", f"use one of {', '.join(choices)}")
        return value

    def vector(self, key: str, length: int) -> NDArray[np.float64]:
        """A list of `length` finite numbers."""
        value = self._take(key, f"a list of {length} numbers")
        good = isinstance(value, list) and len(value) == length
        if not good or not all(_finite(v) for v in value):
            nested = isinstance(value, list) and any(isinstance(v, list) for v in value)
            hint = f"give a list of {length} finite numbers{', one behind the other' * nested}"
            raise self.fail(key, f"is {_shown(value)}", hint)
        self._note_provenance(key)
        return np.array(value, float)

    def vectors(self, key: str, length: int) -> NDArray[np.float64]:
        """A list of lists of `length` finite numbers each (N, length)."""
        value = self._take(key, f"a list of rows of {length} numbers")
        rows = value if isinstance(value, list) else []
        if not rows or any(not isinstance(r, list) or len(r) != length or not all(_finite(v) for v in r) for r in rows):
            raise self.fail(key, f"is {_shown(value)}", f"give a list of rows of {length} finite numbers")
        self._note_provenance(key)
        return np.array(rows, float)

    def texts(self, key: str) -> tuple[str, ...]:
        """A list of texts of one line each."""
        value = self._take(key, "a list of texts")
        if not isinstance(value, list) or any(
            not isinstance(v, str) or not all(c.isprintable() for c in v) for v in value
        ):
            raise self.fail(key, f"is {_shown(value)}", "give a list of texts of one line each")
        return tuple(value)

    def text_map(self, key: str) -> dict[str, str]:
        """A table of texts."""
        value = self._take(key, "a table of texts")
        if not isinstance(value, Mapping) or any(not isinstance(v, str) for v in value.values()):
            raise self.fail(key, f"is {_shown(value)}", "give a table of texts")
        return dict(value)

    def keys(self) -> tuple[str, ...]:
        """The table's own keys."""
        return tuple(k for k in self._data if k != "standing")

    def table(self, key: str, *, needs_provenance: bool | None = None) -> TableReader:
        """The table below `key`; `needs_provenance` as on construction, where it differs from this table's."""
        value = self._take(key, "a table")
        if not isinstance(value, Mapping):
            raise self.fail(key, f"is {_shown(value)}", "give a table")
        stated = self._stated
        if isinstance(stated, Mapping):
            stated = stated.get(key)
        return TableReader(
            value,
            self.path,
            self.place(key),
            error=self.error,
            provenance=self.provenance,
            stated=stated,
            needs_provenance=self._needs_provenance if needs_provenance is None else needs_provenance,
            spot=(*self.spot, key),
            line=self._line,
        )

    def tables(self, key: str) -> list[TableReader]:
        """The tables of an array of tables ([[key]]), [] where there are none."""
        if key not in self._data:
            return []
        value = self._take(key, "an array of tables")
        if not isinstance(value, list) or any(not isinstance(v, Mapping) for v in value):
            raise self.fail(key, "is not an array of tables", f"write [[{self.place(key)}]]")
        readers = []
        for i, v in enumerate(value):
            name = v.get("name")
            label = f"{self.place(key)}[{_short(name)}]" if isinstance(name, str) else f"{self.place(key)} {i + 1}"
            readers.append(
                TableReader(
                    v,
                    self.path,
                    label,
                    error=self.error,
                    provenance=self.provenance,
                    stated=self._stated if isinstance(self._stated, str) else None,
                    needs_provenance=self._needs_provenance,
                    spot=(*self.spot, key, i),
                    line=self._line,
                )
            )
        return readers

    def rest(self) -> dict[str, Any]:
        """What nobody has asked for yet, as it stands in the file: for whoever knows these keys."""
        left = {key: value for key, value in self._data.items() if key not in self._used}
        self._used.update(left)
        for key, value in left.items():
            if _finite(value) or (isinstance(value, list) and value and all(_finite(v) for v in value)):
                self._note_provenance(key)
        return left

    def finish(self) -> None:
        """Raise when the table holds keys that nobody asked for."""
        unknown = sorted(set(self._data) - self._used)
        if unknown:
            known = sorted(self._used | self._asked)
            near = _alike(unknown[0], known)
            hint = f"is it {_short(near)}?" if near else f"use {', '.join(known)}"
            raise self._error(_short(unknown[0]), "is not a key that camrob knows here", hint, (unknown[0],))


class Faults:
    """What is wrong in a file's tables, gathered so that it is reported at once."""

    def __init__(self) -> None:
        self.found: list[InputError] = []

    def of(self, read: Callable[[], T], otherwise: T) -> T:
        """What `read` gives, or `otherwise`, with its error kept."""
        try:
            return read()
        except CellError as error:
            self.found.append(error)
            return otherwise

    def each(self, tables: Sequence[TableReader], read: Callable[[TableReader], T]) -> list[T]:
        """What `read` gives of each table, those left out that are wrong."""
        none: list[T] = []
        return [one for t in tables for one in self.of(lambda t=t: [read(t)], none)]  # type: ignore[misc]

    def raise_any(self) -> None:
        """Raise CellError for all that is wrong, in one line, with the place of the first."""
        if not self.found:
            return
        first, *more = self.found
        if not more:
            raise first
        others = "; ".join(f"{e.what} ({e.hint})" for e in more[:_MOST_FAULTS])
        what = f"{first.what} ({first.hint}); {others}" + (
            f"; and {len(more) - _MOST_FAULTS} more" if len(more) > _MOST_FAULTS else ""
        )
        raise CellError(
            f"{len(self.found)} things are wrong: {what}", hint="correct them all", path=first.path, line=first.line
        )
