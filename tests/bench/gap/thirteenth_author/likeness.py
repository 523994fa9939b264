"""What a log can't tell from a cause, by numbers: the best that each name's usual description makes of it on these very rows."""

from __future__ import annotations

import numpy as np

from .arms import chain, jacobian, level, moment_at, placed, weight
from .wear import backlash, free_of_zeros, hysteresis, smooth

MOST = 700  # rows


def without(columns, gap):
    """`gap` (N, 3) less what `columns` (each (N, 3)) can take of it."""
    if not columns:
        return gap
    A = np.stack([c.ravel() for c in columns], axis=1)
    A = A / np.linalg.norm(A, axis=0)
    return gap - (A @ np.linalg.lstsq(A, gap.ravel(), rcond=1e-9)[0]).reshape(-1, 3)


def _seam(T, at):
    """Six columns: what a small motion at frames `at` does to the tip."""
    R, r = at[:, :3, :3], T[:, :3, 3] - at[:, :3, 3]
    return [R[:, :, k] for k in range(3)] + [np.cross(R[:, :, k], r) for k in range(3)]


def _links(run, J):
    """Columns of names that move links behind encoders, axis by axis."""
    m, out = run.m, {}
    tau = weight(m, run.v)
    more = weight(m.carrying(m.load + 1), run.v) - tau
    arm = range(m.first, len(m.axes))
    col = [J[:, :3, i] for i in range(len(m.axes))]
    out["joint_offset"] = [col[i] for i in arm]
    out["joint_compliance"] = [tau[:, [i]] * col[i] for i in arm if not m.slides[i] and np.ptp(tau[:, i]) > 1e-9]
    out["payload"] = [more[:, [i]] * col[i] for i in arm if not m.slides[i] and np.ptp(more[:, i]) > 1e-9]
    rough = np.where(m.slides, 2e-5, 1e-4)
    out["backlash"] = [backlash(run, [i], None, rough[i]).link[:, [i]] * col[i] for i in range(len(col))]
    out["hysteresis"] = [
        hysteresis(run, [i], None, rough[i], length=length).link[:, [i]] * col[i]
        for i in range(len(col))
        for length in (0.01, 0.05)
    ]
    if run.rests:
        out["early_reading"] = [sum((run.came - run.v)[:, [i]] * col[i] for i in range(len(col)))]
    if all(n in m.names for n in ("A4", "A5", "A6")) and len(arm) == 6:
        a4, a5, a6 = m.of(("A4", "A5", "A6"))
        out["wrist_coupling"] = [run.v[:, [a4]] * col[a5], run.v[:, [a4]] * col[a6], run.v[:, [a5]] * col[a6]]
    if run.force is not None:
        push = np.einsum("nij,ni->nj", J[:, :3], run.force)
        out["cutting_force"] = [push[:, [i]] * col[i] for i in arm]
    return out


def _structure(run, J, T, ends, tool):
    """Columns of names that move parts, or the instrument."""
    m, out = run.m, {}
    foot = ends[m.first - 1] if m.first else np.tile(placed(*m.base), (len(T), 1, 1))
    base = _seam(T, foot)
    out["frame_base"] = base
    out["frame_tool"] = _seam(T, tool)
    M = moment_at(m, run.v, m.first)[:, :2]
    if np.ptp(M) > 1e-6:
        out["lean"] = [M[:, [0]] * base[3], M[:, [1]] * base[4], M[:, [0]] * base[4], M[:, [1]] * base[3]]
    out["geometry"] = []
    for i in range(m.first, len(m.axes)):
        alpha, a, _, _ = m.axes[i].row
        seam = _seam(T, ends[i] @ np.linalg.inv(placed(x=a) @ placed(c=alpha)))
        out["geometry"] += [seam[k] for k in free_of_zeros(m, i)]
    p = T[:, :3, 3]
    out["measurement_frame"] = [np.tile(e, (len(p), 1)) for e in np.eye(3)] + [np.cross(e, p) for e in np.eye(3)]
    out["measurement_scale"] = [p - p.mean(axis=0), *out["measurement_frame"][:3]]
    u = run.part[:, None]
    out["measurement_drift"] = [f * c for f in (u, u**2) for c in out["measurement_frame"]]
    if run.temp is not None:
        warm = (run.temp - run.temp.mean())[:, None]
        out["thermal_drift"] = [warm * J[:, :3, i] for i in range(m.first, len(m.axes))]
        out["thermal_drift"] += [warm * c for i in range(m.first, len(m.axes)) for c in _seam(T, ends[i])[:3]]
    if m.first:
        seam, q = _seam(T, ends[0]), run.v[:, [0]]
        if m.slides[0]:
            u = q / np.ptp(m.limits[0])
            out["track"] = [f * c for f in (u, u**2, u**3, np.sin(2 * np.pi * u), np.cos(2 * np.pi * u)) for c in seam]
        else:
            out["frame_table"] = seam
            waves = (np.cos(q), np.sin(q), np.cos(2 * q), np.sin(2 * q))
            out["turntable"] = [f * c for f in waves for c in seam] + [f * J[:, :3, 0] for f in waves[:2]]
    return out


