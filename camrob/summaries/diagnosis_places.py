"""Where a gap lies, what standards say of it, and when a run passed its program's places."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from camrob.summaries.base import OpenSummary, Summary, keyed, left_out, spread

__all__ = [
    "AddedLoad",
    "AxisError",
    "AxisFriction",
    "AxisReport",
    "ChangePoint",
    "CircleDeviation",
    "DriveError",
    "ErrorPattern",
    "LoadByAxis",
    "LocalPoses",
    "LostTime",
    "OneTurn",
    "OneWay",
    "Places",
    "Rest",
    "RunDuration",
    "RunSpeed",
    "RunStandard",
    "RunTiming",
    "SpeedSpread",
    "StageWithin",
    "Standard",
    "SteadySpeed",
    "Stretch",
]

Interval = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch(OpenSummary):
    """A stretch of a log, with the gap in it: all of it, across the path and along it."""

    log: str
    from_line: int
    to_line: int
    from_s: float
    to_s: float
    samples: int
    rms_mm: float
    contour_mm: float
    tangential_mm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ChangePoint(OpenSummary):
    """Where the mean gap changes at once."""

    log: str
    t_s: float
    line: int
    step_mm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedSpread(OpenSummary):
    """Median, 5 % and 95 % of a speed over time, mm/s."""

    p5: float
    median: float
    p95: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RunDuration(OpenSummary):
    """How long a run took, by the virtual controller too, and at the programmed speed throughout."""

    logged_s: float
    predicted_s: float
    difference_s: float
    difference_percent: float | None
    at_programmed_speed_s: float
    lost_s: float
    paused_s: float
    from_line: int
    to_line: int


@dataclass(frozen=True, slots=True, kw_only=True)
class RunSpeed(OpenSummary):
    """The tool's speed; steady_percent: of the programmed one that it mostly runs at, None where there is no such share."""

    programmed_mm_s: SpeedSpread
    logged_mm_s: SpeedSpread
    predicted_mm_s: SpeedSpread
    at_programmed_percent: float
    matches: bool
    steady_percent: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Rest(OpenSummary):
    """A rest between beginning and end: a pause, or as programmed."""

    t_s: float
    line: int
    seconds: float
    programmed_s: float
    what: str


@dataclass(frozen=True, slots=True, kw_only=True)
class SteadySpeed(OpenSummary):
    """What runs at one speed for most of a stretch: an axis or "tool"; percent `of` what, None for a limit nobody states."""

    what: str
    unit: str
    share: float
    speed: float
    percent: float | None
    of: str


@dataclass(frozen=True, slots=True, kw_only=True)
class LostTime(OpenSummary):
    """A stretch of the program where time is lost against the programmed speed, and what holds the tool back there."""

    from_line: int
    to_line: int
    lost_s: float
    logged_s: float
    predicted_s: float
    at_programmed_speed_s: float
    limit: str
    paused_s: float
    steady: SteadySpeed | None


@dataclass(frozen=True, slots=True, kw_only=True)
class RunTiming(OpenSummary):
    """A log along its program; reason: why it could not be laid there, and duration None then."""

    log: str
    reason: str
    duration: RunDuration | None
    speed: RunSpeed | None
    stops: tuple[Rest, ...]
    lost: tuple[LostTime, ...]
    stretches: int

    def to_json(self) -> dict[str, Any]:
        """The JSON object; where nothing was compared the reason stands last."""
        out = Summary.to_json(self)
        if self.duration is None:
            out["reason"] = out.pop("reason")
        return out


@dataclass(frozen=True, slots=True, kw_only=True)
class OneWay(Summary):
    """ISO 9283 of one direction of a line; RT: None for a single cycle."""

    cycles: int
    AT_mm: float
    RT_mm: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class OneTurn(Summary):
    """ISO 230-4 of one direction of a circle."""

    G_mm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CircleDeviation(Summary):
    """ISO 230-4 of a circle, both directions together where there are both."""

    F_max_mm: float
    F_min_mm: float
    G_b_mm: float | None
    H_mm: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class RunStandard(OpenSummary):
    """The figures of a run: of a line forward and back, or of a circle in both senses."""

    forward: OneWay | None = left_out()
    back: OneWay | None = left_out()
    ccw: OneTurn | None = left_out()
    cw: OneTurn | None = left_out()
    circle: CircleDeviation | None = spread()


