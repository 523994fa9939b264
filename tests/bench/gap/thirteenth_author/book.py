"""A case from its number: runs, sizes, readings, label."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from .arms import jacobian, level, nudged, placed, tip, weight
from .likeness import likenesses, without
from .odd import ODD
from .orders import INSTRUMENTS
from .orders_odd import FOREIGN, SOUND
from .orders_poses import POSES
from .orders_runs import DRIVES, PATHS
from .park import PARK
from .wear import NAMED, Change
from .work import MOVES

BOOK = (*POSES, *PATHS, *DRIVES, *FOREIGN, *SOUND)
SEED = 131_128
CAUSES = {**NAMED, **ODD}
FIRST = {"payload": 3.0, "joint_compliance": 1e-6, "cutting_force": 1e-6, "cartridge_empties": 1e-6, "lean": 1e-4}
# degrees and m, one standard deviation, beside an instrument and alone
TURNING, SLIDING = {True: 0.0002, False: 0.0015}, {True: 4e-7, False: 3e-6}


@dataclass
class Log:
    run: object
    encoders: np.ndarray
    setpoints: np.ndarray | None
    seen: np.ndarray | None  # (N, 4, 4) in the instrument's frame
    motors: np.ndarray | None
    effort: np.ndarray | None
    withheld: bool


@dataclass
class Case:
    key: int
    order: object
    logs: list
    label: dict


def changes_of(order, run, seed, key, sizes):
    out = []
    for k, (cause, size) in enumerate(zip(order.causes, sizes, strict=True)):
        rng = np.random.default_rng([seed, key, 40 + k])
        change = CAUSES[cause.name](run, run.m.of(cause.axes), rng, size, **cause.more)
        if cause.since == "after":
            change = change.times(np.full(len(run.t), float(run.name != "before")))
        elif cause.since is not None:
            change = change.times((run.part > cause.since).astype(float))
        out.append(change)
    return out


def _sum(run, parts):
    return sum(parts, np.zeros_like(run.v))


def _seams(changes, side):
    out = {}
    for c in changes:
        for name, w in getattr(c, side).items():
            out[name] = out.get(name, 0.0) + w
    return out


def _stand_on(order, run, v):
    """Values by which the tip is told in the frame that is measured in."""
    on_plate = order.sees is not None and INSTRUMENTS[order.sees].frame == "base"
    return v if on_plate else level(run.m, v)


def real(order, run, changes, rest=None):
    """Tips (N, 4, 4) that a perfect instrument would tell; encoders and links behind them (N, n)."""
    at = run.v + _sum(run, [c.drive for c in changes])
    link = _sum(run, [c.link for c in changes])
    if order.columns == "M":
        return tip(run.m, _stand_on(order, run, at + link)), at, link
    T = tip(run.m, _stand_on(order, run, at), _seams(changes, "near"), _seams(changes, "far"), link)
    if rest is not None:
        T[:, :3, 3] += rest
    for c in changes:
        for look in c.seen:
            T = T.copy()
            T[:, :3, 3] += look(T, run)
    return T, at, link


def gap_of(order, run, changes, rest=None):
    """(N, 3) m, measured less nominal, without noise."""
    T, at, _ = real(order, run, changes, rest)
    told = at if run.rests else run.v
    return (T @ run.target - tip(run.m, _stand_on(order, run, told)) @ run.target)[:, :3, 3]


def nuisance(order, run):
    """Columns (K, N, 3) of what frame, target and clock can take."""
    instrument = INSTRUMENTS.get(order.sees)
    if instrument is None:
        return []
    T = tip(run.m, _stand_on(order, run, run.v)) @ run.target
    p, out = T[:, :3, 3], []
    if instrument.frame == "unknown":
        out += [np.tile(e, (len(p), 1)) for e in np.eye(3)] + [np.cross(e, p - p.mean(axis=0)) for e in np.eye(3)]
    if instrument.target == "unknown":
        out += [T[:, :3, k] for k in range(3)]
    if not run.rests and all(c.name != "latency" for c in order.causes):
        out += [np.gradient(p, run.t, axis=0)]
    return out


def taken(order, run, gap):
    return without(nuisance(order, run), gap)


def rms(vectors):
    return float(np.sqrt(np.mean(np.sum(np.square(vectors), axis=1))))


def size_of(order, runs, seed, key, k, target):
    """The size of cause k at which it is `target` m over the judged runs, what frame, target and clock take left out."""
    size = FIRST.get(order.causes[k].name, 1e-3)
    for _ in range(9):
        sizes = [size if j == k else 0.0 for j in range(len(order.causes))]
        alone = [taken(order, r, gap_of(order, r, [changes_of(order, r, seed, key, sizes)[k]])) for r in runs]
        now = rms(np.vstack(alone))
        size *= 4.0 if now < 1e-10 else float(np.clip(target / now, 0.04, 25.0))
    return size


def leftover(run, rng):
    """What a real arm leaves and nobody names: bumps over posture, each in a direction of its own (N, 3)."""
    lo, hi = run.m.limits.T
    u = (run.v - (lo + hi) / 2) / np.where(run.m.slides, 0.5 * (hi - lo), 1.0)
    out = np.zeros((len(u), 3))
    for _ in range(9):
        way = rng.standard_normal(u.shape[1]) * 1.1 / np.sqrt(max(1, u.shape[1] / 4))
        out += np.outer(np.tanh(1.6 * np.sin(u @ way + rng.uniform(-3, 3))), rng.standard_normal(3))
    return out


def drive_leftover(run, rng):
    """What loops leave: by place, by speed in place, and by the cube of speed (N, n)."""
    u = run.v / np.where(run.m.slides, 0.25, 1.0)
    s = run.speed / run.m.tops
    out = np.zeros_like(u)
    for i in range(u.shape[1]):
        a, b, c, d = rng.uniform(0.6, 1.6, 4)
        out[:, i] = (
            0.35 * np.sin(2.6 * a * u[:, i] + 4 * b)
            + 1.2 * c * s[:, i] ** 3
            + 0.4 * s[:, i] * np.sin(d * u[:, i] + 3 * a)
        )
    return out * run.m.unit


def encoder_sigma(order, m):
    return np.where(m.slides, SLIDING[bool(order.sees)], np.radians(TURNING[bool(order.sees)]))


def noise_of(order, runs):
    """3-D rms of noise, mm."""
    instrument = INSTRUMENTS.get(order.sees)
    if instrument is not None:
        return float(np.sqrt(np.sum(np.square(instrument.sigma)) * (1 + order.wander**2)))
    J = np.vstack([jacobian(r.m, level(r.m, r.v))[:, :3] for r in runs])
    return 1000 * float(np.sqrt(np.mean(np.sum((J * encoder_sigma(order, runs[0].m)) ** 2, axis=(1, 2)))))


def runs_of(order, seed, key):
    rng = np.random.default_rng([seed, key, 1])
    m = PARK[order.machine]
    loads = order.loads or (m.load,)
    names = ["before", "after"] if order.before else [f"run{k + 1}" for k in range(len(loads))]
    loads = [*(loads if not order.before else loads * 2), *([max(loads)] if order.withheld else [])]
    free = order.sees is not None and INSTRUMENTS[order.sees].target == "unknown"
    target = placed(*(rng.uniform(-50, 50, 3) if free else np.zeros(3)))
    out = []
    for name, kg in zip([*names, "withheld"], loads, strict=False):
        run = MOVES[order.moves](m.carrying(kg), rng, **order.how)
        run.name, run.target = name, target
        if order.temp:
            hours = (run.t % 86400) / 3600 if run.dock is not None else run.t / 3600
            day = run.dock if run.dock is not None else np.zeros(len(run.t), int)
            run.temp = (
                17 + 9 * rng.uniform(0, 1, day.max() + 1)[day] + 1.5 * hours + 0.04 * rng.standard_normal(len(day))
            )
        out.append(run)
    return out


def efforts(order, run, rng):
    """Torques or currents (N, n): weight, inertia, and friction that a cause has grown."""
    if order.columns not in ("I", "T"):
        return None
    tau = weight(run.m, run.v)
    strong = np.maximum(np.abs(tau).max(axis=0), 0.06 * np.abs(tau).max() + 0.5)
    s = run.speed / run.m.tops
    rub = np.tanh(s / 0.008) * (1 + 0.5 * np.exp(-np.abs(s) / 0.06)) + 0.5 * s
    grown = np.ones_like(tau)
    for cause in order.causes:
        if cause.name == "friction" and not (cause.since == "after" and run.name == "before"):
            grown[:, run.m.of(cause.axes)] *= 1 + 1.8 * (1 - cause.more.get("fades", 0.0) * run.part[:, None])
    total = (
        tau
        + 0.14 * strong * grown * rub
        + 0.015 * strong * run.jerkless
        + 0.012 * strong * rng.standard_normal(tau.shape)
    )
    return total if order.columns == "T" else total / (strong / 4.0)


def _shaken(order, run, T, rng):
    """A reading of tips: noise white and slow."""
    instrument = INSTRUMENTS[order.sees]
    white = rng.standard_normal((len(T), 3))
    if order.wander:
        keep = np.exp(-1 / (15 if run.rests else 240))
        slow = np.empty_like(white)
        slow[0] = rng.standard_normal(3)
        for k in range(1, len(slow)):
            slow[k] = keep * slow[k - 1] + np.sqrt(1 - keep**2) * rng.standard_normal(3)
        white = white + order.wander * slow
    out = T.copy()
    if instrument.sigma_deg:
        small = np.hstack([np.zeros((len(T), 3)), np.radians(instrument.sigma_deg) * rng.standard_normal((len(T), 3))])
        out = out @ nudged(small)
    out[:, :3, 3] += np.array(instrument.sigma) / 1000 * white
    return out


def read(order, run, changes, rest, drive_rest, stand, rng):
    """One record as it is written."""
    if drive_rest is not None:
        changes = [*changes, Change(drive=drive_rest)]
    T, at, link = real(order, run, changes, rest)
    if run.goals is not None:  # the arm is led until the ball seats: then its encoders are read
        J = jacobian(run.m, run.v)[:, :3]
        off = T[:, :3, 3] - run.goals
        at = at - np.einsum("nij,ni->nj", J, np.linalg.solve(J @ J.transpose(0, 2, 1), off[:, :, None])[:, :, 0])
        T = T.copy()
        T[:, :3, 3] = run.goals
    sigma = encoder_sigma(order, run.m)
    encoders = at + (link if order.columns == "M" else 0.0) + sigma * rng.standard_normal(at.shape)
    motors = at + sigma * rng.standard_normal(at.shape) if order.columns == "M" else None
    seen = None if order.sees is None else _shaken(order, run, stand @ T @ run.target, rng)
    setpoints = None if run.rests else run.v
    return Log(run, encoders, setpoints, seen, motors, efforts(order, run, rng), run.name == "withheld")


def _stand(order, rng):
    instrument = INSTRUMENTS.get(order.sees)
    if instrument is None or instrument.frame != "unknown":
        return np.eye(4)
    T = placed(*rng.uniform(-2200, 2200, 3))
    T[:3, :3] = Rotation.from_euler(
        "ZYX", [*rng.uniform(-170, 170, 1), *rng.uniform(-3, 3, 2)], degrees=True
    ).as_matrix()
    return T


def _rests(order, runs, judged, seed, key, left):
    """Leftovers of all runs: of the tip, of the drives (None where there is none)."""
    none = [None] * len(runs)
    if not left:
        return none, none
    if order.sees is not None:
        fields = [leftover(r, np.random.default_rng([seed, key, 3])) for r in runs]
        now = rms(np.vstack([taken(order, r, f) for r, f in zip(runs, fields, strict=True) if r in judged]))
        return [left / 1000 / now * f for f in fields], none
    fields = [1e-3 * drive_leftover(r, np.random.default_rng([seed, key, 3])) for r in runs]
    now = rms(
        np.vstack([gap_of(order, r, [Change(drive=f)]) for r, f in zip(runs, fields, strict=True) if r in judged])
    )
    return none, [left / 1000 / now * f for f in fields]


def made(key, seed=SEED):
    """The case of a number."""
    order = BOOK[key]
    runs = runs_of(order, seed, key)
    judged = [r for r in runs if r.name == "withheld"] or runs
    noise = noise_of(order, judged)
    left = order.left * noise
    rests, drive_rests = _rests(order, runs, judged, seed, key, left)
    sizes = [
        size_of(order, judged, seed, key, k, c.ratio * max(left, noise) / 1000) for k, c in enumerate(order.causes)
    ]
    rng = np.random.default_rng([seed, key, 5])
    first, again = _stand(order, rng), _stand(order, rng)
    logs = []
    for run, rest, drive_rest in zip(runs, rests, drive_rests, strict=True):
        stand = again if order.before and run.name != "before" else first
        logs.append(read(order, run, changes_of(order, run, seed, key, sizes), rest, drive_rest, stand, rng))
    kept = [(r, *x) for r, *x in zip(runs, rests, drive_rests, strict=True) if r in judged]
    return Case(key, order, logs, label(key, order, kept, seed, sizes, noise, left))


def label(key, order, kept, seed, sizes, noise, left):
    """What is true of a case (dict)."""
    judged = [r for r, _, _ in kept]
    all_of, stays_of = [], []
    for run, rest, drive_rest in kept:
        changes = changes_of(order, run, seed, key, sizes)
        more = [] if drive_rest is None else [Change(drive=drive_rest)]
        nameless = [c for c, cause in zip(changes, order.causes, strict=True) if cause.where]
        all_of.append(taken(order, run, gap_of(order, run, [*changes, *more], rest)))
        stays_of.append(taken(order, run, gap_of(order, run, [*nameless, *more], rest)))
    gap, stays = (float(np.hypot(1000 * rms(np.vstack(g)), noise)) for g in (all_of, stays_of))
    causes = []
    for k, cause in enumerate(order.causes):
        mine = [changes_of(order, r, seed, key, sizes)[k] for r in judged]
        alone = [gap_of(order, r, [c]) for r, c in zip(judged, mine, strict=True)]
        mm = 1000 * rms(np.vstack([taken(order, r, g) for r, g in zip(judged, alone, strict=True)]))
        like = likenesses(
            order, judged, [nuisance(order, r) for r in judged], alone, cause, bool(np.any(mine[0].drive))
        )
        same = sorted({n for n, r in like.items() if r > 0.99 and n != cause.name} | set(cause.alike))
        causes.append(
            {
                "name": cause.name,
                "axes": list(cause.axes),
                "mm": round(mm, 4),
                "ratio": round(mm / max(left, noise), 2),
                "size": float(f"{sizes[k]:.4g}"),
                "since": cause.since,
                "alike": same,
                "usual": round(like.get(cause.name, 0.0), 3),
                "near": {n: round(r, 3) for n, r in sorted(like.items()) if r > 0.9 and n != cause.name},
                "foreign": bool(cause.where),
                "stage": cause.where[0] if cause.where else None,
                "place": list(cause.where[1]) if cause.where else None,
                "follows": list(cause.where[2]) if cause.where else None,
            }
        )
    return {
        "key": key,
        "kind": order.kind,
        "title": order.title,
        "machine": order.machine,
        "moves": order.moves,
        "sees": order.sees,
        "noise_mm": round(noise, 4),
        "left_mm": round(left, 4),
        "gap_mm": round(gap, 4),
        "removable": round(1 - stays / gap, 3),
        "wander": order.wander,
        "before": order.before,
        "withheld": order.withheld,
        "causes": causes,
        "step": order.step,
        "wrong_step": order.wrong_step,
    }
