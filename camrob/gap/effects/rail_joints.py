"""Where the pieces of a rail meet: places on its travel at which the gap steps or bends, beyond constants and a smooth rail."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.common import found_once
from camrob.gap.observation.noise import plain_gap
from camrob.gap.observation.scene import Scene

__all__ = ["CHOICES", "SHIFTS", "TURNS", "piece", "rail_joints"]

Array = NDArray[np.float64]

SHIFTS, TURNS = ("x", "y", "z"), ("rx", "ry", "rz")
"""Of the robot's foot: a piece may lie off and slope along the first, and be turned about the second."""
CHOICES = 30  # places that are tried
_MOST = 3  # joints that are looked for
_EDGE = 0.08  # of the travel and of the samples, in which a piece could not be told from its end
_APART = 1.5  # of the way between places that are tried: two joints are not nearer
_FINE = (-0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6)  # of that way: where a joint is looked for again
_ROWS = 600  # samples of all logs that tell well enough
_SMOOTH = {"x": 3, "y": 3, "z": 3, "rx": 2, "ry": 2, "rz": 2}  # powers of the place that a smooth rail takes up
# times the scatter of what stays, and share of it, that a joint has to take: with nine columns and thirty places chance gives 30
_CLEAR, _PART = 80.0, 0.1
_PEAK = 1.6  # times what the middle one of all places takes: what takes as much anywhere is no joint
_TINY = 1e-12


def piece(scene: Scene, axis: str, joint: float, parts: Sequence[str]) -> Array:
    """(N, 6, k) how the TCP moves where what lies beyond a joint (m) is elsewhere by a unit of some parts of the foot's place; of
    a shift as it is, and growing with the way from there.
    """
    way = scene.link[:, scene.index(axis)] - joint
    beyond = (way > 0.0).astype(float)
    columns = []
    for part in parts:
        twist = scene.place(f"root.{part}")
        columns.append(twist * beyond[:, None])
        if part in SHIFTS:
            columns.append(twist * (beyond * way)[:, None])
    return np.stack(columns, axis=2)


def rail_joints(scenes: Sequence[Scene], axis: str) -> tuple[float, ...]:
    """Places (m) on a rail's travel at which the gap clearly steps or bends, the clearest first."""
    return found_once(scenes, ("rail", axis), lambda: _searched(scenes, axis))


def _searched(scenes: Sequence[Scene], axis: str) -> tuple[float, ...]:
    travel = np.concatenate([s.link[:, s.index(axis)] for s in scenes])
    low, high = float(travel.min()), float(travel.max())
    within = np.quantile(travel, [_EDGE, 1.0 - _EDGE])
    tried = np.linspace(low + _EDGE * (high - low), high - _EDGE * (high - low), CHOICES)
    tried = tried[(tried > within[0]) & (tried < within[1])]
    step = max(1, len(travel) // _ROWS)
    rows = [np.arange(0, len(s), step) for s in scenes]
    y = np.concatenate([plain_gap(s)[r, :3].ravel() for s, r in zip(scenes, rows, strict=True)])
    Q = _columns_apart(np.concatenate([_others(s, axis, r, low, high) for s, r in zip(scenes, rows, strict=True)]))
    left = y - Q @ (Q.T @ y)
    found: list[float] = []
    apart = (high - low) / CHOICES
    for _ in range(_MOST if len(y) > 2 * Q.shape[1] else 0):
        free = [c for c in tried.tolist() if all(abs(c - f) > _APART * apart for f in found)]
        bases = [_beyond(scenes, axis, c, rows, Q) for c in free]
        gains = [float(np.sum((own.T @ left) ** 2)) for own in bases]
        gain, whole = max(gains, default=0.0), float(left @ left)
        if gain < max(_CLEAR * (whole - gain) / len(y), _PART * whole, _PEAK * float(np.median(gains or [0.0]))):
            break
        near = [free[int(np.argmax(gains))] + apart * part for part in _FINE]
        own, place = max(
            ((_beyond(scenes, axis, c, rows, Q), c) for c in near), key=lambda x: float(np.sum((x[0].T @ left) ** 2))
        )
        found.append(place)
        left = left - own @ (own.T @ left)
        Q = np.concatenate([Q, own], axis=1)
    return tuple(found)


def _beyond(scenes: Sequence[Scene], axis: str, joint: float, rows: Sequence[NDArray[np.int64]], Q: Array) -> Array:
    """An orthonormal basis (3 R, r) of what a piece beyond a joint shows that Q (3 R, q) does not."""
    parts = [
        piece(s, axis, joint, (*SHIFTS, *TURNS))[r, :3].reshape(3 * len(r), -1)
        for s, r in zip(scenes, rows, strict=True)
    ]
    B = np.concatenate(parts)
    return _columns_apart(B - Q @ (Q.T @ B))


def _others(scene: Scene, axis: str, rows: NDArray[np.int64], low: float, high: float) -> Array:
    """(3 R, K) what constants of the chain and a smooth rail show."""
    s = (2.0 * scene.link[rows, scene.index(axis)] - low - high) / max(high - low, _TINY)
    columns = [p[rows, :3].ravel() for p in scene.places.values()]
    columns += [
        (scene.place(f"root.{part}")[rows, :3] * (s**k)[:, None]).ravel()
        for part, degree in _SMOOTH.items()
        for k in range(1, degree + 1)
    ]
    return np.stack(columns, axis=1)


def _columns_apart(X: Array) -> Array:
    """An orthonormal basis (M, r) of columns, without those that others show."""
    scale = np.linalg.norm(X, axis=0)
    X = X[:, scale > _TINY] / scale[scale > _TINY]
    values, vectors = np.linalg.eigh(X.T @ X)
    good = values > 1e-9 * max(float(values[-1]), _TINY) if len(values) else np.zeros(0, bool)
    return np.asarray(X @ (vectors[:, good] / np.sqrt(values[good])))
