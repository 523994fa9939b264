"""Whether a program is one that `camrob compensate` wrote, as the NAME.json beside it says."""

from __future__ import annotations

import json
from pathlib import Path

__all__ = ["said_to_be_compensated"]

_ONLY_THERE = ("error_before", "error_after", "calibration")  # keys of what `compensate` says, and no other job


def said_to_be_compensated(program: Path) -> str:
    """The name of the file that says so, "" where none does."""
    beside = program.with_name(f"{program.name.split('.')[0]}.json")
    try:
        said = json.loads(beside.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return ""
    if not isinstance(said, dict) or any(key not in said for key in _ONLY_THERE):
        return ""
    files = said.get("files")
    return beside.name if isinstance(files, list) and program.name in files else ""
