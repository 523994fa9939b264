"""The surface that a path cuts into stock, beside the one that the program asks for: deviation, band, causes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import CutSurface, Dexels, MetByRays, Moves, deviation, met_by_rays
from camrob.cutting.way import Way
from camrob.prediction.band import band_within
from camrob.prediction.likely import DRAWN_POINTS, LikelySizes, likely_sizes
from camrob.prediction.true_path import TruePath
from camrob.progress import Share, part_of
from camrob.runs import runs_of
from camrob.se3 import inverse

__all__ = ["CuttersOfRun", "PredictedSurface", "predict_surface", "way_of"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_CHUNK = 100_000  # points at once
_STRAIGHT = 1e-6  # m that rows of a run may lie off one straight move: what is predicted are hundredths of a mm
_FARTHEST = 2e-3  # m: what a ray meets farther off is another wall, where the causes make no more of it
# of the distance that causes make to first order, and besides: by so much the cutter's curvature may change it (2 % were found at
# errors of a fifth of the cutter's radius, and errors here are no larger than it); another wall is farther off
_CURVED, _CURVED_ANYWAY = 0.5, 5e-5  # m


@dataclass(frozen=True)
class PredictedSurface:
    """P points of the surface, in `part`. point, normal: (P, 3), out of the material; deviation: (P,) m by which the material
    stands beyond what was programmed (below 0: cut too deep); band: (P,) m, 95 % of the deviation lie within it, either way.

    row: (P,) row of the run that cut there, at: (P,) which share of the way to the next; shares: (P, C) m of the deviation by
    cause, `rounding` (P,) that of the controller's rounded corners, `runout` (P,) that of a cutter that runs out of true.
    likely: how large deviations are on the machines that a diagnosis leaves open.
    reckoned: how many points' rays meet another wall than their own on the machine, whose deviation is what the causes make of it
    to first order. not_met: points left out, as the exact path cuts no wall near them. left: what the machine leaves of the
    stock, on its way `real`.
    """

    point: Array
    normal: Array
    deviation: Array
    band: Array
    row: Ints
    at: Array
    shares: Array
    rounding: Array
    runout: Array
    likely: LikelySizes
    reckoned: int
    not_met: int
    left: Dexels
    real: Way


@dataclass(frozen=True)
class CuttersOfRun:
    """The cutters of a program. runout: m by which the axis of each lies beside the spindle's; what it sweeps is a cutter of that
    much more radius, its corner as it is. of_run, of_programmed: (N,) and (M,) which of them each row of the run, and of the path
    without any rounding, has; None: the only one.
    """

    cutters: tuple[Cutter, ...]
    runout: tuple[float, ...]
    of_run: Ints | None = None
    of_programmed: Ints | None = None

    def swept(self) -> tuple[Cutter, ...]:
        """What they sweep, out of true as they run."""
        return tuple(replace(c, radius=c.radius + r) for c, r in zip(self.cutters, self.runout, strict=True))


class _Contacts(NamedTuple):
    """Where points of a surface are cut: point (P, 3), push (P, 3), by whose product with a shift of the tool the deviation
    changes, and row (P,) of the run, at (P,) which share of the way to the next.
    """

    point: Array
    push: Array
    row: Ints
    at: Array

    def of(self, some: Ints | slice) -> _Contacts:
        """Those of some points."""
        return _Contacts(self.point[some], self.push[some], self.row[some], self.at[some])

    def where(self, own: NDArray[np.bool_], met: MetByRays, real: Way) -> _Contacts:
        """Of points whose own wall (P,) rays have met, where the machine cuts it: a tool that is off along the surface cuts with
        another part of its edge, another slope of it, and maybe on another pass.
        """
        out = _Contacts(self.point.copy(), self.push.copy(), self.row.copy(), self.at.copy())
        out.point[own], out.push[own] = met.point[own], met.push[own]
        out.row[own], out.at[own] = real.rows(met.move[own], met.at[own])
        return out

    def on(self, values: Array) -> Array:
        """Values (N, ...) of the run where the points are cut."""
        return _between(values, self.row, self.at)

    def wrench(self, path: TruePath, part_T_base: Array) -> Array:
        """(P, 6) by which a twist of the tool in `base` moves the points: push . (v + w x r)."""
        arm = self.point - self.on((part_T_base @ path.ideal)[:, :3, 3])
        turn = part_T_base[:3, :3]
        return np.concatenate([self.push @ turn, np.cross(arm, self.push) @ turn], axis=1)


def predict_surface(
    stock: Dexels,
    tools: CuttersOfRun,
    base_T_part: Array,
    path: TruePath,
    programmed: Array,
    *,
    progress: Share | None = None,
) -> PredictedSurface:
    """Cut the stock three times: as the simulated controller goes, as programmed, and as the machine goes.

    stock: in `part`, left as it is. programmed: (M, 4, 4) tool in `base` on the path without any rounding. progress: called with
    the share that is carved.
    """
    part_T_base = inverse(base_T_part)
    meant = way_of(part_T_base @ path.ideal, tools.cutters, tools.of_run, path.line)
    asked = way_of(part_T_base @ programmed, tools.cutters, tools.of_programmed)
    real = way_of(part_T_base @ path.true, tools.swept(), tools.of_run, path.line)

    def carved(k: int, way: Way) -> Dexels:
        left = stock.copy()
        left.carve(way.moves, None if progress is None else part_of(progress, k, 3))
        return left

    surface = carved(0, meant).surface(meant.moves)
    rounding = -deviation(surface, asked.moves, carved(1, asked), farthest=_FARTHEST)
    left = carved(2, real)
    contacts = _Contacts(surface.point, surface.normal, *meant.rows(surface.move, surface.at))
    row, at = contacts.row, contacts.at
    twists = np.stack([c.twist for c in path.causes], axis=2) if path.causes else np.zeros((len(path.t), 6, 0))
    shares = _shares(contacts, path, twists, part_T_base)
    runout = np.array(tools.runout)[0 if tools.of_run is None else tools.of_run[row]]
    wider = -runout * _across(surface, meant.moves)
    due = shares.sum(axis=1) + wider
    slope = np.abs(surface.normal[np.arange(len(due)), surface.direction])
    met = met_by_rays(surface, real.moves, left, farthest=np.maximum(_FARTHEST, (1.0 + _CURVED) * np.abs(due) / slope))
    own = _own_wall(met.deviation, due)
    moved = np.where(own, met.deviation, due)
    there = contacts.where(own, met, real)
    band = _band(there, path, part_T_base) + _other_wall(own, met.deviation, due)
    keep = np.flatnonzero(np.isfinite(rounding))
    some = keep[np.linspace(0, len(keep) - 1, min(len(keep), DRAWN_POINTS)).astype(np.int64)]
    likely = _likely(there.of(some), path, part_T_base, (rounding + moved)[some])
    return PredictedSurface(
        point=surface.point[keep],
        normal=surface.normal[keep],
        deviation=(rounding + moved)[keep],
        band=band[keep],
        row=row[keep],
        at=at[keep],
        shares=shares[keep],
        rounding=rounding[keep],
        runout=wider[keep],
        likely=likely,
        reckoned=int(np.count_nonzero(~own[keep])),
        not_met=int(len(rounding) - len(keep)),
        left=left,
        real=real,
    )


def way_of(part_T_tool: Array, cutters: Sequence[Cutter], number: Ints | None = None, line: Ints | None = None) -> Way:
    """The way along poses (N, 4, 4) of the cutters with these numbers (N,), None for the first; moves belong to one line of the
    program (N,) each.
    """
    number = np.zeros(len(part_T_tool), np.int64) if number is None else np.array(number)
    lone = np.flatnonzero(np.diff(number)[1:] * np.diff(number)[:-1]) + 1  # a row by itself cuts nothing
    number[lone] = number[lone - 1]
    ways = []
    for rows in runs_of(number):
        tip, axis = part_T_tool[rows, :3, 3].copy(), part_T_tool[rows, :3, 2].copy()
        label = None if line is None else line[rows]
        which = int(number[rows.start])
        way = Way.of(tip, axis, cutters[which], tolerance=_STRAIGHT, label=label)
        moves = replace(way.moves, cutter=np.full(len(way.moves.tip), which), cutters=tuple(cutters))
        ways.append(replace(way, moves=moves))
    return _joined(ways)


def _joined(ways: Sequence[Way]) -> Way:
    """Ways one behind another, of cutters from one list; between two of them nothing is cut."""
    tips: list[Array] = []
    axes: list[Array] = []
    along: list[Array] = []
    numbers, kept = [], []
    for way in ways:
        if tips:
            tips.append(np.stack([tips[-1][-1, 1], way.moves.tip[0, 0]])[None])
            axes.append(np.stack([axes[-1][-1, 1], way.moves.axis[0, 0]])[None])
            numbers.append(np.array([-1]))
        tips.append(way.moves.tip)
        axes.append(way.moves.axis)
        numbers.append(way.moves.cutter)
        kept.append(way.kept + sum(len(a) for a in along))
        along.append(way.along + (along[-1][-1] if along else 0.0))
    tip, axis, number = (np.concatenate(x) for x in (tips, axes, numbers))
    return Way(Moves(tip, axis, number, ways[0].moves.cutters), np.concatenate(kept), np.concatenate(along))


def _across(surface: CutSurface, moves: Moves) -> Array:
    """(P,) how much of the normal at points lies across the tool's axis."""
    row, at = surface.move, surface.at[:, None]
    axis = moves.axis[row, 0] * (1.0 - at) + moves.axis[row, 1] * at
    along = np.sum(surface.normal * axis, axis=1) / np.linalg.norm(axis, axis=1)
    return np.asarray(np.sqrt(np.maximum(0.0, 1.0 - along**2)))


