"""What correction takes off the path of cells that other code made: `python tests/bench/bench_loop.py --out DIR [--cells N]`.

Each cell has two to five effects of `gap.draws`, in half of them beside a smooth discrepancy of 1 to 10 times the noise
(`gap.field`); nothing of it comes from camrob. The engraving is run, its log diagnosed, what was found taken off, and it is run
again: how far the true tool (without the noise) is off the intended path as posted, with the constants corrected, with
all that was found, and on a cell that has the discrepancy alone, which nobody can take off. `--table` writes loop_table.md.
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

sys.path.insert(0, str(Path(__file__).resolve().parent))

import closed_loop
from gap import generator
from gap.draws import draw
from gap.field import draw_field
from row_file import add_rows, read_rows

from camrob.cell.read_cell import read_cell
from camrob.controller.simulate import simulate
from camrob.errors import JobError
from camrob.jobs.compensate import compensate
from camrob.jobs.diagnose import diagnose
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.measurement.write_log import write_log

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "toolpaths" / "engraving" / "golden" / "engraving.src"
EFFECTS = (
    "frame_tool",
    "joint_offset",
    "geometry",
    "track",
    "lean",
    "joint_compliance",
    "backlash",
    "servo_lag",
    "friction",
    "gear_ripple",
    "wrist_coupling",
)
FAMILIES = ("effects", "effects and field")
NOISE = closed_loop.SIGMA_MM * np.sqrt(3.0)  # mm, 3-D
Apply = Callable[[generator.World], None]


def cell_of(family: str, number: int, program: Path) -> tuple[list[str], float, Apply, Apply]:
    """The names of a cell's effects, the size of its field (mm), and what makes it: all, and the field alone."""
    rng = np.random.default_rng([7_000_000, FAMILIES.index(family), number])
    ran = simulate(read_krl(program), read_cell(closed_loop.CELL), cycle=generator.STEP).log
    world = told(generator.World(np.asarray(ran.t), ran.setpoints(generator.AXES) / closed_loop.EDGE))
    names = [str(n) for n in rng.choice(EFFECTS, rng.integers(2, 6), replace=False)]
    drawn = [(draw(name, rng, world)[1], rng.uniform(0.5, 1.5)) for name in names]
    size = 0.0 if family == "effects" else float(NOISE * np.exp(rng.uniform(0.0, np.log(10.0))))
    field: Apply = draw_field(number, world, size * 1e-3) if size else (lambda w: None)

    def whole(w: generator.World) -> None:
        told(w)
        for apply, s in drawn:
            apply(w, s)
        field(w)

    return names, size, whole, field


def told(world: generator.World) -> generator.World:
    """The world with what the effects follow along its path."""
    coarse, t = world.command[::25], world.t
    spread = {"torque": generator.torques(coarse), "moment": generator.moment(coarse)}
    spread["tcp"] = generator.pose(coarse)[:, :3, 3]
    world.context = {name: np.stack([np.interp(t, t[::25], c) for c in values.T], 1) for name, values in spread.items()}
    return world


def one(family: str, number: int, out: Path) -> dict[str, Any]:
    """A cell's row."""
    out.mkdir(parents=True, exist_ok=True)
    program = out / PROGRAM.name
    program.write_bytes(PROGRAM.read_bytes())
    dat = PROGRAM.with_suffix(".dat")
    if dat.is_file():
        (out / dat.name).write_bytes(dat.read_bytes())
    names, size, whole, field = cell_of(family, number, program)
    log = closed_loop.run_on_cell(program, whole, number)
    write_log(log, out / "run.csv")
    fitted: Path | None = out / "fitted.toml"
    with suppress(JobError):
        diagnose(cell=closed_loop.CELL, log=[out / "run.csv"], out=out / "diagnosis", calibration=fitted)
    said = json.loads((out / "diagnosis" / "diagnosis.json").read_text())
    fitted = fitted if fitted is not None and fitted.is_file() else None
    claimed = [e["effect"] for e in said["effects"] if e["probability"] >= 0.5]
    row: dict[str, Any] = {"family": family, "draw": number, "effects": names, "field_mm": size, "claimed": claimed}

    def off(run: Path, apply: Apply, added: tuple[int, ...] = ()) -> list[float]:
        exact = closed_loop.run_on_cell(run, apply, number, sigma_mm=0.0)
        size = closed_loop.off_path(exact, program, added=(*closed_loop.lines_of_head(run), *added))
        return [float(np.sqrt(np.mean(size**2))), float(np.quantile(size, 0.95)), float(size.max())]

    row |= {"posted": off(program, whole), "field": off(program, field)}
    row["constants"] = row["both"] = row["posted"]
    if fitted is not None:
        compensate(program, cell=closed_loop.CELL, calibration=fitted, out=out / "constants")
        row["constants"] = off(out / "constants" / program.name, whole)
    if claimed:
        summary = compensate(
            program, cell=closed_loop.CELL, calibration=fitted, diagnosis=out / "diagnosis", out=out / "both"
        ).summary
        assert summary.machine is not None
        added = summary.machine.targets_added.get(program.name, ())
        row["both"] = off(out / "both" / program.name, whole, added)
        row |= {
            "foretold_rms": summary.machine.after.rms_mm,
            "beyond": list(summary.machine.causes),
            "added": len(added),
        }
    return row


def removed(row: dict[str, Any], way: str) -> float:
    """The share of the 95 % error that could be removed (all but the field's own) which `way` removes."""
    return (row["posted"][1] - row[way][1]) / max(row["posted"][1] - row["field"][1], 1e-9)


def table(rows: list[dict[str, Any]]) -> str:
    """The figures for people."""
    lines = [
        "# What correction takes off the path",
        "",
        "`python tests/bench/bench_loop.py --out DIR --cells N`, then `--table`. 95 % of the tool's distances from the path,",
        "mm; removed: of what could be (without the field's own part).",
        "",
        "| cell | effects | field mm | claimed | posted | constants | all that was found | field alone | removed |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for r in sorted(rows, key=lambda r: (r["family"], r["draw"])):
        sizes = " | ".join(f"{r[k][1]:.3f}" for k in ("posted", "constants", "both", "field"))
        lines.append(
            f"| {r['family']} {r['draw']} | {', '.join(r['effects'])} | {r['field_mm']:.3f} | {', '.join(r['claimed'])} "
            f"| {sizes} | {100 * removed(r, 'both'):.0f} % |"
        )
    lines.append("")
    for family in FAMILIES:
        own = [r for r in rows if r["family"] == family]
        if own:
            medians = {way: float(np.median([removed(r, way) for r in own])) for way in ("constants", "both")}
            worse = [r for r in own if r["both"][1] > r["posted"][1]]
            lines.append(
                f"- {family}, {len(own)} cells: removed in the median {100 * medians['constants']:.0f} % by constants, "
                f"{100 * medians['both']:.0f} % by all that was found; worse than posted in {len(worse)}."
            )
    return "\n".join(lines) + "\n"


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--cells", type=int, default=6, help="draws of each family")
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    if options.table:
        (Path(__file__).resolve().parent / "loop_table.md").write_text(table(read_rows(options.out / "loop.jsonl")))
        return
    add_rows(options.out / "loop.jsonl", FAMILIES, options.cells, one)


if __name__ == "__main__":
    main()
