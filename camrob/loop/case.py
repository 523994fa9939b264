"""What a cell's tracker.toml says: the loop, the tests, the tracker, and the simulated robot."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camrob.errors import CellError, InputError
from camrob.frozen import locked
from camrob.loop.law import CorrectionLaw
from camrob.loop.rsi.link import read_sender
from camrob.se3 import frame_from_mm_deg
from camrob.toml.read_toml import read_toml
from camrob.toml.table_reader import TableReader
from camrob.units import deg_to_rad, mm_min_to_m_s, mm_to_m, ms_to_s

__all__ = ["RobotErrors", "TrackerCase", "TrackerNoise", "read_tracker_case"]

Array = NDArray[np.float64]

# the least and most of each that still is a laser tracker: beyond them the unit was mistaken
_INSTRUMENT = {
    "drift_ppm": (0.0, 1e4),
    "latency_ms": (-200.0, 200.0),
    "far_mm": (1e-3, 1e3),
    "far_deg": (1e-3, 90.0),
    "jump_mm": (1e-3, 1e3),
    "jump_deg": (1e-3, 90.0),
}
_RSI_CYCLES = ("stale_after", "stop_after", "late_stop", "saturated_cycles")


@dataclass(frozen=True, slots=True)
class TrackerNoise:
    """Standard deviations of a sample: `position` of each coordinate, m, `angle` about each axis, rad; samples a second."""

    position: float
    angle: float
    rate: float


@dataclass(frozen=True, slots=True)
class RobotErrors:
    """How the simulated robot differs from its nominal self. Arrays are per joint (6,), rad and s, unless said.

    delay: cycles from command to joint control. lag: time constants. lost: half the motion lost at a reversal. friction:
    half of what friction holds back there, dying away with `recovery`, s. sliding: how far a joint turns until friction has
    changed sides, at least twice the sum of both, or the link would move against its motor. seed, link, link_angle: of the
    drawn link errors, m and rad. static (6,): x, y, z, A, B, C of the tool's error at the square's first corner, m and rad.
    """

    delay: int
    lag: Array
    lost: Array
    friction: Array
    recovery: float
    sliding: Array
    seed: int
    link: float
    link_angle: float
    static: Array

    def __post_init__(self) -> None:
        for name in ("lag", "lost", "friction", "sliding", "static"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(6,), name=name))


@dataclass(frozen=True, slots=True)
class TrackerCase:
    """A case, SI. base_T_tracker: where the tracker stands, as calibrated. latency: cycles. corner, center: (3,), m.

    `link`: what [instrument] and [rsi] say of the real loop, by the names of their keys and in the units of these; the study
    doesn't use it. `provenance` maps dotted keys of tracker.toml to where their numbers come from.
    """

    law: CorrectionLaw
    base_T_tracker: Array
    noise: TrackerNoise
    latency: int
    feed: float
    acceleration: float
    rest: float
    side: float
    corner: Array
    switched_on: float
    radius: float
    center: Array
    robot: RobotErrors
    link: dict[str, Any]
    provenance: dict[str, str]

    def __post_init__(self) -> None:
        object.__setattr__(self, "base_T_tracker", locked(self.base_T_tracker, shape=(4, 4), name="base_T_tracker"))
        for name in ("corner", "center"):
            object.__setattr__(self, name, locked(getattr(self, name), shape=(3,), name=name))


def read_tracker_case(folder: Path) -> TrackerCase:
    """The case of a cell's folder. Raises CellError, with key and hint, where tracker.toml is wrong or absent."""
    file = folder / "tracker.toml"
    if not file.exists():
        hint = "add tracker.toml, as in cells/rx160_tracker, or take that cell"
        raise CellError("this cell has no tracker loop", hint=hint, path=folder)
    table = TableReader(read_toml(file), file, needs_provenance=True)
    tracker, motion = table.table("tracker"), table.table("motion")
    square, circle = table.table("square"), table.table("circle")
    case = TrackerCase(
        law=_law(table.table("loop")),
        base_T_tracker=frame_from_mm_deg(tracker.vector("base_to_tracker", 6)),
        noise=TrackerNoise(
            mm_to_m(tracker.number("noise_mm", lower=0.0, upper=1.0)),
            deg_to_rad(tracker.number("noise_deg", lower=0.0, upper=1.0)),
            tracker.number("rate_hz", lower=1.0, upper=1e5),
        ),
        latency=tracker.integer("latency_cycles", lower=0, upper=50),
        feed=mm_min_to_m_s(motion.number("feed_mm_min", lower=1.0, upper=1e5)),
        acceleration=motion.number("acceleration_m_s2", lower=1e-3, upper=100.0),
        rest=motion.number("rest_s", lower=0.1, upper=100.0),
        side=mm_to_m(square.number("side_mm", lower=1.0, upper=1e4)),
        corner=mm_to_m(square.vector("corner_mm", 3)),
        switched_on=square.number("on_s", lower=0.0, upper=1e4),
        radius=mm_to_m(circle.number("radius_mm", lower=1.0, upper=1e4)),
        center=mm_to_m(circle.vector("center_mm", 3)),
        robot=_robot(table.table("robot")),
        link={**_instrument(table), **_rsi(table)},
        provenance=table.provenance,
    )
    for part in (tracker, motion, square, circle, table):
        part.finish()
    return case