def _own_wall(moved: Array, reckoned: Array) -> NDArray[np.bool_]:
    """(P,) whether what a ray has met tells where the surface is: where grooves cross, it may run on to another's wall, or to
    none, and its length says nothing of the error. Nearer than the causes move its own wall, to first order, it is what another
    part of the way cuts there, as of a tool that is late and comes all the same. reckoned: (P,) m by which they move it.
    """
    return np.asarray(np.abs(moved) <= (1.0 + _CURVED) * np.abs(reckoned) + _CURVED_ANYWAY)


def _other_wall(own: NDArray[np.bool_], moved: Array, reckoned: Array) -> Array:
    """(P,) m between where a point's own wall is reckoned to be and the one that a ray meets there instead, 0 where it meets its
    own or none: whoever measures the part finds the one or the other, and the band reaches to both.
    """
    return np.where(own | ~np.isfinite(moved), 0.0, np.abs(moved - reckoned))


def _shares(contacts: _Contacts, path: TruePath, twists: Array, part_T_base: Array) -> Array:
    """(P, C) m of the deviation by cause, to first order."""
    shares = np.zeros((len(contacts.row), twists.shape[2]))
    for some in _chunks(len(shares)):
        own = contacts.of(some)
        shares[some] = np.einsum("pi,pik->pk", own.wrench(path, part_T_base), own.on(twists))
    return shares


