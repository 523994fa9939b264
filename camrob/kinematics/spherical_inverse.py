"""The Jacobian of an arm with a spherical wrist, inverted in closed form, compiled.

Seen from the point where the last three axes meet, those axes move nothing: the 6x6 Jacobian falls into 3x3 blocks
[V 0; W B] with V the velocities that axes 1 to 3 give that point and B the directions of axes 4 to 6. Vectors are tuples of
three floats, which the compiler keeps in registers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import bare

__all__ = ["closed_inverse_kf", "homogeneous_inverse", "inverse_blocks", "sine_cosine", "wrist_distance"]

Array = NDArray[np.float64]
Vector = tuple[float, float, float]

_MEET = 1e-12  # m, within which the wrist's axes have to meet
_SINGULAR = 1e-13  # determinant of a block, over its columns' lengths, below which there is no inverse
_REGULAR = 1e-4  # and from where on the blocks are good enough for a solver


def wrist_distance(before: Array, after: Array) -> float:
    """How far along the fifth axis from its frame's origin the last three axes meet, m; NaN where they don't.

    before: pose of the fifth axis's frame in that of the fourth, after its motion; after: of the sixth's in the fifth's.
    """
    fourth = np.linalg.inv(before)
    places = []
    for origin, along in ((fourth[:3, 3], fourth[:3, 2]), (after[:3, 3], after[:3, 2])):
        across = along[:2] @ along[:2]
        if across < 1e-6:  # parallel to the fifth axis
            return float("nan")
        share = -(origin[:2] @ along[:2]) / across
        nearest = origin + share * along
        if np.linalg.norm(nearest[:2]) > _MEET:
            return float("nan")
        places.append(float(nearest[2]))
    return places[0] if abs(places[0] - places[1]) <= _MEET else float("nan")


@bare
def sine_cosine(x: float) -> tuple[float, float]:
    """Sine and cosine within a unit in the last place for |x| up to a million; branch-free, unlike the library's two calls."""
    k = np.floor(x * 0.6366197723675814 + 0.5)
    r = (x - k * 1.5707963267341256) - k * 6.077100506506192e-11  # by quarter turns, in two parts
    z = r * r
    s = -1.66666666666666324348e-01 + z * (
        8.33333333332248946124e-03
        + z
        * (
            -1.98412698298579493134e-04
            + z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10))
        )
    )
    sine = r + (z * r) * s
    c = 4.16666666666666019037e-02 + z * (
        -1.38888888888741095749e-03
        + z
        * (
            2.48015872894767294178e-05
            + z * (-2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))
        )
    )
    half = 0.5 * z
    whole = 1.0 - half
    cosine = whole + (((1.0 - whole) - half) + z * z * c)
    quarter = int(k) & 3
    a, b = (cosine, sine) if quarter & 1 else (sine, cosine)
    return (-a if quarter & 2 else a), (-b if (quarter + 1) & 2 else b)


@bare
def _row(M: Array, i: int) -> Vector:
    return M[i, 0], M[i, 1], M[i, 2]


@bare
def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@bare
def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@bare
def _times(k: float, a: Vector) -> Vector:
    return k * a[0], k * a[1], k * a[2]


