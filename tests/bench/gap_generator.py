"""Cells with true effects, made for the gap benchmark with nothing of camrob: numpy alone, a product of exponentials.

The KR15 cell's figures are typed in anew. Effects are richer than the library's (play on a 4 ms grid, a lag that steps,
link errors as Denavit-Hartenberg tolerances, a second gear harmonic, uneven compliances); some are outside the library.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

STEP = 0.004
DEG = np.pi / 180.0
G = 9.80665
AXES = ("A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2")
INSIDE = (
    "frame_base", "frame_tool", "joint_offset", "geometry", "track", "lean", "joint_compliance", "payload", "backlash",
    "servo_lag", "acceleration_error", "friction", "gear_ripple", "wrist_coupling", "thermal_drift", "latency", "cutting_force",
)  # fmt: skip
OUTSIDE = ("bent_axis", "rack_pitch", "slip", "hose", "vibration", "wrist_curve")
# rows of the arm as the paper prints them: alpha, a, d (m); signs and offsets of KUKA's axis values
ROWS = [
    (np.pi / 2, 0.300, -0.675), (0.0, 0.650, 0.0), (np.pi / 2, 0.155, 0.0),
    (np.pi / 2, 0.0, -0.600), (np.pi / 2, 0.0, 0.0), (0.3564, 0.0, -0.4434),
]  # fmt: skip
TIP = -0.1197
SIGN = np.array([1, 1, 1, 1, -1, 1.0])
SHIFT = np.array([180, 0, -90, 0, 180, 0]) * DEG  # q = SIGN * axis + SHIFT
MASSES = [  # after which row, kg, place in the row's end frame
    (1, 42.0, (-0.39, 0, 0)), (2, 48.0, (-0.06, 0.04, 0.02)), (3, 22.0, (0, 0.18, 0)), (5, 4.0, (0, 0.127, 0.341)),
    (5, 12.0, (0, 0, 0.130)),
]  # fmt: skip


def hat(w):
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def turn(w):
    angle = np.linalg.norm(w)
    if angle < 1e-14:
        return np.eye(3)
    K = hat(w / angle)
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


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
        self.screws, self.ends = [], []
        for alpha, a, d in rows:
            w, p = T[:3, 2].copy(), T[:3, 3].copy()
            self.screws.append((w, np.cross(p, w)))
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
        T = np.tile(np.eye(4), (N, 1, 1))
        found = {}
        for i, (w, v) in enumerate(self.screws):
            c, s = np.cos(q[:, i]), np.sin(q[:, i])
            K = hat(w)
            E = np.zeros((N, 4, 4))
            E[:, 3, 3] = 1
            E[:, :3, :3] = np.eye(3) + s[:, None, None] * K + (1 - c)[:, None, None] * (K @ K)
            p = np.cross(w, v)
            E[:, :3, 3] = p - E[:, :3, :3] @ p
            T = T @ E
            if i in rows:
                found[i] = T @ self.ends[i]
        return T @ self.home, found


def joints(axis):
    return SIGN * axis[:, :6] + SHIFT


NOMINAL = Arm()


def pose(axis, arm=NOMINAL, base=None, lean=None):
    """Tool poses (N, 4, 4) in world: base @ Trans(0, E1, 0) @ [lean about the foot] @ arm."""
    T, _ = arm.places(joints(axis))
    if lean is not None:
        foot = arm.foot[:3, 3]
        T = T.copy()
        R = np.stack([turn(w) for w in lean])
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


def path(rng, seconds):
    """Commanded axis values (M, 8) every 4 ms along a raster, a tour of circles, or a space curve."""
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
    e1 = rng.uniform(0.05, 0.4) * np.sin(2 * np.pi * f[3] * 0.5 * keys + ph[3])
    home = np.array([0, -90, 90, 0, 90, 0.0]) * DEG
    start = pose(np.r_[home, 0, 0][None])[0]
    targets = np.tile(start, (len(keys), 1, 1))
    for k in range(len(keys)):
        targets[k, :3, :3] = turn(np.array([tilt[0][k], tilt[1][k], tilt[2][k]])) @ start[:3, :3]
        targets[k, :3, 3] = (x[k], y[k] + 0.3 * e1[k], z[k])
    axis, error = inverse(targets, e1, home)
    if error > 1e-6 or np.abs(np.diff(axis[:, :6], axis=0)).max() > 0.6:
        return path(rng, seconds)
    axis[:, 7] = 0.3 * np.sin(2 * np.pi * keys)
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
        self.lean = None
        self.after = np.zeros((len(t), 3))
        self.delay = 0.0
        self.lag = 0.0


def play(u, width):
    out, half = np.empty(len(u)), width / 2
    x = u[0] - half * np.sign(u[min(50, len(u) - 1)] - u[0])
    for i in range(len(u)):
        x = min(max(x, u[i] - half), u[i] + half)
        out[i] = x - u[i]
    return out


def draw(name, rng, world, context):
    """A function apply(world, size) of an effect; size 1 is an ordinary amount, to be scaled afterwards."""
    command, t = world.command, world.t
    speed = np.gradient(command, STEP, axis=0)
    arm = rng.permutation(6)
    if name == "frame_base":
        v = np.r_[rng.normal(0, 4e-4, 3), rng.normal(0, 3e-4, 3)]
        return {}, lambda w, s: setattr(w, "base", rigid(s * v) @ w.base)
    if name == "frame_tool":
        v = np.r_[rng.normal(0, 4e-4, 3), rng.normal(0, 4e-4, 3)]
        return {}, lambda w, s: setattr(w, "tool", w.tool @ rigid(s * v))
    if name == "joint_offset":
        axes = arm[: rng.integers(1, 3)]
        value = rng.choice([-1, 1], len(axes)) * rng.uniform(0.5, 1.5, len(axes)) * 0.04 * DEG
        return {"axes": [AXES[a] for a in axes]}, lambda w, s: w.link.__setitem__(
            (slice(None), axes), w.link[:, axes] + s * value
        )
    if name == "geometry":
        d = rng.normal(0, 1, (6, 3)) * np.array([1.5e-4, 2e-4, 2e-4])

        def apply(w, s):
            for i in range(6):
                for k in range(3):
                    w.rows[i][k] += s * d[i, k]

        return {}, apply
    if name == "track":
        scale, bow = rng.normal(0, 2e-4), rng.normal(0, 2.5e-4, 2)

        def apply(w, s):
            e = w.command[:, 6]
            w.after[:, 1] += s * scale * e
            for k, axis in enumerate((0, 2)):
                w.after[:, axis] += s * bow[k] * (e / 0.5) ** 2

        return {}, apply
    if name == "lean":
        c = rng.uniform(0.5, 2) * 1.5e-7 * np.array([1, rng.uniform(0.7, 1.4), 0])
        M = context["moment"]
        return {}, lambda w, s: setattr(w, "lean", (0 if w.lean is None else w.lean) + s * c * M)
    if name in ("joint_compliance", "payload"):
        c = np.exp(rng.normal(0, 0.4, 6)) * 3e-6
        if name == "joint_compliance":
            c = c * (rng.random(6) < 0.6)
            c[rng.integers(1, 3)] = 3e-6
            tau = context["torque"]
        else:
            tau = context["payload"] * rng.choice([-1, 1]) * 5.0
        return {}, lambda w, s: w.link.__setitem__((slice(None), slice(0, 6)), w.link[:, :6] + s * c * tau)
    if name == "backlash":
        axes = [a for a in arm if np.ptp(command[:, a]) > 3 * DEG][: rng.integers(1, 3)]
        width = rng.uniform(0.5, 1.5, len(axes)) * 0.03 * DEG

        def apply(w, s):
            for a, b in zip(axes, width, strict=True):
                w.link[:, a] += play(w.command[:, a] + w.drive[:, a], s * b)

        return {"axes": [AXES[a] for a in axes]}, apply
    if name == "servo_lag":
        tau = rng.uniform(0.02, 0.05)

        def apply(w, s):
            u, share = w.command, STEP / max(s * tau, STEP)
            y = u[0] - (s * tau - STEP) * speed[0]
            for i in range(len(u)):
                y = y + share * (u[i] - y)
                w.drive[i] += y - u[i]

        return {}, apply
    if name == "acceleration_error":
        a = smooth(np.gradient(speed, STEP, axis=0), 9)
        return {}, lambda w, s: w.link.__setitem__((slice(None), slice(0, 6)), w.link[:, :6] - s * 3e-4 * a[:, :6])
    if name == "friction":
        axes = arm[: rng.integers(2, 5)]
        f = rng.uniform(0.5, 1.5, len(axes)) * 0.006 * DEG

        def apply(w, s):
            for a, b in zip(axes, f, strict=True):
                v = speed[:, a]
                w.drive[:, a] -= (
                    s
                    * b
                    * np.tanh(v / (0.02 * np.abs(v).mean() + 1e-9))
                    * (1 + 0.3 * np.exp(-np.abs(v) / (0.1 * np.abs(v).max() + 1e-9)))
                )

        return {"axes": [AXES[a] for a in axes]}, apply
    if name == "gear_ripple":
        axis = next((a for a in arm if np.ptp(command[:, a]) > 12 * DEG), 0)
        span = np.ptp(command[:, axis])
        order, ph = rng.uniform(2.2 * 2 * np.pi / span, 8 * 2 * np.pi / span), rng.uniform(0, 6.28, 2)
        x = command[:, axis]
        shape = np.sin(order * x + ph[0]) + 0.1 * np.sin(2 * order * x + ph[1])
        return {"axes": [AXES[axis]]}, lambda w, s: w.link.__setitem__(
            (slice(None), axis), w.link[:, axis] + s * 0.01 * DEG * shape
        )
    if name == "wrist_coupling":
        k = rng.normal(0, 1e-3, 3)

        def apply(w, s):
            w.link[:, 4] += s * k[0] * command[:, 3]
            w.link[:, 5] += s * (k[1] * command[:, 3] + k[2] * command[:, 4])

        return {}, apply
    if name == "thermal_drift":
        growth, warm = 1.5e-5 * rng.uniform(0.6, 1.4, 6), context["warm"]

        def apply(w, s):
            lengths = context["growth"]
            for i in range(6):
                w.after += s * growth[i] * warm[:, None] * lengths[i]

        return {}, apply
    if name == "latency":
        return {}, lambda w, s: setattr(w, "delay", w.delay + s * 0.01)
    if name == "cutting_force":
        c = np.exp(rng.normal(0, 0.4, 6)) * 4e-6
        tau = context["force_torque"]
        return {}, lambda w, s: w.link.__setitem__((slice(None), slice(0, 6)), w.link[:, :6] + s * c * tau)
    if name == "bent_axis":
        i, j = rng.choice(3, 2, replace=False)
        x = command[:, j]
        x = 2 * (x - x.min()) / np.ptp(x) - 1
        shape = x**2 * np.sign(x) if rng.random() < 0.5 else np.exp(-8 * x**2)
        return {"axes": [AXES[i]]}, lambda w, s: w.link.__setitem__(
            (slice(None), i), w.link[:, i] + s * 0.01 * DEG * shape
        )
    if name == "rack_pitch":
        pitch = np.ptp(command[:, 6]) / rng.uniform(3, 7)
        return {"axes": ["E1"]}, lambda w, s: w.after.__setitem__(
            (slice(None), 1), w.after[:, 1] + s * 1e-4 * np.sin(2 * np.pi * command[:, 6] / pitch)
        )
    if name == "slip":
        at, v = rng.uniform(0.3, 0.7), rng.normal(0, 1e-4, 3)
        return {}, lambda w, s: setattr(w, "after", w.after + s * v * (t > at * t[-1])[:, None])
    if name == "hose":
        x = command[:, 3] + 0.5 * command[:, 5]
        shape = np.maximum(0, x - np.quantile(x, 0.55))
        return {"axes": ["A4"]}, lambda w, s: w.link.__setitem__(
            (slice(None), [3, 4]), w.link[:, [3, 4]] + s * 0.02 * np.outer(shape, [1, 0.6]) * 0.05
        )
    if name == "vibration":
        f, v = rng.uniform(0.4, 1.2), rng.normal(0, 1e-4, 3)
        return {}, lambda w, s: setattr(w, "after", w.after + s * v * np.sin(2 * np.pi * f * t)[:, None])
    x = command[:, 4] - np.median(command[:, 4])
    return {"axes": ["A6"]}, lambda w, s: w.link.__setitem__((slice(None), 5), w.link[:, 5] + s * 1e-3 * x**2)


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
    return sampled(world.command, at), sampled(encoder, at), T


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


def moved(t, command, apply, s, at):
    """(rms m) that an effect moves the gap by."""
    plain, other = World(t, command), World(t, command)
    apply(other, s)
    a, b = show(plain, at), show(other, at)
    return float(np.sqrt(np.mean(np.sum((b[2][:, :3, 3] - a[2][:, :3, 3]) ** 2, 1))))


def scaled(t, command, apply, target, at):
    """The size at which an effect moves the TCP by target m (rms)."""
    s = 1.0
    for _ in range(4):
        size = moved(t, command, apply, s, at)
        if size < 1e-9:
            return None
        s *= target / size
    return s


def make_case(seed, kind=None, exclude=()):
    """A case: log columns, facts for LOG.toml, and the label. kind: none, one, two, three, outside; drawn where None."""
    rng = np.random.default_rng(seed)
    kind = kind or rng.choice(["none", "one", "two", "three", "outside"], p=[0.15, 0.35, 0.25, 0.10, 0.15])
    seconds, rate = rng.uniform(45, 90), rng.choice([25.0, 12.5, 62.5])
    t, command = path(rng, seconds)
    at = np.arange(0.3, t[-1] - 0.3, 1.0 / rate)
    sigma, turned = rng.uniform(0.01, 0.04) * 1e-3, rng.choice([2e-4, 1e-3, 4e-3]) * DEG
    position_only = rng.random() < 0.2
    lacks = rng.choice(["", "encoders", "setpoints"], p=[0.8, 0.1, 0.1])
    noise = sigma * np.sqrt(3)
    force = np.stack(
        [
            np.clip(80 * np.sin(2 * np.pi * f * t + p) + 60, 0, 140)
            for f, p in zip(rng.uniform(0.05, 0.3, 3), rng.uniform(0, 6, 3), strict=True)
        ],
        1,
    )
    with_force, with_temp = rng.random() < 0.4, rng.random() < 0.6
    rise, tau = rng.uniform(8, 15), rng.uniform(20, 80)
    coarse = slice(None, None, 25)
    wide = lambda f: np.stack([np.interp(t, t[coarse], c) for c in f(command[coarse]).T], 1)  # noqa: E731
    J = wide(lambda c: jacobian(c)[:, :3].reshape(len(c), -1)).reshape(-1, 3, 6)
    lengths = wide(lambda c: np.concatenate(growths(c), 1))
    context = {
        "moment": wide(moment), "torque": wide(torques), "payload": wide(lambda c: torques(c, [(5, 1.0, (0, 0, 0.13))])),
        "warm": rise * (1 - np.exp(-t / tau)), "growth": [lengths[:, 3 * i : 3 * i + 3] for i in range(6)],
        "force_torque": np.einsum("nij,ni->nj", J, force),
    }  # fmt: skip
    names = [
        n
        for n in INSIDE
        if n not in exclude and (n != "cutting_force" or with_force) and (n != "thermal_drift" or with_temp)
    ]
    if lacks == "setpoints":
        names = [n for n in names if n not in ("servo_lag", "friction")]
    count = {"none": 0, "one": 1, "two": 2, "three": 3, "outside": 0}[str(kind)]
    chosen = list(rng.choice(names, count, replace=False)) + ([str(rng.choice(OUTSIDE))] if kind == "outside" else [])
    world = World(t, command)
    label = {"kind": str(kind), "effects": {}, "noise_mm": noise * 1e3}
    for name in chosen:
        info, apply = draw(name, rng, world, context)
        target = noise * np.exp(rng.uniform(np.log(0.5 if kind != "outside" else 1.5), np.log(20)))
        s = scaled(t, command, apply, target, at)
        if s is None:
            continue
        apply(world, s)
        label["effects"][str(name)] = {"size": target / noise, **info}
    rest = [n for n in names if n not in chosen]
    total = rng.uniform(0, 0.1) * noise / np.sqrt(max(len(rest), 1))
    for name in rest:
        _, apply = draw(name, rng, world, context)
        s = scaled(t, command, apply, total, at)
        if s is not None:
            apply(world, s)
    setpoint, encoder, T = show(world, at)
    p = T[:, :3, 3] + rng.normal(0, sigma, (len(at), 3))
    bad = rng.random(len(at)) < rng.choice([0, 0.01])
    p[bad] += rng.normal(0, 1e-3, (bad.sum(), 3))
    R = np.stack([turn(w) for w in rng.normal(0, turned, (len(at), 3))]) @ T[:, :3, :3]
    columns = {"t": at, **{n: p[:, k] * 1e3 for k, n in enumerate("xyz")}}
    if not position_only:
        B = -np.arcsin(np.clip(R[:, 2, 0], -1, 1))
        columns |= {
            "a": np.arctan2(R[:, 1, 0], R[:, 0, 0]) / DEG,
            "b": B / DEG,
            "c": np.arctan2(R[:, 2, 1], R[:, 2, 2]) / DEG,
        }
    edge = np.array([1 / DEG] * 6 + [1e3, 1 / DEG])
    if lacks != "encoders":
        columns |= {n: np.round(encoder[:, k] * edge[k], 5) for k, n in enumerate(AXES)}
    if lacks != "setpoints":
        columns |= {f"c{n}": np.round(setpoint[:, k] * edge[k], 5) for k, n in enumerate(AXES)}
    if with_temp:
        columns["temp"] = 21.0 + np.interp(at, t, context["warm"])
    if with_force:
        columns |= {f"f{n}": np.interp(at, t, force[:, k]) for k, n in enumerate("xyz")}
    facts = {"sigma_mm": sigma * 1e3, "sigma_deg": turned / DEG}
    return columns, facts, label


def write_case(folder: Path, seed: int, kind=None, exclude=()) -> dict:
    """Write SEED.csv and SEED.toml into a folder; gives the label, which the folder never sees."""
    columns, facts, label = make_case(seed, kind, exclude)
    order = [n for n in ("t", *"xyzabc", *AXES, *(f"c{a}" for a in AXES), "temp", "fx", "fy", "fz") if n in columns]
    table = np.stack([columns[n] for n in order], 1)
    header = ",".join(order)
    np.savetxt(folder / f"{seed}.csv", table, fmt="%.6f", delimiter=",", header=header, comments="")
    (folder / f"{seed}.toml").write_text("".join(f"{k} = {json.dumps(v)}\n" for k, v in facts.items()))
    return label
