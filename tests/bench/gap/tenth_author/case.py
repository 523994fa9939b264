"""A case: its runs as they went, its logs, its label."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .chain import frame, small
from .machines import MACHINES
from .motions import Run
from .plan import Plan
from .plan_paths import PATHS
from .plan_poses import POSES
from .truth import Cause, Field, Truth, seen

__all__ = ["PLAN", "SEED", "Case", "Log", "label", "made"]

PLAN: list[Plan] = [*POSES, *PATHS]
SEED = 1010
ENCODER_DEG, ENCODER_MM = 0.0004, 0.0008  # noise of encoders, one standard deviation
SIGMA_DEG = 0.004  # of measured orientations


@dataclass
class Log:
    """One run's file."""

    name: str
    run: Run
    truth: Truth
    pose: np.ndarray  # as the instrument gives it, with noise
    q: np.ndarray  # encoders, with noise
    motor: np.ndarray | None
    torque: np.ndarray


@dataclass
class Case:
    """All of one machine's trouble."""

    number: int
    plan: Plan
    machine: object
    causes: list[Cause]
    setup: dict
    left: Field | None
    drive_left: Field | None
    logs: list[Log] = field(default_factory=list)


def _setup(plan: Plan, machine, rng) -> dict:
    stand = frame(
        [*rng.uniform(-2500, 2500, 2), rng.uniform(-300, 900), *rng.uniform(-180, 180, 1), *rng.uniform(-4, 4, 2)]
    )
    target = machine.tool @ small(rng.uniform(-45, 45, 3), np.zeros(3)) if plan.target == "unknown" else None
    return {"frame": plan.frame, "stand": stand, "target": target}


class _DriveLeft:
    """What a real drive leaves beside: a smooth error over place, other both ways."""

    def __init__(self, machine, mm: float, rng):
        n = len(machine.joints)
        self.k, self.phase = rng.normal(0, 1.2, (4, n)), rng.uniform(0, 6.28, (2, 4, n))
        self.size = np.array([mm / 900.0 if j.kind == "R" else mm / 2 for j in machine.joints]) / 2.0
        self.unit = np.array([1.0 if j.kind == "R" else 500.0 for j in machine.joints])

    def act(self, truth: Truth) -> None:
        v = truth.v
        way = np.tanh(v / (0.05 * (np.max(np.abs(v), axis=0) + 1e-9)))
        x = truth.run.q / self.unit
        for k, p, p2 in zip(self.k, self.phase[0], self.phase[1], strict=True):
            truth.q += self.size * (np.sin(x * k + p) + 0.5 * way * np.sin(x * k + p2))


def _went(case: Case, run: Run, without=()):
    causes = [c for c in case.causes if c.name not in without]
    if case.drive_left is not None:
        beside = Cause("", "setpoint_to_encoder", (), (), case.drive_left.act, "", "")
        causes = [*causes, beside]
    left = case.left if "left" not in without else None
    return seen(case.machine, run, causes, left, case.setup)


def made(seed: int, number: int) -> Case:
    """A case by its number."""
    plan = PLAN[number]
    machine = MACHINES[plan.machine]
    rng = np.random.default_rng([seed, number])
    setup = _setup(plan, machine, rng)
    left = Field(machine, plan.left, rng) if plan.left and plan.see else None
    drive_left = _DriveLeft(machine, plan.left, rng) if plan.left and not plan.see else None
    case = Case(number, plan, machine, plan.causes(), setup, left, drive_left)
    runs = [(f"run_{k + 1}", make(machine, rng)) for k, make in enumerate(plan.runs)]
    if plan.withheld:
        runs.append(("withheld", plan.withheld(machine, rng)))
    for name, run in runs:
        case.logs.append(_log(case, name, run, rng))
    return case


def _log(case: Case, name: str, run: Run, rng) -> Log:
    truth, T, _ = _went(case, run)
    n = len(T)
    pose = T.copy()
    pose[:, :3, 3] += rng.normal(0, case.plan.sigma, (n, 3))
    if case.plan.wander:
        pose[:, :3, 3] += _wander(run.t, case.plan.wander, rng)
    pose[:, :3, :3] = pose[:, :3, :3] @ small(np.zeros(3), rng.normal(0, np.radians(SIGMA_DEG), (n, 3)))[:, :3, :3]
    if case.plan.gross:
        wild = rng.uniform(size=n) < case.plan.gross
        pose[wild, :3, 3] += rng.normal(0, 1.0, (wild.sum(), 3)) * rng.choice([2.0, 8.0, 40.0], (wild.sum(), 1))
    noise = np.array([np.radians(ENCODER_DEG) if j.kind == "R" else ENCODER_MM for j in case.machine.joints])
    q = truth.q + rng.normal(0, 1, truth.q.shape) * noise
    motor = None if truth.motor is None else truth.motor + rng.normal(0, 1, truth.q.shape) * noise
    return Log(name, run, truth, pose, q, motor, _torques(case, truth, rng))


def _wander(t: np.ndarray, mm: float, rng) -> np.ndarray:
    """A wander that forgets itself within a second and a half."""
    out, now = np.zeros((len(t), 3)), rng.normal(0, mm, 3)
    for k in range(len(t)):
        keep = np.exp(-(t[k] - t[k - 1]) / 1.5) if k else 1.0
        now = keep * now + np.sqrt(1 - keep**2) * rng.normal(0, mm, 3)
        out[k] = now
    return out


