"""The best posture of track, table and roll that is held for a whole path, beside what the planner posts.

`python tests/bench/bench_fixed.py [PATH ...] [--to FILE.md]`; PATH: a sample's name or `family` (36 drawn paths, `path_family`).
A rival that needs no postprocessor: table and track stand still at one place, the tool's roll at one angle from frames that turn
as little as can be, and the arm does the rest. Every place of the planner's own grid (track each 0.15 m, table each 20 degrees)
is tried, with each 15 degrees of roll, and each branch of the arm anew in every region. A place counts where one branch reaches
all poses of each region within limits; the one of the highest mean 1/k_F over what is cut is shown. In the rival's favour nothing
is asked of what it touches, of whole turns of A4 and A6 between poses, or of feed.
Reach: the share of all places and rolls that count.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT), str(HERE)]

from bench_posted import SAMPLES, cases  # noqa: E402

from camrob.redundancy.planning.certificate import external_grid, scan  # noqa: E402
from camrob.redundancy.planning.freedoms import PlanSpace, plan_space  # noqa: E402
from camrob.redundancy.planning.waypoints import Waypoints, waypoints  # noqa: E402

SPACING = 0.02  # m of the path between poses
POSES = 150  # of a path at most, evenly along it
ROLLS = 24  # of a turn; the middle one is 0
HEAD = (
    "| path | roll 0, best place: lowest 1/k_F, mean | any roll, held: lowest, mean | at | planned: lowest, mean | reach, % "
    "|\n| --- | --- | --- | --- | --- | --- |"
)


def held(space: PlanSpace, w: Waypoints) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The grid (M, E) of external axes; lowest and mean 1/k_F (M, ROLLS) of what is cut in each; 0 where it is not in reach."""
    cut = np.flatnonzero(np.asarray(w.cut) > 0.0)
    cut = cut[np.unique(np.linspace(0, len(cut) - 1, POSES).astype(int))]
    grid, region, weight = external_grid(space), np.asarray(w.region)[cut], np.asarray(w.cut)[cut]
    lowest, total, reached = (np.full((len(grid), ROLLS), value) for value in (np.inf, 0.0, True))
    for r in np.unique(region):
        least, sums = np.full((len(grid), ROLLS, 8), np.inf), np.zeros((len(grid), ROLLS, 8))
        for k in np.flatnonzero(region == r):
            value = scan(space, np.asarray(w.base_T_tip)[cut[k]], grid, ROLLS).astype(float)
            least, sums = np.minimum(least, value), sums + weight[k] * value
        branch = np.argmax(np.where(least > 0.0, sums, -1.0), axis=2)[..., None]
        one, other = (np.take_along_axis(x, branch, axis=2)[..., 0] for x in (least, sums))
        lowest, total, reached = np.minimum(lowest, one), total + other, reached & (one > 0.0)
    return grid, np.where(reached, lowest, 0.0), np.where(reached, total / weight.sum(), 0.0)


def planned_figures() -> dict[str, tuple[str, str]]:
    """Path to lowest and mean 1/k_F of what is posted, of posted_table.md."""
    out = {}
    for line in (HERE / "posted_table.md").read_text().splitlines():
        cells = [cell.strip() for cell in line.split("|")]
        if len(cells) > 6 and cells[4][:1].isdigit():
            out[cells[1]] = cells[4].split(", ")[-1], cells[5].split(", ")[-1]
    return out


def row(name: str, cell: Any, path: Any, planned: dict[str, tuple[str, str]]) -> str:
    """One line of the table."""
    space = plan_space(cell)
    grid, lowest, mean = held(space, waypoints(path, SPACING))
    straight = int(np.argmax(mean[:, ROLLS // 2]))
    m, k = np.unravel_index(int(np.argmax(mean)), mean.shape)
    if mean[m, k] == 0.0:
        return f"| {name} | none | none | - | {', '.join(planned.get(name, ('-',)))} | 0 |"
    names = [cell.names[i] for i in space.free[: grid.shape[1]]]
    at = [
        f"{n} {1e3 * x:.0f} mm" if slides else f"{n} {np.degrees(x):.0f}°"
        for n, x, slides in zip(names, grid[m], space.prismatic, strict=True)
    ]
    zero = mean[straight, ROLLS // 2]
    first = f"{lowest[straight, ROLLS // 2]:.3f}, {zero:.3f}" if zero > 0.0 else "none"
    return (
        f"| {name} | {first} | {lowest[m, k]:.3f}, {mean[m, k]:.3f} | {', '.join(at)}, roll {-180 + 360 * k / ROLLS:.0f}° "
        f"| {', '.join(planned.get(name, ('-',)))} | {100.0 * np.mean(mean > 0.0):.1f} |"
    )


def main(names: list[str], to: Path | None) -> None:
    """Try all, print and write the table."""
    begun, planned = time.process_time(), planned_figures()
    rows = [
        "# Held at the best place there is, beside what is posted\n",
        f"{__doc__.split(chr(10), 2)[2].rstrip()}\n",
        HEAD,
    ]
    print(HEAD, flush=True)
    for name, cell, path, *_more in cases(names):
        rows.append(row(name, cell, path, planned))
        print(rows[-1], flush=True)
    print(f"{time.process_time() - begun:.0f} s of processor")
    if to is not None:
        to.write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("paths", nargs="*", default=[*SAMPLES, "family"])
    parser.add_argument("--to", type=Path)
    given = parser.parse_args()
    main(given.paths, given.to)
