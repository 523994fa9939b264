"""Frames that are not known: the instrument's own, and the reflector's place on the flange."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.align import laid_by_part
from camrob.measurement.sight import Sight
from camrob.se3 import exp, pose, rotation_log, skew

__all__ = ["Frames", "fit_frames", "left_twists", "right_twists"]

Array = NDArray[np.float64]

_ROUNDS = 60  # at the most: it ends where a step is nothing


@dataclass(frozen=True, slots=True)
class Frames:
    """left, right (4, 4): measured = left @ nominal @ right. fitted_left, fitted_right: True where they are nuisances."""

    left: Array
    right: Array
    fitted_left: bool
    fitted_right: bool


def fit_frames(
    nominal: Array,
    measured: Array,
    seen: NDArray[np.bool_],
    *,
    left: bool,
    right: bool,
    known: Frames | None = None,
    sight: Sight | None = None,
) -> Frames:
    """The frames that bring nominal poses (N, 4, 4) to the measured ones, robustly; the identity where they are known.

    known: frames of another log, which are taken as they are where it did not leave them open. Gauss-Newton from the rigid fit
    of the points; orientations weigh as if at half a metre. sight: what alone was measured of places.
    """
    if known is not None and ((left and not known.fitted_left) or (right and not known.fitted_right)):
        L = known.left if left and not known.fitted_left else np.eye(4)
        R = known.right if right and not known.fitted_right else np.eye(4)
        rest = fit_frames(
            L @ nominal @ R,
            measured,
            seen,
            left=left and known.fitted_left,
            right=right and known.fitted_right,
            sight=sight,
        )
        # only one side is open: the other stands between it and the chain
        return Frames(rest.left @ L, R @ rest.right, rest.fitted_left, rest.fitted_right)
    L, R = np.eye(4), np.eye(4)
    if not left and not right:
        return Frames(L, R, False, False)
    if left:
        L = _rigid(nominal[:, :3, 3], measured[:, :3, 3]) if sight is None else laid_by_part(nominal[:, :3, 3], sight)
    turned = seen[:, 3:].all(axis=1)
    if left and right and turned.sum() > 5:
        L[:3, :3] = _left_rotation(nominal[turned, :3, :3], measured[turned, :3, :3], L[:3, :3])
        L[:3, 3] = np.median(measured[:, :3, 3] - nominal[:, :3, 3] @ L[:3, :3].T, axis=0)
    if right and turned.any():
        R[:3, :3] = _mean_rotation((L @ nominal[turned])[:, :3, :3].swapaxes(1, 2) @ measured[turned, :3, :3])
    columns = 6 * (int(left) + int(right))
    weight = np.concatenate([np.ones(3), np.full(3, 0.5)])
    for _ in range(_ROUNDS):
        now = L @ nominal @ R
        residual = np.zeros((len(now), 6))
        residual[:, :3] = measured[:, :3, 3] - now[:, :3, 3] if sight is None else sight.beyond(now[:, :3, 3])
        residual[:, 3:] = np.where(seen[:, 3:], rotation_log(measured[:, :3, :3] @ now[:, :3, :3].swapaxes(1, 2)), 0.0)
        X = np.concatenate([left_twists(now)] * left + [right_twists(now)] * right, axis=2)
        if sight is not None:
            X = sight.of(X)
        size = np.linalg.norm(residual[:, :3], axis=1)
        robust = 1.0 / np.maximum(1.0, size / (3.0 * np.median(size) + 1e-12))
        w = np.where(seen, weight, 0.0) * np.sqrt(robust)[:, None]
        step = np.linalg.lstsq((X * w[..., None]).reshape(-1, columns), (residual * w).ravel(), rcond=1e-9)[0]
        if left:
            L = exp(step[:6]) @ L
        if right:
            R = R @ exp(step[-6:])
        if np.abs(step).max() < 1e-12:
            break
    return Frames(L, R, left, right)


def left_twists(poses: Array) -> Array:
    """(N, 6, 6): how poses move when a twist is multiplied on their left."""
    out = np.zeros((len(poses), 6, 6))
    out[:, :3, :3] = out[:, 3:, 3:] = np.eye(3)
    out[:, :3, 3:] = -skew(poses[:, :3, 3])
    return out


def right_twists(poses: Array) -> Array:
    """(N, 6, 6): how poses move when a twist is multiplied on their right."""
    out = np.zeros((len(poses), 6, 6))
    out[:, :3, :3] = out[:, 3:, 3:] = poses[:, :3, :3]
    return out


def _rigid(points: Array, others: Array) -> Array:
    """The rigid motion (4, 4) that brings points (N, 3) to others, in the least squares."""
    a, b = points.mean(axis=0), others.mean(axis=0)
    U, _, Vt = np.linalg.svd((others - b).T @ (points - a))
    R = U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))]) @ Vt
    return pose(R, b - R @ a)


def _mean_rotation(R: Array) -> Array:
    """The rotation nearest to the mean of rotations (N, 3, 3)."""
    U, _, Vt = np.linalg.svd(R.mean(axis=0))
    return np.asarray(U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))]) @ Vt)


def _left_rotation(nominal: Array, measured: Array, start: Array) -> Array:
    """The rotation L of measured = L nominal X, X unknown: turns between poses are the same turns, seen from elsewhere."""
    count = len(nominal)
    pick = np.linspace(0, count - 1, min(count, 400)).astype(int)
    other = (pick + count // 2) % count
    a = rotation_log(nominal[pick] @ nominal[other].swapaxes(1, 2))
    b = rotation_log(measured[pick] @ measured[other].swapaxes(1, 2))
    good = (np.linalg.norm(a, axis=1) > 0.05) & (np.linalg.norm(a, axis=1) < 2.9)
    good &= np.abs(np.linalg.norm(a, axis=1) - np.linalg.norm(b, axis=1)) < 0.02
    if good.sum() < 6:
        return start
    U, s, Vt = np.linalg.svd(b[good].T @ a[good])
    if s[1] < 1e-6:
        return start
    return np.asarray(U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))]) @ Vt)
