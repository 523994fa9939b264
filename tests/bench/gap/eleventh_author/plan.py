"""What a case is planned to be."""

from __future__ import annotations

from dataclasses import dataclass

from .moves import Maker
from .stages import Cause

__all__ = ["Plan"]


@dataclass(frozen=True)
class Plan:
    """A machine, what it did, what is wrong with it, and how the shop wrote that down."""

    title: str
    machine: str
    runs: tuple[Maker, ...]
    causes: tuple[Cause, ...] = ()
    withheld: Maker | None = None
    frame: str = "world"  # or "base", "unknown"
    target: str = "tool"
    see: str = (
        "xyz"  # "pose", "ball" (radial), "gauge" (z), "probe" (one of x, y, z a row), "flat" (x, y), "" (no instrument)
    )
    sigma: tuple[float, float, float] = (0.02, 0.02, 0.02)
    told: float | None = None
    wander: float = 0.0  # mm a direction, forgotten within `forget` seconds
    forget: float = 4.0
    left: float = 0.0  # mm, what stays beside all causes
    logged: tuple[str, ...] = ("enc",)  # set, enc, motor, torque, current, temp, force
    sheet: str = "plain"
    tolerance: float | None = None
    gross: float = 0.0
    lost: float = 0.0  # share of rows in which the instrument saw nothing
