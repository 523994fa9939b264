"""Laws that hold for every cell: what may move without changing anything, and what can only change one way."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from camrob import post
from camrob.calibration.error_model import ErrorModel
from camrob.calibration.terms import standard_names
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.read_cell import read_cell
from camrob.checks.collisions import STEP, check_collisions
from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.inputs import read_inputs
from camrob.kinematics.frames import base_T_tool, world_T_base
from camrob.kinematics.kernels import chain_arrays, forward_many
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.redundancy.published.virtual_joint import resolve_vjm
from camrob.se3 import pose, rotation_exp
from camrob.timing.timing import program_time
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

ROOT = Path(__file__).resolve().parents[2]
KR15 = ROOT / "cells" / "kr15_track_table"
CELLS = sorted(
    folder.parent for folder in [*(ROOT / "cells").glob("*/cell.toml"), ROOT / "tests" / "data" / "ur10" / "cell.toml"]
)
NAMES = [folder.name for folder in CELLS]
FEW = settings(
    max_examples=15, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
unit = st.floats(-1.0, 1.0, allow_nan=False)


def postures(cell: Cell, shares: list[list[float]]) -> np.ndarray:
    """Postures within the limits, from shares (-1 to 1) of each joint's range (of a turn, where it is endless)."""
    lower = np.array([max(j.q_lower, -np.pi) for j in cell.joints])
    upper = np.array([min(j.q_upper, np.pi) for j in cell.joints])
    return lower + 0.5 * (np.array(shares)[:, : len(cell)] + 1.0) * (upper - lower)


@pytest.fixture(scope="module", params=CELLS, ids=NAMES)
def cell(request: pytest.FixtureRequest) -> Cell:
    return read_cell(request.param)


rows = st.lists(st.lists(unit, min_size=10, max_size=10), min_size=1, max_size=6)


@FEW
@given(shares=rows)
def test_the_world_may_move(cell: Cell, shares: list[list[float]]) -> None:
    """The whole cell set up elsewhere in the world: poses in `base` follow the first frame, and nothing else changes."""
    q = postures(cell, shares)
    new_T_old = pose(rotation_exp(np.array([0.3, -0.2, 0.9])), np.array([1.0, -2.0, 0.5]))
    moved = replace(cell, base_T_first=new_T_old @ np.asarray(cell.base_T_first))
    expected = new_T_old @ base_T_tool(cell, q)
    assert np.allclose(base_T_tool(moved, q), expected, atol=1e-12)
    assert np.allclose(
        forward_many(chain_arrays(moved), q), new_T_old @ forward_many(chain_arrays(cell), q), atol=1e-12
    )


@FEW
@given(shares=rows)
def test_an_uncalibrated_cell_is_the_nominal_one(cell: Cell, shares: list[list[float]]) -> None:
    """All error parameters at zero: the calibrated chain is the nominal chain, with compliance and ripple too."""
    q = postures(cell, shares)
    q[:, list(cell.indices(Role.ROLL))] = 0.0  # virtual: it has no part in measured poses
    model = ErrorModel.of(cell, standard_names(cell, harmonics=2))
    world_T_tool = world_T_base(cell, q) @ base_T_tool(cell, q)
    assert np.allclose(model.poses(np.zeros(len(model.names)), q), world_T_tool, atol=1e-12)


@FEW
@given(shares=rows)
def test_axis_values_and_back(cell: Cell, shares: list[list[float]]) -> None:
    """KRL's numbers say the posture: signs, offsets and units undone give what was there (the roll is never printed)."""
    q = postures(cell, shares)
    rolls = cell.indices(Role.ROLL)
    q[:, list(rolls)] = 0.0
    assert np.allclose(cell.to_q(cell.to_axis_values(q)), q, atol=1e-12)


@given(value=st.floats(-1e6, 1e6, allow_nan=False, allow_subnormal=False).filter(lambda v: v == 0.0 or abs(v) > 1e-200))
def test_units_are_scaled_exactly(value: float) -> None:
    """Edge units go in and come out within one unit of the last place, and linearly."""
    for there, back in ((mm_to_m, m_to_mm), (deg_to_rad, rad_to_deg)):
        assert back(there(value)) == pytest.approx(value, rel=4e-16, abs=1e-300)
        assert there(2.0 * value) == 2.0 * there(value) and there(-value) == -there(value)


# ---- on whole jobs of the KR15 cell

PART = (
    "TOOL PATH/A,TOOL,B\nTLDATA/MILL,10,0,50,0,0\nMSYS/0,0,0,1,0,0,0,1,0\nRAPID\nGOTO/{0}\nFEDRAT/MMPM,900\nGOTO/{1}\nGOTO/{2}\n"
    "GOTO/{3}\nGOTO/{4}\nRAPID\nGOTO/{0}\nEND-OF-PATH\n"
)
POINTS = np.array([[0, 0, 50], [0, 0, 0], [60, 10, 0], [60, 50, 2], [0, 40, 1]], float)
AXIS = np.array([0.17364818, 0.0, 0.98480775])


def words(points: np.ndarray, axis: np.ndarray) -> list[str]:
    return [",".join(f"{v:.9f}" for v in (*p, *axis)) for p in points]


def job(folder: Path, points: np.ndarray, axis: np.ndarray, placement: np.ndarray) -> Path:
    folder.mkdir()
    (folder / "part.cls").write_text(PART.format(*words(points, axis)))
    (folder / "setup.toml").write_text(f"part_in_base = [{', '.join(f'{v:.9f}' for v in placement)}]\n")
    return folder / "part.cls"


