"""A case: its runs as they went, its logs with their noise, its label."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.signal import lfilter

from .fleet import FLEET
from .moves import Run
from .plan import Plan
from .robots import Robot, nudge, place
from .shop_drives import DRIVES
from .shop_more_poses import MORE_POSES
from .shop_paths import PATHS
from .shop_poses import POSES
from .stages import Cause, Leftover, Seen, look

__all__ = ["PLAN", "SEED", "Case", "Log", "label", "made"]

PLAN: list[Plan] = [*POSES, *MORE_POSES, *PATHS, *DRIVES]
SEED = 71143
ENCODER = (np.radians(0.0005), 0.0015)  # noise of turning axes (rad), of sliding ones (mm)
SIGMA_DEG = 0.005


@dataclass
class Log:
    """One run's file."""

    name: str
    run: Run
    seen: Seen
    pose: np.ndarray
    enc: np.ndarray
    motor: np.ndarray | None
    torque: np.ndarray


@dataclass
class Case:
    """All of one machine's trouble."""

    number: int
    plan: Plan
    robot: Robot
    causes: list[Cause]
    setup: dict
    left: Leftover | None
    runs: list[tuple[str, Run]]
    logs: list[Log] = field(default_factory=list)


def _setup(plan: Plan, robot: Robot, rng) -> dict:
    tip = robot.tip(np.array([robot.ready]))[0, :3, 3]
    reach = 0.5 * np.linalg.norm(tip) + 300.0
    eye = tip + np.array(
        [rng.uniform(1.0, 2.2) * reach, rng.uniform(-1.5, 1.5) * reach, rng.uniform(-0.2, 0.6) * reach]
    )
    stand = place(*rng.uniform(-3000, 3000, 3), rng.uniform(-5, 5, 3) + np.array([0, 0, rng.uniform(-180, 180)]))
    return {
        "see": plan.see,
        "frame": plan.frame,
        "set": "set" in plan.logged,
        "eye": eye,
        "oven": tip + rng.uniform(-300, 300, 3),
        "stand": stand,
        "target": plan.target,
        "offset": nudge(rng.uniform(-60, 60, 3), np.zeros(3))[0],
    }


def made(seed: int, number: int) -> Case:
    """A case by its number."""
    plan = PLAN[number]
    rng = np.random.default_rng([seed, 11, number])
    robot = FLEET[plan.machine]
    setup = _setup(plan, robot, rng)
    if plan.target == "unknown":
        robot = replace(robot, tool=robot.tool @ setup["offset"])
    runs = [(f"run_{k + 1}", make(robot, rng)) for k, make in enumerate(plan.runs)]
    if plan.withheld:
        runs.append(("withheld", plan.withheld(robot, rng)))
    case = Case(number, plan, robot, deepcopy(list(plan.causes)), setup, None, runs)
    for cause in case.causes:
        _sized(case, cause)
    if plan.left:
        left = Leftover(robot, rng)
        case.left = left
        for _ in range(2):
            left.scale *= plan.left / max(_size(case, [], left), 1e-9)
    case.logs = [_log(case, name, run, rng) for name, run in runs]
    return case


def _sized(case: Case, cause: Cause) -> None:
    """Find the size that makes so many mm of it."""
    cause.size = cause.unit
    for _ in range(9):
        now = _size(case, [cause], None)
        cause.size *= float(np.clip(cause.mm / max(now, 1e-9), 0.02, 50.0))


def _size(case: Case, causes, left) -> float:
    whole = [look(case.robot, r, causes, left, case.setup) for _, r in _scored(case)]
    none = [look(case.robot, r, [], None, case.setup) for _, r in _scored(case)]
    return _rms(_taken(case, [_off(case, a, b) for a, b in zip(whole, none, strict=True)], none, causes))


def _scored(case: Case) -> list[tuple[str, Run]]:
    held = [x for x in case.runs if x[0] == "withheld"]
    return held or case.runs


