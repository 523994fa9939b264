"""Rows of a bench in a file of JSON lines: what is there is not done again."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

__all__ = ["add_rows", "read_rows"]


def read_rows(file: Path) -> list[dict[str, Any]]:
    """The rows so far."""
    return [json.loads(line) for line in file.read_text().splitlines()] if file.is_file() else []


def add_rows(
    file: Path, families: Iterable[str], draws: int, one: Callable[[str, int, Path], dict[str, Any]], first: int = 1
) -> None:
    """Do `one(family, draw, folder)` for each draw from the first on that the file has no row of, and add its row."""
    done = {(r["family"], r["draw"]) for r in read_rows(file)}
    for draw in range(first, first + draws):
        for family in families:
            if (family, draw) in done:
                continue
            row = one(family, draw, file.parent / f"{family.replace(' ', '_')}{draw}")
            with file.open("a") as log:
                log.write(json.dumps(row) + "\n")
            sys.stdout.write(json.dumps(row) + "\n")
            sys.stdout.flush()
