"""A fuzzy engine compiled to a surface: weights of all joints on a grid over two axes, read by bilinear interpolation."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.redundancy_settings import FuzzyEngine
from camrob.errors import CellError
from camrob.frozen import locked
from camrob.redundancy.fuzzy.fis import FuzzySystem, read_fis
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["WeightSurface", "compile_surface", "constant_surface", "weights_and_slopes", "weights_at"]

Array = NDArray[np.float64]

NODES = 81  # a side of the grid; the tests hold the surface to the engine itself


class WeightSurface(NamedTuple):
    """table (g0, g1, n): weights of the n joints; axis (2,): the joints that index it; origin, step (2,): in their q."""

    table: Array
    axis: NDArray[np.int64]
    origin: Array
    step: Array


def constant_surface(weights: Array) -> WeightSurface:
    """Weights that don't depend on the posture."""
    table = np.ascontiguousarray(np.broadcast_to(weights, (2, 2, len(weights))))
    return WeightSurface(table, np.zeros(2, np.int64), np.zeros(2), np.ones(2))


def compile_surface(cell: Cell, engine: FuzzyEngine) -> WeightSurface:
    """The surface of one of the cell's engines.

    Raises CellError where the engine has more than two inputs, an input that is no axis, or lacks a named output.
    """
    path = cell.folder / engine.file
    system = read_fis(path)
    _check(cell, engine, system)
    n = len(cell)
    grids = _grids(system)
    values = _on_grid(system)
    outputs = dict(zip((o.name for o in system.outputs), np.moveaxis(values, -1, 0), strict=True))
    table = np.full((*values.shape[:2], n), engine.default_weight)
    for joint, output in engine.weights.items():
        table[..., cell.index(joint)] = outputs[output]
    axis, origin, step = np.zeros(2, np.int64), np.zeros(2), np.ones(2)
    for k, variable in enumerate(system.inputs):
        i = cell.index(variable.name)
        joint_ = cell.joints[i]
        to_si = mm_to_m if joint_.prismatic else deg_to_rad
        axis[k] = i
        origin[k] = float(joint_.q_value(np.asarray(to_si(float(grids[k][0])))))
        step[k] = joint_.sign * to_si(float(grids[k][1] - grids[k][0]))
    return WeightSurface(table, axis, origin, step)


def _grids(system: FuzzySystem) -> list[Array]:
    """The nodes of both inputs; of a second one that isn't there, two."""
    grids = [np.linspace(i.lower, i.upper, NODES) for i in system.inputs]
    return grids if len(grids) == 2 else [*grids, np.zeros(2)]


@lru_cache(maxsize=8)
def _on_grid(system: FuzzySystem) -> Array:
    """Outputs (g0, g1, outputs) at the nodes, kept: a job asks for the same engines several times."""
    first, second = np.meshgrid(*_grids(system), indexing="ij")
    values = [first.ravel(), second.ravel()][: len(system.inputs)]
    return locked(system.evaluate_grid(np.stack(values, axis=1)).reshape(*first.shape, -1))


def _check(cell: Cell, engine: FuzzyEngine, system: FuzzySystem) -> None:
    path = cell.folder / engine.file
    if not 1 <= len(system.inputs) <= 2:
        raise CellError(f"has {len(system.inputs)} inputs", cure="use one or two axes as inputs", path=path)
    for variable in system.inputs:
        if variable.name not in cell.axis_names:
            raise CellError(
                f"input {variable.name!r} is no axis of the cell", cure=f"use {', '.join(cell.axis_names)}", path=path
            )
    names = [o.name for o in system.outputs]
    for joint, output in engine.weights.items():
        if output not in names:
            raise CellError(f"has no output {output!r} for {joint}", cure=f"use one of {', '.join(names)}", path=path)


@numba.njit(cache=True, forceinline=True, error_model="numpy", _nrt=False)
def _cell_of(surface: WeightSurface, q: Array) -> tuple[int, int, float, float, bool, bool]:
    """Grid cell, place in it, and whether each axis lies within the grid."""
    size0, size1, _n = surface.table.shape
    u = (q[surface.axis[0]] - surface.origin[0]) / surface.step[0]
    v = (q[surface.axis[1]] - surface.origin[1]) / surface.step[1]
    inside_u, inside_v = 0.0 <= u <= size0 - 1.0, 0.0 <= v <= size1 - 1.0
    u = min(max(u, 0.0), size0 - 1.0)
    v = min(max(v, 0.0), size1 - 1.0)
    i = min(int(u), size0 - 2)
    j = min(int(v), size1 - 2)
    return i, j, u - i, v - j, inside_u, inside_v


@numba.njit(cache=True, forceinline=True, error_model="numpy", _nrt=False)
def weights_at(surface: WeightSurface, q: Array, out: Array) -> None:
    """Weights (n,) of posture q (n,) into out; beyond the grid the border holds."""
    i, j, u, v, _inside_u, _inside_v = _cell_of(surface, q)
    table = surface.table
    for k in range(table.shape[2]):
        low = table[i, j, k] + v * (table[i, j + 1, k] - table[i, j, k])
        high = table[i + 1, j, k] + v * (table[i + 1, j + 1, k] - table[i + 1, j, k])
        out[k] = low + u * (high - low)


@numba.njit(cache=True, forceinline=True, error_model="numpy", _nrt=False)
def weights_and_slopes(surface: WeightSurface, q: Array, out: Array, slope0: Array, slope1: Array) -> None:
    """As `weights_at`, with the derivatives (n,) by the q of the surface's first and second axis."""
    i, j, u, v, inside_u, inside_v = _cell_of(surface, q)
    table = surface.table
    per0 = 1.0 / surface.step[0] if inside_u else 0.0
    per1 = 1.0 / surface.step[1] if inside_v else 0.0
    for k in range(table.shape[2]):
        a, b, c, d = table[i, j, k], table[i, j + 1, k], table[i + 1, j, k], table[i + 1, j + 1, k]
        low, high = a + v * (b - a), c + v * (d - c)
        out[k] = low + u * (high - low)
        slope0[k] = (high - low) * per0
        left = a + u * (c - a)
        slope1[k] = ((b + u * (d - b)) - left) * per1
