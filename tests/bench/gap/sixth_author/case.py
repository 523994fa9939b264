"""A case from a seed: which machine, which logs, what is wrong with it and by how much; its files, and its label."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from gap.sixth_author import cells, foreign, moves
from gap.sixth_author.chain import Machine, cell_text, frame
from gap.sixth_author.design import alike
from gap.sixth_author.known import MAKERS, MOST
from gap.sixth_author.world import Cause, Run, free_of, off_by, played, rms

POSES = {
    "frame_base", "frame_tool", "frame_table", "joint_offset", "geometry", "track", "turntable", "joint_compliance", "payload",
    "lean", "backlash", "hysteresis", "gear_ripple", "wrist_coupling", "thermal_drift", "early_reading", "measurement_scale",
    "measurement_drift",
}  # fmt: skip
DRIVES = {"servo_lag", "friction", "setpoint_delay", "motor_commutation"}
INNER = {
    *DRIVES,
    "limit_cycle",
    "starved_bus",
}  # between set-point and encoder: nothing of them shows without set-points
ONE_AXIS = {
    "backlash", "hysteresis", "gear_ripple", "acceleration_error", "latency", "measurement_scale", "measurement_drift", *DRIVES,
}  # fmt: skip
NO_LOAD = {"joint_compliance", "payload", "lean"}
# how many cases of each kind
COUNTS = {
    "DEV": {"none": 4, "outside": 6, "mixed": 3, "one": 12, "two": 9, "three": 4, "four": 2},
    "SEALED": {"none": 6, "outside": 10, "mixed": 4, "one": 18, "two": 13, "three": 6, "four": 3},
}
LEFT = 0.65  # of those with something wrong: a leftover beside it
FIRST = {"DEV": 61000, "SEALED": 62000}
MANY = {"none": 0, "outside": 0, "mixed": 1, "one": 1, "two": 2, "three": 3, "four": 4}


@dataclass
class Case:
    """All of a case, before it is written."""

    key: str
    family: str
    kind: str
    machine: Machine
    log: dict
    runs: list[Run]
    sigma: float
    named: list[Cause] = field(default_factory=list)
    nameless: list[Cause] = field(default_factory=list)
    left: list[Cause] = field(default_factory=list)
    sizes: dict = field(default_factory=dict)

    @property
    def causes(self):
        """All that is at work."""
        return [*self.named, *self.nameless, *self.left]

    @property
    def noise(self):
        """3-D rms in mm of what the noise of the instrument (of encoders) makes."""
        return noise_of(self.runs[-1], self.sigma, self.log)


def noise_of(run, sigma, log):
    """See `Case.noise`."""
    if not log["drives"]:
        return sigma * np.sqrt(3)
    jac = run.machine.jacobian(run.c[run.rows])[:, :3] * 1e3
    at = np.array(
        [log["sigma_axis_mm"] * 1e-3 if j.slides else np.radians(log["sigma_axis_deg"]) for j in run.machine.joints]
    )
    return float(np.sqrt(((jac * at) ** 2).sum((1, 2)).mean()))


def planned(family):
    """[(kind, the name or nameless cause that it is about, share of the leftovers' range or None)] of a family's cases."""
    rng = np.random.default_rng([FIRST[family], 7])
    names, strange = list(MAKERS), list(foreign.DEV if family == "DEV" else foreign.SEALED)
    rng.shuffle(names)
    rng.shuffle(strange)
    out, at, odd = [], 0, 0
    for kind, count in COUNTS[family].items():
        for _ in range(count):
            if kind == "none":
                out.append((kind, ""))
            elif kind in ("outside", "mixed"):
                out.append((kind, strange[odd % len(strange)]))
                odd += 1
            else:
                out.append((kind, names[at % len(names)]))
                at += 1
    rng.shuffle(out)
    wrong = [i for i, (kind, _) in enumerate(out) if kind != "none"]
    rng.shuffle(wrong)
    some = wrong[: round(LEFT * len(wrong))]
    share = {i: (k + 0.5) / len(some) for k, i in enumerate(some)}
    return [(str(k), str(n), share.get(i)) for i, (k, n) in enumerate(out)]


def fits(name, machine, show, tied, force):
    """A cause may be at work on such a machine and in such a log."""
    if name in DRIVES:
        return show != "poses"
    if show == "drives" or (show == "poses" and name not in POSES) or (show == "path" and name == "early_reading"):
        return False
    if name in ("frame_table", "turntable"):
        return tied
    if name == "track":
        return "E1" in machine.names
    if name == "cutting_force":
        return force and len(machine.turning) >= 6
    if name == "wrist_coupling":
        return len(machine.turning) >= 6
    if len(machine.joints) == 1:
        return name in ONE_AXIS or (machine.name == "level_axis" and name in ("joint_compliance", "payload"))
    if name in NO_LOAD and machine.name == "scara":
        return False
    return not (name in ("lean", "early_reading") and machine.name == "gantry")


def _shown(rng, about, kind, second):
    """Which sort of logs."""
    if kind in ("outside", "mixed"):
        return str(rng.choice((foreign.SEALED if second else foreign.DEV)[about][1]))
    if about in DRIVES:
        return "drives" if rng.random() < 0.75 and kind != "four" else "path"
    if about == "early_reading" or (about in POSES and rng.random() < 0.55):
        return "poses"
    return "drives" if about == "" and rng.random() < 0.25 else "path"


def _log_of(rng, machine, show, about, sigma):
    """What is told and what is logged."""
    one, table = len(machine.joints) == 1, machine.table
    world = "base" if table and (about in ("frame_table", "turntable") or rng.random() < 0.3) else "world"
    log = {"frame": world, "target": "tool", "drives": show == "drives", "encoders": True, "setpoints": True}
    if world == "world" and not one and about != "frame_base" and rng.random() < (0.4 if show == "poses" else 0.25):
        log["frame"] = "unknown"
    if about != "frame_tool" and not one and rng.random() < 0.25:
        log["target"] = "unknown"
    if show == "path" and rng.random() < 0.2 and about not in INNER:
        log["encoders" if rng.random() < 0.5 else "setpoints"] = False
    if show == "poses" and rng.random() < 0.5:
        log["setpoints"] = False
    log["six"] = show != "drives" and log["target"] == "tool" and rng.random() < 0.3
    log["masses"] = bool(rng.random() < 0.6)
    log["torque"] = show == "drives" or (show == "path" and rng.random() < 0.25)
    log["temp"] = (about == "thermal_drift" and rng.random() < 0.6) or rng.random() < 0.2
    log["told"] = bool(rng.random() < 0.8) or show == "poses"  # a few poses can't show it, so the contract asks for it
    log["noise"] = str(rng.choice(["white", "white", "correlated", "by range"]))
    log["gross"] = float(rng.choice([0, 0, 0.01, 0.04]))
    log["sigma_axis_deg"], log["sigma_axis_mm"] = float(rng.choice([2e-4, 5e-4, 1e-3])), 0.002
    log["axis_told"] = bool(rng.random() < 0.6)
    return log


def _runs(rng, machine, show, about, second, log, force):
    """The logs' motions, the withheld one last."""
    slow = about in ("thermal_drift", "measurement_drift", "sunlit_column", "tired_balancer", "bent_link")
    count = int(rng.integers(3, 5)) if slow else int(rng.integers(1, 4))
    gap, begins = (
        (rng.uniform(600, 2400), rng.uniform(0, 120)) if slow else (rng.uniform(120, 900), rng.uniform(600, 9000))
    )
    rate = float(rng.choice([50, 125, 250] if show == "drives" else [5, 10, 20, 25]))
    made, kind = [], rng.random()
    size = [int(rng.choice([10, 14, 20, 30, 45, 60, 90, 120])) for _ in range(count)]
    long = float(rng.choice([25, 40] if show == "drives" else [35, 60, 110, 190]))
    least = 12 if log["frame"] == "unknown" or log["target"] == "unknown" else 10
    for n in range(count + 1):
        withheld = n == count
        more = {"number": n, "tied": log["frame"] == "base", "begins": begins + n * gap}
        if withheld and slow and second:
            more["cooled"] = 0.6 * more["begins"]
        name = "withheld" if withheld else f"run{n + 1}"
        if show == "poses":
            places = (moves.scan_poses if second else moves.cube_poses)(
                machine, max(least, 25 if withheld else size[n]), rng
            )
            run = moves.stops(machine, name, places, 0.9, pace=float(rng.uniform(15, 60)) if slow else 12.0, **more)
        else:
            run, seconds = None, long * (0.7 if withheld else 1)
            if show == "path" and len(machine.turning) >= 6 and (kind < 0.75 or force):
                for _ in range(8):
                    run = run or moves.milled(machine, name, seconds, rate, rng, second, **more)
            run = run or (moves.shuttle if second else moves.fourier)(machine, name, seconds, rate, rng, **more)
            if len(run.rows) > 5000:
                run = replace(run, rows=run.rows[:5000])
            if force:
                run.force = _pushed(run, rng)
        made.append(run)
    return made


def _pushed(run, rng):
    """A cut's force in world: against the way and off the face, with engagement by stretches and the teeth's ripple."""
    p = run.nominal[:, :3, 3]
    way = np.gradient(p, run.at, axis=0)
    pace = np.linalg.norm(way, axis=1)[:, None]
    way = way / (pace + 1e-4)
    period = rng.uniform(5, 14)
    engaged = np.clip(1.5 * np.sin(2 * np.pi * run.at / period + rng.uniform(0, 6)) + 0.6, 0, 1)[:, None]
    normal = run.nominal[:, :3, 2]
    force = engaged * (-rng.uniform(80, 350) * way + rng.uniform(40, 200) * normal)
    return force * (1 + 0.05 * rng.normal(size=(len(p), 1)))


def sized(cause, run, log, target, most):
    """A cause as large as is wanted, or as its kind can be; None where it can't be seen at all."""

    def size(gain):
        return rms(free_of(off_by(run, [cause.of(gain)], log["drives"]), run, log))

    gain, got, slope = cause.gain, size(cause.gain), 1.0
    for _ in range(8):
        if not np.isfinite(got) or got < 1e-9:
            return None, 0.0
        if abs(got / target - 1) < 0.03:
            break
        to = float(np.clip(gain * np.clip((target / got) ** (1 / slope), 0.05, 20), 0.003, most))
        if to == gain:
            break
        now = size(to)
        if now > 1e-9:
            slope = float(np.clip(np.log(now / got) / np.log(to / gain), 0.4, 5))
        gain, got = to, now
    return cause.of(gain), got


def made(family, number) -> Case:
    """Case `number` (from 0) of a family."""
    second = family == "SEALED"
    kind, about, share = planned(family)[number]
    for attempt in range(40):
        case = _try(family, number, attempt, kind, about, share, second)
        if case is not None:
            return case
    raise RuntimeError(f"{family} {number}: no case about {about} came out in 40 draws")


def _try(family, number, attempt, kind, about, share, second):
    rng = np.random.default_rng([FIRST[family] + number, attempt])
    machines = [m() for m in (cells.SEALED if second else cells.DEV)]
    show = _shown(rng, about, kind, second)
    force = show == "path" and (about == "cutting_force" or rng.random() < 0.12)
    able = machines
    if about in MAKERS:
        able = [m for m in machines if fits(about, m, show, m.table, force)]
    elif about:
        able = [m for m in machines if len(m.joints) > 1 and not (about == "tired_balancer" and len(m.turning) < 6)]
        if about == "filling_hose":
            able = [m for m in able if len(m.turning) >= 6]
    if MANY[kind] >= 3:
        able = [m for m in able if len(m.joints) > 1] or able
    if not able:
        return None
    often = np.array([0.4 if m.name == "table_arm" else 1.0 for m in able])  # themes of tables bring it as it is
    machine = able[int(rng.choice(len(able), p=often / often.sum()))]
    sigma = float(rng.choice([0.01, 0.015, 0.02, 0.03, 0.05, 0.08])) * (0.5 if machine.reach < 0.7 else 1)
    log = _log_of(rng, machine, show, about, sigma)
    seen = machine
    if log["target"] == "unknown":
        log["target_mm"] = [float(x) for x in rng.uniform(-120, 120, 3)]
        t = frame(*machine.tool) @ frame(*log["target_mm"], 0, 0, 0)
        seen = replace(machine, tool=(*(t[:3, 3] * 1e3), *machine.tool[3:]))
    runs = _runs(rng, seen, show, about, second, log, force)
    key = f"{family.lower()}{number:02d}"
    case = Case(key, family, kind, machine, log, runs, sigma)
    return case if _filled(case, rng, about, share, second, show, force) else None


def _filled(case, rng, about, share, second, show, force):
    """Draw what is wrong; False where it doesn't come out as it should."""
    machine, log, last, noise = case.runs[0].machine, case.log, case.runs[-1], case.noise
    rest = 0.0
    if share is not None:
        draw = foreign.drives_rest(machine, rng, second) if log["drives"] else None
        draw = draw or (foreign.elastic_rest if second else foreign.fourier_twists)(machine, rng)
        want = min(noise * 30**share, 1.2)
        cause, rest = sized(draw, last, log, want, 1e4)
        if cause is None:
            return False
        case.left, case.sizes["leftover"] = [cause], rest
    names = [about] if about in MAKERS else []
    while len(names) < MANY[case.kind]:
        able = [n for n in MAKERS if n not in names and fits(n, machine, show, last.tied, force)]
        able = [n for n in able if not (n == "frame_base" and log["frame"] == "unknown")]
        able = [n for n in able if not (n == "frame_tool" and log["target"] == "unknown")]
        able = [n for n in able if log["setpoints"] or n not in INNER]
        if not able:
            return False
        names.append(str(rng.choice(able)))
    for name in names:
        want = noise * 25 ** rng.uniform(0.05, 1)
        if rest:
            want = max(want, rest * 0.4 * 10 ** rng.random())
        cause, size = sized(MAKERS[name](machine, rng, second), last, log, min(want, 4.0), MOST[name])
        if cause is None or size < 0.7 * noise or (name == about and rest and size < 0.35 * rest):
            return False
        case.named.append(cause)
        case.sizes[name] = size
    if about and about not in MAKERS:
        table = foreign.SEALED if second else foreign.DEV
        want = max(noise * 3 * 7 ** rng.random(), 1.5 * rest)
        cause, size = sized(table[about][0](machine, rng), last, log, min(want, 3.0), 60.0)
        if cause is None or size < 1.5 * noise:
            return False
        case.nameless.append(cause)
        case.sizes[about] = size
    return not case.named or label(case, look=False)["perfect"]["shrink"] > 0.03


def _plain(x):
    if isinstance(x, dict):
        return {k: _plain(v) for k, v in x.items()}
    if isinstance(x, (list, tuple)):
        return [_plain(v) for v in x]
    return x.tolist() if isinstance(x, (np.ndarray, np.generic)) else x


def _thin(run):
    every = 1 if run.pace else max(1, len(run.rows) // 250)
    force = None if run.force is None else run.force[::every]
    return replace(run, rows=run.rows[::every], force=force)


def label(case: Case, look=True) -> dict:
    """What is wrong, by how much, and what a perfect diagnosis takes off the withheld log."""
    last, log, noise = case.runs[-1], case.log, case.noise
    seen = alike([_thin(r) for r in case.runs], case.named, log, log["drives"]) if case.named and look else {}
    effects = {
        c.name: {
            "size": float(case.sizes[c.name] / noise),
            "rms_mm": float(case.sizes[c.name]),
            **({"axes": list(c.axes)} if c.axes else {}),
            "stage": c.stage,
            "gain": c.gain,
            "params": _plain(c.params),
            "alike": seen.get(c.name, []),
        }
        for c in case.named
    }
    odd = {
        c.name: {
            "size": float(case.sizes[c.name] / noise),
            "rms_mm": float(case.sizes[c.name]),
            **({"axes": list(c.axes)} if c.axes else {}),
            "stage": c.stage,
            "follows": list(c.follows),
            "gain": c.gain,
        }
        for c in case.nameless
    }
    whole, named = (free_of(off_by(last, c, log["drives"]), last, log) for c in (case.causes, case.named))
    before, after = np.hypot(rms(whole), noise), np.hypot(rms(whole - named), noise)
    return {
        "kind": "three" if case.kind == "four" else case.kind,
        "count": len(case.named),
        "effects": odd if case.kind == "outside" else effects,
        "foreign": odd,
        "discrepancy": {
            "rms_mm": float(case.sizes.get("leftover", 0.0)),
            "times_noise": float(case.sizes.get("leftover", 0.0) / noise),
            "of": case.left[0].params["of"] if case.left else "",
        },
        "noise_mm": noise,
        "perfect": {
            "rms_before_mm": float(before),
            "rms_after_mm": float(after),
            "shrink": float(1 - after / before),
            "gap_mm": rms(whole),
            "left_mm": rms(whole - named),
        },
        "lacks": "tracker" if log["drives"] else "" if log["encoders"] and log["setpoints"] else "a rung",
        "poses": bool(last.rest),
        "machine": case.machine.name,
        "log": _plain(log),
        "rows": [len(r.rows) for r in case.runs],
    }


def _rows(case, run, rng, own):
    """Columns of a log."""
    m, log, n = run.machine, case.log, len(run.rows)
    got, sliding = played(run, case.causes), any(m.joints[k].slides for k in m.arm)
    t = run.clock if run.rest else run.at - run.at[0]
    columns = {"t": np.round(t, 4)}
    if not log["drives"]:
        columns |= _seen(case, got.tip, n, rng, own, t)
    for k, j in enumerate(m.joints):
        if log["encoders"] or log["drives"]:
            sigma = log["sigma_axis_mm"] if j.slides else log["sigma_axis_deg"]
            columns[j.name] = np.round(got.motor[run.rows, k] / j.unit + sigma * rng.normal(size=n), 5)
        if log["setpoints"] or log["drives"]:
            columns["c" + j.name] = np.round(run.c[run.rows, k] / j.unit, 6)
        if log["torque"] and j.name != "A7" and (j.role == "arm" or not run.tied) and not sliding:
            name = ("TE" if j.name[0] == "E" else "T") + j.name[1:]
            torque = got.torque[run.rows, k]
            columns[name] = np.round(torque + 0.005 * (np.abs(torque).max() + 1) * rng.normal(size=n), 3)
    if log["temp"]:
        columns["temp"] = np.round(21 + 17 * run.heat[:, 1] + 0.1 * rng.normal(size=n), 2)
    if run.force is not None:
        for i, name in enumerate(("fx", "fy", "fz")):
            columns[name] = np.round(run.force[:, i] + 1.5 * rng.normal(size=n), 2)
    return columns


def _seen(case, tip, n, rng, own, t):
    """What the instrument says, with its noise."""
    log, sigma = case.log, case.sigma
    noise = rng.normal(size=(n, 3))
    if log["noise"] == "correlated":
        tau, step = 40.0 if case.runs[0].rest else 0.8, np.diff(t, prepend=t[0])
        for i in range(1, n):
            p = np.exp(-step[i] / tau)
            noise[i] = p * noise[i - 1] + np.sqrt(1 - p * p) * noise[i]
    if log["noise"] == "by range":
        far = np.linalg.norm(tip[:, :3, 3] - np.array([-3.0, 2.0, 1.0]), axis=1)
        noise *= (far / np.sqrt((far**2).mean()))[:, None]
    p = tip[:, :3, 3] * 1e3 + sigma * noise
    bad = rng.random(n) < log["gross"]
    p[bad] += rng.normal(size=(bad.sum(), 3)) * max(0.6, 25 * sigma)
    turn = tip[:, :3, :3]
    if log["frame"] == "unknown":
        p, turn = p @ own[:3, :3].T + own[:3, 3] * 1e3, own[:3, :3] @ turn
    out = {k: np.round(p[:, i], 4) for i, k in enumerate("xyz")}
    if log["six"]:
        shake = Rotation.from_rotvec(np.radians(sigma * 0.05) * rng.normal(size=(n, 3)))
        angles = (Rotation.from_matrix(turn) * shake).as_euler("ZYX", degrees=True)
        out |= {k: np.round(angles[:, i], 5) for i, k in enumerate("abc")}
    return out


def _told(case, run):
    """LOG.toml."""
    log = case.log
    lines = [f'instrument = "{"drives" if log["drives"] else "tracker"}"', f"payload_kg = {case.machine.payload}"]
    if not log["drives"]:
        lines += [f'measured_frame = "{log["frame"]}"', f'target = "{log["target"]}"']
        if log["told"]:
            lines += [f"sigma_mm = {case.sigma}"] + ([f"sigma_deg = {case.sigma * 0.05:.5f}"] if log["six"] else [])
        if run is not case.runs[0]:
            lines += [f'same_frame_as = "{case.runs[0].name}.csv"'] if log["frame"] == "unknown" else []
            lines += [f'same_target_as = "{case.runs[0].name}.csv"'] if log["target"] == "unknown" else []
    if log["axis_told"]:
        lines += [f"sigma_axis_deg = {log['sigma_axis_deg']}", f"sigma_axis_mm = {log['sigma_axis_mm']}"]
    return "\n".join(lines + (["poses = true"] if run.rest else [])) + "\n"


def write(case: Case, folder: Path) -> None:
    """The case's files: cell/cell.toml, run1.csv .., withheld.csv, each with its toml."""
    (folder / "cell").mkdir(parents=True, exist_ok=True)
    (folder / "cell" / "cell.toml").write_text(cell_text(case.machine, case.log["masses"]), encoding="utf-8")
    rng = np.random.default_rng([FIRST[case.family], int(case.key[-2:]), 3])
    own = frame(*rng.uniform(-3000, 3000, 3), *rng.uniform(-180, 180, 1), 0, 0)
    own[:3, :3] = own[:3, :3] @ Rotation.from_rotvec(rng.normal(size=3) * 0.05).as_matrix()
    for run in case.runs:
        columns = _rows(case, run, rng, own)
        with (folder / f"{run.name}.csv").open("w", newline="", encoding="utf-8") as file:
            out = csv.writer(file, lineterminator="\n")
            out.writerow(columns)
            out.writerows(zip(*(x.tolist() for x in columns.values()), strict=True))
        (folder / f"{run.name}.toml").write_text(_told(case, run), encoding="utf-8")
