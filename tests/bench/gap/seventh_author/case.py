"""A case from a seed and its number: what it is about, its logs, the sizes of what is at work, its files and its label."""

from __future__ import annotations

import csv
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from .design import alike
from .foreign import FOREIGN, leftover
from .machines import MACHINES, rigid
from .motions import drives, path, poses
from .named import NAMED
from .shift import read, rms, seen, total

SEED = 20261127
COUNT = {"none": 4, "outside": 8, "one": 10, "two": 6, "three": 2}
LEFT = 15  # of the cases with something in them


def fits(names):
    """Machines on which, and logs in which, all of these show."""
    asks = {a for n in names for a in NAMED[n][2]}
    made = [m() for m in MACHINES]
    able = [
        m.name
        for m in made
        if (m.names[0] == "E1" or "rail" not in asks)
        and (m.n > 5 or "wrist" not in asks)
        and (m.told or "masses" not in asks)
    ]
    kinds = set.intersection({"path", "poses", "drives"}, *(NAMED[n][1] for n in names)) if names else set()
    return able, sorted(kinds), asks


def planned(seed):
    """[(kind of case, names, kind of log, leftover in times the noise or None)], 30 of them in an order of their own."""
    rng = np.random.default_rng([seed, 0])
    names = list(NAMED)
    slots = COUNT["one"] + 2 * COUNT["two"] + 3 * COUNT["three"]
    while True:
        deck = [*rng.permutation(names), *rng.permutation(names)[: slots - len(names)]]
        deck = [str(n) for n in rng.permutation(deck)]
        groups = [
            [deck.pop() for _ in range(k)] for k in [1] * COUNT["one"] + [2] * COUNT["two"] + [3] * COUNT["three"]
        ]
        if all(len(set(g)) == len(g) and fits(g)[0] and fits(g)[1] for g in groups):
            break
    about = [(("one", "two", "three")[len(g) - 1], g, str(rng.choice(fits(g)[1]))) for g in groups]
    about += [("outside", [n], kind) for n, (_, kind) in FOREIGN.items()]
    shares = [*np.geomspace(1, 30, LEFT), *[None] * (len(about) - LEFT)]
    plan = [(*a, shares[i]) for a, i in zip(about, rng.permutation(len(about)), strict=True)]
    plan += [("none", [], k, None) for k in ("path", "path", "poses", "drives")]
    return [plan[i] for i in rng.permutation(len(plan))]


@dataclass
class Case:
    """All that is needed to write one."""

    seed: int
    number: int
    kind: str
    runs: list  # the last is withheld
    causes: list  # [(cause, size)]
    left: list  # likewise, one at most
    sigma: float  # mm an axis, or degrees of encoders
    how: dict  # what the instrument is and what it tells

    def shift(self, run, parts=None):
        return total(run, [c.make(run, s) for c, s in (self.causes + self.left if parts is None else parts)])

    def seen(self, run, parts):
        return 1e3 * seen(run, self.shift(run, parts), self.how["frame"] == "world", self.how["target"])

    @property
    def noise(self):
        """3-D rms, mm; of drives, what their encoders' noise makes at the tool."""
        run = self.runs[-1]
        if run.kind != "drives":
            return self.sigma * np.sqrt(3)
        j = run.machine.jacobian(run.c)[:, :3] * run.machine.units
        return float(1e3 * self.sigma * np.sqrt((j**2).sum((1, 2)).mean()))


def sized(case, cause, want):
    """The size at which a cause makes `want` mm on the withheld log, or its most."""
    size = min(cause.first, cause.most)
    for _ in range(8):
        now = rms(case.seen(case.runs[-1], [(cause, size)]))
        if abs(now - want) < 1e-4 * want:
            break
        size = min(size * float(np.clip(want / max(now, 1e-12), 0.02, 50.0)), cause.most)
    return size


def _how(kind, asks, names, rng):
    """Frame, target, columns, and what LOG.toml says."""
    how = {
        "frame": "world",
        "target": None,
        "turns": False,
        "lacks": "",
        "force": False,
        "temp": False,
        "told": True,
        "gross": 0.0,
    }
    if kind == "drives":
        return how
    if "frame" not in asks and rng.random() < 0.35:
        how["frame"] = "unknown"
    if "target" not in asks and rng.random() < 0.25:
        how["target"] = rng.uniform(-0.09, 0.09, 3)
    how["turns"] = how["target"] is None and rng.random() < 0.3
    if "setpoints" not in asks and rng.random() < 0.35:
        how["lacks"] = str(rng.choice(["setpoints", "encoders"]))
    how["force"] = kind == "path" and ("force" in asks or rng.random() < 0.3)
    how["temp"] = rng.random() < (0.6 if "thermal_drift" in names else 0.3)
    how["told"] = kind == "poses" or rng.random() < 0.8
    how["gross"] = 0.02 if kind == "path" and rng.random() < 1 / 3 else 0.0
    return how


