"""What the drives' torques or currents tell of a load that nobody counted, beside friction and inertia."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Role
from camrob.cell.load import PointMass
from camrob.dynamics.gravity import gravity_arrays, gravity_torques
from camrob.gap.observation.scene import Scene
from camrob.summaries.diagnosis_places import AddedLoad, LoadByAxis

__all__ = ["load_from_drives"]

Array = NDArray[np.float64]

_REST = 0.02  # of an axis's ordinary speed: slower is at rest
_SHOWS = 0.02  # of the torque of the cell's own masses: what a kilogram's varies by at the least, for it to tell
_RIDGE = 1e-10
_UNITS = {"T": "Nm", "I": "A"}  # what may be logged, the better first
_LAGS = 40  # samples over which what is left may hang together


def load_from_drives(scenes: Sequence[Scene]) -> AddedLoad | None:
    """The added mass at the plate, kg, with its standard error, by the torques T1 .. (else currents I1 ..) of all logs that have
    them; None where none has, or the cell says no masses, or no axis shows it.

    An axis's torque is gravity's of the known masses and of the added one, dry and viscous friction, inertia and a constant; of
    a current, all that times the motor's unknown factor. `axes`: by axis the dry friction (half its swing) in the unit of
    what was logged, and the mass by that axis alone.
    """
    cell = scenes[0].cell
    arm = [j.name for j in cell.joints if j.role is Role.ARM]
    for kind in _UNITS:
        logged = [(s, v) for s in scenes if (v := s.log.beside(kind, arm)) is not None and not s.poses]
        if logged and cell.masses:
            break
    else:
        return None
    found = {a: one for k, a in enumerate(arm) if (one := _axis(logged, a, k, known=kind == "T")) is not None}
    if not found:
        return None
    mass, std = np.array([one.mass for one in found.values()]), np.array([one.std for one in found.values()])
    weight = 1.0 / np.maximum(std, 1e-9) ** 2
    joint = float(np.sum(weight * mass) / weight.sum())
    # axes that contradict each other know less than each believes
    spread = float(np.sum(weight * (mass - joint) ** 2)) / max(len(mass) - 1, 1)
    std_joint = float(np.sqrt(max(spread, 1.0) / weight.sum()))
    by_axis = {a: LoadByAxis(mass_kg=o.mass, std=o.std, friction=o.dry, unit=_UNITS[kind]) for a, o in found.items()}
    return AddedLoad(source="torques" if kind == "T" else "currents", mass_kg=joint, std=std_joint, axes=by_axis)


@dataclass(frozen=True)
class _ByAxis:
    """What one axis tells: the mass and its standard error, kg, and dry friction in the unit of what was logged."""

    mass: float
    std: float
    dry: float


def _axis(logged: Sequence[tuple[Scene, Array]], axis: str, k: int, *, known: bool) -> _ByAxis | None:
    """One axis; None where it doesn't tell. known: the factor of what was logged is 1 or -1."""
    own, kilogram, further, y = (
        np.concatenate(x) for x in zip(*(_rows(s, v, axis, k) for s, v in logged), strict=True)
    )
    if float(kilogram.std()) < _SHOWS * float(own.std()) or float(own.std()) <= 0.0:
        return None
    X = np.concatenate([own[:, None], kilogram[:, None], further], axis=1)
    solved, cov = _fit(X, y)
    if known:
        # of torques only the sign is free: which way the controller counts them
        sign = 1.0 if solved[0] >= 0.0 else -1.0
        solved, cov = _fit(X[:, 1:], y - sign * own)
        return _ByAxis(sign * float(solved[0]), float(np.sqrt(cov[0, 0])), abs(float(solved[1])))
    factor = float(solved[0])
    slope = np.array([-solved[1] / factor**2, 1.0 / factor])
    std = float(np.sqrt(max(slope @ cov[:2, :2] @ slope, 0.0)))
    return _ByAxis(float(solved[1]) / factor, std, abs(float(solved[2])))


def _rows(scene: Scene, values: Array, axis: str, k: int) -> tuple[Array, Array, Array, Array]:
    """Gravity's torque of the cell's own masses and of a kilogram at the plate (N,), friction, inertia and constant (N, 4); what
    was logged (N,). Rows without a value are left out.
    """
    cell, j = scene.cell, scene.index(axis)
    q = cell.to_q(scene.log.axes(scene.axes) if scene.encoder is not None else scene.log.setpoints(scene.axes))
    last = [joint.name for joint in cell.joints if joint.role is Role.ARM][-1]
    one = gravity_torques(gravity_arrays(cell, [PointMass("one", last, 1.0, np.zeros(3))]), q)[:, cell.index(axis)]
    v, a = (scene.velocity(scene.link[:, [j]], order)[:, 0] for order in (1, 2))
    moving = np.abs(v[np.abs(v) > 0.0])
    dry = np.tanh(v / max(_REST * float(np.median(moving)) if len(moving) else 1.0, 1e-12))
    known = np.isfinite(values[:, k])
    further = np.stack([dry, v, a, np.ones(len(v))], axis=1)[known]
    sign = cell.joints[cell.index(axis)].sign
    return scene.torque[known, j], sign * one[known], further, values[known, k]


def _fit(X: Array, y: Array) -> tuple[Array, Array]:
    """Least squares, and their covariance where residuals hang together over samples."""
    size = np.maximum(np.linalg.norm(X, axis=0), 1e-300)
    Z = X / size
    inverse = np.linalg.inv(Z.T @ Z + _RIDGE * np.eye(Z.shape[1]))
    solved = inverse @ (Z.T @ y)
    left = y - Z @ solved
    energy = float(left @ left)
    lagged = sum(float(left[n:] @ left[:-n]) for n in range(1, min(_LAGS, len(left) - 1)))
    variance = max(energy + 2.0 * max(lagged, 0.0), 1e-30) / max(len(y) - X.shape[1], 1)
    return solved / size, variance * inverse / np.outer(size, size)
