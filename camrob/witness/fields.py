"""Takes the fields of a TOML file one by one, and says which one is wrong."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError

__all__ = ["Fields", "read_toml"]


class Fields:
    """One table of a TOML file; every wrong field raises `error`, naming file and key."""

    def __init__(self, table: Mapping[str, Any], path: Path, error: type[InputError], name: str = "") -> None:
        self.table, self.path, self.error, self.name = table, path, error, name

    def wrong(self, key: str, what: str, hint: str = "") -> InputError:
        """The error to raise for `key`."""
        return self.error(f"{self.name}{key} {what}", hint=hint, path=self.path)

    def __contains__(self, key: str) -> bool:
        return key in self.table

    def none_but(self, *keys: str) -> None:
        """Refuses a key that is not among these: a slip of the pen would be read as if nothing stood there."""
        for key in self.table:
            if key not in keys:
                raise self.wrong(key, "is not a key of this table", f"write one of {', '.join(keys)}")

    def sub(self, key: str) -> Fields:
        """The table `key`; an empty one where it is absent."""
        value = self.table.get(key, {})
        if not isinstance(value, dict):
            raise self.wrong(key, "is not a table")
        return Fields(value, self.path, self.error, f"{self.name}{key}.")

    def subs(self, key: str) -> list[Fields]:
        """The array of tables `key`; a single table counts as an array of one, an absent one as none."""
        value = self.table.get(key, [])
        items = [value] if isinstance(value, dict) else value
        if not isinstance(items, list) or not all(isinstance(item, dict) for item in items):
            raise self.wrong(key, "is not a table, and no array of tables")
        return [Fields(item, self.path, self.error, f"{self.name}{key}[{i}].") for i, item in enumerate(items)]

    def number(self, key: str, default: float | None = None) -> float:
        """The finite number `key`."""
        value = self.table.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise self.wrong(key, "is missing" if value is None else "is not a finite number")
        return float(value)

    def maybe(self, key: str) -> float | None:
        """The finite number `key`, None where it is absent."""
        return self.number(key) if key in self.table else None

    def numbers(self, key: str, count: int, default: list[float] | None = None) -> NDArray[np.float64]:
        """`count` finite numbers."""
        value = self.table.get(key, default)
        if not isinstance(value, list) or len(value) != count:
            raise self.wrong(key, "is missing" if value is None else f"is not a list of {count} numbers")
        whole = Fields({f"{key}[{i}]": item for i, item in enumerate(value)}, self.path, self.error, self.name)
        return np.array([whole.number(name) for name in whole.table])

    def text(self, key: str, default: str | None = None) -> str:
        """The string `key`."""
        value = self.table.get(key, default)
        if not isinstance(value, str):
            raise self.wrong(key, "is missing" if value is None else "is not a string")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        """The strings `key`."""
        value = self.table.get(key)
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise self.wrong(key, "is not a list of strings")
        return tuple(value)

    def flag(self, key: str, default: bool | None = None) -> bool:
        """True or false."""
        value = self.table.get(key, default)
        if not isinstance(value, bool):
            raise self.wrong(key, "is missing" if value is None else "is neither true nor false")
        return value


def read_toml(path: Path, error: type[InputError]) -> Fields:
    """The file's top table; raises `error` where it can't be read."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as failure:
        raise error(f"can't be read ({failure})", path=path) from failure
    except tomllib.TOMLDecodeError as failure:
        raise error(f"is not TOML ({failure})", path=path) from failure
    return Fields(table, path, error)
