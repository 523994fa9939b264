"""A case from a seed: a cell, its logs in a folder, and the label, which is handed back and not written there."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from gap.second_author import design
from gap.second_author.family import Description, Setting
from gap.second_author.logs import write_log
from gap.second_author.run import Run

REPOSITORY = Path(__file__).resolve().parents[4]
FINE = 0.004  # s, the clock on which loops are simulated
MOST_ROWS = 2600  # a log: three logs of it are what a diagnosis takes 20 s for
SHARES = {"none": 0.12, "one": 0.42, "two": 0.18, "three": 0.08, "foreign": 0.14, "foreign and one": 0.06}


def _kinds(rng, robot):
    """What the logs show."""
    draw = rng.random()
    show = "poses" if draw < 0.22 else "drives" if draw < 0.33 else "blind" if draw < 0.41 else "path"
    log = {
        "show": show,
        "tracker": show != "drives",
        "setpoints": show != "blind",
        "encoders": True if show in ("drives", "blind") else bool(rng.random() < 0.88),
        "frame": "world",
        "target": "tool",
        "sixd": bool(rng.random() < 0.55),
    }
    if log["tracker"]:
        frame = rng.random()
        if robot.table and show != "poses" and frame < 0.25:
            log["frame"] = "base"
        elif frame > 0.65:
            log["frame"] = "unknown"
        if not log["sixd"] and rng.random() < 0.5:
            log["target"] = "unknown"
    return log


def _runs(family, robot, rng, log):
    """One or two runs and one that is withheld, last."""
    count, runs, begins = int(rng.integers(1, 3)), [], 0.0
    table = bool(robot.table) and rng.random() < 0.6
    for k in range(count + 1):
        if log["show"] == "poses":
            number = int(np.exp(rng.uniform(np.log(15), np.log(600 if k < count else 200))))
            t, c = family.single_poses(robot, rng, number)
        else:
            rate = 1.0 / (FINE * int(rng.choice([1, 2, 4, 5, 10, 20, 62], p=[0.07, 0.1, 0.18, 0.2, 0.25, 0.12, 0.08])))
            seconds = min(rng.uniform(25, 80), MOST_ROWS / rate)
            t, c = family.motion(robot, rng, seconds, FINE)
            most = int(MOST_ROWS / rate / FINE)
            t, c = t[:most], c[:most]
            log.setdefault("rates", []).append(rate)
        run = Run(robot, t, c, log["show"] == "poses", begins=begins)
        moves = log["frame"] == "base" or table
        if robot.table:
            run.table = _table(run, rng) if moves else np.zeros(len(t))
        runs.append(run)
        begins += float(t[-1]) + rng.uniform(30, 200)
    if log["show"] == "path" and rng.random() < 0.3:
        for run in runs:
            run.force = _force(run, rng)
    log["temp"] = bool(rng.random() < 0.4)
    return runs


def _table(run, rng):
    x = run.t / run.t[-1]
    return rng.uniform(0.5, 2.5) * np.sin(2 * np.pi * x * rng.uniform(0.6, 2) + rng.uniform(0, 6)) + rng.uniform(-1, 1)


def _force(run, rng):
    """Cuts of a few seconds: against the feed, across it, and along the tool, N."""
    speed = np.gradient(run.tip[:, :3, 3], run.dt, axis=0)
    along = speed / (np.linalg.norm(speed, axis=1, keepdims=True) + 1e-3)
    cuts = (np.sin(2 * np.pi * run.t / rng.uniform(6, 15) + rng.uniform(0, 6)) > -0.3).astype(float)
    smooth = np.convolve(cuts, np.ones(50) / 50, mode="same")
    across = np.cross(along, run.tip[:, :3, 2])
    raw = -rng.uniform(40, 150) * along + rng.uniform(-90, 90) * across + rng.uniform(-60, 60) * run.tip[:, :3, 2]
    return raw * (smooth * (1 + 0.1 * np.sin(2 * np.pi * run.t * 1.7)))[:, None]


def flags(robot, log, runs):
    """What descriptions may need."""
    out = {"poses"} if runs[0].rest else {"path"}
    given = {
        "tracker": log["tracker"],
        "setpoints": log["setpoints"],
        "track": bool(robot.carriage) and all(np.ptp(r.c[:, robot.carriage[-1]]) > 0.05 for r in runs),
        "table": log["frame"] == "base",
        "force": runs[0].force is not None,
        "frame_known": log["frame"] == "world",
        "target_known": log["target"] == "tool",
        "wrist": len(robot.arm) >= 6,
    }
    return out | {k for k, v in given.items() if v}


def _seen(log):
    """Runs' tables count only where the measured frame is base."""
    return log["frame"] == "base"


def sized(description, setting, designs, seed, want):
    """The cause at the strength that makes the withheld log differ by `want` mm, what it makes there, or None."""
    strength, rows = 1.0, len(designs[-1].rows)
    late = description.name != "latency"
    nuisance = designs[-1].absorbed(late)
    for _ in range(4):
        cause = description.make(setting, np.random.default_rng(seed), strength)
        made = design.size(design.left(design.pattern(designs[-1], [cause]), nuisance), rows)
        if made < 1e-6:
            return None
        if abs(made / want - 1) < 0.03:
            break
        strength = float(np.clip(strength * want / made, 1e-3, description.most))
    return (cause, made) if 0.35 * want < made < 2.0 * want else None


