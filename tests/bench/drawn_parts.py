"""Small parts drawn by rule for benches: toolpath, stock and cutter, from nothing of camrob.

Three kinds: a floor that a ball end mill rasters, a wall that a flat end mill follows round on two levels, and a dome that a ball
end mill rasters with its axis half way between the vertical and the dome's normal.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["FEED", "KINDS", "DrawnPart", "draw_part"]

Array = NDArray[np.float64]

FEED = 1500.0  # mm/min
KINDS = ("floor", "wall", "dome")
LIFT = 40.0  # mm
LENGTH = 60.0  # mm, of every cutter


@dataclass(frozen=True)
class DrawnPart:
    """tips, axes: (N, 3) of the places that cut, mm in `base`; radius, corner: mm of the cutter; box: (2, 3) mm of the stock."""

    kind: str
    tips: Array
    axes: Array
    radius: float
    corner: float
    box: Array

    def write(self, folder: Path) -> Path:
        """PART.cls and setup.toml in a folder: the former's path."""
        d, r = 2.0 * self.radius, self.corner
        lines = ["TOOL PATH/PART,TOOL,CUTTER", f"TLDATA/MILL,{d},{r},75.0,0.0,0.0"]
        lines += ["MSYS/0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0"]
        above = self.tips[[0, -1]] + LIFT * self.axes[[0, -1]]
        rows = [f"GOTO/{','.join(f'{v:.5f}' for v in (*p, *a))}" for p, a in zip(self.tips, self.axes, strict=True)]
        ends = [
            f"GOTO/{','.join(f'{v:.5f}' for v in (*p, *self.axes[k]))}" for p, k in zip(above, (0, -1), strict=True)
        ]
        lines += ["RAPID", ends[0], f"FEDRAT/MMPM,{FEED}", *rows, "RAPID", ends[1], "END-OF-PATH"]
        file = folder / "part.cls"
        file.write_text("\n".join(lines) + "\n")
        box = ", ".join(f"{v:.3f}" for v in self.box.ravel())
        (folder / "setup.toml").write_text(
            "part_in_base = [0, 0, 0, 0, 0, 0]\nspindle_rpm = 10000\n\n[tool]\n"
            f"diameter_mm = {d}\nlength_mm = {LENGTH}\ncorner_radius_mm = {r}\n\n[stock]\nbox_mm = [{box}]\n"
        )
        return file


def draw_part(kind: str, seed: int) -> DrawnPart:
    """A part of one of KINDS somewhere over the table."""
    rng = np.random.default_rng([seed, 91, KINDS.index(kind)])
    place = np.array([*rng.uniform(-120, 120, 2), rng.uniform(100, 300)])
    angle = rng.uniform(0, np.pi)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    width, size = rng.uniform(70, 110), 5.0
    if kind == "wall":
        radius, corner, size = 6.0, 0.0, 6.0
        along = np.linspace(0.0, 2.0 * np.pi, 25)
        a, b = 0.5 * width, rng.uniform(0.25, 0.4) * width
        # a rounded box: |x / a|^4 + |y / b|^4 = 1
        c, s = np.cos(along), np.sin(along)
        oval = np.stack([a * np.sign(c) * np.sqrt(np.abs(c)), b * np.sign(s) * np.sqrt(np.abs(s)), 0.0 * c], axis=1)
        local = np.concatenate([oval + np.array([0.0, 0.0, 4.0]), oval])
        axes = np.tile([0.0, 0.0, 1.0], (len(local), 1))
    else:
        radius, corner = size, size
        steps = np.linspace(-0.5 * width, 0.5 * width, 9)
        lines = (np.arange(6) - 2.5) * rng.uniform(4.0, 5.0)
        flat = [(x if k % 2 == 0 else -x, y) for k, y in enumerate(lines) for x in steps]
        local = np.array([(*p, 0.0) for p in flat])
        axes = np.tile([0.0, 0.0, 1.0], (len(local), 1))
        if kind == "dome":
            bend = rng.uniform(0.8, 1.2) * width  # mm, the sphere's radius
            z = np.sqrt(bend**2 - local[:, 0] ** 2 - local[:, 1] ** 2) - bend
            n = np.stack([local[:, 0], local[:, 1], z + bend], axis=1) / bend
            half = n + np.array([0.0, 0.0, 1.0])
            axes = half / np.linalg.norm(half, axis=1)[:, None]
            centre = np.stack([local[:, 0], local[:, 1], z], axis=1) + corner * n
            local = centre - corner * axes  # the tip, as CL data has it
    tips, axes = place + local @ turn.T, axes @ turn.T
    lower, upper = tips.min(axis=0) - 2.0 * radius, tips.max(axis=0) + 2.0 * radius
    upper[2] = tips[:, 2].max() + (2.0 if kind == "wall" else 1.5)
    lower[2] = tips[:, 2].min() - 8.0
    return DrawnPart(kind, tips, axes, radius, corner, np.stack([lower, upper]))
