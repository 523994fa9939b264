"""What tips: a link in worn rollers, by its axis's place; one whose bearing clears, or a tool that is loose, by its weight.

An axis in a bad bearing is off about every direction at once, and what it carries with it: of one direction at a time that looks
like two or three axes, each by the angle of the first.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.dynamics.gravity import GRAVITY
from camrob.gap.effects.common import arm_axes
from camrob.gap.evidence.design import Panel
from camrob.kinematics.frames import base_T_joint_axes, base_T_joint_frames, world_T_base

__all__ = ["tipping", "tool_by_weight"]

Array = NDArray[np.float64]
_Rows = Sequence[NDArray[np.int64]]

_STILL = 0.05  # rad: an axis that moves less wears nothing
_BENDS = 8  # powers of an axis's place: worn rollers come by more than once a turn
_WAYS = ("rx", "ry", "zero")
_HARDLY = 0.1  # of the largest moment, which a bearing with clearance needs to tip
_OVER = 0.15  # of a part's largest weight, by which it tips over to one side


def tipping(panels: Sequence[Panel], rows: _Rows) -> Iterator[tuple[str, str, Array, Array]]:
    """Axes of the arm that turn: what moves, what it follows, levers (N, 3, L), shape (N, d)."""
    scene = panels[0].scene
    for a in arm_axes(scene.cell):
        if any(f"{a}.{way}" not in p.scene.places for way in _WAYS for p in panels):
            continue
        if scene.cell.joints[scene.cell.index(a)].prismatic:
            continue
        levers = np.stack([_of(panels, rows, f"{a}.{way}") for way in _WAYS], axis=2)
        at = np.concatenate([p.scene.link[r, p.scene.index(a)] for p, r in zip(panels, rows, strict=True)])
        if np.ptp(at) > _STILL:
            x = 2.0 * (at - at.min()) / np.ptp(at) - 1.0
            yield a, "position", levers, np.asarray(np.polynomial.legendre.legvander(x, _BENDS))
        moment = np.concatenate([_moment(p, r, a) for p, r in zip(panels, rows, strict=True)])
        if np.ptp(moment, axis=0).max() > 0.0:
            far = np.linalg.norm(moment, axis=1, keepdims=True)
            aside = moment / (far + _HARDLY * far.max())  # within its clearance, to the side to which it is pulled
            yield a, "load", levers[:, :, :2], np.concatenate([np.ones_like(far), moment / far.max(), aside], axis=1)


def tool_by_weight(panels: Sequence[Panel], rows: _Rows, turn: Array) -> tuple[Array, Array]:
    """Levers (N, 3, 3) and shape (N, d) of a tool that hangs otherwise by which of its sides is below. turn: (N, 3, 3) of it in
    the measured frame.
    """
    up = np.concatenate([p.scene.measured_R_world[r][..., 2] for p, r in zip(panels, rows, strict=True)])
    return turn, _leaning(np.einsum("nji,nj->ni", turn, up))


def _leaning(pull: Array) -> Array:
    """(N, 1 + 2 d) a constant, what pulls (N, d), and the side to which it does."""
    pull = pull / np.abs(pull).max()
    return np.concatenate([np.ones((len(pull), 1)), pull, np.tanh(pull / _OVER)], axis=1)


def _of(panels: Sequence[Panel], rows: _Rows, term: str) -> Array:
    """(N, 3) m a unit of a constant error."""
    return np.concatenate([p.scene.place(term)[r, :3] for p, r in zip(panels, rows, strict=True)])


def _moment(panel: Panel, rows: NDArray[np.int64], axis: str) -> Array:
    """(n, 2) Nm of all weight behind an axis about x and y of the frame that it turns in, where the axis begins: its link hangs
    there. Of a kilogram at the mounting plate where the cell says no masses.
    """
    scene = panel.scene
    cell, q, k = scene.cell, scene.postures(scene.link[rows]), scene.cell.index(axis)
    ends, at = base_T_joint_frames(cell, q), base_T_joint_axes(cell, q)[k]
    along, begins = at[:, :3, 2], ends[k - 1][:, :3, 3] if k else np.asarray(cell.base_T_first)[:3, 3]
    held = at[:, :3, 3] + np.sum((begins - at[:, :3, 3]) * along, axis=1, keepdims=True) * along
    down = -np.asarray(world_T_base(cell, q))[:, 2, :3]
    last = cell.index(arm_axes(cell)[-1])
    loads = [(m.mass, cell.index(m.after), m.center) for m in cell.masses] or [(1.0, last, np.zeros(3))]
    total = np.zeros((len(rows), 3))
    for mass, after, center in loads:
        if after >= k:
            place = ends[after] @ np.append(center, 1.0)
            total += mass * GRAVITY * np.cross(place[:, :3] - held, down)
    return np.asarray(np.einsum("nji,nj->ni", at[:, :3, :3], total)[:, :2])
