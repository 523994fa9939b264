"""Axis by axis what lies between set-point and encoder, and between motor and link: how much, and what it follows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.evidence.unknown import CONSTANT
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import play
from camrob.summaries.diagnosis_places import AxisError, AxisReport, DriveError, ErrorPattern
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

__all__ = ["axes_report"]

Array = NDArray[np.float64]

_MOST_ROWS = 4000  # tell a pattern well enough
_REST = 0.02  # of an axis's ordinary speed: slower is at rest
_ORDERS = 300  # periods that are tried
_FEWEST_CYCLES, _PER_CYCLE = 2.0, 6.0  # of a period within the travel, and samples a cycle
_WORTH = 0.1  # share of the energy beyond a constant that a pattern explains at the least
_RIDGE = 1e-9
_COEFFICIENTS = {"speed": "s", "acceleration": "s2"}
_MOSTLY, _BY_SIZE = 0.5, 0.25  # share below which a pattern is not all, and of an error's size, from which that is one
_RANGES, _STRETCHES, _FOLDS = 12, 24, 8  # of what a size may follow, and of a log
_EXTREME = 0.999  # quantile of squares, beyond which one counts as that


def axes_report(scenes: Sequence[Scene]) -> dict[str, AxisReport]:
    """For each axis of which both ends are logged: rms and worst error in degrees or mm, its size at the tool in mm, and its
    pattern: what it follows, the share of its energy, the coefficient. {} where no log has both.

    `within` says whether the whole is no more than the drives' stated noise ("noise") or moves the tool by no more than the
    stated tolerance ("tolerance"); "" otherwise. `motor_to_link`: the same between motor-side and link-side encoders.
    """
    out: dict[str, AxisReport] = {}
    for k, axis in enumerate(scenes[0].axes):
        linear = scenes[0].cell.joints[scenes[0].cell.index(axis)].prismatic
        parts = [(s, s.servo_gap[:, k]) for s in scenes if s.servo_gap is not None]
        motors = [(s, s.link[:, k] - m) for s in scenes if (m := s.motor(axis)) is not None]
        drive = _one(parts, k, linear) if parts else None
        if drive is not None or motors:
            out[axis] = AxisReport(
                drive=None if drive is None else _of_drive(drive, _within(parts, k, linear)),
                motor_to_link=_one(motors, k, linear) if motors else None,
            )
    return out


def _of_drive(error: AxisError, within: str) -> DriveError:
    """An error as that of a drive, which may be within its noise or the tolerance."""
    return DriveError(
        unit=error.unit,
        rms=error.rms,
        worst=error.worst,
        mean=error.mean,
        rms_mm=error.rms_mm,
        pattern=error.pattern,
        within=within,
    )


def _one(parts: Sequence[tuple[Scene, Array]], k: int, linear: bool) -> AxisError:
    """One axis's error (N,) a log, SI."""
    edge = m_to_mm if linear else rad_to_deg
    whole = np.concatenate([e for _, e in parts])
    at_tool = np.concatenate([_carried(s, k, e) for s, e in parts])
    return AxisError(
        unit="mm" if linear else "deg",
        rms=edge(float(np.sqrt(np.mean(whole**2)))),
        worst=edge(float(np.abs(whole).max())),
        mean=edge(float(whole.mean())),
        rms_mm=m_to_mm(float(np.sqrt(np.mean(at_tool**2)))),
        pattern=_pattern(parts, k, linear),
    )


def _carried(scene: Scene, k: int, error: Array) -> Array:
    """(N,) m at the TCP, through the nominal chain; 0 where the axis does not move what is measured."""
    name = f"{scene.axes[k]}.zero"
    return np.linalg.norm(scene.places[name][:, :3], axis=1) * error if name in scene.places else np.zeros(len(error))


def _within(parts: Sequence[tuple[Scene, Array]], k: int, linear: bool) -> str:
    stated = [s.log.info.sigma_axis_length if linear else s.log.info.sigma_axis for s, _ in parts]
    if all(np.sqrt(np.mean(e**2)) <= sigma for (_, e), sigma in zip(parts, stated, strict=True)):
        return "noise"
    if all(np.abs(_carried(s, k, e)).max() <= s.log.info.tolerance for s, e in parts):
        return "tolerance"
    return ""


