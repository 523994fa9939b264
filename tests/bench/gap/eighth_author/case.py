"""A case from a seed and a number: what it is about, sizes, logs, files and label."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field

import numpy as np
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from gap.eighth_author.bodies import MACHINES, placed
from gap.eighth_author.like import DRIVES, alike
from gap.eighth_author.strange import FOREIGN, leftover
from gap.eighth_author.ways import DRIVES as ALONE
from gap.eighth_author.ways import PATHS, POSES, worked
from gap.eighth_author.wear import WORN
from gap.eighth_author.works import NAMED
from gap.eighth_author.world import Acts, logged, off, rms, sized, taken, together

SEED = 80_511
COUNT = {"none": 5, "outside": 8, "one": 12, "two": 7, "three": 4}
LEFT = 18  # of those with something have a leftover
CORRELATED = 9
ALL = NAMED | WORN
BY_KEY = {make.__name__: make for make in MACHINES}

_ANY = tuple(BY_KEY)
_LOADED = ("ceiling", "winder", "boom")
_BOTH, _PATH, _SERVO = ("path", "poses"), ("path",), ("path", "drives")
WHERE = {
    "frame_base": (_ANY, _BOTH), "frame_tool": (_ANY, _BOTH), "frame_table": (("winder",), _BOTH),
    "turntable": (("winder",), _BOTH),
    "joint_offset": (_ANY, _BOTH), "geometry": (_ANY, _BOTH), "joint_compliance": (_LOADED, _BOTH), "payload": (_LOADED, _BOTH),
    "lean": (("winder", "turret", "dispenser", "ceiling"), _BOTH), "backlash": (_ANY, _BOTH), "hysteresis": (_ANY, _PATH),
    "gear_ripple": (_ANY, _PATH), "motor_commutation": (_ANY, _SERVO), "servo_lag": (_ANY, _SERVO),
    "setpoint_delay": (_ANY, _SERVO), "acceleration_error": (_LOADED, _PATH), "friction": (_ANY, _SERVO),
    "wrist_coupling": (("portal", "boom", "ceiling", "winder", "turret"), _BOTH), "thermal_drift": (_ANY, _BOTH),
    "track": (("boom",), _BOTH), "measurement_scale": (_ANY, _BOTH), "measurement_drift": (_ANY, _BOTH),
    "latency": (_ANY, _PATH), "cutting_force": (("ceiling", "winder", "boom", "dispenser"), _PATH),
    "early_reading": (_ANY, ("poses",)),
}  # fmt: skip
TABLE = {"frame_table", "turntable"}
GAUGE = {"measurement_scale", "measurement_drift", "frame_base", "track"}
NOTHING = (("turret", "path"), ("winder", "poses"), ("boom", "drives"), ("dispenser", "path"), ("portal", "path"))


def _fits(names):
    """(machines, logs) on which all of these can be met."""
    if (
        len(set(names)) < len(names)
        or (TABLE & set(names) and (GAUGE | TABLE) & set(names) - TABLE)
        or set(names) >= TABLE
    ):
        return set(), set()
    return set.intersection(*(set(WHERE[n][0]) for n in names)), set.intersection(*(set(WHERE[n][1]) for n in names))


def _groups(rng):
    """All names once, half of them twice, dealt out to ones, twos and threes that can stand together."""
    sizes = [1] * COUNT["one"] + [2] * COUNT["two"] + [3] * COUNT["three"]
    again = rng.choice(sorted(ALL), sum(sizes) - len(ALL), replace=False)
    while True:
        bag, out, first = rng.permutation([*sorted(ALL), *again]).tolist(), [], 0
        for size in sizes:
            out.append(bag[first : first + size])
            first += size
        if all(all(_fits(g)) for g in out):
            return out


def planned(seed):
    """[{kind, names, machine, log, left: share of the noise or None, correlated}], in an order that says nothing; each
    sort of log often enough."""
    rng = np.random.default_rng([seed, 8])
    while True:
        plan = _dealt(rng)
        count = [sum(p["log"] == log for p in plan) for log in ("path", "poses", "drives")]
        if count[1] >= 8 and count[2] >= 5:
            return plan


def _dealt(rng):
    plan = [{"kind": "none", "names": [], "machine": m, "log": log} for m, log in NOTHING]
    plan += [{"kind": "outside", "names": [f.__name__], "machine": m, "log": log} for f, (m, log) in FOREIGN.items()]
    used = dict.fromkeys(_ANY, 0)
    for p in plan:
        used[p["machine"]] += 1
    for names in sorted(_groups(rng), key=lambda g: len(_fits(g)[0])):
        machines, logs = _fits(names)
        machine = min(sorted(machines), key=lambda m: used[m] + 0.5 * rng.random())
        used[machine] += 1
        log = str(rng.choice(sorted(logs), p=[0.6, 0.4] if len(logs) == 2 else None))
        if logs == set(_SERVO):
            log = str(rng.choice(["path", "drives"], p=[0.4, 0.6]))
        plan.append({"kind": ("one", "two", "three")[len(names) - 1], "names": names, "machine": machine, "log": log})
    for p in plan:
        p |= {"left": None, "correlated": False}
    some = rng.permutation([p for p in plan if p["names"]])[:LEFT]
    shares = np.exp(np.log(30) * (rng.permutation(LEFT) + rng.random(LEFT)) / LEFT)
    low, rest = [s for s in shares if s < 4], [s for s in shares if s >= 4]
    for p in sorted(some, key=lambda p: p["kind"] != "outside"):  # what has no name stands beside little else
        pile = low if low and (p["kind"] == "outside" or not rest) else rest
        p["left"] = float(pile.pop())
    named = [p for p in some if p["kind"] != "outside"]
    for p, share in zip(named, rng.permutation([p["left"] for p in named]), strict=True):
        p["left"] = float(share)
    paths = [p for p in plan if p["log"] == "path"]
    quiet = [p for p in paths if not p["names"]][:2]
    for p in [*quiet, *rng.permutation([p for p in paths if p["names"]])[: CORRELATED - len(quiet)]]:
        p["correlated"] = True
    return [plan[i] for i in rng.permutation(len(plan))]


@dataclass
class Case:
    plan: dict
    how: dict
    runs: list  # the last is withheld
    causes: list = field(default_factory=list)  # (cause, size)
    left: list = field(default_factory=list)
    noise: float = 0.0  # 3-D rms, mm
    left_mm: float = 0.0


def _how(plan, m, rng):
    names, log = set(plan["names"]), plan["log"]
    drives = any(n in DRIVES for n in names)
    frame = "unknown" if rng.random() < 0.35 else "world"
    if names & {"frame_base", "measurement_scale", "graduated_circle"}:
        frame = "world"
    if names & TABLE:
        frame = "base"
    if log == "drives":
        frame = "world"
    target = (
        "unknown"
        if rng.random() < 0.25
        and log != "drives"
        and not names & {"frame_tool", "wrist_coupling", "spindle_growth", "floating"}
        else "tool"
    )
    lacks = (
        str(rng.choice(["encoders", "encoders" if drives else "setpoints"]))
        if log == "path" and rng.random() < 0.35
        else ""
    )
    if "latency" in names and lacks == "setpoints":
        lacks = "encoders"
    here = m.tip(m.middle[None])[0, :3, 3]
    bearing = rng.uniform(0, 2 * np.pi)
    sigma = m.grain * np.exp(rng.uniform(-0.2, 0.35))
    stand = (
        here + rng.uniform(2.2, 4) * np.array([np.cos(bearing), np.sin(bearing), 0]) + [0, 0, rng.uniform(-0.3, 0.3)]
    )
    return {
        "log": log, "frame": frame, "target": target, "lacks": lacks, "stand": stand,
        "reflector": rng.uniform(-1, 1, 3) * 0.09 if target == "unknown" else np.zeros(3),
        "sigma": sigma,
        "sigma_deg": 0.003 * np.exp(rng.uniform(-0.5, 0.5)), "axis": rng.uniform(4e-4, 1.2e-3) * (1 if log != "drives" else 1.6),
        "turns": target == "tool" and rng.random() < 0.3,
        "told": log == "poses" or rng.random() < 0.75,
        "tau": rng.uniform(0.3, 3) if plan["correlated"] else 0.0,
        "gross": 0.01 if log == "path" and rng.random() < 0.25 else 0.0, "broken": log == "path" and rng.random() < 0.2,
        "seed": int(rng.integers(1 << 40)), "same": rng.random() < 0.5, "temp": "thermal_drift" in names or rng.random() < 0.2,
    }  # fmt: skip


def _runs(plan, m, rng):
    count, out, since = 1 + int(rng.random() < 0.5), [], rng.uniform(0, 200)
    kinds = rng.permutation(sorted({"path": PATHS, "poses": POSES, "drives": ALONE}[plan["log"]]))
    for k in range(count + 1):
        kind = kinds[k % len(kinds)] if k < count or rng.random() < 0.5 else kinds[0]
        if plan["log"] == "path":
            run = worked(m, rng, kind, int(rng.integers(650, 950)))
        elif plan["log"] == "poses":
            run = POSES[kind](m, rng, int(rng.integers(45, 90) if k < count else rng.integers(30, 50)))
        else:
            run = ALONE[kind](m, rng, int(rng.integers(800, 1000)))
        run.facts["since"] = since
        since += run.t[-1] + rng.uniform(30, 200)
        out.append(run)
    return out


def _axis_noise(m, how):
    return how["axis"] * m.unit


def _drawn(plan, rng, less=1.0):
    """A case, or nothing where a cause comes out too small to be asked for; `less` of the leftover that was planned."""
    m = BY_KEY[plan["machine"]]()
    how, runs = _how(plan, m, rng), _runs(plan, m, rng)
    case, last = Case(plan, how, runs), runs[-1]
    jac = m.jacobian(last.c[last.pick])[:, :3] * _axis_noise(m, how)
    case.noise = 1e3 * rms(np.sqrt((jac**2).sum(-1))) if how["log"] == "drives" else np.sqrt(3) * how["sigma"]
    if plan["left"]:
        cause = leftover(m, rng, how["log"])
        size, case.left_mm = sized(cause, last, how, min(max(less * plan["left"], 1) * case.noise, 1.2))
        case.left = [(cause, size)]
    foreign = plan["kind"] == "outside"
    makers = {f.__name__: f for f in FOREIGN} if foreign else ALL
    for name in plan["names"]:
        low, high = ((1.5, 4) if foreign else (0.5, 3)) if case.left_mm else ((3, 15) if foreign else (1.5, 20))
        target = (case.left_mm or case.noise) * np.exp(rng.uniform(np.log(low), np.log(high)))
        cause = makers[name](m, rng, how["stand"])
        size, reached = sized(cause, last, how, min(max(target, 1.5 * case.noise), 2.5))
        if reached < max((2 if foreign else 1) * case.noise, 0.3 * case.left_mm) or reached > 3.0:
            return None
        case.causes.append((cause, size))
    before, after = perfect(case)
    return None if plan["names"] and not foreign and after > 0.97 * before else case


def made(seed, number):
    plan = planned(seed)[number]
    for attempt in range(80):
        case = _drawn(plan, np.random.default_rng([seed, number, attempt]), 0.6 ** (attempt // 2))
        if case is not None:
            return case
    raise RuntimeError(f"{plan}: no case of eighty came out")


def acts(case, run, parts=None):
    """All that is at work in a run, or these (cause, size)."""
    return together([c.act(run, s) for c, s in (case.causes + case.left if parts is None else parts)] or [Acts()])


def _alone(case, run, cause, size):
    """rms in mm of one cause, less what the log's own unknowns take up."""
    return rms(taken(run, off(run, cause.act(run, size), case.how), case.how))


