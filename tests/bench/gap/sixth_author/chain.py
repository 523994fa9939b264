"""A machine as Denavit-Hartenberg rows, by numpy: poses, loads of gravity, postures that reach a pose, its file."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

GRAVITY = np.array([0.0, 0.0, -9.81])


@dataclass(frozen=True)
class Joint:
    """A row Rz(theta) Tz(d) Tx(a) Rx(alpha) in mm and degrees; value = sign * q + offset."""

    name: str
    alpha: float
    a: float
    theta: float
    d: float
    slides: bool = False
    sign: int = 1
    offset: float = 0.0
    speed: float = 120.0  # degrees or mm a second, at most
    role: str = "arm"

    @property
    def unit(self) -> float:
        """SI for one of its own."""
        return 1e-3 if self.slides else np.pi / 180


@dataclass(frozen=True)
class Body:
    """A point mass in the frame in which a joint's row ends."""

    after: str
    mass: float
    centre: tuple[float, float, float]


def frame(x, y, z, a, b, c) -> np.ndarray:
    """KUKA's X, Y, Z, A, B, C in mm and degrees as a matrix in m."""
    out = np.eye(4)
    out[:3, :3] = Rotation.from_euler("ZYX", [a, b, c], degrees=True).as_matrix()
    out[:3, 3] = np.array([x, y, z]) / 1e3
    return out


def small(twist) -> np.ndarray:
    """Matrices of (translation in m, rotation vector in rad), of one or of many."""
    twist = np.asarray(twist, float)
    flat = twist.reshape(-1, 6)
    out = np.tile(np.eye(4), (len(flat), 1, 1))
    out[:, :3, :3] = Rotation.from_rotvec(flat[:, 3:]).as_matrix()
    out[:, :3, 3] = flat[:, :3]
    return out.reshape(*twist.shape[:-1], 4, 4)


def _row(theta, d, a, alpha) -> np.ndarray:
    """Rows of a whole run at once; each number may be one or many."""
    theta, d, a, alpha = np.broadcast_arrays(theta, d, a, alpha)
    c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    out = np.zeros((*theta.shape, 4, 4))
    out[..., 0, :] = np.stack([c, -s * ca, s * sa, a * c], -1)
    out[..., 1, :] = np.stack([s, c * ca, -c * sa, a * s], -1)
    out[..., 2, 1], out[..., 2, 2], out[..., 2, 3], out[..., 3, 3] = sa, ca, d, 1.0
    return out


