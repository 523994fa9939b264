"""A case from a seed and a number: runs, causes and their sizes, files, and the label that says what is true."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from gap.ninth_author.arms import CELLS, Arm, euler, twist
from gap.ninth_author.kinds import FOREIGN, MOST, NAMED, Kind
from gap.ninth_author.looks import leftover, scatter
from gap.ninth_author.machines import machine
from gap.ninth_author.paths import Run, drives, handle, poses, work
from gap.ninth_author.plan import planned
from gap.ninth_author.shift import Shift, nominal, observed, rms, unabsorbed

__all__ = ["PLACE", "SEED", "Case", "Cause", "made", "write"]

SEED = 9_112_027
CARRIES = {"kr15": 15, "rx160": 20, "kr500": 200, "ur10e": 10, "long": 150, "scara": 8}  # kg
PLACE = (2.6, -2.2, 0.9)  # where the instrument stands in world, m


@dataclass
class Cause:
    """A cause at work: its kind, its key, how large it is."""

    name: str
    kind: Kind
    key: object
    axes: list
    ratio: float
    size: float = 0.0

    def shift(self, run: Run, size=None) -> Shift:
        """What it does to a run."""
        return self.kind.make(run, self.key, self.size if size is None else size)


@dataclass
class Case:
    """Runs (the last is withheld), causes, leftover and noise."""

    number: int
    plan: dict
    arm: Arm
    runs: list
    how: dict
    causes: list = field(default_factory=list)
    left: float = 0.0  # scale of the leftover
    left_mm: float = 0.0
    noise_mm: float = 0.0
    seed: int = 0

    @property
    def floor_mm(self) -> float:
        """The larger of leftover and noise."""
        return max(self.left_mm, self.noise_mm)

    def leftover(self, run) -> Shift:
        """What no cause explains."""
        return leftover(run, self.seed + 1, self.left)

    def shifts(self, run, without="") -> list:
        """All that is wrong with a run, but for one cause."""
        out = [self.leftover(run)] if self.left else []
        return out + [c.shift(run) for c in self.causes if c.name != without]

    def off(self, run, shifts, absorb=True, latency=True):
        """Displacement (N, 3) in m of the tool (of the encoders where no instrument looks) from its set-points."""
        tip, encoders, told = observed(run, shifts, self.how["frame"], PLACE)
        if run.kind == "drives":
            tip = nominal(run, "world", encoders)
        d = tip[:, :3, 3] - nominal(run, self.how["frame"], told)[:, :3, 3]
        return unabsorbed(run, d, self.how, latency) if absorb else d

    def noise(self, k):
        """The noise (N, 3) in m of run k, the same whenever it is asked for."""
        run, rng = self.runs[k], np.random.default_rng([self.seed, 77, k])
        if run.kind == "drives":
            q = self.encoders(k, run.q[run.pick])
            return nominal(run, "world", q)[:, :3, 3] - nominal(run, "world")[:, :3, 3]
        return scatter(rng, run, *(self.how[n] / 1e3 for n in ("white", "wander", "chatter")))

    def encoders(self, k, q):
        """Encoders (N, n) of run k with their own noise."""
        rng = np.random.default_rng([self.seed, 78, k])
        scale = np.array(
            [self.how["axis_mm"] / 1e3 if s else np.radians(self.how["axis_deg"]) for s in self.arm.slides]
        )
        return q + scale * rng.normal(size=q.shape)


def _runs(plan, arm, rng):
    """Two training runs (one, of poses at times) and a withheld one."""
    log = plan["log"]
    if log == "poses":
        counts = [(60, 34), (36, 24, 30), (48, 30)][int(rng.integers(3))]
        warm = np.sort(rng.uniform(0, 4, len(counts)))
        return [poses(arm, rng, n, (w, w + rng.uniform(7, 13))) for n, w in zip(counts, warm, strict=True)]
    if log == "drives":
        ticks = int(rng.integers(3, 5))
        runs = [drives(arm, rng, 950, ticks), handle(arm, rng, 600, ticks), handle(arm, rng, 650, ticks)]
        return [replace(run, kind="drives") for run in runs]
    ticks = 1 if rng.uniform() < 0.15 else int(rng.integers(2, 5))
    rows = [1500, 1200, 1000] if ticks == 1 else [800, 700, 650]
    warm = [(0.0, 2.0), (9.0, 10.5), (5.0, 7.5)]
    if log == "handle":
        return [handle(arm, rng, n, ticks, w) for n, w in zip(rows, warm, strict=True)]
    shapes = [log, {"pocket": "trim", "trim": "polish", "polish": "pocket"}[log], log]
    return [work(arm, rng, s, n, ticks, w) for s, n, w in zip(shapes, rows, warm, strict=True)]


def _how(plan, rng):
    """Instrument, frame and noise, by the plan."""
    frame = plan["frame"]
    white = float(np.exp(rng.uniform(np.log(0.012), np.log(0.035))))
    how = {
        "frame": "base" if frame == "base" else "world",
        "unknown_frame": frame == "own",
        "unknown_target": frame in ("own", "foot"),
        "white": white,
        "wander": 0.0,
        "chatter": 0.0,
        "axis_deg": 0.0008 if plan["log"] == "drives" else 0.0002,
        "axis_mm": 0.002,
        "orientation": plan["log"] == "poses" and plan["machine"] in ("rx160", "kr500"),
        "lost": float(rng.uniform(0.02, 0.1)) if plan["log"] == "poses" else 0.0,
    }
    if plan["correlated"]:
        big = 5.0 if plan["kind"] == "none" else 1.0
        how |= {"wander": white * big * rng.uniform(0.7, 1.2), "chatter": white * big * rng.uniform(0.8, 1.6)}
    stands = twist(np.r_[rng.uniform(-3, 3, 3), rng.uniform(-0.5, 0.5, 2), rng.uniform(-3, 3)])
    how["stands"] = stands if frame == "own" else np.eye(4)
    how["reflector"] = rng.uniform(-0.08, 0.08, 3) if how["unknown_target"] else np.zeros(3)
    return how


def _scaled(off, target, most):
    """The size, up to `most`, at which off(size) (mm) comes to the target; it grows with the size."""
    if off(most) <= target:
        return most
    low = np.log(most)
    while low > np.log(most) - 14 and off(np.exp(low)) > target:
        low -= 1.5
    return float(np.exp(brentq(lambda x: off(np.exp(x)) / target - 1, low, low + 1.5, xtol=2e-4)))


RANGES = {"L": (3.0, 10.0), "M": (2.0, 3.0), "S": (0.5, 2.0)}


def _caused(case, rng):
    """The causes, their keys drawn, and how large each shall be by the floor."""
    first = None
    for name, level in case.plan["causes"].items():
        kind = NAMED.get(name) or FOREIGN[name]
        low, high = RANGES.get(level, (1, 1))
        ratio = first * rng.uniform(0.1, 0.5) if level == "l" else float(np.exp(rng.uniform(np.log(low), np.log(high))))
        first = ratio if first is None else first
        key, axes = kind.draw(rng, case.arm, case.runs[-1].kind)
        case.causes.append(Cause(name, kind, key, axes, max(ratio, 0.5)))


def _sized(case, factor):
    """Causes to their sizes; where one can't be as large as its class beside the leftover, there is less of that."""
    last = case.runs[-1]
    tops = {c.name: most(case, c.name) for c in case.causes}
    floor = factor * case.noise_mm
    for cause in case.causes:
        if not cause.kind.fixed and factor > 1:
            floor = max(case.noise_mm, min(floor, size_mm(case, cause, tops[cause.name]) / cause.ratio))
    if factor > 1:
        case.left_mm = floor = max(floor, 1.02 * case.noise_mm)
        case.left = _scaled(lambda s: rms(case.off(last, [leftover(last, case.seed + 1, s)])), floor, 0.05)
    for cause in case.causes:
        top, target = tops[cause.name], cause.ratio * floor
        cause.size = top if cause.kind.fixed else _scaled(lambda s, c=cause: size_mm(case, c, s), target, top)
        cause.ratio = size_mm(case, cause) / floor


