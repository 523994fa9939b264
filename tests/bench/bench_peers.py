"""The tracker beside other solvers: same chain of nine joints, same path, same stopping rule, quality first.

Run: OMP_NUM_THREADS=1 python tests/bench/bench_peers.py [--install] [--parts] [--redraw PAGE] [--points N] [--out DIR]
[--cache DIR]

Every peer has an environment of its own under the cache folder (`--install` makes the missing ones with pip, several hundred
megabytes each); one that is not there is left out, with the reason in the table. Thread time on one core, set-up left out.
The closed forms of EAIK and ssik and COPP's feed stand in tables of their own (`--parts`: these alone). Writes peers.md and
peers.png. A planner's time has all its planning in it; TrajOpt gets the path's first 500 points, for it takes milliseconds each.
Tesseract's Descartes is left out: on this chain it needs a closed-form solver that samples table and track, described in a
plug-in file, and at the grid where it would be a plan memory runs out (0.1 m and 10 degrees: 50 MB a point).
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import subprocess
import sys
import tempfile
import venv
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import version
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from bench_follower import bounds, quality, run, setting  # noqa: E402
from peer_tables import CLOSED_FORMS, FEEDS, closed_form_table, feed_table  # noqa: E402
from spiral import write_cl_file  # noqa: E402

from camrob.cell.urdf import cell_urdf  # noqa: E402
from camrob.jobs.files.cell_for import cell_for  # noqa: E402
from camrob.jobs.files.inputs import read_inputs  # noqa: E402
from camrob.kinematics.frames import base_T_tool  # noqa: E402
from camrob.kinematics.kernels import inverse_kf_many  # noqa: E402
from camrob.redundancy.planned import resolve_planned  # noqa: E402

PACKAGES = {
    "placo": ["placo"],
    "pinocchio": ["pin", "numpy"],
    "pink": ["pin-pink", "qpsolvers[quadprog]"],
    "mink": ["mink", "mujoco", "daqp", "qpsolvers[daqp]"],
    "roboticstoolbox": ["roboticstoolbox-python"],
    "pytorch-kinematics": ["pytorch-kinematics"],
    "trajopt": ["tesseract-robotics"],
    "roboplan": ["roboplan"],
    "eaik": ["eaik"],
    "ssik": ["ssik"],
    "copp": ["copp-py"],
}
COLUMNS = ("error mm", "error deg", "step deg", "step mm", "1/k_F min", "1/k_F mean", "E1 mm", "E2 deg")
TIMEOUT = 600  # s a peer
AT_MOST = 2000  # poses of the path that closed forms get: ssik takes milliseconds each


def python_of(peer: str, cache: Path, install: bool) -> Path | str:
    """The peer's own Python, or why there is none."""
    if peer == "pytorch-kinematics":
        return Path(sys.executable)  # camrob needs it itself
    python = cache / peer / "bin" / "python"
    if not python.exists() and install:
        venv.create(cache / peer, with_pip=True)
        done = subprocess.run([python, "-m", "pip", "install", "-q", *PACKAGES[peer]], capture_output=True, text=True)
        if done.returncode:
            return "pip: " + done.stderr.strip().splitlines()[-1][:100]
    return python if python.exists() else "not installed (--install)"


def measure(peer: str, python: Path, folder: Path) -> tuple[np.ndarray, float, str] | str:
    """Postures, seconds and version of a peer, or why there are none."""
    script = Path(__file__).with_name("peer_runs.py")
    out = folder / f"{peer}.npz"
    command = [python, script, peer, folder / "chain.urdf", folder / "path.npz", out]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT)
    except subprocess.TimeoutExpired:
        return f"more than {TIMEOUT} s"
    if done.returncode:
        return "fails: " + (done.stderr.strip().splitlines() or ["no word"])[-1][:100]
    found = np.load(out)
    return found["q"], float(found["seconds"]), str(found["version"])


