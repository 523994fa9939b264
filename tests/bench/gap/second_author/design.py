"""What a log can't tell apart: what frames, target and latency absorb, and which other names make the same pattern."""

from __future__ import annotations

import numpy as np

from gap.second_author.chain import Body
from gap.second_author.run import gap

ALIKE = 0.99
# orders a turn of an axis that a ripple may have; the scan is as fine as paths of 20 degrees tell
ORDERS = np.concatenate([[1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 25, 30, 36, 45], np.arange(50, 261, 10)])
POLES = np.array([100, 160, 200, 240, 300, 320, 400, 480, 600])


class Design:
    """Patterns of one log: columns by the contract's names, at a few hundred rows, both stages stacked (6R,), mm."""

    def __init__(self, run, log, most=220):
        self.run, self.log, self.rows = run, log, run.thin(most)
        r = self.rows
        self.J = run.jacobian[0][r] * 1e3
        self.tip = run.tip[r]
        self.pos = self.tip[:, :3, 3] * 1e3
        if run.table is not None:
            cos, sin = np.cos(run.table[r]), np.sin(run.table[r])
            zero, one = np.zeros_like(cos), np.ones_like(cos)
            turn = np.array([[cos, -sin, zero], [sin, cos, zero], [zero, zero, one]]).transpose(2, 0, 1)
            self.turn, self.pos = turn, np.einsum("nij,nj->ni", turn, self.pos)
            self.J = turn @ self.J
        else:
            self.turn = np.broadcast_to(np.eye(3), (len(r), 3, 3))
        self.both = log["setpoints"] and log["encoders"]

    def _stack(self, body, drive=False):
        zero = np.zeros_like(body)
        if drive and self.both:
            return np.concatenate([body, zero]).ravel()
        seen = self.log["tracker"] and (self.log["setpoints"] or not drive)
        return np.concatenate([zero, body if seen else zero]).ravel()

    def joint(self, i, values, drive=False):
        """A column of what axis i adds."""
        return self._stack(self.J[:, :, i] * np.asarray(values)[:, None], drive)

    def twist(self, place_frames):
        """Six columns of a small frame behind frames (R, 4, 4) in world: translations, rotations by 1 rad/m."""
        out = []
        for k in range(3):
            axis = place_frames[:, :3, k]
            out.append(self._stack(np.einsum("nij,nj->ni", self.turn, axis)))
        for k in range(3):
            arm = np.cross(place_frames[:, :3, k], self.tip[:, :3, 3] - place_frames[:, :3, 3])
            out.append(self._stack(np.einsum("nij,nj->ni", self.turn, arm)))
        return out

    def _still(self):
        return np.repeat(np.eye(4)[None], len(self.rows), 0)

    def absorbed(self, latency=True):
        """Columns that frame, target and latency take where they are unknown."""
        out = []
        if latency and not self.run.rest:
            speed = np.gradient(self.run.tip[:, :3, 3], self.run.dt, axis=0)[self.rows]
            out.append(self._stack(np.einsum("nij,nj->ni", self.turn, speed)))
        if self.log["frame"] == "unknown":
            out += self.twist(self._still())
        if self.log["target"] == "unknown":
            out += self.twist(self.tip)[:3]
        return np.array(out).T if out else np.zeros((6 * len(self.rows), 0))

    def spans(self):
        """Columns by name of the contract."""
        run, r, n = self.run, self.rows, self.run.c.shape[1]
        robot, t = run.robot, (run.clock[r] - run.clock.mean()) / max(float(np.ptp(run.clock)), 1.0)
        load, came, arm = run.load[r], np.sign(run.came[r]), robot.arm
        turns = [i for i in range(n) if not robot.slides[i]]
        ends = [e[r] for e in run.bones[1]]
        foot = ends[robot.carriage[-1]] if robot.carriage else np.repeat(robot.base[None], len(r), 0)
        out = {
            "joint_offset": [self.joint(i, np.ones(len(r))) for i in arm],
            "geometry": [c for i in arm for c in self.twist(ends[i])[:5]],
            "frame_base": self.twist(self._still()),
            "measurement_frame": self.twist(self._still()),
            "frame_tool": self.twist(self.tip)[:3],
            "joint_compliance": [self.joint(i, load[:, i] / (np.abs(load[:, i]).max() + 1e-9)) for i in turns],
            "measurement_scale": [self._stack(self.pos / 1e3), *self.twist(self._still())[:3]],
            "measurement_drift": [self._stack(np.outer(f, e)) for f in (t, np.exp(-3 * (t + 0.5))) for e in np.eye(3)],
            "backlash": [self.joint(i, came[:, i]) for i in range(n)],
            "hysteresis": [self.joint(i, x) for i in range(n) for x in (came[:, i], self._creeping(i))],
            "thermal_drift": [c * np.tile(np.repeat(t, 3), 2) for i in arm for c in self.twist(ends[i])[:3]],
        }
        out["payload"] = [
            self.joint(i, (robot.moments(run.c[r], self._extra())[:, i, 2] - run.moments[r][:, i, 2])) for i in turns
        ]
        moment = np.cross(run.tip[r][:, :3, 3] - foot[:, :3, 3], [0, 0, -1.0])
        lean = self.twist(foot)
        out["lean"] = [c * np.tile(np.repeat(moment[:, k], 3), 2) for c in lean[3:] for k in range(2)]
        out["early_reading"] = [
            self.joint(i, came[:, i] if run.rest else run.v[r][:, i], d) for i in range(n) for d in (0, 1)
        ]
        out["gear_ripple"] = self._waves(turns, ORDERS, False)
        if robot.carriage:
            i = robot.carriage[-1]
            s = (run.c[r][:, i] - run.c[r][:, i].mean()) / 0.5
            out["track"] = [c * np.tile(np.repeat(s**p, 3), 2) for p in (1, 2, 3, 4) for c in self.twist(ends[i])]
        if len(arm) >= 6:
            k = arm[3:]
            out["wrist_coupling"] = [self.joint(k[2], run.c[r][:, k[1]] ** p) for p in (1, 2)]
            out["wrist_coupling"] += [self.joint(k[2], run.c[r][:, k[0]]), self.joint(k[1], run.c[r][:, k[0]])]
        if run.force is not None:
            f = run.force[r] / 100.0
            push = np.einsum("nij,ni->nj", run.jacobian[0][r], f)
            out["cutting_force"] = [self.joint(i, push[:, i]) for i in turns] + [
                self._stack(np.outer(f[:, k], e)) for k in range(3) for e in np.eye(3)
            ]
        if run.table is not None:
            wave = [np.ones(len(r)), np.cos(run.table[r]), np.sin(run.table[r])]
            out["frame_table"] = [c * np.tile(np.repeat(w, 3), 2) for c in self._on_table() for w in wave[:1]]
            out["turntable"] = [c * np.tile(np.repeat(w, 3), 2) for c in self._on_table() for w in wave]
        if not run.rest:
            self._moving(out, n, turns)
        return out

    def _extra(self):
        last = self.run.robot.names[-1]
        return (Body(last, 3.0, (0.0, 0.0, 150.0)),)

    def _creeping(self, i):
        """The state of a sliding spring of a middling reach, -1 to 1."""
        reach = 0.15 * float(np.ptp(self.run.c[:, i])) + 1e-9
        state, out = 0.0, np.empty(len(self.run.t))
        for k, step in enumerate(np.diff(self.run.c[:, i], prepend=self.run.c[0, i]) / reach):
            state = min(1.0, max(-1.0, state + step))
            out[k] = state
        return out[self.rows]

    def _moving(self, out, n, turns):
        run, r = self.run, self.rows
        fast = np.abs(run.v) > 1e-5
        since = np.zeros_like(run.c)
        for i in range(n):
            back = np.flatnonzero(np.diff(np.sign(run.v[:, i]), prepend=0.0) != 0)
            if len(back) == 0:  # it never moves
                continue
            last = np.searchsorted(back, np.arange(len(run.t)), side="right") - 1
            since[:, i] = np.maximum(run.t - run.t[back[np.maximum(last, 0)]], 0.0)
        sign = np.sign(run.v) * fast
        out["servo_lag"] = [self.joint(i, run.v[r][:, i], True) for i in range(n)]
        out["setpoint_delay"] = [self.joint(i, run.v[r][:, i], True) for i in range(n)]
        out["acceleration_error"] = [self.joint(i, run.a[r][:, i], d) for i in range(n) for d in (0, 1)]
        shapes = [sign, *(sign * np.exp(-since / tau) for tau in (0.03, 0.1, 0.3))]
        out["friction"] = [self.joint(i, s[r][:, i], True) for i in range(n) for s in shapes]
        out["motor_commutation"] = self._waves(turns, POLES, True)
        speed = np.gradient(run.tip[:, :3, 3], run.dt, axis=0)[r] * 1e3
        out["latency"] = [self._stack(np.einsum("nij,nj->ni", self.turn, speed))]

    def _waves(self, turns, orders, drive):
        """A list of pairs, kept apart: of waves one frequency at a time is at work."""
        q = self.run.c[self.rows]
        return [[self.joint(i, f(k * q[:, i]), drive) for f in (np.sin, np.cos)] for i in turns for k in orders]

    def _on_table(self):
        """Six columns of a small frame in base, at the table's axis."""
        out = [self._stack(np.tile(e, (len(self.rows), 1))) for e in np.eye(3)]
        return out + [self._stack(np.cross(np.tile(e, (len(self.rows), 1)), self.pos / 1e3)) for e in np.eye(3)]


