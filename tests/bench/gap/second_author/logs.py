"""Logs in camrob's format: LOG.csv with LOG.toml beside it, through an instrument with noise of its own colour and gross rows."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from gap.second_author.run import played


def coloured(rng, shape, share, step):
    """Unit noise of which a share (of the variance) has a memory; `step` is the row's time over that memory."""
    white = rng.normal(size=shape)
    if share <= 0:
        return white
    keep = np.exp(-step)
    slow = lfilter([np.sqrt(1 - keep * keep)], [1.0, -keep], rng.normal(size=(shape[0] + 300, *shape[1:])), axis=0)[
        300:
    ]
    return np.sqrt(1 - share) * white + np.sqrt(share) * slow


def _rows(run, log, k):
    if run.rest:
        return np.arange(len(run.t))
    step = max(1, round(1.0 / log["rates"][k] / run.dt))
    return np.arange(step, len(run.t), step)


def _measured(run, causes, log, noise, rng, hidden, rows):
    """Positions (mm) and angles (degrees) as the instrument gives them."""
    encoders, tool = played(run, causes)
    encoders, tool = encoders[rows], hidden[0] @ tool[rows] @ hidden[1]
    step = float(np.median(np.diff(run.t[rows]))) / noise["memory_s"] if not run.rest else 0.3
    where = tool[:, :3, 3] * 1e3 + noise["sigma_mm"] * coloured(rng, (len(rows), 3), noise["colour"], step)
    gross = rng.random(len(rows)) < noise["gross"]
    where[gross] += rng.normal(size=(int(gross.sum()), 3)) * 25 * noise["sigma_mm"] + rng.choice(
        [-0.6, 0.6], (int(gross.sum()), 3)
    )
    turn = Rotation.from_matrix(tool[:, :3, :3]) * Rotation.from_rotvec(
        np.radians(noise["sigma_deg"]) * rng.normal(size=(len(rows), 3))
    )
    return encoders, where, turn.as_euler("ZYX", degrees=True)


def _torques(run, rows, rng, robot):
    """Torques by gravity, inertia and a bit of friction, with the noise of a current sensor."""
    reach = np.where(robot.slides, 60.0, np.linspace(12, 0.3, len(robot.rows)))
    load = -run.load + reach * run.a + 0.05 * (np.abs(run.load).max(0) + 5) * np.tanh(run.v / (0.01 * robot.unit * 57))
    return (load * (1 + 0.01 * rng.normal(size=load.shape)) + 0.1 * rng.normal(size=load.shape))[rows]


def write_log(folder: Path, name, run, causes, log, noise, rng, hidden, k):
    """Writes LOG.csv and LOG.toml; how many rows."""
    robot = run.robot
    rows = _rows(run, log, k)
    encoders, where, turn = _measured(run, causes, log, noise, rng, hidden, rows)
    head, columns = ["t"], [run.t[rows] - run.t[rows[0]] + 0.2]
    if log["tracker"]:
        head, columns = [*head, "x", "y", "z"], [*columns, *where.T]
        if log["sixd"]:
            head, columns = [*head, "a", "b", "c"], [*columns, *turn.T]
    sigma = noise["axis"] * np.where(robot.slides, 10, 1)
    axes = [*robot.names, *([robot.table] if robot.table else [])]
    table = np.degrees(run.turned[rows])[:, None] if robot.table else np.zeros((len(rows), 0))
    if log["encoders"]:
        read = encoders / robot.unit + sigma * rng.normal(size=encoders.shape)
        head, columns = head + axes, [*columns, *read.T, *table.T]
    if log["setpoints"]:
        head, columns = head + ["c" + a for a in axes], [*columns, *(run.c[rows] / robot.unit).T, *table.T]
    if log["show"] == "drives":
        letter = "I" if rng.random() < 0.4 and not robot.carriage else "T"
        told = [letter + (n[1:] if n.startswith("A") else n) for n in robot.names]
        head, columns = head + told, [*columns, *_torques(run, rows, rng, robot).T]
    if run.force is not None:
        head, columns = [*head, "fx", "fy", "fz"], [*columns, *(run.force[rows] + rng.normal(size=(len(rows), 3))).T]
    if log["temp"]:
        head, columns = (
            [*head, "temp"],
            [*columns, 21 + 8 * (1 - np.exp(-run.clock[rows] / 300)) + 0.05 * rng.normal(size=len(rows))],
        )
    with (folder / f"{name}.csv").open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(head)
        digits = [4 if h in ("x", "y", "z", "t") else 6 for h in head]
        out.writerows([[f"{v:.{d}f}" for v, d in zip(r, digits, strict=True)] for r in np.column_stack(columns)])
    _toml(folder / f"{name}.toml", run, log, noise, robot)
    return len(rows)


def _toml(path, run, log, noise, robot):
    lines = [f'measured_frame = "{log["frame"]}"', f'target = "{log["target"]}"']
    if noise["told"]:
        if log["tracker"]:
            lines.append(f"sigma_mm = {noise['sigma_mm']:.4f}")
        if log["tracker"] and log["sixd"]:
            lines.append(f"sigma_deg = {noise['sigma_deg']:.5f}")
        lines.append(f"sigma_axis_deg = {noise['axis']:.6f}")
        if robot.slides.any():
            lines.append(f"sigma_axis_mm = {noise['axis'] * 10:.6f}")
    if run.rest:
        lines.append("poses = true")
    lines.append(f"payload_kg = {robot.payload}")
    path.write_text("\n".join(lines) + "\n")
