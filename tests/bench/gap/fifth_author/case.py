"""A case from a seed: what it is about, a machine, a procedure, what else is at work, and the files of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gap.fifth_author.kind import theme
from gap.fifth_author.machine import carrying
from gap.second_author import case as plumbing
from gap.second_author import design
from gap.second_author.family import Description, Setting
from gap.second_author.run import Run

__all__ = ["Made", "case", "cause_of", "made"]

# how likely something else is at work, too, by what is measured
POSED = {
    "joint_offset": 0.35, "geometry": 0.25, "joint_compliance": 0.4, "frame_base": 0.25, "frame_tool": 0.25, "backlash": 0.15,
    "track": 0.3, "lean": 0.15, "hysteresis": 0.12, "payload": 0.05, "measurement_drift": 0.05,
}  # fmt: skip
MOVED = {
    "servo_lag": 0.35, "friction": 0.25, "latency": 0.25, "backlash": 0.2, "gear_ripple": 0.2, "joint_offset": 0.25,
    "track": 0.25, "joint_compliance": 0.25, "frame_base": 0.15, "hysteresis": 0.1,
}  # fmt: skip
DRIVEN = {"servo_lag": 0.4, "friction": 0.4}
RATES, ROWS = (10, 25, 50, 125), 1800
LEAST = 0.2  # of the noise: below, a cause is none that anybody asks for


def _show(rng, about):
    """Poses, a path before an instrument, or a controller's own log."""
    if about in ("thermal_drift", "measurement_drift"):
        return "poses"
    if about in ("servo_lag", "friction"):
        return "drives" if rng.random() < 0.35 else "path"
    share = {"track": 0.6, "payload": 0.7, "joint_offset": 0.75, "geometry": 0.75, "backlash": 0.5}.get(about, 0.55)
    if rng.random() < share:
        return "poses"
    return "drives" if about in ("none", "foreign") and rng.random() < 0.25 else "path"


def _log(rng, show):
    log = {
        "show": show, "tracker": show != "drives", "setpoints": True, "frame": "world", "target": "tool",
        "encoders": show != "poses" or bool(rng.random() < 0.4), "sixd": bool(rng.random() < 0.35), "temp": False,
    }  # fmt: skip
    if log["tracker"] and rng.random() < 0.4:
        log["frame"] = "unknown"
    if log["tracker"] and not log["sixd"] and rng.random() < 0.4:
        log["target"] = "unknown"
    return log


def _machine(kind, rng, about):
    names = [n for n, make in kind.cells.items() if not _lacks(make(), about)]
    name = str(rng.choice(names))
    return name, kind.cells[name]()


def _lacks(robot, about):
    if about == "track":
        return not robot.carriage
    return about in ("payload", "geometry", "foreign", "joint_compliance", "thermal_drift") and len(robot.arm) < 6


def _procedure(kind, rng, robot, about, show):
    pool = kind.poses if show == "poses" else kind.paths
    long = about in ("thermal_drift", "measurement_drift")
    fit = [
        n
        for n in pool
        if (n == kind.warm) == long
        and (n in kind.on_track or about != "track")
        and not (n in kind.on_track and not robot.carriage)
        and not (n in kind.six and len(robot.arm) < 6)
    ]
    return str(rng.choice(fit))


def _payloads(rng, robot, about, count):
    """The machine of each log: with sag, the logs may have been made under several payloads, each told."""
    if about not in ("joint_compliance", "joint_offset", "none", "geometry") or rng.random() < 0.6:
        return [robot] * count
    masses = [robot.payload, *(np.round(robot.rated * rng.uniform(0.15, 0.95, count - 1), 2))]
    rng.shuffle(masses)
    return [carrying(robot, m) for m in masses]


def _runs(kind, rng, robot, about, log):
    name = _procedure(kind, rng, robot, about, log["show"])
    log["motion"], poses, begins, runs = name, log["show"] == "poses", 0.0, []
    make = (kind.poses if poses else kind.paths)[name]
    count = int(rng.integers(1, 3)) + 1
    for k, machine in enumerate(_payloads(rng, robot, about, count)):
        if poses:
            t, c = make(machine, rng, int(rng.integers(55, 140) if k + 1 < count else rng.integers(35, 80)))
        else:
            t, c = make(machine, rng, float(rng.uniform(0.5, 1.1)) * max(robot.size, 0.12) * (1.6 if k == 1 else 1.0))
            fits = [r for r in RATES if r * t[-1] <= ROWS] or [RATES[0]]
            log.setdefault("rates", []).append(int(rng.choice(fits[-2:])))
            most = int(3 * ROWS / log["rates"][-1] / (t[1] - t[0]))
            t, c = t[:most], c[:most]
        runs.append(Run(machine, t, c, poses, begins=begins))
        long = name == kind.warm
        begins = 0.0 if kind.mornings and long else begins + float(t[-1]) + rng.uniform(120, 900)
    return runs


