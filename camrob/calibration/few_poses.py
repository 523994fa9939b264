"""Parameters of poses that are too few for them: each held to its ordinary size, as strongly as says most of poses left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from camrob.calibration.fit import Fit, fit_parameters
from camrob.calibration.folds import left_in_folds
from camrob.calibration.identify import Identifiability
from camrob.calibration.parameters import ParameterSet
from camrob.calibration.sets import Prepared, named_parameter
from camrob.calibration.terms import FRAMES, plain_name
from camrob.cell.cell import Cell
from camrob.errors import JobError, SingularError

__all__ = ["FEW", "fit_few"]

FEW = 40
"""Poses from which so many parameters stand by themselves."""
_AGAINST = (0.01, 0.03, 0.1, 0.3)  # of the scatter that base and tool leave


def fit_few(
    prepared: Sequence[Prepared], cell: Cell, seen: Identifiability, scatter: float
) -> tuple[float, tuple[Prepared, ...], Fit, Identifiability] | None:
    """All parameters that show at all, held to their ordinary sizes: m that they leave of poses left out, the sets, the fit, and
    what of them is fitted; None where no fit ends. scatter: m an axis that base and tool leave.
    """
    names = tuple(n for n in prepared[0].names if (n in seen.kept if _of_frame(n) else _shows(n, seen)))
    left: dict[float, float] = {}
    for part in _AGAINST:
        try:
            left[part] = left_in_folds(prepared, cell, names, against=part * scatter)
        except (JobError, SingularError):
            continue  # a value at its bound: they have to be held more strongly
    if not left:
        return None
    best = min(left, key=lambda part: left[part])
    kept = tuple(p.with_names(names) for p in prepared)
    parameters = ParameterSet.of(named_parameter(cell, n) for n in names)
    fit = fit_parameters([(p.model, p.data) for p in kept], parameters, against=best * scatter)
    merged = {n: others for n, others in seen.merged.items() if n not in names}
    lost = tuple(n for n in seen.left_out if n not in names)
    weak = tuple(n for n in seen.weak if n not in names)
    return left[best], kept, fit, replace(seen, kept=names, merged=merged, weak=weak, left_out=lost)


def _shows(name: str, seen: Identifiability) -> bool:
    """Whether the poses say anything of a robot's value that an instrument's place does not take whole."""
    others = seen.merged.get(name, ())
    return name not in seen.unseen and not (others and all(_of_frame(n) for n in others))


def _of_frame(name: str) -> bool:
    """Whether it is a value of an instrument's place or a reflector's."""
    return plain_name(name) in FRAMES