def turned(cell, q: np.ndarray) -> np.ndarray:
    """Postures with revolute joints followed over whole turns, which some peers take back to half a turn."""
    revolute = ~np.array([joint.prismatic for joint in cell.joints])
    out = q.copy()
    out[:, revolute] = np.unwrap(q[:, revolute], axis=0)
    return out


def rows_of(arguments) -> list[tuple[str, str, float, dict[str, float]] | tuple[str, str]]:
    """A row a solver: name, version, microseconds a point, quality; or name and reason."""
    cell, chain, targets, settings = setting(arguments.points)
    limits = bounds(cell, targets)
    start = run(cell, chain, settings, targets[:1], np.full((1, len(cell)), np.inf), cell.q_home)[0][0]
    found = [run(cell, chain, settings, targets, limits, start) for _ in range(5)]
    q, inv_kf, _ = found[0]
    seconds = min(f[2] for f in found)
    told = quality(cell, targets, q, inv_kf)
    rows = [("camrob, published method", version("numba"), 1e6 * seconds / len(q), told)]
    two = _on_two_threads(lambda: run(cell, chain, settings, targets, limits, start))
    rows.append(("camrob, two paths on two threads, wall time", version("numba"), 1e6 * two / (2 * len(q)), told))
    rows += [_planned(arguments.points, mode) for mode in ("knee", "flowing")]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "chain.urdf").write_text(cell_urdf(cell))
        np.savez(folder / "path.npz", start=start, targets=targets)
        for peer in [p for p in PACKAGES if p not in (*CLOSED_FORMS, *FEEDS)]:
            python = python_of(peer, arguments.cache, arguments.install)
            told = python if isinstance(python, str) else measure(peer, python, folder)
            if isinstance(told, str):
                rows.append((peer, told))
                continue
            q = turned(cell, told[0])
            inv_kf = inverse_kf_many(chain, np.ascontiguousarray(q))
            rows.append((peer, told[2], 1e6 * told[1] / len(q), quality(cell, targets[: len(q)], q, inv_kf)))
    return rows


def _on_two_threads(work) -> float:
    """Least wall time, s, of doing `work` twice at once."""
    least = np.inf
    with ThreadPoolExecutor(2) as pool:
        for _ in range(5):
            begin = perf_counter()
            for done in [pool.submit(work), pool.submit(work)]:
                done.result()
            least = min(least, perf_counter() - begin)
    return least


def _planned(points: int, mode: str):
    """A row for the planned method on the same spiral, which it meets with a roll of its own choice."""
    with tempfile.TemporaryDirectory() as name:
        file = Path(name) / "spiral.cls"
        write_cl_file(file, points)
        inputs = read_inputs(file, cell_for("post", ROOT / "cells" / "kr15_track_table"), None)
    cell, path = inputs.cell, inputs.path
    begin = process_time()
    solution = resolve_planned(cell, path, mode=mode)
    seconds = process_time() - begin
    path = path if solution.path is None else solution.path
    q = np.asarray(solution.q)
    told = quality(cell, base_T_tool(cell, q), q, np.asarray(solution.inv_kf))
    position, axis = solution.residual(cell, path)
    told |= {"error mm": 1e3 * position.max(), "error deg": np.degrees(axis.max())}
    return f"camrob, planned ({mode})", version("numba"), 1e6 * seconds / len(q), told


def table(rows, points: int) -> str:
    """Markdown."""
    lines = [
        f"{points} points of a spiral on a dome in steps of 0.5 mm, nine joints; {platform.processor() or platform.machine()},"
        f" one core of {os.cpu_count()}, load {os.getloadavg()[0]:.1f}, Python {platform.python_version()}",
        "",
        "| solver | version | " + " | ".join(COLUMNS) + " | us a point |",
        "|---" * (len(COLUMNS) + 3) + "|",
    ]
    for row in rows:
        if len(row) == 2:
            lines.append(f"| {row[0]} | {row[1]} |" + " |" * (len(COLUMNS) + 1))
        else:
            values = " | ".join(f"{row[3][c]:.3g}" for c in COLUMNS)
            lines.append(f"| {row[0]} | {row[1]} | {values} | {row[2]:.1f} |")
    return "\n".join(lines) + "\n"


