"""What a set of parameters leaves of poses that its fit did not see: by folds, to choose between few parameters and many."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.fit import LEVER, fit_parameters, residuals
from camrob.calibration.measurements import sampled_rows
from camrob.calibration.parameters import ParameterSet
from camrob.calibration.sets import Prepared, named_parameter
from camrob.cell.cell import Cell

__all__ = ["left_in_folds"]

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
