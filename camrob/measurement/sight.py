"""What a row of a log says of a place: all of it, some of its coordinates, one along a direction, or a distance alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.frozen import locked
from camrob.measurement.log import DISTANCE, NORMAL, POSITION, MeasurementLog
from camrob.units import mm_to_m

__all__ = ["Sight", "sighted"]

Array = NDArray[np.float64]

_ROUNDS, _SETTLED = 30, 1e-9  # m
_AT = 1e-9  # m: nearer to the centre there is no direction
_LEAST = 6  # distances from a point that isn't known
_FLAT = 1e-3  # of how far places lie apart in their widest direction: less in the third tells no centre beside a length


@dataclass(frozen=True, slots=True)
class Sight:
    """Places (N, 3), m, of which only `onto` (N, 3, 3) was measured: projections onto what each row saw. Of distances also the
    `lengths` (N,), m, from `center` (3,), so that no turn away from where the cell puts the target counts.
    """

    places: Array
    onto: Array
    lengths: Array | None = None
    center: Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "places", locked(self.places, shape=(None, 3), name="places"))
        object.__setattr__(self, "onto", locked(self.onto, shape=(len(self.places), 3, 3), name="onto"))

    def select(self, index: NDArray[np.int64] | NDArray[np.bool_] | slice) -> Sight:
        """Some of the rows."""
        lengths = None if self.lengths is None else self.lengths[index]
        return Sight(self.places[index], self.onto[index], lengths, self.center)

    @property
    def away(self) -> Array:
        """(N, 3) unit vectors from where distances are from; 0 of what is no distance."""
        if self.center is None:
            return np.zeros_like(self.places)
        out = self.places - self.center
        return np.asarray(out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), _AT))

    def beyond(self, places: Array) -> Array:
        """(N, 3) m by which what was measured lies beyond modelled places (N, 3)."""
        if self.lengths is None or self.center is None:
            return np.asarray(np.einsum("nij,nj->ni", self.onto, self.places - places))
        away = places - self.center
        size = np.linalg.norm(away, axis=1)
        return np.asarray(away * ((self.lengths - size) / np.maximum(size, _AT))[:, None])

    def of(self, twists: Array) -> Array:
        """Twists (N, 6, ..) or shifts (N, 3, ..) with what was measured of the shifts alone."""
        out = np.array(twists)
        out[:, :3] = np.einsum("nij,nj...->ni...", self.onto, out[:, :3])
        return out

    @property
    def share(self) -> float:
        """Coordinates that a row tells, of three."""
        return float(np.mean(np.trace(self.onto, axis1=1, axis2=2))) / 3.0


def sighted(log: MeasurementLog, nominal: Array) -> Sight | None:
    """What a log's rows say of the places of its target; None where they say all of it. nominal: (N, 3) m, where the cell puts
    the target in the frame that was measured in: directions of distances are taken from there, and what was not measured is
    as nominal.

    Raises LogError for a distance of which the file doesn't say what from.
    """
    if log.has(DISTANCE):
        return _distances(log, nominal)
    if log.has(*NORMAL):
        normal = log.matrix(NORMAL)
        size = np.linalg.norm(normal, axis=1, keepdims=True)
        n = normal / np.where(size > 0.0, size, 1.0)
        return Sight(log.position, n[:, :, None] * n[:, None, :])
    seen = [log.has(name) for name in POSITION]
    if all(seen):
        return None
    places = np.array(nominal)
    for k, name in enumerate(POSITION):
        if seen[k]:
            places[:, k] = mm_to_m(log.columns[name])
    return Sight(places, np.tile(np.diag(np.array(seen, float)), (len(log), 1, 1)))


def _distances(log: MeasurementLog, nominal: Array) -> Sight:
    d, info = np.asarray(mm_to_m(log.columns[DISTANCE])), log.info
    if info.along is not None:
        n = np.asarray(info.along)
        return Sight(nominal + n * (d - nominal @ n)[:, None], np.tile(np.outer(n, n), (len(d), 1, 1)))
    if info.distance_from is None and not info.distance_from_unknown:
        hint = 'd_from_mm = [X, Y, Z] or "unknown" (a bar, a wire), or d_along = [0, 0, 1] (a gauge), in its .toml'
        raise log.error("has distances d, and doesn't say from where", hint=hint, at=None)
    center, zero = np.zeros(3), 0.0
    if info.distance_from is not None:
        center = np.asarray(info.distance_from)
    if info.distance_from_unknown or info.distance_zero_unknown:
        center, zero = _center(log, nominal, d, None if info.distance_from_unknown else center)
    away = nominal - center
    size = np.linalg.norm(away, axis=1, keepdims=True)
    u = away / np.where(size > 0.0, size, 1.0)
    return Sight(center + u * (d + zero)[:, None], u[:, :, None] * u[:, None, :], d + zero, center)


def _center(log: MeasurementLog, nominal: Array, d: Array, known: Array | None) -> tuple[Array, float]:
    """Where distances (N,) to places (N, 3) are from, and what has to be added to them: robust Gauss-Newton, from the sphere
    that fits best in squares. known: the centre, where only the length is not known.
    """
    if len(d) < _LEAST:
        what = f"holds {len(d)} distances from a point that isn't known"
        raise log.error(what, hint=f"measure at least {_LEAST}, or give d_from_mm")
    middle = nominal.mean(axis=0)
    p, open_zero = nominal - middle, log.info.distance_zero_unknown
    if known is not None:
        starts = [(known - middle, 0.0)]
    else:
        starts = [_from_lengths(p, d, open_zero=open_zero), *([_from_one_length(p, d)] if open_zero else [])]
    tried = [_refined(p, d, start, moves=known is None, open_zero=open_zero) for start in starts]
    center, zero, _ = min(tried, key=lambda t: t[2])
    return center + middle, zero


def _from_lengths(p: Array, d: Array, *, open_zero: bool) -> tuple[Array, float]:
    """Centre and zero by |p|^2 - d^2 = 2 p c + 2 d z - k, in the least squares. Where all places lie in one plane, the centre is
    below it by what the distances are longer.
    """
    A = np.concatenate([2.0 * p, *([2.0 * d[:, None]] if open_zero else []), np.ones((len(p), 1))], axis=1)
    found = np.linalg.lstsq(A, np.sum(p**2, axis=1) - d**2, rcond=1e-9)[0]
    center, zero = found[:3], float(found[3]) if open_zero else 0.0
    _, spread, axes = np.linalg.svd(p, full_matrices=False)
    if spread[2] < _FLAT * spread[0]:
        normal = axes[2] * (np.sign(axes[2, 2]) or 1.0)
        center = center - normal * float(normal @ center)
        short = float(np.median((d + zero) ** 2 - np.sum((p - center) ** 2, axis=1)))
        center = center - normal * float(np.sqrt(max(short, 0.0)))
    return center, zero


def _from_one_length(p: Array, d: Array) -> tuple[Array, float]:
    """Centre and zero of distances that are nearly one, as a bar's are."""
    A = np.concatenate([2.0 * p, np.ones((len(p), 1))], axis=1)
    center = np.linalg.lstsq(A, np.sum(p**2, axis=1), rcond=1e-9)[0][:3]
    return center, float(np.median(np.linalg.norm(p - center, axis=1) - d))


def _refined(
    p: Array, d: Array, start: tuple[Array, float], *, moves: bool, open_zero: bool
) -> tuple[Array, float, float]:
    """Centre and zero that fit best near a start, and the median m that is left."""
    center, zero = start
    left = np.zeros(len(p))
    for _ in range(_ROUNDS):
        away = p - center
        size = np.maximum(np.linalg.norm(away, axis=1), _AT)
        left = d + zero - size
        J = np.concatenate([-away / size[:, None]] * moves + [-np.ones((len(p), 1))] * open_zero, axis=1)
        weight = 1.0 / np.sqrt(np.maximum(1.0, np.abs(left) / (3.0 * np.median(np.abs(left)) + _AT)))
        step = np.linalg.lstsq(J * weight[:, None], left * weight, rcond=1e-6)[0]
        center, zero = center + (step[:3] if moves else 0.0), zero + (float(step[-1]) if open_zero else 0.0)
        if float(np.abs(step).max()) < _SETTLED:
            break
    return center, zero, float(np.median(np.abs(left)))
