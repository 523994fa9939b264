"""Causes that the contract names, in this author's physics. Each takes a machine, a generator, and where the instrument
stands."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import cont2discrete, lfilter

from gap.eighth_author.bodies import frame
from gap.eighth_author.ways import DT
from gap.eighth_author.world import DRIVE, LINK, Acts, Cause


def _own(m):
    return list(range(m.first, m.n))


def chosen(m, rng, count, among=None):
    """Axes by number, the first ones likelier: what they do shows more."""
    among = np.array(_own(m) if among is None else among)
    weight = np.linspace(2.0, 0.6, len(among))
    return np.sort(rng.choice(among, min(count, len(among)), replace=False, p=weight / weight.sum()))


def names(m, axes):
    return [m.names[i] for i in axes]


def _held(sign):
    """The sense of the last motion where there is none now."""
    out = sign.copy()
    rows = np.where(sign != 0, np.arange(len(sign))[:, None], 0)
    np.maximum.accumulate(rows, 0, out=rows)
    return np.take_along_axis(out, rows, 0)


def senses(run):
    """(N, n) of +-1: the sense in which each axis moved last; of poses, from the one before."""
    if run.poses:
        step = np.diff(run.c, axis=0, prepend=run.c[:1])
        return _held(np.sign(np.where(np.abs(step) > 1e-5, step, 0)))
    v = run.v
    return _held(np.sign(np.where(np.abs(v) > 1e-3 * run.machine.each("top"), v, 0)))


def mask(m, axes, values=1.0):
    out = np.zeros(m.n)
    out[list(axes)] = values
    return out


def foot_place(m):
    return m.frames(m.middle[None])[m.first][0, :3, 3]


def about(place, shift, turn):
    """(6,) of a turn about a place, and a shift, in world."""
    return np.concatenate([np.asarray(shift) - np.cross(turn, place), turn])


def still(run, x):
    """The same on all rows."""
    return np.repeat(x[None], len(run.t), 0)


def frame_base(m, rng, stand):
    """Three levelling screws at heights of their own, and an aligning pin that is off: the foot rises, tilts and turns."""
    feet = 0.4 * np.array([[1, 0], [-0.5, 0.87], [-0.5, -0.87]])
    heights = rng.normal(0, 1, 3)
    plane = np.linalg.solve(np.column_stack([np.ones(3), feet]), heights)
    turn = np.array([plane[2], -plane[1], rng.normal(0, 0.8)])
    shift = np.array([*rng.normal(0, 0.8, 2), plane[0]])
    twist = about(foot_place(m), shift, turn)
    return Cause(
        "frame_base",
        lambda run, s: Acts(twists={0: 1e-3 * s * still(run, twist)}),
        [],
        LINK,
        ("position",),
        0.1,
        3,
    )


def frame_tool(m, rng, stand):
    """Dowels that let the plate turn, a presetter that reads a length short, a chuck that runs out to one side."""
    side = rng.uniform(0, 2 * np.pi)
    away = np.linalg.norm(frame(m.tool)[:3, 3])
    twist = np.array(
        [np.cos(side), np.sin(side), rng.normal(0, 1), *rng.normal(0, 0.3, 2) / away * 0.3, rng.normal(0, 2)]
    )
    return Cause(
        "frame_tool",
        lambda run, s: Acts(twists={m.n + 1: 1e-3 * s * still(run, twist)}),
        [],
        LINK,
        ("position",),
        0.1,
        3,
    )


def frame_table(m, rng, stand):
    """A mandrel whose tailstock stands beside the headstock's axis: it leans about the headstock, which is off by less."""
    head = np.array([0, -0.9, 0])
    twist = about(head, [*rng.normal(0, 0.15, 3)], [rng.normal(0, 1), 0, rng.normal(0, 1)])
    return Cause(
        "frame_table",
        lambda run, s: Acts(table=1e-3 * s * still(run, twist)),
        ["E2"],
        LINK,
        ("position",),
        0.2,
        3,
    )


