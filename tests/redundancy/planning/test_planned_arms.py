"""Plans for arms without a machine tool builder's geometry: a UR10e on the KR15's track, and the KR15 with an A2 askew."""

from __future__ import annotations

import re
import shutil
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from follower_twins import CELL

import camrob
from camrob.cell.cell import Cell
from camrob.cell.joint import Joint, Role, dh_after, dh_before
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_tool
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.planned import resolve_planned
from camrob.toolpath.region import Move
from camrob.units import deg_to_rad

# standard rows a, alpha, d of the UR10e, m and rad: Universal Robots, "DH parameters for calculations of kinematics and dynamics"
ROWS = [
    (0.0, np.pi / 2, 0.1807), (-0.6127, 0.0, 0.0), (-0.57155, 0.0, 0.0),
    (0.0, np.pi / 2, 0.17415), (0.0, -np.pi / 2, 0.11985), (0.0, 0.0, 0.11655),
]  # fmt: skip
HOME = np.array([0.0, -1.2, 1.8, -2.0, -np.pi / 2, 0.0])


def ur10e_on_a_track() -> Cell:
    """The KR15 cell with a UR10e on its track."""
    arm = [
        Joint(
            f"A{k + 1}", Role.ARM, False,
            (np.asarray(CELL.foot_T_root) if k == 0 else np.eye(4)) @ dh_before(theta=0.0, d=d), dh_after(a=a, alpha=alpha),
            lower=-6.28, upper=6.28, speed=2.0, acceleration=10.0, jerk=100.0, home=HOME[k], reference=HOME[k],
        )
        for k, (a, alpha, d) in enumerate(ROWS)
    ]  # fmt: skip
    joints = (*CELL.joints[: CELL.index("A1")], *arm, CELL.joints[-1])
    return replace(
        CELL, name="ur10e", joints=joints, wrist_T_flange=np.eye(4), flange_T_tool=np.diag([1.0, -1.0, -1.0, 1.0]), shapes=(),
        masses=(),
    )  # fmt: skip


@pytest.mark.slow
def test_a_ur10e_is_planned_and_does_not_fall_back() -> None:
    cell = ur10e_on_a_track()
    assert Arm.of(cell).closed is None and not Arm.of(cell).searched
    begin = base_T_tool(cell, cell.q_home)
    count = 60
    frames = np.tile(begin, (count, 1, 1))
    turn = np.linspace(0.0, 2.0 * np.pi, count)
    frames[:, 0, 3] += 0.08 * (1.0 - np.cos(turn))
    frames[:, 1, 3] += 0.08 * np.sin(turn)
    safe = np.isin(np.arange(count), (0, count - 1))
    path = ToolPathInBase(
        frames, np.where(safe, Move.RAPID, Move.CUT), np.where(safe, np.nan, 0.02), np.arange(1, count + 1),
        np.zeros(count, np.int32), np.arange(count), safe,
    )  # fmt: skip
    solution = resolve_planned(cell, path)
    assert solution.method == "planned", [f.text for f in solution.findings]
    assert "plan-fell-back" not in [f.code for f in solution.findings]
    position, axis = solution.residual(cell, path)
    assert position.max() < 1e-6 and axis.max() < 1e-6
    q = np.asarray(solution.q)
    assert np.all(q >= cell.q_lower) and np.all(q <= cell.q_upper)
    assert np.abs(np.diff(q[:, cell.arm_slice], axis=0)).max() < deg_to_rad(10.0)
    report = solution.plan
    assert report is not None and np.all(solution.inv_kf <= report.bound + 1e-6)


def chain(toml: Path, q: np.ndarray) -> np.ndarray:
    """Tips (N, 3), mm, in `base` of postures q (N, n), SI, by the rows of a cell.toml, multiplied out here."""
    cell = tomllib.loads(toml.read_text())
    T = np.broadcast_to(np.eye(4), (len(q), 4, 4))
    for joint, value in zip(cell["joint"][:-1], q.T, strict=False):  # the roll moves no tip
        row, turns = joint["dh"], joint["type"] == "revolute"
        theta = np.radians(row["theta_deg"]) + turns * value
        c, s = np.cos(theta), np.sin(theta)
        ca, sa = np.cos(np.radians(row["alpha_deg"])), np.sin(np.radians(row["alpha_deg"]))
        step = np.zeros((len(q), 4, 4))
        step[:, 0] = np.stack([c, -s * ca, s * sa, row["a_mm"] * c], axis=1)
        step[:, 1] = np.stack([s, c * ca, -c * sa, row["a_mm"] * s], axis=1)
        step[:, 2, 1], step[:, 2, 2], step[:, 2, 3], step[:, 3, 3] = (
            sa,
            ca,
            row["d_mm"] + (not turns) * 1e3 * value,
            1.0,
        )
        T = T @ step
    assert cell["kinematics"]["wrist_to_flange"] == [0, 0, 0, 0, 0, 180]
    x, y, z = cell["tool"]["flange_to_tool"][:3]  # seen from a plate turned about X
    return np.asarray((T @ np.array([x, -y, -z, 1.0]))[:, :3])


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [0.3, 2])
def test_beside_an_a2_askew_the_engraving_is_planned_and_does_not_fall_back(degrees: float, tmp_path: Path) -> None:
    folder = tmp_path / "askew"
    shutil.copytree(CELL.folder, folder, ignore=shutil.ignore_patterns("poses.csv"))
    toml = folder / "cell.toml"
    text, plain = toml.read_text(), "alpha_deg = 0, a_mm = 650"
    assert text.count(plain) == 1
    toml.write_text(text.replace(plain, f"alpha_deg = {degrees}, a_mm = 650"))
    part = CELL.folder.parents[1] / "toolpaths" / "engraving" / "engraving.cls"
    result = camrob.post(part, cell=folder, out=tmp_path, method="planned", report=False)
    assert result.summary.method == "planned"
    assert not {"plan-collides", "plan-fell-back"} & {f.code for f in result.summary.warnings}
    with np.load(tmp_path / "engraving.path.npz") as path:
        tips = chain(toml, path["q"])
    program = (tmp_path / "engraving.src").read_text()
    targets = re.findall(r"E6POS: X (\S+?),Y (\S+?),Z (\S+?),", program)
    assert len(targets) > 100
    off = np.array([np.linalg.norm(tips - target, axis=1).min() for target in np.array(targets, float)])
    assert np.all((off < 0.002) | (np.abs(off - 40.0) < 0.002))  # void motions are lifted by the set-up's clearance
    assert np.count_nonzero(off < 0.002) > 150
