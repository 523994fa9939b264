"""Does the part come out as predicted? `python tests/bench/bench_predict.py --out DIR [--cells N] [--first N] [--table]`.

The engraving runs on simulated cells whose errors come from `gap.generator`, which shares no code with camrob. One run is logged
with noise and diagnosed; `camrob predict` then says what the part will be like, and how sure that is; what the same cell, without
noise, does on the same program is cut from the same stock. Compared at every point of the surface: the share of points whose
deviation lies within the stated 95 % band, and the 95 % error predicted and reached. Removal itself is camrob's in both
(`tests/cutting` holds it to convex hulls and formulas); paths, errors and measurements are not.
Writes predict.jsonl, which a second run goes on from; --table writes predict_table.md beside this file.
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

from camrob.bodies.meshes import body_triangles
from camrob.cell.read_cell import read_cell
from camrob.cell.read_setup import read_setup
from camrob.controller.simulate import simulate
from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import Moves, deviation, of_mesh
from camrob.errors import JobError
from camrob.jobs.diagnose import diagnose
from camrob.jobs.predict import predict
from camrob.kinematics.frames import world_T_base
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.measurement.write_log import write_log
from camrob.se3 import inverse
from camrob.summaries.diagnosis_summary import DiagnosisSummary

Array = NDArray[np.float64]
World = Any
PROGRAM = ROOT / "toolpaths" / "engraving" / "golden" / "engraving.src"
SETUP = ROOT / "toolpaths" / "engraving" / "setup.toml"
PITCH_MM = 0.4
FARTHEST = 2e-3  # m, as `predict` has it


def compliance(world: World, rng: np.random.Generator) -> None:
    """A2 and A3 yield to gravity, 1 to 4 x 10^-6 rad/Nm."""
    torque = np.stack([np.interp(world.t, world.t[::25], c) for c in generator.torques(world.command[::25]).T], 1)
    for k in (1, 2):
        world.link[:, k] += rng.uniform(1e-6, 4e-6) * torque[:, k]


def coupling(world: World, rng: np.random.Generator) -> None:
    """A5 follows A4 by some thousandths, and axes stand off their marks."""
    world.link[:, 4] += rng.uniform(0.5e-3, 2e-3) * world.command[:, 3]
    for k in rng.choice(6, 2, replace=False):
        world.link[:, k] += rng.uniform(-0.02, 0.02) * DEG


def backlash(world: World, rng: np.random.Generator) -> None:
    """Play of A1 and of one axis more."""
    for k in {0, int(rng.integers(1, 6))}:
        world.link[:, k] += generator.play(world.command[:, k], rng.uniform(0.006, 0.02) * DEG)


def lag(world: World, rng: np.random.Generator) -> None:
    """The drives are late by 8 to 20 ms, seen in the encoders."""
    for k in range(6):
        late = rng.uniform(0.008, 0.020)
        world.drive[:, k] += np.interp(world.t - late, world.t, world.command[:, k]) - world.command[:, k]


def field(world: World, rng: np.random.Generator) -> None:
    """What no library has: a smooth field over posture of 0.06 to 0.15 mm beside compliance."""
    compliance(world, rng)
    phase = world.command[:, :7] @ rng.normal(0.0, 2.0, (7, 3)) + rng.uniform(0, 2 * np.pi, 3)
    world.after += rng.uniform(0.06e-3, 0.15e-3) * np.sin(phase)


FAMILIES: dict[str, Callable[[World, np.random.Generator], None]] = {
    "compliance": compliance,
    "coupling": coupling,
    "play": backlash,
    "lag": lag,
    "field": field,
}


def truth(apply: Callable[[World], None], t: Array, command: Array) -> Array:
    """(N, 4, 4) tool in `base`, as the cell truly goes."""
    cell = read_cell(CELL)
    world = generator.World(t, command)
    apply(world)
    _, encoder, world_T_tool = generator.show(world, t)
    # the table stands where its encoder says
    return inverse(world_T_base(cell, cell.to_q(encoder * EDGE))) @ world_T_tool


def one(family: str, draw: int, out: Path) -> dict[str, Any]:
    """One cell: run, diagnosed, predicted, cut."""

    def apply(world: World) -> None:
        FAMILIES[family](world, np.random.default_rng([draw, *family.encode()]))

    out.mkdir(parents=True, exist_ok=True)
    log = run_on_cell(PROGRAM, apply, draw)
    write_log(log, out / "run.csv")
    fitted = out / "fitted.toml"
    row: dict[str, Any] = {"family": family, "draw": draw}
    with suppress(JobError):  # no constant was found: the diagnosis alone says what is wrong
        diagnose(cell=CELL, log=[out / "run.csv"], program=PROGRAM, out=out / "diagnosis", calibration=fitted)
    said = DiagnosisSummary.from_json(json.loads((out / "diagnosis" / "diagnosis.json").read_text()))
    row |= {"status": said.status, "claimed": [e.effect for e in said.claimed]}
    constants = fitted if fitted.is_file() else None
    given: dict[str, Any] = {"calibration": constants, "diagnosis": out / "diagnosis", "setup": SETUP}
    made = predict(PROGRAM, cell=CELL, out=out / "part", pitch_mm=PITCH_MM, **given)

    ran = simulate(read_krl(PROGRAM), read_cell(CELL), cycle=generator.STEP).log
    t = np.asarray(ran.t)
    held = read_setup(SETUP, read_cell(CELL))
    tool, part_T_base = held.tool(), inverse(np.asarray(held.base_T_part))
    cutter = Cutter(0.5 * tool.diameter, tool.corner, tool.length)

    def moves(base_T_tool: Array) -> Moves:
        part_T_tool = part_T_base @ base_T_tool
        return Moves.along(part_T_tool[:, :3, 3], part_T_tool[:, :3, 2], cutter)

    true = truth(apply, t, ran.setpoints(generator.AXES) / EDGE)
    stock = of_mesh(body_triangles(held.stock), PITCH_MM * 1e-3)
    meant_left, true_left, predicted_left = stock.copy(), stock.copy(), stock.copy()
    meant, real, foreseen = moves(made.path.ideal), moves(true), moves(made.path.true)
    for left, way in ((meant_left, meant), (true_left, real), (predicted_left, foreseen)):
        left.carve(way)
    surface = meant_left.surface(meant)
    reached = deviation(surface, real, true_left, farthest=FARTHEST)
    told = deviation(surface, foreseen, predicted_left, farthest=FARTHEST)
    # the same points, in the same order, as the prediction has kept: those that met a wall in both of its cuts
    key = {tuple(p): k for k, p in enumerate(np.round(made.surface.point * 1e9).astype(np.int64).tolist())}
    at = np.array([key.get(tuple(p), -1) for p in np.round(surface.point * 1e9).astype(np.int64).tolist()])
    both = np.isfinite(reached) & np.isfinite(told) & (at >= 0)
    off = (reached - told)[both] * 1e3
    band = made.surface.band[at[both]] * 1e3
    size = [float(np.quantile(np.abs(x[both]), 0.95) * 1e3) for x in (reached, told)]
    return row | {
        "points": int(both.sum()),
        "within": float(np.mean(np.abs(off) <= band)),
        "band_mm": float(np.median(band)),
        "off_rms_mm": float(np.sqrt(np.mean(off**2))),
        "off_p95_mm": float(np.quantile(np.abs(off), 0.95)),
        "reached_p95_mm": size[0],
        "predicted_p95_mm": size[1],
    }


def table(rows: list[dict[str, Any]]) -> str:
    """The figures for people."""
    lines = [
        "# The part, predicted and cut",
        "",
        "`python tests/bench/bench_predict.py --out DIR`, then `--table`. Within: the share of the surface's points whose",
        "deviation lies in the stated 95 % band. 95 %: what 95 % of the points deviate by at most, in mm.",
        "",
        "| family, draw | claimed | points | within | band mm | prediction off, rms mm | 95 % predicted | 95 % reached |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for r in sorted(rows, key=lambda r: (r["family"], r["draw"])):
        name = f"{r['family']} {r['draw']}"
        lines.append(
            f"| {name} | {', '.join(r['claimed'])} | {r['points']} | {100 * r['within']:.0f} % | {r['band_mm']:.3f} "
            f"| {r['off_rms_mm']:.3f} | {r['predicted_p95_mm']:.3f} | {r['reached_p95_mm']:.3f} |"
        )
    return "\n".join(lines) + "\n"


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--cells", type=int, default=3, help="draws of each family")
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--only", nargs="*", default=list(FAMILIES))
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    file = options.out / "predict.jsonl"
    if options.table:
        (Path(__file__).resolve().parent / "predict_table.md").write_text(table(read_rows(file)))
        return
    add_rows(file, options.only, options.cells, one, options.first)


if __name__ == "__main__":
    main()
