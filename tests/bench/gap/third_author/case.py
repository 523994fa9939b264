"""A case from a seed: what is logged, how the machine moves, how large causes are; the plumbing is the second author's."""

from __future__ import annotations

import csv

import numpy as np

from gap.second_author import case as plumbing
from gap.second_author import design
from gap.second_author.case import sized
from gap.second_author.family import Description, Setting
from gap.second_author.logs import _rows
from gap.second_author.run import Run
from gap.third_author.tools import inertia

FINE = plumbing.FINE
MOST_ROWS = 2400
STREAM = 3003  # so that a seed's case has nothing in common with that of another family
SHARES = {"none": 0.1, "one": 0.42, "two": 0.2, "three": 0.08, "foreign": 0.14, "foreign and one": 0.06}
RATES = (
    (1, 2, 3, 5, 8, 12, 25, 50),
    (0.06, 0.1, 0.14, 0.2, 0.2, 0.14, 0.1, 0.06),
)  # cycles of 4 ms a row, and how often


def kinds(rng, robot):
    """What the logs show: single poses, drives alone, no set-points, or paths; frames and targets that are known or not."""
    draw = rng.random()
    show = "poses" if draw < 0.25 else "drives" if draw < 0.34 else "blind" if draw < 0.41 else "path"
    log = {
        "show": show, "tracker": show != "drives", "setpoints": show != "blind",
        "encoders": show in ("drives", "blind") or bool(rng.random() < 0.85),
        "frame": "world", "target": "tool", "sixd": bool(rng.random() < 0.5), "temp": bool(rng.random() < 0.35),
    }  # fmt: skip
    if log["tracker"]:
        if robot.table and show != "poses" and rng.random() < 0.45:
            log["frame"] = "base"
        elif rng.random() < 0.3:
            log["frame"] = "unknown"
        if not log["sixd"] and rng.random() < 0.45:
            log["target"] = "unknown"
    return log


def table(run, rng):
    """A face plate that is turned by parts, with rests, or slowly all along."""
    x = run.t / run.t[-1]
    if rng.random() < 0.5:
        return rng.choice([-1, 1]) * rng.uniform(1.0, 6.0) * (x - 0.08 * np.sin(2 * np.pi * x) / np.pi) + rng.uniform(
            -3, 3
        )
    parts = int(rng.integers(3, 9))
    at = np.minimum(x * parts, parts - 1e-9)
    inner = np.clip((at - np.floor(at) - 0.3) / 0.5, 0, 1)
    return rng.choice([-1, 1]) * rng.uniform(0.3, 0.9) * (np.floor(at) + inner * inner * (3 - 2 * inner)) + rng.uniform(
        -3, 3
    )


def cuts(run, rng):
    """Cuts that begin and end in half a second, some deeper: along the feed, to a side that stays in world, down on the part."""
    speed = np.gradient(run.tip[:, :3, 3], run.dt, axis=0)
    feed = speed / (np.linalg.norm(speed, axis=1, keepdims=True) + 5e-3)
    edges = np.cumsum(rng.uniform(2, 8, 60))
    depth = np.where(np.arange(61) % 2, rng.uniform(0.4, 1.0, 61), 0.0)[np.searchsorted(edges, run.t)]
    soft = np.convolve(depth, np.ones(125) / 125, mode="same")
    side = np.append(rng.normal(size=2), 0.0)
    raw = (
        -rng.uniform(50, 200) * feed + rng.uniform(30, 120) * side / np.linalg.norm(side) + [0, 0, rng.uniform(20, 90)]
    )
    return raw * soft[:, None]


def runs_of(family, robot, rng, log):
    """One or two runs and one that is withheld, last."""
    count, out, begins = int(rng.integers(1, 3)), [], 0.0
    turns, cut = bool(robot.table) and (log["frame"] == "base" or rng.random() < 0.5), rng.random() < 0.35
    for k in range(count + 1):
        if log["show"] == "poses":
            t, c = family.single_poses(
                robot, rng, int(np.exp(rng.uniform(np.log(18), np.log(500 if k < count else 180))))
            )
        else:
            rate = 1.0 / (FINE * int(rng.choice(RATES[0], p=RATES[1])))
            seconds = min(rng.uniform(25, 90), MOST_ROWS / rate)
            t, c = family.motion(robot, rng, seconds, FINE)
            most = int(seconds / FINE)
            t, c = t[:most], c[:most]
            log.setdefault("rates", []).append(rate)
        run = Run(robot, t - t[0], c, log["show"] == "poses", begins=begins)
        if robot.table:
            run.table = table(run, rng) if turns else np.zeros(len(t))
        if log["show"] == "path" and cut:
            run.force = cuts(run, rng)
        out.append(run)
        begins += float(run.t[-1]) + rng.uniform(60, 400)
    return out


