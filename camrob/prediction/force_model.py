"""The force on a tool while it cuts: stated outright, or from coefficients of the material and how much of the tool is engaged.

A tooth takes a chip of thickness h = c cos(theta), c the feed a tooth, theta its angle from the feed's direction, and is pushed
by K_t h + K_te a metre of its edge against its motion, by K_r h + K_re inward, by K_a h + K_ae along the tool (Altintas,
Manufacturing Automation, 2nd ed., 2012, section 2.4: linear edge model). The machine answers the mean over a turn; what a tooth
does within one is vibration, and no part of this.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError

__all__ = ["CuttingForce", "CuttingForces", "Milling", "Stated"]

Array = NDArray[np.float64]

_ANGLES = 1440  # of a turn, at which teeth are looked at: the mean is then within 1e-5 of itself
_WIDTHS = 129  # widths of a table, between which it is straight


@dataclass(frozen=True)
class Milling:
    """A mechanistic model, SI. chip, edge: (3,) coefficients tangential, radial, axial, N/m2 and N/m; teeth; diameter: m; rate:
    turns a second.

    side: +1 where the material lies to the left of the feed, seen from the holder, -1 to its right, 0 on both sides. sense: +1
    for a spindle that turns clockwise, seen from the holder, -1 for the other way. depth, width: m of the tool engaged along
    its axis and across the feed, NaN where the removal is to say it. material: whose coefficients they are, "" where that isn't
    told.
    """

    chip: Array
    edge: Array
    teeth: int
    diameter: float
    rate: float
    side: int
    sense: int
    depth: float
    width: float
    material: str = ""

    @property
    def asks_removal(self) -> bool:
        """Whether depth or width is left to the removal."""
        return not np.isfinite(self.depth + self.width)

    @property
    def words(self) -> str:
        """In words."""
        whose = f"from the coefficients of {self.material}" if self.material else "from the material's coefficients"
        return whose + (", the engagement from the removal" if self.asks_removal else "")

    def per_depth(self, width: Array) -> tuple[Array, Array]:
        """Mean force (K, 3) along, across and axial for widths (K,) m: N for each m of depth and m of feed a tooth, N for each
        m of depth.
        """
        theta = 2.0 * np.pi * (np.arange(_ANGLES) + 0.5) / _ANGLES
        r = np.stack([np.cos(theta), np.sin(theta), np.zeros(_ANGLES)], axis=1)
        v = np.stack([np.sin(theta), -np.cos(theta), np.zeros(_ANGLES)], axis=1) * self.sense
        z = np.array([0.0, 0.0, 1.0])
        way = np.stack([-v, -r, np.broadcast_to(z, v.shape)], axis=1)
        R = 0.5 * self.diameter
        reach = np.clip(np.asarray(width, float), 0.0, self.diameter)[:, None] / R
        off = np.sin(theta) * self.side
        engaged = off >= 1.0 - reach if self.side else np.abs(np.sin(theta)) <= 0.5 * reach
        engaged = engaged & (np.cos(theta) > 0.0)
        share = self.teeth / _ANGLES * engaged.astype(float)
        chip = np.einsum("ka,a,aci,c->ki", share, np.cos(theta), way, self.chip)
        edge = np.einsum("ka,aci,c->ki", share, way, self.edge)
        return chip, edge

    def mean(self, feed: Array, area: Array | None = None) -> Array:
        """(N, 3) N at feeds (N,) m/s; area: (N,) m2 that is cut across the feed, for what depth and width don't say."""
        taken = np.zeros(len(feed)) if area is None else np.asarray(area, float)
        depth, width = np.full(len(feed), self.depth), np.full(len(feed), self.width)
        if not np.isfinite(self.depth):
            width = width if np.isfinite(self.width) else np.full(len(feed), self.diameter)
            depth = taken / width
        elif not np.isfinite(self.width):
            width = np.clip(taken / self.depth, 0.0, self.diameter)
        grid = np.linspace(0.0, self.diameter, _WIDTHS)
        chip, edge = self.per_depth(grid)
        tooth = np.asarray(feed, float) / (self.rate * self.teeth)
        parts = [np.stack([np.interp(width, grid, part[:, i]) for i in range(3)], axis=1) for part in (chip, edge)]
        pushing = (depth > 0.0) & (tooth > 0.0)
        return np.asarray((parts[0] * tooth[:, None] + parts[1]) * np.where(pushing, depth, 0.0)[:, None])


