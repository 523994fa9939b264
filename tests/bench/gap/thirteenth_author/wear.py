"""What wears, yields, was set or fitted wrongly, where it has a usual name: a function a cause.

Each takes a run, the indices of its axes, draws, and a size in its own unit; they give a Change.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from .arms import jacobian, moment_at, weight


@dataclass
class Change:
    """Added to encoders behind set-points, to links behind encoders, to seams of the structure, to what is seen."""

    drive: np.ndarray | float = 0.0
    link: np.ndarray | float = 0.0
    near: dict = field(default_factory=dict)
    far: dict = field(default_factory=dict)
    seen: list = field(default_factory=list)  # (T, run) -> shift (N, 3)

    def times(self, mask):
        """As it is where `mask` (N,) is 1, nothing where it is 0."""
        c = mask[:, None]
        seams = [{k: c * w for k, w in d.items()} for d in (self.near, self.far)]
        looks = [lambda T, run, f=f: c * f(T, run) for f in self.seen]
        return Change(c * self.drive, c * self.link, *seams, looks)


def put(run, axes, columns):
    out = np.zeros_like(run.v)
    out[:, axes] = columns
    return out


def constant(run, twist):
    return np.tile(np.asarray(twist, float), (len(run.t), 1))


def smooth(x, run, tau, order=1):
    """`order` equal lags in a row that make `tau` together, settled at the first row."""
    if tau <= 0:
        return x
    a = np.exp(-(run.t[1] - run.t[0]) * order / tau)
    for _ in range(order):
        x, _ = lfilter([1 - a], [1, -a], x, axis=0, zi=a * x[:1])
    return x


def joint_offset(run, axes, rng, size, *, shares=(1.0, -0.7, 0.8)):
    """Mastered on a wrong notch, a belt set over by a tooth, counters lost (size: rad or m of the first)."""
    return Change(link=put(run, axes, size * np.array(shares[: len(axes)])))


def free_of_zeros(m, i):
    """Which of six small motions behind axis i are of its link and no zero of its own or its neighbour's."""
    alpha = m.axes[i].row[0]
    if m.axes[i].slides:
        return [0, 3, 5]
    return [0, 2, 3] + ([4] if alpha in (0, 180) else [])


def geometry(run, axes, rng, size):
    """A shim left out, a part of another casting: length, step, twist and lean of a link (size: m, mrad by 0.6 of it)."""
    far = {}
    for i in axes:
        w = np.zeros(6)
        keep = free_of_zeros(run.m, i)
        w[keep] = (np.concatenate([rng.uniform(0.5, 1, 3), 0.6 * rng.uniform(0.5, 1, 3)]) * rng.choice([-1, 1], 6))[
            keep
        ]
        far[run.m.axes[i].name] = constant(run, size * w)
    return Change(far=far)


def frame_base(run, axes, rng, size):
    """Set down again beside its old place."""
    return Change(near={"foot": constant(run, size * np.array([0.6, 0.5, -0.4, -0.3, 0.45, 0.5]))})


def frame_tool(run, axes, rng, size):
    """A tool that sits aslant in its changer."""
    return Change(far={"tool": constant(run, size * np.array([-0.5, 0.7, 0.5, 0.8, 0.9, 0.0]))})


def frame_table(run, axes, rng, size):
    """A headstock set up anew: its axis lies elsewhere on the floor."""
    return Change(far={run.m.axes[axes[0]].name: constant(run, size * np.array([0.5, 0.7, -0.3, 0.6, 0.8, 0.0]))})


def turntable(run, axes, rng, size):
    """A loose bearing: the plate swings in one direction of the floor, once and twice a turn; its encoder's ring runs out."""
    i = axes[0]
    q = run.v[:, i]
    w = np.zeros((len(q), 6))
    w[:, 0] = size * np.cos(q + 0.4)
    w[:, 3] = 0.9 * size * np.cos(2 * q - 0.5)
    w[:, 4] = 0.7 * size * np.sin(q + 1.1)
    return Change(far={run.m.axes[i].name: w}, link=put(run, axes, 0.8 * size * np.sin(q + 0.9)[:, None]))


def track(run, axes, rng, size, *, joint=0.56):
    """One length of rail laid anew: behind the joint lower, to the side and turned, on a rack of another pitch."""
    i = axes[0]
    lo, hi = run.m.limits[i]
    u = (run.v[:, i] - lo) / (hi - lo)
    past = 1 / (1 + np.exp(-(u - joint) / 0.012))
    w = np.zeros((len(u), 6))
    w[:, 0], w[:, 1], w[:, 2] = -0.8 * size * past, 0.6 * size * past, 1.5 * size * np.maximum(0, u - joint)
    w[:, 5] = 0.25 * size * past
    return Change(near={run.m.axes[i].name: w})


