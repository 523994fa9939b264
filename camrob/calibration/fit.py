"""Robust nonlinear least squares of error parameters, with analytic derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from camrob.calibration.measurements import Measurements, sampled_rows
from camrob.calibration.parameters import ParameterSet
from camrob.errors import JobError, SingularError
from camrob.frozen import locked
from camrob.se3 import rotation_log

__all__ = ["LEVER", "Fit", "PoseModel", "fit_parameters", "residuals"]

Array = NDArray[np.float64]

_CHUNK = 20_000  # measurements at once: Jacobians of all would not fit a small memory
_ITERATIONS = 40  # an end for a fit that does not settle
_SETTLED = 1e-8  # squared standard errors
_SAMPLE = 3000  # rows that a long log is begun with
_OUTLIER = 5.0  # robust standard deviations
_MEDIAN_NORM = 1.5382  # median length of a 3-D normal vector of unit deviation an axis
_FLOOR_POSITION, _FLOOR_ANGLE = 1e-9, 1e-10  # m, rad: noise-free data must not divide by 0
LEVER = 0.3
"""m: a tool is turned about a point that far from where the work is, as usual for a flange and a spindle."""


class PoseModel(Protocol):
    """What is fitted: target poses of postures, and their derivatives by the parameters."""

    def poses(self, values: Array, q: Array, /) -> Array:
        """Poses (N, 4, 4) of postures q (N, n) with the parameters' values (P,)."""
        ...

    def poses_and_jacobian(self, values: Array, q: Array, /) -> tuple[Array, Array]:
        """Poses, and derivatives (N, 6, P)."""
        ...


@dataclass(frozen=True, slots=True)
class Fit:
    """What a fit found. parameters: with values and standard errors. correlation (V, V) of the varying ones, `names`.

    scatter_position (m), scatter_angle (rad): robust standard deviation an axis of what remains. outliers: rows
    beyond five of them; they weigh little. rows, iterations. against: m, as `fit_parameters` was told.
    """

    parameters: ParameterSet
    names: tuple[str, ...]
    correlation: Array
    scatter_position: float
    scatter_angle: float
    outliers: int
    rows: int
    iterations: int
    against: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "correlation", locked(self.correlation, shape=(None, None), name="correlation"))

    def strongest(self, count: int = 10) -> list[tuple[str, str, float]]:
        """Pairs of parameters with the largest correlations."""
        upper = np.triu(np.abs(self.correlation), 1)
        order = np.argsort(-upper, axis=None)[:count]
        rows, columns = np.unravel_index(order, upper.shape)
        found = zip(rows.tolist(), columns.tolist(), strict=True)
        return [(self.names[i], self.names[j], float(self.correlation[i, j])) for i, j in found if upper[i, j] > 0.0]


def residuals(model: PoseModel, values: Array, data: Measurements) -> Array:
    """Measured beyond modelled (N, 6): position, m, and rotation vector, rad, in the axes of the measured frame."""
    out = np.zeros((len(data), 6))
    for start in range(0, len(data), _CHUNK):
        part = slice(start, start + _CHUNK)
        out[part] = _difference(model.poses(values, data.q[part]), data, part)
    return out


def _difference(poses: Array, data: Measurements, part: slice) -> Array:
    frames, out = data.frames[part], np.zeros((len(poses), 6))
    out[:, :3] = (
        frames[:, :3, 3] - poses[:, :3, 3] if data.sight is None else data.sight.select(part).beyond(poses[:, :3, 3])
    )
    if data.oriented:
        out[:, 3:] = rotation_log(frames[:, :3, :3] @ np.swapaxes(poses[:, :3, :3], 1, 2))
    return out


