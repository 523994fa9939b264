"""A path to whose first point the straight way from HOME leads nowhere is begun in another posture, to which PTP goes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from six_axes import six_axes

import camrob
from camrob.jobs.files.cells_and_samples import cell_from_urdf
from camrob.jobs.files.inputs import read_inputs
from camrob.kinematics.frames import base_T_tool
from camrob.redundancy.published.beginnings import (
    other_beginnings,
    resolve_begun_elsewhere,
    resolve_published,
)
from camrob.redundancy.published.virtual_joint import resolve_vjm

ROOT = Path(__file__).resolve().parents[3]
BEHIND = "part_in_base = [-900, 300, 300, 0, 0, 0]\nclearance_mm = 20\n"  # the foot stands between it and HOME
CL = """TOOL PATH/GROOVE,TOOL,BALL_3
TLDATA/MILL,3.0000,1.5000,80.0000,0.0000,0.0000
MSYS/0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0
FEDRAT/MMPM,600.0
GOTO/-60.0,0.0,40.0,0.0,0.0,1.0
GOTO/-60.0,0.0,0.0
GOTO/60.0,0.0,0.0
GOTO/60.0,40.0,0.0
GOTO/60.0,40.0,40.0
END-OF-PATH
"""


@pytest.fixture(scope="module")
def job(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("behind")
    cell_from_urdf(six_axes(folder), post=True, out=folder)
    (folder / "part.cls").write_text(CL)
    (folder / "setup.toml").write_text(BEHIND)
    return folder / "part.cls", folder / "six"


def test_a_part_behind_the_foot_is_followed_from_another_posture(job: tuple[Path, Path]) -> None:
    cell = camrob.read_cell(job[1])
    inputs = read_inputs(job[0], cell, None)
    with pytest.raises(camrob.JobError):
        resolve_vjm(cell, inputs.path)
    solution = resolve_published(cell, inputs.path)
    q = np.asarray(solution.q)
    tips = base_T_tool(cell, q)
    np.testing.assert_allclose(tips[:, :3, 3], inputs.path.base_T_tip[:, :3, 3], atol=1e-9)
    np.testing.assert_allclose(tips[:, :3, 2], inputs.path.base_T_tip[:, :3, 2], atol=1e-9)
    assert np.all(q >= cell.q_lower) and np.all(q <= cell.q_upper)
    begun = [f for f in solution.findings if f.code == "begun-elsewhere"]
    assert len(begun) == 1 and "begun in another posture" in begun[0].text


def test_it_is_posted_and_judged(job: tuple[Path, Path], tmp_path: Path) -> None:
    made = camrob.post(job[0], cell=job[1], out=tmp_path / "out", report=False)
    assert made.summary.verified.points == 5
    assert "begun-elsewhere" in {f.code for f in made.findings}


def test_beginnings_put_the_tool_there_and_differ(job: tuple[Path, Path]) -> None:
    cell = camrob.read_cell(job[1])
    pose = np.asarray(read_inputs(job[0], cell, None).path.base_T_tip[0])
    q = other_beginnings(cell, pose)
    assert len(q) >= 2
    there = base_T_tool(cell, q)
    np.testing.assert_allclose(there[:, :3, 3], np.tile(pose[:3, 3], (len(q), 1)), atol=1e-9)
    np.testing.assert_allclose(there[:, :3, 2], np.tile(pose[:3, 2], (len(q), 1)), atol=1e-9)
    assert all(np.abs(a - b)[:6].max() > 0.5 for k, a in enumerate(q) for b in q[:k])


def test_of_other_beginnings_one_that_touches_nothing_is_taken(job: tuple[Path, Path]) -> None:
    cell = camrob.read_cell(job[1])
    path = read_inputs(job[0], cell, None).path
    seen: list[float] = []

    def all_but_the_last(path: object, solution: camrob.Solution) -> np.ndarray:
        seen.append(float(solution.q[0, 1]))
        return np.full(len(solution.q), len(seen) == 1)

    solution = resolve_begun_elsewhere(cell, path, obstacles=all_but_the_last)
    assert len(seen) == 2 and float(solution.q[0, 1]) == seen[1]
    with pytest.raises(camrob.UnreachableError, match="from no other posture"):
        resolve_begun_elsewhere(cell, path, obstacles=lambda path, solution: np.ones(len(solution.q), bool))
