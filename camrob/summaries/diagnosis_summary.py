"""What `camrob diagnose` says: diagnosis.json, as the contract fixes it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt

from camrob.summaries.base import OpenSummary, Summary, keyed, left_out, spread
from camrob.summaries.diagnosis_places import AddedLoad, AxisReport, Places, StageWithin, Standard
from camrob.summaries.fitted.diagnosis_fitted import FittedModel
from camrob.summaries.fitted.instrument_figures import InstrumentSuspect
from camrob.summaries.fitted.since import Since

__all__ = [
    "CLEAR_SIGMAS",
    "LIKELY",
    "Alternative",
    "Compensable",
    "ConsideredMotion",
    "CornerFigures",
    "DiagnosisSummary",
    "EffectFound",
    "ExperimentFigures",
    "ExperimentWritten",
    "FittedValue",
    "GapFigures",
    "Latency",
    "RegimeLeft",
    "Residual",
    "Shrunk",
    "Together",
    "Unknown",
    "UnknownPlace",
    "UnknownShape",
    "WithheldRegime",
    "worth_running",
]

Interval = tuple[float, float]

CLEAR_SIGMAS = 5.0  # a motion that tells less is not worth its time
_BETTER = 1.5  # times what the same again would tell: then a motion tells something new
LIKELY = 0.5  # of a name, or of something unknown, from which it is there rather than not
_SURE = 0.9  # of a name, from which it is acted on, whatever would show nearly the same


@dataclass(frozen=True, slots=True, kw_only=True)
class GapFigures(OpenSummary):
    """The gap over all logs; rms_deg: None where no orientation was measured; noise_mm: the instrument's, 3-D rms."""

    samples: int
    rms_mm: float
    p95_mm: float
    max_mm: float
    rms_deg: float | None
    noise_mm: float
    outliers: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Latency(OpenSummary):
    """s by which the instrument's rows trail the axis values, with its interval; None where it doesn't show."""

    value: float | None
    interval: Interval | None


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedValue(OpenSummary):
    """A fitted value with its standard deviation, in the unit that the parameter's name ends with.

    usual: its ordinary size on such a machine, 0 where nobody has said.
    """

    value: float
    std: float
    usual: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Shrunk(OpenSummary):
    """Errors on withheld samples before and after, and by how much the rms shrinks, with its interval."""

    rms_before_mm: float
    p95_before_mm: float
    max_before_mm: float
    rms_after_mm: float
    p95_after_mm: float
    max_after_mm: float
    shrink: float
    shrink_interval: Interval


@dataclass(frozen=True, slots=True, kw_only=True)
class CornerFigures(Summary):
    """Of the rounding of corners alone: the distance that programs ask for, None where they ask for several."""

    programmed_cdis_mm: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectFound(OpenSummary):
    """An effect: how likely it is at work, its values, and how far the gap shrinks with it, alone, and added last.

    alike: it and what these logs can't tell from it, with the probability of one of them; evidence: of the sets that hold it.
    implausible, unusual: what speaks against its values, "" for nothing. compensable: whether `compensate` can correct it.
    regimes: what such an effect follows. remedy: what a person does about it, "" where nobody has said. isolated_by: the run
    that would show it alone. of_machine: whether the tool itself is elsewhere, and not only the reading of it. physics: what it
    is, in a sentence. Files of before 2026-11-26 lack these four. axis_moves_mm: how far each of its axes moves the tool by its
    own values, rms; stands_out: of these the one that does far more than the others, or those that differ from what all share.
    since: what is at work since a change alone, beside what always was; None for what always was.
    """

    effect: str
    axes: tuple[str, ...]
    probability: float
    parameters: Mapping[str, FittedValue]
    rms_before_mm: float
    p95_before_mm: float
    max_before_mm: float
    rms_after_mm: float
    p95_after_mm: float
    max_after_mm: float
    shrink: float
    shrink_interval: Interval
    alone: Shrunk
    added_last: Shrunk
    moves_mm: float
    indistinguishable_from: tuple[str, ...]
    alike: tuple[str, ...] = keyed("class")
    class_probability: float
    evidence: float
    implausible: str
    compensable: bool
    stages: tuple[str, ...] = keyed("rungs")
    regimes: tuple[str, ...]
    corner: CornerFigures | None = spread()
    unusual: str
    remedy: str = ""
    isolated_by: str = ""
    of_machine: bool = True
    physics: str = ""
    axis_moves_mm: Mapping[str, float] | None = left_out()
    stands_out: tuple[str, ...] = left_out(())
    since: Since | None = left_out()

    @property
    def called(self) -> str:
        """Its name, with when it came where it was not always there."""
        return self.effect if self.since is None else f"{self.effect} {self.since.words}"

    @property
    def claimed(self) -> bool:
        """Whether it is claimed, and not only considered."""
        return self.probability >= LIKELY

    @property
    def like_others(self) -> bool:
        """Whether it may be another that shows nearly the same, so that nothing is to be changed for its name yet."""
        return bool(self.indistinguishable_from) and self.probability < _SURE


