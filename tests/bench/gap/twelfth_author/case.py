"""A case from its number: runs, sizes, readings, label. Nothing here knows camrob."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import bodies, drives
from .chains import frame, jacobian, motion, tips, weights
from .drives import Change
from .fleet import FLEET
from .moves import MOVES, Run
from .plan import INSTRUMENTS
from .shop_drives import DRIVES
from .shop_paths import PATHS
from .shop_poses import POSES
from .shop_strangers import FOREIGN, SOUND
from .strangers import STRANGERS

PLAN = (*POSES, *PATHS, *DRIVES, *FOREIGN, *SOUND)
SEED = 120_711
OF_DRIVES = """servo_lag setpoint_delay acceleration_error friction motor_commutation joint_offset joint_compliance payload
backlash hysteresis gear_ripple wrist_coupling thermal_drift cutting_force"""
OF_BODIES = """geometry frame_base frame_tool frame_table track lean turntable measurement_frame measurement_scale
measurement_drift latency early_reading"""
NAMED = {n: getattr(m, n) for m, names in ((drives, OF_DRIVES), (bodies, OF_BODIES)) for n in names.split()}
CAUSES = {**NAMED, **STRANGERS}
# degrees, one standard deviation, beside an instrument and alone; what slides has 0.5 and 2 um
ENCODER = {True: 0.0003, False: 0.001}


@dataclass
class Log:
    """One file to be: the run, what its encoders and instrument said."""

    run: Run
    encoders: np.ndarray
    setpoints: np.ndarray | None
    tip: np.ndarray | None  # (N, 4, 4) as seen, in the instrument's frame, of its target
    motors: np.ndarray | None
    currents: np.ndarray | None
    withheld: bool


@dataclass
class Case:
    key: int
    spec: object
    chain: object
    logs: list
    label: dict


def _axes(chain, names):
    return [chain.index(n) for n in names]


def changes_of(spec, run, seed, key, sizes):
    out = []
    for k, (cause, size) in enumerate(zip(spec.causes, sizes, strict=True)):
        rng = np.random.default_rng([seed, key, 70 + k])
        out.append(CAUSES[cause.name](run, _axes(run.chain, cause.axes), rng, size, **cause.more))
    return out


def _world(spec, chain, values):
    """Values whose tip is in the frame that is measured in: a table counts where the instrument stands on it, alone."""
    if spec.sees and INSTRUMENTS[spec.sees].frame == "base":
        return values
    out = values.copy()
    for i, joint in enumerate(chain.joints):
        if joint.role == "workpiece":
            out[:, i] = 0.0
    return out


def true_tips(spec, run, changes, rest=None):
    """(N, 4, 4) where the target would be seen without noise, and encoders (N, n) behind drives."""
    zero = np.zeros_like(run.values)
    qe = run.values + sum((c.drive for c in changes), zero)
    link = sum((c.link for c in changes), zero)
    twists = {}
    for change in changes:
        for name, twist in change.twists.items():
            twists[name] = twists.get(name, 0.0) + twist
    if spec.columns == "M":
        return tips(run.chain, _world(spec, run.chain, qe + link)), qe, link
    T = tips(run.chain, _world(spec, run.chain, qe), twists, link)
    if rest is not None:
        T[:, :3, 3] += rest
    for change in changes:
        for look in change.seen:
            T = look(T, run)
    return T, qe, link


def gap_of(spec, run, changes, rest=None):
    """(N, 3) measured less nominal, without noise, m."""
    T, qe, _ = true_tips(spec, run, changes, rest)
    zero = np.zeros_like(run.values)
    told = run.values + sum((c.setpoint for c in changes), zero) if has_setpoints(spec, run) else qe
    return T[:, :3, 3] - tips(run.chain, _world(spec, run.chain, told))[:, :3, 3]


def has_setpoints(spec, run):
    return not run.poses and (spec.setpoints or spec.sees is None)


def _taken(spec, run, vectors):
    """Without what an unknown frame, target and clock take of it."""
    instrument = INSTRUMENTS.get(spec.sees)
    if instrument is None:
        return vectors
    T = tips(run.chain, _world(spec, run.chain, run.values))
    columns, p = [], T[:, :3, 3]
    if instrument.frame == "unknown":
        columns += [np.tile(e, (len(p), 1)) for e in np.eye(3)] + [np.cross(e, p) for e in np.eye(3)]
    if instrument.target == "unknown":
        columns += [T[:, :3, k] for k in range(3)]
    if not run.poses and all(c.name != "latency" for c in spec.causes):
        columns += [np.gradient(p, run.t, axis=0)]
    if not columns:
        return vectors
    A = np.stack([c.ravel() for c in columns], axis=1)
    return vectors - (A @ np.linalg.lstsq(A, vectors.ravel(), rcond=1e-9)[0]).reshape(-1, 3)


def rms(vectors):
    return float(np.sqrt(np.mean(np.sum(np.square(vectors), axis=1))))


def _size(spec, runs, seed, key, k, target):
    """The size of cause k at which it is `target` (m) of the judged runs."""
    cause, size = (
        spec.causes[k],
        {"payload": 5.0, "joint_compliance": 1e-6, "cutting_force": 1e-6}.get(spec.causes[k].name, 2e-3),
    )
    for _ in range(7):
        seen = []
        for run in runs:
            rng = np.random.default_rng([seed, key, 70 + k])
            change = CAUSES[cause.name](run, _axes(run.chain, cause.axes), rng, size, **cause.more)
            seen.append(_taken(spec, run, gap_of(spec, run, [change])))
        now = rms(np.vstack(seen))
        if now < 1e-12:
            size *= 3
            continue
        size *= float(np.clip(target / now, 0.05, 20.0))
    return size


def _field(run, rng):
    """A smooth displacement over posture (N, 3), of no name: six waves of all axes."""
    u = np.where(run.chain.sliding, run.values / 0.6, run.values)
    out = np.zeros((len(u), 3))
    for _ in range(6):
        way = rng.standard_normal(u.shape[1]) * 0.75
        out += np.outer(np.sin(u @ way + rng.uniform(0, 6)), rng.standard_normal(3))
    return out


def _rest_of_drives(run, rng):
    """What drives leave that nobody names: by place and softly by speed (N, n)."""
    u = np.where(run.chain.sliding, run.values / 0.3, run.values)
    v = run.speeds / (np.array([j.speed for j in run.chain.joints]) * run.chain.unit)
    out = np.zeros_like(u)
    for i in range(u.shape[1]):
        a, b, c = rng.uniform(0.5, 1.5, 3)
        out[:, i] = (
            0.4 * np.sin(2.2 * a * u[:, i] + 5 * b)
            + 0.8 * c * v[:, i] * np.abs(v[:, i])
            + 0.3 * v[:, i] * np.cos(b * u[:, 0])
        )
    return out * run.chain.unit


def encoder_noise(spec, chain):
    return np.where(chain.sliding, 0.5e-6 if spec.sees else 2e-6, np.radians(ENCODER[bool(spec.sees)]))


def _noise_mm(spec, runs):
    instrument = INSTRUMENTS.get(spec.sees)
    if instrument is not None:
        s = np.array([v for v, d in zip(instrument.sigma_mm, "xyz", strict=True) if d in instrument.only])
        return float(np.sqrt(np.sum(s**2) * (1 + spec.wander**2)))
    J = np.vstack([jacobian(r.chain, _world(spec, r.chain, r.values))[:, :3] for r in runs])
    return 1000 * float(np.sqrt(np.mean(np.sum((J * encoder_noise(spec, runs[0].chain)) ** 2, axis=(1, 2)))))


def _runs(spec, seed, key):
    rng = np.random.default_rng([seed, key, 1])
    chain = FLEET[spec.machine]
    out = []
    for kg in spec.loads or (chain.payload,):
        out.append(MOVES[spec.moves](chain.loaded(kg), rng, **spec.how))
    if spec.withheld:
        out.append(MOVES[spec.moves](chain.loaded(max(spec.loads or (chain.payload,))), rng, **spec.how))
    for k, run in enumerate(out):
        run.name = "withheld" if spec.withheld and k == len(out) - 1 else f"run{k + 1}"
        if spec.temp:
            run.t = run.t * (5400.0 / run.t[-1])
            run.temp = 21.0 + 14.0 * (1 - np.exp(-run.t / 1500.0)) + 0.05 * rng.standard_normal(len(run.t))
    return out


def _currents(spec, run, rng):
    """Torque (N, n) of weight, inertia and friction, grown by what the plan says of the causes; as currents by a constant."""
    if not spec.columns or spec.columns == "M":
        return None
    chain = run.chain
    tau = weights(chain, run.values)
    strong = np.maximum(np.abs(tau).max(axis=0), 0.05 * np.abs(tau).max() + 2.0)
    grown = np.ones(len(chain.joints))
    for cause in spec.causes:
        if cause.name == "friction":
            grown[_axes(chain, cause.axes)] = 2.6
    v = run.speeds / (np.array([j.speed for j in chain.joints]) * chain.unit)
    rub = 0.16 * strong * grown * (np.tanh(v / 0.02) * (1 + 0.5 * np.exp(-((v / 0.08) ** 2))) + 0.5 * v)
    total = tau + rub + 0.02 * strong * run.accelerations + 0.01 * strong * rng.standard_normal(tau.shape)
    return total if spec.columns == "T" else total / (strong / 6.0)


def _read(spec, run, changes, rest, drive_rest, rng, stand, target):
    """One log as recorder and instrument wrote it."""
    changes = changes if drive_rest is None else [*changes, Change(drive=drive_rest)]
    T, qe, link = true_tips(spec, run, changes, rest)
    noise = encoder_noise(spec, run.chain)
    encoders = qe + (link if spec.columns == "M" else 0) + noise * rng.standard_normal(qe.shape)
    motors = qe + noise * rng.standard_normal(qe.shape) if spec.columns == "M" else None
    setpoints = run.values + sum((c.setpoint for c in changes), np.zeros_like(qe)) if has_setpoints(spec, run) else None
    tip, instrument = None, INSTRUMENTS.get(spec.sees)
    if instrument is not None:
        tip = stand @ T @ frame(*target)
        sigma = np.array(instrument.sigma_mm) / 1000
        white = rng.standard_normal((len(T), 3))
        if spec.wander:
            keep = np.exp(-1 / (22 if run.poses else 180))
            slow = np.empty_like(white)
            slow[0] = rng.standard_normal(3)
            for k in range(1, len(slow)):
                slow[k] = keep * slow[k - 1] + np.sqrt(1 - keep**2) * rng.standard_normal(3)
            white = white + spec.wander * slow
        if instrument.sigma_deg:
            small = np.hstack(
                [np.zeros((len(T), 3)), np.radians(instrument.sigma_deg) * rng.standard_normal((len(T), 3))]
            )
            tip = tip @ motion(small)
        tip[:, :3, 3] += sigma * white
    return Log(run, encoders, setpoints, tip, motors, _currents(spec, run, rng), run.name == "withheld")


def made(key, seed=SEED):
    """The case of a number (Case)."""
    spec = PLAN[key]
    runs = _runs(spec, seed, key)
    judged = [r for r in runs if r.name == "withheld"] or runs
    noise = _noise_mm(spec, judged)
    left = spec.leftover * noise
    rests, drive_rests = [None] * len(runs), [None] * len(runs)
    if left and spec.sees:
        rests = [_field(r, np.random.default_rng([seed, key, 3])) for r in runs]
        scale = (
            left / 1000 / rms(np.vstack([_taken(spec, r, f) for r, f in zip(runs, rests, strict=True) if r in judged]))
        )
        rests = [scale * f for f in rests]
    elif left:
        drive_rests = [_rest_of_drives(r, np.random.default_rng([seed, key, 3])) for r in runs]
        small = [Change(drive=0.01 * d) for d in drive_rests]
        scale = (
            0.01
            * left
            / 1000
            / rms(np.vstack([gap_of(spec, r, [c]) for r, c in zip(runs, small, strict=True) if r in judged]))
        )
        drive_rests = [scale * d for d in drive_rests]
    floor = max(left, noise)
    sizes = [_size(spec, judged, seed, key, k, c.ratio * floor / 1000) for k, c in enumerate(spec.causes)]
    rng = np.random.default_rng([seed, key, 5])
    instrument = INSTRUMENTS.get(spec.sees)
    free = instrument is not None and instrument.frame == "unknown"
    stand = (
        frame(*rng.uniform(-2500, 2500, 3), *rng.uniform(-170, 170, 1), *rng.uniform(-4, 4, 2)) if free else np.eye(4)
    )
    target = (
        (*rng.uniform(-60, 60, 3), 0, 0, 0) if instrument is not None and instrument.target == "unknown" else (0,) * 6
    )
    logs = []
    for run, rest, drive_rest in zip(runs, rests, drive_rests, strict=True):
        logs.append(_read(spec, run, changes_of(spec, run, seed, key, sizes), rest, drive_rest, rng, stand, target))
    chain = runs[0].chain
    return Case(
        key,
        spec,
        chain,
        logs,
        label(key, spec, judged, seed, sizes, noise, left, rests[-len(judged) :], drive_rests[-len(judged) :]),
    )


def label(key, spec, judged, seed, sizes, noise, left, rests, drive_rests):
    """What is true of a case (dict)."""
    causes, gaps, without = [], [], []
    for run, rest, drive_rest in zip(judged, rests, drive_rests, strict=True):
        all_changes = changes_of(spec, run, seed, key, sizes)
        extra = [] if drive_rest is None else [Change(drive=drive_rest)]
        foreign = [c for c, cause in zip(all_changes, spec.causes, strict=True) if cause.where]
        gaps.append(_taken(spec, run, gap_of(spec, run, [*all_changes, *extra], rest)))
        without.append(_taken(spec, run, gap_of(spec, run, [*foreign, *extra], rest)))
    gap, stays = (
        float(np.hypot(1000 * rms(np.vstack(gaps)), noise)),
        float(np.hypot(1000 * rms(np.vstack(without)), noise)),
    )
    for k, cause in enumerate(spec.causes):
        parts = []
        for run in judged:
            change = changes_of(spec, run, seed, key, sizes)[k]
            parts.append(_taken(spec, run, gap_of(spec, run, [change])))
        mm = 1000 * rms(np.vstack(parts))
        causes.append(
            {
                "name": cause.name,
                "axes": list(cause.axes),
                "mm": round(mm, 4),
                "ratio": round(mm / max(left, noise), 2),
                "size": float(f"{sizes[k]:.4g}"),
                "alike": list(cause.alike),
                "foreign": bool(cause.where),
                "stage": cause.where[0] if cause.where else None,
                "place": list(cause.where[1]) if cause.where else None,
                "follows": list(cause.where[2]) if cause.where else None,
            }
        )
    return {
        "key": key,
        "title": spec.title,
        "machine": spec.machine,
        "moves": spec.moves,
        "sees": spec.sees,
        "noise_mm": round(noise, 4),
        "left_mm": round(left, 4),
        "gap_mm": round(gap, 4),
        "removable": round(1 - stays / gap, 3),
        "wander": spec.wander,
        "withheld": spec.withheld,
        "causes": causes,
        "step": spec.step,
        "wrong_step": spec.wrong_step,
    }


__all__ = ["PLAN", "SEED", "made", "np"]
