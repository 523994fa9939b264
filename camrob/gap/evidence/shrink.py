"""How far the gap shrinks on samples that took no part in choosing or fitting."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.gap.evidence.design import Panel, make_panel
from camrob.gap.evidence.evidence import Fitted
from camrob.gap.evidence.model import Model, doubt_of, whole_gap
from camrob.gap.nuisances import NUISANCE, WITHHELD
from camrob.gap.observation.noise import find_outliers, noise_of
from camrob.gap.observation.scene import Scene
from camrob.summaries.diagnosis_summary import Shrunk
from camrob.units import m_to_mm

__all__ = [
    "Shrinkage",
    "Trial",
    "doubt_of_shrinkage",
    "drives_gap",
    "figures",
    "frame_columns",
    "settled",
    "settled_rms",
    "shrinkage",
    "trial_of",
]

Array = NDArray[np.float64]
Set = frozenset[int]

_DRAWS = 400  # of blocks, for an interval
_FEWEST = 12  # rows that frames are fitted to
RANK = 1e-9  # of the largest singular value of frames' columns


@dataclass(frozen=True)
class Shrinkage:
    """before, after: (M, 3) m at the TCP, on withheld samples; block: (M,). Intervals are block bootstraps, 90 %.

    floor: (M,) m2, the mean square that the noise of single poses has, NaN for samples of a path, which tell theirs by how they
    hang together.
    """

    before: Array
    after: Array
    block: NDArray[np.int64]
    floor: Array | None = None

    @property
    def rms_before(self) -> float:
        """m."""
        return _rms(self.before)

    @property
    def rms_after(self) -> float:
        """m."""
        return _rms(self.after)

    @property
    def shrink(self) -> float:
        """1 - after / before."""
        return 1.0 - self.rms_after / max(self.rms_before, 1e-12)

    def interval(self) -> tuple[float, float]:
        """90 % of `shrink`, whole blocks drawn anew."""
        names = np.unique(self.block)
        sums = np.array([[np.sum(e[self.block == b] ** 2) for b in names] for e in (self.before, self.after)])
        draws = np.random.default_rng(0).integers(0, len(names), (_DRAWS, len(names)))
        before, after = sums[0][draws].sum(axis=1), sums[1][draws].sum(axis=1)
        low, high = np.quantile(1.0 - np.sqrt(after / np.maximum(before, 1e-24)), [0.05, 0.95])
        return float(low), float(high)

    def structure(self, *, before: bool = False) -> float:
        """m: rms of what hangs together in what is left, or in the gap before, block by block; of single poses, what is more than
        their noise.
        """
        parts = []
        for b in np.unique(self.block):
            at = self.block == b
            r, floor = (
                (self.before if before else self.after)[at],
                float("nan") if self.floor is None else float(self.floor[at][0]),
            )
            if np.isfinite(floor):
                parts.append(np.sum(r**2, axis=1) - floor)
            else:
                parts += [np.sum(r[k:] * r[:-k], axis=1) for k in (1, 2, 3) if len(r) > 3 * k]
        return float(np.sqrt(max(0.0, float(np.mean(np.concatenate(parts)))))) if parts else 0.0

    def quantiles(self) -> dict[str, tuple[float, float]]:
        """95 % and largest error, before and after, m."""
        a, b = (np.linalg.norm(e, axis=1) for e in (self.before, self.after))
        return {
            "p95": (float(np.quantile(a, 0.95)), float(np.quantile(b, 0.95))),
            "max": (float(a.max()), float(b.max())),
        }


def figures(shrunk: Shrinkage) -> Shrunk:
    """rms, 95 % and worst error before and after, and by how much the rms shrinks, with its interval."""
    quantiles = shrunk.quantiles()
    return Shrunk(
        rms_before_mm=m_to_mm(shrunk.rms_before),
        p95_before_mm=m_to_mm(quantiles["p95"][0]),
        max_before_mm=m_to_mm(quantiles["max"][0]),
        rms_after_mm=m_to_mm(shrunk.rms_after),
        p95_after_mm=m_to_mm(quantiles["p95"][1]),
        max_after_mm=m_to_mm(quantiles["max"][1]),
        shrink=shrunk.shrink,
        shrink_interval=shrunk.interval(),
    )


def _rms(vectors: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))


@dataclass(frozen=True)
class Trial:
    """Withheld samples: panels, and for each the rows that are asked and the blocks that the fit leaves out; named: of logs that
    took no part, not of blocks. unfrozen: the panels as they were before frames that are not known were frozen in them.
    """

    panels: tuple[Panel, ...]
    unfrozen: tuple[Panel, ...]
    asked: tuple[tuple[int, NDArray[np.bool_], int | None], ...]
    name: str
    named: bool = False

    @property
    def aside(self) -> int:
        """How many samples are not asked, as nothing is known there of an effect that was found."""
        good = sum(int(np.count_nonzero(p.w_tcp[:, 0] > 0.0)) for p in self.panels)
        return good - sum(int(rows.sum()) for _, rows, _ in self.asked)


def trial_of(model: Model, withheld: Sequence[Scene]) -> Trial:
    """The withheld logs; without any, each block of the logs in turn. Rows at which nothing is known of an effect that was found
    are not asked.
    """
    found = np.flatnonzero(np.isin(model.design.owner, list(model.best.members)))
    if withheld:
        panels = []
        for k, scene in enumerate(withheld):
            noise = noise_of(scene)
            kept = ~find_outliers(scene, noise)
            panel = make_panel(
                scene, WITHHELD, model.units, model.effects, model.states, noise, kept, 10, 10 * k, model.basis
            )
            panels.append(panel)
        asked = tuple((k, (p.w_tcp[:, 0] > 0.0) & ~p.unknown_rows(found), None) for k, p in enumerate(panels))
        return Trial(tuple(panels), tuple(panels), asked, ", ".join(s.name for s in withheld), named=True)
    rows = []
    for k, p in enumerate(model.panels):
        known = (p.w_tcp[:, 0] > 0.0) & ~p.unknown_rows(found)
        for b in np.unique(p.block[known]):
            rows.append((k, (p.block == b) & known, int(b)))
    return Trial(model.panels, model.panels, tuple(rows), "blocks of the logs")


def shrinkage(
    model: Model, trial: Trial, members: Set, keep: Set | None = None, *, at_drives: bool = False
) -> Shrinkage:
    """The gap before and after `keep` (all of `members` by default) is taken away, with `members` fitted together.

    Frames that are not known are fitted to the withheld rows themselves, before and after: they are nuisances there too.
    at_drives: of logs that tell both ends of the drives, the part of the gap that lies between these; frames have none of it.
    """
    kept = members if keep is None else keep
    before, after, blocks, floors = [], [], [], []
    for p, rows, fitted in _asked(model, trial, members):
        values = np.where(np.isin(model.design.owner, list(kept)), fitted.mean, 0.0)
        if at_drives:
            gap, moved = drives_gap(p, rows), p.carried(p.errors(values, rows), rows)
            before.append(gap)
            after.append(gap - moved)
        else:
            gap, moved = whole_gap(p)[rows], p.moves(values, rows)
            before.append(settled(model, p, rows, gap))
            after.append(settled(model, p, rows, gap - moved))
        blocks.append(p.block[rows])
        floors.append(np.full(int(rows.sum()), _floor(p)))
    return Shrinkage(*(np.concatenate(x) for x in (before, after, blocks, floors)))


def _asked(model: Model, trial: Trial, members: Set) -> Iterator[tuple[Panel, NDArray[np.bool_], Fitted]]:
    """Each log with its withheld rows, and `members` fitted without what was left out for them: once for each that was."""
    fits: dict[int | None, Fitted] = {}
    for k, rows, left_out in trial.asked:
        if left_out not in fits:
            fits[left_out] = model.fit(members | model.evidence.always, () if left_out is None else (left_out,))
        yield trial.panels[k], rows, fits[left_out]


def doubt_of_shrinkage(model: Model, trial: Trial, keep: Set) -> float:
    """m (rms), by how much what `keep` does to withheld samples may be off, fitted beside the best set, as its values are not
    known better and its effects are described no better.
    """
    chosen = np.flatnonzero(np.isin(model.design.owner, list(keep)))
    doubts = []
    for p, rows, fitted in _asked(model, trial, model.best.members):
        X = p.tcp[:, :3, chosen][rows]
        spread = np.einsum("nik,kl,nil->n", X, fitted.spread.block(chosen), X, optimize=True)
        for i in keep:
            own = model.design.owner == i
            share = p.doubted(np.flatnonzero(own), model.accuracy.get(model.units[i].effect, 0.0))
            spread = spread + np.sum(_doubt_at(p, np.where(own, fitted.mean, 0.0), share, rows), axis=1)
        doubts.append(spread)
    return float(np.sqrt(np.mean(np.concatenate(doubts))))


def drives_gap(panel: Panel, rows: NDArray[np.bool_]) -> Array:
    """(M, 3) m at the TCP of what lies between set-points and encoders at some rows of a log that tells both."""
    if panel.y_servo is None:
        raise ValueError("a log without set-points or encoders tells no drive's error")
    return panel.carried(panel.y_servo[rows], rows)


def _doubt_at(panel: Panel, values: Array, share: Array, rows: NDArray[np.bool_]) -> Array:
    """(M, 3) variance of what values (K,) move the TCP by, at some rows: that of a row needs the rows beside it."""
    near = rows.copy()
    near[1:] |= rows[:-1]
    near[:-1] |= rows[1:]
    moved = np.zeros((len(rows), 3))
    moved[near] = panel.moves(values, near)
    return doubt_of(moved, share, poses=panel.scene.poses)[rows]


def _floor(panel: Panel) -> float:
    """m2 of noise where a log holds single poses and tells it, else NaN."""
    stated = panel.scene.poses and np.isfinite(panel.scene.sigma[0])
    return panel.scene.share * float(np.sum(1.0 / panel.w_tcp[:, :3].max(axis=0) ** 2)) if stated else float("nan")


def settled(model: Model, panel: Panel, rows: NDArray[np.bool_], gap: Array) -> Array:
    """The gap (M, 3) at some rows with frames that are not known fitted anew."""
    X = frame_columns(model, panel, rows)
    if X.shape[1] == 0:
        return gap
    solved = np.linalg.lstsq(X, gap.ravel(), rcond=RANK)[0]
    return np.asarray(gap - (X @ solved).reshape(-1, 3))


def settled_rms(model: Model, panels: Sequence[Panel], names: Collection[str]) -> float:
    """How far effects of the best set together move the TCP, m (rms), but for what frames that nobody reported take up of it."""
    members = frozenset(i for i in model.best.members if model.units[i].effect in names)
    values, parts = model.values(members, model.best), []
    for p in panels:
        good = p.w_tcp[:, 0] > 0.0
        parts.append(settled(model, p, good, p.moves(values)[good]))
    return _rms(np.concatenate(parts))


def frame_columns(model: Model, panel: Panel, rows: NDArray[np.bool_]) -> Array:
    """(3 M, k) of the frames that are not known and that are fitted to some rows themselves; none where these are too few."""
    nuisance = [k for k, o in enumerate(model.design.owner) if model.units[o].effect == NUISANCE]
    count = int(rows.sum())
    if not nuisance or count < _FEWEST:
        return np.zeros((3 * count, 0))
    X = panel.tcp[:, :3, nuisance][rows].reshape(3 * count, len(nuisance))
    return np.asarray(X[:, np.abs(X).max(axis=0) > 1e-12])
