"""What a calibration rests on, pose by pose: for reports, and to say what stays unexplained."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked

__all__ = ["CalibrationEvidence", "PoseErrors", "explained_by_axis"]

Array = NDArray[np.float64]

_BINS = 12  # parts of an axis's range, by equal numbers of poses


@dataclass(frozen=True, slots=True)
class PoseErrors:
    """Poses of one log that took part in the fit or did not.

    rows (N,): where they stand in the log. axis_values (N, axes): reported, m and rad. residuals: by stage ("nominal",
    "frames", "calibrated") measured beyond modelled (N, 6), m and rad, angles 0 without `oriented`. outlier (N,).
    sigma: the instrument's noise an axis, m, NaN unknown. refitted: base and reflector were fitted to the other half.
    """

    log: str
    withheld: bool
    rows: NDArray[np.int64]
    axis_values: Array
    oriented: bool
    residuals: Mapping[str, Array]
    outlier: NDArray[np.bool_]
    sigma: float = float("nan")
    refitted: bool = False

    def __post_init__(self) -> None:
        count = len(self.rows)
        object.__setattr__(self, "rows", locked(self.rows, shape=(count,), dtype=np.int64, name="rows"))
        object.__setattr__(self, "axis_values", locked(self.axis_values, shape=(count, None), name="axis_values"))
        object.__setattr__(self, "outlier", locked(self.outlier, shape=(count,), dtype=np.bool_, name="outlier"))
        frozen = {k: locked(v, shape=(count, 6), name=k) for k, v in self.residuals.items()}
        object.__setattr__(self, "residuals", MappingProxyType(frozen))

    def distance(self, stage: str) -> Array:
        """Errors of position (N,), m."""
        return np.asarray(np.linalg.norm(self.residuals[stage][:, :3], axis=1))

    def angle(self, stage: str) -> Array:
        """Errors of orientation (N,), rad."""
        return np.asarray(np.linalg.norm(self.residuals[stage][:, 3:], axis=1))


@dataclass(frozen=True, slots=True)
class CalibrationEvidence:
    """poses: log by log, fitted and withheld. names: of the fitted parameters, with correlation (P, P); singular: values
    of the scaled Jacobian, the largest first.
    """

    poses: tuple[PoseErrors, ...]
    names: tuple[str, ...]
    correlation: Array
    singular: tuple[float, ...]

    def __post_init__(self) -> None:
        count = len(self.names)
        object.__setattr__(self, "correlation", locked(self.correlation, shape=(count, count), name="correlation"))


def explained_by_axis(residuals: Array, axis_values: Array) -> Array:
    """The share (axes,) of the residuals' energy (N, 3) that depends on each axis alone: means of 12 equally filled bins.

    Adjusted for what chance would give (adjusted R squared), 0 at the least, and 0 for an axis that stands still. High
    shares show where a model lacks something; they overlap and need not add up.
    """
    N = len(residuals)
    centred = residuals - residuals.mean(axis=0)
    total = float(np.sum(centred**2))
    out = np.zeros(axis_values.shape[1])
    for k in range(axis_values.shape[1]):
        edges = np.unique(np.quantile(axis_values[:, k], np.linspace(0.0, 1.0, _BINS + 1)[1:-1]))
        place = np.searchsorted(edges, axis_values[:, k], side="right")
        bins = int(place.max()) + 1
        if bins < 2 or N < 3 * _BINS or total <= 0.0 or np.ptp(axis_values[:, k]) < 1e-9:
            continue
        sums = np.stack([np.bincount(place, centred[:, c], minlength=bins) for c in range(3)], axis=1)
        counts = np.bincount(place, minlength=bins)[:, None]
        within = total - float(np.sum(sums**2 / np.maximum(counts, 1)))
        out[k] = max(0.0, 1.0 - within / (N - bins) / (total / (N - 1)))
    return out
