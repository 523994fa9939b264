"""Two parts, before and after: `python tests/bench/worked_parts.py --out DIR [--only relief carving] [--pictures]`.

The shipped programs of the relief and the carving run on a simulated cell whose errors come from `gap.generator`, which shares no
code with camrob: A2 yields to gravity, A5 follows A4, A1 has play, and a smooth field over posture that no library has moves the
tool by up to 0.1 mm. One noisy run is logged and diagnosed, the program is
compensated with what was found, and both programs run once more, without noise. From the same block each cuts its part, with
the cutter as it truly went (reached), and as the machine as diagnosed would go (predicted); deviations are from the
surface that the program as posted asks for. Removal itself is camrob's in all of them (`tests/cutting`).
Writes NAME.json and NAME.npz; --pictures draws docs/explanation/worked_NAME.png of them and prints the table.
"""

from __future__ import annotations

import argparse
import gzip
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parent))

from bench_predict import truth
from closed_loop import CELL, EDGE, ROOT, run_on_cell, true_cell
from gap import generator

from camrob.calibration.calibration_file import read_calibration
from camrob.cell.read_cell import read_cell
from camrob.cell.read_setup import read_setup
from camrob.controller.simulate import simulate
from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import CutSurface, Dexels, deviation
from camrob.jobs.closing.diagnosed_machine import DiagnosedMachine
from camrob.jobs.compensate import compensate
from camrob.jobs.diagnose import diagnose
from camrob.jobs.files.diagnosed import diagnosed
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.measurement.write_log import write_log
from camrob.prediction.surface import way_of
from camrob.program.program_text import ProgramText
from camrob.se3 import inverse
from camrob.summaries.diagnosis_summary import DiagnosisSummary

Array = NDArray[np.float64]

PARTS = {
    "relief": ((-115.0, -115.0, 0.0), (115.0, 115.0, 82.0)),
    "carving": ((-120.0, -80.0, 0.0), (120.0, 80.0, 165.0)),
}
"""mm, the corners of the blocks that they are cut from; that of the carving is its set-up's."""
SEEN = {"relief": (0, 1, 2), "carving": (0, 2, 1)}
"""Coordinates that the pictures show to the right and up, and along: down on the relief, the carving's front."""
PITCH = 0.5e-3  # m
FIELD = 0.1e-3  # m
FARTHEST = 2e-3  # m, as `predict` has it
SHOWN_MM = {"relief": 0.6, "carving": 1.0}  # where the pictures' colours end
WAYS = ("as posted", "compensated")


def apply(world: generator.World) -> None:
    """What is wrong with the cell: what can be found, and what can't."""
    true_cell(world)
    rng = np.random.default_rng(17)
    phase = world.command[:, :7] @ rng.normal(0.0, 2.0, (7, 3)) + rng.uniform(0.0, 2.0 * np.pi, 3)
    world.after += FIELD / np.sqrt(3.0) * np.sin(phase)


class Bench:
    """One part: its set-up, its block, and the cutter."""

    def __init__(self, name: str) -> None:
        lower, upper = PARTS[name]
        setup = read_setup(ROOT / "toolpaths" / name / "setup.toml", read_cell(CELL))
        tool = setup.tool()
        self.cutter = Cutter(0.5 * tool.diameter, tool.corner, tool.length)
        self.part_T_base = inverse(np.asarray(setup.base_T_part))
        self.block = Dexels(np.array(lower) * 1e-3, np.array(upper) * 1e-3, PITCH)
        self.surface: CutSurface | None = None

    def off(self, base_T_tool: Array) -> Array:
        """(P,) m that a way of the tool leaves on the surface as it was meant; the first way that is given is the one meant."""
        way, left = way_of(self.part_T_base @ base_T_tool, (self.cutter,)), self.block.copy()
        left.carve(way.moves)
        if self.surface is None:
            self.surface = left.surface(way.moves)
            return np.zeros(len(self.surface.point))
        return deviation(self.surface, way.moves, left, farthest=FARTHEST)


def truly(program: ProgramText) -> Array:
    """(N, 4, 4) the tool in `base`, as the cell goes."""
    ran = simulate(program, read_cell(CELL), cycle=generator.STEP).log
    return truth(apply, np.asarray(ran.t), ran.setpoints(generator.AXES) / EDGE)


