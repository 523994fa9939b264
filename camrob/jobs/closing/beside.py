"""What the NAME.json beside a program says of it, for the loop: whether it is compensated, and how fast it cuts."""

from __future__ import annotations

import json
from pathlib import Path

from camrob.jobs.release.opinion import fastest_cut
from camrob.prediction.force_model import CuttingForce

__all__ = ["fastest_that_cuts", "said_to_be_compensated"]

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


def fastest_that_cuts(program: Path, force: CuttingForce | None) -> float:
    """m/s beyond which a program's lines and arcs are moves in air: as FORCE.toml says, else as `post` wrote beside the program;
    infinite where neither does.
    """
    return force.fastest if force is not None and force.fastest < float("inf") else fastest_cut(program)