@dataclass(frozen=True)
class Stated:
    """A force that is given outright: (3,) N along the feed, across it (to its left, seen from the holder) and along the tool
    to the holder.
    """

    newton: Array
    asks_removal: bool = False

    def mean(self, feed: Array, area: Array | None = None) -> Array:
        """(N, 3) N at feeds (N,) m/s; zeros where the tool stands."""
        return np.where(np.asarray(feed)[:, None] > 0.0, self.newton, 0.0)

    @property
    def words(self) -> str:
        """In words."""
        along, across, axial = self.newton
        return f"{along:.0f} N along the feed, {across:.0f} N across it, {axial:.0f} N along the tool"


@dataclass(frozen=True)
class CuttingForce:
    """What pushes on one tool. doubt: share of the force by which it may be wrong, one standard deviation. give: (2,) m/N that
    tool and holder yield across and along the tool. path: FORCE.toml.
    """

    path: Path
    model: Stated | Milling
    doubt: float
    give: Array

    @property
    def asks_removal(self) -> bool:
        """Whether it takes the removal to know how much of the tool is engaged."""
        return self.model.asks_removal

    @property
    def words(self) -> str:
        """In words."""
        return self.model.words

    def mean(self, feed: Array, area: Array | None = None) -> Array:
        """(N, 3) N along, across and axial at feeds (N,) m/s, areas (N,) m2 being cut; zeros where the tool stands."""
        return self.model.mean(feed, area)

    def in_base(self, base_T_tool: Array, t: Array, area: Array | None = None) -> Array:
        """(N, 3) N in `base` along a run (N, 4, 4) with times (N,) s; area: (N,) m2 that is cut across the feed on the way to
        each row. Of forces along and across the feed there is the share of the feed that goes across the tool: in a plunge a
        tooth cuts all round, and they cancel out.
        """
        tip, z = base_T_tool[:, :3, 3], base_T_tool[:, :3, 2]
        rate = np.gradient(tip, t, axis=0)
        x = rate - np.sum(rate * z, axis=1, keepdims=True) * z
        speed = np.linalg.norm(rate, axis=1)
        x /= np.maximum(speed, _STANDS)[:, None]
        along, across, axial = self.mean(np.where(speed > _STANDS, speed, 0.0), area).T[:, :, None]
        return np.asarray(along * x + across * np.cross(z, x) + axial * z)


@dataclass(frozen=True)
class CuttingForces:
    """FORCE.toml. by_number: what pushes on the set-up's tools, by their numbers; with the key None on the only one. fastest:
    m/s, motions that are programmed faster cut nothing.
    """

    path: Path
    by_number: Mapping[int | None, CuttingForce]
    fastest: float = float("inf")

    @property
    def asks_removal(self) -> bool:
        """Whether it takes the removal to know how much of a tool is engaged."""
        return any(force.asks_removal for force in self.by_number.values())

    @property
    def names_tools(self) -> bool:
        """Whether it goes by the numbers that a set-up gives its tools."""
        return None not in self.by_number

    @property
    def asks_setup(self) -> bool:
        """Whether it takes a set-up: to know what is removed, or which tool has which number."""
        return self.asks_removal or self.names_tools

    def on(self, numbers: Sequence[int | None], program: str) -> tuple[CuttingForce, ...]:
        """What pushes on each of a program's tools, by the numbers that its set-up gives them.

        Raises InputError where the file speaks of one tool and the program has several, or not of one that it has.
        """
        if not self.names_tools:
            if len(numbers) > 1:
                what = f"says what pushes on one tool, and {program} sets {len(numbers)}"
                hint = "give a [[tool]] for each, with the number that it has in the set-up and its [tool.mean] or [tool.milling]"
                raise InputError(what, hint=hint, path=self.path)
            return (self.by_number[None],)
        for number in numbers:
            if number not in self.by_number:
                named = "a tool without a number" if number is None else f"tool {number}"
                known = ", ".join(str(n) for n in self.by_number)
                what = f"speaks of tool {known}, and {program} cuts with {named}"
                raise InputError(
                    what, hint="add its [[tool]], with the number that it has in the set-up", path=self.path
                )
        return tuple(self.by_number[number] for number in numbers)


_STANDS = 1e-5  # m/s: a tool that moves no faster stands