@dataclass(frozen=True, slots=True, kw_only=True)
class Standard(OpenSummary):
    """A log that is a line or a circle, as it is and without the effects found."""

    log: str
    shape: str
    standard: str
    length_mm: float | None = left_out()
    radius_mm: float | None = left_out()
    before: RunStandard
    after: RunStandard


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorPattern(OpenSummary):
    """What an axis's error follows most, the share of its energy, the coefficient in `unit`, and the period of what repeats."""

    follows: str
    share: float
    coefficient: float | None
    unit: str
    period: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisError(OpenSummary):
    """An axis's error in `unit`, mm or deg, and its rms at the tool."""

    unit: str
    rms: float
    worst: float
    mean: float
    rms_mm: float
    pattern: ErrorPattern


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveError(Summary):
    """An axis's error between set-point and encoder; within: "noise" or "tolerance" where it is no more than these."""

    unit: str
    rms: float
    worst: float
    mean: float
    rms_mm: float
    pattern: ErrorPattern
    within: str


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisFriction(OpenSummary):
    """What friction takes of an axis's torque or current (`source`) in `unit`, with its standard error, at its usual `speed`
    (degrees a second, or mm of a `linear` one) in the `log` where it is most; share: of the motor's energy; by_log: in every log.

    grown: probability that it has grown; times: as many as is expected, None where nothing says what is; against: the log in
    which it is less, "" where the other axes are all that it can be held to.
    """

    source: str
    unit: str
    linear: bool
    speed: float
    size: float
    std: float
    share: float
    by_log: Mapping[str, float]
    grown: float
    times: float | None
    against: str
    log: str


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisReport(OpenSummary):
    """An axis: its drive's error where set-points are logged, that between motor-side and link-side encoder, and its friction
    where torques or currents are.
    """

    drive: DriveError | None = spread()
    motor_to_link: AxisError | None = left_out()
    friction: AxisFriction | None = left_out()


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadByAxis(OpenSummary):
    """The added mass by one axis alone, and its dry friction (half its swing) in the unit of what was logged."""

    mass_kg: float
    std: float
    friction: float
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class AddedLoad(OpenSummary):
    """The mass at the plate beyond what the cell says, with its standard error; source: "torques" or "currents"."""

    source: str = keyed("from")
    mass_kg: float
    std: float
    axes: Mapping[str, LoadByAxis]


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalPoses(OpenSummary):
    """Poses that are off by far more than all others, and share a place: they take no part. axis: of whose values all lie between
    `low` and `high` (in `unit`), or "" where they share a box of the room (x, y, z in mm of the measured frame).

    poses: how many of the log's `of`; rms_mm, worst_mm: how far they are off beside what constants explain.
    """

    log: str
    poses: int
    of: int
    axis: str
    low: tuple[float, ...]
    high: tuple[float, ...]
    unit: str
    rms_mm: float
    worst_mm: float

    @property
    def place(self) -> str:
        """In words: "A1 between −49 and −12 degrees", or the box of the room."""
        low, high = ([f"{v:.0f}".replace("-", "−") for v in values] for values in (self.low, self.high))
        if self.axis:
            return f"{self.axis} between {low[0]} and {high[0]} {self.unit}"
        sides = (f"{n} {a} to {b}" for n, a, b in zip("xyz", low, high, strict=True))
        return f"the tool at {', '.join(sides)} mm"


@dataclass(frozen=True, slots=True, kw_only=True)
class Places(OpenSummary):
    """Where the gap lies, with intervals of 90 %.

    stages: mm rms that each step from program to set-point, encoder and TCP adds, None where a log lacks it. axes, regimes: the
    share of the gap's energy that each would explain alone. program_left_mm: what the rounding of corners leaves. local: poses
    that are far off and share a place.
    """

    stages: Mapping[str, float | None] = keyed("rungs")
    stage_intervals: Mapping[str, Interval | None] = keyed("rung_intervals")
    missing: tuple[str, ...]
    segments: tuple[Stretch, ...]
    change_points: tuple[ChangePoint, ...]
    lines: tuple[Stretch, ...]
    directions: Mapping[str, float]
    direction_intervals: Mapping[str, Interval]
    axes: Mapping[str, float]
    axis_intervals: Mapping[str, Interval]
    regimes: Mapping[str, float]
    regime_intervals: Mapping[str, Interval]
    further_regimes: Mapping[str, float]
    program_left_mm: float | None = left_out()
    timing: tuple[RunTiming, ...]
    local: tuple[LocalPoses, ...] = left_out(())


@dataclass(frozen=True, slots=True, kw_only=True)
class StageWithin(OpenSummary):
    """What a logged stage is within, and by which values: rms and 95 % at the tool, its noise, told by LOG.toml or found, and the
    tolerance that LOG.toml names, None where it does not. axis: of drives, the one that decides; its values are over the work.
    """

    within: str
    rms_mm: float
    p95_mm: float
    noise_mm: float
    noise_told: bool
    tolerance_mm: float | None
    axis: str
