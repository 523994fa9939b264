"""Stretches of the arm's links that no body covers: no collision is seen there. A copied cell with longer links has such."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from camrob.bodies.bodies import Body, cell_bodies
from camrob.cell.cell import Cell
from camrob.cell.shape import ShapeKind
from camrob.kinematics.frames import base_T_joint_axes, base_T_joint_frames, base_T_root
from camrob.se3 import inverse
from camrob.units import m_to_mm

__all__ = ["BareLink", "bare_links"]

Array = NDArray[np.float64]

_BARE = 0.025  # m of a link without a body that are worth a word: bodies are rounded to that
_NEAR = 0.010  # m within which a body of a neighbour covers a place
_STEP = 0.002  # m between the places that are looked at


@dataclass(frozen=True, slots=True)
class BareLink:
    """The way of `length` m between two axes of the arm has no body on `bare` m of it; `body` is the nearest."""

    first: str
    second: str
    length: float
    bare: float
    body: str
    group: str

    @property
    def text(self) -> str:
        """In one line."""
        bare, length = (f"{m_to_mm(v):.0f} mm" for v in (self.bare, self.length))
        return (
            f"{bare} of the {length} from {self.first} to {self.second} have no body, so that no collision is seen there: "
            f"{self.body!r} ({self.group}) is too short by so much"
        )


def bare_links(cell: Cell) -> tuple[BareLink, ...]:
    """What the arm's bodies, together, leave bare between one axis and the next, at HOME.

    A body covers as much of its own link as it is long along it, however far beside it, and what a place of a neighbour's lies
    in or by. Links that nothing is drawn of are not looked at.
    """
    arm = range(*cell.arm_slice.indices(len(cell)))
    bodies = [
        body for body in cell_bodies(cell) if body.shape is not None and body.shape.frame not in ("world", "base")
    ]
    frames, axes = base_T_joint_frames(cell, cell.q_home), base_T_joint_axes(cell, cell.q_home)
    names = [*(cell.names[i] for i in arm), "the plate"]
    found = []
    for n, i in enumerate(arm):
        own = [body for body in bodies if body.link in (i - 1, i)]
        if not own:
            continue
        begin = frames[i - 1] if i else np.asarray(cell.base_T_first)
        foot = (
            begin if n else base_T_root(cell, np.asarray(cell.q_home))
        )  # a row may begin far from the foot, on its axis
        corners = [foot[:3, 3], axes[i][:3, 3], frames[i][:3, 3]]
        corners[1] = corners[1] + axes[i][:3, 2] * (
            (corners[2] - corners[1]) @ axes[i][:3, 2]
        )  # where the axis is left
        near = [body for body in bodies if abs(body.link - i) <= 1]
        stretches = [
            _uncovered(a, b, own if k == 0 else [v for v in own if v.link == i], near, frames, begin, i)
            for k, (a, b) in enumerate(pairwise(corners))
        ]
        places = np.concatenate(stretches)
        if len(places) * _STEP > _BARE:
            at = places[len(places) // 2]
            body = min(own, key=lambda v: float(_outside(v, _local(v, at[None], frames, begin, i))[0]))
            length = sum(float(np.linalg.norm(b - a)) for a, b in pairwise(corners))
            found.append(BareLink(names[n], names[n + 1], length, len(places) * _STEP, body.name, body.group))
    return tuple(found)


def _uncovered(a: Array, b: Array, own: list[Body], near: list[Body], frames: Array, begin: Array, i: int) -> Array:
    """Places (K, 3) of the way from a to b that no body covers."""
    length = float(np.linalg.norm(b - a))
    if length < _STEP:
        return np.zeros((0, 3))
    way = (b - a) / length
    s = np.arange(0.5 * _STEP, length, _STEP)
    places = a + s[:, None] * way
    bare = np.ones(len(s), np.bool_)
    for body in own:
        pose = _pose(body, frames, begin, i)
        middle, half = _extent(body, pose[:3, :3].T @ way)
        at = float((pose[:3, 3] - a) @ way) + middle
        bare &= np.abs(s - at) > half
    for body in near:
        bare &= _outside(body, _local(body, places, frames, begin, i)) > _NEAR
    return np.asarray(places[bare])


def _pose(body: Body, frames: Array, begin: Array, i: int) -> Array:
    """Of a body in `base`; `begin`: the frame behind which the link of joint i begins."""
    return np.asarray((begin if body.link == i - 1 else frames[body.link]) @ body.link_T_body)


def _local(body: Body, places: Array, frames: Array, begin: Array, i: int) -> Array:
    body_T_base = inverse(_pose(body, frames, begin, i))
    return np.asarray(places @ body_T_base[:3, :3].T + body_T_base[:3, 3])


def _box(body: Body) -> tuple[Array, Array]:
    """The middle and half the size of the box about a body, in its frame."""
    if body.triangles is not None:
        low, high = body.triangles.reshape(-1, 3).min(axis=0), body.triangles.reshape(-1, 3).max(axis=0)
        return 0.5 * (low + high), 0.5 * (high - low)
    if body.shape is None:
        raise ValueError(f"{body.name} has neither triangles nor a shape")
    kind, size = body.shape.kind, body.shape.size
    if kind is ShapeKind.BOX:
        return np.zeros(3), 0.5 * np.asarray(size)
    radius = float(size[0])
    long = {ShapeKind.SPHERE: radius, ShapeKind.CYLINDER: 0.5 * float(size[-1])}.get(
        kind, 0.5 * float(size[-1]) + radius
    )
    return np.zeros(3), np.array([radius, radius, long])


def _extent(body: Body, way: Array) -> tuple[float, float]:
    """The middle of a body along a direction of its frame, and half of how long it is there: as of the box about it."""
    middle, half = _box(body)
    return float(middle @ way), float(half @ np.abs(way))


def _outside(body: Body, places: Array) -> Array:
    """How far places (K, 3) of a body's frame lie outside the box about it, m."""
    middle, half = _box(body)
    return np.asarray(np.linalg.norm(np.maximum(np.abs(places - middle) - half, 0.0), axis=1))
