"""The weld seam of Duong and others (2020), its derivatives, and the robot's motion along it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.kinematics.adjusting import CurveInJoints, follow_points, joint_derivatives, printed_derivatives
from camrob.toml.read_toml import read_toml
from camrob.toml.table_reader import TableReader
from camrob.units import mm_to_m

__all__ = ["SEAM", "Seam", "SeamMotion", "read_seam", "seam_motion"]

Array = NDArray[np.float64]

SEAM = "seam.toml"
"""The file of a cell's folder that has the seam."""


@dataclass(frozen=True, slots=True)
class Seam:
    """x = corner + size (1 + sin 2u cos u), y = corner + size (1 + sin 2u sin u), z = height, u from 0 to 1; and the scheme.

    Lengths in m. start: posture (n,) that the first point is adjusted from. step_u: of the printed points. feed_first,
    feed_step, feed_tops: m/s, of the published scheme. gravity: m/s2.
    """

    corner: float
    size: float
    height: float
    start: Array
    step_u: float
    feed_first: float
    feed_step: float
    feed_tops: tuple[float, ...]
    gravity: float

    def point(self, u: Array, order: int = 0) -> Array:
        """Points (N, 3), m, or their derivatives of `order` over u (N,)."""

        def sine(w: float, phase: float) -> Array:
            return w**order * np.sin(w * u + phase + order * np.pi / 2.0)

        half = np.pi / 2.0  # sin 2u cos u = (sin 3u + sin u) / 2, sin 2u sin u = (cos u - cos 3u) / 2
        x = 0.5 * self.size * (sine(3.0, 0.0) + sine(1.0, 0.0))
        y = 0.5 * self.size * (sine(1.0, half) - sine(3.0, half))
        out = np.column_stack([x, y, np.zeros_like(x)])
        if order == 0:
            out += [self.corner + self.size, self.corner + self.size, self.height]
        return out


def read_seam(path: Path) -> Seam:
    """The seam of a cell's folder. Raises CellError, with key and hint, where seam.toml is wrong or absent."""
    file = path / SEAM
    table = TableReader(read_toml(file), file)
    seam = Seam(
        mm_to_m(table.number("corner_mm", lower=-1e4, upper=1e4)),
        mm_to_m(table.number("size_mm", lower=1.0, upper=1e4)),
        mm_to_m(table.number("height_mm", lower=-1e4, upper=1e4)),
        table.vector("start_rad", 6),
        table.number("step_u", lower=1e-4, upper=0.1),
        table.number("feed_first_m_s", lower=1e-6, upper=10.0),
        table.number("feed_step_m_s", lower=1e-6, upper=1.0),
        tuple(float(f) for f in table.vector("feed_top_m_s", 2)),
        table.number("gravity_m_s2", lower=0.0, upper=100.0),
    )
    table.finish()
    return seam


class SeamMotion(NamedTuple):
    """A seam followed at u (N,), arc length s (N,), m: position error (N,), m; joints over s; and over s as printed.

    x1, x2, x3: (N, 3), the tip's derivatives over s. printed_x2: as eq. 15 prints it, the projection added.
    """

    u: Array
    s: Array
    error: Array
    joints: CurveInJoints
    printed: CurveInJoints
    x1: Array
    x2: Array
    x3: Array
    printed_x2: Array


def seam_motion(cell: Cell, seam: Seam, count: int) -> SeamMotion:
    """The robot's motion along the seam at `count` + 1 even steps of u, by increments adjusted to the seam's own points."""
    u = np.linspace(0.0, 1.0, count + 1)
    # the pseudoinverse's path is the limit of small steps: between printed points a few more are taken
    q, error = follow_points(cell, seam.start, seam.point(u))
    p1, p2, p3 = (seam.point(u, k) for k in (1, 2, 3))
    s1 = np.linalg.norm(p1, axis=1)
    s2 = np.sum(p1 * p2, axis=1) / s1
    s3 = (np.sum(p2 * p2 + p1 * p3, axis=1) - s2**2) / s1
    x1 = p1 / s1[:, None]
    x2 = (p2 - x1 * s2[:, None]) / s1[:, None] ** 2
    x3 = (p3 - 3.0 * x2 * (s1 * s2)[:, None] - x1 * s3[:, None]) / s1[:, None] ** 3
    wrong = p2 / s1[:, None] ** 2 + p1 * (s2 / s1**3)[:, None]
    return SeamMotion(
        u,
        _arc_length(seam, u),
        error,
        joint_derivatives(cell, q, x1, x2, x3),
        printed_derivatives(cell, q, x1, x2, x3),
        x1,
        x2,
        x3,
        wrong,
    )


def _arc_length(seam: Seam, u: Array) -> Array:
    """Arc length up to each u by Gauss-Legendre quadrature over each step."""
    nodes, weights = np.polynomial.legendre.leggauss(6)
    half = 0.5 * np.diff(u)
    at = (0.5 * (u[1:] + u[:-1]))[:, None] + half[:, None] * nodes
    speed = np.linalg.norm(seam.point(at.ravel(), 1), axis=1).reshape(at.shape)
    return np.concatenate([[0.0], np.cumsum(half * (speed @ weights))])
