"""A verb's summary as a file: how it is written, and how a job reads one that lies there."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from camrob.errors import InputError
from camrob.summaries.base import Summary

__all__ = ["read_summary", "said_in", "write_summary"]


def write_summary(file: Path, summary: Summary, *, indent: int = 2) -> None:
    """Write a summary's JSON object. Raises ValueError for a number that JSON has no word for."""
    file.write_text(json.dumps(summary.to_json(), indent=indent, allow_nan=False) + "\n", encoding="utf-8")


def read_summary(file: Path, *, hint: str) -> dict[str, Any]:
    """The JSON object in a file. Raises InputError, with `hint`, where the file can't be read or holds none."""
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"can't be read ({error.strerror})", hint=hint, path=file) from error
    except (ValueError, RecursionError) as error:
        raise InputError("is damaged: it is no whole JSON file", hint=hint, path=file) from error
    if not isinstance(found, dict):
        raise InputError("is not a summary", hint=hint, path=file)
    return found


def said_in(file: Path) -> Mapping[str, Any]:
    """What the summary in a file says; nothing where there is no such file, or it is none of ours."""
    try:
        return read_summary(file, hint="")
    except InputError:
        return {}
