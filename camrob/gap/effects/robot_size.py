"""What is ordinary for a robot of its size: effects take their ranges from its masses, its reach and its rated payload."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.dynamics.gravity import GRAVITY

__all__ = ["COMPLIANCE_RATIO", "compliances_beside", "ordinary_compliance", "ordinary_sag", "rated_payload", "reach_of"]

Array = NDArray[np.float64]

COMPLIANCE_RATIO = np.array([1.0, 1.0, 1.0, 4.0, 4.0, 4.0])
"""Compliances of axes of which nothing is known, beside each other: the wrist's gears are some sizes smaller. An assumption,
and said.
"""

_GIVES = 7.1e-3  # rad that a gear gives under the moment of all masses, stretched out; the ranges are wide beside it
_PAYLOAD_SHARE = 0.1  # of its own mass: what an arm carries, where the cell doesn't say
_LEAST_PAYLOAD, _LEAST_REACH = 0.5, 0.1  # kg, m: of the smallest of arms


def reach_of(cell: Cell) -> float:
    """m from the arm's second axis to the mounting plate, stretched out (from the first, where there is no second)."""
    arm = [j for j in cell.joints if j.role is Role.ARM]
    ends = [*(np.asarray(b.before) for b in arm[1:]), np.asarray(cell.wrist_T_flange)]
    links = [float(np.linalg.norm((a.after @ end)[:3, 3])) for a, end in zip(arm, ends, strict=True)]
    return max(sum(links[1:]) or sum(links), _LEAST_REACH)


def rated_payload(cell: Cell) -> float:
    """kg that the cell is rated for, or else what an arm of its mass carries."""
    return max(cell.payload or _PAYLOAD_SHARE * sum(m.mass for m in cell.masses), _LEAST_PAYLOAD)


def ordinary_compliance(cell: Cell) -> float:
    """rad/Nm of an axis: gears are chosen by the moment that they bear.

    Held to fits and data sheets over a factor of 100: 4e-6 for a KR15, 1.8e-5 for a UR10 (0.9e-5 to 1.3e-5 fitted for its A2
    and A3 on real poses), 1.8e-7 for a KR500.
    """
    moved = [m.mass for m in cell.masses if cell.joints[cell.index(m.after)].role is not Role.WORKPIECE]
    return _GIVES / (GRAVITY * max(sum(moved), rated_payload(cell)) * reach_of(cell))


def ordinary_sag() -> float:
    """rad that an axis gives under the arm and its load, stretched out."""
    return _GIVES


def compliances_beside(known: Array, scale: float) -> Array:
    """(6,) rad/Nm: what is known of an arm's axes (6,), 0 of others, and beside it what such an axis has, by the ratio of axes
    (scale: rad/Nm of the first, where nothing is known).
    """
    measured = known > 0.0
    if measured.any():
        scale = float(np.mean(known[measured] / COMPLIANCE_RATIO[measured]))
    return np.where(measured, known, scale * COMPLIANCE_RATIO)