def most(case, name) -> float:
    """The largest size of a cause on this machine."""
    return MOST[name] * (CARRIES[case.plan["machine"]] if name == "payload" else 1.0)


def made(seed, number) -> Case:
    """The case of a seed and a number."""
    rng, plan = np.random.default_rng([seed, number]), planned(number)
    arm = machine(plan["machine"])
    case = Case(number, plan, arm, _runs(plan, arm, rng), _how(plan, rng), seed=int(rng.integers(1, 2**31)))
    case.noise_mm = rms(case.noise(len(case.runs) - 1))
    factor = float(np.exp(rng.uniform(np.log(1.3), np.log(12)))) if plan["left"] else 1.0
    _caused(case, rng)
    _sized(case, min(factor, 0.35 / case.noise_mm) if factor > 1 else 1.0)
    return case


def size_mm(case: Case, cause: Cause, size=None) -> float:
    """Rms on the withheld run of what frames, target and latency can't take of a cause (of `read`: at the encoders)."""
    last, shift = case.runs[-1], cause.shift(case.runs[-1], size)
    if shift.read is not None:
        there = last.q[last.pick]
        return rms(nominal(last, "world", there + shift.read[last.pick])[:, :3, 3] - nominal(last, "world")[:, :3, 3])
    return rms(case.off(last, [shift], latency=cause.name != "latency"))


