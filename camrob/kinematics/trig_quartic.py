"""Real roots of a quadratic in cosine and sine of one angle: at most four, what the general three-axis problems come down to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import part
from camrob.kinematics.subproblems import cone

__all__ = ["conic_angles", "lasting_angles", "square_onto"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_DEGREE = 1e-13  # of the largest coefficient, below which the second harmonic is none
_ROUND = 1e-3  # how far from the unit circle a double root may have come by rounding, whose square root it feels
_ZERO = 1e-11  # of the largest coefficient: what a root may leave over
_SAME = 1e-9  # rad apart, two roots are one
_STEP = 0.1  # rad that an extreme is sought at a time
_POLISHES = 6  # steps of Newton's method


@part
def square_onto(f: Array, sign: float, m: float, c: float, s: float) -> None:
    """f (6,) += sign (m + c cos + s sin)^2, its coefficients being those of 1, cos, sin, cos^2, cos sin, sin^2."""
    f[0] += sign * m * m
    f[1] += sign * 2.0 * m * c
    f[2] += sign * 2.0 * m * s
    f[3] += sign * c * c
    f[4] += sign * 2.0 * c * s
    f[5] += sign * s * s


@part
def _value(f: Array, angle: float) -> tuple[float, float]:
    """The form and its slope at an angle."""
    c, s = np.cos(angle), np.sin(angle)
    value = f[0] + f[1] * c + f[2] * s + f[3] * c * c + f[4] * c * s + f[5] * s * s
    slope = -f[1] * s + f[2] * c + 2.0 * (f[5] - f[3]) * c * s + f[4] * (c * c - s * s)
    return value, slope


@part
def conic_angles(f: Array, out: Array) -> int:
    """out (4,) <- the angles at which the form f (6,) of `square_onto` is 0; how many there are.

    With z = exp(i angle) it is a polynomial of fourth degree, the same read backwards and conjugated; its roots on the unit
    circle, eigenvalues of its companion matrix, are the real ones. Each is mended by Newton's method and leaves nothing over.
    """
    scale = np.max(np.abs(f))
    if scale == 0.0:
        return 0
    top = complex(0.25 * (f[3] - f[5]), -0.25 * f[4])
    side = complex(0.5 * f[1], -0.5 * f[2])
    middle = f[0] + 0.5 * (f[3] + f[5])
    pair = np.empty(2)
    if abs(top) < _DEGREE * scale:
        if not cone(f[1], f[2], -middle, pair):
            return 0
        out[0], out[1] = pair[0], pair[1]
        return 2
    companion = np.zeros((4, 4), np.complex128)
    companion[0, 0] = -side / top
    companion[0, 1] = -middle / top
    companion[0, 2] = -np.conj(side) / top
    companion[0, 3] = -np.conj(top) / top
    for i in range(3):
        companion[i + 1, i] = 1.0
    roots = np.linalg.eigvals(companion)
    count = 0
    for z in roots:
        if abs(abs(z) - 1.0) > _ROUND:
            continue
        angle = np.angle(z)
        for _again in range(_POLISHES):
            value, slope = _value(f, angle)
            if abs(slope) > 1e-9 * scale:  # flatter, the step is rounding
                angle -= min(0.01, max(-0.01, value / slope))
        value, slope = _value(f, angle)
        if abs(value) > _ZERO * scale:
            continue
        known = False
        for i in range(count):
            apart = angle - out[i]
            known = known or abs(apart - 2.0 * np.pi * np.round(apart / (2.0 * np.pi))) < _SAME
        if not known and count < 4:
            out[count] = angle
            count += 1
    return count


@part
def _extreme(f: Array, angle: float) -> float:
    """The angle next to a given one at which the form rises no more or falls no more, by Newton's method."""
    for _again in range(_POLISHES):
        c, s = np.cos(angle), np.sin(angle)
        slope = -f[1] * s + f[2] * c + 2.0 * (f[5] - f[3]) * c * s + f[4] * (c * c - s * s)
        bend = -f[1] * c - f[2] * s + 2.0 * (f[5] - f[3]) * (c * c - s * s) - 4.0 * f[4] * c * s
        if abs(slope) > _STEP * abs(bend):
            angle -= np.copysign(_STEP, slope * bend)
        elif bend != 0.0:
            angle -= slope / bend
    return float(angle)


@part
def lasting_angles(f: Array, axis: float, out: Array, there: Ints) -> int:
    """`conic_angles`, each at the place of out (4,) that it keeps while the form changes; there (4,): 1 at those that are taken.

    Round the circle the form falls and rises through its zeros in turn, and a zero changes from the one to the other only where
    two become one: the falling ones come first, the rising ones last. Two that do the same are told apart by the half of the
    circle that they lie in, on the left of `axis` or on the right, between the extremes that the form is to have near `axis`
    and opposite: the left one stands before the right one.
    """
    angles = np.empty(4)
    found = conic_angles(f, angles)
    for k in range(4):
        there[k] = 0
    start, end = _extreme(f, axis), _extreme(f, axis + np.pi)
    middle, edge = 0.5 * (start + end), np.cos(0.5 * (end - start))
    for k in range(found):
        angle = angles[k]
        _value_there, slope = _value(f, angle)
        first = 0 if slope < 0.0 else 2
        left = np.cos(angle - middle)
        place = first if left > edge else first + 1
        if there[place] and not there[2 * first + 1 - place]:
            # both on one side: the one more to the left stands first
            other = out[place]
            before, after = (angle, other) if left > np.cos(other - middle) else (other, angle)
            out[first], out[first + 1] = before, after
            there[first] = there[first + 1] = 1
            continue
        if there[place]:  # three of one kind are rounding about a double one
            place = 0
            while there[place]:
                place += 1
        out[place], there[place] = angle, 1
    return int(found)
