"""What the comparison of sets of effects ends with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import Effect, State, Unit
from camrob.gap.evidence.design import Design, Panel
from camrob.gap.evidence.discrepancy import SmoothBasis
from camrob.gap.evidence.evidence import Evidence, Fitted
from camrob.gap.observation.noise import Noise
from camrob.gap.observation.scene import Scene

__all__ = ["Model", "doubt_of", "effect_rms", "members_of", "seen_moves", "seen_rms", "some_rows", "whole_gap"]

Array = NDArray[np.float64]

_STEP = 20.0  # how much less an effect's change from sample to sample is trusted than its value
_RANK = 1e-9  # share of the largest singular value under which columns of nuisances are one another's


@dataclass(frozen=True)
class Model:
    """What the comparison ended with. scores: of all sets of units met, over all sizes of the discrepancy; sets: probabilities of
    sets of effects (unknown shapes under "unknown"); best: posterior of the best set; excess: rms in m of what is left at the TCP
    beyond white noise and the discrepancy; basis: of the discrepancy; heat_alone: rows that one independent row stands for where
    values are fitted without the discrepancy, None where they are fitted with it (see `with_fitting`).
    """

    effects: tuple[Effect, ...]
    states: Mapping[str, State]
    scenes: tuple[Scene, ...]
    noises: tuple[Noise, ...]
    panels: tuple[Panel, ...]
    design: Design
    evidence: Evidence
    scores: Mapping[frozenset[int], float]
    sets: Mapping[frozenset[str], float]
    best: Fitted
    excess: float
    outliers: int
    basis: SmoothBasis
    heat_alone: float | None = None

    def fit(self, members: frozenset[int], left_out: tuple[int, ...] = (), design: Design | None = None) -> Fitted:
        """The values of some units, fitted without some blocks, to all logs or to a part of them (`design`).

        How far they may be off is always asked beside the discrepancy, which is there whether it takes part or not.
        """
        evidence = self.evidence if design is None else replace(self.evidence, design=design)
        beside = evidence.variant(left_out).fit(members)
        if self.heat_alone is None:
            return beside
        alone = evidence.variant(left_out, self.heat_alone).fit(members)
        return replace(alone, spread=beside.spread)

    @property
    def units(self) -> tuple[Unit, ...]:
        """All units of the design."""
        return self.design.units

    @property
    def noise(self) -> float:
        """3-D rms of the noise, m."""
        return float(np.sqrt(np.mean([n.rms**2 for n in self.noises])))

    @property
    def accuracy(self) -> dict[str, float]:
        """By what share of itself the description of each effect may be wrong."""
        return {e.name: e.accuracy for e in self.effects}

    @property
    def gap(self) -> float:
        """3-D rms of the whole gap, m, where it was measured and is not gross."""
        told = [whole_gap(p)[good] for p in self.panels if (good := p.w_tcp[:, 0] > 0.0).any()]
        return float(np.sqrt(np.mean([np.mean(np.sum(g**2, axis=1)) for g in told])))

    @property
    def discrepancy(self) -> float:
        """3-D rms of the discrepancy beside the best set, m."""
        field, sizes = self.evidence.field, self.evidence.sizes
        if field is None or sizes is None:
            return 0.0
        weights = field.fitted(self.best.mean, sizes)[:, :3]
        parts = [np.sum((p.smooth @ weights) ** 2, axis=1) for p in self.panels if p.smooth is not None]
        return float(np.sqrt(np.mean(np.concatenate(parts)))) if parts else 0.0

    def values(self, members: frozenset[int], fitted: Fitted) -> Array:
        """(K,) fitted values of some units, 0 elsewhere."""
        return np.where(np.isin(self.design.owner, list(members)), fitted.mean, 0.0)


def members_of(model: Model, name: str) -> frozenset[int]:
    """The units of the best set that are an effect's."""
    return frozenset(i for i in model.best.members if model.units[i].effect == name)


def effect_rms(model: Model, panels: Sequence[Panel], name: str) -> float:
    """How far an effect of the best set moves the TCP, m (rms)."""
    members = members_of(model, name)
    values = model.values(members, model.best)
    return float(np.sqrt(np.mean(np.concatenate([np.sum(p.moves(values) ** 2, axis=1) for p in panels]))))


def seen_rms(model: Model, panels: Sequence[Panel], name: str) -> float:
    """How far an effect of the best set moves the TCP beyond what open frames and latencies would take up of it, m (rms)."""
    members = members_of(model, name)
    moved = seen_moves(model, panels, model.values(members, model.best))
    return float(np.sqrt(np.mean(np.concatenate([np.sum(m**2, axis=1) for m in moved]))))


def seen_moves(model: Model, panels: Sequence[Panel], values: Array) -> list[Array]:
    """By log (N, 3) m: how parameters (K,) move the TCP, less what the nuisances that are always fitted take up of it: the size
    that somebody can hold against the gap, which is reckoned behind these, too.
    """
    moved = [p.moves(values) for p in panels]
    columns = np.flatnonzero(np.isin(model.design.owner, sorted(model.evidence.always)))
    if not len(columns) or not any(m.any() for m in moved):
        return moved
    X = [p.moved_by(columns) for p in panels]
    told = [p.w_tcp[:, 0] > 0.0 for p in panels]
    known = np.concatenate([x[t].reshape(-1, len(columns)) for x, t in zip(X, told, strict=True)])
    asked = np.concatenate([m[t].ravel() for m, t in zip(moved, told, strict=True)])
    taken = np.linalg.lstsq(known, asked, rcond=_RANK)[0]
    return [m - x @ taken for m, x in zip(moved, X, strict=True)]


def whole_gap(panel: Panel) -> Array:
    """(N, 3) m: measured less nominal at the set-points."""
    total = panel.y_tcp[:, :3]
    return total if panel.y_servo is None else total + panel.carried(panel.y_servo)


def some_rows(panel: Panel, most: int) -> NDArray[np.int64]:
    """Rows of a log at which the tool was measured, evenly thinned to `most`."""
    good = np.flatnonzero(panel.w_tcp[:, 0] > 0.0)
    return good[:: max(1, -(-len(good) // most))]


def doubt_of(part: Array, share: Array, *, poses: bool) -> Array:
    """Variance of an effect's part (N, d): a share (N, 1) of itself, and more where it changes between two samples of a path.

    poses: samples are single poses, which stand in no order that an effect could be late in.
    """
    if poses:
        return np.asarray((share * part) ** 2)
    step = np.zeros_like(part)
    change = np.abs(np.diff(part, axis=0))
    step[1:] = change
    step[:-1] = np.maximum(step[:-1], change)
    return np.asarray((share * part) ** 2 + (_STEP * share * step) ** 2)
