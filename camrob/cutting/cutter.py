"""A cutter's envelope as it spins: flat, ball or bull-nosed, after APT's CUTTER of three numbers."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Cutter"]


@dataclass(frozen=True, slots=True)
class Cutter:
    """What cuts: a cylinder of `radius` from the tip up to `length`, its lower edge rounded by `corner`, all m.

    corner: 0 of a flat end mill, `radius` of a ball. Raises ValueError for what is no cutter.
    """

    radius: float
    corner: float
    length: float

    def __post_init__(self) -> None:
        if not (self.radius > 0.0 and 0.0 <= self.corner <= self.radius and self.length >= self.corner):
            raise ValueError(f"no cutter: radius {self.radius}, corner {self.corner}, length {self.length}")
