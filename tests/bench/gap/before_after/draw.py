"""Cases of a machine that became another between two logs or at a moment of one, and of machines that did not: drawn, from
physics alone. A case is a dict: arm, logs (fitted, in order), withheld, label.
"""

from __future__ import annotations

import numpy as np

from gap.before_after.machine import HOME, Faults, followed, moved, real, tip

__all__ = ["KINDS", "case"]

KINDS = ("zero", "play", "tool", "frame", "give", "lag", "links")
_NAME = {
    "zero": "joint_offset",
    "play": "backlash",
    "tool": "frame_tool",
    "frame": "measurement_drift",
    "give": "joint_compliance",
    "lag": "servo_lag",
    "links": "geometry",
}
ALIKE = {
    "play": {"hysteresis"},
    "frame": {"frame_base", "measurement_frame"},
    "tool": {"measurement_drift"},
    "lag": {"setpoint_delay"},
    "give": {"payload", "lean"},
}


def _field(rng, size):
    """A smooth error over posture, m rms an axis."""
    axes = rng.integers(0, 6, (14, 2))
    rate, phase = rng.uniform(0.6, 2.5, (14, 2)), rng.uniform(0, 6.3, 14)
    way = rng.normal(size=(14, 3))

    def at(q):
        waves = np.cos(sum(q[:, axes[:, j]] * rate[:, j] for j in range(2)) + phase)
        return size * waves @ way / np.sqrt(7)

    return at


def _poses(rng, arm, count):
    home = np.radians(HOME[arm])
    span = np.radians([60, 30, 35, 80, 50, 120])
    return home + rng.uniform(-1, 1, (count, 6)) * span


def _path(rng, arm, count, dt):
    """Smooth motions of all axes to and fro: sums of waves, each axis at its own beat."""
    t = np.arange(count) * dt
    span = np.radians([30, 14, 16, 40, 30, 60]) * rng.uniform(0.5, 1, 6)
    rate, phase = rng.uniform(0.15, 0.6, (3, 6)), rng.uniform(0, 6.3, (3, 6))
    waves = sum(np.sin(2 * np.pi * rate[k] * t[:, None] + phase[k]) for k in range(3)) / 3
    return np.radians(HOME[arm]) + rng.uniform(-0.5, 0.5, 6) * np.radians([60, 20, 20, 80, 40, 90]) + span * waves


def _fault(rng, kind, arm):
    """A fault of unit size, and its axis."""
    f, axis = Faults(), None
    if kind in ("zero", "play", "give", "lag"):
        axis = (
            int(rng.integers(1, 3))
            if kind == "give"
            else int(rng.integers(1, 6))
            if kind == "zero"
            else int(rng.integers(0, 6))
        )
        getattr(f, {"zero": "zero", "play": "play", "give": "give", "lag": "lag"}[kind])[axis] = {
            "zero": 1e-3,
            "play": 1e-3,
            "give": 1e-6,
            "lag": 0.01,
        }[kind]
    elif kind == "links":
        axis = int(rng.choice([1, 2]))
        f.links[axis] = 1e-3
    else:
        way = rng.normal(size=6) * np.array([1e-3] * 3 + [5e-4] * 3)
        (f.right if kind == "tool" else f.left)[:] = way
    return f, axis


def _scaled(f, by):
    return Faults(**{k: getattr(f, k) * by for k in f.__dataclass_fields__})


def _twists(arm, q, left, right):
    """(3 N, k) how an open frame and an open target move the tip."""
    T = tip(arm, q)[0]
    parts = []
    if left:
        p = T[:, :3, 3]
        parts += [np.tile(e, (len(q), 1)) for e in np.eye(3)] + [np.cross(e, p) for e in np.eye(3)]
    if right:
        parts += [T[:, :3, k] for k in range(3)]
    return np.stack([x.ravel() for x in parts], axis=1) if parts else np.zeros((3 * len(q), 0))


def _seen(arm, q, t, f, poses, left, right):
    """m rms of what a fault moves the tip by, less what an open frame and target take."""
    at = followed(q, t, f.lag)
    gap = (real(arm, at, f, poses)[:, :3, 3] - tip(arm, q)[0][:, :3, 3]).ravel()
    X = _twists(arm, q, left, right)
    rest = gap - X @ np.linalg.lstsq(X, gap, rcond=None)[0] if X.shape[1] else gap
    return float(np.sqrt(np.mean(rest**2) * 3))