def _torques(case: Case, truth: Truth, rng) -> np.ndarray:
    """Nm of each drive: weight, dry and viscous friction, inertia, whatever a cause adds, noise."""
    m, run = case.machine, truth.run
    weight = -m.weight(truth.q, run.held) if m.masses or run.held else np.zeros(run.q.shape)
    big = 12.0 + np.max(np.abs(weight), axis=0)
    top = np.array([j.speed for j in m.joints])
    v, a = truth.v, truth.a
    dry = 0.08 * big * (np.tanh(v / (0.02 * top)) + 0.6 * v / top)
    clean = weight + dry + 0.04 * big * a / top + truth.torque
    return clean + rng.normal(0, 1, clean.shape) * 0.01 * big


def _scored(case: Case) -> list[Log]:
    held = [x for x in case.logs if x.name == "withheld"]
    return held or case.logs


def _points(case: Case, without=()) -> list[np.ndarray]:
    """Noise-free places of the scored logs; of logs without an instrument the encoders' through the nominal chain."""
    found = []
    for log in _scored(case):
        truth, T, _ = _went(case, log.run, without)
        found.append(T if case.plan.see else case.machine.frames(truth.q)[2])
    return found


def _shown(case: Case) -> slice:
    return {"flat": slice(0, 2), "along": slice(0, 1)}.get(case.plan.see, slice(0, 3))


def _taken(case: Case, d: list[np.ndarray], at: list[np.ndarray], late: bool) -> np.ndarray:
    """What frames, target and latency, where they aren't known, can't take of a displacement."""
    columns = []
    for log, T in zip(_scored(case), at, strict=True):
        n, rows = len(T), []
        if case.plan.see and case.plan.frame == "unknown":
            p = T[:, :3, 3] - T[:, :3, 3].mean(axis=0)
            rows += [np.tile(e, (n, 1)) for e in np.eye(3)] + [np.cross(e, p) / 500.0 for e in np.eye(3)]
        if case.plan.see and case.plan.target == "unknown":
            rows += [T[:, :3, k] for k in range(3)]
        if case.plan.see and late and not log.run.poses:
            rows.append(np.gradient(T[:, :3, 3], log.run.t, axis=0) / 1000.0)
        columns.append(
            np.stack(rows, 2)[:, _shown(case)] if rows else np.zeros((n, len(range(*_shown(case).indices(3))), 0))
        )
    y = np.concatenate([x[:, _shown(case)] for x in d])
    if not columns[0].shape[2]:
        return y
    X, flat = np.concatenate(columns).reshape(-1, columns[0].shape[2]), y.reshape(-1)
    return (flat - X @ np.linalg.lstsq(X, flat, rcond=None)[0]).reshape(y.shape)


def _rms(y: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.sum(y**2, axis=1)))) if len(y) else 0.0


def label(case: Case) -> dict:
    """What is known of a case, by the simulator itself."""
    whole = _points(case)
    shown = len(range(*_shown(case).indices(3)))
    noise = np.hypot(case.plan.sigma, case.plan.wander) * np.sqrt(shown) if case.plan.see else _encoder_noise(case)
    names = [c.name for c in case.causes]
    late = "latency" not in names

    def size(other, absorbed=True):
        d = [a[:, :3, 3] - b[:, :3, 3] for a, b in zip(whole, other, strict=True)]
        return _rms(_taken(case, d, whole, late) if absorbed else np.concatenate(d)[:, _shown(case)])

    if case.plan.see:
        nominal = [_went(case, log.run)[2] for log in _scored(case)]
        left = size(_points(case, ("left",))) if case.left is not None else 0.0
    else:
        nominal = [case.machine.frames(log.run.q)[2] for log in _scored(case)]
        left = _alone(case)
    gap = float(np.hypot(size(nominal), noise))
    floor = max(noise, left)
    told = []
    named = [c.name for c in case.causes if not c.foreign]
    for c in case.causes:
        mm = size(_points(case, (c.name,)))
        told.append(
            {
                "cause": c.name,
                "foreign": c.foreign,
                "axes": list(c.axes),
                "stage": c.stage,
                "follows": list(c.follows),
                "mm": round(mm, 4),
                "raw_mm": round(size(_points(case, (c.name,)), False), 4),
                "ratio": round(float(mm / floor), 2),
                "alike": list(c.alike),
                "step": c.step,
                "wrong_step": c.wrong,
            }
        )
    rest = None
    if named:
        without = _points(case, tuple(named))
        d = [a[:, :3, 3] - b[:, :3, 3] for a, b in zip(without, nominal, strict=True)]
        rest = float(np.hypot(_rms(_taken(case, d, whole, late)), noise))
    return {
        "number": case.number,
        "title": case.plan.title,
        "machine": case.plan.machine,
        "rows": [len(x.run.t) for x in case.logs],
        "poses": case.logs[0].run.poses,
        "withheld": bool(case.plan.withheld),
        "see": case.plan.see,
        "table": case.plan.table,
        "noise_mm": round(float(noise), 4),
        "left_mm": round(left, 4),
        "gap_mm": round(gap, 4),
        "removable": None if rest is None else round(1 - rest / gap, 3),
        "causes": told,
    }


def _encoder_noise(case: Case) -> float:
    rng = np.random.default_rng(1)
    noise = np.array([np.radians(ENCODER_DEG) if j.kind == "R" else ENCODER_MM for j in case.machine.joints])
    parts = []
    for log in _scored(case):
        q = log.run.q
        parts.append(
            (case.machine.frames(q + rng.normal(0, 1, q.shape) * noise)[2] - case.machine.frames(q)[2])[:, :3, 3]
        )
    return _rms(np.concatenate(parts))


def _alone(case: Case) -> float:
    """What a drive's leftover is at the tool."""
    if case.drive_left is None:
        return 0.0
    parts = []
    for log in _scored(case):
        truth = Truth(case.machine, log.run)
        case.drive_left.act(truth)
        parts.append((case.machine.frames(truth.q)[2] - case.machine.frames(log.run.q)[2])[:, :3, 3])
    return _rms(np.concatenate(parts))
