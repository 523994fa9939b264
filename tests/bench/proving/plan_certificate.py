"""What a proof of a plan's price rests on, in a file that `check_plan` proves again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.redundancy.planning.course import moves_along, waypoint_weights
from camrob.redundancy.planning.freedoms import plan_space
from camrob.redundancy.planning.objective import Objective, motion_price
from camrob.redundancy.planning.waypoints import Waypoints
from proving.arm_shape import arm_shape
from proving.whole_plan import dearest

__all__ = ["write_certificate"]

Array = NDArray[np.float64]

_LOWERED, _WIDER = (
    0.0005,
    0.01,
)  # of a plane and of a bin: what other enclosures, which are not the prover's, may be wider by


def write_certificate(
    file: Path, cell: Cell, objective: Objective, w: Waypoints, most: Array, told: list[dict[str, NDArray]]
) -> None:
    """Write what `prove_plan` told of its levels, and what it is a proof of."""
    frames, endless = np.asarray(w.base_T_tip), plan_space(cell).u_endless
    shape = arm_shape(cell, frames[:, :3, 2].sum(axis=0))
    external = len(shape.after)
    motion = motion_price(objective, moves_along(w, np.arange(len(w))), "travel", "smoothness", "speed")
    both: dict[str, NDArray] = {name: np.zeros(2) for name in ("low", "high")}
    both["low"][:external], both["high"][:external] = shape.lower[:external], shape.upper[:external]
    turns = np.zeros(2, np.bool_)
    turns[:external] = endless[:external]
    for name, empty in (("rate", 0.0), ("square", 0.0), ("top", np.inf)):
        both[name] = np.full((len(w), 2), empty)
        both[name][:, :external] = getattr(motion, name)[:, :external]
    columns: dict[str, NDArray] = {}
    for n, level in enumerate(told):
        planes, box = level["planes"].copy(), level["box"].copy()
        planes[:, 0] -= _LOWERED * np.abs(planes[:, 0])
        planes[:, 1:] *= 1.0 + _WIDER
        box[:, 1] *= 1.0 + _WIDER
        columns |= {f"{name}{n}": value for name, value in (level | {"planes": planes, "box": box}).items()}
    np.savez_compressed(
        file,
        levels=len(told),
        tip=frames[:, :3, 3],
        axis=frames[:, :3, 2],
        weight=waypoint_weights(w),
        leap=np.where(w.safe, objective.reposture, np.inf),
        haste=motion.haste,
        most=(1.0 - 2.0 * _LOWERED) * np.minimum(most, dearest(objective)),
        endless=turns,
        conditioning=objective.conditioning,
        threshold=objective.threshold,
        power=objective.power,
        **both,
        **columns,
    )
