"""JOB.toml: what a loop shall make, on which machine, and how well; docs/reference/files.md is its contract."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from camrob.errors import InputError
from camrob.jobs.solving.resolved_job import METHODS
from camrob.shipped import cell_beside, demand_cell
from camrob.toml.read_toml import read_toml
from camrob.toml.table_reader import TableReader

__all__ = ["LoopJob", "Rehearsal", "read_loop_job"]

_TURNS = 4  # at the most: what a loop can take is taken by then
_MOST_TURNS = 50  # beyond is a slip of the pen
_NOISE_MM = 0.02  # of a laser tracker at some metres


@dataclass(frozen=True, slots=True)
class Rehearsal:
    """A machine that is simulated: as a calibration and a diagnosis have it, seen with noise of noise_mm in each direction."""

    calibration: Path | None
    diagnosis: Path | None
    noise_mm: float
    seed: int


@dataclass(frozen=True, slots=True)
class LoopJob:
    """What JOB.toml asks for; paths stand as seen from its folder. rehearsal: None where a real machine runs the programs."""

    path: Path
    toolpath: Path
    cell: Path
    setup: Path | None
    method: str
    tolerance_mm: float
    turns: int
    for_accuracy: bool
    force: Path | None
    experiments: bool
    rehearsal: Rehearsal | None

    @property
    def set_up(self) -> Path:
        """The set-up's file, which need not be there where JOB.toml names none."""
        return self.setup or self.toolpath.parent / "setup.toml"

    def made_from(self) -> dict[str, str]:
        """SHA-256 of each file that the first program is made from, by its part in the job. Raises InputError."""
        cell = self.cell if self.cell.is_file() else self.cell / "cell.toml"
        named = {"toolpath": self.toolpath, "cell": cell, "setup": self.set_up}
        found = {"method": self.method}
        for part, file in named.items():
            try:
                found[part] = hashlib.sha256(file.read_bytes()).hexdigest()
            except OSError as error:
                if part == "setup" and self.setup is None:
                    continue
                raise InputError(
                    f"can't be read ({error.strerror})", hint=f"correct {part} in {self.path.name}", path=file
                ) from None
        return found


def read_loop_job(path: Path) -> LoopJob:
    """Read and check a JOB.toml. Raises InputError naming file, key and hint."""
    path = Path(path)
    table = TableReader(read_toml(path, InputError), path, error=InputError)

    def file(of: TableReader, key: str) -> Path | None:
        return path.parent / of.text(key) if key in of else None

    toolpath = path.parent / table.text("toolpath")
    job = LoopJob(
        path=path,
        toolpath=toolpath,
        cell=_cell(table),
        setup=file(table, "setup"),
        method=table.text("method", choices=tuple(METHODS)) if "method" in table else "vjm",
        tolerance_mm=table.number("tolerance_mm", lower=1e-4, upper=100.0),
        turns=table.integer("turns", lower=1, upper=_MOST_TURNS) if "turns" in table else _TURNS,
        for_accuracy=table.flag("for_accuracy") if "for_accuracy" in table else False,
        force=file(table, "force"),
        experiments=table.flag("experiments") if "experiments" in table else True,
        rehearsal=_rehearsal(table.table("machine"), file) if "machine" in table else None,
    )
    table.finish()
    return job


def _cell(table: TableReader) -> Path:
    named = table.text("cell")
    found = cell_beside(table.path.parent, named)
    try:
        demand_cell(found, named)
    except InputError as error:
        raise table.fail("cell", error.what, error.hint) from None
    return found


def _rehearsal(table: TableReader, file: Callable[[TableReader, str], Path | None]) -> Rehearsal:
    made = Rehearsal(
        calibration=file(table, "calibration"),
        diagnosis=file(table, "diagnosis"),
        noise_mm=table.number("noise_mm", lower=0.0, upper=10.0) if "noise_mm" in table else _NOISE_MM,
        seed=table.integer("seed", lower=0, upper=2**31) if "seed" in table else 0,
    )
    table.finish()
    return made
