"""A cell that may be wrong, for the gap benchmark, with nothing of camrob: numpy alone, a product of exponentials.

The KR15 cell's figures are typed in anew. `gap.draws` makes it wrong, `gap.maker` writes logs of it.
"""

from __future__ import annotations

import numpy as np

STEP = 0.004
DEG = np.pi / 180.0
G = 9.80665
AXES = ("A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2")
# rows of the arm as the paper prints them: alpha, a, d (m); signs and offsets of KUKA's axis values
ROWS = [
    (np.pi / 2, 0.300, -0.675),
    (0.0, 0.650, 0.0),
    (np.pi / 2, 0.155, 0.0),
    (np.pi / 2, 0.0, -0.600),
    (np.pi / 2, 0.0, 0.0),
    (0.3564, 0.0, -0.4434),
]
TIP = -0.1197
SIGN = np.array([1, 1, 1, 1, -1, 1.0])
SHIFT = np.array([180, 0, -90, 0, 180, 0]) * DEG  # q = SIGN * axis + SHIFT
MASSES = [  # after which row, kg, place in the row's end frame
    (1, 42.0, (-0.39, 0, 0)),
    (2, 48.0, (-0.06, 0.04, 0.02)),
    (3, 22.0, (0, 0.18, 0)),
    (5, 4.0, (0, 0.127, 0.341)),
    (5, 12.0, (0, 0, 0.130)),
]


def hat(w):
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def turn(w):
    angle = np.linalg.norm(w)
    if angle < 1e-14:
        return np.eye(3)
    K = hat(w / angle)
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def turns(v):
    """Rotations (N, 3, 3) about vectors (N, 3)."""
    angle = np.linalg.norm(v, axis=1) + 1e-300
    w = v / angle[:, None]
    K = np.zeros((len(v), 3, 3))
    K[:, 0, 1], K[:, 0, 2], K[:, 1, 2] = -w[:, 2], w[:, 1], -w[:, 0]
    K -= K.swapaxes(1, 2)
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + s * K + (1 - c) * K @ K


def rigid(v):
    T = np.eye(4)
    T[:3, 3], T[:3, :3] = v[:3], turn(np.asarray(v[3:]))
    return T


def log_rotation(R):
    v = 0.5 * np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], 1)
    s = np.linalg.norm(v, axis=1)
    c = 0.5 * (np.trace(R, axis1=1, axis2=2) - 1)
    return v * (np.arctan2(s, c) / np.maximum(s, 1e-300))[:, None]


class Arm:
    """Screws and home places of the arm on its carriage, from rows that may be off."""

    def __init__(self, rows=ROWS, tip=TIP, tool=None):
        # the foot in world at E1 = 0, z down as the paper has it: x to world -x? its axes come from the two rows before
        T = np.eye(4)
        T[:3, :3] = np.array([[-1, 0, 0], [0, 1, 0], [0, 0, -1.0]])
        T[:3, 3] = (-0.803, 0.0, -0.305)
        self.foot = T.copy()
        self.turns, self.ends = [], []  # of every row: its axis as a cross matrix, that squared, a point of it
        for alpha, a, d in rows:
            K, p = hat(T[:3, 2]), T[:3, 3].copy()
            self.turns.append((K, K @ K, p))
            A = np.eye(4)
            A[:3, :3] = turn(np.array([alpha, 0, 0]))
            A[:3, 3] = (a, 0, d)
            T = T @ A
            self.ends.append(T.copy())
        M = np.eye(4)
        M[2, 3] = tip
        self.home = T @ M if tool is None else T @ M @ tool

    def places(self, q, rows=()):
        """Tool poses (N, 4, 4) at E1 = 0 and, asked for, ends of rows."""
        N = len(q)
        R, x = np.tile(np.eye(3), (N, 1, 1)), np.zeros((N, 3))
        found = {}
        for i, (K, KK, p) in enumerate(self.turns):
            c, s = np.cos(q[:, i, None, None]), np.sin(q[:, i, None, None])
            E = np.eye(3) + s * K + (1 - c) * KK
            x = x + (R @ (p - E @ p)[..., None])[..., 0]
            R = R @ E
            if i in rows:
                found[i] = self._frame(R, x, self.ends[i])
        return self._frame(R, x, self.home), found

    @staticmethod
    def _frame(R, x, at):
        T = np.zeros((len(x), 4, 4))
        T[:, 3, 3] = 1
        T[:, :3, :3] = R @ at[:3, :3]
        T[:, :3, 3] = R @ at[:3, 3] + x
        return T


