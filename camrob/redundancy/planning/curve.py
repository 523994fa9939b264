"""The curve of plans from still to flowing external axes, with more points about the one that is taken."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.redundancy.clock import Clock
from camrob.redundancy.planning.certificate import Certificate, Survey
from camrob.redundancy.planning.choice import CurvePoint, Knee, plan_point
from camrob.redundancy.planning.course import RETRACT_PRICE, Draft, draft_course, relaxed, search, stopped
from camrob.redundancy.planning.forbidding import RoomOf
from camrob.redundancy.planning.freedoms import PlanSpace
from camrob.redundancy.planning.layers import Nodes, candidate_nodes, region_seeds
from camrob.redundancy.planning.local_lattice import local_nodes
from camrob.redundancy.planning.objective import Objective
from camrob.redundancy.planning.waypoints import Waypoints

__all__ = ["SEARCH_FLOWING", "Landscape", "landscape", "plan_curve"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

STILL_SEEDS, FLOW_SEEDS = 10, 24  # external postures that are tried at each coarse waypoint
FLOWING = 0.02  # share of the cell's travel price that flowing axes pay
SEARCH_FLOWING = 0.1  # and in the search, whose candidates are coarse
LOOSENED = (1.0, 0.3)  # shares at which the still plan is let go
SEARCHED = (0.7, 0.4, 0.3, 0.2)  # shares at which a plan is searched for
BISECTIONS = 3  # further searches about the point that is taken
STILL, _LET_GO = "still", "let go"
_FROM_STILL = (STILL, _LET_GO)  # points that begin with external axes that stand still


@dataclass(frozen=True, slots=True)
class Landscape:
    """What all plans of one path are made from: waypoints, their bound, and candidates at every few of them."""

    cell: Cell
    space: PlanSpace
    objective: Objective
    w: Waypoints
    certificate: Certificate
    coarse: Ints
    still_nodes: Nodes | None
    flow_nodes: Nodes | None
    room_of: RoomOf | None = None

    def searched(self, travel: float, *, still: bool = False, retract: float = RETRACT_PRICE) -> Draft | None:
        """The search's draft, external travel priced `travel` times the cell's weight, a retract `retract`, m; None where
        nothing leads through.
        """
        nodes = self.still_nodes if still else self.flow_nodes
        if nodes is None or np.any(np.diff(nodes.offset) == 0):
            return None
        at = self.w.take(self.coarse)
        way = search(
            self.space, self.objective, at, nodes, still=still, travel=travel, retract=retract, room_of=self.room_of
        )
        if way.reached < len(at):
            return None
        return draft_course(self.space, self.w, self.coarse, nodes, way, self.cell.q_home[self.space.free])

    def cuts(self, draft: Draft) -> Ints:
        """Path points of a draft's re-postures at which the tool is not clear of the part."""
        jump = draft.index[1:][~draft.joined[1:]]
        return np.asarray(self.w.point[jump[~self.w.safe[jump]]], np.int64)

    def point(self, name: str, draft: Draft, travel: float) -> CurvePoint:
        """A draft as a point of the curve, which pays a share of the price of travel."""
        figures = plan_point(self.cell, self.space, self.objective, self.w, self.certificate, name, draft)
        return CurvePoint(name, draft, figures, travel)

    def again(self, point: CurvePoint) -> CurvePoint | None:
        """A point of the curve made anew, by what the objective has come to forbid, if it can be only about that; None where it
        does not lead through.
        """
        still, draft = point.name.startswith(_FROM_STILL), None
        travel = 1.0 if still else max(point.travel, SEARCH_FLOWING)
        if not still and self.flow_nodes is not None:
            local = local_nodes(self.flow_nodes, self.w, self.coarse, point.draft, self.objective.blocked)
            draft = replace(self, flow_nodes=local).searched(travel)
        if draft is None or len(self.cuts(draft)):
            draft = self.searched(travel, still=still)
        if draft is None or len(self.cuts(draft)):
            return None
        if still:
            draft = stopped(self.space, self.objective, self.w, draft)
        return self.point(
            point.name, draft if point.name == STILL else _refined(self, draft, point.travel), point.travel
        )


