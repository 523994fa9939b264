"""A fuzzy engine compiled to a table: weights of all joints on a grid over up to three axes, read by linear interpolation.

An engine bends where a term of an input begins and ends, and steeply so: with nodes spread evenly a weight between them is up
to 226 % too high. The nodes lie at those corners and crowd towards them, which leaves less than a tenth with as many of them
(`table_error` says how much of a given engine, scikit-fuzzy being the judge). A Sugeno engine whose rules are all products of
terms that add up to one is met exactly.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.redundancy_settings import EVEN, FuzzyEngine
from camrob.compiled import bare, kernel
from camrob.errors import CellError
from camrob.frozen import locked
from camrob.redundancy.fuzzy.fis import FuzzySystem, FuzzyVariable, read_fis
from camrob.redundancy.fuzzy.kept import kept
from camrob.units import deg_to_rad, mm_to_m

__all__ = [
    "WeightSurface",
    "compile_surface",
    "constant_surface",
    "engine_surface",
    "table_error",
    "weights_and_slopes",
    "weights_at",
]

Array = NDArray[np.float64]

EVEN_NODES = 81  # a side of the even grid, over two inputs at most
_NODES = {1: 145, 2: 145, 3: 33}  # a side of a grid with as many inputs, about: tables of some megabytes at most
_CROWDED = 0.9  # share of an even step by which the nodes next to a corner draw near: the best of 0, 0.6, 0.9 and 0.97
_KINKED = ("trimf", "trapmf", "zmf", "smf")  # kinds whose parameters are the corners


class WeightSurface(NamedTuple):
    """table (g0, g1, g2, n): weights of the n joints; axis (3,): the joints that index it; nodes: their q, rising.

    origin, step (3,): of an even grid, whose nodes are not looked at, in q (a step below 0 leads to falling q); step 0: by nodes.
    An input that isn't there has one node (a second one: two), and joint 0 for an axis.
    """

    table: Array
    axis: NDArray[np.int64]
    origin: Array
    step: Array
    nodes0: Array
    nodes1: Array
    nodes2: Array


def constant_surface(weights: Array) -> WeightSurface:
    """Weights (n,) that don't depend on the posture."""
    table = np.ascontiguousarray(np.broadcast_to(weights, (2, 2, 1, len(weights))))
    return WeightSurface(
        table, np.zeros(3, np.int64), np.zeros(3), np.zeros(3), np.arange(2.0), np.arange(2.0), np.zeros(1)
    )


def compile_surface(cell: Cell, engine: FuzzyEngine) -> WeightSurface:
    """The surface of one of the cell's engines.

    Raises CellError where the engine has an input that is no axis, or lacks a named output.
    """
    path = cell.folder / engine.file
    system = read_fis(path)
    _check(cell, engine, system)
    even = _is_even(engine, system)
    *grids, values = kept(f"table, even {even}", system, lambda: _flat(system, even))
    return _surface(cell, engine, system, grids, values)


def engine_surface(cell: Cell, engine: FuzzyEngine, system: FuzzySystem) -> WeightSurface:
    """The surface of a system that stands for one of the cell's engines and fits it."""
    *grids, values = _flat(system, _is_even(engine, system))
    return _surface(cell, engine, system, grids, values)


def _is_even(engine: FuzzyEngine, system: FuzzySystem) -> bool:
    return engine.table == EVEN and len(system.inputs) < len(_NODES)


def _flat(system: FuzzySystem, even: bool) -> tuple[Array, ...]:
    grids, values = _on_grid(system, even)
    return (*grids, values)


def _surface(
    cell: Cell, engine: FuzzyEngine, system: FuzzySystem, grids: Sequence[Array], values: Array
) -> WeightSurface:
    even = _is_even(engine, system)
    table = np.full((*values.shape[:3], len(cell)), engine.default_weight)
    names = [o.name for o in system.outputs]
    for joint, output in engine.weights.items():
        table[..., cell.index(joint)] = values[..., names.index(output)]
    axis, origin, step, nodes = np.zeros(3, np.int64), np.zeros(3), np.zeros(3), [*grids]
    for k, variable in enumerate(system.inputs):
        i = cell.index(variable.name)
        joint_ = cell.joints[i]
        to_si = mm_to_m if joint_.prismatic else deg_to_rad
        axis[k] = i
        nodes[k] = np.asarray(joint_.q_value(np.asarray([to_si(float(g)) for g in grids[k]])))
        if even:
            origin[k], step[k] = nodes[k][0], joint_.sign * to_si(float(grids[k][1] - grids[k][0]))
        elif joint_.sign < 0:
            nodes[k], table = nodes[k][::-1], np.flip(table, k)
    return WeightSurface(np.ascontiguousarray(table), axis, origin, step, *(np.array(node) for node in nodes))


