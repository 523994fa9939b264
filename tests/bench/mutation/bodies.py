"""Do bodies of the cell run into each other? Points on one body's surface against the other's signed distance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mutation import arm
from mutation.replay import Move
from mutation.story import Story

Array = NDArray[np.float64]

DEEP_MM = 2.0  # a body this far inside another one touches it, whatever the points on it are
IN_AIR_MM = 1.0  # likewise for the tool in the part on a move through air
_FRAMES = ("E2", "E1", "A1", "A2", "A3", "A4", "A5", "A6")


@dataclass(frozen=True, eq=False)
class Body:
    """A primitive in a frame: size in mm as cell.toml has it."""

    name: str
    group: str
    frame: str
    kind: str
    size: tuple[float, ...]
    at: Array
    ignore: frozenset[str]

    def depth(self, points: Array) -> Array:
        """How deep points (..., 3) in the body's own frame lie in it, mm; outside negative, and nearer than they are."""
        x, y, z = points[..., 0], points[..., 1], points[..., 2]
        if self.kind == "box":
            a, b, c = (s / 2.0 for s in self.size)
            return np.asarray(np.minimum(np.minimum(a - np.abs(x), b - np.abs(y)), c - np.abs(z)))
        if self.kind == "cylinder":
            return np.asarray(np.minimum(self.size[0] - np.hypot(x, y), self.size[1] / 2.0 - np.abs(z)))
        half = self.size[1] / 2.0 if self.kind == "capsule" else 0.0
        z = z - np.clip(z, -half, half)
        return np.asarray(self.size[0] - np.sqrt(x * x + y * y + z * z))

    @cached_property
    def surface(self) -> Array:
        """Points (N, 3) on the body, in its own frame: no more than about 40 mm apart where that is a few hundred."""
        if self.kind == "box":
            half = np.array(self.size) / 2.0
            steps = [np.linspace(-h, h, int(np.clip(2 * h / 40.0, 2, 12)) + 1) for h in half]
            grid = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
            return np.asarray(grid[(np.abs(np.abs(grid) - half) < 1e-9).any(axis=1)])
        half = self.size[1] / 2.0 if self.kind != "sphere" else 0.0
        ring = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
        heights = np.linspace(-half, half, int(np.clip(2 * half / 30.0, 2, 12)) + 1)
        around = [
            np.stack([self.size[0] * np.cos(ring), self.size[0] * np.sin(ring), np.full(16, z)], 1) for z in heights
        ]
        inner = [
            np.stack([f * self.size[0] * np.cos(ring), f * self.size[0] * np.sin(ring), np.full(16, z)], 1)
            for f in (0.0, 0.5)
            for z in (-half, half)
            if self.kind == "cylinder"
        ]
        poles = (
            [] if self.kind == "cylinder" else [np.array([[0, 0, half + self.size[0]], [0, 0, -half - self.size[0]]])]
        )
        return np.concatenate([*around, *inner, *poles])


@dataclass(frozen=True)
class Bodies:
    """The cell's bodies (in the cell.toml's words), the part as a box in base or None."""

    bodies: tuple[Body, ...]

    def touching(self, moves: Sequence[Move], cutting: Sequence[bool], story: Story) -> list[tuple[str, str]]:
        """The first pair of bodies of which one is inside the other."""
        axes = np.concatenate([m.axes for m in moves])
        cuts = np.concatenate([np.full(len(m.axes), c) for m, c in zip(moves, cutting, strict=True)])
        tips = np.concatenate([m.base_T_tip for m in moves])
        poses = self._poses(axes, tips)
        for i, a in enumerate(self.bodies):
            for b in self.bodies[i + 1 :]:
                if a.group == b.group or a.group in b.ignore or b.group in a.ignore:
                    if not {a.group, b.group} == {"tool", "part"}:
                        continue
                where = np.ones(len(axes), bool)
                allowed = DEEP_MM
                if {a.group, b.group} == {"tool", "part"}:
                    where, allowed = (
                        ~_near_cut(
                            cuts,
                            tips,
                            max(a.size[0] if a.group == "tool" else 0.0, b.size[0] if b.group == "tool" else 0.0),
                        ),
                        IN_AIR_MM,
                    )
                depth = _depth(a, b, poses[a.name][where], poses[b.name][where])
                if depth > allowed:
                    return [("collision", f"{a.name} is {depth:.1f} mm in {b.name}")]
        return []

    def _poses(self, axes: Array, tips: Array) -> Mapping[str, Array]:
        chain = arm.links(axes)
        zero = np.zeros(len(axes))
        world = arm.base_T_root(zero, axes[:, 7]) @ arm.inverse(arm.base_T_root(zero, zero))
        frames = dict(zip(_FRAMES, chain, strict=True))
        frames |= {
            "base": np.broadcast_to(np.eye(4), world.shape),
            "world": world,
            "tool": tips,
            "root": arm.base_T_root(axes[:, 6], axes[:, 7]),
            "flange": chain[-1] @ arm.rx(180.0),
        }
        return {b.name: frames[b.frame] @ b.at for b in self.bodies}


def _near_cut(cuts: NDArray[np.bool_], tips: Array, radius: float) -> NDArray[np.bool_]:
    """Samples that cut, or lie within three radii of a place that is cut."""
    places = tips[cuts][:, :3, 3]
    if not len(places):
        return cuts
    gap = np.linalg.norm(tips[:, None, :3, 3] - places[None], axis=2).min(axis=1)
    return np.asarray(cuts | (gap <= 3.0 * radius + 12.0))


def _depth(a: Body, b: Body, at_a: Array, at_b: Array) -> float:
    """How deep one is in the other over all samples, mm."""
    deepest = -np.inf
    for inner, at_inner, outer, at_outer in ((a, at_a, b, at_b), (b, at_b, a, at_a)):
        turned = np.swapaxes(at_outer[:, :3, :3], 1, 2)
        middle = (turned @ (at_inner[:, :3, 3] - at_outer[:, :3, 3])[..., None])[..., 0]
        near = outer.depth(middle) > -float(np.linalg.norm(inner.surface, axis=1).max())
        if near.any():
            rotation = turned[near] @ at_inner[near, :3, :3]
            points = inner.surface @ np.swapaxes(rotation, 1, 2) + middle[near, None]
            deepest = max(deepest, float(outer.depth(points).max()))
    return float(deepest)


def read_bodies(cell: Mapping[str, Any], tool: tuple[float, float] | None, part: Body | None) -> Bodies:
    """The bodies of a cell.toml's tables; a tool of (diameter, length) mm takes the place of the cell's own."""
    out = []
    for shape in cell["shape"]:
        size, at = tuple(map(float, shape["size_mm"])), arm.frame(tuple(map(float, shape["at"])))
        if shape["group"] == "tool" and tool is not None:
            size, at = (tool[0] / 2.0, tool[1]), arm.shift(0.0, 0.0, tool[1] / 2.0)
        out.append(
            Body(
                shape["name"],
                shape["group"],
                shape["frame"],
                shape["kind"],
                size,
                at,
                frozenset(shape.get("ignore", ())),
            )
        )
    return Bodies((*out, *((part,) if part is not None else ())))
