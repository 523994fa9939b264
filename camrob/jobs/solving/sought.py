"""What a plan for accuracy, or a feed held to a tolerance, is asked to go by."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from camrob.cell.cell import Cell
from camrob.errors import InputError

__all__ = ["Sought", "check_sought"]


@dataclass(frozen=True, slots=True)
class Sought:
    """What is known of the machine: files, each None where there is none. cell: the cell's folder; corrected: the program is
    compensated afterwards with them.
    """

    cell: Path
    calibration: Path | None = None
    diagnosis: Path | None = None
    force: Path | None = None
    corrected: bool = False

    def files(self) -> tuple[Path, ...]:
        """The files behind it, by which it can be told from another."""
        diagnosis = None if self.diagnosis is None else Path(self.diagnosis) / "diagnosis.json"
        return tuple(Path(f) for f in (self.calibration, diagnosis, self.force) if f is not None)


def check_sought(sought: Sought, cell: Cell, *, asked: bool, planned: bool, tolerance: bool) -> Sought | None:
    """What the plan is to go by; None where no plan looks at the part's error. tolerance: the feed is held to one, and goes by
    the diagnosis, too. Raises InputError for options that don't fit.
    """
    given = [n for n in ("calibration", "diagnosis", "force") if getattr(sought, n) is not None]
    if asked and not planned:
        raise InputError("--for-accuracy needs postures that are planned", hint="add --method planned")
    looks = planned and (asked or _for_accuracy(cell))
    if tolerance and sought.diagnosis is not None:
        given = [n for n in given if n == "force"]
    if sought.corrected and not looks:
        raise InputError("--then-compensated is for plans for accuracy", hint="add --for-accuracy")
    if given and not looks:
        hint = "add --for-accuracy" if given[0] == "force" else "add --for-accuracy, or tolerance_mm to setup.toml"
        raise InputError(f"--{given[0]} is for plans that look at the part's error", hint=hint)
    return sought if looks else None


def _for_accuracy(cell: Cell) -> bool:
    """Whether the cell itself has plans look at the part's error."""
    from camrob.redundancy.planning.objective import plan_weights

    return plan_weights(cell).accuracy > 0.0
