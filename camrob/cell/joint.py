"""One joint of a cell's chain, with how the controller prints it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

__all__ = ["Joint", "Role", "dh_after", "dh_before"]

Array = NDArray[np.float64]
Value = TypeVar("Value", float, NDArray[np.float64])


class Role(StrEnum):
    """What a joint moves, in the chain's order from workpiece to tool."""

    WORKPIECE = "workpiece"  # the part: rotary table, positioner
    CARRIAGE = "carriage"  # the robot's foot: track, gantry
    ARM = "arm"
    ROLL = "roll"  # virtual: the tool's own symmetry axis


@dataclass(frozen=True, slots=True)
class Joint:
    """A revolute or prismatic joint; SI throughout (rad or m; per second).

    The chain's variable q relates to the axis value that the controller prints by `axis = sign * q + offset`. `lower`
    and `upper` limit the axis value (-inf, inf for an endless or virtual joint). `home` and `reference` are values
    of q.
    `before` (4, 4) stands before the motion along or about z, `after` (4, 4) behind it. Both hold the constants of its
    Denavit-Hartenberg row: Rz(theta) Tz(d), then Tx(a) Rx(alpha).
    """

    name: str
    role: Role
    prismatic: bool
    before: Array
    after: Array
    sign: float = 1.0
    offset: float = 0.0
    lower: float = -np.inf
    upper: float = np.inf
    speed: float = np.inf
    acceleration: float = np.inf
    jerk: float = np.inf
    home: float = 0.0
    reference: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "before", locked(self.before, shape=(4, 4), name="before"))
        object.__setattr__(self, "after", locked(self.after, shape=(4, 4), name="after"))

    @property
    def endless(self) -> bool:
        """True where the axis has no limit."""
        return not np.isfinite(self.lower) and not np.isfinite(self.upper)

    @property
    def q_lower(self) -> float:
        """Lower limit of q."""
        return min(self.sign * (self.lower - self.offset), self.sign * (self.upper - self.offset))

    @property
    def q_upper(self) -> float:
        """Upper limit of q."""
        return max(self.sign * (self.lower - self.offset), self.sign * (self.upper - self.offset))

    def axis_value(self, q: Array) -> Array:
        """Axis values, as the controller counts them (SI), of q."""
        return self.sign * q + self.offset

    def q_value(self, axis_value: Array) -> Array:
        """The chain's q of axis values (SI)."""
        return self.sign * (axis_value - self.offset)

    @property
    def unit(self) -> str:
        """The trade's unit of its values as keys and columns end: "mm" or "deg"."""
        return "mm" if self.prismatic else "deg"

    @property
    def unit_word(self) -> str:
        """The trade's unit of its values as a sentence has it: "mm" or "degrees"."""
        return "mm" if self.prismatic else "degrees"

    def to_edge(self, value: Value) -> Value:
        """mm or degrees of a value of this joint in m or rad, be it a place, a way or a speed."""
        return m_to_mm(value) if self.prismatic else rad_to_deg(value)

    def from_edge(self, value: Value) -> Value:
        """m or rad of a value of this joint in mm or degrees."""
        return mm_to_m(value) if self.prismatic else deg_to_rad(value)

    def motion(self, q: Array) -> Array:
        """The joint's own motion (..., 4, 4) along or about its z, of q (...)."""
        T = np.zeros((*np.shape(q), 4, 4))
        T[..., 3, 3] = T[..., 2, 2] = 1.0
        if self.prismatic:
            T[..., 0, 0] = T[..., 1, 1] = 1.0
            T[..., 2, 3] = q
        else:
            T[..., 0, 0] = T[..., 1, 1] = np.cos(q)
            T[..., 1, 0] = np.sin(q)
            T[..., 0, 1] = -T[..., 1, 0]
        return T


def dh_before(*, theta: float, d: float) -> Array:
    """Rz(theta) Tz(d), what a Denavit-Hartenberg row puts before the joint's own motion, which adds q to one of them."""
    T = np.eye(4)
    T[2, 3] = d
    if theta != 0.0:
        c, s = np.cos(theta), np.sin(theta)
        T[:2, :2] = [[c, -s], [s, c]]
    return T


def dh_after(*, a: float, alpha: float) -> Array:
    """Tx(a) Rx(alpha), the rest of a standard Denavit-Hartenberg row Rz(theta) Tz(d) Tx(a) Rx(alpha)."""
    c, s = np.cos(alpha), np.sin(alpha)
    return np.array([[1, 0, 0, a], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1.0]])
