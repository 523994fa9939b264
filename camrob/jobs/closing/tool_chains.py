"""The calibrated chain with each of the tools that a program mounts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import Calibration, calibrated_chain
from camrob.calibration.compensate import Compensated, compensate_postures
from camrob.calibration.error_model import ErrorModel
from camrob.cell.cell import Cell
from camrob.controller.replay import Replay
from camrob.errors import SingularError
from camrob.kinematics.frames import base_T_tool
from camrob.progress import Share

__all__ = ["ToolChains", "tool_poses"]

Array = NDArray[np.float64]


def tool_poses(run: Replay, q: Array) -> Array:
    """(N, 4, 4) of the tool in `base` at postures (N, n) of a program's motions, each with the tool that it is made with."""
    out = np.empty((len(q), 4, 4))
    for k, cell in enumerate(run.cells):
        rows = run.mounted == k
        out[rows] = base_T_tool(cell, q[rows])
    return out


@dataclass(frozen=True)
class ToolChains:
    """models: the chain with each tool; values: of its parameters, alike for all of them; mounted: (N,) whose tool each of N
    motions, or rows of a run, is made with.
    """

    models: tuple[ErrorModel, ...]
    values: Array
    mounted: NDArray[np.int64]

    @classmethod
    def of(cls, found: Calibration | None, cells: Sequence[Cell], mounted: NDArray[np.integer]) -> ToolChains:
        """The calibrated chain, None: the nominal one, with the tools of these cells; mounted (N,) as above."""
        chains = [calibrated_chain(found, cell) for cell in cells]
        return cls(tuple(model for model, _ in chains), chains[0][1], np.asarray(mounted, np.int64))

    def at(self, rows: NDArray[np.int64]) -> ToolChains:
        """Those of some motions."""
        return replace(self, mounted=self.mounted[rows])

    @property
    def moves_tool(self) -> bool:
        """Whether a tool's own frame is among the parameters, which a calibration knows of one tool."""
        return any(name.startswith("tool.") for name in self.models[0].names)

    def poses(self, q: Array) -> Array:
        """(N, 4, 4) in `base` at postures (N, n)."""
        out = np.empty((len(q), 4, 4))
        for k, rows in self._rows():
            out[rows] = self.models[k].poses(self.values, q[rows])
        return out

    def met(
        self, q: Array, targets: Array, *, farthest: float | None = None, progress: Share | None = None
    ) -> Compensated:
        """As `compensate_postures`."""
        more = {} if farthest is None else {"farthest": farthest}
        parts = []
        for k, rows in self._rows():
            try:
                found = compensate_postures(
                    self.models[k], self.values, q[rows], targets[rows], progress=progress, **more
                )
            except SingularError as error:
                raise SingularError(error.what, value=float(rows[int(error.value or 0.0)])) from None
            parts.append((rows, found))
        order = np.argsort(np.concatenate([rows for rows, _ in parts]))
        columns = [
            np.concatenate([np.asarray(getattr(found, name)) for _, found in parts])[order]
            for name in ("q", "iterations", "before", "after")
        ]
        return Compensated(*columns)

    def _rows(self) -> list[tuple[int, NDArray[np.int64]]]:
        """By tool, the motions that are made with it."""
        rows = [(k, np.flatnonzero(self.mounted == k)) for k in range(len(self.models))]
        return [(k, own) for k, own in rows if len(own)]
