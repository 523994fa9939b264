"""What there is to say of a solution by the published method."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.findings import Finding, Severity
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.solution import Revision

__all__ = ["kept_revisions", "moved_in_holes"]

Array = NDArray[np.float64]


def kept_revisions(revisions: list[Revision], path: ToolPathInBase) -> tuple[Finding, ...]:
    """Each revision that was kept, with what it made of 1/k_F."""
    return tuple(
        Finding("revision-kept", f"posture revised: 1/k_F {r.inv_kf_before:.3f} to {r.inv_kf_after:.3f}", Severity.INFO,
                line=int(path.line[min(r.point + 1, len(path) - 1)]), region=r.region, point=r.point)
        for r in revisions if r.kept
    )  # fmt: skip


def moved_in_holes(cell: Cell, path: ToolPathInBase, q: Array) -> tuple[Finding, ...]:
    """Holes and short retracts that the arm could not make alone, as one finding with the first of them."""
    external = [*cell.indices(Role.WORKPIECE), *cell.indices(Role.CARRIAGE)]
    moved = np.flatnonzero(path.along_axis[1:] & (np.diff(q[:, external], axis=0) != 0.0).any(axis=1)) + 1
    if not len(moved):
        return ()
    text = "an external axis moves in a hole or a short retract: the arm alone does not reach all of it"
    k = int(moved[0])
    return (Finding("external-axis-in-hole", text, line=int(path.line[k]), region=int(path.region[k]), point=k),)
