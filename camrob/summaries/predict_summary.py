"""What `camrob predict` says: predict.json."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.summaries.base import Summary, keyed, left_out
from camrob.summaries.remarks import Remark

__all__ = [
    "DeviationSize",
    "HeldToPart",
    "HolderMeets",
    "LikelySize",
    "PartPlace",
    "PredictSeconds",
    "PredictSummary",
    "PredictedForce",
    "PredictedPlace",
    "PredictedRegion",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviationSize(Summary):
    """Deviations of a surface from the programmed one, along its normal: rms, the 95th percentile and the largest of their sizes,
    and their mean with its sign (above 0: material is left).
    """

    points: int
    rms_mm: float
    p95_mm: float
    worst_mm: float
    mean_mm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LikelySize(Summary):
    """What an error, of surface or tool, is likely to be on a machine of which nothing more is known than was found: that
    of the middle machine, with what 2.5 % (`low`) and 97.5 % (`high`) of the machines stay below.
    """

    rms_mm: float
    rms_low_mm: float
    rms_high_mm: float
    p95_mm: float
    p95_low_mm: float
    p95_high_mm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictedPlace(Summary):
    """One of the worst places: where in the part (mm), the program's line, the deviation and its 95 % band, the largest cause
    with its part of the deviation (mm), and which share of the sizes of all causes that is.
    """

    x_mm: float
    y_mm: float
    z_mm: float
    line: int
    deviation_mm: float
    band_mm: float
    cause: str
    cause_mm: float
    share: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictedRegion(Summary):
    """A file of the program: what it cuts."""

    file: str
    first_line: int
    last_line: int
    size: DeviationSize


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictedForce(Summary):
    """The force that was reckoned with: its file, in words, the share of it by which it may be wrong; the axes that yield under
    it as far as was found, whether tool and holder do; what 95 % of the run's rows deflect by at most.
    """

    model: str
    words: str = keyed("told")
    doubt: float
    yields: tuple[str, ...]
    granted: tuple[str, ...] = left_out(())
    tool: bool
    deflection_p95_mm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PartPlace(Summary):
    """A place of the cut surface (mm, in the part), the program's line that cut it, and by how much material stands there beyond
    the part's mesh (below 0: a gouge).
    """

    x_mm: float
    y_mm: float
    z_mm: float
    line: int
    deviation_mm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldToPart(Summary):
    """The cut surface held to the part's own mesh, with what the CAM left of it: deviations along the normal, volumes that the
    part lacks and that stand beyond it; the deepest gouges and the thickest rests. elsewhere: cut points with no wall of the part
    near; beyond_stock_mm: by how much the mesh reaches out of the stock.
    """

    mesh: str
    size: DeviationSize
    gouged_mm3: float
    left_mm3: float
    gouges: tuple[PartPlace, ...]
    rests: tuple[PartPlace, ...]
    elsewhere: int
    beyond_stock_mm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class HolderMeets(Summary):
    """Where the holder goes through material, as the stock is at that moment: the program's lines from first to last, and mm3."""

    first_line: int
    last_line: int
    taken_mm3: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictSeconds(Summary):
    """How long the stages took."""

    simulate: float
    path: float
    cut: float
    whole: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictSummary(Summary):
    """The part as it would come out. rms_mm, p95_mm, worst_mm: of what is expected of each point, which is less than what
    comes out where much is in doubt; likely: with that doubt. band_mm: 95 % of a deviation's doubt lie within it, either
    way, the middle one of all points; causes: rms (mm) of each one's part of the deviations. rest_mm: standard deviation in
    one direction of what nothing explains. reckoned: points of which the cut stock tells nothing, as another wall is where
    theirs would be: what the causes make of them to first order. not_met: points left out. not_reckoned: causes that were found
    and this run does not tell. not_judged: what else a real cut has. force: where a force model was given; part: where the set-up
    has the part's mesh; holder: where it has the holder (none: it meets nothing). meant: the program that says what the part is
    to be, "" for its own.
    """

    program: str
    cell: str
    calibration: str
    diagnosis: str
    pitch_mm: float
    points: int
    rms_mm: float
    p95_mm: float
    worst_mm: float
    mean_mm: float
    band_mm: float
    band_p95_mm: float
    likely: LikelySize
    percentiles_mm: Mapping[str, float]
    causes: Mapping[str, float]
    rest_mm: float
    places: tuple[PredictedPlace, ...]
    regions: tuple[PredictedRegion, ...]
    reckoned: int
    not_met: int
    not_reckoned: tuple[str, ...]
    not_judged: tuple[str, ...]
    warnings: tuple[Remark, ...]
    files: tuple[str, ...]
    seconds: PredictSeconds
    force: PredictedForce | None = left_out(None)
    part: HeldToPart | None = left_out(None)
    holder: tuple[HolderMeets, ...] | None = left_out(None)
    meant: str = ""