def perfect(case):
    """rms in mm on the withheld log with all, and without what has a name, noise included."""
    last = case.runs[-1]
    rest = case.left if case.plan["kind"] != "outside" else case.left + case.causes
    both = [rms(taken(last, off(last, acts(case, last, p), case.how), case.how)) for p in (None, rest)]
    return tuple(float(np.hypot(x, case.noise)) for x in both)


def label(case, look=True):
    """What is to be found, with what these logs can't tell from it."""
    for run in case.runs:
        run.facts["force"] = acts(case, run).force
    like = alike(case.runs, case.how, case.causes, sorted(ALL)) if look else {}
    before, after = perfect(case)
    last = case.runs[-1]
    moved = {c.name: _alone(case, last, c, s) for c, s in case.causes + case.left}
    return {
        "kind": case.plan["kind"], "machine": case.plan["machine"], "log": case.plan["log"],
        "motions": [r.kind for r in case.runs],
        "noise_mm": round(case.noise, 4), "left_mm": round(moved.get("leftover", 0.0), 4),
        "correlated_s": round(case.how["tau"], 2),
        "frame": case.how["frame"], "target": case.how["target"], "lacks": case.how["lacks"],
        "effects": {
            c.name: {
                "size": round(moved[c.name] / case.noise, 2), "rms_mm": round(moved[c.name], 4), "axes": c.axes,
                "stage": c.stage, "follows": list(c.follows), "alike": like.get(c.name, []), "amount": float(f"{s:.4g}"),
            }
            for c, s in case.causes
        },
        "perfect": {"rms_before_mm": round(before, 4), "rms_after_mm": round(after, 4)},
    }  # fmt: skip


