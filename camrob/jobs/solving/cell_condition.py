"""`camrob cell condition`: the length by which an arm's Jacobian is made homogeneous, and the posture that is best by it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from camrob.cell.read_cell import read_cell
from camrob.kinematics.best_condition import best_condition
from camrob.kinematics.kernels import chain_arrays, inverse_kf_many
from camrob.summaries.shipped_summary import ConditionSummary
from camrob.units import m_to_mm

__all__ = ["CellConditionResult", "cell_condition"]


@dataclass(frozen=True, slots=True)
class CellConditionResult:
    """The arm's best condition."""

    summary: ConditionSummary


def cell_condition(cell: Path) -> CellConditionResult:
    """The characteristic length and best-conditioned posture of a cell's arm. Raises CellError."""
    machine = read_cell(Path(cell))
    best = best_condition(machine)
    values = machine.to_axis_values(best.q)
    arm = {joint.name for joint in machine.joints[machine.arm_slice]}
    summary = ConditionSummary(
        cell=machine.name,
        characteristic_length_mm=round(float(m_to_mm(best.length)), 3),
        stated_mm=round(float(m_to_mm(machine.condition_length)), 3),
        kf=round(best.kf, 5),
        inv_kf=round(1.0 / best.kf, 5),
        posture={n: round(float(v), 3) for n, v in zip(machine.axis_names, values, strict=True) if n in arm},
        home_inv_kf=round(float(inverse_kf_many(chain_arrays(machine), machine.q_home[None])[0]), 5),
    )
    return CellConditionResult(summary)
