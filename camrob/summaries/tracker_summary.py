"""What `camrob tracker` says of the study of a laser-tracker loop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.summaries.base import Summary, keyed

__all__ = [
    "AxesErrors",
    "CircleFigures",
    "ComparisonFigures",
    "ErrorSizes",
    "GainFigures",
    "GainNeeded",
    "JointLagFigures",
    "LapFigures",
    "LatencyFigures",
    "LawFigures",
    "MarginFigures",
    "RunFigures",
    "SensitivityFigures",
    "Shrinks",
    "SimulatedGain",
    "SquareFigures",
    "TrackerSummary",
    "VariantFigures",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class LawFigures(Summary):
    """The correction law as the cell's tracker.toml has it."""

    gain: float
    cycle_ms: float
    latency_cycles: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonFigures(Summary):
    """A published figure beside ours; kind: "tuned", "result" or "checked"."""

    what: str
    published: str
    found: str
    kind: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorSizes(Summary):
    """Mean, rms, 95 % and largest of an error, in mm or degrees as what holds them says."""

    mean: float
    rms: float
    p95: float
    most: float


@dataclass(frozen=True, slots=True, kw_only=True)
class AxesErrors(Summary):
    """Errors along and about the six axes of the tool's pose."""

    x_mm: ErrorSizes
    y_mm: ErrorSizes
    z_mm: ErrorSizes
    a_deg: ErrorSizes
    b_deg: ErrorSizes
    c_deg: ErrorSizes


@dataclass(frozen=True, slots=True, kw_only=True)
class RunFigures(Summary):
    """A run: errors in truth and as the tracker sees them, at corners, where joints reverse, and at rest before it."""

    axes: AxesErrors
    axes_seen: AxesErrors
    tool_mm: ErrorSizes
    tool_seen_mm: ErrorSizes
    path_mm: ErrorSizes
    path_seen_mm: ErrorSizes
    corners_mm: tuple[float, ...]
    reversal_peaks_mm: tuple[float, ...]
    static: tuple[float, ...]
    increments_cut_later: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Shrinks(Summary):
    """The shares by which errors shrink."""

    tool_rms: float
    tool_mean: float
    path_mean: float
    path_seen_mean: float
    x_rms: float
    y_rms: float
    z_rms: float
    a_rms: float
    b_rms: float
    c_rms: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SquareFigures(Summary):
    """The square, with the correction switched on half-way."""

    switched_on_s: float
    before: RunFigures
    after: RunFigures
    reduction: Shrinks


@dataclass(frozen=True, slots=True, kw_only=True)
class CircleFigures(Summary):
    """The circle without and with correction, and where joints reverse on it."""

    before: RunFigures
    after: RunFigures
    reduction: Shrinks
    reversals_deg: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class VariantFigures(Summary):
    """A variant of the law on both paths."""

    key: str
    name: str
    square: RunFigures
    circle: RunFigures


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedGain(Summary):
    """A gain as simulated on the circle."""

    gain: float
    circle_rms_mm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class GainFigures(Summary):
    """The gain by analysis; expected_rms_mm: a row a run, a column a gain, None where the loop is unstable."""

    chosen: float
    gains: tuple[float, ...]
    expected_rms_mm: tuple[tuple[float | None, ...], ...]
    simulated: tuple[SimulatedGain, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class MarginFigures(Summary):
    """Margins of a loop: of gain, phase and delay, the peak of its sensitivity, its bandwidth, and noise that passes."""

    gain: float
    phase_deg: float
    delay_cycles: float
    peak: float
    bandwidth_hz: float
    noise_variance: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LatencyFigures(Summary):
    """A latency: the gain at which the loop is unstable, and the margins of two gains; None beyond it."""

    cycles: int
    limit: float
    published: MarginFigures | None
    chosen: MarginFigures | None


@dataclass(frozen=True, slots=True, kw_only=True)
class GainNeeded(Summary):
    """The best gain at a latency and noise, and what error it leaves."""

    latency_cycles: int
    noise_mm: float
    gain: float | None
    expected_rms_mm: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class LapFigures(Summary):
    """Learning from lap to lap."""

    name: str
    lead_cycles: int
    factor: float
    square_rms_mm: tuple[float, ...]
    circle_rms_mm: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class JointLagFigures(Summary):
    """What was identified of a joint: how late it is, and its lost motion."""

    late_ms: float
    lost_deg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SensitivityFigures(Summary):
    """The circle under another assumption."""

    name: str
    before_path_mean_mm: float
    after_path_mean_mm: float
    reduction: float
    reduction_seen: float
    after_tool_rms_mm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerSummary(Summary):
    """The paper's two tests in simulation, and what does better. lags: None for a joint that the paths don't move."""

    cell: str
    law: LawFigures
    published: tuple[ComparisonFigures, ...]
    square: SquareFigures
    circle: CircleFigures
    variants: tuple[VariantFigures, ...]
    gain: GainFigures
    latency: tuple[LatencyFigures, ...]
    gain_needs: tuple[GainNeeded, ...]
    learning: tuple[LapFigures, ...]
    lags: Mapping[str, JointLagFigures | None]
    sensitivity: tuple[SensitivityFigures, ...]
    equation_2_off_mm: float
    provenance: Mapping[str, str] = keyed("standings")
    files: tuple[str, ...]
