"""What do plans for accuracy gain? `python tests/bench/bench_accuracy.py --out DIR [--cells N] [--table]`; `--trial` for 24
poses.

Simulated cells whose errors come from `gap.generator`, which shares no code with camrob: all six joints yield to gravity and to
the force of the cut, axes have play, drives have friction. The cell is diagnosed on one noisy run of the engraving in air. A
drawn raster (place, direction, size by rule) is then posted twice with planned postures at the same feed, by conditioning, and
for accuracy with that diagnosis and a force that is off by what is drawn; both are compensated with the constants that were
found. The cell runs all four, without noise: by how much the tip is off the programmed path across the feed, over what is cut.
Writes accuracy.jsonl, which a second run goes on from; --table writes accuracy_table.md beside this file.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parent))

from closed_loop import CELL, DEG, EDGE, ROOT, run_on_cell
from gap import generator
from row_file import add_rows, read_rows

from camrob import post
from camrob.cell.read_cell import read_cell
from camrob.controller.simulate import simulate
from camrob.errors import JobError
from camrob.jobs.compensate import compensate
from camrob.jobs.diagnose import diagnose
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.measurement.write_log import write_log
from camrob.redundancy.planning.certificate import external_grid
from camrob.redundancy.planning.freedoms import conditioning, plan_space, plan_work
from camrob.redundancy.planning.layers import candidate_nodes
from camrob.redundancy.planning.objective import Objective, plan_weights

Array = NDArray[np.float64]
World = Any
PROGRAM = ROOT / "toolpaths" / "engraving" / "golden" / "engraving.src"
STATED = np.array([-60.0, 30.0, 20.0])  # N along the feed, across it, along the tool
LINES, POINTS, FEED = 7, 9, 1500.0
COARSE = 25  # rows of 4 ms from one Jacobian to the next
Effect = Callable[[World, np.random.Generator], None]


def wide(world: World, few: Array) -> Array:
    """Values at every COARSEth row, drawn out to all."""
    flat = few.reshape(len(few), -1)
    full = np.stack([np.interp(world.t, world.t[::COARSE], c) for c in flat.T], 1)
    return full.reshape(len(world.t), *few.shape[1:])


def yields(world: World, rng: np.random.Generator) -> None:
    """All joints yield, the wrist's more, to gravity and to the force, which is not quite the stated one."""
    c = np.concatenate([rng.uniform(1e-6, 4e-6, 3), rng.uniform(4e-6, 12e-6, 3)])
    factor = rng.uniform(0.7, 1.3)
    few = world.command[::COARSE]
    world.link[:, :6] += c * wide(world, generator.torques(few))
    if not world.context["cuts"].any():
        return
    J = wide(world, generator.jacobian(few)[:, :3])
    world.link[:, :6] += c * np.einsum("nij,ni->nj", J, factor * world.context["force"])


def play(world: World, rng: np.random.Generator) -> None:
    """Play of A1 and of one axis more, 0.01 to 0.04 degrees."""
    for k in {0, int(rng.integers(1, 6))}:
        world.link[:, k] += generator.play(world.command[:, k], rng.uniform(0.01, 0.04) * DEG)


def friction(world: World, rng: np.random.Generator) -> None:
    """Drives of A1 to A3 stay behind on the side they come from, and more so for a while after they turn round."""
    for k in range(3):
        rate = np.gradient(world.command[:, k], world.t)
        side = np.tanh(rate / (0.02 * DEG))
        slow = np.empty_like(side)
        slow[0] = side[0]
        for i in range(1, len(side)):
            slow[i] = slow[i - 1] + (side[i] - slow[i - 1]) * (1.0 - np.exp(-(world.t[i] - world.t[i - 1]) / 0.15))
        world.drive[:, k] -= rng.uniform(0.004, 0.012) * DEG * side + rng.uniform(0.004, 0.012) * DEG * (side - slow)


FAMILIES: dict[str, tuple[Effect, ...]] = {
    "force": (yields,),
    "play": (play,),
    "friction": (friction,),
    "force and play": (yields, play),
}


