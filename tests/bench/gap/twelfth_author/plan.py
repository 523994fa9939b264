"""How a case is told: machine, motion, instrument, causes by the floor, leftover, table, what is right to do first."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Cause:
    """`ratio`: by the floor (the larger of leftover and noise). `where` of a foreign one: stage, axes, what it follows."""

    name: str
    axes: tuple = ()
    ratio: float = 5.0
    alike: tuple = ()
    more: dict = field(default_factory=dict)
    where: tuple | None = None


@dataclass(frozen=True)
class Spec:
    title: str
    machine: str
    moves: str
    sees: str | None
    causes: tuple
    step: str
    wrong_step: str = ""
    leftover: float = 0.0  # by the noise
    wander: float = 0.0  # of an instrument that is correlated, by its noise
    withheld: bool = True
    loads: tuple = ()
    form: str = "plain"
    columns: str = ""  # I, T, M
    temp: bool = False
    tolerance_mm: float = 0.0
    setpoints: bool = True  # of dense logs
    how: dict = field(default_factory=dict)


@dataclass(frozen=True)
class Instrument:
    sigma_mm: tuple  # of x, y, z
    frame: str = "world"
    target: str = "tool"
    sigma_deg: float = 0.0
    only: str = "xyz"
    name: str = ""


INSTRUMENTS = {
    "tracker": Instrument((0.018, 0.018, 0.018), "unknown", "unknown", name="laser tracker, reflector on the flange"),
    "tracker_in_cell": Instrument((0.022, 0.022, 0.022), name="laser tracker, set on the cell's marks"),
    "tracker_six": Instrument(
        (0.03, 0.03, 0.03), sigma_deg=0.004, name="laser tracker with a target of six degrees of freedom"
    ),
    "photogrammetry": Instrument((0.03, 0.03, 0.075), name="two cameras on a beam"),
    "photogrammetry_free": Instrument((0.03, 0.03, 0.075), "unknown", "unknown", name="two cameras, dots on the hand"),
    "measuring_arm": Instrument((0.035, 0.035, 0.035), "unknown", "tool", name="measuring arm on a magnet foot"),
    "interferometer": Instrument((0.002, 0.002, 0.002), only="z", name="laser interferometer along the column"),
    "on_table": Instrument((0.025, 0.025, 0.025), "base", name="probe head against balls on the turning plate"),
}
