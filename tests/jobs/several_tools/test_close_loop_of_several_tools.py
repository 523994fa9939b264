"""The loop with a program that changes its tool, on a machine of other code: each stretch is measured with its own tool."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from gap_cases import closed_loop, generator
from process_story import KR15, PLACED_Z, TWO_TOOLS

from camrob import post
from camrob.cell.read_cell import read_cell
from camrob.controller.simulate import simulate
from camrob.errors import LogError
from camrob.gap.tool_stretches import tool_stretches
from camrob.jobs.close_loop import close_loop
from camrob.jobs.closing.measured_path import intended_path, measured_off_path
from camrob.jobs.closing.off_way import off_path_size
from camrob.kinematics.second_library import pinocchio_poses
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo, MeasuredFrame
from camrob.measurement.write_log import write_log
from camrob.program.motion import Motion

Array = np.ndarray
LINES = np.linspace(-30.0, 30.0, 4)
FIRST = [(60.0 * s, y) for k, y in enumerate(LINES) for s in ((-1, 1) if k % 2 else (1, -1))]
SECOND = [(y, 40.0 * s) for k, y in enumerate(LINES) for s in ((-1, 1) if k % 2 else (1, -1))]
NOISE_MM, ROWS = 0.02, slice(0, None, 10)


def raster(points: list[tuple[float, float]]) -> str:
    x, y = points[0]
    return f"G0 X{x:g} Y{y:g}\nZ8\nG1 Z2 F1500\n" + "".join(f"X{x:g} Y{y:g}\n" for x, y in points[1:]) + "G0 Z50\n"


CHANGE = "M5\nT{} M6\nS3000 M3\n"
JOB = "%\nG21 G90 G17\n{}M5\nM30\n%\n".format(
    "".join(CHANGE.format(tool) + raster(points) for tool, points in ((1, FIRST), (2, SECOND), (1, FIRST[:3])))
)


def machine(world: generator.World) -> None:
    """A zero of A3 that is off, a coupling of the wrist, and play in A1, which no constant corrects."""
    world.link[:, 2] += 0.03 * closed_loop.DEG
    world.link[:, 4] += 1.2e-3 * world.command[:, 3]
    world.link[:, 0] += generator.play(world.command[:, 0], 0.02 * closed_loop.DEG)


def tips_of(program: Path) -> tuple[MeasurementLog, Array, Array]:
    """A run's set-points, where the tools truly are in `base` (N, 3), mm, by Pinocchio, and which of them is mounted (N,)."""
    cell, text = read_cell(KR15), read_krl(program)
    ran = simulate(text, cell, cycle=generator.STEP)
    world = generator.World(np.asarray(ran.log.t), ran.log.setpoints(generator.AXES) / closed_loop.EDGE)
    machine(world)
    q = cell.to_q((world.command + world.link) * closed_loop.EDGE)
    tool = np.cumsum(np.diff(np.asarray(text.tool)[np.asarray(ran.motion)], prepend=0) != 0)
    tip = np.empty((len(q), 3))
    for stretch in np.unique(tool):
        rows = tool == stretch
        frame = text.tools[int(np.asarray(text.tool)[np.asarray(ran.motion)][rows][0])]
        tip[rows] = 1e3 * pinocchio_poses(cell.with_tool(closed_loop_frame(frame.xyzabc)), q[rows])[:, :3, 3]
    return ran.log, tip, np.asarray(ran.motion)


def closed_loop_frame(xyzabc: Array) -> Array:
    """(4, 4) m of a frame in mm and degrees, Z Y X, written out here."""
    x, y, z, a, b, c = np.asarray(xyzabc) * [1e-3, 1e-3, 1e-3, *[np.pi / 180.0] * 3]
    (ca, sa), (cb, sb), (cc, sc) = ((np.cos(v), np.sin(v)) for v in (a, b, c))
    turn = np.array([[ca, -sa, 0], [sa, ca, 0], [0, 0, 1]]) @ np.array([[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]])
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = turn @ np.array([[1, 0, 0], [0, cc, -sc], [0, sc, cc]]), (x, y, z)
    return out


