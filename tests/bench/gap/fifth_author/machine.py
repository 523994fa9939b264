"""A machine of either family: a chain that may hang or stand askew, what it carries, how stiff it is; and its folder."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from gap.second_author.chain import Body, Robot, Row

__all__ = ["Machine", "arm", "carrying", "grown", "rail_axes"]


@dataclass
class Machine(Robot):
    """A robot whose last body is its payload.

    stiffness: Nm/rad of the arm's axes, by class. size: half the way in m that a test of it moves the tool.
    rated: kg. metal: growth of its links, 1/K. foot: Nm/rad of what it stands on.
    """

    stiffness: tuple[float, ...] = ()
    size: float = 0.15
    rated: float = 5.0
    metal: float = 11.5e-6
    foot: float = 5e6

    def _toml(self):
        told = super()._toml()
        if self.carriage or np.allclose(self.base, np.eye(4)):
            return told
        numbers = [*(self.base[:3, 3] * 1e3), *Rotation.from_matrix(self.base[:3, :3]).as_euler("ZYX", degrees=True)]
        head = ["[kinematics]", "base_follows_table = false", "characteristic_length_mm = 500"]
        head += ["base_to_first = [" + ", ".join(f"{x:.6f}" for x in numbers) + "]"]
        head += [f"{k} = [0, 0, 0, 0, 0, 0]" for k in ("foot_to_root", "wrist_to_flange")]
        head += ['standing = "datasheet"', ""]
        return told.replace("[arm]", "\n".join(head) + "\n[arm]", 1)

    def write(self, folder):
        """The cell's folder; the poses are said to be this author's."""
        super().write(folder)
        path = folder / "poses.csv"
        path.write_text(path.read_text().replace("the second author's", "the fifth author's"))


def arm(numbers, ranges, speeds, signs=(1, 1, 1, 1, 1, 1)):
    """Rows of an arm from (alpha, a, theta, d), ranges and speeds as a data sheet has them."""
    each = zip(numbers, ranges, speeds, signs, strict=False)
    return [
        Row(f"A{k + 1}", al, a, th, d, sign=sign, low=low, high=high, speed=speed)
        for k, ((al, a, th, d), (low, high), speed, sign) in enumerate(each)
    ]


def carrying(machine, mass):
    """The same machine with another payload at the same place, which the log tells."""
    *others, last = machine.bodies
    return replace(machine, bodies=[*others, replace(last, mass=float(mass))], payload=float(mass))


def pull(run, mass, centre):
    """Gravity's torque (N, n) in the controller's sign of a mass (kg) at the flange, its centre in mm."""
    extra = (Body(run.robot.names[-1], mass, tuple(centre)),)
    return (run.robot.moments(run.c, extra)[:, :, 2] - run.moments[:, :, 2]) * run.robot.signs


def grown(row):
    """Where a row's link leads, in the frame in which it ends, m: what grows when it is warm."""
    alpha = np.radians(row.alpha)
    along = np.array([row.a, row.d * np.sin(alpha), row.d * np.cos(alpha)])
    return along / 1e3


def rail_axes(robot):
    """Along, aside, up of a carriage, in the frame in which its row ends; of a lift up is a side of its post."""
    i = robot.carriage[-1]
    alpha = np.radians(robot.rows[i].alpha)
    along = np.array([0.0, np.sin(alpha), np.cos(alpha)])
    end = robot.frames(np.array(robot.home) * robot.unit)[1][i][0, :3, :3]
    up = end.T @ np.array([0.0, 0.0, 1.0])
    if abs(up @ along) > 0.9:
        up = np.array([1.0, 0.0, 0.0])
    return along, np.cross(along, up), up
