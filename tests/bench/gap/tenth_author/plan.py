"""What a case is planned to be."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["Plan"]


@dataclass(frozen=True)
class Plan:
    """A machine, what it was asked to do, what is wrong with it, and how the shop wrote that down."""

    title: str
    machine: str
    runs: list[Callable]  # (machine, rng) to Run
    causes: Callable[[], list]
    withheld: Callable | None = None
    frame: str = "world"
    target: str = "tool"
    sigma: float = 0.02  # mm a direction
    told: float | None = None  # what the log's file says of it, where that is something else
    left: float = 0.0  # mm, 3-D rms of what stays beside all causes
    see: str = "place"  # "place", "pose" (with orientation), "flat" (x and y), "along" (x), "" (no instrument)
    logged: tuple[str, ...] = ("enc",)  # set, enc, motor, torque, current, temp
    table: str = "plain"
    clock: bool = True
    gross: float = 0.0
    tolerance: float | None = None  # mm, where the log's file names one
    wander: float = 0.0  # mm a direction, by which air and stand let the instrument wander within seconds