def fit_parameters(
    pairs: Sequence[tuple[PoseModel, Measurements]], parameters: ParameterSet, *, against: float = 0.0
) -> Fit:
    """Fit the varying parameters to measured poses, each set with the model of its own instrument. against: m an axis, the
    scatter of positions that parameters are held to their ordinary sizes against, all but those without bounds; 0: they are not.

    All models have `parameters`' names. Gauss-Newton within the bounds, steps halved where they don't help; rows are
    weighed by their length in robust deviations (soft L1), which, re-estimated in every round or told, also weigh positions
    against orientations. Raises SingularError where parameters can't be told apart and JobError where one ends on its
    bound.
    """
    names = tuple(p.name for p in parameters.items_ if p.vary)
    free = np.flatnonzero(parameters.varying)
    scale = parameters.scales[free]
    lower = np.array([p.lower for p in parameters.items_])[free]
    upper = np.array([p.upper for p in parameters.items_])[free]
    ridge = _Ridge(against, scale, np.isfinite(lower)) if against > 0.0 else None
    values, iterations = parameters.values_array, 0
    sample = [(model, data.select(sampled_rows(len(data), _SAMPLE))) for model, data in pairs]
    for part in (sample, pairs) if any(len(data) > 2 * _SAMPLE for _, data in pairs) else (pairs,):
        values, count = _gauss_newton(part, values, free, (scale, lower, upper), names, ridge)
        iterations += count
    spread = _spread(pairs, values)
    H, _, _ = _normal(pairs, values, free, scale, ridge.spread if ridge else spread)
    held = np.diag(ridge.held) if ridge else np.zeros_like(H)
    covariance = np.linalg.inv(H + held)
    if ridge:
        # what remains is noise, whatever it was weighed by; a value that the poses don't tell is of ordinary size
        covariance = covariance @ ((spread[0] / against) ** 2 * H + held) @ covariance
    std = np.sqrt(np.diag(covariance))
    stds = np.full(len(values), np.nan)
    stds[free] = std * scale
    found = parameters.with_values(values, stds)
    stuck = [p.name for p in found.items_ if p.at_bound]
    if stuck:
        what = f"{', '.join(stuck)} ended at the bound of what is plausible: cell, log or units don't fit"
        what += "; check them, or leave these parameters out"
        raise JobError(what, reasons={})
    scattered = np.concatenate([_lengths(model, values, data, spread) for model, data in pairs])
    return Fit(
        parameters=found,
        names=names,
        correlation=covariance / np.outer(std, std),
        scatter_position=spread[0],
        scatter_angle=spread[1],
        outliers=int(np.sum(scattered > _OUTLIER)),
        rows=len(scattered),
        iterations=iterations,
        against=against,
    )


@dataclass(frozen=True)
class _Ridge:
    """Ordinary sizes that values are held to. against: m; scale: (V,) the sizes; bounded: (V,) which are held."""

    against: float
    scale: Array
    bounded: NDArray[np.bool_]

    @property
    def spread(self) -> tuple[float, float]:
        """The deviations an axis that residuals are weighed by, m and rad."""
        return self.against, self.against / LEVER

    @property
    def held(self) -> Array:
        """(V,) 1 where a value is held, 0 where it is open."""
        return self.bounded.astype(float)

    def cost(self, values: Array) -> float:
        """The sum of squares of values (V,) in their sizes."""
        return float(np.sum(self.held * (values / self.scale) ** 2))


def _gauss_newton(
    pairs: Sequence[tuple[PoseModel, Measurements]],
    values: Array,
    free: NDArray[np.int64],
    bounds: tuple[Array, Array, Array],
    names: tuple[str, ...],
    ridge: _Ridge | None,
) -> tuple[Array, int]:
    """Values (P,) where no step lessens the cost any more, and the number of steps; bounds: scale, lower, upper (V,)."""

    def penalty(tried: Array) -> float:
        return ridge.cost(tried[free]) if ridge else 0.0

    scale, lower, upper = bounds
    for iteration in range(1, _ITERATIONS + 1):
        spread = ridge.spread if ridge else _spread(pairs, values)
        H, g, cost = _normal(pairs, values, free, scale, spread)
        if ridge:
            H, g = H + np.diag(ridge.held), g - ridge.held * values[free] / scale
            cost += penalty(values)
        step = _step(H, g, (lower - values[free]) / scale, (upper - values[free]) / scale, names)
        length = 1.0
        for _ in range(8):
            trial = values.copy()
            trial[free] = np.clip(values[free] + length * scale * step, lower, upper)
            if _cost(pairs, trial, spread) + penalty(trial) <= cost * (1.0 + 1e-12):
                break
            length *= 0.5
        else:
            return values, iteration
        values = trial
        # half of what the cost is expected to fall by, in squared standard errors
        if float(g @ step) < _SETTLED:
            break
    return values, iteration


