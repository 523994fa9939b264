"""A TOML file's contents, or the line that is wrong and what to do about it."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from camrob.errors import CellError, InputError
from camrob.text import bytes_of

__all__ = ["read_toml"]

_MOST_BYTES = 2**26  # 64 MB: a diagnosis with everything in it is a hundredth of it


def read_toml(path: Path, error: type[InputError] = CellError) -> dict[str, Any]:
    """The contents of a TOML file. Raises `error`, with the line, where it can't be read."""
    try:
        data = bytes_of(path, _MOST_BYTES)
        if len(data) > _MOST_BYTES:
            raise error("is too large for a TOML file", hint="check the path", path=path)
        return tomllib.loads(data.decode("utf-8-sig"))
    except IsADirectoryError:
        raise error("is a folder", hint="name the .toml file in it", path=path) from None
    except OSError as e:
        raise error(f"can't be read ({e.strerror})", hint="check the path", path=path) from None
    except UnicodeDecodeError:
        raise error("is not UTF-8 text", hint="save it as UTF-8", path=path) from None
    except tomllib.TOMLDecodeError as e:
        found = re.search(r" \(at line (\d+), column (\d+)\)$", str(e))
        what = str(e)[: found.start()] + f" at column {found[2]}" if found else str(e)
        what = what.replace("Cannot overwrite a value", "a key is given a second time")
        line = int(found[1]) if found else 0
        raise error(f"is not valid TOML: {what[:200]}", hint=_cure(path, line), path=path, line=line) from None
    except (RecursionError, ValueError) as e:
        raise error(f"is not valid TOML: {str(e)[:200]}", hint="correct that place", path=path) from None


def _cure(path: Path, line: int) -> str:
    """What to do about a line that is no TOML: slips of whoever comes from Windows, a country of decimal commas, or a text
    processor, or who gives a key again.
    """
    rows = path.read_bytes().decode("utf-8-sig").splitlines()
    row = rows[line - 1] if 0 < line <= len(rows) else ""
    if re.search(r'"[^"]*\\', row):
        return "write paths with /, or between single quotes"
    if re.search(r"=\s*-?\d+,\d+\s*(#.*)?$", row):
        return "write a decimal point for the comma"
    if re.search("[\u2018-\u201f]", row):
        return "write straight quotes, not a text processor's"
    key = row.partition("=")[0].strip()
    if key and sum(other.partition("=")[0].strip() == key for other in rows[:line]) > 1:
        return f"leave one of its lines that say {key[:40]}"
    return "correct that place"