@dataclass(frozen=True)
class Machine:
    """A chain from the workpiece's frame to the tool, and what its data sheet says besides."""

    name: str
    title: str
    joints: tuple[Joint, ...]
    home: tuple[float, ...]  # axis values of the middle of its work
    swing: tuple[float, ...]  # how far it works to either side
    tool: tuple[float, ...]
    bodies: tuple[Body, ...]
    stiff: tuple[float, ...]  # Nm/rad or N/m of each joint
    gears: tuple[float, ...]
    base: tuple[float, ...] = (0, 0, 0, 0, 0, 0)
    payload: float = 0.0
    reach: float = 1.0  # m, by which sizes are drawn
    play: float = 0.01  # degrees: a gear of its class when worn

    @cached_property
    def names(self):
        """Names of the axes, as logs have them."""
        return [j.name for j in self.joints]

    @cached_property
    def unit(self):
        """SI of a log's unit, by axis."""
        return np.array([j.unit for j in self.joints])

    @cached_property
    def arm(self):
        """Indices of the arm's axes."""
        return [k for k, j in enumerate(self.joints) if j.role == "arm"]

    @cached_property
    def turning(self):
        """Indices of the arm's axes that turn."""
        return [k for k in self.arm if not self.joints[k].slides]

    @property
    def foot(self) -> int:
        """The joint in whose end frame the arm stands, -1 for none."""
        return self.arm[0] - 1

    @property
    def table(self) -> bool:
        """The first joint turns the workpiece."""
        return self.joints[0].role == "workpiece"

    def index(self, name: str) -> int:
        """The place of an axis."""
        return self.names.index(name)

    def q(self, values):
        """Joint variables of axis values (SI both)."""
        sign = np.array([j.sign for j in self.joints])
        offset = np.array([j.offset * j.unit for j in self.joints])
        return (np.asarray(values) - offset) * sign

    def frames(self, values, twists=None, rows=None):
        """[(N, 4, 4)] before each joint, after each, and at the tip. `twists` {joint: (N, 6)} move its end frame, `rows`
        {(joint, "a" | "d" | "alpha" | "beta" | "theta"): more of it}."""
        q, twists, rows = np.atleast_2d(self.q(values)), twists or {}, rows or {}
        at = np.tile(frame(*self.base), (len(q), 1, 1))
        if -1 in twists:
            at = at @ small(twists[-1])
        before, after = [], []
        for k, j in enumerate(self.joints):
            more = {n: rows.get((k, n), 0.0) for n in ("theta", "d", "a", "alpha", "beta")}
            turn = np.radians(j.theta) + more["theta"] + (0 if j.slides else q[:, k])
            along = j.d / 1e3 + more["d"] + (q[:, k] if j.slides else 0)
            before.append(at)
            at = at @ _row(turn, along, j.a / 1e3 + more["a"], np.radians(j.alpha) + more["alpha"])
            if (k, "beta") in rows:
                at = at @ small(np.array([0, 0, 0, 0, 1.0, 0]) * np.reshape(more["beta"], (-1, 1)))
            if k in twists:
                at = at @ small(twists[k])
            after.append(at)
        at = at @ frame(*self.tool)
        if "tip" in twists:
            at = at @ small(twists["tip"])
        if "world" in twists:
            at = small(twists["world"]) @ at
        return before, after, at

    def still(self, values):
        """Axis values with the table at zero: what the world sees."""
        values = np.array(np.atleast_2d(values), float)
        if self.table:
            values[:, 0] = 0.0
        return values

    def tip(self, values):
        """The tool in world."""
        return self.frames(self.still(values))[2]

    def jacobian(self, values):
        """(N, 6, n) of the tip in world by axis values."""
        values = self.still(values)
        before, _, tip = self.frames(values)
        out = np.zeros((len(values), 6, len(self.joints)))
        for k, j in enumerate(self.joints):
            z = before[k][:, :3, 2] * j.sign
            if j.role == "workpiece":
                continue
            if j.slides:
                out[:, :3, k] = z
            else:
                out[:, :3, k] = np.cross(z, tip[:, :3, 3] - before[k][:, :3, 3])
                out[:, 3:, k] = z
        return out

    def load(self, values, bodies=None, pull=None):
        """(N, n) torque or force of gravity on each axis, in its sense; `pull` (N, 3) of each body in place of its weight."""
        values = self.still(values)
        before, after, _ = self.frames(values)
        out = np.zeros((len(values), len(self.joints)))
        for b, body in enumerate(self.bodies if bodies is None else bodies):
            at = self.index(body.after)
            p = after[at][:, :3, :3] @ (np.array(body.centre) / 1e3) + after[at][:, :3, 3]
            force = np.broadcast_to(body.mass * GRAVITY, p.shape) if pull is None else pull[b]
            for k in range(at + 1):
                j = self.joints[k]
                if j.role == "workpiece":
                    continue
                z = before[k][:, :3, 2] * j.sign
                moved = z if j.slides else np.cross(z, p - before[k][:, :3, 3])
                out[:, k] += (moved * force).sum(1)
        return out

    def centres(self, values):
        """[(N, 3)] of each body in world."""
        _, after, _ = self.frames(self.still(values))
        places = [self.index(b.after) for b in self.bodies]
        return [
            after[k][:, :3, :3] @ (np.array(b.centre) / 1e3) + after[k][:, :3, 3]
            for k, b in zip(places, self.bodies, strict=True)
        ]

    def foot_moment(self, values):
        """(N, 3) moment of gravity about the foot, in the foot's frame."""
        values = self.still(values)
        before, _, _ = self.frames(values)
        foot = before[self.arm[0]]
        moment = np.zeros((len(values), 3))
        for body, p in zip(self.bodies, self.centres(values), strict=True):
            moment += np.cross(p - foot[:, :3, 3], body.mass * GRAVITY)
        return np.einsum("nji,nj->ni", foot[:, :3, :3], moment)

    def reached(self, poses, start, rounds=40):
        """Axis values that bring the tip to `poses` by the arm alone, beginning at `start` (N, n); and where it worked."""
        v = np.array(start, float)
        arm = self.turning
        for _ in range(rounds):
            at = self.tip(v)
            turn = Rotation.from_matrix(poses[:, :3, :3] @ at[:, :3, :3].transpose(0, 2, 1)).as_rotvec()
            off = np.concatenate([poses[:, :3, 3] - at[:, :3, 3], turn], 1)
            if np.abs(off).max() < 1e-11:
                break
            j = self.jacobian(v)[:, :, arm]
            step = j.transpose(0, 2, 1) @ np.linalg.solve(j @ j.transpose(0, 2, 1) + 1e-9 * np.eye(6), off[..., None])
            v[:, arm] += np.clip(step[..., 0], -0.2, 0.2)
        return v, np.abs(off).max(1) < 1e-8