def landscape(
    cell: Cell,
    space: PlanSpace,
    objective: Objective,
    w: Waypoints,
    survey: Survey,
    certificate: Certificate,
    coarse: Ints,
    *,
    still: bool,
    flow: bool,
    room_of: RoomOf | None = None,
) -> Landscape:
    """Candidates for still axes, for flowing ones, or for both. room_of: what the search asks of those that it would take."""
    at, every = w.take(coarse), room_of is not None
    still_nodes = flow_nodes = None
    if still:
        seeds = _seeds(w, coarse, survey, STILL_SEEDS, spread=False)
        still_nodes = candidate_nodes(space, objective, at.base_T_tip, seeds, push=at.push, every=every)
    if flow:
        some = Certificate(certificate.inv_kf[coarse], certificate.u[coarse], certificate.branch[coarse])
        seeds = _seeds(w, coarse, survey, FLOW_SEEDS, spread=True)
        flow_nodes = candidate_nodes(space, objective, at.base_T_tip, seeds, some, at.push, every=every)
    return Landscape(cell, space, objective, w, certificate, coarse, still_nodes, flow_nodes, room_of)


def plan_curve(
    land: Landscape, still: Draft | None, flowing: Draft | None, knee: Knee | None, clock: Clock
) -> tuple[list[CurvePoint], int]:
    """The curve's points, from still to flowing, and how many there was no time for: one end there is in any case.

    still, flowing: the search's drafts for the ends, None for an end that is not wanted or does not lead through in one piece.
    With a knee there are points between: the still plan let go, and plans searched for at lower and lower prices of
    travel, the last ones about the point that the knee takes.
    """
    missed: list[float] = []

    def timely(share: float) -> CurvePoint | None:
        if clock.up:
            missed.append(share)
            return None
        return _between(land, share)

    with ThreadPoolExecutor(2) as pool:  # the kernels release the interpreter's lock
        from_still = pool.submit(_from_still, land, still, LOOSENED if knee is not None else (), clock, missed)
        last = []
        if flowing is not None and clock.up and still is not None:
            missed.append(FLOWING)
        elif flowing is not None:
            last = [land.point("flowing", _refined(land, flowing, FLOWING), FLOWING)]
        first = from_still.result()
        if knee is None or land.flow_nodes is None:
            return [*first, *last], len(missed)
        between = dict(zip(SEARCHED, pool.map(timely, SEARCHED), strict=True))
    for _again in range(BISECTIONS):
        shares = [s for s, p in sorted(between.items(), reverse=True) if p is not None]
        gap = knee.between([*first[:1], *(between[s] for s in shares), *last])  # type: ignore[list-item]
        if gap is None:
            break
        around = [*([1.0] if first else []), *shares, *([SEARCH_FLOWING] if last else [])]
        share = float(np.sqrt(around[gap] * around[gap + 1]))
        between[share] = timely(share)
        if between[share] is None:
            break
    return [*first, *(p for _share, p in sorted(between.items(), reverse=True) if p is not None), *last], len(missed)


def _refined(land: Landscape, draft: Draft, travel: float) -> Draft:
    return relaxed(land.space, land.objective, land.w, draft, travel)


def _from_still(
    land: Landscape, draft: Draft | None, shares: Sequence[float], clock: Clock, missed: list[float]
) -> list[CurvePoint]:
    """The still plan, and it let go at `shares` of the price of travel, each begun from the one before, while there is time."""
    if draft is None:
        return []
    draft = stopped(land.space, land.objective, land.w, draft)
    points = [land.point(STILL, draft, 1.0)]
    for share in shares:
        if clock.up:
            missed.append(share)
            continue
        draft = _refined(land, draft, share)
        points.append(land.point(f"{_LET_GO}, x{share:g}", draft, share))
    return points


def _between(land: Landscape, share: float) -> CurvePoint | None:
    """The plan at a share of the price of travel; None where it does not lead through in one piece."""
    draft = land.searched(share)
    if draft is None or len(land.cuts(draft)):
        return None
    return land.point(f"x{share:.3g}", _refined(land, draft, share), share)


def _seeds(w: Waypoints, coarse: Ints, survey: Survey, count: int, *, spread: bool) -> list[Array]:
    """External postures (K, E) to try at each coarse waypoint: its region's; between regions both neighbours'. Axes that stand
    still have to get from one region's postures to the next one's at a safe point: it has those of the region beside it, too.
    """
    region = np.asarray(w.region)
    of = {
        int(r): region_seeds(survey, np.flatnonzero(region == r), count, spread=spread)
        for r in np.unique(region[region >= 0])
    }
    here = region[coarse]
    known = np.where(here >= 0, np.arange(len(here)), -1)
    before = np.maximum.accumulate(known)
    after = np.minimum.accumulate(np.where(here >= 0, np.arange(len(here)), len(here))[::-1])[::-1]
    seeds = []
    for k in range(len(here)):
        aside = 1 if w.safe[coarse[k]] and not spread else 0
        beside = range(max(k - aside, 0), min(k + aside + 1, len(here)))
        near = {int(here[j]) for i in beside for j in (before[i], after[i]) if 0 <= j < len(here)}
        seeds.append(np.unique(np.concatenate([of[r] for r in sorted(near)]), axis=0))
    return seeds
