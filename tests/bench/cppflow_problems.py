"""CppFlow's planning problems: their files read, and each made into a cell of camrob with its bodies and obstacles."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
import yaml
from cppflow_robots import ROBOTS, Robot

from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.se3 import rotation_to_abc
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["NAMES", "Box", "Problem", "build_cell", "model_of", "read_problem"]

NAMES = tuple(
    f"{robot}__{path}"
    for robot, paths in (
        ("fetch_arm", "circle hello rot_yz2 s square"),
        ("fetch", "circle hello rot_yz2 s square"),
        ("panda", "1cube 2cubes flappy_bird"),
    )
    for path in paths.split()
)


@dataclass(frozen=True)
class Box:
    """Full lengths size (3,), about center (3,), m; axes are the world's, as all the problems' are."""

    size: np.ndarray
    center: np.ndarray


@dataclass(frozen=True)
class Problem:
    """world_T_tip (T, 4, 4): the poses that the robot's end is to take, in the frame of the URDF's root."""

    name: str
    robot: Robot
    world_T_tip: np.ndarray
    boxes: tuple[Box, ...]


def model_of(robot: Robot, shared: Path) -> pin.Model:
    """Pinocchio's model of the robot's URDF, all but its own joints held at 0."""
    model = pin.buildModelFromUrdf(str(shared / "urdf" / robot.urdf))
    locked = [i for i, name in enumerate(model.names) if i and name not in robot.joints]
    return pin.buildReducedModel(model, locked, pin.neutral(model))


def read_problem(name: str, shared: Path) -> Problem:
    """A problem of ../shared/benchmarks/cppflow. The path's offset is from a frame of the robot at joints 0, as theirs is."""
    told = yaml.safe_load((shared / "cppflow" / "problems" / f"{name}.yaml").read_text())
    robot = ROBOTS[told["robot"]]
    with open(shared / "cppflow" / "paths" / f"{told['path_name']}.csv") as file:
        rows = np.array([[float(x) for x in row[1:]] for row in list(csv.reader(file))[1:]])
    if not np.array_equal(np.array(told["path_R_offset"], float), np.eye(3)):
        raise ValueError("the path is turned: none of the problems' is")
    offset = np.array(told["path_xyz_offset"], float)
    if told["path_offset_frame"] != "world":
        model = pin.buildModelFromUrdf(str(shared / "urdf" / robot.urdf))
        data = model.createData()
        pin.framesForwardKinematics(model, data, pin.neutral(model))
        frame = data.oMf[model.getFrameId(told["path_offset_frame"])]
        np.testing.assert_allclose(frame.rotation, np.eye(3), atol=1e-9)
        offset = offset + frame.translation
    poses = np.tile(np.eye(4), (len(rows), 1, 1))
    poses[:, :3, 3] = rows[:, :3] + offset
    for k, (w, x, y, z) in enumerate(rows[:, 3:] / np.linalg.norm(rows[:, 3:], axis=1)[:, None]):
        poses[k, :3, :3] = pin.Quaternion(w, x, y, z).toRotationMatrix()
    boxes = []
    for one in told.get("obstacles", []):
        known = {key: float(value) for part in one for key, value in part.items()}
        center = np.array([known[k] for k in "xyz"]) + np.array(told["obstacle_xyz_offset"], float)
        boxes.append(Box(np.array([known[f"size_{k}"] for k in "xyz"]), center))
    return Problem(name, robot, poses, tuple(boxes))


def _held(text: str, joints: tuple[str, ...]) -> str:
    """The URDF with some joints fixed."""
    for joint in joints:
        text, count = re.subn(rf'(<joint name="{joint}" type=)"\w+"', r'\1"fixed"', text)
        if count != 1:
            raise ValueError(f"{joint} stands {count} times in the URDF")
    return text


def build_cell(problem: Problem, shared: Path, folder: Path) -> Cell:
    """A cell's folder of the problem: the URDF, capsules on its links, the obstacles. The root's frame is the cell's `base`."""
    robot = problem.robot
    folder.mkdir(parents=True)
    (folder / "robot.urdf").write_text(_held((shared / "urdf" / robot.urdf).read_text(), robot.fixed))
    lines = ["schema = 1", f'name = "{problem.name}"', 'standing = "datasheet"', "", "[arm]", 'urdf = "robot.urdf"']
    lines += [f'tip = "{robot.tip}"', ""]
    names = ["E1"] * ("torso_lift_joint" in robot.joints)
    names += [f"A{k + 1}" for k in range(len(robot.joints) - len(names))]
    model = model_of(robot, shared)
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    joint_of = dict(zip(robot.joints, names, strict=True))
    for link, numbers in robot.capsules.items():
        frame = model.frames[model.getFrameId(link)]
        parent = frame.parentJoint
        # the frame of the moving link that the capsule's link is fixed to: Pinocchio's joint frames are URDF's link frames
        on = joint_of[model.names[parent]] if parent else "base"
        ends = [frame.placement.act(np.array(numbers[k : k + 3], float)) for k in (0, 3)]
        others = [set(p) for p in robot.pairs]
        ignored = [o for o in robot.capsules if o != link and {o, link} not in others]
        if not parent and problem.boxes:
            ignored.append("obstacles")
        lines += _shape(
            link, link, on, "capsule", [numbers[6], np.linalg.norm(ends[1] - ends[0])], _along(*ends), ignored
        )
    for k, box in enumerate(problem.boxes):
        at = np.concatenate([m_to_mm(box.center), np.zeros(3)])
        lines += _shape(f"box{k + 1}", "obstacles", "base", "box", list(box.size), at, [])
    (folder / "cell.toml").write_text("\n".join(lines) + "\n")
    return read_cell(folder)


def _shape(
    name: str, group: str, frame: str, kind: str, size: list[float], at: np.ndarray, ignore: list[str]
) -> list[str]:
    mm = [max(1e-3, float(m_to_mm(s))) for s in size]
    lines = ["[[shape]]", f'name = "{name}"', f'group = "{group}"', f'frame = "{frame}"', f'kind = "{kind}"']
    lines += [f"size_mm = {mm}", f"at = {[float(v) for v in at]}", f"ignore = {json.dumps(ignore)}", ""]
    return lines


def _along(first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """X, Y, Z, A, B, C, mm and degrees, of a frame half way between two points whose z goes from one to the other."""
    z = last - first
    length = np.linalg.norm(z)
    z = np.array([0.0, 0.0, 1.0]) if length < 1e-6 else z / length
    x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
    x /= np.linalg.norm(x)
    R = np.stack([x, np.cross(z, x), z], axis=1)
    return np.concatenate([m_to_mm(0.5 * (first + last)), rad_to_deg(rotation_to_abc(R))])
