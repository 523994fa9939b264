"""Names of drives that these logs can't tell from another, which leaves as little of what the encoders show in their place."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import Model
from camrob.gap.verdict.belief import BELIEF

__all__ = ["not_told_apart"]

Array = NDArray[np.float64]

_SCALES = (0.5, 1.5)  # times the fitted values, between which a stand-in is tried
_STEADY = frozenset({"speed", "acceleration"})  # regimes of what a delay shows too, its second order with its first


def not_told_apart(model: Model, library: Sequence[Effect], claimed: Collection[str]) -> dict[str, list[str]]:
    """Claimed effects, and the one that would leave nearly as little between set-point and encoder in their place, alone or in
    that of all names of the best set that follow speed and acceleration: by fewer squares of what stays, at the temperature,
    than a name has to stand out by to be nearly sure. Of logs that tell both ends.
    """
    found: dict[str, list[str]] = {}
    if any(p.y_servo is None for p in model.panels):
        return found
    inside = model.evidence.effects_of(model.best.members)
    steady = {e.name for e in library if e.name in inside and _STEADY.issuperset(e.regimes)}
    for effect in library:
        if effect.name not in claimed or not effect.stands_in:
            continue
        for replaced in ({effect.name}, steady - {effect.stands_in}):
            if effect.name in replaced and _clearer(model, effect, replaced) < BELIEF.stands_out:
                found |= {name: [effect.stands_in] for name in replaced.intersection(claimed)}
    return found


def _clearer(model: Model, effect: Effect, replaced: Collection[str]) -> float:
    """By how many squares some effects leave less than the stand-in of one of them does in their place."""
    lag = model.values(frozenset(i for i in model.best.members if model.units[i].effect == effect.name), model.best)
    named = {q.name: float(v) for q, v in zip(model.design.parameters, lag, strict=True) if v != 0.0}
    if not named:
        return np.inf
    # what is left out is a nuisance with values of its own, fitted beside these: it would take the lag's part
    mean = model.values(model.best.members, model.best)
    values = model.values(frozenset(i for i in model.best.members if model.units[i].effect in replaced), model.best)

    def beyond(scale: float) -> float:
        """Squares that are left more so."""
        total = 0.0
        for p in model.panels:
            instead = np.zeros_like(p.errors(values))
            for axis, signal in effect.stand_in(p.scene, model.states[effect.name], named, scale).items():
                instead[:, p.scene.index(axis)] = signal
            total += _more_squares(p, mean, p.errors(values) - instead)
        return total

    least = minimize_scalar(beyond, bounds=_SCALES, method="bounded", options={"xatol": 1e-5}).fun
    return float(least / model.evidence.temperature)


def _more_squares(panel: Panel, mean: Array, back: Array) -> float:
    """By how many weighed squares more is left at the drives with `back` (N, k) put back, where that is known."""
    if panel.y_servo is None or panel.w_servo is None:
        raise ValueError("a log without set-points or encoders tells no drive's error")
    left = panel.y_servo - panel.errors(mean)
    return float(np.nansum(((left + back) ** 2 - left**2) * panel.w_servo**2))
