"""The loop closed on a simulated cell: `python tests/bench/closed_loop.py [PROGRAM.src[.gz]] --out DIR`.

A program is run by the virtual controller; what a cell with true effects would make of its set-points comes from
`gap.generator`, which shares no code with camrob. The log is diagnosed, what can be corrected is handed to `compensate`,
and the compensated program is run on the same cell: deviation from the programmed path before, predicted, reached.
Writes loop.json and loop.md.
"""

from __future__ import annotations

import argparse
import gzip
import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

from gap import generator

from camrob.calibration.calibration_file import read_calibration
from camrob.cell.read_cell import read_cell
from camrob.controller.simulate import simulate
from camrob.gap.observation.program_track import track_of
from camrob.gap.observation.scene import make_scene
from camrob.jobs.compensate import compensate
from camrob.jobs.diagnose import diagnose
from camrob.kinematics.frames import world_T_base
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo
from camrob.measurement.write_log import write_log

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"
PROGRAM = ROOT / "toolpaths" / "carving" / "golden" / "carving.src.gz"
DEG = np.pi / 180.0
EDGE = np.array([1 / DEG] * 6 + [1e3, 1 / DEG])
SIGMA_MM, SIGMA_DEG = 0.02, 1e-3
ROWS = slice(1250, None, 5)  # of the 4 ms grid: every 20 ms, from when all axes have moved, so that play lies on a side


def true_cell(world: generator.World) -> None:
    """What is wrong with the cell: compliance of A2, a coupling of the wrist, and play in A1, which no constant corrects."""
    torque = np.stack([np.interp(world.t, world.t[::25], c) for c in generator.torques(world.command[::25]).T], 1)
    world.link[:, 1] += 2.5e-6 * torque[:, 1]
    world.link[:, 4] += 1.2e-3 * world.command[:, 3]
    world.link[:, 0] += generator.play(world.command[:, 0], 0.012 * DEG)


def run_on_cell(
    program: Path, apply: Callable[[generator.World], None], seed: int, *, sigma_mm: float = SIGMA_MM
) -> MeasurementLog:
    """The log of a program's run on the cell; sigma_mm: the instrument's noise of position."""
    cell = read_cell(CELL)
    ran = simulate(read_krl(program), cell, cycle=generator.STEP).log
    command = ran.setpoints(generator.AXES) / EDGE
    world = generator.World(np.asarray(ran.t), command)
    apply(world)

    at = np.asarray(ran.t)[ROWS]
    setpoint, encoder, T = generator.show(world, at)
    rng = np.random.default_rng(seed)
    p = T[:, :3, 3] * 1e3 + rng.normal(0, sigma_mm, (len(at), 3))
    R = np.stack([generator.turn(w) for w in rng.normal(0, SIGMA_DEG * DEG, (len(at), 3))]) @ T[:, :3, :3]
    columns = {"t": at, "line": np.asarray(ran.line)[ROWS].astype(float)}
    columns |= {n: p[:, k] for k, n in enumerate("xyz")}
    columns |= {
        "a": np.arctan2(R[:, 1, 0], R[:, 0, 0]) / DEG,
        "b": -np.arcsin(R[:, 2, 0]) / DEG,
        "c": np.arctan2(R[:, 2, 1], R[:, 2, 2]) / DEG,
    }
    columns |= {n: encoder[:, k] * EDGE[k] for k, n in enumerate(generator.AXES)}
    columns |= {f"c{n}": setpoint[:, k] * EDGE[k] for k, n in enumerate(generator.AXES)}
    info = LogInfo(sigma_position=SIGMA_MM * 1e-3, sigma_angle=SIGMA_DEG * DEG, program=program.name)
    return MeasurementLog(columns, info)


def lines_of_head(program: Path) -> tuple[int, ...]:
    """Lines by which `compensate` says at a program's head what it is: its original lacks them. None of another program."""
    lines = program.read_text(encoding="latin-1").splitlines()
    first = next((k for k, line in enumerate(lines, 1) if "CORRECTED by camrob compensate" in line), None)
    if first is None:
        return ()
    return tuple(range(first, 1 + next(k for k, line in enumerate(lines, 1) if "The original's own head" in line)))


