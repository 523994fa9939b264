"""Logs as strangers write them, of an arm of 210 kg by modified Denavit-Hartenberg rows: numpy alone, nothing of camrob."""

from __future__ import annotations

from pathlib import Path

import numpy as np

ROWS = ((0, 0, 0, 675), (-90, 350, 0, 0), (0, 1150, -90, 0), (-90, -41, 0, 1200), (90, 0, 0, 0), (-90, 0, 0, 215))
_MIDDLE = np.radians([0, -60, 80, 0, 40, 0])
_SPAN = np.radians([90, 30, 40, 90, 50, 150])
LEFT, RIGHT = (
    (1500.0, -2200.0, 900.0, 35.0),
    (30.0, -45.0, 20.0),
)  # the instrument's frame: a shift, mm, and a turn; a reflector


_RAIL = """
[kinematics]
base_to_first = [0, 0, 0, -90, 0, -90]
standing = "measured"

[[joint]]
name = "E1"
role = "carriage"
type = "prismatic"
dh = { alpha_deg = 90, a_mm = 0, theta_deg = 0, d_mm = 0 }
standing = "measured"
"""


def cell_text(rows=ROWS, convention="modified", rail=False):
    """A cell.toml of an arm that is only measured; rail: it rides along x."""
    listed = "".join(f"  {[float(v) for v in row]},\n" for row in rows)
    arm = f'[arm]\nconvention = "{convention}"\ndh = [\n{listed}]\nstanding = "datasheet"\n'
    tool = '[tool]\nflange_to_tool = [50, 0, 250, 0, 30, 0]\nstanding = "measured"\n'
    return f'schema = 1\nname = "kr210"\n{_RAIL if rail else ""}\n{arm}\n{tool}'


def _turn(angle, axis):
    T, (i, j) = np.eye(4), {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    T[i, i] = T[j, j] = np.cos(angle)
    T[i, j], T[j, i] = -np.sin(angle), np.sin(angle)
    return T


def _shift(x, y, z):
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def tips(q):
    """(N, 4, 4) where the tool is at axis values (N, 6), rad; mm."""
    T = np.tile(np.eye(4), (len(q), 1, 1))
    for k, (alpha, a, theta, d) in enumerate(ROWS):
        turned = np.stack([_turn(v, "z") for v in np.radians(theta) + q[:, k]])
        T = T @ _turn(np.radians(alpha), "x") @ _shift(a, 0, 0) @ turned @ _shift(0, 0, d)
    return T @ _shift(50, 0, 250) @ _turn(np.radians(30), "y")


def on_rail(q, ways, course):
    """(N, 4, 4) of the tool of an arm that rides to `ways` (N,), mm, off its rail by course(ways) (N, 3), mm."""
    carried = np.tile(np.eye(4), (len(q), 1, 1))
    carried[:, :3, 3] = course(ways) + np.outer(ways, [1, 0, 0])
    return carried @ _turn(np.radians(-90), "z") @ tips(q)


def read(T, *, open_frames=False, slipped=(0, 0, 0), seed=0, sigma=0.02):
    """(N, 3) mm that an instrument reads of tools (N, 4, 4), at a reflector that slipped by mm."""
    if open_frames:
        T = _shift(*LEFT[:3]) @ _turn(np.radians(LEFT[3]), "z") @ T @ _shift(*np.add(RIGHT, slipped))
    return T[:, :3, 3] + np.random.default_rng(seed).normal(0.0, sigma, (len(T), 3))


def poses(count, seed):
    """(N, 6) rad, postures all over."""
    return _MIDDLE + _SPAN * np.random.default_rng(seed).uniform(-1, 1, (count, 6))


def run(seconds, step, seed):
    """Times (N,) and axis values (N, 6), rad, of an arm that goes from place to place and rests there for a moment."""
    rng, t = np.random.default_rng(seed), np.arange(round(seconds / step)) * step
    goals = _MIDDLE + 0.8 * _SPAN * rng.uniform(-1, 1, (int(seconds / 3.3) + 3, 6))
    leg, part = np.divmod(t, 3.3)
    u = np.minimum(part / 3.0, 1.0)[:, None]
    leg = leg.astype(int)
    return t, goals[leg] + (goals[leg + 1] - goals[leg]) * (10 * u**3 - 15 * u**4 + 6 * u**5)


def seen(q, *, wrong_deg=(0, 0, 0, 0, 0, 0), open_frames=False, slipped=(0, 0, 0), seed=0, sigma=0.02):
    """(N, 3) mm that an instrument reads of an arm whose axes are off by wrong_deg and whose reflector slipped by mm."""
    T = tips(q + np.radians(wrong_deg))
    return read(T, open_frames=open_frames, slipped=slipped, seed=seed, sigma=sigma)


def write(folder: Path, columns, facts, rows=ROWS, convention="modified", rail=False):
    """A cell and a log of it in a folder; facts: lines of LOG.toml."""
    (folder / "cell").mkdir(exist_ok=True)
    (folder / "cell" / "cell.toml").write_text(cell_text(rows, convention, rail))
    names, table = list(columns), np.stack(list(columns.values()), axis=1)
    lines = [",".join(names), *(",".join(f"{v:.6f}" for v in row) for row in table)]
    (folder / "log.csv").write_text("\n".join(lines) + "\n")
    (folder / "log.toml").write_text("\n".join(["sigma_mm = 0.02", *facts]) + "\n")


def columns_of(q, place, t=None, setpoints=None):
    """A log's columns, in degrees and mm."""
    found = {} if t is None else {"t": t}
    found |= dict(zip("xyz", place.T, strict=True))
    found |= {f"A{k + 1}": np.degrees(q[:, k]) for k in range(6)}
    return found if setpoints is None else found | {f"cA{k + 1}": np.degrees(setpoints[:, k]) for k in range(6)}