def work(name: str, out: Path) -> None:
    """Run, diagnose, compensate, cut."""
    out.mkdir(parents=True, exist_ok=True)
    posted = out / f"{name}.src"
    posted.write_bytes(gzip.decompress((ROOT / "toolpaths" / name / "golden" / f"{name}.src.gz").read_bytes()))
    (out / f"{name}.dat").write_bytes((ROOT / "toolpaths" / name / "golden" / f"{name}.dat").read_bytes())
    write_log(run_on_cell(posted, apply, 1), out / "run.csv")
    fitted, found = out / "fitted.toml", out / "diagnosis"
    said = diagnose(cell=CELL, log=[out / "run.csv"], program=posted, out=found, calibration=fitted).summary
    compensate(posted, cell=CELL, calibration=fitted, diagnosis=found, out=out / "compensated")

    cell = read_cell(CELL)
    constants = read_calibration(fitted, cell)
    units, rest = diagnosed(found, constants, CELL, cell)
    machine = DiagnosedMachine(cell, constants, units, rest, name)
    texts = [read_krl(posted), read_krl(out / "compensated" / posted.name)]
    runs = [machine.run(text) for text in texts]
    bench = Bench(name)
    bench.off(runs[0].path.ideal)
    assert bench.surface is not None
    off: dict[str, Array] = {}
    for way, text, run in zip(WAYS, texts, runs, strict=True):
        off[f"predicted, {way}"] = bench.off(run.path.true)
        off[f"reached, {way}"] = bench.off(truly(text))
    met = np.all([np.isfinite(v) for v in off.values()], axis=0)
    sizes = {
        key: {
            "rms": float(np.sqrt(np.mean(v[met] ** 2)) * 1e3),
            "p95": float(np.quantile(np.abs(v[met]), 0.95) * 1e3),
            "worst": float(np.abs(v[met]).max() * 1e3),
        }
        for key, v in off.items()
    }
    claimed = [[e.effect, list(e.axes), e.probability] for e in said.claimed]
    (out / f"{name}.json").write_text(
        json.dumps({"points": int(met.sum()), "claimed": claimed, "mm": sizes}, indent=1) + "\n"
    )
    np.savez_compressed(out / f"{name}.npz", point=bench.surface.point[met], **{k: v[met] for k, v in off.items()})


def picture(name: str, out: Path, file: Path) -> None:
    """The part before and after, as predicted and as reached."""
    import matplotlib.pyplot as plt

    data: Any = np.load(out / f"{name}.npz")
    right, up, along = SEEN[name]
    front = -1.0 if along == 1 else 1.0
    order = np.argsort(front * data["point"][:, along])  # what is nearer is drawn later
    point = data["point"][order] * 1e3
    figure, grid = plt.subplots(2, 2, figsize=(11, 8.8 if along == 2 else 4.4), layout="constrained")
    sizes = json.loads((out / f"{name}.json").read_text())["mm"]
    for row, said in enumerate(("predicted", "reached")):
        for column, way in enumerate(WAYS):
            key, axes = f"{said}, {way}", grid[row, column]
            drawn = axes.scatter(
                point[:, right],
                point[:, up],
                c=data[key][order] * 1e3,
                s=0.6,
                marker="s",
                cmap="RdBu_r",
                vmin=-SHOWN_MM[name],
                vmax=SHOWN_MM[name],
                linewidths=0,
                rasterized=True,
            )
            axes.set_title(f"{said}, {way}: 95 % within {sizes[key]['p95']:.2f} mm", fontsize=11)
            axes.set_aspect("equal")
            axes.set_xlabel(f"{'xyz'[right]} of the part, mm")
            axes.set_ylabel(f"{'xyz'[up]}, mm")
    figure.colorbar(drawn, ax=grid, shrink=0.8, label="mm beyond the programmed surface\n(below 0: cut too deep)")
    figure.savefig(file, dpi=90)


def table(out: Path, names: list[str]) -> str:
    """The figures for people."""
    lines = ["| part | points | | rms mm | 95 % mm | worst mm |", "| --- | --- | --- | --- | --- | --- |"]
    for name in names:
        said = json.loads((out / name / f"{name}.json").read_text())
        for key, size in said["mm"].items():
            lines.append(
                f"| {name} | {said['points']} | {key} | {size['rms']:.3f} | {size['p95']:.3f} | {size['worst']:.3f} |"
            )
        found = DiagnosisSummary.from_json(json.loads((out / name / "diagnosis" / "diagnosis.json").read_text()))
        claims = ", ".join(f"{e} of {' '.join(axes)} ({100 * p:.0f} %)" for e, axes, p in said["claimed"])
        lines.append(f"| {name} | | found: {claims}; stays unexplained | {found.unexplained_mm:.3f} | | |")
    return "\n".join(lines)


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", nargs="*", default=list(PARTS))
    parser.add_argument("--pictures", action="store_true", help="draw what an earlier run has left in --out")
    options = parser.parse_args()
    for name in options.only:
        if options.pictures:
            picture(name, options.out / name, ROOT / "docs" / "explanation" / f"worked_{name}.png")
        else:
            work(name, options.out / name)
    if options.pictures:
        print(table(options.out, options.only))


if __name__ == "__main__":
    main()