def turntable(m, rng, stand):
    """A chuck of three jaws: three lifts a turn, a mandrel that is bent once a turn, an index gear that runs out twice."""
    p, share = rng.uniform(0, 6, 4), rng.uniform(0.4, 0.8)

    def act(run, s):
        w = run.c[:, 0]
        lift = np.cos(w + p[0]) + share * np.cos(3 * w + p[1])
        side = np.sin(w + p[0]) + share * np.cos(3 * w + p[2])
        turn = 2.0 * np.sin(2 * w + p[3])
        zero = 0 * w
        return Acts(table=1e-3 * s * np.stack([side, zero, lift, 0.3 * lift, turn, 0.3 * side], 1))

    return Cause("turntable", act, ["E2"], LINK, ("position",), 0.1, 2)


def joint_offset(m, rng, stand):
    """Two motors changed and set to the vernier's marks."""
    axes = chosen(m, rng, 2)
    by = mask(m, axes, rng.uniform(0.5, 1, len(axes)) * rng.choice([-1, 1], len(axes))) * m.unit
    return Cause(
        "joint_offset",
        lambda run, s: Acts(link=s * still(run, by)),
        names(m, axes),
        LINK,
        ("position",),
        0.02,
        0.4,
    )


def geometry(m, rng, stand):
    """Every row machined to a general tolerance, which grows with its length; bores that are not square."""
    twists = {}
    for k in range(m.first, m.n):
        a = m.axes[k]
        long = (abs(a.a) + abs(a.d) + 60) / 1e3
        twists[k + 1] = np.concatenate(
            [1e-3 * np.sqrt(long) * rng.uniform(-1, 1, 3), np.radians(0.03) * rng.uniform(-1, 1, 2), [0]]
        )
    return Cause(
        "geometry",
        lambda run, s: Acts(twists={k: s * still(run, x) for k, x in twists.items()}),
        [],
        LINK,
        ("position",),
        0.1,
        3,
    )


def _catalogue(load, rated):
    """A gear's turn over its torque in three straight pieces, as catalogues have it; softest near nothing. In units of load."""
    x = np.abs(load) / rated
    piece = np.minimum(x, 0.14) + np.clip(x - 0.14, 0, 0.34) / 1.35 + np.maximum(x - 0.48, 0) / 1.7
    return np.sign(load) * piece * rated


def joint_compliance(m, rng, stand):
    """Gears that wind up by their catalogue's three stiffnesses; two axes of the most loaded."""
    load = np.abs(m.loads(m.middle + np.random.default_rng(1).uniform(-1, 1, (40, m.n)) * m.spread))
    reach = np.where(m.slides, 0.0, 1.0) * m.each("soft") * load.std(0)
    axes = np.sort(np.argsort(-reach)[: int(rng.integers(1, 3))])
    by = mask(m, axes, rng.uniform(0.6, 1, len(axes))) * m.each("soft")
    rated = 1.5 * load.max(0) + 1e-9
    return Cause(
        "joint_compliance",
        lambda run, s: Acts(link=s * by * _catalogue(m.loads(run.c), rated)),
        names(m, axes),
        LINK,
        ("load", "position"),
        0.5,
        6,
    )


def payload(m, rng, stand):
    """Another head than the one that is told, and a dress pack on the forearm that nobody told of; the told load is taken off."""
    last, fore = m.names[-1], m.names[-4]
    head = (last, m.payload * rng.choice([-0.6, 0.8]), tuple(rng.uniform(-1, 1, 3) * [80, 80, 150] + [0, 0, 120]))
    pack = (fore, 0.5 * m.payload * rng.uniform(0.3, 1), tuple(rng.uniform(-1, 1, 3) * 120))

    def act(run, s):
        return Acts(link=s * m.each("soft") * ~m.slides * (m.loads(run.c, (head, pack)) - m.loads(run.c)))

    return Cause("payload", act, [], LINK, ("load", "position"), 0.3, 1.2)