def effects(family: str, draw: int) -> Callable[[World], None]:
    """What is wrong with a cell."""

    def apply(world: World) -> None:
        world.context.setdefault("cuts", np.zeros(len(world.t), bool))
        for k, effect in enumerate(FAMILIES[family]):
            effect(world, np.random.default_rng([draw, k, *family.encode()]))

    return apply


def raster_file(folder: Path, draw: int) -> Path:
    """A flat raster somewhere on the table, in a drawn direction."""
    rng = np.random.default_rng([draw, 77])
    angle, width, step = rng.uniform(0, np.pi), rng.uniform(100, 180), rng.uniform(8, 14)
    x0, y0, z0 = rng.uniform(-120, 120), rng.uniform(-120, 120), rng.uniform(100, 300)
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    lines = [
        "TOOL PATH/RASTER,TOOL,BALL_6",
        "TLDATA/MILL,6.0,3.0,75.0,0.0,0.0",
        "MSYS/0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0",
    ]

    def goto(a: float, b: float, z: float) -> str:
        x, y = np.array([x0, y0]) + a * along + b * across
        return f"GOTO/{x:.4f},{y:.4f},{z:.4f},0.0,0.0,1.0"

    s = np.linspace(-0.5 * width, 0.5 * width, POINTS)
    rows = [(s if k % 2 == 0 else -s, (k - 0.5 * (LINES - 1)) * step) for k in range(LINES)]
    lines += ["RAPID", goto(rows[0][0][0], rows[0][1], z0 + 40), f"FEDRAT/MMPM,{FEED}"]
    lines += [goto(a, b, z0) for values, b in rows for a in values]
    lines += ["RAPID", goto(rows[-1][0][-1], rows[-1][1], z0 + 40), "END-OF-PATH"]
    file = folder / "raster.cls"
    file.write_text("\n".join(lines) + "\n")
    (folder / "setup.toml").write_text("part_in_base = [0, 0, 0, 0, 0, 0]\nspindle_rpm = 10000\n")
    return file


def in_base(poses: Array, table: Array) -> Array:
    """Poses (N, 4, 4) of `world` seen from the table at angles (N,), by numpy alone."""
    turned = np.tile(np.eye(4), (len(poses), 1, 1))
    turned[:, 0, 0] = turned[:, 1, 1] = np.cos(table)
    turned[:, 1, 0] = np.sin(table)
    turned[:, 0, 1] = -turned[:, 1, 0]
    return turned @ poses


def errors_on_cell(program: Path, apply: Callable[[World], None], asked: Array | None = None) -> tuple[Array, Array]:
    """(N,) m off the asked path across the feed where the program cuts, and that path (M, 3) itself in `base`: a program's own,
    if none is given.
    """
    ran = simulate(read_krl(program), read_cell(CELL), cycle=generator.STEP).log
    t, command = np.asarray(ran.t), ran.setpoints(generator.AXES) / EDGE
    plain = in_base(generator.pose(command), command[:, 7])
    tip = plain[:, :3, 3]
    rate = np.gradient(tip, t, axis=0)
    speed = np.linalg.norm(rate, axis=1)
    # a flat raster: what is cut lies lowest, and ways down to it are none of it
    cuts = (tip[:, 2] < tip[:, 2].min() + 3e-3) & (speed > 1e-4) & (np.abs(rate[:, 2]) < 0.1 * speed)
    way = np.where(cuts[:, None], rate / np.maximum(speed, 1e-9)[:, None], 0.0)
    left = np.cross([0.0, 0.0, 1.0], way)
    pushed = STATED[0] * way + STATED[1] * left + STATED[2] * np.array([0.0, 0.0, 1.0]) * cuts[:, None]
    back = np.tile(np.eye(3), (len(t), 1, 1))
    c, s = np.cos(command[:, 7]), np.sin(command[:, 7])
    back[:, 0, 0] = back[:, 1, 1] = c
    back[:, 0, 1], back[:, 1, 0] = s, -s
    world = generator.World(t, command)
    world.context = {"force": np.einsum("nij,nj->ni", back, pushed), "cuts": cuts}
    apply(world)
    _, encoder, world_T_tool = generator.show(world, t)
    true = in_base(world_T_tool, encoder[:, 7])[cuts, :3, 3]
    path = tip[cuts] if asked is None else asked
    # the nearest place of the asked path, between its rows, is what lies across its feed
    off = np.empty(len(true))
    for begin in range(0, len(true), 500):
        some = true[begin : begin + 500]
        near = np.argmin(np.linalg.norm(some[:, None] - path[None], axis=2), axis=1)
        near = np.clip(near, 1, len(path) - 2)
        d = path[near + 1] - path[near - 1]
        d /= np.maximum(np.linalg.norm(d, axis=1), 1e-12)[:, None]
        e = some - path[near]
        off[begin : begin + 500] = np.linalg.norm(e - np.sum(e * d, axis=1)[:, None] * d, axis=1)
    return off, path