def lean(run, axes, rng, size):
    """Anchors that have lost their tension: the foot tilts with the moment of all weight, to the side more than to the front."""
    M = moment_at(run.m, run.v, run.m.first)
    w = np.zeros((len(M), 6))
    w[:, 3:5] = size * M[:, :2] / np.abs(M).max() * np.array([1.0, 0.7])
    return Change(near={"foot": w})


def joint_compliance(run, axes, rng, size):
    """A gear of less stiffness (size: rad/Nm of the first)."""
    return Change(link=put(run, axes, -size * (1 + 0.5 * np.arange(len(axes))) * weight(run.m, run.v)[:, axes]))


def payload(run, axes, rng, size, *, soft=3e-6):
    """More at the plate than was declared (size: kg), on gears of a known softness."""
    more = weight(run.m.carrying(run.m.load + size), run.v) - weight(run.m, run.v)
    return Change(link=put(run, axes, -soft * (1 + 0.5 * np.arange(len(axes))) * more[:, axes]))


def _passed(run):
    """Values in the order in which they are passed, and the rows among them."""
    if not run.rests:
        return run.v, np.arange(len(run.v))
    both = np.empty((2 * len(run.v), run.v.shape[1]))
    both[0::2], both[1::2] = run.came, run.v
    return both, np.arange(1, len(both), 2)


def backlash(run, axes, rng, size, *, worn=None, much=3.0):
    """Play (size: the whole of it); `worn`, a place and a width in degrees, where teeth in use have `much` of it."""
    passed, rows = _passed(run)
    out = np.zeros((len(rows), len(axes)))
    for k, i in enumerate(axes):
        q = passed[:, i]
        half = np.full(len(q), size / 2)
        if worn:
            half = half * (1 + (much - 1) * np.exp(-(((np.degrees(q) - worn[0]) / worn[1]) ** 2)))
        at, link = q[0], np.empty(len(q))
        for j in range(len(q)):
            at = min(max(at, q[j] - half[j]), q[j] + half[j])
            link[j] = at - q[j]
        out[:, k] = link[rows]
    return Change(link=put(run, axes, out))


def hysteresis(run, axes, rng, size, *, length=0.02):
    """Dahl's: behind a reversal what is lost comes back as exp(-way / length) (size: half of the loop's width)."""
    passed, rows = _passed(run)
    out = np.zeros((len(rows), len(axes)))
    for k, i in enumerate(axes):
        q = passed[:, i]
        z = np.zeros(len(q))
        for j in range(1, len(q)):
            d = q[j] - q[j - 1]
            z[j] = np.sign(d) + (z[j - 1] - np.sign(d)) * np.exp(-abs(d) / length) if d else z[j - 1]
        out[:, k] = -size * z[rows]
    return Change(link=put(run, axes, out))


def gear_ripple(run, axes, rng, size, *, waves=2.0):
    """A ring out of round, a shaft's encoder off its centre: waves by the axis's own place (size: amplitude)."""
    return Change(link=put(run, axes, size * np.cos(waves * run.v[:, axes] + 0.8)))


def wrist_coupling(run, axes, rng, size):
    """Ratios of a wrist of another build: A5 by A4, A6 by A4 and by A5 (size: of A5 by A4)."""
    a4, a5, a6 = run.m.of(("A4", "A5", "A6"))
    out = np.zeros_like(run.v)
    out[:, a5] = size * run.v[:, a4]
    out[:, a6] = -0.6 * size * run.v[:, a4] + 0.9 * size * run.v[:, a5]
    return Change(link=out)


def thermal_drift(run, axes, rng, size):
    """Links grow and gears creep with the arm's warmth (size: m of the first at the record's warmest)."""
    warm = (run.temp - run.temp[0]) / np.ptp(run.temp)
    far = {}
    for k, i in enumerate(axes):
        w = np.zeros((len(warm), 6))
        w[:, 0], w[:, 2] = size * warm * (1 - 0.3 * k), -0.4 * size * warm
        far[run.m.axes[i].name] = w
    return Change(far=far, link=put(run, axes, -0.6 * size * warm[:, None]))


