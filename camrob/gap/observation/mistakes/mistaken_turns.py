"""Orientations that can't be this cell's, tried for what is wrong: units, their order, the way round, a constant turn."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from camrob.gap.observation.scene import Scene
from camrob.measurement.log import ORIENTATION
from camrob.se3 import abc_to_rotation, rotation_exp, rotation_log
from camrob.units import deg_to_rad, rad_to_deg

__all__ = ["mistaken_turns"]

Array = NDArray[np.float64]

_LEFT = 0.1  # of the angle that is left where a mistake is corrected, at the most
_X, _Y, _Z = np.eye(3)


def mistaken_turns(scene: Scene) -> str:
    """What was mixed up in a log's a, b, c, in words, "" where nothing that was tried mends it. Each is tried once, alone.

    scene: a log whose tool is turned by degrees from where the axis values put it.
    """
    rows = np.flatnonzero(scene.seen[:, 3:].all(axis=1))
    told = scene.log.matrix(ORIENTATION)[rows]
    nominal = scene.nominal[rows, :3, :3]
    whole = _size(nominal, scene.measured[rows, :3, :3])
    left = [
        (_size(nominal, R), words) for words, R in (*_written(told), *_turned(nominal, scene.measured[rows, :3, :3]))
    ]
    best, words = min(left)
    if best > _LEFT * whole:
        return ""
    return f"{words}: corrected so, the tool is turned by {rad_to_deg(best):.2g} degrees (median)"


def _size(nominal: Array, measured: Array) -> float:
    """rad, the median angle between rotations (N, 3, 3)."""
    return float(np.median(np.linalg.norm(rotation_log(measured @ nominal.swapaxes(1, 2)), axis=1)))


def _written(told: Array) -> Iterator[tuple[str, Array]]:
    """Each mistake of writing in words, and the rotations as if it had not been made. told: a, b, c as they stand."""
    angles = deg_to_rad(told)
    about_z, about_y, about_x = (rotation_exp(angles[:, k, None] * axis) for k, axis in enumerate((_Z, _Y, _X)))
    yield "its a, b, c are in radians", abc_to_rotation(told)
    yield "its a and c are exchanged (a turns about z, c about x)", abc_to_rotation(angles[:, ::-1])
    first, second, third = (rotation_exp(angles[:, k, None] * axis) for k, axis in enumerate((_X, _Y, _Z)))
    xyz = 'its a, b, c turn about x, y, z in this order (orientation = { as = "xyz", .. } in [table] of its .toml)'
    yield xyz, first @ second @ third
    yield (
        "its a, b, c turn about fixed axes z, y, x in this order, not about the turned ones",
        about_x @ about_y @ about_z,
    )
    rotvec = 'its a, b, c are a rotation vector, in {} (orientation = {{ as = "rotvec", .. }} in [table] of its .toml)'
    yield rotvec.format("degrees"), rotation_exp(angles)
    yield rotvec.format("radians"), rotation_exp(told)
    yield "its a, b, c are those of the world in the tool", abc_to_rotation(angles).swapaxes(1, 2)


def _turned(nominal: Array, measured: Array) -> Iterator[tuple[str, Array]]:
    """A turn that is the same in all rows, of the tool and of the measured frame, taken off."""
    for apart, tool in ((nominal.swapaxes(1, 2) @ measured, True), (measured @ nominal.swapaxes(1, 2), False)):
        U, _, Vt = np.linalg.svd(apart.mean(axis=0))
        turn = U @ np.diag([1.0, 1.0, float(np.sign(np.linalg.det(U @ Vt)))]) @ Vt
        angle = rad_to_deg(rotation_log(turn[None])[0])
        by = f"({angle[0]:.1f}, {angle[1]:.1f}, {angle[2]:.1f}) degrees about x, y, z in all rows"
        if tool:
            yield f"the tool that was measured is turned from the cell's by {by}", measured @ turn.T
        else:
            yield f"the measured frame is turned from the one that its .toml names by {by}", turn.T @ measured
