"""A drawn family of short paths on the KR15 cell's table, six kinds of six: what weights are fitted on and withheld from.

Every path is drawn by its kind's rule from a seed of its own, so that the family is the same wherever it is made. A path that no
posture can follow from HOME with the cell's own engines is drawn again (the next seed): what would be compared on it is luck.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from camrob.cell.cell import Cell
from camrob.errors import JobError
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.published.virtual_joint import resolve_vjm
from camrob.redundancy.transfers import build_path
from camrob.toolpath.region import Move, Region
from camrob.toolpath.toolpath import Toolpath

__all__ = ["KINDS", "FamilyPath", "drawn_path", "family"]

FEED = 0.05  # m/s: roughing in foam, where the axes' speeds begin to matter
SPACING = 0.01  # m between points
CLEARANCE = 0.05


@dataclass(frozen=True)
class FamilyPath:
    """A path with its kind and the seed that it was drawn from."""

    kind: str
    seed: int
    path: ToolPathInBase


def zigzag(width: float, depth: float, rows: int) -> np.ndarray:
    """(N, 2) points of rows to and fro, SPACING apart."""
    x = np.linspace(-0.5 * width, 0.5 * width, max(2, int(width / SPACING) + 1))
    rows_y = np.linspace(-0.5 * depth, 0.5 * depth, rows)
    return np.concatenate(
        [np.stack([x if k % 2 == 0 else x[::-1], np.full(len(x), y)], axis=1) for k, y in enumerate(rows_y)]
    )


def turned(axis: np.ndarray, about: float) -> np.ndarray:
    """A rotation (3, 3) whose z is `axis` and whose x lies level, turned by `about` about the axis."""
    z = axis / np.linalg.norm(axis)
    x = np.cross([0.0, 0.0, 1.0], z) if abs(z[2]) < 0.999 else np.array([1.0, 0.0, 0.0])
    x = x / np.linalg.norm(x)
    y = np.cross(z, x)
    return np.stack([np.cos(about) * x + np.sin(about) * y, np.cos(about) * y - np.sin(about) * x, z], axis=1)


def leaning(tilt: float, azimuth: float) -> np.ndarray:
    """A unit vector `tilt` rad off the vertical, towards `azimuth`."""
    return np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])


def region(name: str, position: np.ndarray, axis: np.ndarray) -> Region:
    n = len(position)
    axis = axis / np.linalg.norm(axis, axis=1, keepdims=True)
    return Region(
        name, position, axis, np.full(n, FEED), np.full(n, int(Move.CUT), np.int8), np.arange(1, n + 1), operation=name
    )


def plane(rng, name: str, normal: np.ndarray, center: np.ndarray, size: tuple[float, float]) -> Region:
    flat = zigzag(rng.uniform(*size), rng.uniform(*size), int(rng.integers(4, 8)))
    R = turned(normal, rng.uniform(0.0, np.pi))
    return region(name, center + flat @ R[:, :2].T, np.tile(normal, (len(flat), 1)))


def flat(rng) -> list[Region]:
    """2.5 D: rows in a level plane, the tool upright."""
    center = np.array([rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2), rng.uniform(0.1, 0.6)])
    return [plane(rng, "flat", np.array([0.0, 0.0, 1.0]), center, (0.15, 0.45))]


def tilted(rng) -> list[Region]:
    """3+2: rows in a leaning plane, the tool along its normal."""
    center = np.array([rng.uniform(-0.15, 0.15), rng.uniform(-0.15, 0.15), rng.uniform(0.2, 0.6)])
    normal = leaning(np.radians(rng.uniform(15.0, 65.0)), rng.uniform(-np.pi, np.pi))
    return [plane(rng, "tilted", normal, center, (0.15, 0.35))]


def five_axis(rng) -> list[Region]:
    """Rows over a bumpy surface, the tool along its normal."""
    across = zigzag(rng.uniform(0.15, 0.35), rng.uniform(0.15, 0.35), int(rng.integers(4, 8)))
    height, wave = rng.uniform(0.01, 0.04), rng.uniform(15.0, 30.0)
    phase = rng.uniform(0.0, 2.0 * np.pi, 2)
    a, b = wave * across[:, 0] + phase[0], wave * across[:, 1] + phase[1]
    z = height * np.sin(a) * np.cos(b)
    normal = np.stack(
        [-height * wave * np.cos(a) * np.cos(b), height * wave * np.sin(a) * np.sin(b), np.ones(len(z))], 1
    )
    center = np.array([rng.uniform(-0.15, 0.15), rng.uniform(-0.15, 0.15), rng.uniform(0.15, 0.5)])
    R = turned(leaning(np.radians(rng.uniform(0.0, 30.0)), rng.uniform(-np.pi, np.pi)), rng.uniform(0.0, np.pi))
    return [region("bumps", center + np.column_stack([across, z]) @ R.T, normal @ R.T)]


def two_sided(rng) -> list[Region]:
    """Two leaning planes back to back, as the paper's carving has them, one after the other."""
    azimuth, tilt = rng.uniform(-np.pi, np.pi), np.radians(rng.uniform(40.0, 80.0))
    height, half = rng.uniform(0.25, 0.55), rng.uniform(0.05, 0.12)
    sides = []
    for k in range(2):
        normal = leaning(tilt, azimuth + k * np.radians(rng.uniform(80.0, 180.0)))
        sides.append(plane(rng, f"side {k + 1}", normal, half * normal + [0.0, 0.0, height], (0.1, 0.25)))
    return sides