def servo_lag(run, axes, rng, size, *, shares=None):
    """Loops of second order without feed-forward (size: s of the first); one fed too much has a share below 0 and leads."""
    shares = np.array(shares if shares else (1.0, 0.75, 0.6, 0.5, 0.5, 0.4)[: len(axes)])
    v = run.speed[:, axes]
    late = np.stack([smooth(v[:, [k]], run, abs(size * s), 2)[:, 0] for k, s in enumerate(shares)], axis=1)
    return Change(drive=put(run, axes, -size * shares * late))


def setpoint_delay(run, axes, rng, size):
    """Set-points that an axis gets late (size: s)."""
    late = np.stack([np.interp(run.t - size, run.t, run.v[:, i]) for i in axes], axis=1)
    return Change(drive=put(run, axes, late - run.v[:, axes]))


def acceleration_error(run, axes, rng, size):
    """Inertia that is not fed forward (size: s2), through a loop of 15 ms."""
    return Change(drive=put(run, axes, -size * smooth(run.jerkless[:, axes], run, 0.015)))


def friction(run, axes, rng, size, *, beyond=None, fades=0.0, integral=0.9):
    """Rubbing that a loop's integral takes off slowly (size: rad or m of stiction); `beyond` degrees alone; it `fades`."""
    v = run.speed[:, axes] / run.m.tops[axes]
    rub = np.tanh(v / 0.008) * (1 + 0.5 * np.exp(-np.abs(v) / 0.06)) + 0.2 * v
    if beyond is not None:
        rub = rub * (0.15 + 0.85 / (1 + np.exp(-(np.degrees(run.v[:, axes]) - beyond) / 4)))
    rub = rub * (1 - fades * run.part[:, None])
    return Change(drive=put(run, axes, -size * smooth(rub - 0.7 * smooth(rub, run, integral), run, 0.03)))


def motor_commutation(run, axes, rng, size, *, waves=60.0):
    """Torque that waves with the motor's poles: the quicker it turns, the less the loop lets through of it."""
    q, v = run.v[:, axes], run.speed[:, axes]
    return Change(drive=put(run, axes, size * np.sin(waves * q + 0.3) / (1 + np.abs(waves * v) / 25)))


def cutting_force(run, axes, rng, size):
    """Gears that give way to the force at the tool (size: rad/Nm)."""
    tau = np.einsum("nij,ni->nj", jacobian(run.m, run.v)[:, :3], run.force)[:, axes]
    return Change(link=put(run, axes, size * (1 + 0.3 * np.arange(len(axes))) * tau))


def measurement_frame(run, axes, rng, size):
    """Marks of the cell that were glued on anew."""
    shift, turn = size * np.array([-0.5, 0.8, 0.3]), size * np.array([0.3, -0.25, 0.6])
    return Change(seen=[lambda T, run: shift + Rotation.from_rotvec(turn).apply(T[:, :3, 3]) - T[:, :3, 3]])


def measurement_scale(run, axes, rng, size):
    """A yardstick that is off (size: of one), from its stand on."""
    return Change(seen=[lambda T, run: size * (T[:, :3, 3] - np.array([-1.8, 2.2, 0.9]))])


def measurement_drift(run, axes, rng, size, *, knock=None):
    """A stand that settles steadily and turns (size: m at the end), or, with `knock`, at once at that share of the record."""
    u = run.part if knock is None else 1.0 * (run.part > knock)

    def look(T, run):
        turn = Rotation.from_rotvec(np.outer(u, size * np.array([0.2, -0.15, 0.3]))).apply(T[:, :3, 3]) - T[:, :3, 3]
        return np.outer(u, size * np.array([0.6, 0.5, -0.6])) + turn

    return Change(seen=[look])


def latency(run, axes, rng, size):
    """Readings that come late (size: s)."""
    return Change(
        seen=[
            lambda T, run: np.stack([np.interp(run.t - size, run.t, T[:, k, 3]) - T[:, k, 3] for k in range(3)], axis=1)
        ]
    )


def early_reading(run, axes, rng, size):
    """A window for 'in position' that is too wide: read while a share of the way is left, of long ways more."""
    way = run.came - run.v
    return Change(link=size * way)


NAMES = """joint_offset geometry frame_base frame_tool frame_table turntable track lean joint_compliance payload backlash
hysteresis gear_ripple wrist_coupling thermal_drift servo_lag setpoint_delay acceleration_error friction motor_commutation
cutting_force measurement_frame measurement_scale measurement_drift latency early_reading"""
NAMED = {n: globals()[n] for n in NAMES.split()}
