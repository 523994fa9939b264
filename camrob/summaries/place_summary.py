"""What `camrob place` says: NAME.place.json."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from camrob.summaries.base import Summary, left_out

__all__ = ["PlaceSummary", "PlaceTrial", "Placement"]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceTrial(Summary):
    """A placement followed by the published method, on a thinned path."""

    method: str
    points: int
    inv_kf_mean: float
    inv_kf_min: float
    collisions_checked: bool
    clearance_min_mm: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Placement(Summary):
    """A placement, X .. C in mm and degrees; bounds of 1/k_F: None out of reach; standing: what is known for or against it."""

    part_in_base: tuple[float, ...]
    inv_kf_bound_mean: float | None
    inv_kf_bound_min: float | None
    standing: str
    trial: PlaceTrial | None = left_out()


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceSummary(Summary):
    """Where a part is worked best, beside where it lies now, and how many placements were refused for what.

    best: the best by its own trial of those that were tried, `now` where it stays; others: the other trials, the better first.
    border: along which of X, Y, Z `best` lies at the border of the search, so that a better one may lie beyond.
    """

    program: str
    cell: str
    now: Placement
    best: Placement
    stays: bool
    others: tuple[Placement, ...]
    placements: int
    in_reach: int
    table: str
    tried: int
    refused: Mapping[str, int]
    files: tuple[str, ...]
    border: tuple[str, ...] = ()
