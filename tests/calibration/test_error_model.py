"""The model of a cell's errors: its poses against plain matrices, its derivatives against differences, its torques."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob.calibration.error_model import ErrorModel
from camrob.calibration.terms import parameter_of, standard_names
from camrob.cell.joint import Role
from camrob.cell.read_cell import read_cell
from camrob.cell.world import world_T_floor
from camrob.dynamics.gravity import gravity_arrays, gravity_stiffness, gravity_torques, pinocchio_torques
from camrob.errors import LogError
from camrob.kinematics.frames import base_T_tool, world_T_base
from camrob.se3 import frame_from_xyzabc, inverse, pose, rotation_exp, rotation_log

ROOT = Path(__file__).resolve().parents[2]
CELL = read_cell(ROOT / "cells" / "kr15_track_table")
MORE = ["A5.by.A4", "A3.by.speed", "root.rx.by.lean", "root.y.by.lean", "A2.z", "A3.scale", "E1.zero", "A4.sin2.5"]


def postures(n: int, seed: int = 0) -> np.ndarray:
    q = np.random.default_rng(seed).uniform(-2.0, 2.0, (n, 9))
    q[:, 8] = 0.0
    return q


def case(in_base: bool, n: int = 15):
    rng = np.random.default_rng(7)
    names = (*standard_names(CELL, table=in_base, harmonics=1), *MORE, *(["E2.zero"] if in_base else []))
    left = frame_from_xyzabc(rng.normal(size=6))
    right = frame_from_xyzabc(0.3 * rng.normal(size=6))
    model = ErrorModel.of(CELL, names, in_base=in_base, left=left, right=right)
    scales = np.array([parameter_of(CELL, n).scale for n in names])
    values = 20.0 * scales * rng.normal(size=len(names))
    given = {"speed": rng.normal(size=n), "lean": rng.normal(size=n)}
    return model, values, scales, postures(n), given


def moved(v) -> np.ndarray:
    return pose(rotation_exp(v[3:]), v[:3])


def twin(model: ErrorModel, values: np.ndarray, q: np.ndarray, row: int, given) -> np.ndarray:
    """The pose of one posture by plain 4x4 matrices, term by term."""
    v = dict(zip(model.names, values, strict=True))
    torque = gravity_torques(model.gravity, q)[row]

    def place(owner: str) -> np.ndarray:
        return moved(np.array([v.get(f"{owner}.{k}", 0.0) for k in ("x", "y", "z", "rx", "ry", "rz")]))

    def joint_motion(joint, angle: float) -> np.ndarray:
        T = moved(np.array([0, 0, 0, 0, 0, angle])) if not joint.prismatic else np.eye(4)
        T[2, 3] = angle if joint.prismatic else 0.0
        return T

    T = model.arrays.left
    world_T_start = world_T_floor(CELL)
    if model.in_base:
        T = T @ CELL.base_T_first
    for i, joint in enumerate(CELL.joints[:-1]):
        if joint.role is Role.WORKPIECE and not model.in_base:
            continue
        if i == 1:
            T = T @ (inverse(world_T_start) if model.in_base else np.eye(4)) @ place("base") @ world_T_start
        if joint.name == "A1":
            lean = np.array([v["root.rx.by.lean"], v["root.y.by.lean"]]) * given["lean"][row]
            foot = moved(np.array([0, lean[1], 0, lean[0], 0, 0]))
            T = T @ CELL.foot_T_root @ foot @ inverse(np.asarray(CELL.foot_T_root))
        axis = joint.axis_value(q[row, i])
        real = axis * (1.0 + v.get(f"{joint.name}.scale", 0.0)) + v.get(f"{joint.name}.zero", 0.0)
        for k in (1.0, 2.5):
            real += v.get(f"{joint.name}.cos{k:g}", 0.0) * np.cos(k * axis)
            real += v.get(f"{joint.name}.sin{k:g}", 0.0) * np.sin(k * axis)
        if joint.name == "A5":
            real += v["A5.by.A4"] * CELL.joints[CELL.index("A4")].axis_value(q[row, CELL.index("A4")])
        if joint.name == "A3":
            real += v["A3.by.speed"] * given["speed"][row]
        now = joint.q_value(real) + v.get(f"{joint.name}.compliance", 0.0) * torque[i]
        if joint.role is Role.ARM:
            T = T @ joint.before @ place(joint.name) @ joint_motion(joint, now) @ joint.after
        else:
            zero = joint.q_value(0.0)
            E = place(joint.name)
            T = T @ joint.before @ E @ joint_motion(joint, now - zero) @ inverse(E) @ joint_motion(joint, zero)
            T = T @ joint.after
    return T @ CELL.wrist_T_flange @ CELL.flange_T_tool @ place("tool") @ model.arrays.right


@pytest.mark.parametrize("in_base", [False, True])
def test_without_errors_the_model_is_nominal(in_base: bool) -> None:
    q = postures(30)
    model = ErrorModel.of(CELL, standard_names(CELL, table=in_base), in_base=in_base)
    want = base_T_tool(CELL, q) if in_base else world_T_base(CELL, q) @ base_T_tool(CELL, q)
    assert np.allclose(model.poses(np.zeros(len(model.names)), q), want, atol=1e-14)


@pytest.mark.parametrize("in_base", [False, True])
def test_the_kernel_matches_plain_matrices(in_base: bool) -> None:
    model, values, _, q, given = case(in_base)
    poses = model.poses(values, q, given)
    for row in range(len(q)):
        assert np.allclose(poses[row], twin(model, values, q, row, given), atol=1e-12)


@pytest.mark.parametrize("in_base", [False, True])
def test_derivatives_are_those_of_differences(in_base: bool) -> None:
    model, values, scales, q, given = case(in_base)
    poses, J = model.poses_and_jacobian(values, q, given)
    assert np.allclose(poses, model.poses(values, q, given), atol=1e-15)
    for k, name in enumerate(model.names):
        step = np.zeros(len(values))
        step[k] = 1e-2 * scales[k]
        a, b = model.poses(values - step, q, given), model.poses(values + step, q, given)
        turn = rotation_log(b[:, :3, :3] @ np.swapaxes(a[:, :3, :3], 1, 2))
        want = np.concatenate([(b - a)[:, :3, 3], turn], axis=1) / (2.0 * step[k])
        assert np.allclose(J[:, :, k], want, atol=1e-6 * max(1.0, np.abs(want).max())), name


def test_the_arm_s_own_derivatives_hold_compliance_and_gears() -> None:
    model, values, _, q, given = case(False)
    J = model.poses_and_arm_jacobian(values, q, given)[1]
    for i in range(6):
        step = np.zeros(9)
        step[CELL.arm_slice.start + i] = 1e-6
        a, b = model.poses(values, q - step, given), model.poses(values, q + step, given)
        turn = rotation_log(b[:, :3, :3] @ np.swapaxes(a[:, :3, :3], 1, 2))
        want = np.concatenate([(b - a)[:, :3, 3], turn], axis=1) / 2e-6
        assert np.allclose(J[:, :, i], want, atol=1e-7)


def test_signs_are_the_contract_s() -> None:
    """joint_offset adds to KRL's axis value; frame_base stands left of world_T_root, frame_tool right of the tip."""
    q = postures(5)
    values = CELL.to_axis_values(q)
    values[:, 4] += 0.05  # A5, whose sign is turned in this cell
    model = ErrorModel.of(CELL, ["A5.zero", "base.x", "base.rz", "tool.y"])
    nominal = model.poses(np.zeros(4), q)
    turned = world_T_base(CELL, q) @ base_T_tool(CELL, CELL.to_q(values))
    assert np.allclose(model.poses(np.array([np.deg2rad(0.05), 0, 0, 0]), q), turned, atol=1e-12)
    assert np.allclose(model.poses(np.array([0, 0.001, 0, 0]), q)[:, :3, 3] - nominal[:, :3, 3], [0.001, 0, 0])
    assert np.allclose(
        model.poses(np.array([0, 0, 0, 0.001]), q)[:, :3, 3], nominal[:, :3, 3] + 0.001 * nominal[:, :3, 1]
    )
    about = moved(np.array([0, 0, 0, 0, 0, 0.01]))
    assert np.allclose(model.poses(np.array([0, 0, 0.01, 0]), q), about @ nominal, atol=1e-14)


