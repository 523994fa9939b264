"""Which closed form an arm's six screw axes have, found from the axes alone, and tried before it is believed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.kinematics.screw_arm import OFFSET, PARALLEL, WRIST, ScrewArm, solve_screws_many
from camrob.kinematics.spherical_wrist import BRANCH_OK
from camrob.se3 import inverse

__all__ = ["screw_arm", "screw_displacement"]

Array = NDArray[np.float64]

_NEAR = (1e-9, 0.02)  # m and rad within which axes meet or are parallel: as drawn, and of an arm that was calibrated
_TRIED = 24  # postures that the closed form has to give back
_GIVEN_BACK = 1e-6  # rad
_CONTINUED = 0.8  # share of them that an arm has to give back which misses its family
_LEAST_SINE = 0.1  # between neighbours of three axes that meet, for a wrist that reaches


def screw_displacement(h: Array, o: Array, q: Array) -> Array:
    """Displacements (..., 4, 4) of postures q (..., n) about axes h, o (n, 3), angle by angle (Rodrigues)."""
    q = np.asarray(q, float)
    out = np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4)).copy()
    for i in range(len(h)):
        x, y, z = h[i]
        K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        step = np.broadcast_to(np.eye(4), out.shape).copy()
        s, c = np.sin(q[..., i])[..., None, None], np.cos(q[..., i])[..., None, None]
        step[..., :3, :3] = np.eye(3) + s * K + (1.0 - c) * (K @ K)
        step[..., :3, 3] = o[i] - step[..., :3, :3] @ o[i]
        out = out @ step
    return out


def screw_arm(h: Array, o: Array, foot_T_tool: Array) -> ScrewArm | None:
    """The closed form of the arm with axes h, o (6, 3) and its tool at foot_T_tool (4, 4), all at q = 0; None where it has none.

    An arm that misses a family by up to 0.02 m and rad (calibrated, or built so) has the postures of the arm that doesn't miss
    it, continued to its own by Newton's method; where one is lost so, at the border of what the arm reaches, it is not found.
    A family is only believed once it has given back each of two dozen postures that it was asked for; one that is continued
    so or searched, most of them.
    """
    tool_T_foot = np.ascontiguousarray(inverse(np.asarray(foot_T_tool, float)))
    h, o = np.array(h, float), np.array(o, float)
    for families in ((WRIST, PARALLEL), (OFFSET,)):
        for near in _NEAR:
            for mirrored in (False, True):
                axes, points = (-h[::-1].copy(), o[::-1].copy()) if mirrored else (h, o)
                for family in families:
                    drawn = _met(family, axes, points, near)
                    if drawn is None:
                        continue
                    arm = ScrewArm(family, mirrored, *drawn, axes.copy(), points.copy(), tool_T_foot)
                    if _gives_back(arm, h, o, np.asarray(foot_T_tool, float)):
                        return arm
    return None


def _met(family: int, h: Array, o: Array, near: float) -> tuple[Array, Array] | None:
    """The axes that belong to the family and lie nearest to h, o; None where they lie farther off than `near`."""
    h, o = h.copy(), o.copy()
    if family == PARALLEL:
        mean = h[1] + np.sign(h[2] @ h[1]) * h[2] + np.sign(h[3] @ h[1]) * h[3]
        mean /= np.linalg.norm(mean)
        for i in (1, 2, 3):
            if np.linalg.norm(np.cross(mean, h[i])) > near:
                return None
            h[i] = np.sign(h[i] @ mean) * mean
        return h, o
    if family == OFFSET:
        across = np.cross(h[3], h[4])
        sine = np.linalg.norm(across)
        if sine < _LEAST_SINE or abs(across @ (o[4] - o[3])) > near * sine:
            return None
        o[4] -= (across @ (o[4] - o[3])) / (sine * sine) * across
        return h, o
    across = np.eye(3) - h[3:, :, None] * h[3:, None, :]
    if min(np.linalg.norm(np.cross(h[3], h[4])), np.linalg.norm(np.cross(h[4], h[5]))) < _LEAST_SINE:
        return None
    meet = np.linalg.solve(across.sum(axis=0), np.einsum("kij,kj->i", across, o[3:]))
    if np.max(np.linalg.norm(np.cross(h[3:], meet - o[3:]), axis=1)) > near:
        return None
    o[3:] = meet
    return (h, o) if near == _NEAR[0] else _squared(h, o, near)


def _squared(h: Array, o: Array, near: float) -> tuple[Array, Array]:
    """The first three axes drawn to the nearest arm whose second and third are parallel, where they nearly are."""
    if np.linalg.norm(np.cross(h[1], h[2])) < near:
        mean = h[1] + np.sign(h[2] @ h[1]) * h[2]
        h[2] = np.sign(h[2] @ h[1]) * mean / np.linalg.norm(mean)
        h[1] = np.sign(h[2] @ h[1]) * h[2]
    return h, o


def _gives_back(arm: ScrewArm, h: Array, o: Array, foot_T_tool: Array) -> bool:
    """Whether the closed form gives back postures spread over all angles."""
    angles = np.random.default_rng(7).uniform(-np.pi, np.pi, (_TRIED, 6))
    poses = np.ascontiguousarray(screw_displacement(h, o, angles) @ foot_T_tool)
    Q, why = solve_screws_many(arm, poses, angles)
    off = np.where(why == BRANCH_OK, np.abs(Q - angles[:, None]).max(axis=2), np.inf).min(axis=1)
    exact = arm.family != OFFSET and np.array_equal(arm.h, arm.true_h) and np.allclose(arm.o, arm.true_o)
    return bool(np.all(off < _GIVEN_BACK)) if exact else bool(np.mean(off < _GIVEN_BACK) > _CONTINUED)
