"""What `camrob compensate` says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.summaries.base import Summary, left_out
from camrob.summaries.post_summary import Manifest
from camrob.summaries.predict_summary import LikelySize
from camrob.summaries.remarks import Remark

__all__ = [
    "AxisCorrection",
    "CalibrationUsed",
    "CompensateSummary",
    "Corrections",
    "ErrorBetween",
    "Iterations",
    "MarginsBeforeAfter",
    "NewViolation",
    "OffPathSize",
    "OnDiagnosedMachine",
    "PoseErrorSize",
    "RateBeforeAfter",
    "Violations",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Iterations(Summary):
    """Newton iterations a point."""

    mean: float
    max: int


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseErrorSize(Summary):
    """Errors of the calibrated robot at the motions' ends."""

    mean_mm: float
    max_mm: float
    mean_deg: float
    max_deg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorBetween(Summary):
    """Errors half-way through the LINs, and the line of the largest."""

    mean_mm: float
    max_mm: float
    mean_deg: float
    max_deg: float
    worst_line: int


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisCorrection(Summary):
    """By how much an axis was moved, in mm or degrees, and the line of the largest."""

    mean_mm: float | None = left_out()
    max_mm: float | None = left_out()
    mean_deg: float | None = left_out()
    max_deg: float | None = left_out()
    line: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Corrections(Summary):
    """By how much the tip was moved, and each axis; external ones stay as planned."""

    mean_mm: float
    max_mm: float
    axes: Mapping[str, AxisCorrection]


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationUsed(Summary):
    """The calibration's file, and the logs that it rests on."""

    file: str
    logs: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class RateBeforeAfter(Summary):
    """The least ds/dt, rad/s, that the axes' limits of a kind allow."""

    before: float
    after: float


@dataclass(frozen=True, slots=True, kw_only=True)
class NewViolation(Summary):
    """A bound that the compensated program alone passes, how many times over, and where."""

    axis: str
    quantity: str
    line: int
    times: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Violations(Summary):
    """Bounds that are passed at the program's own mean rate: how many before and after, and which are new."""

    rate_rad_s: float
    before: int
    after: int
    new: tuple[NewViolation, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class MarginsBeforeAfter(Summary):
    """The least margin of each axis to a limit, after and before, degrees or mm; None for an endless one."""

    margin_min: Mapping[str, float | None]
    margin_min_before: Mapping[str, float | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class OffPathSize(Summary):
    """How far the tool is off the intended path while it moves along lines and arcs that cut."""

    rms_mm: float
    p95_mm: float
    max_mm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class OnDiagnosedMachine(Summary):
    """The program run on the machine as diagnosed: as it was, with the chain's constants corrected, and as written.

    causes: what more than constants was corrected, none where that would not have helped; not_reckoned: what was found and a
    program's run does not tell; rest_mm: what no cause explains (3-D rms); targets_added: within lines, where a correction has
    to change more quickly than between two targets: by file, the lines of the written program that hold them. fastest_cut_mm_min:
    lines and arcs that are programmed faster count as moves in air; left out where none do. likely: `after` on the machines that
    the diagnosis leaves open; left out where an older camrob wrote the file.
    """

    diagnosis: str
    causes: tuple[str, ...]
    not_reckoned: tuple[str, ...]
    rest_mm: float
    targets_added: Mapping[str, tuple[int, ...]]
    before: OffPathSize
    constants: OffPathSize
    after: OffPathSize
    likely: LikelySize | None = left_out()
    fastest_cut_mm_min: float | None = left_out()

    def steps(self) -> tuple[tuple[str, OffPathSize], ...]:
        """The program as it was, what the chain's constants alone make of it, and what was written."""
        return (
            ("the program as it was", self.before),
            ("constants of the chain corrected", self.constants),
            ("as written", self.after),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class CompensateSummary(Summary):
    """A compensated program: errors of the calibrated robot before and after, corrections, what was not corrected.

    calibrated_withheld_mm: the calibration's mean error on withheld poses, None without any. calibration: None where a diagnosis
    found no constants. error_between: None without a LIN, and where more than constants was corrected. derivatives: by kind of
    limit, none of a program too short; violations: None of a program without speed. machine: with a diagnosis or a force only.
    """

    program: str
    cell: str
    motions: int
    iterations: Iterations
    error_before: PoseErrorSize
    error_after: PoseErrorSize
    correction: Corrections
    calibrated_withheld_mm: float | None
    calibration: CalibrationUsed | None
    error_between: ErrorBetween | None
    derivatives: Mapping[str, RateBeforeAfter]
    violations: Violations | None
    limits: MarginsBeforeAfter
    warnings: tuple[Remark, ...]
    source: str
    files: tuple[str, ...]
    seconds: float
    machine: OnDiagnosedMachine | None = left_out()
    manifest: Manifest | None = left_out()