def _features(scene: Scene, k: int, linear: bool) -> dict[str, Array]:
    """(N, d) each: what an axis's error may follow. Direction comes as sign and as the state of a play."""
    u = scene.command[:, k]
    v, a = (scene.velocity(u[:, None], order)[:, 0] for order in (1, 2))
    moving = np.abs(v[np.abs(v) > 0.0])
    rest = _REST * float(np.median(moving)) if len(moving) else 1.0
    width = mm_to_m(0.02) if linear else deg_to_rad(0.02)
    direction = [np.tanh(v / max(rest, 1e-12)), play(u, scene.t, scene.pieces, width)]
    return {
        "speed": v[:, None],
        "acceleration": a[:, None],
        "direction": np.stack(direction, axis=1),
        "load": scene.torque[:, [k]],
        "time": (scene.t - scene.t[0])[:, None],
        "position": np.stack([u, u**2], axis=1),
    }


def _pattern(parts: Sequence[tuple[Scene, Array]], k: int, linear: bool) -> ErrorPattern:
    """What the error follows most, alone; the coefficients are those of all that it may follow together."""
    given = [_features(s, k, linear) for s, _ in parts]
    names = list(given[0])
    y = np.concatenate([e for _, e in parts])
    step = max(1, len(y) // _MOST_ROWS)
    X = {n: np.concatenate([g[n] for g in given])[::step] for n in names}
    y, u = y[::step] - y.mean(), np.concatenate([s.command[:, k] for s, _ in parts])[::step]
    energy, whole = float(np.sum(y**2)), np.concatenate([e for _, e in parts])[::step]
    edge = m_to_mm if linear else rad_to_deg
    nothing = ErrorPattern(follows=CONSTANT, share=0.0, coefficient=None, unit="", period=None)
    if energy <= _RIDGE**2 * float(np.sum(whole**2)):  # a constant, but for rounding
        return nothing
    shares = {n: 1.0 - _left(X[n], y) / energy for n in names}
    period, periodic = _periodic(u, y - _fitted(np.concatenate([X[n] for n in names], axis=1), y))
    best = max(shares, key=lambda n: shares[n])
    rest = energy * (1.0 - max(shares.values()))
    if period > 0.0 and periodic > max(shares[best] * energy, 0.5 * rest):
        size = edge(float(np.sqrt(2.0 * periodic / len(y))))
        return ErrorPattern(
            follows="position",
            share=periodic / energy,
            coefficient=size,
            unit="mm" if linear else "deg",
            period=edge(period),
        )
    by_size, share = _size_follows(parts, k) if shares[best] < _MOSTLY else ("", 0.0)
    if share > _BY_SIZE:
        return ErrorPattern(follows=by_size, share=share, coefficient=None, unit="", period=None)
    if shares[best] < _WORTH:
        return nothing
    solved = _solved(np.concatenate([X[n] for n in names], axis=1), y)
    at = np.cumsum([0, *(X[n].shape[1] for n in names)])[names.index(best)]
    if best in _COEFFICIENTS:
        coefficient, unit = float(solved[at]), _COEFFICIENTS[best]
    else:
        moved = _fitted(X[best], y)
        coefficient = edge(0.5 * float(np.quantile(moved, 0.98) - np.quantile(moved, 0.02)))
        unit = "mm" if linear else "deg"
    return ErrorPattern(follows=best, share=shares[best], coefficient=coefficient, unit=unit, period=None)


def _size_follows(parts: Sequence[tuple[Scene, Array]], k: int) -> tuple[str, float]:
    """What the size of an axis's error follows most, whichever way it is off, and the share of the changes of its square that
    this shows on stretches left out: what rings at a speed, sags under an acceleration or rubs at a place swings to both sides.
    """
    found: dict[str, list[Array]] = {"speed": [], "acceleration": [], "position": []}
    squares, folds = [], []
    for scene, error in parts:
        u = scene.command[:, k]
        v, a = (scene.velocity(u[:, None], order)[:, 0] for order in (1, 2))
        for name, x in (("speed", np.abs(v)), ("acceleration", np.abs(a)), ("position", u)):
            found[name].append(x)
        squares.append((error - np.median(error)) ** 2)
        folds.append((np.arange(len(u)) * _STRETCHES // len(u)) % _FOLDS)
    square, fold = np.concatenate(squares), np.concatenate(folds)
    square = np.minimum(square, np.quantile(square, _EXTREME))
    shares = {n: _shown(np.concatenate(x), square, fold) for n, x in found.items()}
    best = max(shares, key=lambda n: shares[n])
    return best, shares[best]


def _shown(x: Array, square: Array, fold: NDArray[np.int64]) -> float:
    """Share of the changes of squares (N,) that their mean in ranges of x (N,) shows, each fold by the others' means."""
    edges = np.unique(np.quantile(x, np.linspace(0.0, 1.0, _RANGES + 1)[1:-1]))
    at, whole = np.digitize(x, edges), float(np.sum((square - square.mean()) ** 2))
    sums, counts = (
        np.array([np.bincount(at[fold == f], w[fold == f], len(edges) + 1) for f in range(_FOLDS)])
        for w in (square, np.ones(len(x)))
    )
    rest, count = sums.sum(axis=0) - sums, counts.sum(axis=0) - counts
    mean = np.where(count > 0.0, rest / np.maximum(count, 1.0), square.mean())
    return 1.0 - float(np.sum((square - mean[fold, at]) ** 2)) / max(whole, 1e-300)


def _periodic(u: Array, y: Array) -> tuple[float, float]:
    """The period of what is left (0 where none can be seen) over an axis's travel, and the energy that it explains."""
    span = float(np.ptp(u))
    step = float(np.median(np.abs(np.diff(u)))) if len(u) > 1 else 0.0
    longest, shortest = span / _FEWEST_CYCLES, _PER_CYCLE * step
    if not 0.0 < shortest < longest:
        return 0.0, 0.0
    frequencies = np.linspace(1.0 / longest, min(1.0 / shortest, _ORDERS / span), _ORDERS)
    gained = _by_frequency(u, y - y.mean(), frequencies)
    best = int(np.argmax(gained))
    return (1.0 / float(frequencies[best]), float(gained[best])) if gained[best] > 0.0 else (0.0, 0.0)


def _by_frequency(u: Array, y: Array, frequencies: Array) -> Array:
    """(F,) energy of y (N,), whose mean is 0, that a cosine and a sine over u explain beside a constant, at evenly spaced
    frequencies: each turns the one before it on.
    """
    turn = np.exp(2.0j * np.pi * frequencies[0] * u)
    step = np.exp(2.0j * np.pi * (frequencies[1] - frequencies[0]) * u)
    sums = np.empty((len(frequencies), 3), np.complex128)  # of the turns, of their squares, and with y
    for row in sums:
        row[:] = turn.sum(), turn @ turn, turn @ y
        turn *= step
    count, c, s = len(u), sums[:, 0].real, sums[:, 0].imag
    cc = 0.5 * (count + sums[:, 1].real) - c**2 / count
    ss = 0.5 * (count - sums[:, 1].real) - s**2 / count
    cs = 0.5 * sums[:, 1].imag - c * s / count
    cy, sy = sums[:, 2].real, sums[:, 2].imag
    size = np.maximum(cc * ss, _RIDGE**2 * count**2)
    det = (1.0 + _RIDGE) ** 2 * size - cs**2
    return np.asarray((cy**2 * ss - 2.0 * cy * sy * cs + sy**2 * cc) / det)


def _solved(X: Array, y: Array) -> Array:
    """Coefficients of columns (N, d), each beyond its mean."""
    Z = X - X.mean(axis=0)
    size = np.linalg.norm(Z, axis=0)
    flat = size <= _RIDGE * np.linalg.norm(X, axis=0)
    Z = Z / np.where(flat | (size == 0.0), np.inf, size)
    solved = np.linalg.solve(Z.T @ Z + _RIDGE * np.eye(Z.shape[1]), Z.T @ y)
    return np.asarray(np.where(flat | (size == 0.0), 0.0, solved / np.where(size == 0.0, 1.0, size)))


def _fitted(X: Array, y: Array) -> Array:
    return np.asarray((X - X.mean(axis=0)) @ _solved(X, y))


def _left(X: Array, y: Array) -> float:
    return float(np.sum((y - _fitted(X, y)) ** 2))