def size(off: Array) -> dict[str, float]:
    """rms, 95 % and worst, mm."""
    return {
        "rms": float(np.sqrt(np.mean(off**2)) * 1e3),
        "p95": float(np.quantile(off, 0.95) * 1e3),
        "worst": float(off.max() * 1e3),
    }


def one(family: str, draw: int, out: Path) -> dict[str, Any]:
    """One cell, one raster."""
    out.mkdir(parents=True, exist_ok=True)
    apply = effects(family, draw)
    write_log(run_on_cell(PROGRAM, apply, draw), out / "run.csv")
    fitted = out / "fitted.toml"
    with suppress(JobError):  # no constant was found
        diagnose(cell=CELL, log=[out / "run.csv"], program=PROGRAM, out=out / "diagnosis", calibration=fitted)
    said = json.loads((out / "diagnosis" / "diagnosis.json").read_text())
    constants = fitted if fitted.is_file() else None
    force = None
    if yields in FAMILIES[family]:
        force = out / "FORCE.toml"
        names = ("along", "across", "axial")
        force.write_text("[mean]\n" + "".join(f"{n}_n = {v}\n" for n, v in zip(names, STATED, strict=True)))
    part = raster_file(out, draw)
    post(part, cell=CELL, out=out / "plain", method="planned", report=False)
    made = post(
        part,
        cell=CELL,
        out=out / "accurate",
        method="planned",
        report=False,
        for_accuracy=True,
        calibration=constants,
        diagnosis=out / "diagnosis",
        force=force,
    )
    claimed = [e["effect"] for e in said["effects"] if e["probability"] >= 0.5]
    row: dict[str, Any] = {"family": family, "draw": draw, "claimed": list(dict.fromkeys(claimed))}
    plan = made.summary.plan
    if plan is not None and plan.accuracy is not None:
        row["expected"] = {"plain": plan.accuracy.conditioning.rms_mm, "accurate": plan.accuracy.accuracy.rms_mm}
        row["taken"] = plan.accuracy.taken
    for name in ("plain", "accurate"):
        program = out / name / "raster.src"
        off, asked = errors_on_cell(program, apply)
        row[name] = size(off)
        if constants is not None:
            compensate(program, cell=CELL, calibration=constants, out=out / f"{name}_compensated")
            row[f"{name}_compensated"] = size(
                errors_on_cell(out / f"{name}_compensated" / "raster.src", apply, asked)[0]
            )
    return row


