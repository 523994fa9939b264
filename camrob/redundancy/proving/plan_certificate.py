"""What a proof of a plan's price rests on, in a file that `camrob.witness.proof_check` proves again."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.redundancy.planning.freedoms import plan_space
from camrob.redundancy.planning.objective import Objective
from camrob.redundancy.proving.arm_shape import arm_shape
from camrob.redundancy.proving.statement import Statement
from camrob.redundancy.proving.whole_plan import Told

__all__ = ["write_certificate"]

_LOWERED = 0.0005  # of a plane: what other enclosures of a price, which are not the prover's, may be wider by


def write_certificate(
    file: Path, cell: Cell, objective: Objective, pieces: Sequence[tuple[Statement, Sequence[Told]]]
) -> None:
    """Write, piece by piece, what is stated and what `prove_plan` told of its levels."""
    columns: dict[str, NDArray[Any]] = {}
    for p, (stated, told) in enumerate(pieces):
        own = _stated(cell, objective, stated)
        for n, level in enumerate(told):
            planes = level["planes"].copy()
            planes[:, 0] -= _LOWERED * np.abs(planes[:, 0])
            own |= {f"{name}{n}": value for name, value in (level | {"planes": planes}).items()}
        columns |= {f"{p}.{name}": value for name, value in (own | {"levels": np.array(len(told))}).items()}
    with file.open("wb") as stream:
        np.savez_compressed(
            stream,
            pieces=len(pieces),
            conditioning=objective.conditioning,
            threshold=objective.threshold,
            power=objective.power,
            tool=cell.flange_T_tool,
            **columns,  # type: ignore[arg-type]
        )


def _stated(cell: Cell, objective: Objective, stated: Statement) -> dict[str, NDArray[Any]]:
    """A statement's columns, for two external axes whether there are two or not."""
    shape, external = arm_shape(cell, stated.axis.sum(axis=0)), stated.rate.shape[1]
    columns: dict[str, NDArray[Any]] = {name: np.zeros(2) for name in ("low", "high")}
    columns["low"][:external], columns["high"][:external] = shape.lower[:external], shape.upper[:external]
    columns["endless"] = np.zeros(2, np.bool_)
    columns["endless"][:external] = plan_space(cell).u_endless[:external]
    for name, empty in (("rate", 0.0), ("square", 0.0), ("top", np.inf)):
        columns[name] = np.full((len(stated.weight), 2), empty)
        columns[name][:, :external] = getattr(stated, name)
    for name in ("tip", "axis", "weight", "leap", "haste"):
        columns[name] = getattr(stated, name)
    # what planes are lowered by must not make a cell count that was dearer than the most
    columns["most"] = (1.0 - 2.0 * _LOWERED) * stated.most
    return columns
