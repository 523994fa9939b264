"""Cases of the gap benchmark: a cell with true effects, nuisances of all others, two runs of it, and the label.

A case is drawn from its seed alone. The second run is another path of the same cell; it is withheld from the diagnosis's
choice and fit. Nothing here comes from camrob.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gap.draws import ON_TABLE, OUTSIDE, PATHS, POSES, POSES_OUTSIDE, draw
from gap.field import draw_field
from gap.generator import AXES, DEG, World, growths, jacobian, moment, path, pose, show, torques, turns
from gap.motions import fitted_rig, read_motion

KINDS = {"none": 0.15, "one": 0.35, "two": 0.25, "three": 0.10, "outside": 0.15}
NUISANCE = 0.1  # of the noise: what all absent effects together move the TCP by at most
HOME = np.array([0, -90, 90, 0, 90, 0, 0, 0.0]) * DEG
_TRIES = 8  # draws of an effect, each of less than the one before
_MOST = {  # times the ordinary amount, beyond which no machine is; 12 for all others
    "payload": 4.0,
    "thermal_drift": 3.0,
    "track": 6.0,
    "joint_offset": 6.0,
    "joint_compliance": 8.0,
    "backlash": 6.0,
    "servo_lag": 6.0,
    "gear_ripple": 7.0,
    "wrist_coupling": 5.0,
    "cutting_force": 5.0,
}


@dataclass
class Rig:
    """What is drawn of a case beside its effects."""

    poses: bool
    in_base: bool
    sigma: float
    sigma_turned: float
    told: bool
    position_only: bool
    lacks: str
    with_force: bool
    with_temp: bool
    outliers: float
    rise: float
    tau: float
    rate: float
    travel: float
    waves: np.ndarray = field(repr=False)

    @property
    def noise(self):
        """3-D rms of the instrument's noise, m."""
        return self.sigma * np.sqrt(3)


def draw_rig(rng):
    """Instrument, frame, what is logged."""
    poses = rng.random() < 0.12
    return Rig(
        poses=poses,
        in_base=rng.random() < 0.15,
        sigma=rng.uniform(0.01, 0.04) * 1e-3,
        sigma_turned=rng.choice([2e-4, 1e-3, 4e-3]) * DEG,
        told=poses or rng.random() < 0.85,
        position_only=rng.random() < 0.2,
        lacks=str(rng.choice(["", "encoders", "setpoints"], p=[0.8, 0.1, 0.1])),
        with_force=not poses and rng.random() < 0.4,
        with_temp=rng.random() < 0.6,
        outliers=rng.choice([0, 0.01]),
        rise=rng.uniform(8, 15),
        tau=rng.uniform(20, 80),
        rate=rng.choice([10.0, 12.5, 25.0, 62.5]),
        travel=rng.uniform(0.05, 0.4),
        waves=rng.uniform(0, 1, (2, 3)),
    )


def posture_list(rng):
    """Axis values (M, 8) of single poses, spread over the workspace."""
    count = int(rng.integers(80, 260))
    spread = np.array([30, 20, 25, 60, 40, 90]) * DEG
    axis = HOME + np.zeros((count, 8))
    axis[:, :6] += rng.uniform(-1, 1, (count, 6)) * spread
    axis[:, 6] = rng.uniform(-0.5, 0.5, count)
    axis[:, 7] = rng.uniform(-2.5, 2.5, count)
    return axis


def run_of(rng, rig, seconds, travel, motion=None, before=0.0):
    """(world, sample times) of one run, nothing wrong yet. travel: m of the track either way; motion: that of a given log,
    instead of a drawn one; before: s for which the arm has been warming up.
    """
    if motion is not None:
        t, command = motion.command()
        at, coarse = motion.at, slice(None, None, 25)
    elif rig.poses:
        command = posture_list(rng)
        t = np.arange(len(command), dtype=float)
        at, coarse = t, slice(None)
    else:
        t, command = path(rng, seconds, rng.uniform(0.3, 2.5) if rig.in_base else 0.3, travel)
        at, coarse = np.arange(0.3, t[-1] - 0.3, 1.0 / rig.rate), slice(None, None, 25)
    world = World(t, command)
    world.in_base = rig.in_base
    force = np.clip(80 * np.sin(2 * np.pi * np.outer(t, 0.05 + 0.25 * rig.waves[0]) + 6 * rig.waves[1]) + 60, 0, 140)
    few, short = command[coarse], t[coarse]

    def wide(values):
        return values if rig.poses else np.stack([np.interp(t, short, c) for c in values.T], 1)

    J = wide(jacobian(few)[:, :3].reshape(len(few), -1)).reshape(-1, 3, 6)
    lengths = wide(np.concatenate(growths(few), 1))
    world.context = {
        "tcp": wide(pose(few)[:, :3, 3]),
        "moment": wide(moment(few)),
        "torque": wide(torques(few)),
        "payload": wide(torques(few, [(5, 1.0, (0, 0, 0.13))])),
        "warm": rig.rise * (1 - np.exp(-(t - t[0] + before) / rig.tau)),
        "growth": [lengths[:, 3 * i : 3 * i + 3] for i in range(6)],
        "force": np.einsum("nij,ni->nj", J, force),
        "pushed": force,
    }
    return world, at