def by_exponentials(machine: Machine, values) -> np.ndarray:
    """The tip by screws about the axes of the posture q = 0, one pose at a time: the other formula."""
    screws, at, turn = [], np.array(machine.base[:3]) / 1e3, Rotation.from_euler("ZYX", machine.base[3:], degrees=True)
    for j in machine.joints:
        screws.append((turn.apply([0, 0, 1.0]), at))
        swing = Rotation.from_euler("z", j.theta, degrees=True)
        at = at + turn.apply(np.array([0, 0, j.d / 1e3]) + swing.apply([j.a / 1e3, 0, 0]))
        turn = turn * swing * Rotation.from_euler("x", j.alpha, degrees=True)
    at = at + turn.apply(np.array(machine.tool[:3]) / 1e3)
    turn = turn * Rotation.from_euler("ZYX", machine.tool[3:], degrees=True)
    for (axis, point), j, q in zip(
        reversed(screws), reversed(machine.joints), reversed(machine.q(values)), strict=True
    ):
        if j.slides:
            at = at + axis * q
        else:
            swing = Rotation.from_rotvec(axis * q)
            at, turn = swing.apply(at - point) + point, swing * turn
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = turn.as_matrix(), at
    return out


def cell_text(machine: Machine, masses: bool) -> str:
    """cell.toml of the contract, for measuring only."""
    arm = [machine.joints[k] for k in machine.arm]
    lines = ["schema = 1", f'name = "{machine.name}"', f'title = "{machine.title}"', 'standing = "assumed"', ""]
    lines += ["[kinematics]", f"base_to_first = {[float(x) for x in machine.base]}"]
    lines += [f"base_follows_table = {'true' if machine.table else 'false'}", 'standing = "assumed"', ""]
    for j in machine.joints[: machine.foot + 1]:
        row = f"alpha_deg = {j.alpha}, a_mm = {j.a}, theta_deg = {j.theta}, d_mm = {j.d}"
        off = "offset_mm" if j.slides else "offset_deg"
        lines += ["[[joint]]", f'name = "{j.name}"', f'role = "{j.role}"']
        lines += [f'type = "{"prismatic" if j.slides else "revolute"}"', f"dh = {{ {row} }}"]
        lines += [f"axis = {{ sign = {j.sign}, {off} = {j.offset} }}", 'standing = "assumed"', ""]
    lines += ["[arm]", 'convention = "standard"', f'kinds = "{"".join("P" if j.slides else "R" for j in arm)}"']
    lines += [f"signs = {[j.sign for j in arm]}", f"offsets_deg = {[float(j.offset) for j in arm]}", "dh = ["]
    lines += [f"  [{j.alpha}, {j.a}, {j.theta}, {j.d}]," for j in arm]
    lines += ["]", "", "[tool]", f"flange_to_tool = {[float(x) for x in machine.tool]}", 'standing = "assumed"', ""]
    if masses:
        lines += ["[load]", f"payload_kg = {machine.payload}", 'standing = "assumed"', ""]
        for i, b in enumerate(machine.bodies):
            lines += ["[[mass]]", f'name = "body {i + 1}"', f'after = "{b.after}"', f"mass_kg = {b.mass}"]
            lines += [f"center_mm = {[float(x) for x in b.centre]}", 'standing = "assumed"', ""]
    return "\n".join(lines)
