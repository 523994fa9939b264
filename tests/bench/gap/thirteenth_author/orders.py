"""How a work order is told: machine, way of measuring, what is truly wrong, and what a sensible technician does first."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Cause:
    """`ratio` by the floor (the larger of leftover and noise, 3-D rms); `since`: after a service, or from that share on."""

    name: str
    axes: tuple = ()
    ratio: float = 5.0
    more: dict = field(default_factory=dict)
    since: str | float | None = None
    alike: tuple = ()  # by physics, beside what the numbers show
    where: tuple | None = None  # of one without a name: stage, axes, what it follows


@dataclass(frozen=True)
class Order:
    kind: str  # poses, paths, drives, foreign, sound
    title: str
    machine: str
    moves: str
    sees: str | None
    causes: tuple
    step: str
    wrong_step: str = ""
    left: float = 0.0  # leftover by the noise
    wander: float = 0.0  # slow part of the instrument's noise by its white one; the noise that is told holds both
    before: bool = False  # one record of the time before beside that of the time after
    withheld: bool = True
    loads: tuple = ()
    form: str = "plain"
    columns: str = ""  # I, T: of drives; M: encoders on motor and load
    temp: bool = False
    tolerance_mm: float = 0.0
    how: dict = field(default_factory=dict)


@dataclass(frozen=True)
class Instrument:
    sigma: tuple  # mm, white, of x, y, z
    frame: str = "world"
    target: str = "tool"
    sigma_deg: float = 0.0
    name: str = ""


INSTRUMENTS = {
    "tracker": Instrument((0.015,) * 3, "unknown", "unknown", name="laser tracker, magnet nest on the tool"),
    "tracker_cell": Instrument((0.02,) * 3, name="laser tracker, stationed on the cell's marks"),
    "tracker_six": Instrument((0.025,) * 3, "unknown", "tool", 0.003, "laser tracker with a six-dimensional probe"),
    "cheap_arm": Instrument((0.045,) * 3, "unknown", "tool", name="jointed measuring arm on a magnet foot"),
    "stereo": Instrument((0.028, 0.028, 0.065), name="stereo camera on the cell's fence"),
    "nest": Instrument((0.012,) * 3, name="ball in nests of a measured plate"),
    "gauges": Instrument((0.008,) * 3, name="three dial gauges at a ball, pose by pose"),
    "plate_arm": Instrument((0.03,) * 3, "base", name="jointed measuring arm on the turning plate"),
}

MASTER = "look at the marks of {0} and master {0} anew"
