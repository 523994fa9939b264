"""The collision checker finds every pair of the shipped cell's bodies in a posture in which they are known to touch.

That they touch is worked out apart from camrob: the cell's bodies placed by the arm's published rows, points on the one inside
the other (tests/bench/mutation).
"""

from __future__ import annotations

import sys
import tomllib
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from camrob.cell.read_cell import read_cell
from camrob.checks.collisions import check_collisions

HERE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(HERE / "bench"))

from mutation import arm  # noqa: E402
from mutation.bodies import Bodies, Body, read_bodies  # noqa: E402

FOLDER = HERE.parent / "cells" / "kr15_track_table"
CELL = read_cell(FOLDER)
NAMES = ("A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2")
DEEP_MM = 8.0
LOW, HIGH = np.array([-150.0, -150.0, 120.0]), np.array([150.0, 150.0, 600.0])  # mm in base: a part, a stock


def _box(name: str) -> Body:
    return Body(name, name, "base", "box", tuple((HIGH - LOW).tolist()), arm.shift(*((LOW + HIGH) / 2.0)), frozenset())


def _triangles() -> np.ndarray:
    """The box as a mesh (12, 3, 3), m."""
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * (HIGH - LOW) + LOW
    faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return np.array([[corner[f[0]], corner[f[k]], corner[f[k + 1]]] for f in faces for k in (1, 2)]) / 1000.0


@cache
def _bodies() -> tuple[Body, ...]:
    return read_bodies(tomllib.loads((FOLDER / "cell.toml").read_text(encoding="utf-8")), None, None).bodies


@cache
def _drawn() -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Postures (N, 8), degrees and mm, also beyond the axes' ranges, and where each body is then."""
    rng = np.random.default_rng(5)
    axes = rng.uniform(-180.0, 180.0, (10000, 8))
    axes[:, 6] *= 1500.0 / 180.0
    every = Bodies((*_bodies(), _box("part"), _box("stock")))
    tips = arm.base_T_flange(axes) @ arm.frame(arm.TOOL)
    return axes, dict(every._poses(axes, tips))


def _depths(inner: Body, outer: Body, at: dict[str, np.ndarray]) -> np.ndarray:
    """(N,) how deep the deepest point of `inner` lies in `outer`, mm."""
    turned = np.swapaxes(at[outer.name][:, :3, :3], 1, 2)
    middle = (turned @ (at[inner.name][:, :3, 3] - at[outer.name][:, :3, 3])[..., None])[..., 0]
    out = np.full(len(middle), -np.inf)
    near = np.flatnonzero(outer.depth(middle) > -float(np.linalg.norm(inner.surface, axis=1).max()))
    for rows in np.array_split(near, max(1, len(near) // 2000)):
        points = inner.surface @ np.swapaxes(turned[rows] @ at[inner.name][rows, :3, :3], 1, 2) + middle[rows, None]
        out[rows] = outer.depth(points).max(axis=1)
    return out


def _pairs() -> list[tuple[str, str]]:
    bodies = _bodies()
    moving = [
        (a.name, b.name)
        for i, a in enumerate(bodies)
        for b in bodies[i + 1 :]
        if a.group != b.group and a.group not in b.ignore and b.group not in a.ignore and _rides(a) != _rides(b)
    ]
    job = [(b.name, job) for job in ("part", "stock") for b in bodies if _rides(b) > 2 and b.group != "tool"]
    return [*moving, *job, ("tool", "part")]


def _rides(body: Body) -> int:
    """How far down the chain from `world` the body's frame is; `base` is beside it."""
    order = ("world", "base", "root", "A1", "A2", "A3", "A4", "A5", "A6", "flange", "tool")
    return order.index(body.frame)


def _touched(posture: np.ndarray) -> set[frozenset[str]]:
    """The pairs of bodies that the checker finds touching in a posture (8,), between moves through air."""
    q = CELL.to_q(posture[[NAMES.index(name) for name in CELL.axis_names]])
    q = np.stack([q, q])
    no = np.zeros(2, bool)
    mesh = _triangles()
    report = check_collisions(CELL, q, cutting=no, line=no, region=no, part_mesh=mesh, stock_mesh=mesh)
    return {frozenset(pair.pair) for pair in report.pairs if pair.count}


@pytest.mark.slow
def test_each_pair_of_bodies_is_found_where_it_touches() -> None:
    axes, at = _drawn()
    bodies = {body.name: body for body in (*_bodies(), _box("part"), _box("stock"))}
    missed, met = [], set()
    for a, b in _pairs():
        depth = np.maximum(_depths(bodies[a], bodies[b], at), _depths(bodies[b], bodies[a], at))
        rows = np.flatnonzero(depth > DEEP_MM)
        rows = rows[np.argsort(depth[rows])]
        for row in {int(rows[0]), int(rows[len(rows) // 2])} if len(rows) else ():
            met.add((a, b))
            if frozenset((a, b)) not in _touched(axes[row]):
                missed.append((a, b, axes[row].round(2).tolist()))
    assert missed == []
    never = sorted(set(_pairs()) - met)
    assert len(met) >= 85, never