def _off(case: Case, a: Seen, b: Seen | None = None) -> np.ndarray:
    """What two truths differ by (or one and its nominal), as far as the instrument sees it: (N, 3)."""
    if not case.plan.see:
        if b is None:
            return case.robot.tip(a.enc)[:, :3, 3] - case.robot.tip(a.set)[:, :3, 3]
        return case.robot.tip(a.enc)[:, :3, 3] - case.robot.tip(b.enc)[:, :3, 3]
    d = a.pose[:, :3, 3] - (a.nominal if b is None else b.pose)[:, :3, 3]
    if b is not None and not case.setup["set"]:  # the reference moves with the encoders
        d = d - (a.nominal - b.nominal)[:, :3, 3]
    return shown(case, d, a)


def shown(case: Case, d: np.ndarray, seen: Seen) -> np.ndarray:
    """The part of a displacement that the instrument sees."""
    see = case.plan.see
    if see == "ball":
        p = seen.nominal[:, :3, 3]
        out = p - 0.5 * (p.max(axis=0) + p.min(axis=0))
        flat = np.ptp(p, axis=0) < 1.0
        out[:, flat] = 0.0
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        return out * np.sum(out * d, axis=1, keepdims=True)
    keep = {"gauge": [2], "flat": [0, 1]}.get(see)
    if keep is not None:
        mask = np.zeros(3)
        mask[keep] = 1.0
        return d * mask
    if see == "probe":
        mask = np.zeros(d.shape)
        mask[np.arange(len(d)), touched(len(d))] = 1.0
        return d * mask
    return d


def touched(n: int) -> np.ndarray:
    """Which face a probe touches in each row."""
    return np.array([0, 1, 2, 2, 0, 1, 2])[np.arange(n) % 7]


def _taken(case: Case, d: list[np.ndarray], seen: list[Seen], causes) -> np.ndarray:
    """What frames, target and latency, where they aren't known, can't take of a displacement."""
    y = np.concatenate(d)
    if not case.plan.see:
        return y
    columns = []
    late = not any(c.name == "latency" for c in causes)
    for x, (_, run) in zip(seen, _scored(case), strict=True):
        T, rows = x.nominal, []
        p = T[:, :3, 3] - T[:, :3, 3].mean(axis=0)
        if case.plan.frame == "unknown":
            rows += [np.tile(e, (len(T), 1)) for e in np.eye(3)] + [np.cross(e, p) / 500 for e in np.eye(3)]
        if case.plan.target == "unknown":
            rows += [T[:, :3, k] for k in range(3)]
        if late and not run.poses:
            rows.append(np.gradient(T[:, :3, 3], x.t, axis=0) / 1000)
        columns.append(np.stack([shown(case, r, x) for r in rows], 2) if rows else np.zeros((len(T), 3, 0)))
    X = np.concatenate(columns)
    if not X.shape[2]:
        return y
    A, flat = X.reshape(-1, X.shape[2]), y.reshape(-1)
    return (flat - A @ np.linalg.lstsq(A, flat, rcond=None)[0]).reshape(y.shape)


def _rms(y: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.sum(y**2, axis=1))))


def _wandering(t, mm, forget, rng) -> np.ndarray:
    step = float(np.median(np.diff(t)))
    keep = np.exp(-step / forget)
    white = rng.normal(0, mm * np.sqrt(1 - keep**2), (len(t), 3))
    white[0] = rng.normal(0, mm, 3)
    return lfilter([1], [1, -keep], white, axis=0)


def _log(case: Case, name: str, run: Run, rng) -> Log:
    plan, robot = case.plan, case.robot
    seen = look(robot, run, case.causes, case.left, case.setup)
    n = len(seen.t)
    noise = rng.normal(0, 1, (n, 3)) * np.array(plan.sigma)
    if plan.wander:
        noise += _wandering(seen.t, plan.wander, plan.forget, rng)
    if plan.gross:
        wild = rng.uniform(size=n) < plan.gross
        noise[wild] += rng.normal(0, 1, (wild.sum(), 3)) * rng.choice([3.0, 12.0, 60.0], (wild.sum(), 1))
    pose = seen.pose.copy()
    d = pose[:, :3, 3] - seen.nominal[:, :3, 3]
    pose[:, :3, 3] = seen.nominal[:, :3, 3] + shown(case, d, seen) + shown(case, noise, seen)
    pose[:, :3, :3] = pose[:, :3, :3] @ nudge(np.zeros(3), rng.normal(0, np.radians(SIGMA_DEG), (n, 3)))[:, :3, :3]
    if plan.frame == "unknown":
        pose = case.setup["stand"] @ pose
    if plan.lost:
        pose[rng.uniform(size=n) < plan.lost, :3, 3] = np.nan
    counts = np.array([ENCODER[1] if j.slides else ENCODER[0] for j in robot.joints])
    enc = robot.with_rods(seen.enc + rng.normal(0, 1, seen.enc.shape) * counts)
    motor = None if seen.motor is None else seen.motor + rng.normal(0, 0.3, seen.motor.shape) * counts
    return Log(name, run, seen, pose, enc, motor, _torques(case, run, seen, rng))