def clone(world):
    """The same run with nothing wrong."""
    fresh = World(world.t, world.command)
    fresh.context, fresh.in_base = world.context, world.in_base
    return fresh


def moved(world, appliers, at):
    """m (rms): by how much effects, given as (apply, size), move the TCP."""
    plain, other = clone(world), clone(world)
    for apply, s in appliers:
        apply(other, s)
    a, b = show(plain, at)[2], show(other, at)[2]
    return float(np.sqrt(np.mean(np.sum((b[:, :3, 3] - a[:, :3, 3]) ** 2, 1))))


def scaled(world, apply, target, at, rounds=4):
    """The size at which an effect moves the TCP by target m (rms); None where it can't."""
    s = 1.0
    for _ in range(rounds):
        size = moved(world, [(apply, s)], at)
        if size < 1e-9:
            return None
        s *= target / size
    return s


def names_of(rig, without=()):
    """Effects of the library that a case with this rig can have."""
    names = list(POSES if rig.poses else PATHS) + (list(ON_TABLE) if rig.in_base else [])
    names += ["thermal_drift"] if rig.poses and rig.with_temp else []
    lacking = {"cutting_force": rig.with_force, "thermal_drift": rig.with_temp}
    if rig.lacks == "setpoints":
        lacking |= {"servo_lag": False, "friction": False}
    return [n for n in names if lacking.get(n, True) and n not in without]


def names_on(motion):
    """Effects of the library that a case on a given log's motion can have."""
    given = read_motion(motion)
    rig = fitted_rig(draw_rig(np.random.default_rng(0)), given, "thermal_drift" if "temp" in given.columns else None)
    rig.with_force = True
    return tuple(names_of(rig))


def _sized(rng, name, world, at, noise, low, high):
    """(facts, apply, s, times the noise) of an effect, drawn anew until it moves the tool enough with a plausible value."""
    times = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    for _ in range(_TRIES):
        facts, apply = draw(name, rng, world)
        s = scaled(world, apply, times * noise, at)
        if s is not None and s <= _MOST.get(name, 12.0):
            return facts, apply, s, times
        times = max(low, 0.7 * times)
    return None


def _kind(rng):
    return str(rng.choice(list(KINDS), p=list(KINDS.values())))


def drawn_kind(seed):
    """none, one, two, three or outside, as a seed draws it."""
    return _kind(np.random.default_rng(seed))


