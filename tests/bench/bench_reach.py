"""The area that can be milled, with and without the spare freedoms: python tests/bench/bench_reach.py

The published method's Figure 11. Over a plane of `base`, a tool pointing down or lying level: the best 1/k_F among
all postures within their limits that put the tool there, the table, the track and the tool's roll each free or held at home.
Collisions are left out. Writes docs/explanation/reach.png and prints the areas.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from camrob.cell.read_cell import read_cell  # noqa: E402
from camrob.frozen import locked  # noqa: E402
from camrob.redundancy.planning.certificate import ROLLS, external_grid, scan  # noqa: E402
from camrob.redundancy.planning.freedoms import plan_space  # noqa: E402
from camrob.se3 import pose  # noqa: E402

CELL = read_cell(ROOT / "cells" / "kr15_track_table")
SPACE = plan_space(CELL)
EDGE, STEP, HEIGHT = 2.6, 0.2, 0.3  # m: the plane's half, its raster, and how high it lies
WAYS = {
    "nothing spare (table, track, roll held)": (False, False),
    "the roll": (False, True),
    "table and track": (True, False),
    "all three": (True, True),
}
TOOLS = {"pointing down": (0.0, 0.0, 1.0), "level, along X": (1.0, 0.0, 0.0)}


def best(position: np.ndarray, axis: np.ndarray, external: bool, roll: bool) -> float:
    """The best 1/k_F, 0 where nothing reaches."""
    across = np.array([0.0, 1.0, 0.0])
    frame = locked(pose(np.stack([np.cross(across, axis), across, axis], axis=1), position))
    home = np.ascontiguousarray(CELL.q_home[SPACE.free][None, : len(SPACE.free) - SPACE.roll])
    found = scan(SPACE, frame, external_grid(SPACE) if external else home, ROLLS)
    return float(found.max() if roll else found[:, ROLLS // 2].max())


def main() -> None:
    ticks = np.arange(-EDGE, EDGE + 0.5 * STEP, STEP)
    figure, axes = plt.subplots(
        len(TOOLS), len(WAYS), figsize=(13, 6.6), sharex=True, sharey=True, layout="constrained"
    )
    print("| tool | free | area in reach, m2 | with 1/k_F of 0.5 and more, m2 |\n| --- | --- | --- | --- |")
    for row, (tool, axis) in zip(axes, TOOLS.items(), strict=True):
        for picture, (way, free) in zip(row, WAYS.items(), strict=True):
            value = np.array([[best(np.array([x, y, HEIGHT]), np.array(axis), *free) for x in ticks] for y in ticks])
            area = [np.count_nonzero(value > least) * STEP**2 for least in (0.0, 0.5)]
            print(f"| {tool} | {way} | {area[0]:.2f} | {area[1]:.2f} |", flush=True)
            shown = np.where(value > 0.0, value, np.nan)
            edges = (ticks[0] - 0.5 * STEP, ticks[-1] + 0.5 * STEP)
            drawn = picture.imshow(shown, origin="lower", extent=(*edges, *edges), vmin=0.0, vmax=0.75, cmap="viridis")
            picture.set_title(f"{way}\n{area[0]:.1f} m², {area[1]:.1f} m² from 0.5 on", fontsize=9)
        row[0].set_ylabel(f"tool {tool}\ny in base, m")
    for picture in axes[-1]:
        picture.set_xlabel("x in base, m")
    figure.colorbar(drawn, ax=axes, label="best 1/k_F", shrink=0.8)
    figure.savefig(ROOT / "docs/explanation/reach.png", dpi=90)


if __name__ == "__main__":
    main()