def _torques(case: Case, run: Run, seen: Seen, rng) -> np.ndarray:
    """What the drives give: weight, dry and viscous friction, inertia, what a cause adds, noise."""
    robot = case.robot
    weight = -robot.load(seen.set, run.held)
    big = 6.0 + np.max(np.abs(weight), axis=0)
    v = run.speed[seen.rows] / robot.speeds
    a = np.gradient(v, seen.t, axis=0) if not run.poses else 0 * v
    dry = 0.1 * big * (np.tanh(v / 0.01) * (1 + 0.4 * np.exp(-((v / 0.03) ** 2))) + 0.8 * v)
    return weight + dry + 0.05 * big * a + seen.torque + rng.normal(0, 1, weight.shape) * 0.012 * big


def _noise(case: Case) -> float:
    plan = case.plan
    if not plan.see:
        J = case.robot.jacobian(np.concatenate([r.q[::7] for _, r in _scored(case)]))[:, :3]
        e = np.array([ENCODER[1] if j.slides else ENCODER[0] for j in case.robot.joints])
        return float(np.sqrt(np.mean(np.sum((J * e) ** 2, axis=(1, 2)))))
    s = np.sqrt(np.array(plan.sigma) ** 2 + plan.wander**2)
    part = {"gauge": s[2:], "flat": s[:2], "ball": s[:1], "probe": [np.sqrt(np.mean(s**2))]}.get(plan.see, s)
    return float(np.sqrt(np.sum(np.array(part) ** 2)))


def label(case: Case) -> dict:
    """What is known of a case, by the simulator itself."""
    plan, causes = case.plan, case.causes
    noise = _noise(case)

    def of(some, left=case.left):
        return [look(case.robot, r, some, left, case.setup) for _, r in _scored(case)]

    whole = of(causes)
    rest = [c for c in causes if c.foreign]
    gap = _rms(_taken(case, [_off(case, a) for a in whole], whole, causes))
    after = _rms(_taken(case, [_off(case, a) for a in of(rest)], whole, causes))
    left = _size(case, [], case.left) if case.left else 0.0
    told = []
    for c in causes:
        other = of([x for x in causes if x is not c])
        d = [_off(case, a, b) for a, b in zip(whole, other, strict=True)]
        mm = _rms(_taken(case, d, other, causes))
        told.append(
            {
                "cause": c.name,
                "axes": list(c.axes),
                "stage": c.stage,
                "follows": list(c.follows),
                "foreign": c.foreign,
                "mm": round(mm, 4),
                "raw_mm": round(_rms(np.concatenate(d)), 4),
                "ratio": round(mm / max(left, noise), 2),
                "size": float(f"{c.size:.4g}"),
                "alike": list(c.alike),
                "told": c.told,
                "step": c.step,
                "wrong_step": c.wrong_step,
            }
        )
    removable = 1 - np.hypot(after, noise) / np.hypot(gap, noise)
    return {
        "number": case.number,
        "title": plan.title,
        "machine": case.robot.name,
        "sheet": plan.sheet,
        "see": plan.see or "nothing",
        "noise_mm": round(noise, 4),
        "left_mm": round(left, 4),
        "gap_mm": round(gap, 4),
        "removable": round(float(removable), 3),
        "poses": bool(case.runs[0][1].poses),
        "withheld": plan.withheld is not None,
        "correlated": bool(plan.wander),
        "rows": [len(x.seen.t) for x in case.logs],
        "causes": told,
    }