def test_a_load_bends_the_arm_down() -> None:
    """With a stretched arm, compliance lowers the tool, whatever the sign of an axis."""
    q = CELL.to_q(np.array([[0.0, -40.0, 60.0, 0.0, 20.0, 0.0, 0.0, 0.0]]))
    for axis in ("A2", "A3", "A5"):
        model = ErrorModel.of(CELL, [f"{axis}.compliance"])
        drop = model.poses(np.array([1e-6]), q) - model.poses(np.zeros(1), q)
        assert drop[0, 2, 3] < 0.0, axis


def test_torques_are_pinocchio_s() -> None:
    q = postures(20)
    arrays = gravity_arrays(CELL)
    torques = gravity_torques(arrays, q)
    assert np.allclose(torques, pinocchio_torques(CELL, q), atol=1e-10)
    assert np.abs(torques[:, CELL.index("A2")]).max() > 300.0
    step = 1e-6 * np.eye(9)
    slope = np.stack([(gravity_torques(arrays, q + s) - gravity_torques(arrays, q - s)) / 2e-6 for s in step], axis=-1)
    assert np.allclose(gravity_stiffness(arrays, q), slope, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("A7.zero", "is not an error parameter of cell"),
        ("A3.banana", "use A3 with x, y, z, rx, ry, zero"),
        ("E1.x", "use E1 with rx, ry, zero"),
        ("A1.rz", "is not an error parameter"),
        ("A1.zero\n", "is not an error parameter"),
    ],
)
def test_names_that_say_nothing(name: str, message: str) -> None:
    with pytest.raises(LogError, match=message):
        ErrorModel.of(CELL, [name])


def test_names_twice_and_quantities_that_are_absent() -> None:
    with pytest.raises(LogError, match=r"A1\.zero appears twice"):
        ErrorModel.of(CELL, ["A1.zero", "A1.zero"])
    with pytest.raises(LogError, match="needs a quantity 'speed'"):
        ErrorModel.of(CELL, ["A3.by.speed"]).poses(np.zeros(1), postures(1))


def test_the_published_set_has_thirty_geometric_and_five_stiffness_parameters() -> None:
    names = standard_names(CELL, track=False)
    own = [n for n in names if n[:4] not in ("base", "tool")]
    assert sum(n.endswith("compliance") for n in own) == 5
    assert len(own) - 5 == 30