def lean(m, rng, stand):
    """Four anchors, each softer where it is drawn than where it is pressed: the foot tilts the further, the more of
    them are drawn."""
    half, pulled, spring = 0.3, rng.uniform(0.25, 0.5), 1.0
    corners = half * np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]])
    rows = np.column_stack(
        [np.ones(4), corners[:, 1], -corners[:, 0]]
    )  # rise of an anchor by (z, turn about x, turn about y)
    place = foot_place(m)

    def tilt(q):
        moment, weight = m.moment(q, place)
        push = np.column_stack([np.full(len(q), -0.15 * weight), moment[:, :2]])
        k = np.full((len(q), 4), spring)
        for _ in range(25):
            stiff = np.einsum("ki,nk,kj->nij", rows, k, rows)
            turn = np.linalg.solve(stiff, push[..., None])[..., 0]
            k = spring * np.where(turn @ rows.T > 0, pulled, 1.0)
        return turn

    rest, scale = tilt(m.middle[None])[0], 1e-4 / np.abs(tilt(m.middle[None])).max()

    def act(run, s):
        now = scale * s * (tilt(run.c) - rest)
        zero = np.zeros(len(now))
        turn = np.column_stack([now[:, 1], now[:, 2], zero])
        shift = np.column_stack([zero, zero, now[:, 0]]) - np.cross(turn, place)
        return Acts(twists={0: np.column_stack([shift, turn])})

    return Cause("lean", act, [], LINK, ("load", "position"), 1.0, 25)


def backlash(m, rng, stand):
    """Play whose oil film has to be squeezed out: a link crosses in its own time, and only while its axis moves."""
    axes = chosen(m, rng, int(rng.integers(1, 3)), range(m.first, m.n - 1))
    by, tau = mask(m, axes, rng.uniform(0.6, 1, len(axes))) * m.unit, rng.uniform(0.03, 0.15)

    def act(run, s):
        side = senses(run)
        if not run.poses:
            share = np.minimum(1, np.abs(run.v) / (0.02 * m.each("top"))) * DT / tau
            at, out = side[0], np.empty_like(side)
            for i, (to, by_) in enumerate(zip(side, share, strict=True)):
                at = at + by_ * (to - at)
                out[i] = at
            side = out
        return Acts(link=-0.5 * s * by * side)

    return Cause("backlash", act, names(m, axes), LINK, ("direction",), 0.02, 0.15)


def hysteresis(m, rng, stand):
    """Bouc's and Wen's law: a spring that yields smoothly and remembers."""
    axes = chosen(m, rng, int(rng.integers(1, 3)), range(m.first, m.n - 1))
    by, wide = mask(m, axes, rng.uniform(0.6, 1, len(axes))) * m.unit, m.spread * rng.uniform(0.05, 0.15)
    bend = rng.uniform(0.3, 0.7)

    def act(run, s):
        step = np.diff(run.c, axis=0, prepend=run.c[:1]) / wide
        z, out = np.zeros(m.n), np.empty_like(step)
        for i, d in enumerate(step):
            z = z + d - (1 - bend) * np.abs(d) * z - bend * d * np.abs(z)
            out[i] = z
        return Acts(link=-s * by * out)

    return Cause("hysteresis", act, names(m, axes), LINK, ("direction",), 0.01, 0.06)