@dataclass(frozen=True, slots=True, kw_only=True)
class WithheldRegime(OpenSummary):
    """What is left in a regime that took no part in the fit, and whether it is worse than nothing there."""

    regime: str
    what: str
    samples: int
    rms_before_mm: float
    rms_after_mm: float
    shrink: float
    shrink_interval: Interval
    doubt_mm: float
    worse: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Together(OpenSummary):
    """All claimed effects together, on what was withheld; removable_removed: None where nothing is removable."""

    rms_before_mm: float
    p95_before_mm: float
    max_before_mm: float
    rms_after_mm: float
    p95_after_mm: float
    max_after_mm: float
    shrink: float
    shrink_interval: Interval
    withheld: str
    left_aside: int
    predicted_shrink: float
    expected_after_mm: float
    removable_removed: float | None
    compensable_mm: float
    regimes_withheld: tuple[WithheldRegime, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Alternative(OpenSummary):
    """A set of effects that explains the logs, whatever is unknown beside it, and its probability; none is the unknown alone."""

    effects: tuple[str, ...]
    probability: float


@dataclass(frozen=True, slots=True, kw_only=True)
class UnknownShape(OpenSummary):
    """Something unexplained: its stage, what moves, what that follows, and how far it swings, in `unit`."""

    stage: str = keyed("rung")
    moves: str
    follows: str
    swing: float
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class UnknownPlace(OpenSummary):
    """Where the unknown sits: stage (None for nowhere), axes, what it follows, how it comes back ("every 1.14 s", "" for not)."""

    stage: str | None = keyed("rung")
    axes: tuple[str, ...]
    regimes: tuple[str, ...]
    comes_back: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Unknown(OpenSummary):
    """How likely the library lacks a cause, how much of the withheld gap stays beside what is claimed and which share of its
    energy that is, where it sits, and effects that would fit with values no machine has. isolated_by: the run that would show
    it alone, "" where it is not likely, and in files of before 2026-11-27.
    """

    probability: float
    rms_mm: float
    share: float
    where: UnknownPlace
    text: str
    shapes: tuple[UnknownShape, ...]
    implausible: Mapping[str, str]
    isolated_by: str = left_out("")

    @property
    def likely(self) -> bool:
        """Whether something unknown is at work rather than not."""
        return self.probability >= LIKELY


@dataclass(frozen=True, slots=True, kw_only=True)
class RegimeLeft(OpenSummary):
    """What the residual still depends on."""

    regime: str
    p_value: float
    share: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Residual(OpenSummary):
    """What stays on withheld samples, how much of it is correlated from sample to sample, and the discrepancy's fitted size."""

    rms_mm: float
    noise_mm: float
    structured_mm: float
    discrepancy_mm: float
    structure: tuple[RegimeLeft, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Compensable(OpenSummary):
    """What of the claimed effects `compensate` can correct, what it leaves, and the calibration that was written for it.

    fitted: all that is claimed, for `predict`; None in files of before 2026-11-22.
    """

    effects: tuple[str, ...]
    left: tuple[str, ...]
    rms_before_mm: float
    rms_after_mm: float
    shrink: float
    shrink_interval: Interval
    written: str | None = left_out()
    fitted: FittedModel | None = left_out()


@dataclass(frozen=True, slots=True, kw_only=True)
class ConsideredMotion(OpenSummary):
    """A motion that would set the rivals apart, and how far."""

    motion: str
    text: str
    separation_mm: float
    separation_sigmas: float


def worth_running(noises: float, sigmas: float, again_sigmas: float) -> bool:
    """Whether a motion shows a person more than the same again would: what it sets apart (rms), in noises of one sample, and in
    sigmas over all of them.
    """
    return noises >= 1.0 and sigmas >= max(CLEAR_SIGMAS, _BETTER * again_sigmas)


@dataclass(frozen=True, slots=True, kw_only=True)
class ExperimentWritten(Summary):
    """The experiment as a checked program; passed_over: motions that tell more and can't be run."""

    file: str
    files: tuple[str, ...]
    motion: str
    passed_over: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ExperimentFigures(OpenSummary):
    """The motion to run next, and the sets that it tells apart; separation: mm by which they lie apart on it, or that what is
    unexplained moves the tool by; expected: mm rms that each of the two expects there.
    """

    motion: str
    rivals: tuple[tuple[str, ...], ...]
    separation_mm: float | None
    separation_sigmas: float | None = left_out()
    again_sigmas: float | None = left_out()
    expected_mm: tuple[float, ...] | None = left_out()
    considered: tuple[ConsideredMotion, ...] | None = left_out()
    written: ExperimentWritten | None = left_out()


@dataclass(frozen=True, slots=True, kw_only=True)
class DiagnosisSummary(OpenSummary):
    """The diagnosis: the gap, where it lies, the effects that cause it, how far it shrinks, and what stays unknown.

    status: "explained", "partly explained", "unexplained" or "no gap". within: by logged stage, what the gap is within, "noise"
    or "tolerance", or "beyond"; within_values: by which values. aliases: effects that these logs can't tell apart.
    axes_report: axes of which both ends are logged. added_load: None where no drive shows it. experiment: None where there is
    nothing to tell apart. next_experiment_for: the effects that the next experiment would tell from others, or "unknown".
    changed: what became another between the logs or within one, in a sentence or two, "" for nothing.
    """

    cell: str
    without: tuple[str, ...]
    gap: GapFigures
    where: Places
    latency_s: Latency
    status: str
    within: Mapping[str, str]
    within_values: Mapping[str, StageWithin]
    effects: tuple[EffectFound, ...]
    together: Together
    alternatives: tuple[Alternative, ...]
    unknown: Unknown
    aliases: tuple[tuple[str, ...], ...]
    residual: Residual
    next_experiment: str
    next_experiment_for: tuple[str, ...] = left_out(())
    logs: tuple[str, ...]
    axes_report: Mapping[str, AxisReport]
    added_load: AddedLoad | None
    instrument: InstrumentSuspect
    compensable: Compensable
    experiment: ExperimentFigures | None = left_out()
    standards: tuple[Standard, ...]
    changed: str = left_out("")

    @property
    def claimed(self) -> tuple[EffectFound, ...]:
        """The effects that are claimed."""
        return tuple(e for e in self.effects if e.claimed)

    @property
    def unexplained_mm(self) -> float:
        """What stays on withheld samples beyond the noise, 3-D rms."""
        return sqrt(max(self.together.rms_after_mm**2 - self.gap.noise_mm**2, 0.0))

    @property
    def blamed_axes(self) -> tuple[str, ...]:
        """Axes of the effects that are claimed, then those at which what is unknown sits: what every chart begins with."""
        return tuple(dict.fromkeys([*(a for e in self.claimed for a in e.axes), *self.unknown.where.axes]))

    @property
    def blamed_regimes(self) -> tuple[str, ...]:
        """What the effects that are claimed follow, then what the unknown does."""
        return tuple(dict.fromkeys([*(r for e in self.claimed for r in e.regimes), *self.unknown.where.regimes]))