def drawn(seed, kind=None, only=None, sizes=None, whole=True, motions=(), longer=1.0):
    """(rng, rig, runs, chosen effects as (name, apply, size), label). only: the one effect; sizes: (least, most) times the noise.

    whole: with the second run and the nuisances; without, the first run has nothing wrong yet. motions: logs (paths) on whose
    motions the runs are, the one to fit and the withheld one, instead of drawn ones; longer: times their drawn length.
    """
    given = [read_motion(m) for m in motions]
    rng, other = np.random.default_rng(seed), np.random.default_rng([seed, 1])
    kind = kind or _kind(rng)
    rig = draw_rig(rng)
    if only is not None:
        kind, rig = "one", _fitting(rig, only)
    if given:
        rig = fitted_rig(rig, given[0], only)
    first, last = (given[0], given[-1]) if given else (None, None)
    seconds = longer * np.exp(rng.uniform(np.log(25), np.log(100)))
    runs = [run_of(rng, rig, seconds, rig.travel, first)]
    world, at = runs[0]
    few = at[:: max(1, len(at) // 300)]
    names = names_of(rig)
    count = {"none": 0, "one": 1, "two": 2, "three": 3, "outside": 0}[kind]
    low, high = sizes or (1.5 if kind == "outside" else 0.5, 20.0)
    pool = [only] if only is not None else list(rng.permutation(names))
    if kind == "outside":
        count, pool = 1, list(rng.permutation(POSES_OUTSIDE if rig.poses else OUTSIDE))
    label = {"seed": seed, "kind": kind, "effects": {}, "noise_mm": rig.noise * 1e3}
    chosen = []
    while pool and len(chosen) < count:
        name = str(pool.pop(0))
        found = _sized(rng, name, world, few, rig.noise, low, high)
        if found is not None:
            facts, apply, s, times = found
            chosen.append((name, apply, s))
            label["effects"][name] = {"size": times, **facts}
    picked = [name for name, _, _ in chosen]
    if not whole:
        return rng, rig, runs, chosen, label
    passed = at[-1] if given else 0.0
    runs.append(run_of(other, rig, longer * other.uniform(20, 40), rig.travel * other.uniform(0.6, 1.2), last, passed))
    nuisances = []
    for name in (n for n in names if n not in picked):
        _, apply = draw(name, rng, world)
        s = scaled(world, apply, 0.02 * rig.noise, few, rounds=2)
        if s is not None:
            nuisances.append((apply, s))
    # all together within their bound on both runs, whichever moves more
    spans = [(one, at[:: max(1, len(at) // 300)]) for one, at in runs]
    total = max(moved(one, nuisances, some) for one, some in spans) / rig.noise if nuisances else 0.0
    share = rng.uniform(0, NUISANCE)
    for one, _ in runs:
        for _, apply, s in chosen:
            apply(one, s)
        for apply, s in nuisances:
            apply(one, s * share / max(total, 1e-9))
    label |= {
        "nuisance": share,
        "poses": rig.poses,
        "in_base": rig.in_base,
        "lacks": rig.lacks,
        "position_only": rig.position_only,
    }
    return rng, rig, runs, chosen, label


def _fitting(rig, only):
    """The rig changed so that it can show an effect."""
    rig.poses = only == "early_reading" or (rig.poses and only in POSES)
    rig.in_base = only in ON_TABLE or rig.in_base
    rig.with_force = not rig.poses and (only == "cutting_force" or rig.with_force)
    rig.with_temp = only == "thermal_drift" or rig.with_temp
    rig.lacks = "" if only in ("servo_lag", "friction") and rig.lacks == "setpoints" else rig.lacks
    return rig


def columns_of(rng, rig, world, at):
    """The log's columns, in its units."""
    setpoint, encoder, T = show(world, at)
    p = T[:, :3, 3] + rng.normal(0, rig.sigma, (len(at), 3))
    bad = rng.random(len(at)) < (0 if rig.poses else rig.outliers)
    p[bad] += rng.normal(0, 1e-3, (bad.sum(), 3))
    R = turns(rng.normal(0, rig.sigma_turned, (len(at), 3))) @ T[:, :3, :3]
    columns = {"t": at, **{n: p[:, k] * 1e3 for k, n in enumerate("xyz")}}
    if not rig.position_only:
        columns |= {
            "a": np.arctan2(R[:, 1, 0], R[:, 0, 0]) / DEG,
            "b": -np.arcsin(np.clip(R[:, 2, 0], -1, 1)) / DEG,
            "c": np.arctan2(R[:, 2, 1], R[:, 2, 2]) / DEG,
        }
    edge = np.array([1 / DEG] * 6 + [1e3, 1 / DEG])
    if rig.lacks != "encoders":
        columns |= {n: np.round(encoder[:, k] * edge[k], 5) for k, n in enumerate(AXES)}
    if rig.lacks != "setpoints":
        columns |= {f"c{n}": np.round(setpoint[:, k] * edge[k], 5) for k, n in enumerate(AXES)}
    if rig.with_temp:
        columns["temp"] = 21.0 + np.interp(at, world.t, world.context["warm"])
    if rig.with_force:
        columns |= {f"f{n}": np.interp(at, world.t, world.context["pushed"][:, k]) for k, n in enumerate("xyz")}
    return columns


def write_case(folder: Path, seed: int, kind=None, only=None, sizes=None, motions=(), field=0.0, longer=1.0) -> dict:
    """Write SEED.csv and SEED_withheld.csv, with what is told beside them, into a folder; gives the label.

    motions: logs (paths) on whose motions the case is, the one to fit and the withheld one; what is written then has their
    columns, rows and instrument. field: times the noise that a smooth field over posture moves the tool by, beside all effects;
    longer: times the drawn length of both runs.
    """
    rng, rig, runs, _, label = drawn(seed, kind, only, sizes, motions=motions, longer=longer)
    if field > 0.0:
        apply = draw_field(seed, runs[0][0], field * rig.noise)
        for world, _ in runs:
            apply(world)
        label["field"] = field
    given = [read_motion(m) for m in motions]
    facts = {"sigma_mm": rig.sigma * 1e3, "sigma_deg": rig.sigma_turned / DEG} if rig.told else {}
    facts |= {"measured_frame": "base"} if rig.in_base else {}
    facts |= {"poses": True} if rig.poses else {}
    for name, (world, at) in zip((f"{seed}", f"{seed}_withheld"), runs, strict=True):
        columns = columns_of(rng, rig, world, at)
        if given:
            motion = given[-1 if name.endswith("withheld") else 0]
            still = {"temp": np.full(len(at), 21.0)} if "temp" in motion.columns else {}
            columns = still | motion.extra | columns
        order = [
            n
            for n in ("t", *"xyzabc", *AXES, *(f"c{a}" for a in AXES), "temp", "fx", "fy", "fz", "line")
            if n in columns
        ]
        table = np.stack([columns[n] for n in order], 1)
        np.savetxt(folder / f"{name}.csv", table, fmt="%.6f", delimiter=",", header=",".join(order), comments="")
        (folder / f"{name}.toml").write_text("".join(f"{k} = {json.dumps(v)}\n" for k, v in facts.items()))
    return label
