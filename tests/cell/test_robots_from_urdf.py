"""Robots of other people's URDF as cells: kinematics and limits equal to Pinocchio's, which reads the files for itself."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from camrob.cell.joint import Role
from camrob.errors import InputError
from camrob.jobs.files.cells_and_samples import cell_from_urdf
from camrob.kinematics.frames import base_T_tool

URDF = Path(__file__).resolve().parents[2].parent / "shared" / "benchmarks" / "urdf"
ROBOTS = {
    "ur10e": ("tool0", ["A1", "A2", "A3", "A4", "A5", "A6"]),
    "panda_arm_hand": ("panda_hand", ["A1", "A2", "A3", "A4", "A5", "A6", "A7"]),
    "iiwa14": ("link_ee", ["A1", "A2", "A3", "A4", "A5", "A6", "A7"]),
    "fetch": ("gripper_link", ["E1", "A1", "A2", "A3", "A4", "A5", "A6", "A7"]),
}


@pytest.mark.parametrize("name", ROBOTS)
def test_poses_and_limits_are_pinocchio_s(name: str, tmp_path: Path) -> None:
    file = URDF / f"{name}.urdf"
    if not file.is_file():
        pytest.skip("../shared/benchmarks is not here")
    import pinocchio as pin

    tip, axes = ROBOTS[name]
    cell = cell_from_urdf(file, tip=tip, out=tmp_path).cell
    assert list(cell.names) == axes
    assert all((j.role is Role.CARRIAGE) == (j.name == "E1") for j in cell.joints)
    model = pin.buildModelFromUrdf(str(file))
    data, frame = model.createData(), model.getFrameId(tip)
    moving = [j for j in model.supports[model.frames[frame].parentJoint] if j]
    assert len(moving) == len(cell)
    for joint, j in zip(cell.joints, moving, strict=True):
        at = model.joints[j].idx_q
        if model.joints[j].nq == 1:
            assert (joint.q_lower, joint.q_upper) == (model.lowerPositionLimit[at], model.upperPositionLimit[at])
        else:
            assert joint.endless
    rng = np.random.default_rng(3)
    q = rng.uniform(np.maximum(cell.q_lower, -np.pi), np.minimum(cell.q_upper, np.pi), (200, len(cell)))
    for ours, row in zip(base_T_tool(cell, q), q, strict=True):
        whole = pin.neutral(model)
        for value, j in zip(row, moving, strict=True):
            at, wide = model.joints[j].idx_q, model.joints[j].nq
            whole[at : at + wide] = [value] if wide == 1 else [np.cos(value), np.sin(value)]
        pin.framesForwardKinematics(model, data, whole)
        np.testing.assert_allclose(ours, data.oMf[frame].homogeneous, atol=1e-9)


def test_a_lift_beneath_a_short_arm_is_still_an_axis_of_it(tmp_path: Path) -> None:
    def joint(k: int, kind: str) -> str:
        limit = '<limit lower="0" upper="1" effort="0" velocity="1"/>'
        return f'<joint name="j{k}" type="{kind}"><parent link="l{k}"/><child link="l{k + 1}"/><axis xyz="0 0 1"/>{limit}</joint>'

    kinds = ["prismatic", "revolute", "revolute", "revolute"]
    text = "".join(f'<link name="l{k}"/>' for k in range(5)) + "".join(joint(k, kind) for k, kind in enumerate(kinds))
    (tmp_path / "scara.urdf").write_text(f'<robot name="scara">{text}</robot>')
    assert list(cell_from_urdf(tmp_path / "scara.urdf", out=tmp_path).cell.names) == ["A1", "A2", "A3", "A4"]
    more = "".join(f'<link name="l{k}"/>' for k in range(10)) + "".join(joint(k, "revolute") for k in range(9))
    (tmp_path / "nine.urdf").write_text(f'<robot name="nine">{more}</robot>')
    with pytest.raises(InputError, match="9 moving joints"):
        cell_from_urdf(tmp_path / "nine.urdf", out=tmp_path)


ARM = """<robot name="a"><link name="base"/><link name="tip"/><joint name="j1" type="revolute"><parent link="base"/>
<child link="tip"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="3"/></joint></robot>"""


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("0 0 1", "0 0 0", "joint 'j1' has an axis of no length"),
        ('lower="-1"', 'lower="nan"', "a number is 'nan'"),
        ('lower="-1"', 'lower="${-pi}"', "is a xacro file"),
        ('<link name="base"/>', '<xacro:arm prefix="a"/><link name="base"/>', "is a xacro file"),
        ('<link name="tip"/>', '<link name="tip"/><xacro:arm prefix=""/>', "is a xacro file"),
        ('lower="-1"', 'lower="-170"', "joint 'j1' with a limit of 170 rad, which look like degrees"),
        ("</joint>", '<mimic joint="j0"/></joint>', "joint 'j1' that follows 'j0' (mimic"),
        (
            "</robot>",
            '<joint name="b" type="fixed"><parent link="base"/><child link="tip"/></joint></robot>',
            "two joints carry",
        ),
        ('<parent link="base"/>', "", "needed where a URDF has 0 ends that move"),
    ],
)
def test_what_is_wrong_with_a_urdf_is_said_of_the_file_that_was_given(
    old: str, new: str, what: str, tmp_path: Path
) -> None:
    file = tmp_path / "a.urdf"
    file.write_text(ARM.replace(old, new))
    with pytest.raises(InputError, match=re.escape(what)) as error:
        cell_from_urdf(file, out=tmp_path)
    assert error.value.path == file
    assert not (tmp_path / "a").exists()
    file.write_text(ARM)
    assert cell_from_urdf(file, out=tmp_path).summary.axes == ("A1",)


def test_what_xacro_left_in_comments_is_no_xacro(tmp_path: Path) -> None:
    """As in the Talos, Tiago and xArm7 of example-robot-data: `<!-- <xacro:..> -->`, `<!-- rpy="${..}" -->`."""
    (tmp_path / "a.urdf").write_text(ARM.replace("</robot>", '<!-- <xacro:arm rpy="${pi}"/> --></robot>'))
    assert cell_from_urdf(tmp_path / "a.urdf", out=tmp_path).summary.axes == ("A1",)


def test_an_end_that_nothing_moves_is_nobody_s_tip(tmp_path: Path) -> None:
    """ROS-Industrial's files have a link `base` beside `tool0`."""
    still = '<link name="b"/><joint name="f" type="fixed"><parent link="base"/><child link="b"/></joint></robot>'
    (tmp_path / "a.urdf").write_text(ARM.replace("</robot>", still))
    assert cell_from_urdf(tmp_path / "a.urdf", out=tmp_path).summary.axes == ("A1",)
    other = still.replace('"fixed"', '"revolute"')
    (tmp_path / "b.urdf").write_text(ARM.replace("</robot>", other))
    with pytest.raises(InputError, match="2 ends that move, not 1; name one, such as tip, b"):
        cell_from_urdf(tmp_path / "b.urdf", out=tmp_path)


def test_a_joint_that_follows_another_behind_the_tip_is_no_matter(tmp_path: Path) -> None:
    finger = '<link name="f"/><joint name="g" type="revolute"><parent link="tip"/><child link="f"/><mimic joint="j1"/></joint>'
    (tmp_path / "a.urdf").write_text(ARM.replace("</robot>", f"{finger}</robot>"))
    assert cell_from_urdf(tmp_path / "a.urdf", tip="tip", out=tmp_path).summary.axes == ("A1",)
