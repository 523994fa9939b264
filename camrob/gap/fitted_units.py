"""What a diagnosis found, with all that is needed to reckon it on another path: units, values, covariance, states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError
from camrob.gap.effects.effect import Effect, EffectParameter, State, Unit
from camrob.gap.evidence.model import Model
from camrob.gap.states.later_effect import base_name
from camrob.gap.unexplained import UnexplainedField, unexplained_field
from camrob.summaries.fitted.diagnosis_fitted import FittedModel, FittedUnit, UnitParameter

__all__ = ["FittedUnits", "fitted_model", "fitted_units"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FittedUnits:
    """Units that were found, each with its effect and the state it was fitted in; values (K,) and cov (K, K) of all their
    parameters in order, SI. unexplained: what stays beside them as far as it follows posture, None where that is not known.
    """

    units: tuple[Unit, ...]
    effects: tuple[Effect, ...]
    states: tuple[State, ...]
    values: Array
    cov: Array
    unexplained: UnexplainedField | None = None

    @property
    def owner(self) -> NDArray[np.int64]:
        """(K,) each parameter's unit."""
        return np.array([i for i, u in enumerate(self.units) for _ in u.parameters], np.int64)


def fitted_model(model: Model, members: frozenset[int]) -> FittedModel:
    """The part of the JSON object: the claimed units of the best set, as the machine is when the last log ends."""
    came = {e.name: e.since for e in model.effects}
    own = sorted(i for i in members if (change := came.get(model.units[i].effect)) is None or change.now)
    columns = np.flatnonzero(np.isin(model.design.owner, own))
    units = []
    for i in own:
        unit = model.units[i]
        values = model.best.mean[model.design.owner == i]
        fitted_values = (
            UnitParameter(name=p.name, unit=p.unit, usual=p.usual, value=float(v))
            for p, v in zip(unit.parameters, values, strict=True)
        )
        state = {k: float(v) for k, v in model.states[unit.effect].items()}
        units.append(
            FittedUnit(
                effect=base_name(unit.effect),
                axis=unit.axis,
                key=unit.key,
                parameters=tuple(fitted_values),
                state=state,
            )
        )
    cov = _covariance(model, columns)
    field = unexplained_field(model, frozenset(own))
    return FittedModel(
        units=tuple(units),
        covariance=tuple(tuple(map(float, row)) for row in cov),
        unexplained=None if field is None else field.said(),
    )


def _covariance(model: Model, columns: NDArray[np.int64]) -> Array:
    """How far values may be off. Those fitted as if there were no discrepancy hold a part of it, where there is one, and its
    posterior beside them does not know that: they may also be off by as much as they lie from the values fitted beside it.
    """
    cov = model.best.spread.block(columns)
    if model.heat_alone is None:
        return cov
    apart = (model.best.mean - model.evidence.fit(model.best.members).mean)[columns]
    return cov + np.outer(apart, apart)


def fitted_units(found: FittedModel, library: Sequence[Effect]) -> FittedUnits:
    """What a JSON object holds, with the effects of a library. Raises InputError for an effect that the library lacks."""
    by_name = {e.name: e for e in library}
    for unit in found.units:
        if unit.effect not in by_name:
            hint = "give the cell that it was made with (its effects/ folder), or diagnose again"
            raise InputError(f"the diagnosis found {unit.effect!r}, which is not an effect here", hint=hint)
    units = tuple(
        Unit(
            u.effect,
            u.axis,
            tuple(EffectParameter(p.name, p.unit, p.usual, -np.inf, np.inf) for p in u.parameters),
            key=u.key,
        )
        for u in found.units
    )
    values = np.array([p.value for u in found.units for p in u.parameters])
    cov = np.asarray(found.covariance, float).reshape(len(values), len(values))
    effects = tuple(by_name[u.effect] for u in found.units)
    field = None if found.unexplained is None else UnexplainedField.of(found.unexplained)
    return FittedUnits(units, effects, tuple(dict(u.state) for u in found.units), values, cov, field)
