"""What `camrob calibrate` says, and a published calibration that is repeated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.summaries.base import Summary, keyed, left_out, spread
from camrob.summaries.remarks import Remark

__all__ = [
    "CalibrationFigures",
    "CalibrationSummary",
    "Correlation",
    "ErrorFigures",
    "FittedParameter",
    "HeldParameter",
    "MeasuringCollisions",
    "MeasuringFigures",
    "Observability",
    "PublishedFigure",
    "UsedLog",
    "WithheldLog",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class UsedLog(Summary):
    """A log that was fitted, and its digest."""

    file: str
    digest: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorFigures(Summary):
    """Errors of some poses at a stage of the fit; orientation: None where none was measured."""

    poses: int
    mean_mm: float
    rms_mm: float
    p95_mm: float
    max_mm: float
    mean_deg: float | None
    max_deg: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedParameter(Summary):
    """A parameter with its standard error; nuisance: of the instrument, not of the robot."""

    name: str
    value: float
    std: float
    unit: str
    nuisance: bool

    @property
    def may_be_none(self) -> bool:
        """Whether two standard errors hold 0."""
        return abs(self.value) < 2.0 * self.std


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldParameter(Summary):
    """A parameter that was left out: merged with others, unseen, or weak."""

    name: str
    why: str
    others: tuple[str, ...] = keyed("with")


@dataclass(frozen=True, slots=True, kw_only=True)
class Correlation(Summary):
    """How strongly the estimates of two parameters are correlated, -1 to 1."""

    pair: tuple[str, str]
    value: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Observability(Summary):
    """The observability indices O1 to O5 of the poses."""

    o1: float
    o2: float
    o3: float
    o4: float
    o5: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationFigures(Summary):
    """A calibration: errors by stage ("calibrated/withheld"), parameters, and what the poses can't tell.

    scatter: what remains an axis, by one standard deviation; scatter_deg: None where no orientation was measured.
    """

    cell: str
    logs: tuple[UsedLog, ...]
    poses: int
    left_out: int
    outliers: int
    oriented: bool
    errors: Mapping[str, ErrorFigures]
    scatter_mm: float
    scatter_deg: float | None
    parameters: tuple[FittedParameter, ...]
    held: tuple[HeldParameter, ...]
    correlations: tuple[Correlation, ...]
    condition: float
    observability: Observability
    warnings: tuple[Remark, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedFigure(Summary):
    """A paper's figure beside ours, in words."""

    what: str
    published: str
    ours: str


@dataclass(frozen=True, slots=True, kw_only=True)
class WithheldLog(Summary):
    """Poses that took no part; refitted: base and reflector were fitted to half of them."""

    file: str
    poses: int
    refitted: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuringCollisions(Summary):
    """Whether the way between the poses was checked, and how many poses were exchanged because they touch something."""

    checked: bool
    count: int
    exchanged: int


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuringFigures(Summary):
    """The poses to measure next: axis values as programs print them, tips in base, and the error expected on the path."""

    poses: int
    expected_before_mm: float
    expected_after_mm: float
    collisions: MeasuringCollisions
    axis_values: tuple[tuple[float, ...], ...]
    tip_mm: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationSummary(Summary):
    """A calibration that was written, with its report; published: None but for a repeated case; next: None unless asked for."""

    figures: CalibrationFigures = spread()
    file: str
    report: str
    published: tuple[PublishedFigure, ...] | None = left_out()
    withheld: tuple[WithheldLog, ...]
    next: MeasuringFigures | None = left_out()
    seconds: float | None = left_out()