def parts_of(arguments) -> str:
    """The arm's closed form and the feed beside other people's: two tables."""
    cell, chain, targets, settings = setting(arguments.points)
    free = np.full((1, len(cell)), np.inf)
    start = run(cell, chain, settings, targets[:1], free, cell.q_home)[0][0]
    q = run(cell, chain, settings, targets, bounds(cell, targets), start)[0]
    every = max(1, len(q) // AT_MOST)
    pythons = {p: python_of(p, arguments.cache, arguments.install) for p in (*CLOSED_FORMS, *FEEDS)}
    with tempfile.TemporaryDirectory() as name:
        closed = closed_form_table(cell, q[::every], {p: pythons[p] for p in CLOSED_FORMS}, Path(name))
        return closed + "\n" + feed_table(pythons[FEEDS[0]], Path(name))


def plot(rows, file: Path) -> None:
    """Time against the worst conditioning."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(8, 5))
    high = low = 0
    for row in sorted((row for row in rows if len(row) == 4), key=lambda row: row[2]):
        x, y = row[2], row[3]["1/k_F min"]
        axes.plot(x, y, "o")
        if y > 0.1:  # neighbours in time don't cover each other's names
            above, high = (-12, 4, 4, -12, 4, -12)[high % 6], high + 1
        else:  # and at the bottom not the next but one either
            above, low = (4, -12, 15)[low % 3], low + 1
        side, at = ("left", 6) if x < 3e3 else ("right", -6)
        axes.annotate(row[0], (x, y), xytext=(at, above), textcoords="offset points", fontsize=8, ha=side)
    axes.set(xscale="log", xlabel="microseconds a point", ylabel="worst 1/k_F", xlim=(0.4, 3e4), ylim=(-0.03, 0.65))
    axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(file, dpi=130)


def drawn_before(page: Path) -> list[tuple[str, str, float, dict[str, float]]]:
    """Rows of the table of solvers that stands in a page: what a figure is drawn of again without measuring."""
    lines = iter(page.read_text(encoding="utf-8").splitlines())
    head = next([c.strip() for c in line.split("|")[1:-1]] for line in lines if line.startswith("| solver |"))
    next(lines)
    rows = []
    for line in lines:
        cells = [c.strip() for c in line.split("|")[1:-1]]
        if len(cells) != len(head):
            return rows
        told = dict(zip(head, cells, strict=True))
        time = float(told["microseconds a point"].replace(" ", ""))
        name = re.split(r" (?=\d|with|\(its|first)|, (?=a pose|first)", told["solver"])[0]
        rows.append((name, "", time, {"1/k_F min": float(told["worst 1/k_F"])}))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description="the tracker beside other solvers")
    parser.add_argument("--install", action="store_true")
    parser.add_argument("--parts", action="store_true", help="closed forms and feed alone")
    parser.add_argument("--redraw", type=Path, help="draw peers.png of the table in this page, and measure nothing")
    parser.add_argument("--points", type=int, default=10_000)
    parser.add_argument("--out", type=Path, default=Path("out"))
    parser.add_argument("--cache", type=Path, default=Path.home() / ".cache" / "camrob-peers")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    if arguments.redraw:
        plot(drawn_before(arguments.redraw), arguments.out / "peers.png")
        return
    text = ""
    if not arguments.parts:
        rows = rows_of(arguments)
        text = table(rows, arguments.points) + "\n"
        plot(rows, arguments.out / "peers.png")
    text += parts_of(arguments)
    (arguments.out / "peers.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