def _spread(pairs: Sequence[tuple[PoseModel, Measurements]], values: Array) -> tuple[float, float]:
    """Robust deviations an axis of positions and orientations."""
    r = [residuals(model, values, data) for model, data in pairs]
    # of what is told of each position: the median length of that many deviations differs
    lengths = [
        np.linalg.norm(x[:, :3], axis=1) * _MEDIAN_NORM / _median_norm(3.0 * data.share)
        for x, (_, data) in zip(r, pairs, strict=True)
    ]
    place = np.concatenate(lengths)
    turns = [np.linalg.norm(x[:, 3:], axis=1) for x, (_, data) in zip(r, pairs, strict=True) if data.oriented]
    angle = float(np.median(np.concatenate(turns))) if turns else 0.0
    return (
        max(float(np.median(place)) / _MEDIAN_NORM, _FLOOR_POSITION),
        max(angle / _MEDIAN_NORM, _FLOOR_ANGLE),
    )


def _median_norm(coordinates: float) -> float:
    """The median length of a normal vector of 1, 2 or 3 dimensions, of unit deviation an axis."""
    return float(np.interp(coordinates, [1.0, 2.0, 3.0], [0.6745, 1.1774, _MEDIAN_NORM]))


def _whitened(r: Array, oriented: bool, spread: tuple[float, float]) -> Array:
    out = r / np.repeat(spread, 3)
    return np.asarray(out if oriented else out[:, :3])


def _lengths(model: PoseModel, values: Array, data: Measurements, spread: tuple[float, float]) -> Array:
    """Lengths (N,) of the residuals in deviations an axis."""
    e = _whitened(residuals(model, values, data), data.oriented, spread)
    told = e.shape[1] - 3.0 * (1.0 - data.share)
    return np.asarray(np.linalg.norm(e, axis=1) / np.sqrt(told))


def _cost(pairs: Sequence[tuple[PoseModel, Measurements]], values: Array, spread: tuple[float, float]) -> float:
    """The sum of soft L1 losses: 2 (sqrt(1 + e^2) - 1) of rows' lengths in threes of deviations."""
    total = 0.0
    for model, data in pairs:
        e = _whitened(residuals(model, values, data), data.oriented, spread)
        total += float(np.sum(np.sqrt(1.0 + np.sum(e * e, axis=1) / (9.0 * e.shape[1])) - 1.0)) * 18.0 * e.shape[1]
    return total


def _normal(
    pairs: Sequence[tuple[PoseModel, Measurements]],
    values: Array,
    free: NDArray[np.int64],
    scale: Array,
    spread: tuple[float, float],
) -> tuple[Array, Array, float]:
    """Normal matrix (V, V) and right side (V,) in scaled parameters, and the cost, chunk by chunk."""
    H, g = np.zeros((len(free), len(free))), np.zeros(len(free))
    for model, data in pairs:
        for start in range(0, len(data), _CHUNK):
            part = slice(start, start + _CHUNK)
            poses, J = model.poses_and_jacobian(values, data.q[part])
            J = data.told(J, part)
            e = _whitened(_difference(poses, data, part), data.oriented, spread)
            rows = e.shape[1]
            weight = 1.0 / np.sqrt(1.0 + np.sum(e * e, axis=1) / (9.0 * rows))
            A = J[:, :rows][:, :, free] * scale / np.repeat(spread, 3)[:rows, None]
            A *= np.sqrt(weight)[:, None, None]
            A = A.reshape(-1, len(free))
            H += A.T @ A
            g += A.T @ (e * np.sqrt(weight)[:, None]).ravel()
    return H, g, _cost(pairs, values, spread)


def _step(H: Array, g: Array, lower: Array, upper: Array, names: tuple[str, ...]) -> Array:
    """The scaled step within its bounds. Raises SingularError, naming parameters, where H is singular."""
    size = np.sqrt(np.diag(H))
    if np.any(size == 0.0):
        dead = ", ".join(n for n, s in zip(names, size, strict=True) if s == 0.0)
        raise SingularError(f"the poses say nothing about {dead}; leave them out")
    unit = H / np.outer(size, size)
    low, vectors = np.linalg.eigh(unit)
    if low[0] < 1e-11:
        mixed = [names[k] for k in np.argsort(-np.abs(vectors[:, 0]))[:4] if abs(vectors[k, 0]) > 0.05]
        raise SingularError(f"the poses can't tell {', '.join(mixed)} apart; leave one out or measure other poses")
    L = np.linalg.cholesky(unit)
    step = np.linalg.solve(L.T, np.linalg.solve(L, g / size)) / size
    if np.all(step > lower) and np.all(step < upper):
        return np.asarray(step)
    bounded = lsq_linear(L.T * size, np.linalg.solve(L, g / size), bounds=(lower - 1e-12, upper + 1e-12))
    return np.asarray(bounded.x)