def _moving(run, col):
    """Columns of names that follow speed and acceleration, `col` what each axis does to the tip."""
    out, n = {}, range(len(col))
    v, a = run.speed, run.jerkless
    out["servo_lag"] = [v[:, [i]] * col[i] for i in n]
    out["setpoint_delay"] = [(np.interp(run.t - 0.004, run.t, run.v[:, i]) - run.v[:, i])[:, None] * col[i] for i in n]
    out["acceleration_error"] = [a[:, [i]] * col[i] for i in n]
    rub = [np.tanh(v[:, [i]] / run.m.tops[i] / 0.01) for i in n]
    out["friction"] = [r * col[i] for i, r in enumerate(rub)]
    out["friction"] += [(rub[i] - 0.7 * smooth(rub[i], run, 0.9)) * col[i] for i in n]
    return out


def _ripples(run, col, waves):
    return [f(waves * run.v[:, [i]]) * c for i, c in enumerate(col) for f in (np.cos, np.sin)]


def _of(order, run, cause, of_drives):
    """Name to columns (each (N, 3)), of the stage in which the cause is: what is logged on both sides of it tells the stage."""
    v = run.v if order.sees == "plate_arm" else level(run.m, run.v)
    _, ends, T = chain(run.m, v)
    J = jacobian(run.m, v)
    J[:, :3] += np.cross(J[:, 3:], (T[:, :3, :3] @ run.target[:3, 3])[:, :, None], axis=1)
    tool, T = T, T @ run.target
    col = [J[:, :3, i] for i in range(len(run.m.axes))]
    waves = cause.more.get("waves")
    if of_drives:
        out = _moving(run, col)
        if waves is not None:
            out["motor_commutation"] = _ripples(run, col, waves)
        return out
    if order.columns == "M":
        rough, n = np.where(run.m.slides, 2e-5, 1e-4), range(len(col))
        out = {"backlash": [backlash(run, [i], None, rough[i]).link[:, [i]] * col[i] for i in n]}
        out["hysteresis"] = [hysteresis(run, [i], None, rough[i], length=0.03).link[:, [i]] * col[i] for i in n]
        return out
    out = {**_links(run, J), **_structure(run, J, T, ends, tool)}
    if waves is not None:
        out["gear_ripple"] = _ripples(run, col, waves)
    if not run.rests:
        out["latency"] = [np.gradient(T[:, :3, 3], run.t, axis=0)]
    return out


def likenesses(order, runs, nuisances, gaps, cause, of_drives):
    """Name to the correlation of its best with the cause, both less what frame, target and clock take, over the judged runs."""
    best, total = {}, 0.0
    columns, wholes = {}, []
    for run, taken_by, gap in zip(runs, nuisances, gaps, strict=True):
        rows = np.unique(np.linspace(0, len(gap) - 1, min(MOST, len(gap))).astype(int))
        free = [c[rows] for c in taken_by]
        wholes.append(without(free, gap[rows]).ravel())
        for name, cols in _of(order, run, cause, of_drives).items():
            if cols:
                columns.setdefault(name, []).append(np.array([without(free, c[rows]).ravel() for c in cols]))
    y = np.concatenate(wholes)
    total = float(y @ y)
    for name, parts in columns.items():
        if len(parts) != len(runs) or not len(parts[0]) or not total:
            continue
        A = np.concatenate(parts, axis=1).T
        size = np.linalg.norm(A, axis=0)
        A = A[:, size > 1e-12 * max(size.max(), 1e-300)]
        A = A / np.linalg.norm(A, axis=0)
        left = y - A @ np.linalg.lstsq(A, y, rcond=1e-8)[0]
        best[name] = float(np.sqrt(max(0.0, 1 - left @ left / total)))
    return best
