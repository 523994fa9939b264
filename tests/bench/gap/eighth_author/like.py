"""Which names these logs can't tell from a cause that is at work: the usual linear patterns, all their parameters free."""

from __future__ import annotations

import numpy as np

from gap.eighth_author.bodies import inverse
from gap.eighth_author.works import senses
from gap.eighth_author.world import DRIVE, nuisance, off, taken

LIMIT = 0.99
DRIVES = ("servo_lag", "setpoint_delay", "friction", "motor_commutation")


def _waves(q, numbers):
    return [f(k * q) for k in numbers for f in (np.sin, np.cos)]


class Patterns:
    """Of one run: columns (K, 3) in mm a unit, for each name a list."""

    def __init__(self, run, how):
        self.run, self.how, self.m = run, how, run.machine
        self.q = run.c[run.pick]
        self.jac = self.m.jacobian(self.q)[:, :3]
        self.at = self.m.tip(self.q)[:, :3, 3]
        tip = self.m.tip(self.q)[:, :3, :3] @ how["reflector"]
        self.jac = self.jac + np.cross(np.swapaxes(self.m.jacobian(self.q)[:, 3:], 1, 2), tip[:, None]).swapaxes(1, 2)
        self.at = self.at + tip
        self.unknown, _ = np.linalg.qr(nuisance(run, how) if how["log"] != "drives" else np.zeros((3 * len(self.q), 0)))
        self.back = inverse(self.m.base(self.q))[:, :3, :3] if how["frame"] == "base" else None

    def joints(self, what):
        """One pattern an axis, of joints moved by `what` (K, n)."""
        return [self.jac[:, :, i] * what[:, i : i + 1] for i in range(self.m.first, self.m.n)]

    def turns(self, frames, amounts):
        """Of a frame (K, 4, 4) shifted and turned along its own axes, each times `amounts` (K, p)."""
        out = []
        for k in range(3):
            z = frames[:, :3, k]
            for x in (z, np.cross(z, self.at - frames[:, :3, 3])):
                out += [x * a[:, None] for a in amounts.T]
        return out

    def of(self, name):
        run, m, pick = self.run, self.m, self.run.pick
        one, world = np.ones((len(pick), 1)), np.repeat(np.eye(4)[None], len(pick), 0)
        t = (run.t[pick] + run.facts["since"])[:, None]
        w = self.q[:, :1]
        if name in DRIVES or name in ("acceleration_error", "hysteresis", "gear_ripple", "backlash"):
            return self._moving(name)
        if name == "joint_offset":
            return self.joints(np.ones_like(self.q))
        if name in ("joint_compliance", "payload"):
            more = ((m.names[-1], 10.0, (0, 0, 100)), (m.names[-4], 5.0, (0, 0, 0)))
            load = m.loads(self.q)
            return self.joints(load if name == "joint_compliance" else m.loads(self.q, more) - load)
        if name == "lean":
            moment = m.moment(self.q, m.frames(m.middle[None])[m.first][0, :3, 3])[0]
            return self.turns(world, moment[:, :2])
        if name == "frame_base":
            return self.turns(world, one)
        if name == "frame_tool":
            return self.turns(m.tip(self.q), one)
        if name in ("frame_table", "turntable") and m.table:
            return self.turns(world, one if name == "frame_table" else np.column_stack(_waves(w, (1, 2, 3))))
        if name == "geometry":
            chain = m.frames(self.q)
            return [p for k in range(m.first + 1, m.n + 1) for p in self.turns(chain[k], one)]
        if name == "wrist_coupling":
            q = np.roll(self.q - m.middle, 1, 1)
            return self.joints(q)[-2:]
        if name == "thermal_drift":
            chain = m.frames(self.q)
            rise = np.column_stack([1 - np.exp(-t / s) for s in (60, 300)])
            return [p for k in range(m.first + 1, m.n + 1) for p in self.turns(chain[k], rise)]
        if name == "track" and m.names[0] == "E1":
            u = (self.q[:, :1] - m.middle[0]) / m.spread[0]
            return self.turns(m.frames(self.q)[1], np.column_stack([u, u**2, u**3]))
        return self._measured(name, t, one, world)

    def _measured(self, name, t, one, world):
        run, pick = self.run, self.run.pick
        if name == "measurement_scale":
            return [self.at - self.how["stand"]]
        if name == "measurement_drift":
            return self.turns(world, np.column_stack([t, t**2]) / (1 + t.max()))
        if name == "latency":
            return [self.joints_sum(run.v[pick])]
        if name == "cutting_force" and run.facts.get("force") is not None:
            force = run.facts["force"][pick]
            return [*self.joints(np.einsum("nki,nk->ni", self.jac, force)), force]
        if name == "early_reading":
            return self.joints(np.diff(run.c, axis=0, prepend=run.c[:1])[pick]) if run.poses else []
        return []

    def joints_sum(self, what):
        return np.einsum("nki,ni->nk", self.jac, what)

    def _moving(self, name):
        run, pick, m = self.run, self.run.pick, self.m
        if name in ("servo_lag", "setpoint_delay"):
            return self.joints(run.v[pick]) + (self.joints(run.a[pick]) if name == "servo_lag" else [])
        if name == "friction":
            return self.joints(senses(run)[pick]) + self.joints(run.v[pick])
        if name == "acceleration_error":
            return self.joints(run.a[pick])
        if name == "backlash":
            return self.joints(senses(run)[pick])
        if name == "hysteresis":  # of the logged rows
            z, out = np.zeros((2, m.n)), np.empty((len(pick), 2, m.n))
            wide = np.stack([0.03 * m.spread, 0.15 * m.spread])
            for i, d in enumerate(np.diff(self.q, axis=0, prepend=self.q[:1])):
                z = np.clip(z + d / wide, -1, 1)
                out[i] = z
            return [p for k in range(2) for p in self.joints(out[:, k])]
        gear = np.where(m.slides, 2 * np.pi, 1) * m.each("ratio")
        numbers = (3 * gear, 6 * gear) if name == "motor_commutation" else (1, 2, gear, 2 * gear)
        return [p for k in numbers for x in (np.sin, np.cos) for p in self.joints(x(k * self.q))]

    def flat(self, name):
        """(3 K, p), less what the log's own unknowns take up."""
        columns = self.of(name)
        if self.back is not None:
            columns = [(self.back @ c[..., None])[..., 0] for c in columns]
        if not columns:
            return np.zeros((3 * len(self.q), 0))
        flat = np.stack([c.reshape(-1) for c in columns], 1)
        return flat - self.unknown @ (self.unknown.T @ flat)


def alike(runs, how, parts, names):
    """{cause: names that show its pattern on all logs at a correlation above LIMIT}; `parts` of (cause, size)."""
    seen = [Patterns(r, how) for r in runs]
    basis = {n: np.concatenate([p.flat(n) for p in seen]) for n in names}
    out = {}
    for cause, size in parts:
        error = np.concatenate([taken(r, off(r, cause.act(r, size), how), how).reshape(-1) for r in runs])
        apart = not how["lacks"]  # both stages were logged, so that they are told apart
        mine = [n for n in names if n != cause.name and not (apart and (n in DRIVES) != (cause.stage == DRIVE))]
        out[cause.name] = [n for n in mine if _shown(error, basis[n]) > LIMIT]
    return out


def _shown(error, basis):
    if not basis.shape[1] or not error.any():
        return 0.0
    basis = basis / np.maximum(np.linalg.norm(basis, axis=0), 1e-30)
    values, vectors = np.linalg.eigh(basis.T @ basis)
    keep = values > 1e-10 * values[-1]
    seen = vectors[:, keep].T @ (basis.T @ error)
    return float(np.sqrt(min(1.0, (seen**2 / values[keep]).sum() / (error @ error))))
