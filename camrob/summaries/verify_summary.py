"""What `camrob verify` says."""

from __future__ import annotations

from dataclasses import dataclass

from camrob.summaries.base import Summary, keyed, left_out, spread
from camrob.summaries.feed_figures import BlockTime
from camrob.summaries.remarks import Approximated, AxisLimits, JudgedRemark

__all__ = ["Against", "CorrectedFrom", "Judged", "LeastConditioning", "ProgramEvents", "ReplayFigures", "VerifySummary"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged(Summary):
    """Area by area: True (judged, nothing was found against it), False (something does), None (not judged, or not all of it)."""

    path: bool | None
    frames: bool | None
    process: bool | None
    limits: bool | None
    collisions: bool | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ProgramEvents(Summary):
    """The program's own process; events_in_file: None without a CL file; spindle: line, rev/min, sense; changes: line, number."""

    events_in_file: int | None
    events_in_program: int
    spindle: tuple[tuple[int, float, str], ...]
    tool_changes: tuple[tuple[int, float], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class LeastConditioning(Summary):
    """The lowest 1/k_F; None where no posture is known."""

    inv_kf_min: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayFigures(Summary):
    """What the replay measured; approximation, blocks (motions too short for the controller): None for a program that the ideal
    controller would not run, blocks also where the cell has no `block_ms`.
    """

    samples: int
    limits: AxisLimits
    singular: int
    conditioning: LeastConditioning
    jump_deg_max: float
    second_library_error_mm_max: float
    approximation: Approximated | None
    blocks: BlockTime | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Against(Summary):
    """How far the program is off its CL points, and how far it deviates between them."""

    file: str
    points: int
    met: int
    position_error_mm_max: float
    axis_error_deg_max: float
    deviation_mm_max: float = keyed("stray_mm_max")


@dataclass(frozen=True, slots=True, kw_only=True)
class CorrectedFrom(Summary):
    """Of a compensated program: how far its targets are moved, and the calibrated robot is off the original's poses."""

    original: str
    calibration: str
    moved_mm_max: float
    position_error_mm_max: float
    axis_error_deg_max: float


@dataclass(frozen=True, slots=True, kw_only=True)
class VerifySummary(Summary):
    """The judgement of a program.

    ok: None where nothing was found against it but not all of it was judged. motions, replay: None where it could not be
    replayed. against: None without a CL file. corrected: of a compensated program that was held to its original.
    """

    program: str
    cell: str
    ok: bool | None
    judged: Judged
    not_judged: tuple[str, ...]
    errors: tuple[JudgedRemark, ...]
    warnings: tuple[JudgedRemark, ...]
    process: ProgramEvents
    files: tuple[str, ...]
    motions: int | None
    replay: ReplayFigures | None = spread()
    against: Against | None
    seconds: float
    corrected: CorrectedFrom | None = left_out()