def off_path(
    log: MeasurementLog, program: Path, shift: np.ndarray | None = None, added: tuple[int, ...] = ()
) -> np.ndarray:
    """(N,) mm from the measured TCP (less shift (N, 3) m) to the nearest place of the programmed path, corners rounded.

    added: lines of the program that ran which this one does not have.
    """
    line = np.asarray(log.columns["line"])
    log = MeasurementLog({**log.columns, "line": line - np.searchsorted(added, line)}, log.info)
    text, cell = read_krl(program), read_cell(CELL)
    scene = make_scene(log, cell)
    track = track_of(scene, text)
    world = scene.log.position - (0.0 if shift is None else shift)
    turned = world_T_base(cell, cell.to_q(scene.log.axes(scene.axes)))
    base = np.einsum("nji,nj->ni", turned[:, :3, :3], world - turned[:, :3, 3])
    return np.linalg.norm(replace(track, base_p=base, world_p=world).offset(track.path()), axis=1) * 1e3


def close_loop(program: Path, out: Path, apply: Callable[[generator.World], None] = true_cell) -> dict:
    """Program, run, diagnose, compensate, run again."""
    out.mkdir(parents=True, exist_ok=True)
    text = gzip.decompress(program.read_bytes()) if program.suffix == ".gz" else program.read_bytes()
    program = program.with_suffix("") if program.suffix == ".gz" else program
    (out / program.name).write_bytes(text)
    first = run_on_cell(out / program.name, apply, 1)
    write_log(first, out / "run1.csv")
    file = out / "fitted.toml"
    said = diagnose(cell=CELL, log=[out / "run1.csv"], out=out / "diagnosis", calibration=file).summary
    compensate(out / program.name, cell=CELL, calibration=file, out=out / "compensated")
    second = run_on_cell(out / "compensated" / program.name, apply, 2)
    write_log(second, out / "run2.csv")
    cell = read_cell(CELL)
    model, values = read_calibration(file, cell).model(cell)
    q = cell.to_q(first.axes(cell.axis_names))
    moved = model.poses(values, q)[:, :3, 3] - model.poses(np.zeros(len(values)), q)[:, :3, 3]
    errors = {
        "before": off_path(first, out / program.name),
        "predicted": off_path(first, out / program.name, moved),
        "reached": off_path(second, out / program.name, added=lines_of_head(out / "compensated" / program.name)),
    }
    sizes = {
        name: {"rms_mm": float(np.sqrt(np.mean(e**2))), "p95_mm": float(np.quantile(e, 0.95)), "max_mm": float(e.max())}
        for name, e in errors.items()
    }
    return {
        "program": program.name,
        "samples": len(first),
        "status": said.status,
        "found": [[e.effect, list(e.axes), e.probability] for e in said.claimed],
        "handed_over": list(said.compensable.effects),
        "left": list(said.compensable.left),
        "gap": {
            "before_mm": said.together.rms_before_mm,
            "all_effects_mm": said.together.rms_after_mm,
            "compensable_mm": said.compensable.rms_after_mm,
            "noise_mm": said.gap.noise_mm,
        },
        "off_path": sizes,
    }


def table(loop: dict) -> str:
    """The figures for people."""
    found = ", ".join(f"{e} {' '.join(a)} ({100 * p:.0f} %)".replace("  ", " ") for e, a, p in loop["found"])
    lines = [
        f"# The loop closed: {loop['program']}, {loop['samples']} samples",
        "",
        f"Found: {found}. Handed to compensate: {', '.join(loop['handed_over'])}. Left: {', '.join(loop['left']) or 'nothing'}.",
        "",
        "| distance from the programmed path | rms mm | 95 % mm | worst mm |",
        "| --- | --- | --- | --- |",
    ]
    for name, e in loop["off_path"].items():
        lines.append(f"| {name} | {e['rms_mm']:.3f} | {e['p95_mm']:.3f} | {e['max_mm']:.3f} |")
    gap = loop["gap"]
    lines += [
        "",
        f"Gap at the TCP on withheld stretches: {gap['before_mm']:.3f} mm; {gap['compensable_mm']:.3f} mm without what "
        f"compensate corrects, {gap['all_effects_mm']:.3f} mm without all that was found; noise {gap['noise_mm']:.3f} mm.",
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=Path, nargs="?", default=PROGRAM)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    loop = close_loop(arguments.program, arguments.out)
    (arguments.out / "loop.json").write_text(json.dumps(loop, indent=2) + "\n")
    (arguments.out / "loop.md").write_text(table(loop))
    sys.stdout.write(table(loop))


if __name__ == "__main__":
    main()
