"""What several effects share: names of axes, constant errors, which axes move."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.load import PointMass
from camrob.dynamics.gravity import gravity_arrays, gravity_torques
from camrob.gap.effects.effect import Column, EffectParameter
from camrob.gap.observation.scene import Scene
from camrob.units import deg_to_rad, mm_to_m

__all__ = [
    "ANGLE",
    "LENGTH",
    "PLACES",
    "PPM",
    "TOOL_ANGLE",
    "arm_axes",
    "constant",
    "moved",
    "place_parameters",
    "pushed_along",
    "reach_moments",
    "shows",
    "tool_mass",
    "under_force",
    "under_kilogram",
]

Array = NDArray[np.float64]

PLACES = ("x", "y", "z", "rx", "ry", "rz")
PPM = 1e6
"""Parts of a million in one."""
LENGTH, ANGLE, TOOL_ANGLE = mm_to_m(0.6), deg_to_rad(0.04), deg_to_rad(0.06)
"""Ordinary sizes of a misplaced frame, an axis's zero and a tool's angle: wide priors, of what a probe and a dial gauge leave."""
_MOST = 20.0  # times the ordinary size: no longer plausible
_STILL = 1e-4  # rad or m: an axis that moves less stands


def arm_axes(cell: Cell) -> tuple[str, ...]:
    """Names of the arm's axes."""
    return tuple(j.name for j in cell.joints if j.role is Role.ARM)


def place_parameters(parts: Iterable[str], length: float, angle: float) -> tuple[EffectParameter, ...]:
    """Parameters of displacements x, y, z and turns rx, ry, rz, whatever stands before these letters."""
    out = []
    for part in parts:
        turn = part.rpartition("_")[2].startswith("r")
        usual, unit = (angle, "deg") if turn else (length, "mm")
        out.append(EffectParameter(f"{part}_{unit}", unit, usual, -_MOST * usual, _MOST * usual))
    return tuple(out)


def constant(scene: Scene, terms: Iterable[str]) -> tuple[Column, ...]:
    """Columns of constant errors."""
    return tuple(Column(tcp=scene.place(term)) for term in terms)


def moved(scenes: Sequence[Scene], axis: str) -> bool:
    """True where an axis moves in any of the logs."""
    return any(float(np.ptp(s.link[:, s.index(axis)])) > _STILL for s in scenes)


def shows(scenes: Sequence[Scene], axis: str) -> bool:
    """True where the axis's own errors reach the measured frame."""
    return all(f"{axis}.zero" in s.places for s in scenes)


def tool_mass(cell: Cell) -> PointMass:
    """The heaviest of the masses behind the arm's last mass: what the arm carries."""
    return max((m for m in cell.masses if m.after == cell.masses[-1].after), key=lambda m: m.mass)


def under_kilogram(scene: Scene, at: Array) -> tuple[Column, ...]:
    """How each arm axis gives way, by 1 rad/Nm, to a kilogram more at a place (3,) of what carries the tool."""
    cell = scene.cell
    values = scene.log.axes(scene.axes) if scene.encoder is not None else scene.log.setpoints(scene.axes)
    one = PointMass("one", tool_mass(cell).after, 1.0, at)
    torque = gravity_torques(gravity_arrays(cell, [one]), cell.to_q(values))
    axes = [(a, cell.index(a)) for a in arm_axes(cell)]
    return tuple(Column(tcp=scene.shift(a, cell.joints[i].sign * torque[:, i])) for a, i in axes)


def under_force(scene: Scene) -> tuple[tuple[Column, ...], tuple[Column, ...]]:
    """How each arm axis gives way, by 1 rad/Nm, to the logged force on the tool, and the tip along x, y, z of `world`, by 1 m/N;
    none where no force was logged.
    """
    if scene.force is None:
        return (), ()
    force = np.einsum("nij,nj->ni", scene.measured_R_world, scene.force)
    arms = [scene.place(f"{a}.zero") for a in arm_axes(scene.cell)]
    axes = tuple(Column(tcp=arm * np.sum(arm[:, :3] * force, axis=1)[:, None]) for arm in arms)
    return axes, pushed_along(scene.measured_R_world, force)


def pushed_along(turned: Array, force: Array) -> tuple[Column, ...]:
    """How a tip gives way along the columns of `turned` (N, 3, 3), by 1 m/N, to a force (N, 3); both in the measured frame."""
    columns = []
    for k in range(3):
        twist = np.zeros((len(force), 6))
        twist[:, :3] = turned[:, :, k] * np.sum(turned[:, :, k] * force, axis=1)[:, None]
        columns.append(Column(tcp=twist))
    return tuple(columns)


def reach_moments(scene: Scene) -> Array:
    """(N, 2) what a unit of weight at the TCP would make about x and y of `root` at the robot's foot, m."""
    turned = scene.place("root.rz")[:, :3]
    return np.stack([np.sum(turned * scene.place(f"root.{p}")[:, :3], axis=1) for p in "xy"], axis=1)
