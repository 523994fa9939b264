"""What `camrob tune-engines` says: tune.json."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.summaries.base import Summary

__all__ = ["TuneSummary", "TunedFigures", "TunedWay"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TunedFigures(Summary):
    """What weights come to on a set of paths, means over the paths that were followed.

    price: m for each metre cut. travel: of each external axis while cutting, mm and degrees. feed_held_percent: of the length.
    """

    paths: int
    followed: int
    price: float
    price_by_seed: tuple[float, ...]
    inv_kf_mean: float | None
    inv_kf_min: float | None
    travel: Mapping[str, float]
    feed_held_percent: float | None
    margin_min_deg: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class TunedWay(Summary):
    """A way to weigh the joints: where it was fitted, and on the paths withheld from the fit (None: none were).

    weights: the constants of the best seed, by output; empty for rules. file: its .fis in `out`; empty for the cell's own rules.
    """

    way: str
    tried: int
    trained: TunedFigures
    withheld: TunedFigures | None
    weights: Mapping[str, float]
    file: str


@dataclass(frozen=True, slots=True, kw_only=True)
class TuneSummary(Summary):
    """Rules and constants fitted alike, and which of them costs least where it was not fitted.

    table_error_percent: how far off the compiled table of the cell's engine is at worst, scikit-fuzzy being the judge, and
    `table_error_at` where, by axis in its unit.
    """

    cell: str
    engine: str
    budget: int
    seeds: int
    trained_on: tuple[str, ...]
    withheld: tuple[str, ...]
    ways: tuple[TunedWay, ...]
    best: str
    judged_by: str
    table_error_percent: float
    table_error_at: Mapping[str, float]
    files: tuple[str, ...]