def _runs(machine, kind, rng):
    """One or two logs and a withheld one, some minutes apart."""
    out, begun = [], float(rng.uniform(0, 1500))
    rate = float(rng.choice([10.0, 12.5, 25.0, 50.0] if kind == "path" else [62.5, 125.0]))
    count, short = int(rng.integers(1, 3)), 0.6 if rate in (50.0, 125.0) else 1.0
    for i in range(count + 1):
        if kind == "path":
            run = path(machine, rng, rate, short * rng.uniform(55, 95), begun)
        elif kind == "drives":
            run = drives(machine, rng, rate, short * rng.uniform(24, 40), begun)
        else:
            run = poses(machine, rng, int(rng.integers(28, 80) if i < count else rng.integers(16, 32)), begun)
        out.append(run)
        begun += float(run.t[-1] + rng.uniform(60, 600))
    return out


def made(seed, number):
    """The case, drawn anew where a cause can't be as large as it was to be, at least as large as the noise."""
    kind, names, log, share = planned(seed)[number]
    able, _, asks = fits(names if kind != "outside" else [])
    for again in range(60):
        rng = np.random.default_rng([seed, 1 + number, again])
        chosen = rng.choice(able)
        machine = next(m() for m in MACHINES if m.__name__ == chosen)
        runs = _runs(machine, log, rng)
        if any(np.any(np.abs(run.q - machine.middle) > 3 * np.array(machine.swing) * machine.units) for run in runs):
            continue  # beyond its ranges
        sigma = (
            float(np.exp(rng.uniform(np.log(0.01), np.log(0.05))))
            if log != "drives"
            else float(rng.uniform(2e-4, 8e-4))
        )
        case = Case(seed, number, kind, runs, [], [], sigma, _how(log, asks, names, rng))
        floor = 0.0
        if share is not None:
            floor = min(share * case.noise, 1.2)
            cause = leftover(machine, rng, log)
            case.left = [(cause, sized(case, cause, floor))]
        for name in names:
            cause = (FOREIGN[name] if kind == "outside" else NAMED[name])[0](machine, rng)
            low, high, over = (3, 15, (1.5, 4)) if kind == "outside" else (1.5, 20, (0.5, 3))
            want = max(
                case.noise * np.exp(rng.uniform(np.log(low), np.log(high))), floor * np.exp(rng.uniform(*np.log(over)))
            )
            case.causes.append((cause, sized(case, cause, min(want, 2.5))))
        sizes = [rms(case.seen(case.runs[-1], [c])) for c in case.causes]
        if min(sizes, default=9.0) > max(case.noise, 0.3 * floor) and _shrinks(case):
            return case
    raise ValueError(f"case {number} of seed {seed} can't be made")


def _shrinks(case):
    if case.kind in ("none", "outside"):
        return True
    before, after = gaps(case)
    return 1 - after / before > 0.03


def gaps(case):
    """Rms in mm on the withheld log, noise included, with all and without what has a name."""
    run = case.runs[-1]
    rest = case.left + (case.causes if case.kind == "outside" else [])
    return tuple(float(np.hypot(rms(case.seen(run, parts)), case.noise)) for parts in (case.causes + case.left, rest))


def label(case, look=True):
    """What was wrong; `look`: also which names look the same, which takes a second."""
    run = case.runs[-1]
    effects = {}
    for c, s in case.causes:
        mm = rms(case.seen(run, [(c, s)]))
        effects[c.name] = {
            "size": float(f"{mm / case.noise:.3g}"),
            "rms_mm": float(f"{mm:.4g}"),
            "axes": list(c.axes),
            "stage": c.stage,
            "follows": c.follows,
            "alike": alike(case, c, s) if look else [],
        }
    before, after = gaps(case)
    return {
        "kind": case.kind,
        "machine": run.machine.name,
        "log": run.kind,
        "noise_mm": float(f"{case.noise:.4g}"),
        "left_mm": float(f"{rms(case.seen(run, case.left)):.4g}") if case.left else 0.0,
        "effects": effects,
        "perfect": {"rms_before_mm": float(f"{before:.4g}"), "rms_after_mm": float(f"{after:.4g}")},
    }


