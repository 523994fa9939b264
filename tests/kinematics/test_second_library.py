"""Second opinions on the chain: Pinocchio from the exported URDF, and pytorch-kinematics."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from camrob.cell.read_cell import read_cell
from camrob.cell.urdf import cell_urdf
from camrob.kinematics import frames, kernels
from camrob.kinematics.batched import BatchedKinematics
from camrob.se3 import inverse

pinocchio = pytest.importorskip("pinocchio")

FOLDER = Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table"
CELL = read_cell(FOLDER)
CHAIN = kernels.chain_arrays(CELL)


@pytest.fixture(scope="module")
def postures():
    rng = np.random.default_rng(11)
    lower = np.where(np.isfinite(CELL.q_lower), CELL.q_lower, -7.0)
    upper = np.where(np.isfinite(CELL.q_upper), CELL.q_upper, 7.0)
    return rng.uniform(lower, upper, (300, len(CELL)))


@pytest.fixture(scope="module")
def model():
    return pinocchio.buildModelFromXML(cell_urdf(CELL))


@pytest.fixture(scope="module")
def batched():
    return BatchedKinematics(CELL, chunk=128)  # so that 300 postures are three chunks, the last a short one


def pinocchio_q(q):
    """Pinocchio keeps a continuous joint as (cos, sin)."""
    return np.concatenate([[np.cos(v), np.sin(v)] if j.endless else [v] for j, v in zip(CELL.joints, q, strict=True)])


def test_pinocchio_sees_the_same_poses(model, postures):
    data = model.createData()
    base_T_tool, base_T_flange = frames.base_T_tool(CELL, postures), frames.base_T_flange(CELL, postures)
    base_T_root, compiled = frames.base_T_root(CELL, postures), kernels.forward_many(CHAIN, postures)
    for k, q in enumerate(postures):
        pinocchio.framesForwardKinematics(model, data, pinocchio_q(q))
        for name, expected in (
            ("tool", base_T_tool[k]),
            ("tool", compiled[k]),
            ("flange", base_T_flange[k]),
            ("root", base_T_root[k]),
        ):
            assert np.max(np.abs(data.oMf[model.getFrameId(name)].homogeneous - expected)) < 1e-12


def test_pinocchio_sees_the_same_jacobian(model, postures):
    data = model.createData()
    n = len(CELL)
    Z, P, R, p, plate, J = (
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty((3, 3)),
        np.empty(3),
        np.empty(3),
        np.empty((6, n)),
    )
    for q in postures[:50]:
        kernels.forward(CHAIN, q, Z, P, R, p, plate)
        kernels.jacobian(CHAIN, Z, P, p, J)
        expected = pinocchio.computeFrameJacobian(
            model, data, pinocchio_q(q), model.getFrameId("tool"), pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        assert np.max(np.abs(J - expected)) < 1e-12


def test_urdf_carries_limits_and_masses(model):
    robot = ElementTree.fromstring(cell_urdf(CELL))
    kinds = {j.get("name"): j.get("type") for j in robot.findall("joint")}
    assert (kinds["E2"], kinds["E1"], kinds["A5"], kinds["roll"]) == (
        "continuous",
        "prismatic",
        "revolute",
        "continuous",
    )
    a5 = next(j for j in robot.findall("joint") if j.get("name") == "A5").find("limit")
    assert np.degrees([float(a5.get("lower")), float(a5.get("upper"))]) == pytest.approx([45.0, 315.0])  # 180 -+ 135
    assert sum(i.mass for i in model.inertias) == pytest.approx(sum(m.mass for m in CELL.masses))


def test_inertials_pull_where_the_masses_hang(model, postures):
    """Gravity torques from the URDF equal the slope of the masses' height, taken from the cell's own frames."""

    def energy(q):
        T = frames.base_T_joint_frames(CELL, q)
        heights = [(T[CELL.index(m.after)] @ np.append(m.center, 1.0))[2] for m in CELL.masses]
        return 9.81 * np.dot([m.mass for m in CELL.masses], heights)

    data = model.createData()
    for q in postures[:5]:
        slope = [(energy(q + d) - energy(q - d)) / 2e-6 for d in 1e-6 * np.eye(len(CELL))]
        expected = pinocchio.computeGeneralizedGravity(model, data, pinocchio_q(q))
        np.testing.assert_allclose(expected, slope, atol=2e-6)


def test_hostile_names_stay_text():
    joints = (*CELL.joints[:-1], replace(CELL.joints[-1], name='"/><link name="x'))
    text = cell_urdf(replace(CELL, name="<!ENTITY & ]]>", joints=joints))
    robot = ElementTree.fromstring(text)
    assert robot.get("name") == "<!ENTITY & ]]>"
    assert len(robot.findall("link")) == len(CELL) + 4  # base, root, flange, tool


def test_batched_chain_is_the_same(batched, postures):
    base_T_tool = batched.forward(postures)
    assert base_T_tool.dtype == np.float64
    assert np.max(np.abs(base_T_tool - kernels.forward_many(CHAIN, postures))) < 1e-12
    n = len(CELL)
    Z, P, R, p, plate, J = (
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty((3, 3)),
        np.empty(3),
        np.empty(3),
        np.empty((6, n)),
    )
    for q, expected in zip(postures, batched.jacobian(postures), strict=True):
        kernels.forward(CHAIN, q, Z, P, R, p, plate)
        kernels.jacobian(CHAIN, Z, P, p, J)
        assert np.max(np.abs(J - expected)) < 1e-12
    assert np.max(np.abs(batched.inverse_kf(postures) - kernels.inverse_kf_many(CHAIN, postures))) < 1e-9


def test_batched_arm_alone_is_the_same(batched, postures):
    root_T_flange = inverse(frames.base_T_root(CELL, postures)) @ frames.base_T_flange(CELL, postures)
    arm = postures[:, CELL.arm_slice]
    assert np.max(np.abs(batched.arm_forward(arm) - root_T_flange)) < 1e-12
    J = batched.arm_jacobian(arm)
    step = 1e-6
    for i in range(6):
        d = step * np.eye(6)[i]
        slope = (batched.arm_forward(arm + d)[:, :3, 3] - batched.arm_forward(arm - d)[:, :3, 3]) / (2 * step)
        np.testing.assert_allclose(J[:, :3, i], slope, atol=2e-9)


def test_batched_at_the_edges(batched):
    assert batched.forward(np.empty((0, len(CELL)))).shape == (0, 4, 4)
    singular = CELL.to_q(np.array([[0, -90, 90, 0, 0, 0, 0, 0.0]]))
    assert batched.inverse_kf(singular)[0] == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(ValueError, match="expected"):
        batched.forward(np.zeros((3, 8)))
    with pytest.raises(ValueError, match="chunk"):
        BatchedKinematics(CELL, chunk=0)


def test_pytorch_kinematics_reads_the_urdf(postures):
    """Its URDF reader works in float32, so this is about the text, to a micrometre; the chain above is exact."""
    pytorch_kinematics = pytest.importorskip("pytorch_kinematics")
    torch = pytest.importorskip("torch")
    chain = pytorch_kinematics.build_serial_chain_from_urdf(cell_urdf(CELL), "tool").to(dtype=torch.float64)
    expected = chain.forward_kinematics(torch.tensor(postures)).get_matrix().numpy()
    assert chain.get_joint_parameter_names() == list(CELL.names)
    assert np.max(np.abs(expected - frames.base_T_tool(CELL, postures))) < 5e-6