def gear_ripple(m, rng, stand):
    """A cycloid gear's pins, one worn: as many waves a turn as pins, and the double; the harder it is loaded, the higher."""
    axes = chosen(m, rng, int(rng.integers(1, 3)), range(m.first, m.n - 1))
    pins = np.where(m.slides, 2 * np.pi / rng.uniform(0.012, 0.03, m.n), rng.integers(20, 56, m.n))
    by, phase, double = (
        mask(m, axes, rng.uniform(0.6, 1, len(axes))) * m.unit,
        rng.uniform(0, 6, (2, m.n)),
        rng.uniform(0.2, 0.5),
    )

    def act(run, s):
        load = np.abs(m.loads(run.c[:: max(1, len(run.c) // 400)]))
        share = 0.7 + 0.3 * np.abs(m.loads(run.c)) / (load.max(0) + 1e-9)
        return Acts(
            link=s * by * share * (np.sin(pins * run.c + phase[0]) + double * np.sin(2 * pins * run.c + phase[1]))
        )

    return Cause("gear_ripple", act, names(m, axes), LINK, ("position",), 0.005, 0.06)


def motor_commutation(m, rng, stand):
    """Current sensors off zero (a wave an electrical turn) and unlike one another (two): what the loop does not hold
    down, the less the faster."""
    axes = chosen(m, rng, int(rng.integers(1, 3)))
    waves = 3 * m.each("ratio") * np.where(m.slides, 2 * np.pi, 1.0)
    by, phase, second = (
        mask(m, axes, rng.uniform(0.6, 1, len(axes))) * m.unit,
        rng.uniform(0, 6, (2, m.n)),
        rng.uniform(0.3, 0.8),
    )

    def act(run, s):
        slow = 1 / (1 + (waves * run.v / (2 * np.pi * 12)) ** 2)
        return Acts(
            drive=s * by * slow * (np.sin(waves * run.c + phase[0]) + second * np.sin(2 * waves * run.c + phase[1]))
        )

    return Cause("motor_commutation", act, names(m, axes), DRIVE, ("position",), 0.005, 0.03)


def servo_lag(m, rng, stand):
    """A cascade: a position loop about a speed loop with its own reset, speed fed forward in part; each axis tuned for itself."""
    part, gain = rng.uniform(0.7, 1.3, m.n), rng.uniform(12, 35, m.n)
    w, z = 2 * np.pi * rng.uniform(18, 45), rng.uniform(0.5, 0.9)

    def act(run, s):
        out = np.empty_like(run.c)
        for i in range(m.n):
            late = max(s * part[i], 1e-6)
            kv = min(gain[i], 1 / late)
            loop = np.array([2 * z * w, w * w])  # the speed loop's answer: (2 z w s + w w) / (s s + 2 z w s + w w)
            over = np.polymul([1 - late * kv, kv], loop)
            under = np.polyadd(np.polymul([1, 0], [1, 2 * z * w, w * w]), kv * loop)
            b, a, _ = cont2discrete((over, under), DT, "bilinear")
            out[:, i] = lfilter(b[0], a, run.c[:, i] - run.c[0, i])
        return Acts(drive=out + run.c[0] - run.c)

    return Cause("servo_lag", act, names(m, range(m.n)), DRIVE, ("speed",), 0.01, 0.08)


def setpoint_delay(m, rng, stand):
    """The hand's axes hang on a second bus: a whole telegram late, and smoothed over two."""
    axes = np.arange(m.n - int(rng.integers(2, 4)), m.n)

    def act(run, s):
        rows = np.clip(np.arange(len(run.t)) - s / DT, 0, None)
        late = np.stack([np.interp(rows, np.arange(len(run.t)), x) for x in run.c.T], 1)
        return Acts(drive=mask(m, axes) * (uniform_filter1d(late, 3, axis=0, mode="nearest") - run.c))

    return Cause("setpoint_delay", act, names(m, axes), DRIVE, ("speed",), 0.01, 0.08)


NAMED = {
    f.__name__: f
    for f in (
        frame_base, frame_tool, frame_table, turntable, joint_offset, geometry, joint_compliance, payload, lean,
        backlash, hysteresis, gear_ripple, motor_commutation, servo_lag, setpoint_delay,
    )
}  # fmt: skip