def _law(table: TableReader) -> CorrectionLaw:
    """[loop]."""
    law = CorrectionLaw(
        gain=table.number("gain", lower=1e-6, upper=1.0),
        limit_m=mm_to_m(table.number("limit_mm", lower=1e-3, upper=100.0)),
        limit_rad=deg_to_rad(table.number("limit_deg", lower=1e-3, upper=10.0)),
        cycle_s=ms_to_s(table.number("cycle_ms", lower=0.1, upper=20.0)),
        step_m=mm_to_m(table.number("step_mm", lower=1e-6, upper=10.0)),
        step_rad=deg_to_rad(table.number("step_deg", lower=1e-6, upper=10.0)),
    )
    table.finish()
    return law


def _instrument(table: TableReader) -> dict[str, Any]:
    """[instrument]: those of its keys that are there."""
    if "instrument" not in table:
        return {}
    own = table.table("instrument")
    found: dict[str, Any] = {"clock": own.text("clock", choices=("own", "shared"))} if "clock" in own else {}
    for key, (lower, upper) in _INSTRUMENT.items():
        if key in own:
            found[key] = own.number(key, lower=lower, upper=upper)
    own.finish()
    return found


def _rsi(table: TableReader) -> dict[str, Any]:
    """[rsi]: those of its keys that are there."""
    if "rsi" not in table:
        return {}
    own = table.table("rsi")
    found: dict[str, Any] = {key: own.integer(key, lower=1, upper=1_000_000) for key in _RSI_CYCLES if key in own}
    if "mode" in own:
        found["mode"] = own.text("mode", choices=("absolute", "relative"))
    if "corrected" in own:
        found["corrected"] = own.flag("corrected")
    if "sen_type" in own:
        found["sen_type"] = own.text("sen_type")
    if "allow" in own:
        found["allow"] = own.texts("allow")
        if not found["allow"]:
            raise own.fail("allow", "names nobody", "name the controller and the instrument, or leave it out")
        for sender in found["allow"]:
            try:
                read_sender(sender)
            except InputError as error:
                raise own.fail("allow", error.what, error.hint) from None
    own.finish()
    return found


def _robot(table: TableReader) -> RobotErrors:
    """[robot]."""
    errors = RobotErrors(
        delay=table.integer("delay_cycles", lower=0, upper=100),
        lag=ms_to_s(_positive(table, "lag_ms", 0.0)),
        lost=deg_to_rad(_positive(table, "lost_deg", 0.0)),
        friction=deg_to_rad(_positive(table, "friction_deg", 0.0)),
        recovery=ms_to_s(table.number("recovery_ms", lower=1.0, upper=1e4)),
        sliding=deg_to_rad(_positive(table, "sliding_deg", 1e-6)),
        seed=table.integer("seed", lower=0, upper=2**31),
        link=mm_to_m(table.number("link_mm", lower=0.0, upper=10.0)),
        link_angle=deg_to_rad(table.number("link_deg", lower=0.0, upper=5.0)),
        static=np.concatenate([mm_to_m(table.vector("static_mm", 3)), deg_to_rad(table.vector("static_deg", 3))]),
    )
    if np.any(errors.sliding < 2.0 * (errors.lost + errors.friction) * (1.0 - 1e-9)):
        raise table.fail(
            "sliding_deg", "is less than twice lost_deg + friction_deg", "give more: a link can't run backwards"
        )
    table.finish()
    return errors


def _positive(table: TableReader, key: str, lower: float) -> Array:
    """Six numbers, none below `lower`."""
    values = table.vector(key, 6)
    if np.any(values < lower):
        raise table.fail(key, f"holds {values.min():g}", f"give six numbers from {lower:g} on")
    return values