def joints(axis):
    return SIGN * axis[:, :6] + SHIFT


NOMINAL = Arm()


def pose(axis, arm=NOMINAL, base=None, lean=None):
    """Tool poses (N, 4, 4) in world: base @ Trans(0, E1, 0) @ [lean about the foot] @ arm."""
    T, _ = arm.places(joints(axis))
    if lean is not None:
        foot = arm.foot[:3, 3]
        T = T.copy()
        R = turns(lean)
        T[:, :3, 3] = np.einsum("nij,nj->ni", R, T[:, :3, 3] - foot) + foot
        T[:, :3, :3] = R @ T[:, :3, :3]
    T[:, 1, 3] += axis[:, 6]
    return T if base is None else base @ T


def jacobian(axis):
    """(N, 6, 6) motion of the tool (v, w) in world per radian of KUKA's axes, by differences."""
    J = np.zeros((len(axis), 6, 6))
    for i in range(6):
        up, down = axis.copy(), axis.copy()
        up[:, i] += 1e-6
        down[:, i] -= 1e-6
        a, b = pose(up), pose(down)
        J[:, :3, i] = (a[:, :3, 3] - b[:, :3, 3]) / 2e-6
        J[:, 3:, i] = log_rotation(a[:, :3, :3] @ b[:, :3, :3].swapaxes(1, 2)) / 2e-6
    return J


def energy(axis, masses):
    _, ends = NOMINAL.places(joints(axis), tuple({m[0] for m in masses}))
    return sum(m * G * (ends[i] @ np.array([*p, 1.0]))[:, 2] for i, m, p in masses)


def torques(axis, masses=MASSES):
    out = np.zeros((len(axis), 6))
    for i in range(6):
        up, down = axis.copy(), axis.copy()
        up[:, i] += 1e-4
        down[:, i] -= 1e-4
        out[:, i] = -(energy(up, masses) - energy(down, masses)) / 2e-4
    return out


def moment(axis):
    _, ends = NOMINAL.places(joints(axis), tuple({m[0] for m in MASSES}))
    foot = NOMINAL.foot[:3, 3]
    total = np.zeros((len(axis), 3))
    for i, m, p in MASSES:
        total += np.cross((ends[i] @ np.array([*p, 1.0]))[:, :3] - foot, [0, 0, -m * G])
    return total


def inverse(targets, e1, guess):
    """Axis values (N, 8) by damped Newton steps, all samples at once."""
    axis = np.zeros((len(targets), 8))
    axis[:, :6], axis[:, 6] = guess, e1
    for _ in range(60):
        T = pose(axis)
        e = np.concatenate(
            [targets[:, :3, 3] - T[:, :3, 3], log_rotation(targets[:, :3, :3] @ T[:, :3, :3].swapaxes(1, 2))], 1
        )
        J = jacobian(axis)
        JJ = J @ J.swapaxes(1, 2) + 1e-8 * np.eye(6)
        step = (J.swapaxes(1, 2) @ np.linalg.solve(JJ, e[..., None]))[..., 0]
        axis[:, :6] += np.clip(step, -0.2, 0.2)
        if np.abs(e).max() < 1e-11:
            break
    return axis, float(np.abs(e).max())


def smooth(x, n):
    kernel = np.hanning(n + 2)[1:-1]
    kernel /= kernel.sum()
    pad = np.concatenate([np.repeat(x[:1], n, 0), x, np.repeat(x[-1:], n, 0)])
    return np.stack([np.convolve(pad[:, k], kernel, "same") for k in range(x.shape[1])], 1)[n:-n]


