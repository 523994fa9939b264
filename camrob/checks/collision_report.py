"""What a collision check found, as data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from camrob.findings import Finding
from camrob.frozen import locked
from camrob.units import m_to_mm

__all__ = ["CollisionReport", "PairClearance", "joined_collisions"]

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class PairClearance:
    """Two bodies: `count` points at which (or on the way to which) they touch, `first` of them (-1: none), the smallest
    clearance found (m, 0.0 where they touch) and the point where it is, and how finely that was looked for: `samples`,
    and the largest motion between two of them that no clearance covered (m; 0.0: all in between is proven).
    """

    pair: tuple[str, str]
    groups: tuple[str, str]
    count: int
    first: int
    clearance: float
    at: int
    samples: int
    largest_step: float


@dataclass(frozen=True, slots=True)
class CollisionReport:
    """What a collision check found.

    checked: False where the cell has no bodies to check. count: points at which (or on the way to which) anything
    touches; hit: (M,) which ones. findings: one for each two groups that touch, at the first point. clearance_min: m,
    the smallest between any two bodies but tool and part, found to within a millimetre or a tenth of it, with the point
    and the pair (None, -1 and () where nothing was checked). points, samples: on the path, and taken in all pairs.
    largest_step: m, the largest motion of a body between two samples of a pair that their clearance did not cover, so
    that only a touch shallower than this can be missed. skipped: pairs that were left out, with the reason.
    """

    checked: bool
    count: int
    findings: tuple[Finding, ...]
    clearance_min: float | None
    clearance_at: int
    clearance_pair: tuple[str, ...]
    pairs: tuple[PairClearance, ...]
    points: int
    samples: int
    largest_step: float
    hit: Mask
    skipped: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "hit", locked(self.hit, shape=(None,), dtype=np.bool_, name="hit"))

    @property
    def sampled(self) -> str:
        """How finely the path was looked at, in words."""
        if not self.checked:
            return "no collisions were checked: the cell has no bodies"
        text = f"{len(self.pairs)} pairs of bodies along {self.points} points, {self.samples} samples"
        if self.largest_step <= 0.0:
            return text + "; between them the clearance covers every motion"
        return text + f"; between them no body moved by more than its clearance or {m_to_mm(self.largest_step):.2f} mm"


def joined_collisions(reports: Sequence[CollisionReport]) -> CollisionReport:
    """Reports of parts of a path as one; points are counted on from part to part."""
    begins = np.cumsum([0, *(len(r.hit) for r in reports)]).tolist()
    placed = list(zip(begins, reports, strict=False))
    known = [(r.clearance_min, k) for k, r in enumerate(reports) if r.clearance_min is not None]
    k = min(known)[1] if known else 0
    least = reports[k]
    return CollisionReport(
        checked=all(r.checked for r in reports),
        count=sum(r.count for r in reports),
        findings=tuple(replace(f, point=f.point + begin) for begin, r in placed for f in r.findings),
        clearance_min=least.clearance_min,
        clearance_at=begins[k] + least.clearance_at if known else -1,
        clearance_pair=least.clearance_pair,
        pairs=tuple(
            replace(p, first=p.first + begin if p.first >= 0 else -1, at=p.at + begin)
            for begin, r in placed
            for p in r.pairs
        ),
        points=sum(r.points for r in reports),
        samples=sum(r.samples for r in reports),
        largest_step=max(r.largest_step for r in reports),
        hit=np.concatenate([np.asarray(r.hit) for r in reports]),
        skipped=tuple(dict.fromkeys(text for r in reports for text in r.skipped)),
    )
