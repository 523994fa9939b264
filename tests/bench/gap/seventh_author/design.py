"""Which names a case's logs can't tell from what is at work: their usual linear patterns give its own back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .named import NAMED
from .shift import Shift, read

ENOUGH = 0.99
ROWS = 120


def _units(run, n):
    """{name: [(field, values)]}: what one parameter of a name does, in the simplest model that there is of it."""
    eye, m = np.eye(n), run.machine
    v, a, came = run.at(run.v), run.at(run.a), run.came
    late = (run.late - run.late[0] + run.begun) / 1000

    def each(field, value):
        return [(field, np.broadcast_to(value, run.c.shape) * e) for e in eye]

    def frame(at, value=1.0, parts=range(6)):
        out = []
        for i in parts:
            twist = np.zeros((len(run.c), n + 2, 6))
            twist[:, at, i] = value
            out.append(("twist", twist))
        return out

    moment = run.machine.moment(run.c)
    waves = (
        [f(2 * np.pi * i * run.c[:, 0] / 3) for i in range(1, 9) for f in (np.sin, np.cos)] if m.kinds[0] == "P" else []
    )
    heavy = [
        ("true", np.array(m.soft) * m.load(run.c, ((n, 1.0, c),)))
        for c in ((0, 0, 0), (99, 0, 0), (0, 99, 0), (0, 0, 99))
    ]
    warm = 1 - np.exp(-late)
    return {
        "joint_offset": each("true", 1.0),
        "geometry": [u for k in range(1, n + 1) for u in frame(k, parts=(0, 2, 3, 4))],
        "frame_base": frame(0),
        "frame_tool": frame(n + 1),
        "joint_compliance": each("true", run.load),
        "payload": heavy,
        "lean": [u for i in range(2) for u in frame(0, moment[:, i], (3, 4))],
        "backlash": each("true", came),
        "hysteresis": each("true", came),
        "wrist_coupling": [("true", run.c[:, [i]] * eye[k]) for i in range(n - 3, n) for k in range(i + 1, n)],
        "thermal_drift": [u for k in range(1, n + 1) for u in frame(k, warm, (0, 1, 2))],
        "track": [u for w in waves for u in frame(1, w, (0, 1, 2))] + [u for u in frame(1, run.c[:, 0], (1,)) if waves],
        "servo_lag": each("enc", v),
        "setpoint_delay": each("enc", v),
        "friction": each("enc", came),
        "acceleration_error": each("enc", a),
        "latency": [("true", v)],
        "early_reading": each("true", np.diff(run.c, axis=0, prepend=m.middle[None])) if run.kind == "poses" else [],
        "cutting_force": [("off", run.force * e) for e in np.eye(3)] if run.kind == "path" else [],
        "measurement_scale": [("off", run.points - run.points.mean(0))],
        "measurement_drift": [("off", late[:, None] * e) for e in np.eye(3)]
        + [("off", late[:, None] * np.cross(e, run.points)) for e in np.eye(3)],
        "measurement_frame": frame(0),
    }


def _some(run):
    """Which of a log's rows are looked at; all of a set of poses."""
    return np.linspace(0, len(run.pick) - 1, min(ROWS, len(run.pick))).astype(int)


def _pattern(case, run, shift, at_rest):
    """What a shift does to a log, (N, 3) or the stages apart, (2 N, 3), where both are logged; `at_rest`: read without any."""
    servo = np.einsum("nij,nj->ni", run.machine.jacobian(run.c)[:, :3], shift.enc)
    if run.kind == "drives":
        return [servo]
    whole = read(run, shift, case.how["target"])[:, :3, 3] - at_rest
    return [whole] if case.how["lacks"] else [servo, whole - servo]


def _at_rest(case, run):
    return read(run, Shift.none(run), case.how["target"])[:, :3, 3]


def _matrix(case, names):
    """{name: patterns over all logs, a column a parameter}."""
    blocks = {name: [] for name in names}
    for whole in case.runs:
        run = replace(whole, pick=whole.pick[_some(whole)])
        units, at_rest = _units(run, run.machine.n), _at_rest(case, run)
        for name in names:
            columns = []
            for field, value in units[name]:
                most = np.abs(value).max() + 1e-12
                shift = Shift.none(run)
                getattr(shift, field)[...] = 1e-6 * value / most  # as small as a linear pattern wants
                columns.append(np.concatenate(_pattern(case, run, shift, at_rest)).ravel() * most)
            blocks[name].append(columns)
    return {k: np.concatenate([np.array(c).T for c in b]) for k, b in blocks.items() if all(b)}


def alike(case, cause, size):
    """Other names whose parameters give a cause's pattern back by a correlation above 0.99, after an unknown frame and target."""
    mine = []
    for run in case.runs:
        mine += [b[_some(run)].ravel() for b in _pattern(case, run, cause.make(run, size), _at_rest(case, run))]
    mine = np.concatenate(mine)
    names = [n for n in [*NAMED, "measurement_frame"] if n not in ("gear_ripple", "motor_commutation", cause.name)]
    if case.how["frame"] == "unknown":
        names = [n for n in names if n not in ("frame_base", "measurement_frame")]
    columns = _matrix(case, names)
    free = [_matrix(case, ["frame_base"])["frame_base"]] if case.how["frame"] == "unknown" else []
    free += [_matrix(case, ["frame_tool"])["frame_tool"][:, :3]] if case.how["target"] is not None else []
    if free:
        basis = np.linalg.qr(np.concatenate(free, 1))[0]
        mine = mine - basis @ (basis.T @ mine)
        columns = {k: c - basis @ (basis.T @ c) for k, c in columns.items()}
    out = []
    for name, c in columns.items():
        c = c / (np.linalg.norm(c, axis=0) + 1e-30)
        fit = c @ np.linalg.lstsq(c, mine, rcond=1e-9)[0]
        if fit @ mine > ENOUGH * np.linalg.norm(fit) * np.linalg.norm(mine):
            out.append(name)
    return out