def path(rng, seconds, table=0.3, travel=None):
    """Commanded axis values (M, 8) every 4 ms along a raster, a tour of circles, or a space curve; table: rad, travel: m of
    the track, either way."""
    keys = np.linspace(0, 1, 260)
    kind = rng.choice(["raster", "circles", "curve"])
    if kind == "raster":
        rows = rng.integers(5, 9)
        u = keys * rows
        x = 0.02 + 0.28 * np.floor(u) / rows
        y = 0.14 * (2 * np.abs((u % 2) - 1) - 1)
        z = 0.22 + 0.02 * np.cos(3 * y / 0.14)
    elif kind == "circles":
        a = 2 * np.pi * keys * rng.integers(4, 8)
        radius = 0.06 + 0.08 * np.abs(np.sin(np.pi * 2 * keys))
        x, y, z = 0.16 + radius * np.cos(a), radius * np.sin(a) * np.sign(0.5 - keys), 0.2 + 0.12 * keys
    else:
        f = rng.uniform(2, 6, 3)
        ph = rng.uniform(0, 6.28, 3)
        x, y, z = (
            c + r * np.sin(2 * np.pi * w * keys + p)
            for c, r, w, p in zip((0.16, 0, 0.25), (0.14, 0.14, 0.1), f, ph, strict=True)
        )
    f, ph = rng.uniform(1, 5, 6), rng.uniform(0, 6.28, 6)
    tilt = [0.45 * np.sin(2 * np.pi * f[k] * keys + ph[k]) for k in range(3)]
    travel = travel or rng.uniform(0.05, 0.4)
    e1 = travel * np.sin(2 * np.pi * f[3] * 0.5 * keys + ph[3])
    home = np.array([0, -90, 90, 0, 90, 0.0]) * DEG
    start = pose(np.r_[home, 0, 0][None])[0]
    targets = np.tile(start, (len(keys), 1, 1))
    for k in range(len(keys)):
        targets[k, :3, :3] = turn(np.array([tilt[0][k], tilt[1][k], tilt[2][k]])) @ start[:3, :3]
        targets[k, :3, 3] = (x[k], y[k] + 0.3 * e1[k], z[k])
    axis, error = inverse(targets, e1, home)
    if error > 1e-6 or np.abs(np.diff(axis[:, :6], axis=0)).max() > 0.6:
        return path(rng, seconds, table, travel)
    axis[:, 7] = table * np.sin(2 * np.pi * keys)
    t = np.arange(0, seconds, STEP)
    fine = np.stack([np.interp(t / seconds, keys, axis[:, k]) for k in range(8)], 1)
    return t, smooth(smooth(fine, 31), 31)


class World:
    """Everything that an effect may change, on the 4 ms grid; `shown` gives what controller and instrument log."""

    def __init__(self, t, command):
        self.t, self.command = t, command
        self.drive = np.zeros_like(command)  # encoder less command
        self.link = np.zeros_like(command)  # link less encoder
        self.rows = [list(r) for r in ROWS]
        self.base, self.tool = np.eye(4), np.eye(4)
        self.table, self.instrument = (
            np.eye(4),
            np.eye(4),
        )  # where the table's axis really is, and the instrument's frame
        self.in_base = False  # measured on the turning table
        self.lean = None
        self.after = np.zeros((len(t), 3))
        self.delay = 0.0
        self.context = {}  # by name, what effects follow along this path


def play(u, width):
    out, half = np.empty(len(u)), width / 2
    x = u[0] - half * np.sign(u[min(50, len(u) - 1)] - u[0])
    for i in range(len(u)):
        x = min(max(x, u[i] - half), u[i] + half)
        out[i] = x - u[i]
    return out


def show(world, at):
    """Set-points, encoders (M, 8) and measured poses (M, 4, 4) at times."""

    def sampled(x, when):
        return np.stack([np.interp(when, world.t, x[:, k]) for k in range(x.shape[1])], 1)

    encoder = world.command + world.drive
    when = at - world.delay
    arm = Arm([tuple(r) for r in world.rows], TIP, world.tool)
    lean = None if world.lean is None else sampled(world.lean, when)
    T = pose(sampled(encoder + world.link, when), arm, world.base, lean)
    T[:, :3, 3] += sampled(world.after, when)
    if world.in_base:
        angle = sampled((encoder + world.link)[:, 7:], when)[:, 0]
        turned = np.tile(np.eye(4), (len(at), 1, 1))
        turned[:, 0, 0] = turned[:, 1, 1] = np.cos(angle)
        turned[:, 1, 0] = np.sin(angle)
        turned[:, 0, 1] = -turned[:, 1, 0]
        T = world.table @ turned @ np.linalg.inv(world.table) @ T
    return sampled(world.command, at), sampled(encoder, at), world.instrument @ T


def growths(command):
    """How the tool moves when each row's lengths grow by one part: 6 of (M, 3)."""
    out = []
    base = pose(command)[:, :3, 3]
    for i in range(6):
        rows = [list(r) for r in ROWS]
        rows[i][1] *= 1.001
        rows[i][2] *= 1.001
        out.append((pose(command, Arm([tuple(r) for r in rows]))[:, :3, 3] - base) / 0.001)
    return out