def _noise(rng, kind, log, runs):
    """The instrument's figures, and the floor of the gap, mm, 3-D."""
    low, high = np.log(kind.sigma)
    robot = runs[-1].robot
    out = {
        "sigma_mm": float(np.exp(rng.uniform(low, high))), "sigma_deg": float(rng.uniform(0.002, 0.008)),
        "axis": float(np.exp(rng.uniform(np.log(5e-5), np.log(4e-4)))), "colour": float(rng.choice([0.0, 0.4], p=[0.8, 0.2])),
        "memory_s": float(rng.uniform(0.4, 4.0)), "told": bool(rng.random() < 0.8),
        "gross": float(rng.choice([0.0, 0.01, 0.03], p=[0.65, 0.25, 0.1])) if log["tracker"] else 0.0,
    }  # fmt: skip
    axis = out["axis"] * robot.unit * np.where(robot.slides, 10, 1)
    through = 1e3 * float(np.sqrt(((runs[-1].jacobian[0] * axis) ** 2).sum(axis=(1, 2)).mean()))
    floor = out["sigma_mm"] * np.sqrt(3.0) if log["tracker"] else through
    return out, float(np.hypot(floor, through if log["encoders"] else 0.0))


def cause_of(description, setting, designs, seed, strength=1.0):
    """(cause, rms mm on the withheld log after frame, target and latency took their part), or None where it can't be at work."""
    try:
        cause = description.make(setting, np.random.default_rng(seed), strength)
    except ValueError:  # no axis moves that it needs
        return None
    last = designs[-1]
    left = design.left(design.pattern(last, [cause]), last.absorbed(cause.name != "latency"))
    return cause, design.size(left, len(last.rows))


def _first(kind, rng, setting, designs, about, floor):
    """What the case is about, at its own size; drawn anew where it would drown."""
    if about not in kind.known or not kind.known[about].needs <= plumbing.flags(
        setting.robot, setting.log, setting.runs
    ):
        return []
    best = None
    for _ in range(6):
        found = cause_of(kind.known[about], setting, designs, int(rng.integers(1 << 30)))
        if found and (best is None or found[1] > best[1]):
            best = found
        if best and best[1] > 0.7 * floor:
            break
    return [(kind.known[about], *best)] if best and best[1] > LEAST * floor else []


def _foreign(kind, rng, setting, designs, least):
    """A cause without a name, at its own size or, where that would drown, as strong as two to four times what is there."""
    have = plumbing.flags(setting.robot, setting.log, setting.runs)
    pool = [d for d in kind.foreign if d.needs <= have]
    for k in rng.permutation(len(pool)):
        seed = int(rng.integers(1 << 30))
        found = cause_of(pool[k], setting, designs, seed)
        if found and found[1] < 1.5 * least:
            found = plumbing.sized(pool[k], setting, designs, seed, least * rng.uniform(2, 4))
        if found and found[1] > least:
            return [(pool[k], *found)]
    return []


def _beside(kind, rng, setting, designs, taken, floor, most):
    """Others at work, each by its own chance."""
    chances = {"poses": POSED, "path": MOVED, "drives": DRIVEN}[setting.log["show"]]
    have = plumbing.flags(setting.robot, setting.log, setting.runs)
    names = [n for n, p in chances.items() if n in kind.known and kind.known[n].needs <= have and rng.random() < p]
    rng.shuffle(names)
    pair = {"payload", "joint_compliance"}  # the payload is told to a model that takes the sag off
    out = []
    for name in names:
        if name in taken or (name in pair and taken & pair) or len(out) >= most:
            continue
        found = cause_of(kind.known[name], setting, designs, int(rng.integers(1 << 30)))
        if found and found[1] > LEAST * floor:
            out.append((kind.known[name], *found))
            taken = taken | {name}
    return out


