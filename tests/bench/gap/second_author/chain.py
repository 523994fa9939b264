"""Serial chains: Denavit-Hartenberg rows, small errors between them, gravity; and their folders in camrob's format."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

GRAVITY = np.array([0.0, 0.0, -9.81])


def place(x=0.0, y=0.0, z=0.0, a=0.0, b=0.0, c=0.0):
    """A frame from mm and degrees, R = Rz(A) Ry(B) Rx(C)."""
    out = np.eye(4)
    out[:3, :3] = Rotation.from_euler("ZYX", [a, b, c], degrees=True).as_matrix()
    out[:3, 3] = np.array([x, y, z]) / 1000.0
    return out


def turned(axis, angle):
    """A rotation about x (0) or z (2) as a frame."""
    out = np.eye(4)
    vector = np.zeros(3)
    vector[axis] = angle
    out[:3, :3] = Rotation.from_rotvec(vector).as_matrix()
    return out


def moved_by(x=0.0, z=0.0):
    """A translation in m along x and z."""
    out = np.eye(4)
    out[0, 3], out[2, 3] = x, z
    return out


def small(twist):
    """Frames (N, 4, 4) of translations and rotation vectors (N, 6)."""
    twist = np.atleast_2d(np.asarray(twist, float))
    out = np.zeros((len(twist), 4, 4))
    out[:, :3, :3] = Rotation.from_rotvec(twist[:, 3:]).as_matrix()
    out[:, :3, 3] = twist[:, :3]
    out[:, 3, 3] = 1.0
    return out


@dataclass(frozen=True)
class Row:
    """One axis: its Denavit-Hartenberg row (degrees, mm) and how the controller counts it."""

    name: str
    alpha: float
    a: float
    theta: float = 0.0
    d: float = 0.0
    kind: str = "R"
    sign: int = 1
    offset: float = 0.0
    low: float = -170.0
    high: float = 170.0
    speed: float = 150.0


@dataclass(frozen=True)
class Body:
    """A mass behind an axis, its centre in the frame in which that row ends (mm)."""

    after: str
    mass: float
    centre: tuple[float, float, float]


@dataclass
class Robot:
    """A chain from world to tool tip. `home` in controller units (degrees, mm); `known` masses are told to the diagnosis."""

    name: str
    title: str
    rows: list[Row]
    home: list[float]
    bodies: list[Body] = field(default_factory=list)
    modified: bool = False
    base: np.ndarray = field(default_factory=lambda: np.eye(4))
    after: dict[str, np.ndarray] = field(default_factory=dict)
    flange: np.ndarray = field(default_factory=lambda: np.eye(4))
    tool: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    known: bool = False
    payload: float = 5.0
    ratio: float = 100.0
    copied: str = ""
    table: str = ""

    @cached_property
    def names(self):
        """Axes in the chain's order."""
        return [r.name for r in self.rows]

    @cached_property
    def slides(self):
        """Which axes slide."""
        return np.array([r.kind == "P" for r in self.rows])

    @cached_property
    def unit(self):
        """One unit of the controller in SI, axis by axis."""
        return np.where(self.slides, 1e-3, np.pi / 180.0)

    @cached_property
    def arm(self):
        """Indices of the arm's axes."""
        return [i for i, r in enumerate(self.rows) if r.name.startswith("A")]

    @cached_property
    def carriage(self):
        """Indices of axes before the arm that slide."""
        return [i for i, r in enumerate(self.rows) if r.name.startswith("E") and r.kind == "P"]

    @cached_property
    def root(self):
        """Place of `frames` at which the robot's foot stands."""
        return 2 + self.carriage[-1] if self.carriage else 1

    @cached_property
    def _fixed(self):
        pre, post = [], []
        for r in self.rows:
            turn, shift = turned(0, np.radians(r.alpha)), moved_by(x=r.a / 1e3)
            still = turned(2, np.radians(r.theta)) @ moved_by(z=r.d / 1e3)
            pre.append(turn @ shift if self.modified and r.name.startswith("A") else np.eye(4))
            end = still if self.modified and r.name.startswith("A") else still @ shift @ turn
            post.append(end @ self.after.get(r.name, np.eye(4)))
        return pre, post

    @cached_property
    def tip(self):
        """From the last row's end to the tool tip."""
        return self.flange @ place(*self.tool)

    def q(self, values):
        """Joint variables of axis values (SI)."""
        sign = np.array([r.sign for r in self.rows], float)
        return (values - np.array([r.offset for r in self.rows]) * self.unit) * sign

    @cached_property
    def signs(self):
        """dv/dq by axis."""
        return np.array([r.sign for r in self.rows], float)

    def frames(self, values, between=None):
        """World frames (N, 4, 4): joints' frames before they turn, ends of rows, and the tool's, with small frames between.

        `between` maps a place to (N, 6): 0 world's left, 1 behind the base, 2 + i behind row i, -1 behind the tool.
        """
        values, between = np.atleast_2d(values), between or {}
        q, (pre, post) = self.q(values), self._fixed
        now = small(between[0]) @ self.base if 0 in between else np.broadcast_to(self.base, (len(q), 4, 4))
        if 1 in between:
            now = now @ small(between[1])
        axes, ends = [], []
        for i in range(len(self.rows)):
            now = now @ pre[i]
            axes.append(now)
            step = np.zeros((len(q), 4, 4))
            step[:, 3, 3] = step[:, 2, 2] = 1.0
            if self.slides[i]:
                step[:, 0, 0] = step[:, 1, 1] = 1.0
                step[:, 2, 3] = q[:, i]
            else:
                cos, sin = np.cos(q[:, i]), np.sin(q[:, i])
                step[:, 0, 0] = step[:, 1, 1] = cos
                step[:, 0, 1], step[:, 1, 0] = -sin, sin
            now = now @ (step @ post[i])
            if 2 + i in between:
                now = now @ small(between[2 + i])
            ends.append(now)
        now = now @ self.tip
        if -1 in between:
            now = now @ small(between[-1])
        return axes, ends, now

    def pose(self, values, between=None):
        """The tool's frames (N, 4, 4) in world."""
        return self.frames(values, between)[2]

    def jacobian(self, values):
        """d position / d axis value, (N, 3, n), and d rotation likewise."""
        axes, _, tip = self.frames(values)
        lin, ang = [], []
        for i, frame in enumerate(axes):
            z = frame[:, :3, 2] * self.signs[i]
            lin.append(z if self.slides[i] else np.cross(z, tip[:, :3, 3] - frame[:, :3, 3]))
            ang.append(np.zeros_like(z) if self.slides[i] else z)
        return np.stack(lin, axis=2), np.stack(ang, axis=2)

    def moments(self, values, extra=()):
        """Gravity's moments on each axis in its own frame (N, n, 3), z the joint's; of sliding axes forces."""
        axes, ends, _ = self.frames(values)
        index = {r.name: i for i, r in enumerate(self.rows)}
        out = np.zeros((len(ends[0]), len(self.rows), 3))
        for body in (*self.bodies, *extra):
            j = index[body.after]
            centre = ends[j][:, :3, :3] @ (np.array(body.centre) / 1e3) + ends[j][:, :3, 3]
            for i in range(j + 1):
                force = np.broadcast_to(GRAVITY * body.mass, centre.shape)
                push = force if self.slides[i] else np.cross(centre - axes[i][:, :3, 3], force)
                out[:, i] += np.einsum("nji,nj->ni", axes[i][:, :3, :3], push)
        return out

    def write(self, folder: Path):
        """The cell's folder: cell.toml and poses.csv."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "cell.toml").write_text(self._toml())
        rng = np.random.default_rng(7)
        spread = np.where(self.slides, 300.0, 25.0)
        rows = [np.array(self.home)] + [
            np.array(self.home) + spread * rng.uniform(-1, 1, len(spread)) for _ in range(3)
        ]
        with (folder / "poses.csv").open("w", newline="") as file:
            out = csv.writer(file)
            units = ["_mm" if s else "_deg" for s in self.slides]
            where = ["x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg"]
            out.writerow(["name", *(n + u for n, u in zip(self.names, units, strict=True)), *where, "source", "note"])
            for k, values in enumerate(rows):
                tip = self.pose(values * self.unit)[0]
                angles = Rotation.from_matrix(tip[:3, :3]).as_euler("ZYX", degrees=True)
                numbers = [f"{x:.6f}" for x in (*values, *(tip[:3, 3] * 1e3), *angles)]
                out.writerow([f"pose_{k}", *numbers, "hand", "the second author's own chain"])

    def _toml(self):
        lines = ["schema = 1", f'name = "{self.name}"', f'title = "{self.title}"', 'standing = "datasheet"', ""]
        carriages = [r for r in self.rows if r.name.startswith("E")]
        if carriages:
            numbers = [
                *(self.base[:3, 3] * 1e3),
                *Rotation.from_matrix(self.base[:3, :3]).as_euler("ZYX", degrees=True),
            ]
            still = "base_follows_table = false"
            lines += ["[kinematics]", still, "characteristic_length_mm = 500", f"base_to_first = {_list(numbers)}"]
            lines += [
                "foot_to_root = [0, 0, 0, 0, 0, 0]",
                "wrist_to_flange = [0, 0, 0, 0, 0, 0]",
                'standing = "datasheet"',
                "",
            ]
        for r in carriages:
            lines += ["[[joint]]", f'name = "{r.name}"', 'role = "carriage"', 'type = "prismatic"']
            lines += [f"dh = {{ alpha_deg = {r.alpha}, a_mm = {r.a}, theta_deg = {r.theta}, d_mm = {r.d} }}"]
            lines += [f"axis = {{ sign = {r.sign}, offset_mm = {r.offset} }}", 'standing = "datasheet"', ""]
        arm = [self.rows[i] for i in self.arm]
        lines += ["[arm]", f'convention = "{"modified" if self.modified else "standard"}"', "dh = ["]
        lines += [f"  [{r.alpha}, {r.a}, {r.theta}, {r.d}]," for r in arm]
        lines += ["]", f"signs = {[r.sign for r in arm]}", f"offsets_deg = {[float(r.offset) for r in arm]}", ""]
        lines += ["[tool]", f"flange_to_tool = {[float(x) for x in self.tool]}", 'standing = "measured"', ""]
        if self.known:
            lines += ["[load]", f"payload_kg = {self.payload}", 'standing = "datasheet"', ""]
            for k, b in enumerate(self.bodies):
                lines += ["[[mass]]", f'name = "body {k}"', f'after = "{b.after}"', f"mass_kg = {b.mass}"]
                lines += [f"center_mm = {[float(x) for x in b.centre]}", 'standing = "datasheet"', ""]
        return "\n".join(lines) + "\n"


def _list(numbers):
    return "[" + ", ".join(f"{x:.6f}" for x in numbers) + "]"
