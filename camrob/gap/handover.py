"""From a diagnosis to `compensate`: what was fitted, as a calibration in the one error model that all three share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration import Calibration, ErrorSize, robot_digest
from camrob.calibration.identify import Observability
from camrob.calibration.parameters import ParameterSet
from camrob.calibration.terms import parameter_of
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.shrink import Shrinkage, Trial, shrinkage
from camrob.gap.fitted_units import fitted_model
from camrob.gap.states.later_effect import base_name
from camrob.summaries.diagnosis_summary import Compensable
from camrob.units import m_to_mm

__all__ = ["Handover", "hand_over"]

Array = NDArray[np.float64]
Set = frozenset[int]


@dataclass(frozen=True)
class Handover:
    """calibration: for `compensate`, None where nothing claimed can be stated there, or correcting that alone would not shrink
    the gap; said: what of the claims can be corrected, and what that leaves.
    """

    calibration: Calibration | None
    said: Compensable


def hand_over(model: Model, trial: Trial, claimed: Sequence[str], members: Set) -> Handover:
    """What of the claimed effects `compensate` can correct, and what the gap would then be on withheld samples.

    members: units of the best set that are claimed. What depends on time, speed or the direction of motion is no constant
    of the chain, and stays.
    """
    names = {e.name: e for e in model.effects}
    terms: dict[int, tuple[str, ...]] = {}
    for i in sorted(members):
        unit = model.units[i]
        own = names[unit.effect].terms(unit, model.states[unit.effect])
        if own:
            terms[i] = own
    handed = frozenset(terms)
    shrunk = shrinkage(model, trial, model.best.members, handed)
    left = _left(model, members - handed)
    said = Compensable(
        effects=tuple(dict.fromkeys(base_name(n) for n in claimed if any(model.units[i].effect == n for i in handed))),
        left=tuple(left),
        rms_before_mm=m_to_mm(shrunk.rms_before),
        rms_after_mm=m_to_mm(shrunk.rms_after),
        shrink=shrunk.shrink,
        shrink_interval=shrunk.interval(),
        fitted=fitted_model(model, members),
    )
    if not handed or said.shrink_interval[0] <= 0.0:
        # of causes that mimic each other's shape, a part by itself may make things worse
        return Handover(None, said)
    return Handover(_calibration(model, terms, shrunk, left), said)


def _left(model: Model, units: Set) -> list[str]:
    """What is claimed and can't be handed over, each once, with its axes."""
    axes: dict[str, list[str]] = {}
    for i in sorted(units):
        axes.setdefault(model.units[i].effect, []).append(model.units[i].axis)
    return [
        f"{name} of {', '.join(dict.fromkeys(a for a in found if a))}" if any(found) else name
        for name, found in axes.items()
    ]


def _calibration(
    model: Model, terms: Mapping[int, tuple[str, ...]], shrunk: Shrinkage, left: Sequence[str]
) -> Calibration:
    cell = model.scenes[0].cell
    columns = np.array([k for k, o in enumerate(model.design.owner) if int(o) in terms])
    order = {i: np.flatnonzero(model.design.owner == i) for i in terms}
    values: dict[str, float] = {}
    variances: dict[str, float] = {}
    for i, named in terms.items():
        for name, k in zip(named, order[i], strict=True):
            values[name] = values.get(name, 0.0) + float(model.best.mean[k])
            variances[name] = variances.get(name, 0.0) + float(model.best.cov[k, k])
    parameters = ParameterSet.of(parameter_of(cell, n) for n in values).with_values(
        np.array(list(values.values())), np.sqrt(np.maximum(list(variances.values()), 0.0))
    )
    rows = sum(int((p.w_tcp[:, 0] > 0.0).sum()) for p in model.panels)
    scale = model.design.usual[columns]
    gram = model.design.A.sum(axis=0)[np.ix_(columns, columns)] * np.outer(scale, scale)
    singular = np.sqrt(np.maximum(np.linalg.eigvalsh(gram)[::-1], 1e-30))
    seen = Observability.of(singular, 6 * rows)
    oriented = any(bool(s.seen[:, 3:].any()) for s in model.scenes)
    warnings = [f"diagnosed, not calibrated: {name} was found too and is not corrected by this" for name in left]
    return Calibration(
        cell_name=cell.name,
        cell_digest=robot_digest(cell),
        parameters=parameters,
        errors={
            "nominal/withheld": _size(shrunk.before),
            "calibrated/withheld": _size(shrunk.after),
        },
        condition=float(singular[0] / singular[-1]),
        observability=(seen.o1, seen.o2, seen.o3, seen.o4, seen.o5),
        scatter_position=float(model.noise),
        logs=tuple((s.name, s.log.digest) for s in model.scenes),
        rows=rows,
        outliers=model.outliers,
        oriented=oriented,
        warnings=tuple(warnings),
    )


def _size(errors: Array) -> ErrorSize:
    size = np.linalg.norm(errors, axis=1)
    return ErrorSize.of(size, np.zeros(len(size)), oriented=False)
