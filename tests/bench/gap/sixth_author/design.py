"""What a log can't tell apart: a cause's pattern held against all that the parameters of another name can show."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from gap.sixth_author.chain import Body
from gap.sixth_author.world import loose, played

ALIKE = 0.99
LEVER = 1 / np.radians(0.05)  # mm a rad: by how much an instrument sees turns less well than places


def _apart(run, tip, six):
    """How far poses are from the nominal ones, in mm, turns by `LEVER` where they are measured."""
    off = (tip - run.nominal)[:, :3, 3] * 1e3
    if six:
        turn = Rotation.from_matrix(tip[:, :3, :3] @ run.nominal[:, :3, :3].transpose(0, 2, 1)).as_rotvec()
        off = np.concatenate([off, LEVER * turn], 1)
    return off.ravel()


def patterns(run, six) -> dict[str, list[np.ndarray]]:
    """Columns (mm) by name: first derivatives of what is measured by each parameter of the usual model."""
    m, e = run.machine, 1e-6

    def _moved(run, twists=None, rows=None):
        return _apart(run, run.tip(run.c[run.rows], twists, rows), six)

    jac = m.jacobian(run.c[run.rows])
    jac = np.concatenate([jac[:, :3] * 1e3, LEVER * jac[:, 3:]], 1)[:, : 6 if six else 3]
    if run.tied:
        q = m.joints[0].sign * run.c[run.rows, 0]
        back = np.zeros((len(q), 3, 3))
        back[:, 0, 0] = back[:, 1, 1] = np.cos(q)
        back[:, 0, 1], back[:, 1, 0], back[:, 2, 2] = -np.sin(q), np.sin(q), 1.0
        jac = np.concatenate([back @ jac[:, i : i + 3] for i in range(0, jac.shape[1], 3)], 1)
    load = run.load[run.rows]
    one = np.eye(6) * e
    out = {
        "frame_base": [_moved(run, {"world": w}) for w in one],
        "frame_tool": [_moved(run, {"tip": w}) for w in one],
        "joint_offset": [jac[:, :, k].ravel() for k in m.turning],
        "geometry": [_moved(run, None, {(k, n): np.array(e)}) for k in m.arm for n in ("a", "d", "alpha", "beta")],
        "joint_compliance": [(jac[:, :, k] * load[:, k : k + 1]).ravel() for k in m.turning],
        "latency": [np.einsum("nik,nk->ni", jac, run.v[run.rows]).ravel()],
        "servo_lag": [(jac[:, :, k] * run.v[run.rows, k : k + 1]).ravel() for k in range(len(m.joints))],
        "acceleration_error": [(jac[:, :, k] * run.a[run.rows, k : k + 1]).ravel() for k in m.turning],
        "measurement_scale": [_padded(run.nominal[:, :3, 3], six)],
    }
    out["measurement_frame"] = out["frame_base"]
    out["setpoint_delay"] = out["servo_lag"]
    foot = m.foot_moment(run.c[run.rows])
    out["lean"] = [_moved(run, {m.foot: e * np.c_[0 * foot, foot * w / 1e3]}) for w in np.eye(3)]
    last, tool = m.names[m.arm[-1]], m.bodies[-1]
    soft = 1 / np.array(m.stiff)
    for c in (tool.centre, *(np.array(tool.centre) + 100 * w for w in np.eye(3))):
        more = run.load_of((Body(last, 1.0, tuple(c)),))[run.rows] * soft
        out.setdefault("payload", []).append(np.einsum("nik,nk->ni", jac, more).ravel())
    if "E1" in m.names:
        k = m.index("E1")
        s = (run.c[run.rows, k] / m.unit[k] - m.home[k]) / m.swing[k]
        shapes = [s**p for p in (1, 2, 3)]
        out["track"] = [_moved(run, {k: e * x[:, None] * w}) for x in shapes for w in np.eye(6)]
    if run.tied:
        q = run.c[run.rows, 0]
        waves = [f(n * q) for n in (1, 2) for f in (np.sin, np.cos)]
        out["frame_table"] = [_moved(run, {"table": w}) for w in one[:5]]
        out["turntable"] = [_moved(run, {"table": x[:, None] * w}) for x in waves for w in one]
    return out


def _padded(places, six):
    return (np.concatenate([places, 0 * places], 1) if six else places).ravel()


def _free(run, log):
    """Columns of what is unknown, with their turns."""
    columns = loose(run, log)
    if not log["six"]:
        return columns
    out = [np.concatenate([x.reshape(-1, 3), 0 * x.reshape(-1, 3)], 1) for x in columns]
    for k in range(3, min(6, len(out))):
        out[k][:, k] = LEVER / 1e3
    return [x.ravel() for x in out]


def alike(runs, causes, log, drives) -> dict[str, list[str]]:
    """By cause, the names whose parameters show its pattern on these logs at a correlation above `ALIKE`."""
    spans = [patterns(r, log["six"]) for r in runs]
    out = {}
    for cause in causes:
        got = [(r, played(r, [cause])) for r in runs]
        d = np.concatenate([_apart(r, r.tip(p.motor[r.rows]) if drives else p.tip, log["six"]) for r, p in got])
        free = [_free(r, log) for r in runs]
        fixed = [np.concatenate([f[i] for f in free]) for i in range(len(free[0]))]
        found = []
        inner = cause.stage == "setpoint_to_encoder" and log["encoders"]
        for name in spans[0]:
            if (inner or drives) and name not in ("servo_lag", "setpoint_delay"):
                continue
            if log["encoders"] and not inner and name in ("servo_lag", "setpoint_delay"):
                continue
            if name == cause.name or any(len(s[name]) != len(spans[0][name]) for s in spans):
                continue
            own = [np.concatenate([s[name][i] for s in spans]) for i in range(len(spans[0][name]))]
            a = np.array(fixed + own).T
            a = a / (np.linalg.norm(a, axis=0) + 1e-30)
            d0 = d
            if fixed:
                f = np.array(fixed).T
                d0 = d - f @ np.linalg.lstsq(f, d, rcond=None)[0]
            rest = d - a @ np.linalg.lstsq(a, d, rcond=1e-9)[0]
            if np.linalg.norm(rest) < np.sqrt(1 - ALIKE**2) * np.linalg.norm(d0):
                found.append(name)
        out[cause.name] = found
    return out
