"""What a plan for accuracy is asked to go by."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from camrob.cell.cell import Cell
from camrob.errors import InputError
from camrob.redundancy.planning.objective import plan_weights

__all__ = ["Sought", "check_sought"]


@dataclass(frozen=True, slots=True)
class Sought:
    """What a plan for accuracy goes by: files, each None where there is none. cell: the cell's folder."""

    cell: Path
    calibration: Path | None = None
    diagnosis: Path | None = None
    force: Path | None = None


def check_sought(sought: Sought, cell: Cell, *, asked: bool, planned: bool) -> Sought | None:
    """What the plan is to go by; None where nobody looks at the part's error. Raises InputError for options that don't fit."""
    given = [n for n in ("calibration", "diagnosis", "force") if getattr(sought, n) is not None]
    if asked and not planned:
        raise InputError("--for-accuracy needs postures that are planned", hint="add --method planned")
    looks = planned and (asked or plan_weights(cell).accuracy > 0.0)
    if given and not looks:
        raise InputError(f"--{given[0]} is for plans that look at the part's error", hint="add --for-accuracy")
    return sought if looks else None
