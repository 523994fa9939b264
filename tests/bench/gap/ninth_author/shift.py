"""What is wrong with a run, stage by stage, and what is then seen of it.

A `Shift` holds what one cause adds: to the encoders (`drive`: encoder less set-point), to the links (`link`: link less
encoder), rigid twists behind rows, at the foot, in world or at the tool, what the table does, what the instrument adds
(`seen`, `scale`, `delay`), and what is only written wrongly (`read`: encoder as logged less encoder; `told`: the set-point
as logged). All on the run's clock, in m and rad. `observed` puts them on the machine, one in another, and looks.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gap.ninth_author.paths import Run, lines

__all__ = ["Shift", "nominal", "nuisances", "observed", "rms", "total", "unabsorbed"]


@dataclass
class Shift:
    """One cause's part of a run; what is None is not touched."""

    drive: np.ndarray | None = None
    link: np.ndarray | None = None
    twists: dict = field(default_factory=dict)
    axis: np.ndarray | None = None  # (6,) where the table's axis truly lies
    wobble: np.ndarray | None = None  # (N, 6)
    seen: np.ndarray | None = None  # (N, 3) at the rows, m
    about: np.ndarray | None = None  # (N, 3): the instrument turns by it (rad) about its place, at the rows
    scale: float = 0.0
    delay: float = 0.0
    read: np.ndarray | None = None
    told: np.ndarray | None = None


def _add(a, b):
    return b if a is None else a if b is None else a + b


def total(shifts) -> Shift:
    """All of them at once."""
    out = Shift()
    for s in shifts:
        for name in ("drive", "link", "axis", "wobble", "seen", "about", "read", "scale", "delay"):
            setattr(out, name, _add(getattr(out, name), getattr(s, name)))
        for key, w in s.twists.items():
            out.twists[key] = _add(out.twists.get(key), w)
        out.told = s.told if s.told is not None else out.told
    return out


def _at(run: Run, v, when):
    """A value of the clock at other times; what holds one value for a run is given for each of them."""
    v = np.asarray(v, float)
    if v.ndim == 1:
        return np.repeat(v[None], len(when), 0)
    return v[run.pick] if run.kind == "poses" else lines(when, run.t, v)


def nominal(run: Run, frame: str, q=None):
    """The tool (N, 4, 4) where set-points (or other axis values) of the rows put it, in world or on the base."""
    q = run.q[run.pick] if q is None else q
    tip = run.arm.tips(q)
    return run.arm.tables(q) @ tip if frame == "base" else tip


def observed(run: Run, shifts, frame="world", place=(3.0, -2.0, 0.5)):
    """(tool (N, 4, 4) as seen, encoders (N, n) and set-points (N, n) as logged) at the rows, without noise."""
    s = total(shifts)
    zero = np.zeros(run.arm.n)
    off = zero if s.drive is None else s.drive
    real = run.q + off
    encoders = real[run.pick] if s.read is None else real[run.pick] + s.read[run.pick]
    links = real if s.link is None else real + s.link
    when = run.t[run.pick] - (0.0 if run.kind == "poses" else s.delay)
    when = np.clip(when, run.t[0], run.t[-1])
    q = _at(run, links, when)
    tip = run.arm.tips(q, {k: _at(run, w, when) for k, w in s.twists.items()})
    if frame == "base":
        wobble = None if s.wobble is None else _at(run, s.wobble, when)
        tip = run.arm.tables(q, s.axis, wobble) @ tip
    tip = tip.copy()
    away = tip[:, :3, 3] - np.asarray(place)
    tip[:, :3, 3] += s.scale * away
    if s.about is not None:
        tip[:, :3, 3] += np.cross(s.about, away)
    if s.seen is not None:
        tip[:, :3, 3] += s.seen
    told = run.q[run.pick] if s.told is None else s.told[run.pick]
    return tip, encoders, told


def nuisances(run: Run, how, latency=True):
    """Columns (3N, k) of what is fitted besides: an unknown frame, an unknown target, one latency."""
    tip = nominal(run, how["frame"])
    p, n, out = tip[:, :3, 3], len(run.pick), []
    if how["unknown_frame"]:
        out += [np.repeat(e[None], n, 0) for e in np.eye(3)]
        out += [np.cross(e, p - p.mean(0)) for e in np.eye(3)]
    if how["unknown_target"]:
        out += [tip[:, :3, k] for k in range(3)]
    if latency and run.kind == "path":
        out.append(np.gradient(p, run.t[run.pick], axis=0))
    return np.stack([c.ravel() for c in out], 1) if out else np.zeros((3 * n, 0))


def unabsorbed(run: Run, off, how, latency=True):
    """Displacements (N, 3) less what frames, target and latency would take of them."""
    columns = nuisances(run, how, latency)
    if not columns.shape[1] or not off.any():
        return off
    columns = columns / np.linalg.norm(columns, axis=0)
    fit = np.linalg.lstsq(columns, off.ravel(), rcond=1e-9)[0]
    return (off.ravel() - columns @ fit).reshape(-1, 3)


def rms(off) -> float:
    """3-D rms in mm of displacements (N, 3) in m."""
    return 1e3 * float(np.sqrt((np.asarray(off) ** 2).sum(-1).mean()))
