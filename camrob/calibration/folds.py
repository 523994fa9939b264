"""What parameters leave of poses that their fit did not see, by folds: to choose few or many, or how strongly to hold them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.fit import LEVER, Fit, fit_parameters, residuals
from camrob.calibration.identify import Identifiability
from camrob.calibration.measurements import sampled_rows
from camrob.calibration.parameters import ParameterSet
from camrob.calibration.sets import Prepared, named_parameter
from camrob.calibration.terms import FRAMES, plain_name
from camrob.cell.cell import Cell
from camrob.errors import JobError, SingularError

__all__ = ["FEW", "fit_few", "left_in_folds"]

FEW = 40
"""Poses from which so many parameters stand by themselves."""
_AGAINST = (0.01, 0.03, 0.1, 0.3)  # of the scatter that base and tool leave

_FOLDS = 5  # few enough to be quick, and each fit keeps most of the poses
_SAMPLE = 1000  # poses of a set that tell which parameters carry over
_GROSS = 4.0  # times the median: what lies farther off counts as much, as gross rows must not choose
_SEED = 20261126


def left_in_folds(prepared: Sequence[Prepared], cell: Cell, names: Sequence[str], *, against: float = 0.0) -> float:
    """m: robust rms of what these parameters, fitted to four fifths of the poses, leave of the rest, each fifth in turn. against:
    as `fit_parameters` is told.

    Rows of one posture, and of sets on the same postures, are left out together. Raises JobError and SingularError as
    `fit_parameters` does.
    """
    sets = [p.with_names(names) for p in prepared]
    sets = [replace(p, data=p.data.select(sampled_rows(len(p.data), _SAMPLE))) for p in sets]
    parameters = ParameterSet.of(named_parameter(cell, n) for n in names)
    folds = _folds([np.asarray(p.data.q) for p in sets], paths=not all(p.data.single for p in sets))
    left = []
    for k in range(_FOLDS):
        pairs = [(p.model, p.data.select(f != k)) for p, f in zip(sets, folds, strict=True)]
        values = fit_parameters(pairs, parameters, against=against).parameters.values_array
        for p, f in zip(sets, folds, strict=True):
            rest = residuals(p.model, values, p.data.select(f == k))
            turned = LEVER * rest[:, 3:] if p.data.oriented else np.zeros((len(rest), 3))
            left.append(np.sqrt(np.sum(rest[:, :3] ** 2, axis=1) + np.sum(turned**2, axis=1)))
    off = np.concatenate(left)
    return float(np.sqrt(np.mean(np.minimum(off, _GROSS * np.median(off)) ** 2)))


def _folds(postures: Sequence[NDArray[np.float64]], *, paths: bool) -> list[NDArray[np.int64]]:
    """The fold of each row, set by set: of single poses by chance, of paths in whole blocks."""
    whole = np.concatenate(postures)
    _, which = np.unique(np.round(whole, 6), axis=0, return_inverse=True)
    which = which.ravel()
    count = int(which.max()) + 1
    if paths:
        fold = np.arange(len(whole)) * (4 * _FOLDS) // max(len(whole), 1) % _FOLDS
    else:
        fold = np.random.default_rng(_SEED).permutation(count)[which] % _FOLDS
    ends = np.cumsum([0, *(len(q) for q in postures)])
    return [fold[a:b] for a, b in pairwise(ends)]


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
