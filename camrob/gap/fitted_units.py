"""What a diagnosis found, with all that is needed to reckon it on another path: units, values, covariance, states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.errors import InputError
from camrob.gap.effects.effect import Effect, EffectParameter, State, Unit
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.unknown import UNKNOWN
from camrob.gap.states.later_effect import base_name
from camrob.gap.unclaimed import open_doubt
from camrob.gap.unexplained import UnexplainedField, unexplained_field
from camrob.summaries.fitted.diagnosis_fitted import FittedModel, FittedUnit, UnitParameter

__all__ = ["FittedUnits", "OpenUnits", "fitted_model", "fitted_units"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class OpenUnits:
    """Units that were not claimed and may be there; root: (K + L, R), by whose square the covariance of the K claimed values and
    the L of these is more for that.
    """

    units: tuple[Unit, ...]
    effects: tuple[Effect, ...]
    states: tuple[State, ...]
    root: Array


@dataclass(frozen=True)
class FittedUnits:
    """Units that were found, each with its effect and the state it was fitted in; values (K,) and cov (K, K) of all their
    parameters in order, SI, as if nothing else were there. unexplained: what stays beside them as far as it follows posture, None
    where that is not known; open: what may be there beside them, None where nobody has asked.
    """

    units: tuple[Unit, ...]
    effects: tuple[Effect, ...]
    states: tuple[State, ...]
    values: Array
    cov: Array
    unexplained: UnexplainedField | None = None
    open: OpenUnits | None = None

    @property
    def owner(self) -> NDArray[np.int64]:
        """(K,) each parameter's unit."""
        return np.array([i for i, u in enumerate(self.units) for _ in u.parameters], np.int64)


def fitted_model(model: Model, members: frozenset[int]) -> FittedModel:
    """The part of the JSON object: the claimed units of the best set, as the machine is when the last log ends."""
    came = {e.name: e.since for e in model.effects}
    gone = frozenset(
        i for i, unit in enumerate(model.units) if (change := came.get(unit.effect)) is not None and not change.now
    )
    own, mean = sorted(members - gone), np.asarray(model.best.mean)
    columns = np.flatnonzero(np.isin(model.design.owner, own))
    unnamed = frozenset(i for i, unit in enumerate(model.units) if unit.effect == UNKNOWN.name)
    doubt = open_doubt(model, frozenset(own), gone | unnamed)
    field = unexplained_field(model, frozenset(own), doubt.units)
    return FittedModel(
        units=tuple(_said(model, i, mean) for i in own),
        covariance=_rows(_covariance(model, columns)),
        unexplained=None if field is None else field.said(),
        open_units=tuple(_said(model, i, np.zeros_like(mean)) for i in doubt.units),
        open_root=_rows(doubt.root) if doubt.root.size else (),
    )


def _said(model: Model, i: int, values: Array) -> FittedUnit:
    """A unit of the design with its own of all values (K,)."""
    unit = model.units[i]
    own = zip(unit.parameters, values[model.design.owner == i], strict=True)
    parameters = tuple(UnitParameter(name=p.name, unit=p.unit, usual=p.usual, value=float(v)) for p, v in own)
    state = {k: float(v) for k, v in model.states[unit.effect].items()}
    return FittedUnit(effect=base_name(unit.effect), axis=unit.axis, key=unit.key, parameters=parameters, state=state)


def _rows(values: Array) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(map(float, row)) for row in values)


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
    units, effects, states = _of(found.units, library)
    values = np.array([p.value for u in found.units for p in u.parameters])
    cov = np.asarray(found.covariance, float).reshape(len(values), len(values))
    field = None if found.unexplained is None else UnexplainedField.of(found.unexplained)
    beside = None
    if found.open_root:
        beside = OpenUnits(*_of(found.open_units, library), np.asarray(found.open_root, float))
    return FittedUnits(units, effects, states, values, cov, field, beside)


def _of(
    said: Sequence[FittedUnit], library: Sequence[Effect]
) -> tuple[tuple[Unit, ...], tuple[Effect, ...], tuple[State, ...]]:
    """Units, their effects and the states in which they were fitted."""
    by_name = {e.name: e for e in library}
    for unit in said:
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
        for u in said
    )
    return units, tuple(by_name[u.effect] for u in said), tuple(dict(u.state) for u in said)
