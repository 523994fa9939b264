"""What `camrob post` says: NAME.json, as the contract fixes it. Units are those of the trade, in the names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.summaries.base import Summary, left_out
from camrob.summaries.feed_figures import FeedFigures, Torques
from camrob.summaries.remarks import AxisLimits, Remark

__all__ = [
    "AccuracyFigures",
    "ClampingFigures",
    "CollisionFigures",
    "Conditioning",
    "ExpectedErrorFigures",
    "Manifest",
    "PlanFigures",
    "PlanOnCurve",
    "PlannedCut",
    "PostSummary",
    "PriceBound",
    "ProcessFigures",
    "ProgramTime",
    "RegionFigures",
    "Source",
    "ToolChanged",
    "Tracking",
    "Verified",
    "WitnessFigures",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Source(Summary):
    """The CL file."""

    file: str
    sha256: str
    dialect: str
    units: str


@dataclass(frozen=True, slots=True, kw_only=True)
class RegionFigures(Summary):
    """A region: its CL lines, and how well the arm stands in it; before and after a revision, at its first point."""

    index: int
    name: str
    first_line: int
    last_line: int
    points: int
    revised: bool
    inv_kf_before: float
    inv_kf_after: float
    inv_kf_min: float
    inv_kf_mean: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Tracking(Summary):
    """What the solver leaves of the poses, before rounding."""

    position_error_mm_max: float
    axis_error_deg_max: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Conditioning(Summary):
    """1/k_F of the arm along the path, and the mean of the best that any posture reaches; None where no plan looked for it."""

    inv_kf_min: float
    inv_kf_mean: float
    inv_kf_bound_mean: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class CollisionFigures(Summary):
    """Collisions along the program; the clearance is None where none was measured."""

    checked: bool
    count: int
    clearance_min_mm: float | None
    clearance_pair: tuple[str, ...]
    sampled: str
    skipped: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ProgramTime(Summary):
    """s, at the programmed feed, and planned; None without a plan."""

    program: float
    optimal: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ToolChanged(Summary):
    """A change of tools: where the file has it, the number and name it gives, and the set-up's tool."""

    line: int
    number: int
    name: str
    tool: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessFigures(Summary):
    """What happens beside moving; spindle: line, rev/min and sense of each start."""

    events_in_file: int
    events_in_program: int
    spindle: tuple[tuple[int, float, str], ...]
    tool_changes: tuple[ToolChanged, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Verified(Summary):
    """How far the program that was read back and replayed is off the CL file."""

    by: str
    position_error_mm_max: float
    axis_error_deg_max: float
    second_library_error_mm_max: float
    second_library_poses: int
    points: int


@dataclass(frozen=True, slots=True, kw_only=True)
class WitnessFigures(Summary):
    """What the witness judged, and in lines what it could not."""

    complete: bool
    judged_points: int
    judged_events: int
    not_judged: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedCut(Summary):
    """Where the arm is re-postured, and why; inserted: a retract was put in."""

    line: int
    region: int
    inserted: bool
    by: str
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanOnCurve(Summary):
    """A plan between still and flowing; travel by axis while cutting, in SI and in the units that its keys name; the rms of the
    part's expected error where the plan looks at it.
    """

    name: str
    inv_kf_mean: float
    inv_kf_min: float
    share_of_bound: float
    travel_si: Mapping[str, float]
    travel: Mapping[str, float]
    error_mm: float | None = left_out(None)


@dataclass(frozen=True, slots=True, kw_only=True)
class ExpectedErrorFigures(Summary):
    """The part's error that is to be expected of a plan, over what is cut: rms, and what 95 % keep, mm; turns: of axes that
    leave a mark where they turn round in a cut, by axis.
    """

    rms_mm: float
    p95_mm: float
    turns: Mapping[str, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class AccuracyFigures(Summary):
    """What looking at the part's error has gained: the plan by conditioning, the one for accuracy, whether that one was taken;
    rms of the error in each place's best posture of a scan; what is counted and what is left out, in words.
    """

    conditioning: ExpectedErrorFigures
    accuracy: ExpectedErrorFigures
    taken: bool
    best_rms_mm: float
    counted: tuple[str, ...]
    left_out: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class PriceBound(Summary):
    """A proved lower bound of what any plan costs, m, by the objective that `terms` are of: the plan's price, the bound, 0 where
    none is proved, and how far the plan may be above the best that exists; checked: whether the checker proves it again from the
    certificate; why: what stands against more; left_out: what the bound doesn't count.
    """

    price_m: float
    bound_m: float
    within_percent: float | None
    checked: bool
    why: str
    left_out: tuple[str, ...]
    seconds: float
    certificate: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanFigures(Summary):
    """How a planned solution was chosen: the curve of conditioning against external travel, and the objective's terms, m.

    gap_percent: what the mean 1/k_F over what is cut lacks to its bound's; seconds: what was asked for, None for no end; missed:
    points of the curve that there was no time for, and the look for a cheaper plan, which counts for one; mended: how often the
    plan was made anew where it touched something.
    """

    mode: str
    chosen: str
    rule: str
    bound_mean: float
    bound_min: float
    terms: Mapping[str, float]
    shares: Mapping[str, float]
    repostures: int
    retracts: int
    cuts: tuple[PlannedCut, ...]
    curve: tuple[PlanOnCurve, ...]
    gap_percent: float
    seconds: float | None
    missed: int
    mended: int
    accuracy: AccuracyFigures | None = left_out(None)
    proved: PriceBound | None = left_out(None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Manifest(Summary):
    """SHA-256 of every file that the program was made from and of its own, by name; camrob: the version.

    known: calibration, diagnosis and force that it goes by, left out where there are none. source: the program whose targets were
    moved, of one that is compensated; `cl_file` and `setup` are that one's then.
    """

    camrob: str
    cl_file: Mapping[str, str]
    setup: Mapping[str, str]
    cell: Mapping[str, str]
    program: Mapping[str, str]
    known: Mapping[str, str] | None = left_out()
    source: Mapping[str, str] | None = left_out()


@dataclass(frozen=True, slots=True, kw_only=True)
class ClampingFigures(Summary):
    """One of a job's programs, of a part that is worked from several sides: first and last line of the CL file, the main file."""

    name: str
    program: str
    first_line: int
    last_line: int


@dataclass(frozen=True, slots=True, kw_only=True)
class PostSummary(Summary):
    """A program that was made: from what, how well it stands and keeps its limits, what was verified, what to read first.

    singular: motions that pass a singular posture. external_travel: by axis and unit. torques: None for a cell without masses;
    plan: None for the published method. seconds: by stage of the job. clamping: of which side's program this is, clampings: all
    programs of the job, where the part is worked from several.
    """

    program: str
    cell: str
    method: str
    source: Source
    points: int
    regions: tuple[RegionFigures, ...]
    tracking: Tracking
    conditioning: Conditioning
    limits: AxisLimits
    singular: int
    collisions: CollisionFigures
    external_travel: Mapping[str, float]
    time_s: ProgramTime
    feed: FeedFigures
    torques: Torques | None
    process: ProcessFigures
    verified: Verified
    witness: WitnessFigures
    plan: PlanFigures | None
    warnings: tuple[Remark, ...]
    notes: tuple[Remark, ...]
    files: tuple[str, ...]
    manifest: Manifest
    clamping: str = left_out("")
    clampings: tuple[ClampingFigures, ...] = left_out(())
    seconds: Mapping[str, float] | None = left_out()