@bare
def _minus(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@bare
def _mix(m: Vector, a: Vector, b: Vector, c: Vector) -> Vector:
    """m0 a + m1 b + m2 c."""
    return (
        m[0] * a[0] + m[1] * b[0] + m[2] * c[0],
        m[0] * a[1] + m[1] * b[1] + m[2] * c[1],
        m[0] * a[2] + m[1] * b[2] + m[2] * c[2],
    )


@bare
def _wrist(Z: Array, P: Array, start: int, wrist: float) -> Vector:
    """Where the last three axes meet."""
    i = start + 4
    return P[i, 0] + wrist * Z[i, 0], P[i, 1] + wrist * Z[i, 1], P[i, 2] + wrist * Z[i, 2]


@bare
def _inverse(a: Vector, b: Vector, c: Vector) -> tuple[Vector, Vector, Vector, float]:
    """Rows of the inverse of the matrix with columns a, b, c, and its determinant over the columns' lengths (0: none)."""
    bc, ca, ab = _cross(b, c), _cross(c, a), _cross(a, b)
    det = _dot(a, bc)
    size = np.sqrt(_dot(a, a) * _dot(b, b) * _dot(c, c))
    if not abs(det) > _SINGULAR * size:
        return a, b, c, 0.0
    k = 1.0 / det
    return _times(k, bc), _times(k, ca), _times(k, ab), abs(det) / size


@bare
def inverse_blocks(Z: Array, P: Array, point: Array, start: int, wrist: float, rows: Array, lever: Array) -> bool:
    """rows (6, 3) <- rows of V^-1 and of B^-1; lever (3,) <- from `point` (3,) to the wrist. False near a singular posture."""
    c = _wrist(Z, P, start, wrist)
    lever[0], lever[1], lever[2] = c[0] - point[0], c[1] - point[1], c[2] - point[2]
    v0 = _cross(_row(Z, start), _minus(c, _row(P, start)))
    v1 = _cross(_row(Z, start + 1), _minus(c, _row(P, start + 1)))
    v2 = _cross(_row(Z, start + 2), _minus(c, _row(P, start + 2)))
    a0, a1, a2, good = _inverse(v0, v1, v2)
    b0, b1, b2, fine = _inverse(_row(Z, start + 3), _row(Z, start + 4), _row(Z, start + 5))
    for r in range(3):
        rows[0, r], rows[1, r], rows[2, r] = a0[r], a1[r], a2[r]
        rows[3, r], rows[4, r], rows[5, r] = b0[r], b1[r], b2[r]
    return bool(good > _REGULAR and fine > _REGULAR)


@bare
def _put(H: Array, i: int, a: Vector, b: Vector) -> float:
    """H[i] <- (a, b); returns its square."""
    H[i, 0], H[i, 1], H[i, 2] = a
    H[i, 3], H[i, 4], H[i, 5] = b
    return float(_dot(a, a) + _dot(b, b))


@bare
def homogeneous_inverse(Z: Array, P: Array, plate: Array, start: int, wrist: float, length: float, H: Array) -> float:
    """H (6, 6) <- the inverse of the arm's homogeneous Jacobian at `plate` (eq. 15); its squared norm, or inf."""
    c = _wrist(Z, P, start, wrist)
    z0, z1, z2 = _row(Z, start), _row(Z, start + 1), _row(Z, start + 2)
    v0, v1 = _cross(z0, _minus(c, _row(P, start))), _cross(z1, _minus(c, _row(P, start + 1)))
    a0, a1, a2, good = _inverse(v0, v1, _cross(z2, _minus(c, _row(P, start + 2))))
    b0, b1, b2, fine = _inverse(_row(Z, start + 3), _row(Z, start + 4), _row(Z, start + 5))
    if good == 0.0 or fine == 0.0:
        return np.inf
    lever = c[0] - plate[0], c[1] - plate[1], c[2] - plate[2]
    total = _put(H, 0, _times(length, a0), _cross(lever, a0))
    total += _put(H, 1, _times(length, a1), _cross(lever, a1))
    total += _put(H, 2, _times(length, a2), _cross(lever, a2))
    d = _mix((_dot(b0, z0), _dot(b0, z1), _dot(b0, z2)), a0, a1, a2)
    total += _put(H, 3, _times(-length, d), _minus(b0, _cross(lever, d)))
    d = _mix((_dot(b1, z0), _dot(b1, z1), _dot(b1, z2)), a0, a1, a2)
    total += _put(H, 4, _times(-length, d), _minus(b1, _cross(lever, d)))
    d = _mix((_dot(b2, z0), _dot(b2, z1), _dot(b2, z2)), a0, a1, a2)
    total += _put(H, 5, _times(-length, d), _minus(b2, _cross(lever, d)))
    return float(total)


@bare
def _share(
    b: Vector, zs: tuple[Vector, Vector, Vector], rows: tuple[Vector, Vector, Vector], lever: Vector, square: float
) -> float:
    """Squared norm of a row of the wrist's part of the homogeneous inverse."""
    d = _mix((_dot(b, zs[0]), _dot(b, zs[1]), _dot(b, zs[2])), rows[0], rows[1], rows[2])
    turn = _minus(b, _cross(lever, d))
    return float(square * _dot(d, d) + _dot(turn, turn))


@bare
def closed_inverse_kf(Z: Array, P: Array, plate: Array, start: int, wrist: float, length: float) -> float:
    """1/k_F (eq. 16) at `plate`, 0 where the arm is singular: 6 over the norms of the homogeneous Jacobian and its inverse."""
    c = _wrist(Z, P, start, wrist)
    point = plate[0], plate[1], plate[2]
    trace = 0.0
    for k in range(6):
        v = _cross(_row(Z, start + k), _minus(point, _row(P, start + k)))
        trace += _dot(v, v)
    trace = trace / (length * length) + 6.0
    z0, z1, z2 = _row(Z, start), _row(Z, start + 1), _row(Z, start + 2)
    v0, v1 = _cross(z0, _minus(c, _row(P, start))), _cross(z1, _minus(c, _row(P, start + 1)))
    a0, a1, a2, good = _inverse(v0, v1, _cross(z2, _minus(c, _row(P, start + 2))))
    b0, b1, b2, fine = _inverse(_row(Z, start + 3), _row(Z, start + 4), _row(Z, start + 5))
    if good == 0.0 or fine == 0.0:
        return 0.0
    lever = _minus(c, point)
    square = length * length
    total = square * (_dot(a0, a0) + _dot(a1, a1) + _dot(a2, a2))
    t0, t1, t2 = _cross(lever, a0), _cross(lever, a1), _cross(lever, a2)
    total += _dot(t0, t0) + _dot(t1, t1) + _dot(t2, t2)
    zs, rows = (z0, z1, z2), (a0, a1, a2)
    total += (
        _share(b0, zs, rows, lever, square) + _share(b1, zs, rows, lever, square) + _share(b2, zs, rows, lever, square)
    )
    return float(6.0 / np.sqrt(trace * total))
