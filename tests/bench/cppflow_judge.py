"""What a plan of CppFlow's problems is worth, by Pinocchio and Coal alone: nothing here is camrob's.

Scored as theirs (cppflow/config.py, evaluation_utils.py): a plan is valid where at all its waypoints the end is within 0.1 mm and
0.1 degrees of its pose, all joints within their limits, no two bodies touch, and no joint goes farther than 7 degrees or 2 cm
from one waypoint to the next. Capsules and pairs are theirs; camrob's bodies are made from the same numbers by other code.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
from cppflow_problems import Problem, model_of

__all__ = ["Verdict", "judge"]

_POSITION, _ANGLE = 1e-4, np.radians(0.1)  # m, rad: SUCCESS_THRESHOLD_translation_ERR_MAX_MM, _rotation_ERR_MAX_DEG
_STEP, _SLIDE = np.radians(7.0), 0.02  # rad, m: SUCCESS_THRESHOLD_mjac_DEG, _mjac_CM


@dataclass(frozen=True)
class Verdict:
    """position, angle: the largest errors, m and rad; past: how far a joint is past its limit, m or rad; step, slide: the largest
    steps; length, slid: their sums; own, obstacles: the least distances of bodies among each other and from obstacles, m
    (inf: none).
    """

    position: float
    angle: float
    past: float
    step: float
    slide: float
    length: float
    slid: float
    own: float
    obstacles: float

    @property
    def solved(self) -> bool:
        """Whether all of it holds."""
        near = self.position < _POSITION and self.angle < _ANGLE and self.past <= 0.0
        return bool(near and self.step < _STEP and self.slide < _SLIDE and min(self.own, self.obstacles) > 0.0)


def judge(problem: Problem, q: np.ndarray, shared: Path) -> Verdict:
    """The verdict on postures q (T, n), in the order of the robot's joints. Angles are compared modulo a turn, as theirs are."""
    model = model_of(problem.robot, shared)
    data = model.createData()
    order = [model.getJointId(name) for name in problem.robot.joints]
    tip = model.getFrameId(problem.robot.tip)
    slides = np.array(["P" in model.joints[j].shortname() for j in order])
    solids = {}
    for link, (*ends, radius) in problem.robot.capsules.items():
        a, b = np.array(ends[:3], float), np.array(ends[3:], float)
        turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), b - a).toRotationMatrix()
        solids[link] = (coal.Capsule(radius, float(np.linalg.norm(b - a))), pin.SE3(turn, 0.5 * (a + b)))
    worst = np.zeros(3)
    own = obstacles = np.inf
    for k, posture in enumerate(q):
        whole = pin.neutral(model)
        for value, j in zip(posture, order, strict=True):
            joint = model.joints[j]
            if joint.nq == 2:
                whole[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
            else:
                whole[joint.idx_q] = value
                low, high = model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]
                worst[2] = max(worst[2], low - value, value - high)
        pin.framesForwardKinematics(model, data, whole)
        want = pin.SE3(problem.world_T_tip[k, :3, :3], problem.world_T_tip[k, :3, 3])
        off = want.actInv(data.oMf[tip])
        worst[0] = max(worst[0], np.linalg.norm(off.translation))
        worst[1] = max(worst[1], np.linalg.norm(pin.log3(off.rotation)))
        stand = {link: data.oMf[model.getFrameId(link)] * at for link, (_, at) in solids.items()}
        for a, b in problem.robot.pairs:
            own = min(own, _distance(solids[a][0], stand[a], solids[b][0], stand[b]))
        for box in problem.boxes:
            at = pin.SE3(np.eye(3), box.center)
            for link, (solid, _) in solids.items():
                if model.frames[model.getFrameId(link)].parentJoint:
                    obstacles = min(obstacles, _distance(solid, stand[link], coal.Box(*box.size), at))
    step = np.abs(np.diff(q, axis=0))
    step[:, ~slides] = np.abs((np.diff(q, axis=0)[:, ~slides] + np.pi) % (2.0 * np.pi) - np.pi)
    turned, slid = step[:, ~slides], step[:, slides]
    return Verdict(*worst, turned.max(), slid.max(initial=0.0), turned.sum(), slid.sum(), own, obstacles)


def _distance(a: coal.CollisionGeometry, world_T_a: pin.SE3, b: coal.CollisionGeometry, world_T_b: pin.SE3) -> float:
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    A = coal.Transform3s(world_T_a.rotation, world_T_a.translation)
    B = coal.Transform3s(world_T_b.rotation, world_T_b.translation)
    return float(coal.distance(a, A, b, B, request, result))