def _left(kind, rng, setting, designs, floor):
    """In half of the cases something that nobody has a name for, 1 to 10 times the noise."""
    make = kind.leftover if setting.log["tracker"] else kind.drive_leftover
    if rng.random() >= 0.5:
        return []
    what = Description("leftover", make, most=400.0)
    want = floor * float(np.exp(rng.uniform(0, np.log(10))))
    try:
        found = plumbing.sized(what, setting, designs, int(rng.integers(1 << 30)), want)
    except ValueError:  # nothing moves
        found = None
    return [(what, *found)] if found else []


def _drawn(kind, rng, setting, designs, about, floor, field):
    if about == "none":
        return []
    if about == "foreign":
        foreign = _foreign(kind, rng, setting, designs, max(floor, field))
        return foreign + (_beside(kind, rng, setting, designs, set(), floor, 1) if rng.random() < 0.35 else [])
    first = _first(kind, rng, setting, designs, about, floor)
    return first + _beside(kind, rng, setting, designs, {about}, floor, int(rng.choice(3, p=[0.3, 0.4, 0.3])))


def _warmth(folder, run, name, causes, rng):
    """Appends the arm's temperature to a log of poses: that of what warms it, or of a hall."""
    path = folder / f"{name}.csv"
    warm = next((c.temperature for c in causes if hasattr(c, "temperature")), None)
    temp = 21.0 + (warm(run) if warm else 1.5 * np.sin(run.clock / 9000.0)) + 0.1 * rng.normal(size=len(run.t))
    head, *rows = path.read_text().splitlines()
    path.write_text("\n".join([head + ",temp", *(f"{r},{x:.2f}" for r, x in zip(rows, temp, strict=True))]) + "\n")


@dataclass
class Made:
    """A case before it is written: the generator of its noise, its machine and runs, what is at work as [(way, cause, mm)]."""

    rng: np.random.Generator
    about: str
    name: str
    log: dict
    runs: list
    designs: list
    noise: dict
    floor: float
    left: list
    drawn: list


def made(kind, seed):
    """What a seed's case is."""
    rng = np.random.default_rng([seed, 5])
    about = theme(kind, seed)
    log = _log(rng, _show(rng, about))
    if about == "measurement_drift" or (about in ("payload", "thermal_drift") and rng.random() < 0.6):
        log["frame"] = "world"
        log["target"] = "tool" if about == "payload" else log["target"]
    name, robot = _machine(kind, rng, about)
    runs = _runs(kind, rng, robot, about, log)
    setting = Setting(robot, runs, log)
    designs = [design.Design(r, log) for r in runs]
    noise, floor = _noise(rng, kind, log, runs)
    left = _left(kind, rng, setting, designs, floor)
    drawn = _drawn(kind, rng, setting, designs, about, floor, left[0][2] if left else 0.0)
    return Made(rng, about, name, log, runs, designs, noise, floor, left, drawn)


def case(kind, seed, folder, off=False):
    """Writes a case's cell and logs into `folder`; its label. `off` leaves out all that is at work."""
    got = made(kind, seed)
    robot, left, drawn = kind.cells[got.name](), [] if off else got.left, [] if off else got.drawn
    field = plumbing._told(*left[0], got.designs) if left else {"size_mm": 0.0, "alike": []}
    label = {
        "seed": seed, "family": kind.name, "cell": robot.name, "robot": got.name, "about": got.about, "kind": str(len(drawn)),
        "log": got.log, "noise": got.noise, "noise_mm": got.floor, "leftover_mm": field["size_mm"],
        "leftover_alike": field["alike"], "causes": [plumbing._told(*d, got.designs) for d in drawn], "rows": [],
        "target_mm": [0.0, 0.0, 0.0],
    }  # fmt: skip
    folder.mkdir(parents=True, exist_ok=True)
    causes = [c for _, c, _ in (*left, *drawn)]
    plumbing._write(folder, robot, got.runs, causes, got.log, got.noise, got.rng, label)
    if got.log["show"] == "poses" and got.rng.random() < 0.5:
        label["temperature"] = True
        names = [*(f"run_{'abc'[k]}" for k in range(len(got.runs) - 1)), "withheld"]
        for run, name in zip(got.runs, names, strict=True):
            _warmth(folder, run, name, causes, got.rng)
    return label