def trial(count: int = 24) -> list[str]:
    """At `count` poses over the table: um/N along and across the tool, in the best-conditioned of all scanned postures, the
    stiffest along the tool, and the middling one; compliances of 1.2 to 10 x 10^-6 rad/Nm, J C J^T in numpy from the other
    code's Jacobian.
    """
    cell = read_cell(CELL)
    space = plan_space(cell)
    objective = Objective.of(cell, space, plan_weights(cell))
    rng = np.random.default_rng(17)
    c = np.array([1.2, 1.5, 2.0, 5.0, 8.0, 10.0]) * 1e-6
    rows = []
    for _ in range(count):
        frame = np.eye(4)
        frame[:3, 3] = *rng.uniform(-0.2, 0.2, 2), rng.uniform(0.05, 0.35)
        tilt = rng.uniform(-0.5, 0.5, 2)
        frame[:3, :3] = generator.turn(np.array([*tilt, 0.0]))
        nodes = candidate_nodes(space, objective, frame[None], [external_grid(space)])
        work = plan_work()
        value = np.array([conditioning(space, q, work) for q in nodes.q])
        axis = np.zeros((len(value), 8))
        whole = np.zeros((len(value), len(cell)))
        whole[:, space.free], whole[:, cell.arm_slice] = nodes.u, nodes.q
        told = cell.to_axis_values(whole)
        axis[:] = told[:, [cell.axis_names.index(a) for a in generator.AXES]] / EDGE
        J = generator.jacobian(axis)[:, :3]
        C = np.einsum("nij,j,nkj->nik", J, c, J)
        z = generator.pose(axis)[:, :3, 2]
        along = np.einsum("ni,nij,nj->n", z, C, z) * 1e6
        across = 0.5 * (np.trace(C, axis1=1, axis2=2) * 1e6 - along)
        picked = [int(np.argmax(value)), int(np.argmin(along)), int(np.argsort(along)[len(along) // 2])]
        rows.append([(along[k], across[k], value[k]) for k in picked])
    mean = np.mean(np.array(rows), axis=0)
    names = ("best-conditioned", "stiffest along the tool", "middling along the tool")
    return [f"| {n} | {a:.2f} | {b:.2f} | {v:.2f} |" for n, (a, b, v) in zip(names, mean.tolist(), strict=True)]


def table(rows: list[dict[str, Any]], trial_rows: list[str]) -> str:
    """The figures for people."""
    ways = ("plain", "accurate", "plain_compensated", "accurate_compensated")
    lines = [
        "# Plans for accuracy, on cells that are wrong",
        "",
        "`python tests/bench/bench_accuracy.py --out DIR`, then `--table`. How far the tip is off the programmed path across the",
        "feed, mm: rms / 95 % / worst, over what is cut, at equal feed. Cells are diagnosed on another program's run in air.",
        "",
        "| family, draw | found | plan by conditioning | plan for accuracy | compensated | both | less rms | predicted |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    gains: dict[str, list[float]] = {}
    for r in sorted(rows, key=lambda r: (r["family"], r["draw"])):
        cells = [" / ".join(f"{r[w][k]:.3f}" for k in ("rms", "p95", "worst")) if w in r else "-" for w in ways]
        gain = 100.0 * (1.0 - r["accurate"]["rms"] / r["plain"]["rms"])
        gains.setdefault(r["family"], []).append(gain)
        told = r.get("expected")
        expected = f"{100.0 * (1.0 - told['accurate'] / told['plain']):.0f} %" if told and told["plain"] > 0 else "-"
        if not r.get("taken", True):
            expected = "nothing; not taken"
        name, found = f"{r['family']} {r['draw']}", ", ".join(r["claimed"])
        lines.append(f"| {name} | {found} | {' | '.join(cells)} | {gain:.0f} % | {expected} |")
    every = [g for some in gains.values() for g in some]
    medians = [f"{name}: {np.median(some):.0f} % ({len(some)})" for name, some in gains.items()]
    lines += ["", f"Less rms in the median: {np.median(every):.0f} % of {len(every)} cells; {'; '.join(medians)}."]
    lines += [
        "",
        "## The first trial",
        "",
        "`python tests/bench/bench_accuracy.py --trial`: means over 24 poses, micrometres per newton; compliances of 1.2 to",
        "10 x 10^-6 rad/Nm.",
        "",
        "| posture | along the tool | across it | 1/k_F |",
        "| --- | --- | --- | --- |",
        *trial_rows,
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--cells", type=int, default=2, help="draws of each family")
    parser.add_argument("--only", nargs="*", default=list(FAMILIES))
    parser.add_argument("--table", action="store_true")
    parser.add_argument("--trial", action="store_true")
    options = parser.parse_args()
    if options.trial:
        print("\n".join(trial()))
        return
    options.out.mkdir(parents=True, exist_ok=True)
    file = options.out / "accuracy.jsonl"
    if options.table:
        (Path(__file__).resolve().parent / "accuracy_table.md").write_text(table(read_rows(file), trial()))
        return
    add_rows(file, options.only, options.cells, one)


if __name__ == "__main__":
    main()
