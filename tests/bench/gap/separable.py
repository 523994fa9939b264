"""What a case's path can't tell apart, by the generator's own simulation: the angle between an effect and others' patterns.

Used by the scorer alone. A pattern is how an effect moves what is logged (positions, turns, encoders against set-points),
over the instrument's noise. Effects that no two parameters of which are alike (ripple of unknown order) cover nothing.
"""

from __future__ import annotations

import numpy as np

from gap.draws import _DRAWS, shift
from gap.generator import DEG, STEP, log_rotation, play, rigid, show, smooth
from gap.maker import clone, drawn

LIMIT = 6.0  # degrees: what lies nearer can't be told apart
_ROWS = 240


def _set(attribute, v, left=True):
    def apply(w):
        old = getattr(w, attribute)
        setattr(w, attribute, rigid(v) @ old if left else old @ rigid(v))

    return apply


def _units(size_length=1e-4, size_angle=1e-4, parts=range(6)):
    return [np.eye(6)[k] * (size_length if k < 3 else size_angle) for k in parts]


def _row(i, k, d):
    return lambda w: w.rows[i].__setitem__(k, w.rows[i][k] + d)


def _after(axis, value):
    return lambda w: w.after.__setitem__((slice(None), axis), w.after[:, axis] + value(w))


def _link(axis, value):
    return lambda w: shift(w, axis, value(w))


def _lag(w):
    u, y = w.command, w.command[0] - 0.026 * (w.command[1] - w.command[0]) / STEP
    for i in range(len(u)):
        y = y + (STEP / 0.03) * (u[i] - y)
        w.drive[i] += y - u[i]


def _accelerated(w):
    shift(w, slice(0, 6), -3e-4 * smooth(np.gradient(np.gradient(w.command, STEP, axis=0), STEP, axis=0), 9)[:, :6])


def _rubbed(axis):
    def apply(w):
        v = np.gradient(w.command[:, axis], STEP)
        w.drive[:, axis] -= 1e-4 * np.tanh(v / (0.02 * np.abs(v).mean() + 1e-9))

    return apply


def _early(w):
    before = np.zeros_like(w.command)
    before[1:] = w.command[:-1] - w.command[1:]
    shift(w, slice(0, 8), 2e-4 * before)


def _grown(i):
    def apply(w):
        w.after += 1.5e-5 * w.context["warm"][:, None] * w.context["growth"][i]

    return apply


def _drifted(i):
    """The instrument shifts steadily along one axis; that it may turn as well is left aside."""

    def apply(w):
        w.after[:, i] += 1e-4 * (w.t - w.t[0]) / max(w.t[-1] - w.t[0], 1e-9)

    return apply


def members(name):
    """Small applications whose patterns span what an effect of the library can show."""
    arm = range(6)
    spans = {
        "frame_base": [_set("base", v) for v in _units()],
        "frame_tool": [_set("tool", v, left=False) for v in _units()],
        "measurement_frame": [_set("instrument", v) for v in _units()],
        "frame_table": [_set("table", v) for v in _units(parts=(0, 1, 3, 4))],
        "joint_offset": [_link(k, lambda w: 0.02 * DEG) for k in arm],
        "geometry": [_row(i, k, 1e-4) for i in arm for k in range(3)],
        "track": [_after(k, lambda w, n=n: 1e-4 * (w.command[:, 6] / 0.5) ** n) for k in range(3) for n in (1, 2)],
        "lean": [lambda w, e=e: setattr(w, "lean", 1e-7 * e * w.context["moment"]) for e in np.eye(3)[:2]],
        "joint_compliance": [_link(k, lambda w, k=k: 1e-6 * w.context["torque"][:, k]) for k in arm],
        "payload": [_link(k, lambda w, k=k: 5e-6 * w.context["payload"][:, k]) for k in arm],
        "backlash": [_link(k, lambda w, k=k: play(w.command[:, k], 0.03 * DEG)) for k in arm],
        "servo_lag": [_lag],
        "acceleration_error": [_accelerated],
        "friction": [_rubbed(k) for k in arm],
        "wrist_coupling": [_link(b, lambda w, a=a: 1e-3 * w.command[:, a]) for a, b in ((3, 4), (3, 5), (4, 5))],
        "thermal_drift": [_grown(i) for i in arm],
        "latency": [lambda w: setattr(w, "delay", 0.005)],
        "cutting_force": [_link(k, lambda w, k=k: 4e-6 * w.context["force"][:, k]) for k in arm],
        "early_reading": [_early],
        "measurement_drift": [_drifted(i) for i in range(3)],
    }
    return spans.get(name, [])


class Separation:
    """One case, regenerated: `same(claim)` tells whether the path can't separate a claimed set from the true one."""

    def __init__(self, seed, kind=None, only=None, sizes=None, motions=()):
        _, self.rig, runs, chosen, self.label = drawn(seed, kind, only, sizes, whole=False, motions=motions)
        world, at = runs[0]
        self.world, self.at = clone(world), at[:: max(1, len(at) // _ROWS)]
        self.plain = show(self.world, self.at)
        self.true = {name: self._pattern(lambda w, a=apply, s=s: a(w, s)) for name, apply, s in chosen}
        self.spans = {}

    def _pattern(self, apply):
        w = clone(self.world)
        apply(w)
        _, encoder, T = show(w, self.at)
        rows = [((T[:, :3, 3] - self.plain[2][:, :3, 3]) / self.rig.sigma).ravel()]
        if not self.rig.position_only:
            turned = T[:, :3, :3] @ self.plain[2][:, :3, :3].swapaxes(1, 2)
            rows.append((log_rotation(turned) / self.rig.sigma_turned).ravel())
        if not self.rig.lacks:
            rows.append(((encoder - self.plain[1])[:, :6] / (0.2 * self.rig.sigma)).ravel())
        return np.concatenate(rows)

    def _span(self, name):
        if name not in self.spans:
            found = [self._pattern(m) for m in members(name)] + ([self.true[name]] if name in self.true else [])
            self.spans[name] = np.stack(found, 1) if found else np.zeros((len(next(iter(self.true.values()))), 0))
        return self.spans[name]

    def angle(self, name, claim):
        """Degrees between a true effect's pattern and all that a set of effects can show."""
        X, y = np.concatenate([self._span(n) for n in sorted(claim)], 1), self.true[name]
        X = X[:, np.linalg.norm(X, axis=0) > 0]
        if X.shape[1] == 0 or not y.any():
            return 90.0
        X = X / np.linalg.norm(X, axis=0)
        rest = y - X @ np.linalg.lstsq(X, y, rcond=1e-8)[0]
        return float(np.degrees(np.arcsin(min(1.0, np.linalg.norm(rest) / np.linalg.norm(y)))))

    def same(self, claim):
        """True where `claim` has no more effects than the truth and shows each true one within the limit."""
        claim = set(claim)
        known = all(n in _DRAWS for n in claim)
        return (
            known
            and 0 < len(claim) <= len(self.true)
            and all(n in claim or self.angle(n, claim) < LIMIT for n in self.true)
        )


__all__ = ["LIMIT", "Separation"]