def near_wrist(rng) -> list[Region]:
    """An arc over which the tool leans from upright to beyond the level and back: the way past A5 = 0."""
    azimuth, steepest = rng.uniform(-np.pi, np.pi), np.radians(rng.uniform(75.0, 115.0))
    count, radius = 140, rng.uniform(0.08, 0.2)
    s = np.linspace(0.0, 1.0, count)
    tilt = steepest * np.sin(np.pi * s) ** 2
    wander = azimuth + np.radians(rng.uniform(-40.0, 40.0)) * (s - 0.5)
    axis = np.stack([np.sin(tilt) * np.cos(wander), np.sin(tilt) * np.sin(wander), np.cos(tilt)], axis=1)
    side = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    center = np.array([rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1), rng.uniform(0.3, 0.7)])
    return [region("lean", center + radius * axis + rng.uniform(0.1, 0.3) * (s - 0.5)[:, None] * side, axis)]


def stretched(rng) -> list[Region]:
    """A tall or far place: rows up a wall or across a wide plane, where the arm has to stretch."""
    azimuth = rng.uniform(-np.pi, np.pi)
    wall = rng.uniform() < 0.5
    if wall:
        normal = leaning(np.radians(rng.uniform(70.0, 95.0)), azimuth)
        center = 0.25 * normal + [0.0, 0.0, rng.uniform(0.8, 1.3)]
        return [plane(rng, "wall", normal, center, (0.2, 0.4))]
    center = np.array([0.3 * np.cos(azimuth), 0.3 * np.sin(azimuth), rng.uniform(0.8, 1.2)])
    return [plane(rng, "high", leaning(np.radians(rng.uniform(0.0, 30.0)), azimuth), center, (0.3, 0.6))]


KINDS: dict[str, Callable[..., list[Region]]] = {
    "2.5 D": flat,
    "tilted": tilted,
    "5-axis": five_axis,
    "two-sided": two_sided,
    "near the wrist's singularity": near_wrist,
    "stretched": stretched,
}


def drawn_path(cell: Cell, kind: str, seed: int) -> ToolPathInBase:
    """The path of a kind that a seed draws."""
    rng = np.random.default_rng([list(KINDS).index(kind), seed])
    regions = tuple(KINDS[kind](rng))
    return build_path(cell, Toolpath(regions, "drawn", "", "drawn"), np.eye(4), clearance=CLEARANCE)


def family(cell: Cell, each: int = 6) -> list[FamilyPath]:
    """`each` paths of every kind that the cell's own engines can follow."""
    found = []
    for kind in KINDS:
        seed, kept = 0, 0
        while kept < each:
            path = drawn_path(cell, kind, seed)
            try:
                resolve_vjm(cell, path)
            except JobError:
                pass
            else:
                found.append(FamilyPath(kind, seed, path))
                kept += 1
            seed += 1
    return found