@settings(max_examples=6, deadline=None, derandomize=True)
@given(shift=st.tuples(unit, unit, unit), turn=unit)
def test_part_and_path_may_move_together(tmp_path_factory: pytest.TempPathFactory, shift: tuple, turn: float) -> None:
    """The CL file in another frame of the part, and the part's frame moved back: the same program, to the last digit or two."""
    folder = tmp_path_factory.mktemp("moved")
    angle = np.round(180.0 * turn, 3)
    part_R_old = rotation_exp(np.array([0.0, 0.0, np.radians(-angle)]))
    offset = np.round(300.0 * np.array(shift), 3)
    part_p_old = -part_R_old @ offset  # so that the old part frame lies where it lay
    plain = job(folder / "plain", POINTS, AXIS, np.array([20.0, -30.0, 250.0, 0, 0, 0]))
    moved = job(
        folder / "moved",
        POINTS @ part_R_old.T + part_p_old,
        part_R_old @ AXIS,
        np.array([20.0, -30.0, 250.0, angle, 0, 0]) + np.array([*offset, 0, 0, 0]),
    )
    programs = []
    for part in (plain, moved):
        out = post(part, cell=KR15, out=part.parent / "out", report=False).out
        programs.append(read_krl(out / "part.src"))
    one, other = programs
    assert np.array_equal(one.kind, other.kind) and np.array_equal(one.speed, other.speed)
    by_pose = np.isfinite(one.pose[:, 0])
    assert np.abs(one.pose[by_pose, :3] - other.pose[by_pose, :3]).max() <= 0.0011
    assert np.abs(one.external - other.external).max() <= 0.0011


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory):
    part = job(tmp_path_factory.mktemp("job") / "in", POINTS, AXIS, np.array([20.0, -30.0, 250.0, 0, 0, 0]))
    inputs = read_inputs(part, cell_for("post", KR15), None)
    return inputs, resolve_vjm(inputs.cell, inputs.path)


@FEW
@given(
    slower=st.lists(st.floats(0.02, 1.0), min_size=9, max_size=9),
    what=st.sampled_from(["speed", "acceleration", "jerk"]),
)
def test_slower_limits_never_shorten_time(solved, slower: list[float], what: str) -> None:
    inputs, solution = solved
    path = inputs.path
    speed = np.where(path.cutting, path.feed, 0.1)
    limited = replace(
        inputs.cell,
        joints=tuple(
            replace(j, **{what: getattr(j, what) * s}) for j, s in zip(inputs.cell.joints, slower, strict=True)
        ),
    )
    usual = program_time(inputs.cell, path, np.asarray(solution.q), speed=speed).total
    assert program_time(limited, path, np.asarray(solution.q), speed=speed).total >= usual * (1.0 - 1e-12)
    assert program_time(inputs.cell, path, np.asarray(solution.q), speed=speed * min(slower)).total >= usual * (
        1 - 1e-12
    )


def box(center: np.ndarray, size: float) -> np.ndarray:
    """Triangles (12, 3, 3) of a cube."""
    import trimesh

    cube = trimesh.creation.box((size, size, size))
    cube.apply_translation(center)
    return np.asarray(cube.triangles)


@settings(max_examples=8, deadline=None, derandomize=True)
@given(place=st.tuples(unit, unit, unit), size=st.floats(0.02, 0.3))
def test_an_obstacle_never_adds_room(solved, place: tuple, size: float) -> None:
    """A body more: collisions stay, and the clearance doesn't grow."""
    inputs, solution = solved
    path = inputs.path
    of_path = {"cutting": path.cutting, "line": path.line, "region": path.region, "tool": inputs.tool}
    near = box(np.array([0.05, 0.0, 0.2]) + 0.05, 0.04)
    more = np.concatenate([near, box(np.array([0.0, 0.0, 0.3]) + 0.4 * np.array(place), size)])
    few = check_collisions(inputs.cell, np.asarray(solution.q), part_mesh=near, **of_path)
    many = check_collisions(inputs.cell, np.asarray(solution.q), part_mesh=more, **of_path)
    assert many.count >= few.count
    assert many.clearance_min <= few.clearance_min + STEP  # samples of a path lie a step apart


@pytest.mark.slow
def test_the_same_input_gives_the_same_bytes(tmp_path: Path) -> None:
    """Run after run, and in a process of its own with other numbers of threads: programs and paths are the same bytes."""
    import os
    import subprocess
    import sys

    part = job(tmp_path / "in", POINTS, AXIS, np.array([20.0, -30.0, 250.0, 0, 0, 0]))
    made: list[dict[str, bytes]] = []
    for method in ("vjm", "planned"):
        for threads in ("1", "4"):
            out = tmp_path / f"{method}{threads}"
            threading = {
                n: threads for n in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
            }
            command = ["post", str(part), "--cell", str(KR15), "--out", str(out), "--method", method, "--quiet"]
            subprocess.run(
                [sys.executable, "-m", "camrob.cli", *command],
                check=True,
                env={**os.environ, **threading, "PYTHONPATH": str(ROOT)},
            )
            files = {f.name: f.read_bytes() for f in out.iterdir()}
            summary = json.loads(files.pop("part.json"))
            summary.pop("seconds")
            files["part.json"] = json.dumps(summary).encode()
            made.append({name: data for name, data in files.items() if not name.endswith(".html")})
        assert [n for n in made[-1] if made[-1][n] != made[-2].get(n)] == [], method
    assert made[0]["part.src"] != made[-1]["part.src"]
