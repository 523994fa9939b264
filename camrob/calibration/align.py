"""Where an instrument stands and where its reflector sits, from measured poses and nominal kinematics alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.errors import SingularError
from camrob.measurement.sight import Sight
from camrob.se3 import pose

__all__ = ["align", "laid_by_part"]

Array = NDArray[np.float64]

_SAME_PART = 1e-9  # apart: rounding
_FLAT = 1e-3  # of how far places lie apart: less in the third direction tells no frame
_KEPT = 1e-3  # how much of what was not measured is kept as it was, beside what was
_ROUNDS = 200  # frame and reflector in turns: an end for a fit that wanders


def align(
    nominal: Array, measured: Array, *, oriented: bool, frame_known: bool, target_known: bool
) -> tuple[Array, Array]:
    """left and right (4, 4) with measured ~ left @ nominal @ right, of poses (N, 4, 4).

    frame_known, target_known: left, right are the identity. With orientations the rotations follow from a linear null
    vector (R_m B = A R_n) and the places from linear least squares; without, in turns: the frame by matching points
    (Kabsch), the reflector by least squares; its orientation means nothing then. What follows is a start for a fit,
    good to about the robot's error. Raises SingularError where the poses are too few or lie on a line.
    """
    left, right = np.eye(4), np.eye(4)
    if frame_known and target_known:
        return left, right
    spread = nominal[:, :3, 3] - nominal[:, :3, 3].mean(axis=0)
    if len(nominal) < 4 or (not frame_known and np.linalg.svd(spread, compute_uv=False)[1] < 1e-3):
        why = f"{len(nominal)} poses are too few" if len(nominal) < 4 else f"its {len(nominal)} poses are on one line"
        raise SingularError(f"the instrument's frame can't be found: {why}; measure 4 or more, spread in space")
    if oriented:
        return _oriented(nominal, measured, frame_known, target_known)
    return _by_turns(nominal, measured, frame_known, target_known)


def laid_by_part(nominal: Array, sight: Sight) -> Array:
    """The frame (4, 4) that lays places (N, 3) on those of which only a part was measured, the same of every row: a start for a
    fit. What was not measured, or hardly shows, stays as it is; so does all where rows saw different parts.
    """
    onto = sight.onto
    if float(np.abs(onto - onto[0]).max()) > _SAME_PART:
        return np.eye(4)
    size, axes = np.linalg.eigh(onto[0])
    B = axes[:, size > 0.5].T  # (r, 3) what was measured
    middle = nominal.mean(axis=0)
    points, seen = nominal - middle, sight.places @ B.T
    spread = np.linalg.svd(points, compute_uv=False)
    if spread[2] < _FLAT * spread[0]:
        return np.eye(4)
    W = np.linalg.lstsq(points, seen - seen.mean(axis=0), rcond=1e-6)[0].T
    U, _, Vt = np.linalg.svd(W, full_matrices=False)
    R = _nearest_rotation(B.T @ (U @ Vt) + _KEPT * (np.eye(3) - onto[0]))
    # the rows of B have to come out as fitted: what is left over turns about them alone
    return pose(R, B.T @ seen.mean(axis=0) + (np.eye(3) - onto[0]) @ middle - onto[0] @ R @ middle)


def _oriented(nominal: Array, measured: Array, frame_known: bool, target_known: bool) -> tuple[Array, Array]:
    """From whole poses: by their rotations, or, should these hardly differ (and say nothing of the frame), by the
    places.
    """
    choices = [_rotations(nominal, measured, frame_known, target_known)]
    if not (frame_known or target_known):
        R = _by_turns(nominal, measured, frame_known, target_known)[0][:3, :3]
        choices.append((R, _reflector(nominal, measured, R)))
    best, least = (np.eye(4), np.eye(4)), np.inf
    for left_R, right_R in choices:
        places = _places(nominal, measured, left_R, frame_known, target_known)
        left, right = pose(left_R, places[0]), pose(right_R, places[1])
        error = float(np.median(np.linalg.norm((left @ nominal @ right - measured)[:, :3, 3], axis=1)))
        if error < least:
            best, least = (left, right), error
    return best


def _by_turns(nominal: Array, measured: Array, frame_known: bool, target_known: bool) -> tuple[Array, Array]:
    """From positions alone: frame and reflector in turns."""
    left, right = np.eye(4), np.eye(4)
    before = np.inf
    for _ in range(_ROUNDS):
        tips = nominal[:, :3, :3] @ right[:3, 3] + nominal[:, :3, 3]
        if not frame_known:
            left = _matched(tips, measured[:, :3, 3])
        error = float(np.linalg.norm(left[:3, :3] @ tips.T + left[:3, 3:] - measured[:, :3, 3].T))
        if target_known or before - error < 1e-9 * error:
            break
        before = error
        place = _places(nominal, measured, left[:3, :3], frame_known, target_known)
        left[:3, 3], right[:3, 3] = place
    return left, right


def _matched(points: Array, seen: Array) -> Array:
    """The rigid motion (4, 4) that lays points (N, 3) onto others best (Kabsch)."""
    a, b = points.mean(axis=0), seen.mean(axis=0)
    R = _nearest_rotation((seen - b).T @ (points - a))
    return pose(R, b - R @ a)


def _nearest_rotation(M: Array) -> Array:
    """The rotation nearest to a matrix (3, 3)."""
    U, _, Vt = np.linalg.svd(M)
    return np.asarray(U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt)


def _rotations(nominal: Array, measured: Array, frame_known: bool, target_known: bool) -> tuple[Array, Array]:
    """Rotations (A, B^T) of left and right: R_m = A R_n B^T."""
    Rn, Rm = nominal[:, :3, :3], measured[:, :3, :3]
    if target_known:
        return _nearest_rotation(np.sum(Rm @ np.swapaxes(Rn, 1, 2), axis=0)), np.eye(3)
    if frame_known:
        return np.eye(3), _nearest_rotation(np.sum(np.swapaxes(Rn, 1, 2) @ Rm, axis=0))
    # (I x R_m) vec(B) = (R_n^T x I) vec(A), columns stacked: the least singular vector
    eye = np.eye(3)
    rows = np.concatenate([np.stack([np.kron(eye, m) for m in Rm]), -np.stack([np.kron(n.T, eye) for n in Rn])], axis=2)
    vector = np.linalg.eigh(np.einsum("nij,nik->jk", rows, rows))[1][:, 0]
    A = vector[9:].reshape(3, 3, order="F")
    sign = np.sign(np.linalg.det(A)) or 1.0
    A = _nearest_rotation(sign * A)
    return A, _reflector(nominal, measured, A)


def _reflector(nominal: Array, measured: Array, left_R: Array) -> Array:
    """The rotation of right that fits best with a rotation of left."""
    return _nearest_rotation(np.sum(np.swapaxes(left_R @ nominal[:, :3, :3], 1, 2) @ measured[:, :3, :3], axis=0))


def _places(
    nominal: Array, measured: Array, left_R: Array, frame_known: bool, target_known: bool
) -> tuple[Array, Array]:
    """Translations of left and right, of least norm where the poses leave them open: p_m = A (R_n x + p_n) + l."""
    N = len(nominal)
    wanted = (measured[:, :3, 3] - nominal[:, :3, 3] @ left_R.T).ravel()
    columns = []
    if not frame_known:
        columns.append(np.tile(np.eye(3), (N, 1)))
    if not target_known:
        columns.append((left_R @ nominal[:, :3, :3]).reshape(-1, 3))
    found = np.linalg.lstsq(np.concatenate(columns, axis=1), wanted, rcond=1e-6)[0]
    frame = np.asarray(np.zeros(3) if frame_known else found[:3])
    return frame, np.asarray(np.zeros(3) if target_known else found[-3:])
