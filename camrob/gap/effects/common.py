"""What several effects share: names of axes, constant errors, which axes move, what was looked for once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.load import PointMass
from camrob.dynamics.gravity import gravity_arrays, gravity_torques
from camrob.gap.effects.effect import Column, EffectParameter
from camrob.gap.observation.scene import Scene
from camrob.se3 import inverse
from camrob.units import deg_to_rad, mm_to_m

__all__ = [
    "ANGLE",
    "LENGTH",
    "PLACES",
    "PPM",
    "TOOL_ANGLE",
    "arm_axes",
    "constant",
    "found_once",
    "moved",
    "place_parameters",
    "pushed_along",
    "reach_moments",
    "shows",
    "tool_mass",
    "under_even_kilogram",
    "under_flange_kilogram",
    "under_force",
    "under_kilogram",
]

Array = NDArray[np.float64]
Found = TypeVar("Found")

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


def found_once(scenes: Sequence[Scene], what: tuple[str, ...], search: Callable[[], Found]) -> Found:
    """What a search of all these logs finds, made once. The first keeps it, and the others with it: their ids stay their own."""
    known, key = scenes[0].found, (*what, *map(id, scenes))
    if key not in known:
        known[key] = tuple(scenes[1:]), search()
    found: Found = known[key][1]
    return found


def shows(scenes: Sequence[Scene], axis: str) -> bool:
    """True where the axis's own errors reach the measured frame."""
    return all(f"{axis}.zero" in s.places for s in scenes)


def tool_mass(cell: Cell) -> PointMass:
    """The heaviest of the masses behind the arm's last mass: what the arm carries."""
    return max((m for m in cell.masses if m.after == cell.masses[-1].after), key=lambda m: m.mass)


def under_kilogram(scene: Scene, at: Array) -> tuple[Column, ...]:
    """How each arm axis gives way, by 1 rad/Nm, to a kilogram more at a place (3,) of what carries the tool."""
    return _under(scene, [PointMass("one", tool_mass(scene.cell).after, 1.0, at)])


def under_flange_kilogram(scene: Scene) -> tuple[Column, ...]:
    """The same of a kilogram on the mounting plate, of a cell whose masses nobody knows."""
    after, plate = _link_middles(scene.cell)[-1][0], np.asarray(scene.cell.wrist_T_flange)[:3, 3]
    return _under(scene, [PointMass("one", after, 1.0, plate)])


def under_even_kilogram(scene: Scene) -> tuple[Column, ...]:
    """The same of a kilogram spread over the arm's links by their lengths: of an arm whose masses nobody knows, only this much
    is sure, that what is long weighs more than what is short.
    """
    links = _link_middles(scene.cell)
    total = sum(length for _, _, length in links) or 1.0
    return _under(scene, [PointMass(after, after, length / total, middle) for after, middle, length in links])


def _link_middles(cell: Cell) -> list[tuple[str, Array, float]]:
    """By axis of the arm: its name; the middle (3,) of its link, in the frame where its row ends; the link's length; m."""
    arm = [j for j in cell.joints if j.role is Role.ARM]
    ends = [*(np.asarray(j.before) for j in arm[1:]), np.asarray(cell.wrist_T_flange)]
    # a link runs from its axis to the next one's; its row ends somewhere between
    begins = [inverse(np.asarray(j.after))[:3, 3] for j in arm]
    return [
        (j.name, 0.5 * (begin + end[:3, 3]), float(np.linalg.norm(end[:3, 3] - begin)))
        for j, begin, end in zip(arm, begins, ends, strict=True)
    ]


def _under(scene: Scene, loads: Sequence[PointMass]) -> tuple[Column, ...]:
    cell = scene.cell
    values = scene.log.axes(scene.axes) if scene.encoder is not None else scene.log.setpoints(scene.axes)
    torque = gravity_torques(gravity_arrays(cell, loads), cell.to_q(values))
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
