"""Solved paths as files, NAME.path.npz: the postures, the axis values that a program prints of them, and where they are from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import InputError
from camrob.jobs.files.npz import read_arrays
from camrob.units import m_to_mm

__all__ = ["is_solution", "read_solution", "save_solution", "stem_of"]

Array = NDArray[np.float64]

_SUFFIX = ".path.npz"


def is_solution(path: Path) -> bool:
    """True for NAME.path.npz."""
    return path.name.lower().endswith(_SUFFIX)


def stem_of(path: Path) -> str:
    """NAME of a solution, NAME.path.npz, or of a program."""
    return path.name[: -len(_SUFFIX)] if is_solution(path) else path.stem


def read_solution(path: Path, cell: Cell) -> tuple[Array, NDArray[np.int64]]:
    """Postures (N, n) and lines (N,) of a NAME.path.npz. Raises InputError."""
    q, line, axes = read_arrays(path, "q", "line", "axes", hint="give the NAME.path.npz that camrob post wrote")
    alike = q.dtype.kind == "f" and line.dtype.kind == "i" and axes.dtype.kind == "U" and axes.ndim == 1
    alike = alike and q.ndim == 2 and q.shape[1] == len(cell) and line.shape == (len(q),)
    alike = alike and tuple(axes.tolist()) == tuple(cell.names)
    if not alike or not np.all(np.isfinite(q)):
        raise InputError("holds postures of another cell", hint=f"post it for {cell.name}", path=path)
    if len(q) < 2:
        raise InputError("holds fewer than 2 postures", hint="give a longer path", path=path)
    return np.asarray(q, float), np.asarray(line, np.int64)


def save_solution(
    path: Path,
    cell: Cell,
    q: Array,
    *,
    line: NDArray[np.int64],
    region: NDArray[np.int32],
    inv_kf: Array,
    length: Array,
    **more: NDArray[Any],
) -> None:
    """Write NAME.path.npz: postures q (N, n), rad and m, with their axis values as the controller counts them.

    line, region (N,): where the points are from; inv_kf (N,): the arm's 1/k_F; length (N,): m along the path; more: further
    arrays by their names.
    """
    columns: dict[str, Any] = {
        "q": q,
        "axes": np.array(cell.names),
        "axis_values": cell.to_axis_values(q),
        "axis_names": np.array(cell.axis_names),
        "line": line,
        "region": region,
        "inv_kf": inv_kf,
        "s": m_to_mm(length),
        **more,
    }
    np.savez(path, **columns)