def table_error(system: FuzzySystem, *, even: bool = False, points: int = 2000, seed: int = 0) -> tuple[float, Array]:
    """The largest relative error of a weight in the compiled table, and the inputs (k,) there, degrees and mm.

    Judged by `FuzzySystem.evaluate`, scikit-fuzzy's, at the worst of `points` drawn places (the even grid's own error is
    looked for with `even`).
    """
    inputs = len(system.inputs)
    grids, values = _on_grid(system, even and inputs < len(_NODES))
    x = np.random.default_rng(seed).uniform(
        [v.lower for v in system.inputs], [v.upper for v in system.inputs], (points, inputs)
    )
    place = np.zeros((points, 3))
    place[:, :inputs] = x
    read = np.empty((points, values.shape[3]))
    _read_many(np.array(values, order="C"), *(np.array(g) for g in grids), place, read)
    exact = system.evaluate_grid(x)
    worst = np.max(np.abs(read / exact - 1.0), axis=1)
    k = int(np.argmax(worst))
    reference = system.evaluate(x[k])
    return float(np.max(np.abs(read[k] / reference - 1.0))), x[k]


def _nodes(variable: FuzzyVariable, inputs: int, even: bool) -> Array:
    """An input's nodes, in its own unit."""
    if even:
        return np.linspace(variable.lower, variable.upper, EVEN_NODES)
    corners = {c for term in variable.terms if term.kind in _KINKED for c in term.parameters}
    knots = sorted({variable.lower, variable.upper, *(c for c in corners if variable.lower < c < variable.upper)})
    between = int(np.ceil((_NODES[inputs] - 1) / (len(knots) - 1)))
    t = np.arange(between) / between
    t = t - _CROWDED * np.sin(2.0 * np.pi * t) / (2.0 * np.pi)
    return np.concatenate([*(a + (b - a) * t for a, b in itertools.pairwise(knots)), [knots[-1]]])