def _drawn(kind, family, rng, setting, designs, floor, field):
    """[(description, cause, size)] of one case."""
    counts = {
        "none": (0, 0),
        "one": (1, 0),
        "two": (2, 0),
        "three": (3, 0),
        "foreign": (0, 1),
        "foreign and one": (1, 1),
    }
    have = flags(setting.robot, setting.log, setting.runs)
    out = []
    for pool, count in zip((family.known, family.foreign), counts[kind], strict=True):
        fit = [d for d in pool if d.needs <= have]
        for _ in range(count):
            for _ in range(10):
                rest = [d for d in fit if d.name not in {o[0].name for o in out}]
                if not rest:
                    break
                picked = rest[rng.integers(len(rest))]
                want = max(floor, field) * float(
                    np.exp(rng.uniform(np.log(0.7), np.log(8.0 if field > floor else 16.0)))
                )
                if pool is family.foreign:
                    want = max(want, 2.0 * floor, 1.5 * field)
                try:
                    found = sized(picked, setting, designs, int(rng.integers(1 << 30)), want)
                except ValueError:  # no axis moves that this cause needs
                    found = None
                if found:
                    out.append((picked, *found))
                    break
    return out


def _noise(rng, log, robot, runs):
    """The instrument's figures, and the floor of the gap in mm, 3-D."""
    out = {
        "sigma_mm": float(np.exp(rng.uniform(np.log(0.008), np.log(0.05)))),
        "sigma_deg": float(rng.uniform(0.001, 0.005)),
        "axis": float(np.exp(rng.uniform(np.log(5e-5), np.log(8e-4)))),
        "colour": float(rng.uniform(0.4, 0.8)) if rng.random() < 0.25 else 0.0,
        "memory_s": float(rng.uniform(0.3, 3.0)),
        "gross": float(rng.choice([0.0, 0.01, 0.1], p=[0.65, 0.25, 0.1])) if log["tracker"] else 0.0,
        "told": bool(rng.random() < 0.85),
    }
    axis = out["axis"] * robot.unit * np.where(robot.slides, 10, 1)
    through = 1e3 * float(np.sqrt(((runs[-1].jacobian[0] * axis) ** 2).sum(axis=(1, 2)).mean()))
    floor = out["sigma_mm"] * np.sqrt(3.0) if log["tracker"] else through
    return out, float(np.hypot(floor, through if log["encoders"] else 0.0))


def case(family, seed, folder: Path):
    """Writes a case's cell and logs into `folder`; the label."""
    rng = np.random.default_rng([seed, 20261125])
    names = list(family.cells)
    shares = np.array([family.cells[n][1] for n in names])
    cell = names[rng.choice(len(names), p=shares / shares.sum())]
    robot = family.cells[cell][0]()
    log = _kinds(rng, robot)
    runs = _runs(family, robot, rng, log)
    setting = Setting(robot, [_in_frame(r, log) for r in runs], log)
    designs = [design.Design(r, log) for r in setting.runs]
    noise, floor = _noise(rng, log, robot, runs)
    field, causes, field_alike = 0.0, [], []
    if rng.random() < 0.5:
        want = floor * float(np.exp(rng.uniform(0.0, np.log(30.0))))
        make = family.leftover if log["tracker"] else family.drive_leftover
        leftover = _leftover(make, setting, designs, int(rng.integers(1 << 30)), min(want, 1.5))
        if leftover:
            causes.append(leftover[0])
            field = leftover[1]
            field_alike = _told(Description("leftover", make), *leftover, designs)["alike"]
    kind = str(rng.choice(list(SHARES), p=list(SHARES.values())))
    drawn = _drawn(kind, family, rng, setting, designs, floor, field)
    causes += [c for _, c, _ in drawn]
    label = {
        "seed": seed, "family": family.name, "cell": robot.name, "robot": cell, "kind": kind, "log": log, "noise": noise,
        "noise_mm": floor, "leftover_mm": field, "leftover_alike": field_alike,
        "causes": [_told(d, c, s, designs) for d, c, s in drawn], "rows": [], "target_mm": [0.0, 0.0, 0.0],
    }  # fmt: skip
    _write(folder, robot, setting.runs, causes, log, noise, rng, label)
    return label


def _in_frame(run, log):
    """Its table stands aside where the tool is measured in world: what turns there moves nothing that is seen."""
    run.turned = run.table
    if not _seen(log):
        run.table = None
    return run


def _leftover(make, setting, designs, seed, want):
    try:
        return sized(Description("leftover", make, most=400.0), setting, designs, seed, want)
    except ValueError:
        return None


def _told(description, cause, made, designs):
    late = cause.name != "latency"
    stacked = design.patterns(designs, lambda d: design.pattern(d, [cause]), late)
    return {
        "name": cause.name, "foreign": description.foreign, "stage": cause.stage, "axes": cause.axes, "params": cause.params,
        "follows": cause.follows, "size_mm": made, "alike": design.alike(designs, cause.name, stacked, late),
    }  # fmt: skip


def _write(folder, robot, runs, causes, log, noise, rng, label):
    if robot.copied:
        shutil.copytree(REPOSITORY / "cells" / robot.copied, folder / "cell", dirs_exist_ok=True)
    else:
        robot.write(folder / "cell")
    hidden = _hidden(rng, log)
    label["target_mm"] = (hidden[1][:3, 3] * 1e3).tolist()
    names = [f"run_{'abc'[k]}" for k in range(len(runs) - 1)] + ["withheld"]
    for k, (run, name) in enumerate(zip(runs, names, strict=True)):
        label["rows"].append(write_log(folder, name, run, causes, log, noise, rng, hidden, k))


def _hidden(rng, log):
    """The instrument's own frame and the reflector's place, identities where they are known."""
    frame, target = np.eye(4), np.eye(4)
    if log["frame"] == "unknown":
        frame[:3, :3] = Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix()
        frame[:3, 3] = rng.uniform(-3, 3, 3)
    if log["target"] == "unknown":
        target[:3, 3] = rng.uniform(-0.08, 0.08, 3)
    return frame, target
