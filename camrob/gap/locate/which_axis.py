"""Of an effect that several axes may have: how far each moves the tool, and whether one of them stands out of its like."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.model import Model, seen_moves
from camrob.summaries.diagnosis_summary import FittedValue
from camrob.units import m_to_mm

__all__ = ["NO_AXIS", "WhichAxis", "fitted_values", "which_axis"]

Set = frozenset[int]

_FAR_MORE = 2.0  # times what the next axis does, from which one stands out
_ODD = 0.2  # of the value that all axes share, by which an axis has to differ to stand out
_CANCELS = 2.0  # times the energy of all axes together, that each for itself may have at the most: more cancels
_NO_LIKE = 2.0  # times an ordinary value, from which an axis that stands out is one to be looked at
_FAR_FROM_IT = 6.0  # times an ordinary value, from which something is to be looked at that has no axis


@dataclass(frozen=True)
class WhichAxis:
    """moves_mm: how far each axis moves the tool by its own values (rms), the largest first, None for no axis; stands_out: the
    axis that does far more than the others, or those that do otherwise than all of them; far: times an ordinary value, of what
    stands out, or of all where nothing has an axis; shared: whether all axes share a value, or would as a rule and don't.
    """

    moves_mm: Mapping[str, float] | None
    stands_out: tuple[str, ...]
    far: float
    shared: bool

    def remedy(self, effect: Effect) -> str:
        """What a person does about it: about the axis that stands out, where its value is no ordinary one, or what all have alike
        is another one there; about what has no axis, where its value is far from ordinary.
        """
        if "{axis}" in effect.odd_axis:
            asked = bool(self.stands_out) and (self.shared or self.far >= _NO_LIKE)
        else:
            asked = bool(effect.odd_axis) and self.far >= _FAR_FROM_IT
        return effect.odd_axis.format(axis=" and ".join(self.stands_out)) if asked else effect.remedy


NO_AXIS = WhichAxis(None, (), 0.0, shared=False)
"""Of an effect of which nothing is claimed."""


def which_axis(model: Model, own: Set) -> WhichAxis:
    """Of units of an effect."""
    each = {a: _rms(_seen(model, _of_axis(model, own, a))) for a in {model.units[i].axis for i in own} - {""}}
    each = dict(sorted(each.items(), key=lambda x: (-x[1], x[0])))
    shared = bool(each) and any(not model.units[i].axis for i in own)
    odd = _otherwise(each, fitted_values(model, own)) if shared else _far_more(each, _rms(_seen(model, own)))
    far = _by_usual(fitted_values(model, _of_axis(model, own, odd[0]) if odd else own))
    return WhichAxis(
        {a: m_to_mm(rms) for a, rms in each.items()} or None, odd, far, shared or _of_one_alone(model, own)
    )


def _of_one_alone(model: Model, own: Set) -> bool:
    """Whether axes have for themselves what all axes that moved have alike, as a rule."""
    kinds = {model.units[i].effect for i in own}
    like = {unit.axis for unit in model.units if unit.effect in kinds}
    return "" in like and len(like - {""}) > len({model.units[i].axis for i in own})


def fitted_values(model: Model, own: Set) -> dict[str, FittedValue]:
    """Values of units with their standard deviations, by parameter name."""
    deviations = np.sqrt(np.maximum(np.diag(model.best.cov), 0.0))
    return {
        parameter.name: FittedValue(
            value=parameter.at_edge(float(model.best.mean[k])),
            std=parameter.at_edge(float(deviations[k])),
            usual=parameter.at_edge(parameter.usual),
        )
        for k, (parameter, owner) in enumerate(zip(model.design.parameters, model.design.owner, strict=True))
        if int(owner) in own
    }


def _of_axis(model: Model, own: Set, axis: str) -> Set:
    return frozenset(i for i in own if model.units[i].axis == axis)


def _seen(model: Model, own: Set) -> NDArray[np.float64]:
    """(N, 3) m: how units move the tool, all logs, beyond what open frames and latencies take up."""
    return np.concatenate(seen_moves(model, model.panels, model.values(own, model.best)))


def _rms(moved: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(np.sum(moved**2, axis=1))))


def _far_more(each: Mapping[str, float], together: float) -> tuple[str, ...]:
    """The axis that does far more than any other. None where what several do cancels: the log doesn't tell which it is then."""
    first, *rest = each or [""]
    alone = bool(first) and (not rest or each[first] >= _FAR_MORE * each[rest[0]])
    return (first,) if alone and sum(rms**2 for rms in each.values()) <= _CANCELS * together**2 else ()


def _otherwise(each: Iterable[str], values: Mapping[str, FittedValue]) -> tuple[str, ...]:
    """Axes whose own value is far from the one that all share, those first that do most."""
    beyond = {n.partition("_beyond_")[0]: v.value for n, v in values.items() if "_beyond_" in n}
    common = max((abs(v.value) for n, v in values.items() if "_beyond_" not in n), default=0.0)
    return tuple(a for a in each if abs(beyond.get(a, 0.0)) > _ODD * common)


def _by_usual(values: Mapping[str, FittedValue]) -> float:
    """The largest of some values, in ordinary ones of its kind; 0 where nobody has said what is ordinary."""
    return max((abs(v.value) / v.usual for v in values.values() if v.usual > 0.0), default=0.0)