def left(pattern, columns):
    """What least squares on columns leave of a pattern."""
    if columns.shape[1] == 0:
        return pattern
    scale = np.linalg.norm(columns, axis=0)
    columns = columns[:, scale > 1e-12] / scale[scale > 1e-12]
    return pattern - columns @ np.linalg.lstsq(columns, pattern, rcond=1e-9)[0]


def size(pattern, rows):
    """Rms of both stages, mm."""
    return float(np.sqrt((pattern**2).sum() / rows))


def patterns(designs, pattern_of, latency=True):
    """The patterns of one cause over all logs, each with its own nuisances taken off, stacked."""
    return np.concatenate([left(pattern_of(d), d.absorbed(latency)) for d in designs])


def alike(designs, name, stacked, late):
    """Names of the contract whose columns give the pattern of `name` back by a correlation above 0.99."""
    out, total = [], float((stacked**2).sum())
    if total <= 0:
        return out
    spans = [d.spans() for d in designs]
    keep = [d.absorbed(late) for d in designs]
    names = set.intersection(*(set(s) for s in spans)) - {name}
    for other in sorted(names):
        pairs = isinstance(spans[0][other][0], list)
        groups = range(len(spans[0][other])) if pairs else [None]
        best = total
        for g in groups:
            columns = []
            for s, nuisance in zip(spans, keep, strict=True):
                own = np.array(s[other][g] if pairs else s[other]).T
                columns.append(np.column_stack([left(c, nuisance) for c in own.T]))
            best = min(best, float((left(stacked, np.vstack(columns)) ** 2).sum()))
        if np.sqrt(max(0.0, 1.0 - best / total)) > ALIKE:
            out.append(other)
    return out


def pattern(design, causes):
    """The gap that causes make on a log, as stacked stages."""
    drive, body = gap(design.run, causes, design.rows)
    if not design.log["encoders"] or not design.log["setpoints"]:
        return np.concatenate([np.zeros_like(body), body + drive if design.log["setpoints"] else body]).ravel()
    if not design.log["tracker"]:
        body = np.zeros_like(body)
    return np.concatenate([drive, body]).ravel()
