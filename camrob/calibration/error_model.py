"""The one model of a cell's errors: measured poses from axis values and named parameters, with analytic derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.error_kernel import (
    BASE,
    JOINT,
    JOINT_SLOTS,
    MOTION,
    ROOT,
    TOOL,
    Displacements,
    ModelArrays,
    poses_and_twists,
)
from camrob.calibration.terms import ErrorTerm, TermKind, term_of
from camrob.cell.cell import Cell
from camrob.cell.joint import Joint, Role
from camrob.cell.world import world_T_floor
from camrob.dynamics.gravity import GravityArrays, gravity_arrays, gravity_stiffness, gravity_torques
from camrob.errors import LogError
from camrob.se3 import inverse, left_jacobian, rotation_exp

__all__ = ["ErrorModel"]

Array = NDArray[np.float64]
Quantities = Mapping[str, Array]


@dataclass(frozen=True)
class ErrorModel:
    """A cell's chain with error parameters; `terms` give their order. Make it with `of`.

    Poses are those of the target in the measured frame: left @ world_T_tool @ right, or left @ base_T_tool @ right
    where the poses are measured in the turning `base`. The virtual roll is at 0.
    """

    cell: Cell
    terms: tuple[ErrorTerm, ...]
    in_base: bool
    arrays: ModelArrays
    gravity: GravityArrays

    @classmethod
    def of(
        cls,
        cell: Cell,
        names: Sequence[str],
        *,
        in_base: bool = False,
        left: Array | None = None,
        right: Array | None = None,
    ) -> ErrorModel:
        """The model with parameters of these names (see `terms`).

        in_base: poses are seen from `base`, which turns with the table. left, right (4, 4): the instrument's frame
        and the reflector, where they are not `world` and the tip. Raises LogError for an unknown name or one that is
        there twice.
        """
        if len(set(names)) < len(names):
            twice = next(n for n in names if names.count(n) > 1)
            raise LogError(f"the parameter {twice} appears twice", hint="name it once")
        terms = tuple(term_of(cell, name) for name in names)
        return cls(cell, terms, in_base, _arrays(cell, in_base, left, right), gravity_arrays(cell))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(t.name for t in self.terms)

    def poses(self, values: Array, q: Array, quantities: Quantities | None = None) -> Array:
        """Target poses (N, 4, 4) of postures q (N, n), with the parameters' values (P,), SI.

        quantities: (N,) each, those that terms `by.NAME` name.
        """
        return self._evaluate(values, q, quantities or {}, np.zeros(0, np.int64), np.zeros(0, np.int64))[0]

    def poses_and_jacobian(self, values: Array, q: Array, quantities: Quantities | None = None) -> tuple[Array, Array]:
        """Poses (N, 4, 4) and their derivatives (N, 6, P).

        A column holds (v, w), the velocity of the target's origin and the turn of the target in the axes of the
        measured frame, a unit of the parameter. Torques are those of the reported posture. About 3 microseconds a row
        and 40 parameters.
        """
        slots = np.array([t.slot for t in self.terms], np.int64)
        motions = [k for k, t in enumerate(self.terms) if t.kind is not TermKind.PLACE]
        factor_of = np.full(len(self.terms), -1, np.int64)
        factor_of[motions] = np.arange(len(motions))
        return self._evaluate(values, q, quantities or {}, slots, factor_of)

    def poses_and_arm_jacobian(
        self, values: Array, q: Array, quantities: Quantities | None = None, *, slope: Array | None = None
    ) -> tuple[Array, Array]:
        """Poses (N, 4, 4) and their derivatives by the arm's q (N, 6, 6), those of compliance and gears included.

        slope: an `arm_slope` of postures near by, which costs half of the whole, to be taken instead of a new one.
        """
        part = self.cell.arm_slice
        slots = np.array([JOINT + JOINT_SLOTS * i + MOTION for i in range(part.start, part.stop)], np.int64)
        poses, J = self._evaluate(values, q, quantities or {}, slots, np.full(len(slots), -1, np.int64))
        return poses, J + J @ (self.arm_slope(values, q) if slope is None else slope)

    def _evaluate(
        self, values: Array, q: Array, given: Quantities, slots: NDArray[np.int64], factor_of: NDArray[np.int64]
    ) -> tuple[Array, Array]:
        q = np.ascontiguousarray(q, np.float64)
        values = np.asarray(values, float)
        factors = self._factors(q, given)
        real = q + self._shifts(values, factors, q)
        real = np.ascontiguousarray(real[:, : len(self.arrays.prismatic)])  # without the virtual roll
        displacements = self._displacements(values, factors)
        poses, J = poses_and_twists(self.arrays, displacements, real, slots, factors, factor_of)
        return np.asarray(poses), np.asarray(J)

    def _factors(self, q: Array, given: Quantities) -> Array:
        """What each term that is no mere place is multiplied by (N, M), in the order of the terms."""
        moving = [t for t in self.terms if t.kind is not TermKind.PLACE]
        out = np.empty((len(q), len(moving)))
        torque = gravity_torques(self.gravity, q) if any(t.kind is TermKind.COMPLIANCE for t in moving) else np.zeros(0)
        for k, term in enumerate(moving):
            out[:, k] = torque[:, term.joint] if term.kind is TermKind.COMPLIANCE else self._factor(term, q, given)
        return out

    def _factor(self, term: ErrorTerm, q: Array, given: Quantities) -> Array:
        """The factor (N,) of one term other than compliance, in the chain's sign."""
        if term.kind is TermKind.BY:
            factor = self._quantity(term, q, given)
            return factor if term.joint < 0 else self.cell.joints[term.joint].sign * factor
        joint = self.cell.joints[term.joint]
        axis = joint.axis_value(q[:, term.joint])
        if term.kind is TermKind.ZERO:
            return np.full(len(q), joint.sign)
        if term.kind is TermKind.SCALE:
            return joint.sign * axis
        wave = np.cos if term.kind is TermKind.COS else np.sin
        return np.asarray(joint.sign * wave(term.order * axis))

    def _quantity(self, term: ErrorTerm, q: Array, given: Quantities) -> Array:
        """What a term `by.NAME` is proportional to: one of the caller's quantities, or another axis's value."""
        if term.by in given:
            return np.asarray(given[term.by], float)
        if term.by in self.cell.axis_names:
            other = self.cell.index(term.by)
            return self.cell.joints[other].axis_value(q[:, other])
        raise LogError(f"{term.name} needs a quantity {term.by!r}", hint="give it with the postures")

    def _shifts(self, values: Array, factors: Array, q: Array) -> Array:
        """By how much the joints really stand beyond q (N, n), SI."""
        moving = [k for k, t in enumerate(self.terms) if t.kind is not TermKind.PLACE]
        out = np.zeros_like(np.asarray(q, float))
        for column, k in enumerate(moving):
            if self.terms[k].joint >= 0 and values[k] != 0.0:
                out[:, self.terms[k].joint] += values[k] * factors[:, column]
        return out

    def arm_slope(self, values: Array, q: Array) -> Array:
        """How the arm's shifts, by compliance and gears, change with its q (N, 6, 6)."""
        values = np.asarray(values, float)
        part = self.cell.arm_slice
        out = np.zeros((len(q), 6, 6))
        stiffness: Array | None = None
        for value, term in zip(values, self.terms, strict=True):
            row = term.joint - part.start
            if value == 0.0 or row < 0 or term.kind in (TermKind.PLACE, TermKind.ZERO):
                continue
            joint = self.cell.joints[term.joint]
            axis = joint.axis_value(q[:, term.joint])
            if term.kind is TermKind.COMPLIANCE:
                if stiffness is None:
                    stiffness = gravity_stiffness(self.gravity, np.asarray(q, float))
                out[:, row] += value * stiffness[:, term.joint, part]
            elif term.kind is TermKind.SCALE:
                out[:, row, row] += value
            elif term.kind is TermKind.COS:
                out[:, row, row] -= value * term.order * np.sin(term.order * axis)
            elif term.kind is TermKind.SIN:
                out[:, row, row] += value * term.order * np.cos(term.order * axis)
            elif term.by in self.cell.axis_names and self.cell.index(term.by) >= part.start:
                other = self.cell.index(term.by)
                out[:, row, other - part.start] += value * joint.sign * self.cell.joints[other].sign
        return out

    def _displacements(self, values: Array, factors: Array) -> Displacements:
        """The places' values as rigid motions."""
        count = len(self.arrays.prismatic)
        slots = np.zeros(JOINT + JOINT_SLOTS * count)
        moved = np.zeros(count, np.bool_)
        root = np.zeros((0, 6))
        column = 0
        for value, term in zip(values, self.terms, strict=True):
            if term.kind is TermKind.PLACE:
                slots[term.slot] = value
                if term.joint >= 0:
                    moved[term.joint] = True
            else:
                if ROOT <= term.slot < JOINT:
                    root = np.zeros((len(factors), 6)) if len(root) == 0 else root
                    root[:, term.slot - ROOT] += value * factors[:, column]
                column += 1
        joints = slots[JOINT:].reshape(count, JOINT_SLOTS)[:, :6]
        base, base_J = _motion(slots[BASE : BASE + 6])
        tool, tool_J = _motion(slots[TOOL : TOOL + 6])
        return Displacements(base, base_J, tool, tool_J, *_motion(joints), moved, root)