def _band(contacts: _Contacts, path: TruePath, part_T_base: Array) -> Array:
    """(P,) m within which 95 % of the deviations of points that are cut there lie, either way."""
    band = np.zeros(len(contacts.row))
    for some in _chunks(len(band)):
        own = contacts.of(some)
        wrench = own.wrench(path, part_T_base)
        lever = np.sum(wrench[:, :3] ** 2, axis=1)
        variance = np.sum(np.einsum("pi,pik->pk", wrench, own.on(path.spread)) ** 2, axis=1)
        unsized = np.zeros(len(variance)) if path.unsized is None else lever * own.on(path.unsized) ** 2
        band[some] = band_within(variance + lever * own.on(path.rest) ** 2, unsized)
    return band


def _likely(contacts: _Contacts, path: TruePath, part_T_base: Array, deviation: Array) -> LikelySizes:
    """Sizes on machines that are drawn, of some points with their expected deviations."""
    wrench = contacts.wrench(path, part_T_base)
    own = np.einsum("pi,pik->pk", wrench, contacts.on(path.spread))
    together = np.zeros((len(deviation), 0)) if path.together is None else contacts.on(path.together)
    lever = np.linalg.norm(wrench[:, :3], axis=1)
    apart = contacts.on(path.rest) ** 2 - np.sum(together**2, axis=1)
    return likely_sizes(deviation, wrench[:, :3], own, together, lever * np.sqrt(np.maximum(apart, 0.0)))


def _chunks(count: int) -> list[slice]:
    return [slice(start, start + _CHUNK) for start in range(0, count, _CHUNK)]


def _between(values: Array, row: Ints, at: Array) -> Array:
    """Values (N, ...) of the run between its rows: (P, ...) at shares (P, 1) of the way to the next."""
    share = at.reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(values[row] * (1.0 - share) + values[row + 1] * share)