def case(seed, kind=None, *, nothing=None, within=None, plain=False):
    """One case. kind: of what changes; nothing: nothing does, but perhaps where the tracker stands; within: at a moment of a log;
    plain: the smallest of its kind, poses of one machine without any other fault, in a known frame.
    """
    rng = np.random.default_rng([20261128, seed])
    nothing = bool(rng.random() < 0.3) if nothing is None else nothing
    within = bool(rng.random() < 0.3) if within is None else within
    kind = kind or str(rng.choice(KINDS))
    arm = str(rng.choice(["large", "middle", "light"]))
    poses = kind != "lag" and bool(rng.random() < 0.6)
    known = bool(rng.random() < 0.5) or kind == "frame" or (within and kind == "zero")
    told_tool = kind == "tool" or bool(rng.random() < 0.4)
    n = int(rng.integers(1, 3)) if within else int(rng.integers(2, 5))
    since = int(rng.integers(0, n)) if within else int(rng.integers(1, n))
    noise = float(rng.choice([0.01, 0.02, 0.04])) * 1e-3
    floor = noise * np.sqrt(3)
    level = float(rng.uniform(2, 6)) if rng.random() < 0.5 else 0.0
    smooth = _field(rng, level * noise)
    count, dt = (int(rng.integers(40, 70)), 20.0) if poses else (int(rng.integers(500, 900)), 0.02)
    runs = [(_poses(rng, arm, count) if poses else _path(rng, arm, count, dt)) for _ in range(n + 1)]
    t = np.arange(count) * dt
    if plain:
        arm, poses, known, told_tool, level = "middle", True, True, True, 0.0
        n, since = (1, 0) if within else (2, 1)
        count, dt, smooth = 45, 20.0, _field(rng, 0.0)
        runs = [_poses(rng, arm, count) for _ in range(n + 1)]
        t = np.arange(count) * dt
    size = floor * max(level, 1.0) * float(rng.uniform(2, 6))

    def sized(f, ratio=1.0):
        return _scaled(
            f, ratio * size / max(np.mean([_seen(arm, q, t, f, poses, not known, not told_tool) for q in runs]), 1e-9)
        )

    always, old = Faults(), None
    if not plain and rng.random() < 0.5:
        old_kind = str(rng.choice(["zero", "links", "play"]))
        f, axis = _fault(rng, old_kind, arm)
        always, old = sized(f, float(rng.uniform(0.5, 1.5))), (_NAME[old_kind], axis)
    new, axis = _fault(rng, kind, arm)
    new = sized(new)
    at = float(rng.uniform(0.25, 0.75)) if within else None
    stood = [
        moved(np.r_[rng.normal(size=3) * 1.0, rng.normal(size=3) * 0.5]) if not known else np.eye(4)
        for _ in range(n + 1)
    ]
    anew = nothing and known and bool(rng.random() < 0.4)
    if anew:
        k = int(rng.integers(1, n)) if n > 1 else 0
        for j in range(k, n + 1) if n > 1 else ():
            stood[j] = moved(np.r_[rng.normal(size=3) * 3e-4, rng.normal(size=3) * 1e-4])
    target = Faults(right=np.r_[rng.normal(size=3) * 0.02, 0, 0, 0]) if not told_tool else Faults()
    logs = []
    for k, q in enumerate(runs):
        share = np.zeros(count, bool)
        if not nothing:
            share[:] = k > since if within else k >= since
            if within and k == since:
                share = np.arange(count) >= int(at * count)
        logs.append(
            _log(
                rng,
                arm,
                q,
                t,
                poses,
                always.plus(target),
                new,
                share,
                stood[k],
                smooth,
                noise,
                known,
                told_tool,
                kind == "lag",
                k,
            )
        )
    label = {
        "seed": seed,
        "nothing": nothing,
        "kind": kind,
        "name": _NAME[kind],
        "axis": None if axis is None else f"A{axis + 1}",
        "within": within,
        "since": since,
        "row": int(at * count) if within else None,
        "old": old,
        "level": level,
        "noise_mm": noise * 1e3,
        "size_mm": size * 1e3,
        "poses": poses,
        "known": known,
        "told_tool": told_tool,
        "n": n,
        "arm": arm,
        "anew": anew,
    }
    return {"arm": arm, "logs": logs[:n], "withheld": logs[n:], "label": label}


def _log(rng, arm, q, t, poses, always, new, share, stood, smooth, noise, known, told_tool, drives, k):
    """One log: columns in the file's units, and what its .toml says."""
    both = always.plus(new)
    at = np.where(share[:, None], followed(q, t, both.lag), followed(q, t, always.lag))
    before, after = (real(arm, at, f, poses)[:, :3, 3] for f in (always, both))
    place = np.where(share[:, None], after, before) + smooth(at)
    seen = place @ stood[:3, :3].T + stood[:3, 3] + noise * rng.normal(size=place.shape)
    columns = {"t": t, **{c: 1e3 * seen[:, i] for i, c in enumerate("xyz")}}
    columns |= {f"A{i + 1}": np.round(np.degrees(at[:, i]), 5) for i in range(6)}
    if drives:
        columns |= {f"cA{i + 1}": np.round(np.degrees(q[:, i]), 5) for i in range(6)}
    info = {
        "measured_frame": "world" if known else "unknown",
        "target": "tool" if told_tool else "unknown",
        "sigma_mm": noise * 1e3,
        "poses": poses,
    }
    if drives:
        info["sigma_axis_deg"] = 0.0002
    if not told_tool and k:
        info["same_target_as"] = "log0.csv"
    return {"name": f"log{k}.csv", "columns": columns, "info": info}
