"""`camrob cell from-urdf --post`: Denavit-Hartenberg rows out of a URDF's frames, held to Pinocchio's reading of the file."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from camrob.cell.joint import Joint, Role, dh_after, dh_before
from camrob.cell.read_cell import read_cell
from camrob.errors import CellError
from camrob.jobs.files.cells_and_samples import cell_from_urdf
from camrob.kinematics.dh_rows import dh_chain
from camrob.kinematics.frames import base_T_tool
from camrob.se3 import rotation_exp

URDF = Path(__file__).resolve().parents[2].parent / "shared" / "benchmarks" / "urdf"


def drawn_joints(rng: np.random.Generator, kind: str) -> list[Joint]:
    """A chain in frames of its own: askew everywhere, parallel and square axes, or a lift beneath it."""
    joints = []
    for k in range(6):
        before = np.eye(4)
        turn = rng.uniform(-3.0, 3.0, 3) if kind == "askew" else 0.5 * np.pi * rng.integers(-2, 3, 3)
        for i in range(3):
            before[:3, :3] = before[:3, :3] @ rotation_exp(np.eye(3)[i] * turn[i])
        before[:3, 3] = rng.uniform(-0.5, 0.5, 3) * (rng.uniform(size=3) < 0.7)
        joints.append(Joint(f"A{k + 1}", Role.ARM, kind == "lift" and k == 0, before, np.eye(4)))
    return joints


def forward(places: list[tuple[np.ndarray, np.ndarray]], joints: list[Joint], q: np.ndarray) -> np.ndarray:
    T = np.eye(4)
    for (before, after), joint, value in zip(places, joints, q, strict=True):
        T = T @ before @ joint.motion(np.array(value)) @ after
    return T


@pytest.mark.parametrize("kind", ["askew", "square", "lift"])
def test_rows_put_the_end_where_the_chain_s_own_frames_do(kind: str) -> None:
    rng = np.random.default_rng(5)
    for _ in range(30):
        joints = drawn_joints(rng, kind)
        chain = dh_chain(joints)
        rows = [(dh_before(theta=r.theta, d=r.d), dh_after(a=r.a, alpha=r.alpha)) for r in chain.rows]
        end = np.linalg.inv(chain.base_T_frames[-1]) @ chain.base_T_ends[-1]
        for q in rng.uniform(-2.0, 2.0, (5, 6)):
            own = forward([(j.before, j.after) for j in joints], joints, q)
            np.testing.assert_allclose(chain.base_T_frames[0] @ forward(rows, joints, q) @ end, own, atol=1e-11)


def test_a_robot_s_rows_are_pinocchio_s_and_a_part_is_posted_with_them(tmp_path: Path) -> None:
    file = URDF / "ur10e.urdf"
    if not file.is_file():
        pytest.skip("../shared/benchmarks is not here")
    import pinocchio as pin

    cell = cell_from_urdf(file, tip="tool0", post=True, out=tmp_path).cell
    model = pin.buildModelFromUrdf(str(file))
    data, frame = model.createData(), model.getFrameId("tool0")
    rng = np.random.default_rng(3)
    for q in rng.uniform(cell.q_lower[:6], cell.q_upper[:6], (100, 6)):
        pin.framesForwardKinematics(model, data, q)
        ours = base_T_tool(cell, np.append(q, 0.0)) @ np.linalg.inv(np.asarray(cell.flange_T_tool))
        np.testing.assert_allclose(ours, data.oMf[frame].homogeneous, atol=1e-9)
    assert np.allclose([j.speed for j in cell.joints[:6]], model.velocityLimit)
    assert sum(m.mass for m in cell.masses) == pytest.approx(sum(i.mass for i in model.inertias[1:]), rel=1e-9)
    assert cell.provenance["joint[A1].dh.alpha_deg"] == "datasheet"
    assert read_cell(tmp_path / "ur10e").digest == cell.digest


def test_home_is_before_the_foot_with_the_first_axis_at_zero(tmp_path: Path) -> None:
    axes = ("0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0")
    places = ("0 0 0.5", "0.2 0 0", "0 0 0.9", "0 0 0.2", "1 0 0", "0.15 0 0")
    link = "".join(f'<link name="l{k}"/>' for k in range(7))
    joint = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/><origin xyz="{place}"/>'
        f'<axis xyz="{axis}"/><limit lower="-2.5" upper="2.5" velocity="1" effort="9"/></joint>'
        for k, (axis, place) in enumerate(zip(axes, places, strict=True))
    )
    (tmp_path / "six.urdf").write_text(f'<robot name="six">{link}{joint}</robot>')
    cell = cell_from_urdf(tmp_path / "six.urdf", post=True, out=tmp_path / "out").cell
    q = np.asarray(cell.q_home)[:6]
    assert q[0] == 0.0  # it leaves conditioning alone
    assert np.sum(q == 0.0) >= 2, q
    x, _y, z = base_T_tool(cell, np.asarray(cell.q_home))[:3, 3]
    assert x > 0.5
    assert z > 0.0


def test_an_arm_of_seven_axes_is_refused_with_what_to_do(tmp_path: Path) -> None:
    link = "".join(f'<link name="l{k}"/>' for k in range(8))
    joint = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/><origin xyz="0 0.2 0.1"/>'
        f'<axis xyz="{k % 2} 0 {1 - k % 2}"/><limit lower="-2" upper="2" velocity="1" effort="9"/></joint>'
        for k in range(7)
    )
    (tmp_path / "seven.urdf").write_text(f'<robot name="seven">{link}{joint}</robot>')
    with pytest.raises(CellError, match="an arm of 7 axes, and programs are made for six that turn; leave --post out"):
        cell_from_urdf(tmp_path / "seven.urdf", post=True, out=tmp_path)
    assert not (tmp_path / "seven").exists()


def test_axes_askew_by_a_file_s_rounding_are_made_square_and_it_is_said(tmp_path: Path) -> None:
    """1.5708 for pi / 2: common normals of such axes lie hundreds of metres away."""
    places = ["0 0 0.4", "0.2 0 0", "0 0.6 0", "0 0 0", "0 0.7 0", "0 0 0"]
    turns = ["0 0 0", "1.5708 0 0", "0 0 0", "0 1.5708 0", "-1.5708 0 0", "1.5708 0 0"]
    joint = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/><origin xyz="{xyz}" rpy="{rpy}"/>'
        '<axis xyz="0 0 1"/><limit lower="-2.9671" upper="2.0944" velocity="1.5708" effort="9"/></joint>'
        for k, (xyz, rpy) in enumerate(zip(places, turns, strict=True))
    )
    link = "".join(f'<link name="l{k}"/>' for k in range(7))
    (tmp_path / "round.urdf").write_text(f'<robot name="round">{link}{joint}</robot>')
    made = cell_from_urdf(tmp_path / "round.urdf", post=True, out=tmp_path)
    text = (tmp_path / "round" / "cell.toml").read_text(encoding="utf-8")
    assert text.count("range_deg = [-170, 120], speed_deg_s = 90, acceleration_deg_s2 = 270,") == 6
    lengths = [abs(float(v)) for v in re.findall(r"(?:a|d)_mm = (-?[\d.]+)", text)]
    assert max(lengths) < 1000.0
    assert {float(v) % 90.0 for v in re.findall(r"alpha_deg = (-?[\d.]+)", text)} == {0.0}
    said = [line for line in made.summary.next if "beside the file's" in line]
    assert len(said) == 1
    assert 1e-3 < float(re.findall(r"up to ([\d.]+) mm", said[0])[0]) < 0.02