def logged(program: Path, seed: int) -> MeasurementLog:
    """What an instrument with noise writes of a run."""
    ran, tip, _motion = tips_of(program)
    seen = tip[ROWS] + np.random.default_rng(seed).normal(0.0, NOISE_MM, tip[ROWS].shape)
    columns = {name: np.asarray(ran.columns[name])[ROWS] for name in ("t", "line")}
    columns |= dict(zip("xyz", seen.T, strict=True))
    for axis, values in zip(generator.AXES, ran.setpoints(generator.AXES).T, strict=True):
        columns[axis] = columns[f"c{axis}"] = values[ROWS]
    return MeasurementLog(
        columns, LogInfo(measured_frame=MeasuredFrame.BASE, sigma_position=1e-3 * NOISE_MM, program=program.name)
    )


def off_cl(program: Path) -> float:
    """95 % of how far, mm, the tips are off what the CL file's level cuts ask for, in rows of slow lines."""
    text, (_, tip, motion) = read_krl(program), tips_of(program)
    slow = (np.asarray(text.kind) == Motion.LIN) & (np.asarray(text.speed) < 1.01 * 0.025)
    rows = np.flatnonzero(slow[motion])
    here = tip[rows] - [0.0, 0.0, PLACED_Z]
    here, nearest = here[here[:, 2] < 4.0], np.inf
    for points in (FIRST, SECOND):
        for a, b in pairwise(np.array([[*p, 2.0] for p in points])):
            along = np.clip((here - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
            nearest = np.minimum(nearest, np.linalg.norm(here - a - along[:, None] * (b - a), axis=1))
    return float(np.quantile(nearest, 0.95))


@pytest.fixture
def job(tmp_path: Path) -> Path:
    (tmp_path / "part.nc").write_text(JOB)
    (tmp_path / "setup.toml").write_text(TWO_TOOLS)
    file = tmp_path / "loop.toml"
    file.write_text(f'toolpath = "part.nc"\ncell = "{KR15}"\ntolerance_mm = 0.08\nexperiments = false\n')
    return file


def test_a_log_is_taken_apart_by_its_tools_and_measured_with_each(job: Path, tmp_path: Path) -> None:
    post(tmp_path / "part.nc", cell=KR15, out=tmp_path / "out", report=False)
    file, cell = tmp_path / "out" / "part.src", read_cell(KR15)
    program, log = read_krl(file), replace(logged(file, 1), path=tmp_path / "run.csv")
    parts = tool_stretches([log], [program], cell)
    assert len(parts) == 3 and parts[0].log.path.name == "run.csv"
    assert parts[0].cell.digest == parts[2].cell.digest != parts[1].cell.digest
    assert sum(len(p.log) for p in parts) == len(log)
    unknown = replace(log, info=replace(log.info, measured_frame=MeasuredFrame.UNKNOWN))
    assert [p.log.info.same_frame_as for p in tool_stretches([unknown], [program], cell)] == ["", "run.csv", "run.csv"]
    slow = (np.asarray(program.kind) == Motion.LIN) & (np.asarray(program.speed) < 1.01 * 0.025)
    seen = measured_off_path(log, program, cell, intended_path(program, cell), np.arange(len(program)), slow)
    assert off_path_size(seen.distance).p95_mm == pytest.approx(off_cl(file), rel=0.15)
    silent = MeasurementLog({k: v for k, v in log.columns.items() if k != "line"}, log.info, log.path)
    with pytest.raises(LogError, match=r"does not say which line of PART ran, and the program changes its tool"):
        tool_stretches([silent], [program], cell)


@pytest.mark.slow
def test_the_loop_brings_all_tools_to_their_ways(job: Path, tmp_path: Path) -> None:
    """Two turns on a machine of other code: what it measures is what its own judge measures, and that shrinks to a quarter."""
    out, reached = tmp_path / "loop", []
    for turn in (1, 2):
        close_loop(job, out=out)
        program = out / f"turn_{turn}" / "part.src"
        write_log(logged(program, turn), out / f"turn_{turn}" / "run.csv")
        reached.append(off_cl(program))
    said = close_loop(job, out=out).summary
    assert said.outcome == "within tolerance"
    assert said.turns[0].measured.p95_mm == pytest.approx(reached[0], rel=0.15)
    assert {"backlash A1"} <= set(said.turns[0].found)
    assert reached[1] < 0.25 * reached[0]