def _columns(case, run, shift, rng):
    """The log as {column: values}."""
    m, how = run.machine, case.how
    out = {"t": run.t[run.pick] - run.t[run.pick][0]}
    c, e = m.axes(run.c), m.axes(run.c + shift.enc)
    e = e + (case.sigma if run.kind == "drives" else 1e-5) * rng.normal(size=e.shape)
    if run.kind != "drives":
        seen_T = read(run, shift, how["target"])
        if how["frame"] == "unknown":
            own = np.random.default_rng([case.seed, 100 + case.number])
            seen_T = (
                rigid(
                    *own.uniform(-3000, 3000, 2),
                    own.uniform(-500, 500),
                    *own.uniform(-170, 170, 1),
                    *own.uniform(-2, 2, 2),
                )
                @ seen_T
            )
        at = 1e3 * seen_T[:, :3, 3] + case.sigma * rng.normal(size=(len(seen_T), 3))
        bad = rng.random(len(at)) < how["gross"]
        at += bad[:, None] * rng.normal(size=at.shape) * 35 * case.sigma
        out |= dict(zip("xyz", at.T, strict=True))
        if how["turns"]:
            noise = Rotation.from_rotvec(rng.normal(size=at.shape) * 0.005, degrees=True)
            turns = (noise * Rotation.from_matrix(seen_T[:, :3, :3])).as_euler("ZYX", degrees=True)
            out |= dict(zip("abc", turns.T, strict=True))
    if how["lacks"] != "encoders":
        out |= dict(zip(m.names, e.T, strict=True))
    if how["lacks"] != "setpoints":
        out |= {"c" + n: x for n, x in zip(m.names, c.T, strict=True)}
    if run.kind == "drives":
        v, a = run.at(run.v), run.at(run.a)
        torque = (m.inertia(run.c) * a - run.load + 0.04 * np.abs(run.load).max(0) * np.tanh(v / 0.01)) * np.array(
            m.signs
        )
        torque *= 1 + 0.01 * rng.normal(size=torque.shape)
        out |= {("T" + n if n[0] == "E" else "T" + n[1:]): x for n, x in zip(m.names, torque.T, strict=True)}
    if how["force"]:
        out |= dict(zip(("fx", "fy", "fz"), (run.force + 3 * rng.normal(size=run.force.shape)).T, strict=True))
    if how["temp"]:
        out["temp"] = 21 + 9 * (1 - np.exp(-run.late / 1700)) + 0.1 * rng.normal(size=len(run.late))
    return out


def _says(case, run, name, first):
    how = case.how
    out = [f"payload_kg = {run.machine.masses[-1][1]}"]
    if run.kind == "drives":
        return [*out, f"sigma_axis_deg = {case.sigma:.6f}", f"sigma_axis_mm = {case.sigma:.6f}"]
    out += ["poses = true"] if run.kind == "poses" else []
    out += [f"sigma_mm = {case.sigma:.5f}"] if how["told"] else []
    out += ["sigma_deg = 0.005"] if how["turns"] and how["told"] else []
    target = "tool" if how["target"] is None else "unknown"
    out += ['instrument = "laser tracker"', f'measured_frame = "{how["frame"]}"', f'target = "{target}"']
    if name != first:
        out += [f'same_frame_as = "{first}"'] if how["frame"] == "unknown" else []
        out += [f'same_target_as = "{first}"'] if how["target"] is not None else []
    return out


def write(case, folder, parts=None):
    """cell/, run1.csv.., withheld.csv with what lies beside them; `parts`: only some of what is wrong."""
    m = case.runs[0].machine
    (folder / "cell").mkdir(parents=True, exist_ok=True)
    (folder / "cell" / "cell.toml").write_text(m.cell(), encoding="utf-8")
    _poses(m, folder / "cell" / "poses.csv")
    names = [*(f"run{i + 1}.csv" for i in range(len(case.runs) - 1)), "withheld.csv"]
    for i, (name, run) in enumerate(zip(names, case.runs, strict=True)):
        columns = _columns(
            case, run, case.shift(run, parts), np.random.default_rng([case.seed, 1 + case.number, 1000 + i])
        )
        with (folder / name).open("w", newline="", encoding="utf-8") as file:
            out = csv.writer(file)
            out.writerow(columns)
            out.writerows([f"{x:.6f}" for x in row] for row in zip(*columns.values(), strict=True))
        said = "\n".join(_says(case, run, name, names[0])) + "\n"
        (folder / name).with_suffix(".toml").write_text(said, encoding="utf-8")
    return names


def _poses(m, path):
    """Postures worked out here, to which a reader of the cell may hold its own chain."""
    spread = np.array([[0.0] * m.n, *np.random.default_rng(1).uniform(-1, 1, (4, m.n))])
    q = m.middle + spread * np.array(m.swing) * m.units
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        heads = [f"{n}_{'deg' if k == 'R' else 'mm'}" for n, k in zip(m.names, m.kinds, strict=True)]
        out.writerow(["name", *heads, "x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg", "source", "note"])
        for i, (axes, tip) in enumerate(zip(m.axes(q), m.tip(q), strict=True)):
            turns = Rotation.from_matrix(tip[:3, :3]).as_euler("ZYX", degrees=True)
            out.writerow(
                [
                    f"p{i}",
                    *(f"{x:.6f}" for x in (*axes, *(1e3 * tip[:3, 3]), *turns)),
                    "hand",
                    "by the maker of the case",
                ]
            )
