"""The published compensation, as it is printed: Newton's method on six pose numbers with a numeric Jacobian."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from camrob.errors import SingularError
from camrob.se3 import mm_deg_from_frame
from camrob.units import deg_to_rad, rad_to_deg

__all__ = ["DELTA", "EPSILON", "compensate_as_published"]

Array = NDArray[np.float64]

DELTA, EPSILON = 1e-8, 1e-15  # the paper's own
_ITERATIONS = 50  # the loop takes two or three where it converges


def compensate_as_published(
    forward: Callable[[Array], Array], desired: Array, ideal: Array, *, delta: float = DELTA, epsilon: float = EPSILON
) -> tuple[Array, int]:
    """Compensated axis angles (6,), rad, and the number of iterations, for one desired pose (4, 4).

    Eq. 5 to 9 of the paper on the KR500: F = [dX, dY, dZ, dA, dB, dC] in mm and degrees (eq. 6), J from differences
    over delta of each machine coordinate, in degrees (eq. 7), theta <- theta - J^-1 F (eq. 8), until |F|^2 < epsilon
    (eq. 9). forward: the calibrated robot's pose (4, 4) of angles (6,). Angles A, B, C break down at B = +-90
    degrees, as printed. Raises SingularError where it does not end.
    """
    wanted = mm_deg_from_frame(desired)
    theta = rad_to_deg(np.array(ideal, float))
    for iteration in range(_ITERATIONS):
        F = _deviation(mm_deg_from_frame(forward(deg_to_rad(theta))), wanted)
        if float(F @ F) < epsilon:
            return deg_to_rad(theta), iteration
        J = np.empty((6, 6))
        for i in range(6):
            moved = theta.copy()
            moved[i] += delta
            J[:, i] = (_deviation(mm_deg_from_frame(forward(deg_to_rad(moved))), wanted) - F) / delta
        try:
            theta = theta - np.linalg.solve(J, F)
        except np.linalg.LinAlgError:
            raise SingularError("the numeric Jacobian is singular") from None
    raise SingularError("the published iteration does not end", value=float(F @ F), limit=epsilon)


def _deviation(numbers: Array, wanted: Array) -> Array:
    """Eq. 6; the angles' differences without whole turns."""
    F = numbers - wanted
    F[3:] -= 360.0 * np.round(F[3:] / 360.0)
    return np.asarray(F)
