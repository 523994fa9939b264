"""A calibration: the error parameters of a cell and how well they are known, and the chain that they make of it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.error_model import ErrorModel
from camrob.calibration.parameters import ParameterSet
from camrob.cell.cell import Cell
from camrob.errors import StaleInputError
from camrob.frozen import digest
from camrob.text import one_line

__all__ = ["Calibration", "ErrorSize", "Held", "calibrated_chain", "robot_digest"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ErrorSize:
    """Errors of some poses: m and rad (NaN where the orientation was not measured)."""

    rows: int
    mean: float
    rms: float
    p95: float
    worst: float
    mean_angle: float
    worst_angle: float

    @classmethod
    def of(cls, position: Array, angle: Array, *, oriented: bool) -> ErrorSize:
        """The sizes of errors (N,), m and rad."""
        return cls(
            len(position),
            float(np.mean(position)),
            float(np.sqrt(np.mean(position**2))),
            float(np.quantile(position, 0.95)),
            float(np.max(position)),
            float(np.mean(angle)) if oriented else float("nan"),
            float(np.max(angle)) if oriented else float("nan"),
        )


@dataclass(frozen=True, slots=True)
class Held:
    """A parameter that was not fitted, and why: "merged" with others, "unseen" by the data, or too "weak" in them."""

    name: str
    why: str
    others: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Calibration:
    """What a calibration found of a cell.

    parameters: those fitted. nuisance: names among them that describe the instrument and the reflector, not the
    robot: they take no part in the calibrated chain. held: those asked for that the data don't tell. errors: sizes of
    errors by stage: "nominal", "frames" (base and tool fitted), "calibrated", each "/fitted" and "/withheld".
    correlations: the strongest pairs. condition: of the scaled Jacobian; observability: o1 to o5. cell_digest, logs
    (name, digest), rows, outliers, left_out (rows with empty cells). warnings: sentences for people.
    """

    cell_name: str
    cell_digest: str
    parameters: ParameterSet
    nuisance: tuple[str, ...] = ()
    held: tuple[Held, ...] = ()
    errors: dict[str, ErrorSize] = field(default_factory=dict)
    correlations: tuple[tuple[str, str, float], ...] = ()
    condition: float = float("nan")
    observability: tuple[float, ...] = ()
    scatter_position: float = float("nan")
    scatter_angle: float = float("nan")
    logs: tuple[tuple[str, str], ...] = ()
    rows: int = 0
    outliers: int = 0
    left_out: int = 0
    oriented: bool = False
    warnings: tuple[str, ...] = ()

    def check(self, cell: Cell) -> None:
        """Raise StaleInputError where the calibration was made for another cell, or another state of it."""
        if self.cell_name != cell.name:
            raise StaleInputError(
                f"the calibration is of cell {one_line(self.cell_name, 60)}, not of {cell.name}; give its own"
            )
        if self.cell_digest != robot_digest(cell):
            what = f"cell {cell.name} has changed since it was calibrated"
            raise StaleInputError(f"{what}; calibrate again, or give the cell as it was then")

    def model(self, cell: Cell, *, in_base: bool = False) -> tuple[ErrorModel, Array]:
        """The calibrated chain of the cell (with its present tool) and the parameters' values.

        Poses are those of the tip in `world`, or with in_base in the turning `base`. Raises StaleInputError.
        """
        self.check(cell)
        own = [p for p in self.parameters.items_ if p.name not in self.nuisance]
        return ErrorModel.of(cell, [p.name for p in own], in_base=in_base), np.array([p.value for p in own])


def robot_digest(cell: Cell) -> str:
    """Digest of the cell without its tool, its limits and its settings: what a calibration is true of."""
    joints = [
        part for j in cell.joints for part in (j.name, j.role.value, j.prismatic, j.before, j.after, j.sign, j.offset)
    ]
    masses = [part for m in cell.masses for part in (m.after, m.mass, m.center)]
    return digest(*joints, *masses, cell.base_T_first, cell.foot_T_root, cell.wrist_T_flange)


def calibrated_chain(found: Calibration | None, cell: Cell) -> tuple[ErrorModel, Array]:
    """A calibration's chain and values in `base`; without one the nominal chain, which has none."""
    if found is None:
        return ErrorModel.of(cell, (), in_base=True), np.zeros(0)
    return found.model(cell, in_base=True)