def write(case, folder, parts=None):
    """Folder of a case: its cell, its logs, nothing of what is wrong with it."""
    m = case.runs[0].machine
    (folder / "cell").mkdir(parents=True, exist_ok=True)
    (folder / "cell" / "cell.toml").write_text(m.cell(), encoding="utf-8")
    for k, run in enumerate(case.runs):
        name = "withheld" if k + 1 == len(case.runs) else f"run{k + 1}"
        rng = np.random.default_rng([case.how["seed"], k])
        columns = _columns(case, run, acts(case, run, parts), rng, k)
        with (folder / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
            out = csv.writer(file, lineterminator="\n")
            out.writerow(columns)
            out.writerows([["" if x != x else f"{x:.9g}" for x in row] for row in zip(*columns.values(), strict=True)])
        (folder / f"{name}.toml").write_text(_told(case, m, k), encoding="utf-8")


def _noise(rng, run, how, shape):
    white = rng.normal(0, 1, shape)
    if not how["tau"]:
        return white
    keep = np.exp(-np.gradient(run.t[run.pick]).mean() / how["tau"])
    slow = lfilter(
        [np.sqrt(1 - keep**2)], [1, -keep], rng.normal(0, 1, shape), axis=0, zi=keep * rng.normal(0, 1, (1, *shape[1:]))
    )[0]
    return np.sqrt(0.85) * slow + np.sqrt(0.15) * white


def _columns(case, run, what, rng, k):
    m, how = run.machine, case.how
    c, e, tip = logged(run, what, how)
    e = e + rng.normal(0, 1, e.shape) * _axis_noise(m, how)
    out = {"t": np.round(run.t[run.pick], 4)}
    if how["log"] != "drives":
        out |= _measured(case, run, tip, rng, k)
    for values, before in ((m.values(e), ""), (m.values(c), "c")):
        if how["lacks"] != {"": "encoders", "c": "setpoints"}[before]:
            out |= {before + n: x for n, x in zip(m.names, values.T, strict=True)}
    if how["log"] == "drives" and m.key in ("boom", "winder"):
        load = -m.loads(c) + 0.02 * np.abs(m.loads(m.middle[None])).max() * np.tanh(run.v[run.pick] / 0.05)
        out |= {
            f"T{n[1:]}": load[:, i] * (1 + rng.normal(0, 0.01, len(load))) for i, n in enumerate(m.names) if n[0] == "A"
        }
    if how["temp"] and how["log"] != "drives":
        warm = what.warmth[run.pick] if what.warmth is not None else 2 * np.sin(run.t[run.pick] / 500)
        out["temp"] = np.round(22 + warm + rng.normal(0, 0.1, len(warm)), 1)
    if what.force is not None:
        force = what.force[run.pick] + rng.normal(0, 0.03, (len(c), 3)) * np.abs(what.force).max()
        out |= dict(zip(("fx", "fy", "fz"), force.T, strict=True))
    return out


def _measured(case, run, tip, rng, k):
    """x, y, z in mm, turns in degrees where they are measured, in the instrument's own frame where that is unknown."""
    how = case.how
    if how["frame"] == "unknown":
        own = np.random.default_rng([case.how["seed"], 99, 0 if how["same"] else k])
        turn = Rotation.from_rotvec(own.normal(0, 1, 3)).as_matrix()
        tip = placed(turn, own.uniform(-3, 3, 3)) @ tip
    at = 1e3 * tip[:, :3, 3] + how["sigma"] * _noise(rng, run, how, (len(tip), 3))
    gross = rng.random(len(tip)) < how["gross"]
    at[gross] += rng.normal(0, 1, (gross.sum(), 3)) * rng.uniform(0.5, 2)
    if how["broken"]:
        first = int(rng.uniform(0.2, 0.7) * len(at))
        at[first : first + len(at) // 40] = np.nan
    out = dict(zip("xyz", at.T, strict=True))
    if how["turns"]:
        shake = Rotation.from_rotvec(np.radians(how["sigma_deg"]) * rng.normal(0, 1, (len(tip), 3)))
        turns = (shake * Rotation.from_matrix(tip[:, :3, :3])).as_euler("ZYX", degrees=True)
        turns[np.isnan(at[:, 0])] = np.nan
        out |= dict(zip("abc", turns.T, strict=True))
    return out


def _told(case, m, k):
    """What stands beside a log."""
    how, lines = case.how, [f"payload_kg = {m.payload}"]
    if how["log"] == "drives" or how["told"]:
        lines.append(f"sigma_axis_deg = {how['axis']:.5f}\nsigma_axis_mm = {how['axis']:.5f}")
    if how["log"] != "drives":
        lines += [f'measured_frame = "{how["frame"]}"', f'target = "{how["target"]}"']
        if how["told"]:
            lines.append(
                f"sigma_mm = {how['sigma']:.4f}" + (f"\nsigma_deg = {how['sigma_deg']:.4f}" if how["turns"] else "")
            )
        if k and how["same"] and how["frame"] == "unknown":
            lines.append('same_frame_as = "run1.csv"')
        if k and how["target"] == "unknown":
            lines.append('same_target_as = "run1.csv"')
    if case.plan["log"] == "poses":
        lines.append("poses = true")
    return "\n".join(lines) + "\n"
