"""The path of the benchmarks: a dome milled in a spiral, tool leaning out and swaying, in steps of half a millimetre."""

from __future__ import annotations

from pathlib import Path

import numpy as np

__all__ = ["poses", "spiral", "write_cl_file"]

FIRST, LAST = 0.020, 0.130  # m, radii
STEP = 0.0005  # m
DOME = 0.25  # m, radius of the dome; its top is at HEIGHT above the table
HEIGHT = 0.25
SWAY = 0.1  # rad, three times a turn


def spiral(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Tips (count, 3), m, and unit tool axes (count, 3) in the table's frame; the pitch is such that the points fill the dome."""
    s = STEP * np.arange(count)
    squares = np.pi * (LAST**2 - FIRST**2)
    pitch = squares / max(s[-1], STEP)
    radius = np.sqrt(FIRST**2 + pitch * s / np.pi)
    angle = 2.0 * np.pi * (radius - FIRST) / pitch
    out = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    slope = np.arcsin(radius / DOME)
    tips = radius[:, None] * out + (HEIGHT - DOME * (1.0 - np.cos(slope)))[:, None] * up
    lean = slope + SWAY * np.sin(3.0 * angle)
    return tips, np.sin(lean)[:, None] * out + np.cos(lean)[:, None] * up


def poses(tips: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Poses (N, 4, 4), z the tool axis and x turning as little as can be."""
    rotations = np.empty((len(tips), 3, 3))
    x = np.array([1.0, 0.0, 0.0])
    for k, z in enumerate(axes):
        x = x - (x @ z) * z
        x = x / np.linalg.norm(x)
        rotations[k] = np.stack([x, np.cross(z, x), z], axis=1)
    out = np.tile(np.eye(4), (len(tips), 1, 1))
    out[:, :3, :3], out[:, :3, 3] = rotations, tips
    return out


def write_cl_file(file: Path, count: int, feed_mm_min: float = 3000.0) -> None:
    """The spiral as a CL file of `count` GOTO."""
    tips, axes = spiral(count)
    with file.open("w", encoding="ascii") as out:
        out.write(f"UNITS/MM\nMULTAX/ON\nFEDRAT/{feed_mm_min:.1f},MMPM\n")
        for start in range(0, count, 100_000):
            part = slice(start, start + 100_000)
            rows = np.hstack([1000.0 * tips[part], axes[part]]).tolist()
            out.write("".join("GOTO/{:.5f},{:.5f},{:.5f},{:.9f},{:.9f},{:.9f}\n".format(*row) for row in rows))
        out.write("FINI\n")