def _columns(case: Case, k: int, shifts):
    """The columns of a log, by name, (N,) each; NaN is an empty cell."""
    run, how, arm = case.runs[k], case.how, case.arm
    rng = np.random.default_rng([case.seed, 79, k])
    tip, encoders, told = observed(run, shifts, how["frame"], PLACE)
    encoders = case.encoders(k, encoders)
    out = {"t": run.t[run.pick] - (run.t[0] if run.kind == "poses" else 0.0)}
    if run.kind != "drives":
        at = tip[:, :3, 3] + np.einsum("nij,j->ni", tip[:, :3, :3], how["reflector"]) + case.noise(k)
        at = 1e3 * (at @ how["stands"][:3, :3].T + how["stands"][:3, 3])
        lost = rng.uniform(size=len(at)) < how["lost"]
        at[lost] = np.nan
        out |= dict(zip("xyz", at.T, strict=True))
        if how["orientation"]:
            noise = np.zeros((len(at), 6))
            noise[:, 3:] = np.radians(0.004) * rng.normal(size=(len(at), 3))
            turned = how["stands"][:3, :3] @ tip[:, :3, :3] @ twist(noise)[:, :3, :3]
            turned[lost] = np.nan
            out |= dict(zip("abc", euler(turned).T, strict=True))
    out |= dict(zip(arm.names, arm.values(encoders).T, strict=True))
    out |= {"c" + n: v for n, v in zip(arm.names, arm.values(told).T, strict=True)}
    if run.kind == "drives" or (run.force.any() and arm.name != "kr500_afp"):
        out |= _torques(case, run, rng)
    if run.force.any():
        f = run.force[run.pick] + 1.5 * rng.normal(size=(len(run.pick), 3))
        out |= dict(zip(("fx", "fy", "fz"), f.T, strict=True))
    out["temp"] = 21.0 + run.temp[run.pick] + 0.05 * rng.normal(size=len(run.pick))
    return out


def _torques(case, run, rng):
    """Torques of the arm's axes in Nm (or currents of a small arm): weight, push, inertia and friction, 3 % uneven."""
    arm, first = case.arm, case.arm.first
    load = -(run.loads + run.work) + 0.06 * np.abs(run.loads).max(0) * np.tanh(run.rate() / 0.01)
    load = load + run.rate(2) / (arm.soft + 1e-8) * 2e-5
    load = (arm.sign * load)[run.pick]
    load = load * (1 + 0.03 * rng.normal(size=load.shape)) + 0.01 * np.abs(load).max(0) * rng.normal(size=load.shape)
    small = arm.name in ("ur10e", "scara_column")
    gain = 9.0 if small else 1.0
    return {("I" if small else "T") + str(i - first + 1): load[:, i] / gain for i in range(first, arm.n)}


PLACES = {"t": 3, "x": 4, "y": 4, "z": 4, "fx": 1, "fy": 1, "fz": 1, "temp": 1}


def _table(case, k, path: Path, shifts, names):
    columns = _columns(case, k, shifts)
    rows = [",".join(columns)]
    for row in zip(*columns.values(), strict=True):
        cells = []
        for name, v in zip(columns, row, strict=True):
            digits = PLACES.get(name, 2 if name[0] in "TI" else 4)
            cells.append("" if np.isnan(v) else f"{v:.{digits}f}")
        rows.append(",".join(cells))
    path.write_text("\n".join(rows) + "\n")
    how = case.how
    told = []
    if case.runs[k].kind != "drives":
        frame = "unknown" if how["unknown_frame"] else how["frame"]
        told += [f'measured_frame = "{frame}"', f'target = "{"unknown" if how["unknown_target"] else "tool"}"']
        told.append(f"sigma_mm = {np.sqrt(how['white'] ** 2 + how['wander'] ** 2 + how['chatter'] ** 2):.4f}")
        if how["orientation"]:
            told.append("sigma_deg = 0.004")
        if k and how["unknown_frame"]:
            told.append(f'same_frame_as = "{names[0]}"')
        if k and how["unknown_target"]:
            told.append(f'same_target_as = "{names[0]}"')
        told.append('instrument = "laser tracker"')
    told.append(f"sigma_axis_deg = {how['axis_deg']}")
    if any(case.arm.slides):
        told.append(f"sigma_axis_mm = {how['axis_mm']}")
    if case.runs[k].kind == "poses":
        told.append("poses = true")
    path.with_suffix(".toml").write_text("\n".join(told) + "\n")


def write(case: Case, folder: Path, shifts=None) -> list:
    """The case's files in a folder, `shifts(run)` in place of what is wrong; the names of its logs, the withheld one last."""
    folder.mkdir(parents=True, exist_ok=True)
    names = [f"run_{k + 1}.csv" for k in range(len(case.runs) - 1)] + ["withheld.csv"]
    for k, name in enumerate(names):
        made_of = case.shifts(case.runs[k]) if shifts is None else shifts(case.runs[k])
        _table(case, k, folder / name, made_of, names)
    (folder / "cell").mkdir(exist_ok=True)
    if case.arm.shipped:
        for file in (CELLS / case.arm.shipped).iterdir():
            shutil.copyfile(file, folder / "cell" / file.name)
    else:
        (folder / "cell" / "cell.toml").write_text(case.arm.text)
    return names
