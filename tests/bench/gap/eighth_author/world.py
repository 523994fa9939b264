"""What causes do to a run, stage by stage, and what an instrument and encoders then see of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from gap.eighth_author.bodies import inverse, placed, small
from gap.eighth_author.ways import DT

DRIVE, LINK = "setpoint_to_encoder", "encoder_to_tcp"


@dataclass
class Acts:
    """On all rows of a run's clock: `drive` is encoder less set-point, `link` the link less its encoder (N, n); twists
    behind rows, and of a table's axis in world (N, 6). `ages` are (s, weight) of what is measured as now; `seen` bends
    measured places (K, 3); `force` is what is logged of it, N; `warmth` of the arm, degrees above the air."""

    drive: np.ndarray | float = 0.0
    link: np.ndarray | float = 0.0
    twists: dict = field(default_factory=dict)
    table: np.ndarray | None = None
    ages: tuple = ((0.0, 1.0),)
    seen: tuple = ()
    force: np.ndarray | None = None
    warmth: np.ndarray | None = None


@dataclass
class Cause:
    """`act(run, size)`; none is larger than `most`, the size begins at `guess`."""

    name: str
    act: Callable
    axes: list
    stage: str
    follows: tuple
    guess: float
    most: float


def together(parts):
    """One of several."""
    out = Acts()
    for p in parts:
        out.drive = out.drive + p.drive
        out.link = out.link + p.link
        for k, twist in p.twists.items():
            out.twists[k] = out.twists.get(k, 0.0) + twist
        for what in ("table", "force", "warmth"):
            mine = getattr(p, what)
            if mine is not None:
                setattr(out, what, mine if getattr(out, what) is None else getattr(out, what) + mine)
        out.seen += p.seen
        if p.ages != ((0.0, 1.0),):
            out.ages = p.ages
    return out


def _at(x, rows):
    """Rows that may lie between those of a clock."""
    rows = np.clip(rows, 0, len(x) - 1)
    low = np.minimum(rows.astype(int), len(x) - 2)
    share = (rows - low).reshape(-1, *[1] * (x.ndim - 1))
    return x[low] * (1 - share) + x[low + 1] * share


def logged(run, acts, how):
    """Set-points, encoders (K, n) and what is measured of the tool (K, 4, 4) on the logged rows, all without noise, in
    world or on the base.
    Where the target isn't known it is a reflector at `how["reflector"]` in tool axes, m."""
    m, base = run.machine, how["frame"] == "base"
    drive = np.broadcast_to(acts.drive, run.c.shape)
    link = run.c + drive + acts.link
    poses = 0.0
    for age, weight in acts.ages:
        rows = run.pick - age / DT
        twists = {k: _at(np.broadcast_to(x, (len(run.t), 6)), rows) for k, x in acts.twists.items()}
        q = _at(link, rows)
        tip = m.tip(q, twists)
        if base:
            under = m.base(q)
            if acts.table is not None:
                under = small(_at(acts.table, rows)) @ under
            tip = inverse(under) @ tip
        poses = poses + weight * tip
    turn, _, back = np.linalg.svd(poses[:, :3, :3])
    turn = turn @ back
    at = poses[:, :3, 3] + turn @ how["reflector"]
    for see in acts.seen:
        at = see(run, at)
    return run.c[run.pick], (run.c + drive)[run.pick], placed(turn, at)


def reckoned(run, q, how):
    """(K, 4, 4) of what should be measured at q (K, n)."""
    tip = run.machine.tip(q)
    if how["frame"] == "base":
        tip = inverse(run.machine.base(q)) @ tip
    tip[:, :3, 3] += tip[:, :3, :3] @ how["reflector"]
    return tip


def off(run, acts, how):
    """(K, 3) mm: what is measured less what is reckoned, without noise; of drives alone what their encoders are off by,
    at the tool."""
    c, e, tip = logged(run, acts, how)
    if how["log"] == "drives":
        return 1e3 * (run.machine.tip(e) - run.machine.tip(c))[:, :3, 3]
    return 1e3 * (tip - reckoned(run, e if how["lacks"] == "setpoints" else c, how))[:, :3, 3]


def nuisance(run, how):
    """(3 K, p) mm: what a frame and a target that are not known would take up, in the log's own frame."""
    tip = reckoned(run, run.c[run.pick], how)
    out = []
    if how["frame"] == "unknown":
        at = tip[:, :3, 3]
        for k in np.eye(3):
            out += [np.repeat(k[None], len(at), 0), np.cross(k, at - at.mean(0))]
    if how["target"] == "unknown":
        out += [tip[:, :3, k] for k in range(3)]
    return np.stack(out, -1).reshape(3 * len(tip), -1) if out else np.zeros((3 * len(tip), 0))


def taken(run, error, how):
    """An error (K, 3) less what its log's own unknowns take up."""
    if how["log"] == "drives":
        return error
    basis, _ = np.linalg.qr(nuisance(run, how))
    flat = error.reshape(-1)
    return (flat - basis @ (basis.T @ flat)).reshape(error.shape)


def rms(x):
    return float(np.sqrt((np.asarray(x) ** 2).sum(-1).mean()))


def sized(cause, run, how, target):
    """The size at which a cause alone comes to `target` mm rms on a run, or the most that it can be; and what it then
    comes to."""
    size, reached = cause.guess, 0.0
    for _ in range(7):
        reached = rms(taken(run, off(run, cause.act(run, size), how), how))
        if reached <= 0 or (size >= cause.most and reached <= target) or abs(reached / target - 1) < 1e-3:
            return float(size), reached
        size = min(size * np.clip(target / reached, 0.02, 50), cause.most)
    reached = rms(taken(run, off(run, cause.act(run, size), how), how))
    return float(size), reached