def _motion(parts: Array) -> tuple[Array, Array]:
    """Trans(x, y, z) exp(rx, ry, rz) (..., 4, 4), and the left Jacobian (..., 3, 3) of exp, of parts (..., 6)."""
    w = parts[..., 3:]
    T = np.zeros((*parts.shape[:-1], 4, 4))
    T[..., :3, :3] = rotation_exp(w)
    T[..., :3, 3] = parts[..., :3]
    T[..., 3, 3] = 1.0
    return T, left_jacobian(w)


def _arrays(cell: Cell, in_base: bool, left: Array | None, right: Array | None) -> ModelArrays:
    """The chain's constant part, the virtual roll at 0."""
    joints: list[Joint] = [j for j in cell.joints if j.role is not Role.ROLL]
    rolls = [j for j in cell.joints if j.role is Role.ROLL]
    workpiece = len(cell.indices(Role.WORKPIECE))
    last = cell.wrist_T_flange @ cell.flange_T_tool
    for joint in rolls:
        last = last @ joint.before @ joint.after
    before = np.stack([np.asarray(j.before) for j in joints])
    if workpiece:
        before[0] = cell.base_T_first @ before[0]
    floor = world_T_floor(cell)
    return ModelArrays(
        left=np.eye(4) if left is None else np.ascontiguousarray(left, float),
        start=0 if in_base else workpiece,
        workpiece=workpiece,
        arm=cell.indices(Role.ARM)[0],
        floor=np.array(floor),  # a copy: frozen arrays would be compiled for separately
        floor_inverse=np.array(inverse(floor)),
        root=np.ascontiguousarray(cell.foot_T_root),
        root_inverse=np.ascontiguousarray(inverse(np.asarray(cell.foot_T_root))),
        before=before,
        after=np.stack([np.asarray(j.after) for j in joints]),
        last=np.ascontiguousarray(last),
        right=np.eye(4) if right is None else np.ascontiguousarray(right, float),
        prismatic=np.array([j.prismatic for j in joints]),
        zero=np.array([float(j.q_value(np.zeros(()))) for j in joints]),
    )
