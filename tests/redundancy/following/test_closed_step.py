"""The follower's step by the arm's closed inverse: held to NumPy, and to the QR factorisation that is used where it doesn't."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from follower_twins import CELL, CHAIN, five_axis_path, follow, settings_of, state_at

from camrob.cell.read_cell import read_cell
from camrob.compiled import kernel
from camrob.kinematics.kernels import chain_arrays, forward, inverse_kf_many, jacobian
from camrob.kinematics.spherical_inverse import homogeneous_inverse, sine_cosine, wrist_distance
from camrob.redundancy.following import linear_algebra as la
from camrob.redundancy.following import newton_step
from camrob.redundancy.following.chain_work import curvature, follower_work
from camrob.redundancy.following.follower import FOLLOWED
from camrob.se3 import pose, rotation_exp

SETTINGS = settings_of(CELL)
BY_QR = CHAIN._replace(spherical=False)
N = len(CELL)


def test_sine_and_cosine_within_a_unit_in_the_last_place() -> None:
    x = np.concatenate(
        [np.linspace(-8.0, 8.0, 4001), 1e5 * np.linspace(-1.0, 1.0, 2001), np.arange(-40, 41) * np.pi / 4]
    )
    expected = np.array([sine_cosine(v) for v in x])
    assert np.abs(expected[:, 0] - np.sin(x)).max() <= 1.2e-16
    assert np.abs(expected[:, 1] - np.cos(x)).max() <= 1.2e-16
    assert np.isnan(kernel(sine_cosine, cache=False)(np.nan)[0])  # in Python there is no integer for it


def homogeneous(q: np.ndarray):
    Z, P, R, p, plate = np.empty((N, 3)), np.empty((N, 3)), np.empty((3, 3)), np.empty(3), np.empty(3)
    forward(CHAIN, q, Z, P, R, p, plate)
    arm = CELL.arm_slice
    H = np.vstack([np.cross(Z[arm], plate - P[arm]).T / CHAIN.length, Z[arm].T])
    return Z, P, plate, H


def test_the_arms_inverse_and_its_condition_against_numpy() -> None:
    rng = np.random.default_rng(0)
    assert CHAIN.spherical
    for q in CELL.q_home + rng.normal(0.0, 0.6, (50, N)):
        Z, P, plate, H = homogeneous(q)
        wanted = np.empty((6, 6))
        square = homogeneous_inverse(Z, P, plate, CHAIN.arm_start, CHAIN.wrist, CHAIN.length, wanted)
        expected = np.linalg.inv(H)
        size = np.linalg.norm(expected)
        np.testing.assert_allclose(wanted, expected, atol=1e-13 * size**2)
        assert square == pytest.approx(size**2, rel=1e-11)
        k_f = np.linalg.norm(H) * size / 6.0
        assert inverse_kf_many(CHAIN, q[None])[0] == pytest.approx(1.0 / k_f, rel=1e-11)
        assert inverse_kf_many(BY_QR, q[None])[0] == pytest.approx(1.0 / k_f, rel=1e-8)


def test_a_straight_wrist_has_none() -> None:
    straight = CELL.to_q(np.array([0.0, -60.0, 60.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    assert inverse_kf_many(CHAIN, straight[None])[0] < 1e-9


def test_where_the_wrists_axes_meet() -> None:
    turn = rotation_exp(np.array([np.pi / 2, 0.0, 0.0]))
    fourth_T_fifth, fifth_T_sixth = pose(turn, np.array([0.0, 0.0, 0.3])), pose(turn.T, np.array([0.0, 0.0, 0.2]))
    assert wrist_distance(fourth_T_fifth, pose(turn.T, np.zeros(3))) == pytest.approx(0.0, abs=1e-15)
    assert np.isnan(wrist_distance(fourth_T_fifth, fifth_T_sixth))  # along the fifth axis, elsewhere
    assert np.isnan(wrist_distance(fourth_T_fifth, pose(turn.T, np.array([0.01, 0.0, 0.0]))))  # beside it
    assert np.isnan(wrist_distance(fourth_T_fifth, pose(np.eye(3), np.zeros(3))))  # parallel to it


@pytest.mark.parametrize("name", ["ta1400_weld", "kr500_afp"])
def test_other_arms_know_whether_they_are_spherical(name: str) -> None:
    cell = read_cell(Path(__file__).resolve().parents[3] / "cells" / name)
    chain = chain_arrays(cell)
    q = cell.q_home + np.random.default_rng(1).normal(0.0, 0.3, (40, len(cell)))
    np.testing.assert_allclose(
        inverse_kf_many(chain, q), inverse_kf_many(chain._replace(spherical=False), q), rtol=1e-8, atol=1e-9
    )


def test_a_stable_step_does_not_depend_on_the_basis() -> None:
    rng = np.random.default_rng(2)
    shifted = 0
    for _ in range(300):
        r = int(rng.integers(1, 4))
        M, b = rng.normal(size=(r, r)) + rng.uniform(-1.0, 3.0) * np.eye(r), rng.normal(size=r)
        x = b.copy()
        shift = la.solve_positive(M, r, 0.0, np.empty((r, r)), x)
        np.testing.assert_allclose(x, np.linalg.solve(M + shift * np.eye(r), b), rtol=1e-8, atol=1e-9)
        real = np.linalg.eigvals(M).real.min()
        assert real + shift > 0.0
        assert shift == 0.0 or real < 1.1e-3 * np.linalg.norm(M)  # no shift without need
        shifted += shift > 0.0
        Q = np.linalg.qr(rng.normal(size=(r, r)))[0]
        turned = Q.T @ b
        again = la.solve_positive(np.ascontiguousarray(Q.T @ M @ Q), r, 0.0, np.empty((r, r)), turned)
        assert again == pytest.approx(shift, rel=1e-9)
        np.testing.assert_allclose(Q @ turned, x, rtol=1e-7, atol=1e-8)
    assert 30 < shifted < 270


def stepped(chain, q, settings, side, acting: bool):
    """Scratch after a Newton step at q towards a pose nearby, and the number of free joints."""
    w = follower_work(N)
    forward(chain, q, w.Z, w.P, w.R, w.p, w.plate)
    w.error[:] = [1e-3, -2e-3, 5e-4, 3e-3, 1e-3, -2e-3]
    jacobian(chain, w.Z, w.P, w.p, w.J)
    m = newton_step.task_step(chain, N, side, settings.locked, w)
    state = state_at(q, CELL.q_home if acting else None)
    newton_step.gradient_and_multipliers(settings, q, CELL.q_reference, state, chain, m, w.multipliers, w)
    shift = newton_step.self_motion(chain, settings, m, acting, 0.0, w.multipliers, True, w)
    return w, m, shift


@pytest.mark.parametrize("held", [(), ("E1",), ("E2", "roll"), ("E1", "E2", "roll")])
@pytest.mark.parametrize("acting", [False, True])
def test_a_step_is_the_one_by_qr(held: tuple[str, ...], acting: bool) -> None:
    rng = np.random.default_rng(3)
    for q in CELL.q_home + rng.normal(0.0, 0.3, (15, N)):
        side = np.zeros(N, np.int64)
        side[[CELL.index(name) for name in held]] = 1
        w, m, shift = stepped(CHAIN, q, SETTINGS, side, acting)
        v, other, shift_by_qr = stepped(BY_QR, q, SETTINGS, side, acting)
        assert w.split[0] and not v.split[0] and m == other == N - len(held)
        free = w.free[:m]
        np.testing.assert_array_equal(free, v.free[:m])
        np.testing.assert_allclose(w.x[:m], np.linalg.pinv(w.J[:, free]) @ w.error, atol=1e-12)
        np.testing.assert_allclose(w.multipliers, v.multipliers, rtol=1e-7, atol=1e-9)
        rows = np.linalg.lstsq((w.J[:, free] / np.repeat([CHAIN.length, 1.0], 3)[:, None]).T, w.g[free], rcond=None)[0]
        np.testing.assert_allclose(w.multipliers, rows, rtol=1e-7, atol=1e-9)
        if m > 6:
            assert shift == pytest.approx(shift_by_qr, rel=1e-7)
            np.testing.assert_allclose(w.s[:m], v.s[:m], rtol=1e-6, atol=1e-9 * max(1.0, np.abs(v.s[:m]).max()))
            np.testing.assert_allclose(w.J[:, free] @ w.s[:m], 0.0, atol=1e-11 * max(1.0, np.abs(w.s[:m]).max()))


def test_the_step_solves_newtons_equations() -> None:
    """Without a shift: N^T (g + C (x + s)) = 0, with C the whole matrix of derivatives, in plain NumPy."""
    seen = 0
    for q in CELL.q_home + np.random.default_rng(4).normal(0.0, 0.2, (20, N)):
        w, _m, shift = stepped(CHAIN, q, SETTINGS, np.zeros(N, np.int64), False)
        if shift > 0.0:
            continue
        seen += 1
        curvature(CHAIN, N, 1.0 / CHAIN.length, w.multipliers, w)
        C = np.diag(w.weight) - w.C
        for axis, slope in zip(SETTINGS.joint_weights.axis, w.slope, strict=True):
            C[:, axis] += slope
        null = np.linalg.svd(w.J)[2][6:]
        left = null @ (w.g + C @ (w.x + w.s))
        assert np.abs(left).max() < 1e-9 * max(1.0, np.abs(w.g).max())
    assert seen > 5


@pytest.mark.parametrize("threshold", [0.0, 1.0])
@pytest.mark.parametrize("locked", [(), ("E2",), ("E1", "E2")])
def test_a_path_is_the_one_by_qr(threshold: float, locked: tuple[str, ...]) -> None:
    stands = np.zeros(N, np.bool_)
    stands[[CELL.index(name) for name in locked]] = True
    settings = SETTINGS._replace(threshold=threshold, locked=stands)
    path = five_axis_path(CELL.q_home, 120, np.array([0.002, 0.001, -0.0006]), np.array([0.006, 0.002, 0.0]))
    reference = np.where(stands, CELL.q_home, CELL.q_reference)
    code, _, q, inv_kf = follow(settings, path, state_at(CELL.q_home), reference=reference)
    other, _, q_by_qr, inv_kf_by_qr = follow(settings, path, state_at(CELL.q_home), reference=reference, chain=BY_QR)
    assert code == other == FOLLOWED
    np.testing.assert_allclose(q, q_by_qr, atol=1e-8)
    np.testing.assert_allclose(inv_kf, inv_kf_by_qr, atol=1e-8)
