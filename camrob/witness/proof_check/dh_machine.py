"""The machine as a cell.toml says it: how a tool is seen from its arm, all over cells of table and track."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.witness.proof_check.forms import (
    bounds,
    constant,
    inverse,
    minus,
    plus,
    root,
    scaled,
    shifted,
    times,
    turned,
)

__all__ = ["NEAR", "Machine", "dh", "frame"]

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

NEAR = 1e-3
"""Share of the farthest squared distance from axis 1 below which nothing is said of a cell."""
_MM = 1e3  # in a metre
_SAME = 1e-12  # m and sines: an axis that is off by more isn't square, or parallel, to another
_FOUR, _JOINTS = 4, 6  # rows of a matrix; axes of an arm


def dh(row: dict[str, Any], q: float = 0.0, prismatic: bool = False) -> Array:
    """Denavit and Hartenberg's matrix of a row, its variable at q beside what the row says. ValueError: a modified one."""
    if row.get("convention", "standard") != "standard":
        raise ValueError("not a machine that is covered: a modified row")
    t, a = np.radians(row.get("theta_deg", 0.0)) + (0.0 if prismatic else q), np.radians(row["alpha_deg"])
    d = row.get("d_mm", 0.0) / _MM + (q if prismatic else 0.0)
    c, s, ca, sa = np.cos(t), np.sin(t), np.cos(a), np.sin(a)
    r = row["a_mm"] / _MM
    return np.array([[c, -s * ca, s * sa, r * c], [s, c * ca, -c * sa, r * s], [0.0, sa, ca, d], [0.0, 0.0, 0.0, 1.0]])


def frame(values: list[float]) -> Array:
    """X, Y, Z mm, A, B, C degrees about z, y', x''."""
    a, b, c = np.radians(values[3:])
    ca, sa, cb, sb, cc, sc = np.cos(a), np.sin(a), np.cos(b), np.sin(b), np.cos(c), np.sin(c)
    R = np.array([[ca, -sa, 0], [sa, ca, 0], [0, 0, 1]]) @ np.array([[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]])
    T = np.eye(_FOUR)
    T[:3, :3], T[:3, 3] = R @ np.array([[1, 0, 0], [0, cc, -sc], [0, sc, cc]]), np.array(values[:3]) / _MM
    return T


def _mixed(v: list[Array], row: Array) -> Array:
    return scaled(v[0], row[0]) + scaled(v[1], row[1]) + scaled(v[2], row[2])