@lru_cache(maxsize=8)
def _on_grid(system: FuzzySystem, even: bool) -> tuple[tuple[Array, Array, Array], Array]:
    """The nodes of three inputs and the outputs (g0, g1, g2, outputs) there, kept: a job asks for the same engines often."""
    grids = [_nodes(variable, len(system.inputs), even) for variable in system.inputs]
    absent = [np.arange(2.0), np.zeros(1)]
    grids += absent[len(grids) - 1 :]
    x = np.stack([g.ravel() for g in np.meshgrid(*grids, indexing="ij")], axis=1)[:, : len(system.inputs)]
    parts = np.array_split(x, max(1, len(x) // 4096))  # what the aggregates of all at once would take is gigabytes
    values = np.concatenate([system.evaluate_grid(part) for part in parts])
    a, b, c = (locked(g, name="nodes") for g in grids)
    return (a, b, c), locked(values.reshape(*map(len, grids), -1), name="values")


def _check(cell: Cell, engine: FuzzyEngine, system: FuzzySystem) -> None:
    path = cell.folder / engine.file
    for variable in system.inputs:
        if variable.name not in cell.axis_names:
            raise CellError(
                f"input {variable.name!r} is not an axis of the cell",
                hint=f"use {', '.join(cell.axis_names)}",
                path=path,
            )
    names = [o.name for o in system.outputs]
    for joint, output in engine.weights.items():
        if output not in names:
            raise CellError(f"has no output {output!r} for {joint}", hint=f"use one of {', '.join(names)}", path=path)


@bare
def _place_of(nodes: Array, origin: float, step: float, x: float) -> tuple[int, float, float]:
    """The interval of the nodes that x lies in, the share of it, and one over its length; 0 beyond the nodes."""
    last = nodes.shape[0] - 1
    if step != 0.0:
        u = (x - origin) / step
        inside = 0.0 <= u <= last
        u = min(max(u, 0.0), float(last))
        i = min(int(u), last - 1)
        return i, u - i, 1.0 / step if inside else 0.0
    if last == 0:
        return 0, 0.0, 0.0
    if not x > nodes[0]:
        return 0, 0.0, 1.0 / (nodes[1] - nodes[0]) if x == nodes[0] else 0.0
    if not x < nodes[last]:
        return last - 1, 1.0, 1.0 / (nodes[last] - nodes[last - 1]) if x == nodes[last] else 0.0
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        if nodes[middle] <= x:
            low = middle
        else:
            high = middle
    per = 1.0 / (nodes[low + 1] - nodes[low])
    return low, (x - nodes[low]) * per, per


@bare
def _bilinear(table: Array, i: int, j: int, h: int, k: int, u: float, v: float) -> tuple[float, float, float]:
    """Value and slopes by u and v in the plane h of the table's column k."""
    a, b, c, d = table[i, j, h, k], table[i, j + 1, h, k], table[i + 1, j, h, k], table[i + 1, j + 1, h, k]
    low, high = a + v * (b - a), c + v * (d - c)
    return low + u * (high - low), high - low, (b + u * (d - b)) - (a + u * (c - a))


@kernel
def _read_many(table: Array, nodes0: Array, nodes1: Array, nodes2: Array, x: Array, out: Array) -> None:
    """out (N, outputs) <- the table at x (N, 3)."""
    for row in range(x.shape[0]):
        i, u, _p = _place_of(nodes0, 0.0, 0.0, x[row, 0])
        j, v, _p = _place_of(nodes1, 0.0, 0.0, x[row, 1])
        h, t, _p = _place_of(nodes2, 0.0, 0.0, x[row, 2])
        for k in range(table.shape[3]):
            value = _bilinear(table, i, j, h, k, u, v)[0]
            if t > 0.0:
                value += t * (_bilinear(table, i, j, h + 1, k, u, v)[0] - value)
            out[row, k] = value


@bare
def weights_at(surface: WeightSurface, q: Array, out: Array) -> None:
    """Weights (n,) of posture q (n,) into out; beyond the grid the border holds."""
    i, u, _per0 = _place_of(surface.nodes0, surface.origin[0], surface.step[0], q[surface.axis[0]])
    j, v, _per1 = _place_of(surface.nodes1, surface.origin[1], surface.step[1], q[surface.axis[1]])
    h, t, _per2 = _place_of(surface.nodes2, surface.origin[2], surface.step[2], q[surface.axis[2]])
    for k in range(surface.table.shape[3]):
        out[k] = _bilinear(surface.table, i, j, h, k, u, v)[0]
        if t > 0.0:
            out[k] += t * (_bilinear(surface.table, i, j, h + 1, k, u, v)[0] - out[k])


@bare
def weights_and_slopes(surface: WeightSurface, q: Array, out: Array, slope: Array) -> None:
    """As `weights_at`, with the derivatives (3, n) by the q of the surface's axes."""
    i, u, per0 = _place_of(surface.nodes0, surface.origin[0], surface.step[0], q[surface.axis[0]])
    j, v, per1 = _place_of(surface.nodes1, surface.origin[1], surface.step[1], q[surface.axis[1]])
    h, t, per2 = _place_of(surface.nodes2, surface.origin[2], surface.step[2], q[surface.axis[2]])
    third = surface.nodes2.shape[0] > 1
    for k in range(surface.table.shape[3]):
        value, by0, by1 = _bilinear(surface.table, i, j, h, k, u, v)
        by2 = 0.0
        if third:
            other, other0, other1 = _bilinear(surface.table, i, j, h + 1, k, u, v)
            by2 = other - value
            value, by0, by1 = value + t * by2, by0 + t * (other0 - by0), by1 + t * (other1 - by1)
        out[k] = value
        slope[0, k], slope[1, k], slope[2, k] = by0 * per0, by1 * per1, by2 * per2
