"""k_F and its slope by the joints, held to the plain kernel and to differences."""

from __future__ import annotations

import numpy as np
from follower_twins import CELL, CHAIN

from camrob.kinematics.conditioning_slope import kf_and_slope
from camrob.kinematics.kernels import forward, inverse_kf_many


def looked_at(q: np.ndarray) -> tuple[float, np.ndarray]:
    n = len(q)
    Z, P, R, p, plate = np.empty((n, 3)), np.empty((n, 3)), np.empty((3, 3)), np.empty(3), np.empty(3)
    forward(CHAIN, q, Z, P, R, p, plate)
    slope = np.full(n, np.nan)
    scratch = [np.full((n, n), np.nan) for _ in range(3)]
    return kf_and_slope(CHAIN, Z, P, plate, slope, *scratch), slope


def test_against_differences() -> None:
    rng = np.random.default_rng(0)
    step = 1e-6
    for _ in range(20):
        q = CELL.q_home + rng.normal(0, 0.3, len(CELL))
        kf, slope = looked_at(q)
        assert abs(kf * inverse_kf_many(CHAIN, q[None])[0] - 1.0) < 1e-13
        both = [1.0 / inverse_kf_many(CHAIN, q + sign * step * np.eye(len(q))) for sign in (1.0, -1.0)]
        expected = (both[0] - both[1]) / (2.0 * step)
        np.testing.assert_allclose(slope, expected, atol=2e-9 * np.abs(expected).max() * kf**2 + 1e-8)
        assert np.abs(slope[CELL.arm_slice]).max() > 0.05  # there is something to compare
        assert np.all(np.delete(slope, np.arange(len(q))[CELL.arm_slice]) == 0.0)  # and the arm alone decides


def test_a_singular_arm_has_none() -> None:
    kf, slope = looked_at(CELL.to_q(np.array([0.0, -60.0, 60.0, 0.0, 0.0, 0.0, 0.0, 0.0])))
    assert kf > 1e6 or np.isinf(kf)
    assert np.all(np.isfinite(slope))
