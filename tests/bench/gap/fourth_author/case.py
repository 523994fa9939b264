"""A case from a seed: a machine, what was measured with it, what is at work, and files that lack rows as real ones do."""

from __future__ import annotations

import numpy as np

from gap.fourth_author.causes import KNOWN
from gap.fourth_author.machines import MACHINES
from gap.fourth_author.moves import POSES, circle, raster, sweeps
from gap.fourth_author.unnamed import FOREIGN, drive_leftover, leftover
from gap.second_author import case as plumbing
from gap.second_author import design
from gap.second_author.family import Description, Setting
from gap.second_author.run import Run

__all__ = ["case", "thinned"]

# how likely a cause is at work, by what is measured: what a lab finds, not each as likely as another
POSED = {
    "joint_offset": 0.8, "joint_compliance": 0.75, "geometry": 0.3, "frame_base": 0.3, "frame_tool": 0.3, "backlash": 0.2,
    "payload": 0.15, "lean": 0.1, "hysteresis": 0.15, "track": 0.5, "wrist_coupling": 0.1, "thermal_drift": 0.2,
    "measurement_scale": 0.1, "measurement_drift": 0.15, "early_reading": 0.1, "gear_ripple": 0.1,
}  # fmt: skip
MOVED = {
    "servo_lag": 0.5, "friction": 0.3, "latency": 0.35, "backlash": 0.3, "gear_ripple": 0.25, "joint_offset": 0.3,
    "joint_compliance": 0.3, "frame_base": 0.15, "frame_tool": 0.1, "setpoint_delay": 0.12, "motor_commutation": 0.12,
    "hysteresis": 0.15, "acceleration_error": 0.2, "cutting_force": 0.5, "frame_table": 0.5, "turntable": 0.4, "track": 0.4,
    "geometry": 0.1,
}  # fmt: skip
DRIVEN = {"servo_lag": 0.6, "friction": 0.6, "setpoint_delay": 0.25, "motor_commutation": 0.35}
RATES = (10, 25, 50, 125, 250)  # rows a second that trackers and controllers write
TOP = 2500  # rows of a log: a longer one is written more sparsely


def _log(rng, robot):
    """What the log shows: half are poses before a tracker, a third paths, the rest a controller's own."""
    show = str(rng.choice(["poses", "path", "drives"], p=[0.47, 0.35, 0.18]))
    log = {
        "show": show, "tracker": show != "drives", "setpoints": True, "frame": "world", "target": "tool",
        "encoders": show != "poses" or bool(rng.random() < 0.4), "sixd": bool(rng.random() < 0.35),
        "temp": bool(rng.random() < 0.25),
    }  # fmt: skip
    if show == "path" and robot.table and rng.random() < 0.6:
        log["frame"] = "base"
    elif log["tracker"] and rng.random() < 0.45:
        log["frame"] = "unknown"
    if log["tracker"] and not log["sixd"] and rng.random() < 0.5:
        log["target"] = "unknown"
    return log


def _moved(robot, rng, log, k, kind, speed):
    t, c = {"circle": circle, "raster": raster, "sweeps": sweeps}[kind](robot, rng, speed * (1.0 if k != 1 else 2.5))
    fits = [r for r in RATES if r * t[-1] <= TOP] or [RATES[0]]
    log.setdefault("rates", []).append(min(fits[-1], log.get("writes", 250)))
    return t, c


def _runs(robot, rng, log):
    """One or two runs, and one that is withheld, last; what was drawn."""
    count, begins, runs = int(rng.integers(1, 3)), 0.0, []
    poses = log["show"] == "poses"
    log["motion"] = str(rng.choice(list(POSES)) if poses else rng.choice(["circle", "raster", "sweeps"]))
    speed = float(rng.uniform(0.03, 0.12)) if log["motion"] != "sweeps" else float(rng.uniform(0.05, 0.12))
    log["writes"] = int(rng.choice(RATES[1:]))
    count = 2 if log["motion"] == "raster" else 1 if poses else count
    for k in range(count + 1):
        if poses:
            t, c = POSES[log["motion"]](robot, rng, int(rng.integers(50, 151) if k < count else rng.integers(30, 61)))
        else:
            t, c = _moved(robot, rng, log, k, log["motion"], speed)
        run = Run(robot, t, c, poses, begins=begins)
        if robot.table:
            run.table = _turning(run, rng) if log["frame"] == "base" else np.zeros(len(t))
        begins += float(t[-1]) + rng.uniform(60, 400)
        runs.append(run)
    if log["motion"] == "raster" and log["tracker"] and rng.random() < 0.5:
        for run in runs:
            run.force = _cut(run, rng)
    return runs


def _turning(run, rng):
    """The table goes slowly there and back."""
    return rng.uniform(0.8, 2.0) * np.sin(2 * np.pi * run.t / run.t[-1]) + rng.uniform(-0.5, 0.5)


def _cut(run, rng):
    """A cut in each line: against the feed, aside and along the tool, N."""
    v = np.gradient(run.tip[:, :3, 3], run.dt, axis=0)
    speed = np.linalg.norm(v, axis=1, keepdims=True)
    along, axis = v / (speed + 1e-4), run.tip[:, :3, 2]
    on = np.clip(speed / speed.max() * 3 - 1, 0, 1)
    return on * (
        -rng.uniform(60, 200) * along + rng.uniform(-80, 80) * np.cross(along, axis) - rng.uniform(20, 80) * axis
    )