def noise_of(rng, log, robot, runs):
    """The instrument's and encoders' figures, and the floor of the gap in mm, 3-D."""
    out = {
        "sigma_mm": float(np.exp(rng.uniform(np.log(0.007), np.log(0.06)))),
        "sigma_deg": float(rng.uniform(0.001, 0.006)),
        "axis": float(np.exp(rng.uniform(np.log(4e-5), np.log(6e-4)))),
        "colour": float(rng.uniform(0.3, 0.9)) if rng.random() < 0.25 else 0.0,
        "memory_s": float(np.exp(rng.uniform(np.log(0.2), np.log(8.0)))),
        "gross": float(rng.choice([0.0, 0.005, 0.03, 0.08], p=[0.65, 0.15, 0.12, 0.08])) if log["tracker"] else 0.0,
        "told": bool(rng.random() < 0.85),
    }
    axis = out["axis"] * robot.unit * np.where(robot.slides, 10, 1)
    through = 1e3 * float(np.sqrt(((runs[-1].jacobian[0] * axis) ** 2).sum(axis=(1, 2)).mean()))
    floor = out["sigma_mm"] * np.sqrt(3.0) if log["tracker"] else through
    return out, float(np.hypot(floor, through if log["encoders"] else 0.0))


def flags(robot, log, runs):
    """What descriptions may need."""
    out = plumbing.flags(robot, log, runs)
    if len(robot.arm) >= 3 and not robot.slides[robot.arm[:3]].any():
        out.add("elbow")
    if len(robot.carriage) > 1 and all(np.ptp(r.c[:, robot.carriage[0]]) > 0.03 for r in runs):
        out.add("bridge")
    return out


COUNTS = {"none": (0, 0), "one": (1, 0), "two": (2, 0), "three": (3, 0), "foreign": (0, 1), "foreign and one": (1, 1)}


def drawn(kind, family, rng, setting, designs, floor, field):
    """[(description, cause, size)]: names first, each as likely as another; sizes from 0.4 to 10 times what is there anyway."""
    have, out = flags(setting.robot, setting.log, setting.runs), []
    for pool, count in zip((family.known, family.foreign), COUNTS[kind], strict=True):
        fit = [d for d in pool if d.needs <= have]
        for _ in range(count):
            tried = set()
            while True:
                names = sorted({d.name for d in fit} - {o[0].name for o in out} - tried)
                if not names:
                    break
                name = names[rng.integers(len(names))]
                tried.add(name)
                ways = [d for d in fit if d.name == name]
                picked = ways[rng.integers(len(ways))]
                want = max(floor, field) * float(np.exp(rng.uniform(np.log(0.4), np.log(10.0))))
                if pool is family.foreign:
                    want = max(want, 2.0 * floor, 1.5 * field)
                found = _sized(picked, setting, designs, int(rng.integers(1 << 30)), want)
                if found:
                    out.append((picked, *found))
                    break
    return out


def _sized(description, setting, designs, seed, want):
    try:
        return sized(description, setting, designs, seed, want)
    except ValueError:  # no axis moves that this cause needs
        return None


def case(family, seed, folder):
    """Writes a case's cell and logs into `folder`; the label."""
    rng = np.random.default_rng([seed, STREAM])
    names = list(family.cells)
    shares = np.array([family.cells[n][1] for n in names])
    cell = names[rng.choice(len(names), p=shares / shares.sum())]
    robot = family.cells[cell][0]()
    log = kinds(rng, robot)
    runs = runs_of(family, robot, rng, log)
    setting = Setting(robot, [plumbing._in_frame(r, log) for r in runs], log)
    designs = [design.Design(r, log) for r in setting.runs]
    noise, floor = noise_of(rng, log, robot, runs)
    field, causes, alike = 0.0, [], []
    if rng.random() < 0.5:
        make = family.leftover if log["tracker"] else family.drive_leftover
        want = min(floor * float(np.exp(rng.uniform(0.0, np.log(30.0)))), 1.5)
        leftover = Description("leftover", make, most=400.0)
        found = _sized(leftover, setting, designs, int(rng.integers(1 << 30)), want)
        if found:
            causes.append(found[0])
            field, alike = found[1], plumbing._told(leftover, *found, designs)["alike"]
    kind = str(rng.choice(list(SHARES), p=list(SHARES.values())))
    picked = drawn(kind, family, rng, setting, designs, floor, field)
    causes += [c for _, c, _ in picked]
    label = {
        "seed": seed, "family": family.name, "cell": robot.name, "robot": cell, "kind": kind, "log": log, "noise": noise,
        "noise_mm": floor, "leftover_mm": field, "leftover_alike": alike,
        "causes": [plumbing._told(d, c, s, designs) for d, c, s in picked], "rows": [], "target_mm": [0.0, 0.0, 0.0],
    }  # fmt: skip
    folder.mkdir(parents=True, exist_ok=True)
    plumbing._write(folder, robot, setting.runs, causes, log, noise, rng, label)
    if getattr(robot, "sensors", False) and log["show"] == "path":
        for k, run in enumerate(setting.runs):
            name = "withheld" if k == len(runs) - 1 else f"run_{'abc'[k]}"
            add_torques(folder / f"{name}.csv", run, _rows(run, log, k), rng)
    return label


def add_torques(path, run, rows, rng):
    """Columns T1 .. of torques at the links: weight and inertia, with what the sensors add."""
    robot = run.robot
    told = np.stack([inertia(run, i) * run.a[:, i] / 1.5 - run.load[:, i] for i in robot.arm], axis=1)[rows]
    told = told * (1 + 0.005 * rng.normal(size=told.shape[1])) + 0.05 * rng.normal(size=told.shape)
    with path.open(newline="") as file:
        lines = list(csv.reader(file))
    with path.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow([*lines[0], *("T" + robot.names[i][1:] for i in robot.arm)])
        out.writerows([[*line, *(f"{x:.4f}" for x in more)] for line, more in zip(lines[1:], told, strict=True)])