class Machine:
    """A table that turns on a track that slides, or one of them, under an arm of two parallel axes and a spherical wrist.

    L: the characteristic length, m; lower, upper (6,): limits of the arm, rad; x2, z2: where axis 2 passes, seen from axis 1;
    up, fore (2,): upper arm and forearm, zero posture; wrist, sixth, plate (3,) in the tool's frame.
    """

    def __init__(self, file: Path, tool: Array | None = None) -> None:
        """Of a cell.toml; tool (4, 4): the flange's frame to the tool's, None: as the cell has it. Raises ValueError."""
        cell = tomllib.loads(Path(file).read_text(encoding="utf-8"))
        try:
            self._read(cell, tool)
        except (KeyError, IndexError, TypeError) as error:
            raise ValueError(f"not a machine that is covered: {error}") from None

    def _read(self, cell: dict[str, Any], tool: Array | None) -> None:
        joints = cell["joint"]
        self.L = cell["kinematics"]["characteristic_length_mm"] / _MM
        self.base = frame(cell["kinematics"]["base_to_first"])
        self.outer = [j for j in joints if j["role"] in ("workpiece", "carriage")]
        arm = [j for j in joints if j["role"] == "arm"]
        T, h, o = np.eye(_FOUR), list[Array](), list[Array]()
        for j in arm:
            h.append(T[:3, 2])
            o.append(T[:3, 3])
            T = T @ dh(j["dh"])
        plate = T[:3, 3]
        own = frame(cell["tool"]["flange_to_tool"]) if tool is None else tool
        tip = T @ frame(cell["kinematics"]["wrist_to_flange"]) @ own
        self.lower, self.upper = np.array([self._limits(j) for j in arm]).T
        self.sense = np.sign(h[1][1]), np.sign(h[2][1])
        lean = [
            abs(h[1] @ [1, 0, 0]),
            abs(h[1] @ [0, 0, 1]),
            np.linalg.norm(np.cross(h[1], h[2])),
            abs(o[1][1]),
            abs(o[2][1]),
        ]
        wrist = o[4]
        lean += [
            np.linalg.norm(np.cross(h[3], wrist - o[3])),
            np.linalg.norm(np.cross(h[5], wrist - o[5])),
            abs(wrist[1]),
        ]
        lean += [abs(h[3] @ h[4]), abs(h[4] @ h[5]), np.linalg.norm(np.cross(h[0], [0, 0, 1])), abs(h[3][1])]
        if len(arm) != _JOINTS or len(self.outer) not in (1, 2) or max(lean) > _SAME:
            raise ValueError("not a machine that is covered")
        self.x2, self.z2 = o[1][0], o[1][2]
        self.up, self.fore = (o[2] - o[1])[[0, 2]], (wrist - o[2])[[0, 2]]
        f, g = self.fore / np.linalg.norm(self.fore), h[3][[0, 2]]
        self.h4 = f @ g, f[0] * g[1] - f[1] * g[0]  # axis 4 along the forearm, and a quarter on
        self.R = tip[:3, :3]
        self.wrist, self.sixth, self.plate = (
            self.R.T @ (wrist - tip[:3, 3]),
            self.R.T @ h[5],
            self.R.T @ (plate - wrist),
        )
        self.zero5 = np.arctan2(h[4] @ np.cross(h[5], h[3]), h[5] @ h[3])

    @staticmethod
    def _limits(j: dict[str, Any]) -> Array:
        low, high = j["limits"]["range_deg"]
        q = [(v - j["axis"].get("offset_deg", 0.0)) / j["axis"]["sign"] for v in (low, high)]
        return np.asarray(np.radians(sorted(q)))

    def range_of(self, i: int) -> tuple[float, float]:
        """From where to where external axis i goes, m or rad; a turn about 0 where it is endless."""
        j = self.outer[i]
        if j["limits"].get("endless", False):
            return -np.pi, np.pi
        if j["type"] != "prismatic":
            low, high = self._limits(j)
            return float(low), float(high)
        values = [(v - j["axis"].get("offset_mm", 0.0)) / j["axis"]["sign"] / _MM for v in j["limits"]["range_mm"]]
        return min(values), max(values)

    def seen(self, tip: Array, axis: Array, middle: Array, half: Array) -> tuple[Array, Bools]:
        """Forms (N, 5): radius, height, axis along the radius, across it, up; of poses (N, 3) all over cells, symbols 0 and 1."""
        B = np.linalg.inv(self.base)
        p = [constant(tip @ B[i, :3] + B[i, 3]) for i in range(3)]
        z = [constant(axis @ B[i, :3]) for i in range(3)]
        for i, j in enumerate(self.outer):
            u = constant(middle[:, i])
            u[:, 1 + i] = half[i]
            if j["type"] == "prismatic":
                p = [p[0], p[1], minus(p[2], u)]
            else:
                c, s = turned(u)
                p, z = (
                    [plus(times(c, v[0]), times(s, v[1])), minus(times(c, v[1]), times(s, v[0])), v[2]] for v in (p, z)
                )
            A = np.asarray(np.linalg.inv(dh(j["dh"])), np.float64)
            p = [shifted(_mixed(p, A[r, :3]), A[r, 3]) for r in range(3)]
            z = [_mixed(z, A[r, :3]) for r in range(3)]
        far = plus(times(p[0], p[0]), times(p[1], p[1]))
        low, high = bounds(far)
        near = low < NEAR * high
        low = np.where(near, 0.5 * high, low)
        radius = root(far, low, high)
        over = inverse(radius, np.sqrt(low), np.sqrt(high))
        along = times(plus(times(z[0], p[0]), times(z[1], p[1])), over)
        aside = times(minus(times(z[1], p[0]), times(z[0], p[1])), over)
        return np.stack([radius, shifted(p[2], -self.z2), along, aside, z[2]], axis=1), near