def _noise(rng, log, robot, runs):
    """A tracker of 10 to 40 micrometres, or cameras of twice that; how often the beam sees something else."""
    out = {
        "sigma_mm": float(np.exp(rng.uniform(np.log(0.01), np.log(0.06)))), "sigma_deg": float(rng.uniform(0.002, 0.008)),
        "axis": float(np.exp(rng.uniform(np.log(5e-5), np.log(5e-4)))), "colour": float(rng.choice([0.0, 0.5], p=[0.8, 0.2])),
        "memory_s": float(rng.uniform(0.5, 5.0)), "told": bool(rng.random() < 0.8),
        "gross": float(rng.choice([0.0, 0.01, 0.03], p=[0.6, 0.25, 0.15])) if log["tracker"] else 0.0,
    }  # fmt: skip
    axis = out["axis"] * robot.unit * np.where(robot.slides, 10, 1)
    through = 1e3 * float(np.sqrt(((runs[-1].jacobian[0] * axis) ** 2).sum(axis=(1, 2)).mean()))
    floor = out["sigma_mm"] * np.sqrt(3.0) if log["tracker"] else through
    return out, float(np.hypot(floor, through if log["encoders"] else 0.0))


def _drawn(rng, chances, have, least, most):
    """Names at work: each by its own chance, in any order, `least` at least and `most` at most."""
    fit = {n: p for n, p in chances.items() if KNOWN[n].needs <= have}
    names = [n for n, p in fit.items() if rng.random() < p]
    rng.shuffle(names)
    if "payload" in names:  # the payload that was told wrong is told to a model of compliance
        names = [n for n in names if n != "joint_compliance"]
    pool = sorted(set(fit) - set(names))
    while len(names) < least:
        names.append(pool.pop(int(rng.integers(len(pool)))))
    return names[:most]


def _made(description, setting, rng):
    """A cause at its own size, or None where no axis moves that it needs."""
    try:
        return description.make(setting, rng, 1.0)
    except ValueError:
        return None


def _size(cause, designs):
    """What a cause does on the withheld log once frame, target and latency took their part, rms mm."""
    nuisance = designs[-1].absorbed(cause.name != "latency")
    return design.size(design.left(design.pattern(designs[-1], [cause]), nuisance), len(designs[-1].rows))


def _causes(rng, setting, designs, floor, field):
    """[(description, cause, size)] of one case."""
    kind, show = rng.random(), setting.log["show"]
    have = plumbing.flags(setting.robot, setting.log, setting.runs) | ({"drives"} if show == "drives" else set())
    out = []
    if kind < 0.1:
        return out
    if kind < 0.3:
        picked = [d for d in FOREIGN if d.needs <= have]
        foreign = picked[int(rng.integers(len(picked)))]
        want = max(floor, field) * rng.uniform(2.0, 6.0)
        found = plumbing.sized(foreign, setting, designs, int(rng.integers(1 << 30)), want)
        out += [(foreign, *found)] if found else []
    chances = {"poses": POSED, "path": MOVED, "drives": DRIVEN}[show]
    if not out:
        names = _drawn(rng, chances, have, 1, 4)
    else:
        names = _drawn(rng, chances, have, 0, 2) if rng.random() < 0.5 else []
    for name in names:
        cause = _made(KNOWN[name], setting, rng)
        size = _size(cause, designs) if cause else 0.0
        if size > 0.2 * floor:  # what is far below the noise is no cause that anybody asks for
            out.append((KNOWN[name], cause, size))
    return out


def thinned(path, rng, share, gap):
    """Drops rows of a log as real ones lack them: single ones, and a stretch in which the beam was cut; how many stay."""
    head, *rows = path.read_text().splitlines()
    keep = rng.random(len(rows)) >= share
    if gap and len(rows) > 200:
        start = int(rng.integers(20, len(rows) - 100))
        keep[start : start + int(rng.integers(10, 60))] = False
    path.write_text("\n".join([head, *(r for r, k in zip(rows, keep, strict=True) if k)]) + "\n")
    return int(keep.sum())


def case(seed, folder):
    """Writes a case's cell and logs into `folder`; the label."""
    rng = np.random.default_rng([seed, 4])
    name = str(rng.choice(list(MACHINES)))
    robot = MACHINES[name]()
    log = _log(rng, robot)
    runs = _runs(robot, rng, log)
    setting = Setting(robot, [plumbing._in_frame(r, log) for r in runs], log)
    designs = [design.Design(r, log) for r in setting.runs]
    noise, floor = _noise(rng, log, robot, runs)
    causes, field, field_alike = [], 0.0, []
    if rng.random() < 0.5:
        make = leftover if log["tracker"] else drive_leftover
        left = Description("leftover", make, most=400.0)
        found = plumbing.sized(
            left, setting, designs, int(rng.integers(1 << 30)), floor * float(np.exp(rng.uniform(0, np.log(10))))
        )
        if found:
            causes, field = [found[0]], found[1]
            field_alike = plumbing._told(left, *found, designs)["alike"]
    drawn = _causes(rng, setting, designs, floor, field)
    kind = "foreign" if any(d.foreign for d, _, _ in drawn) else str(len(drawn))
    label = {
        "seed": seed, "family": "fourth", "cell": robot.name, "robot": name, "kind": kind, "log": log, "noise": noise,
        "noise_mm": floor, "leftover_mm": field, "leftover_alike": field_alike,
        "causes": [plumbing._told(d, c, s, designs) for d, c, s in drawn], "rows": [], "target_mm": [0.0, 0.0, 0.0],
    }  # fmt: skip
    folder.mkdir(parents=True, exist_ok=True)
    plumbing._write(folder, robot, setting.runs, [*causes, *(c for _, c, _ in drawn)], log, noise, rng, label)
    if rng.random() < 0.5:
        logs = [*sorted(folder.glob("run_*.csv")), folder / "withheld.csv"]
        label["rows"] = [thinned(p, rng, rng.uniform(0.0, 0.05), log["show"] == "path") for p in logs]
    return label
