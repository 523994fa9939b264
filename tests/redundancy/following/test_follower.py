"""The follower: held to the published loop, to derivatives by differences, and to what must never happen."""

from __future__ import annotations

import literal_loop
import numpy as np
import pytest
from follower_twins import CELL, CHAIN, bilinear, five_axis_path, follow, settings_of, state_at
from literal_loop import TwinState, engine_weights, follow_as_published

from camrob.errors import UnreachableError
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.kernels import forward, inverse_kf_many, jacobian
from camrob.redundancy.following import chain_work, newton_step
from camrob.redundancy.following import linear_algebra as la
from camrob.redundancy.following.follower import FAILED_NOT_REACHED, FOLLOWED
from camrob.redundancy.fuzzy.surfaces import constant_surface
from camrob.se3 import pose, rotation_exp, rotation_log

SETTINGS = settings_of(CELL)
STEP, TURN = np.array([0.002, 0.001, -0.0006]), np.array([0.01, 0.003, 0.0])
EVEN = np.full(len(CELL), CELL.resolve.joint_engine.default_weight)
LOW = CELL.to_q(np.array([-20.0, -60.0, 62.0, 25.0, 24.0, -12.0, 150.0, 20.0]))
"""A posture near the wrist's singularity, 1/k_F below the threshold."""


def pose_errors(q: np.ndarray, targets: np.ndarray) -> tuple[float, float]:
    reached = base_T_tool(CELL, q)
    position = np.linalg.norm(reached[:, :3, 3] - targets[:, :3, 3], axis=1).max()
    turned = rotation_log(np.swapaxes(reached[:, :3, :3], 1, 2) @ targets[:, :3, :3])
    return float(position), float(np.linalg.norm(turned, axis=1).max())


def surfaces_as_weights(settings):
    return (lambda q: bilinear(settings.joint_weights, q)), (lambda q: bilinear(settings.condition_weights, q))


# ---- the published loop


@pytest.mark.slow
def test_the_figures_that_the_issue_warns_of() -> None:
    """Null-space term inside the loop: 20 iterations a point to 1e-4, over 200 to 1e-6, and not the same postures."""
    path = five_axis_path(CELL.q_home, 6, STEP, TURN)
    weights = [engine_weights(CELL, e) for e in (CELL.resolve.joint_engine, CELL.resolve.condition_engine)]
    loose, tight = (
        follow_as_published(
            CELL,
            path,
            TwinState(CELL.q_home),
            joint_weights=weights[0],
            condition_weights=weights[1],
            q_reference=CELL.q_reference,
            epsilon=epsilon,
        )
        for epsilon in (1e-4, 1e-6)
    )
    assert np.median(loose.iterations) == pytest.approx(20, abs=4)
    assert tight.iterations.min() > 200
    assert np.abs(loose.q - tight.q)[-1].max() > 1e-3  # rad and m: the answer depends on where the loop is stopped


def test_a_weight_of_one_percent_shrinks_the_step_by_one_percent() -> None:
    path = five_axis_path(CELL.q_home, 1, 10 * STEP, 10 * TURN)
    found = follow_as_published(
        CELL,
        path,
        TwinState(CELL.q_home),
        joint_weights=lambda q: EVEN,
        condition_weights=lambda q: EVEN,
        q_reference=CELL.q_reference,
        epsilon=1e-6,
    )
    steps = found.steps[0]
    assert len(steps) > 200
    np.testing.assert_allclose(steps[-100:] / steps[-101:-1], 0.99, atol=2e-3)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("even", [True, False])
def test_the_tracker_ends_where_the_published_loop_does(even: bool) -> None:
    settings = SETTINGS
    if even:
        settings = settings._replace(joint_weights=constant_surface(EVEN), condition_weights=constant_surface(EVEN))
    path = five_axis_path(CELL.q_home, 4, 4 * STEP, 3 * TURN)
    joint, condition = surfaces_as_weights(settings)
    expected = follow_as_published(
        CELL,
        path,
        TwinState(CELL.q_home),
        joint_weights=joint,
        condition_weights=condition,
        q_reference=CELL.q_reference,
        epsilon=1e-9,
    )
    code, _, q, inv_kf = follow(settings, path, state_at(CELL.q_home))
    assert code == FOLLOWED
    np.testing.assert_allclose(q, expected.q, atol=5e-7)
    np.testing.assert_allclose(inv_kf, expected.inv_kf, atol=1e-6)
    assert np.abs(q[-1] - CELL.q_home).max() > 0.05  # there was a way to go


def test_with_the_condition_term_too() -> None:
    """Below the threshold h_cond acts, drawn to the posture recorded when it was crossed."""
    recorded = LOW + 0.02
    path = five_axis_path(LOW, 3, STEP, 0.5 * TURN)
    joint, condition = surfaces_as_weights(SETTINGS)
    expected = follow_as_published(
        CELL,
        path,
        TwinState(LOW, recorded),
        joint_weights=joint,
        condition_weights=condition,
        q_reference=CELL.q_reference,
        epsilon=1e-10,
    )
    state = state_at(LOW, recorded)
    code, _, q, inv_kf = follow(SETTINGS, path, state)
    assert code == FOLLOWED and state.flags[0] == 1
    assert inv_kf.max() < CELL.resolve.threshold
    np.testing.assert_allclose(q, expected.q, atol=1e-6)
    _, _, without, _ = follow(SETTINGS._replace(threshold=0.0), path, state_at(LOW))
    assert np.abs(without - q).max() > 0.01


def test_the_threshold_records_and_forgets_the_posture() -> None:
    value = float(inverse_kf_many(CHAIN, LOW[None])[0])
    path = five_axis_path(LOW, 1, STEP, TURN)
    state = state_at(LOW)
    follow(SETTINGS._replace(threshold=value + 1e-6), path, state)
    assert state.flags[0] == 1
    np.testing.assert_array_equal(state.q_threshold, LOW)
    state = state_at(LOW, CELL.q_home)
    follow(SETTINGS._replace(threshold=value + 1e-6), path, state)
    np.testing.assert_array_equal(state.q_threshold, CELL.q_home)  # recorded at the crossing, not later
    follow(SETTINGS._replace(threshold=value - 0.3), path, state)
    assert state.flags[0] == 0


@pytest.mark.slow
def test_the_published_loop_tells_when_it_does_not_settle() -> None:
    path = base_T_tool(CELL, CELL.q_home)[None].copy()
    path[0, 2, 3] += 5.0
    with pytest.raises(UnreachableError, match="point 0"):
        follow_as_published(
            CELL,
            path,
            TwinState(CELL.q_home),
            joint_weights=lambda q: EVEN,
            condition_weights=lambda q: EVEN,
            q_reference=CELL.q_reference,
            epsilon=1e-12,
        )


# ---- laws of the follower itself


def test_the_pose_is_met_and_nothing_is_left_in_the_null_space() -> None:
    path = five_axis_path(CELL.q_home, 40, 2 * STEP, TURN)
    code, reached, q, inv_kf = follow(SETTINGS, path, state_at(CELL.q_home))
    assert (code, reached) == (FOLLOWED, 40)
    assert max(pose_errors(q, path)) < 1e-10
    np.testing.assert_allclose(inv_kf, inverse_kf_many(CHAIN, q), atol=1e-14)
    for posture in q:
        J = literal_loop._jacobian(CELL, posture, base_T_tool(CELL, posture)[:3, 3])
        _, _, rows = np.linalg.svd(J)
        h = -bilinear(SETTINGS.joint_weights, posture) * (posture - CELL.q_reference)
        assert np.abs(rows[6:] @ h).max() < 1e-8


def test_the_answer_does_not_depend_on_the_way_there() -> None:
    """One stride or ten to the same pose: the constrained optimum is the same."""
    path = five_axis_path(CELL.q_home, 10, STEP, TURN)
    _, _, fine, _ = follow(SETTINGS, path, state_at(CELL.q_home))
    _, _, coarse, _ = follow(SETTINGS, path[-1:], state_at(CELL.q_home))
    np.testing.assert_allclose(coarse[0], fine[-1], atol=1e-8)


@pytest.mark.parametrize(("name", "share"), [("A5", 0.4), ("E1", 0.3), ("A4", 0.5), ("A2", 0.4)])
def test_a_limit_is_an_active_set(name: str, share: float) -> None:
    """A joint's range narrowed to less than the path would take: it stands at the limit, and never beyond it."""
    i = CELL.index(name)
    path = five_axis_path(CELL.q_home, 60, 3 * STEP, 1.2 * TURN)
    _, _, free, _ = follow(SETTINGS, path, state_at(CELL.q_home))
    moved = free[:, i] - CELL.q_home[i]
    far = moved[np.argmax(np.abs(moved))]
    assert abs(far) > 0.01
    lower, upper = CELL.q_lower.copy(), CELL.q_upper.copy()
    (upper if far > 0 else lower)[i] = limit = CELL.q_home[i] + share * far
    state = state_at(CELL.q_home)
    code, _, q, _ = follow(SETTINGS._replace(lower=lower, upper=upper), path, state)
    assert code == FOLLOWED
    assert max(pose_errors(q, path)) < 1e-10
    assert np.all(q[:, i] <= upper[i]) and np.all(q[:, i] >= lower[i])
    assert np.sum(q[:, i] == limit) > 5  # exactly at it, not near it
    assert state.side[i] == np.sign(far)


def test_a_joint_comes_back_from_its_limit() -> None:
    """There and back again: the joint leaves its limit where the optimum draws it inwards, and ends where it began."""
    i = CELL.index("E1")
    there = five_axis_path(CELL.q_home, 60, 3 * STEP, 1.2 * TURN)
    path = np.concatenate([there, there[::-1]])
    _, _, free, _ = follow(SETTINGS, path, state_at(CELL.q_home))
    far = free[:, i][np.argmax(np.abs(free[:, i]))]
    lower, upper = CELL.q_lower.copy(), CELL.q_upper.copy()
    (upper if far > 0 else lower)[i] = 0.3 * far
    state = state_at(CELL.q_home)
    code, _, q, _ = follow(SETTINGS._replace(lower=lower, upper=upper), path, state)
    assert code == FOLLOWED and state.side[i] == 0
    assert np.sum(q[:, i] == 0.3 * far) > 5
    np.testing.assert_allclose(q[-1], free[-1], atol=1e-7)


def test_out_of_reach_ends_with_limits_held() -> None:
    path = five_axis_path(CELL.q_home, 200, np.array([0.0, 0.0, 0.02]), np.zeros(3))
    state = state_at(CELL.q_home)
    code, reached, q, _ = follow(SETTINGS, path, state)
    assert code != FOLLOWED and 10 < reached < 200
    assert np.all(np.isnan(q[reached:])) and np.all(np.isfinite(q[:reached]))
    for postures in (q[:reached], state.q[None]):
        assert np.all(postures >= CELL.q_lower) and np.all(postures <= CELL.q_upper)
    assert np.all(np.isfinite(state.q))


def test_a_start_at_the_wrists_singularity_is_bounded() -> None:
    """A5 = 0 loses a direction of the arm; the redundant chain goes on, in steps that stay finite and bounded."""
    straight = CELL.to_q(np.array([0.0, -60.0, 60.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    for seed in range(6):
        rng = np.random.default_rng(seed)
        path = five_axis_path(straight, 25, rng.normal(0, 0.002, 3), rng.normal(0, 0.02, 3))
        state = state_at(straight)
        code, reached, q, _ = follow(SETTINGS, path, state)
        assert np.all(np.isfinite(state.q))
        assert np.all(state.q >= CELL.q_lower) and np.all(state.q <= CELL.q_upper)
        if code == FOLLOWED:
            assert max(pose_errors(q, path)) < 1e-10
        else:
            assert np.all(np.isfinite(q[:reached]))


def test_every_random_stride_is_met_or_refused() -> None:
    """No NaN, no posture beyond a limit, no pose that is claimed and not met, whatever is asked for."""
    rng = np.random.default_rng(5)
    outcomes = set()
    for _ in range(150):
        start = CELL.q_home + rng.normal(0, 0.4, len(CELL))
        start = np.clip(start, CELL.q_lower + 0.01, CELL.q_upper - 0.01)
        target = base_T_tool(CELL, start)[None].copy()
        target[0, :3, 3] += rng.normal(0, 0.5, 3)
        target[0, :3, :3] = rotation_exp(rng.normal(0, 1.2, 3)) @ target[0, :3, :3]
        state = state_at(start)
        code, _, q, _ = follow(SETTINGS, target, state)
        outcomes.add(code)
        assert np.all(np.isfinite(state.q))
        assert np.all(state.q >= CELL.q_lower) and np.all(state.q <= CELL.q_upper)
        if code == FOLLOWED:
            assert max(pose_errors(q, target)) < 1e-10
    assert {FOLLOWED, FAILED_NOT_REACHED} <= outcomes


def test_the_table_is_endless() -> None:
    """Two and a half turns round the table: it turns on without a jump, with the reference at the nearest turn."""
    count = 901
    angle = np.linspace(np.pi, 6.0 * np.pi, count)
    outwards = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    along = np.stack([-np.sin(angle), np.cos(angle), np.zeros(count)], axis=1)
    tool = np.sin(1.0) * outwards + np.cos(1.0) * np.array([0.0, 0.0, 1.0])  # leaning out by a radian
    path = pose(np.stack([along, np.cross(tool, along), tool], axis=2), 0.25 * outwards + np.array([0.0, 0.0, 0.4]))
    state = state_at(CELL.q_home)
    follow(SETTINGS, path[:1], state)
    code, _, q, _ = follow(SETTINGS, path, state, limit=0.02)
    assert code == FOLLOWED
    assert max(pose_errors(q, path)) < 1e-10
    assert np.abs(np.diff(q, axis=0)).max() < 0.05
    turned = q[-1, CELL.index("E2")] - q[0, CELL.index("E2")]
    assert abs(turned) > 4.0 * np.pi  # it has gone round with the tool, and never back by a turn
    a_turn = 360
    far = q[a_turn + 300] - q[300]
    assert angle[a_turn + 300] - angle[300] == pytest.approx(2.0 * np.pi)
    assert abs(abs(far[CELL.index("E2")]) - 2.0 * np.pi) < 0.05
    np.testing.assert_allclose(far[CELL.arm_slice], 0.0, atol=0.05)  # a turn on, the arm stands as before


def test_a_turn_more_on_endless_axes_changes_nothing() -> None:
    turned = CELL.q_home.copy()
    turned[CELL.index("E2")] += 4.0 * np.pi
    turned[CELL.index("roll")] -= 2.0 * np.pi
    path = five_axis_path(CELL.q_home, 10, STEP, TURN)
    _, _, plain, _ = follow(SETTINGS, path, state_at(CELL.q_home))
    _, _, other, _ = follow(SETTINGS, path, state_at(turned))
    np.testing.assert_allclose(other - plain, np.tile(turned - CELL.q_home, (10, 1)), atol=1e-8)


def test_self_motion_keeps_to_its_bounds() -> None:
    """With a bound on self-motion the pose is met all the same, and the posture lags behind."""
    path = five_axis_path(CELL.q_home, 10, STEP, TURN)
    _, _, free, _ = follow(SETTINGS, path, state_at(CELL.q_home))
    code, _, q, _ = follow(SETTINGS, path, state_at(CELL.q_home), limit=1e-9)
    assert code == FOLLOWED and max(pose_errors(q, path)) < 1e-10
    assert np.abs(q - free).max() > 1e-3


# ---- plain twins of the compiled pieces


def factored(m: int, seed: int):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(m, 6))
    F, tau = A.copy(), np.empty(6)
    least = la.qr_six(F, m, tau)
    return A, F, tau, least


@pytest.mark.parametrize("m", [6, 7, 9])
def test_qr_against_numpy(m: int) -> None:
    A, F, tau, least = factored(m, m)
    Q = np.empty((m, m))
    for k in range(m):
        x = np.eye(m)[k].copy()
        la.apply_q(F, m, tau, x)
        Q[:, k] = x
    R = np.triu(F[:6])
    np.testing.assert_allclose(Q.T @ Q, np.eye(m), atol=1e-13)
    np.testing.assert_allclose(Q[:, :6] @ R, A, atol=1e-13)
    expected = np.abs(np.diag(np.linalg.qr(A)[1]))
    np.testing.assert_allclose(np.abs(np.diag(R)), expected, rtol=1e-12)
    assert least == pytest.approx(expected.min() / expected.max(), rel=1e-12)
    x = np.arange(1.0, m + 1.0)
    y = x.copy()
    la.apply_q_transposed(F, m, tau, y)
    np.testing.assert_allclose(y, Q.T @ x, atol=1e-12)
    # the pseudoinverse step of J = A^T
    e = np.arange(6.0) - 2.0
    step = np.zeros(m)
    step[:6] = e
    la.solve_r_transposed(F, step)
    la.apply_q(F, m, tau, step)
    np.testing.assert_allclose(step, np.linalg.pinv(A.T) @ e, atol=1e-11)
    b = e.copy()
    la.solve_r(F, b)
    np.testing.assert_allclose(R @ b, e, atol=1e-11)


def test_qr_tells_a_lost_rank() -> None:
    A = np.random.default_rng(1).normal(size=(9, 6))
    A[:, 3] = 2.0 * A[:, 1] - A[:, 0]
    assert la.qr_six(A.copy(), 9, np.empty(6)) < 1e-14
    assert la.qr_six(np.zeros((9, 6)), 9, np.empty(6)) == 0.0


def test_positive_solver_against_numpy() -> None:
    rng = np.random.default_rng(2)
    for r in (1, 2, 3):
        M = rng.normal(size=(r, r)) + 4.0 * np.eye(r)
        x = rng.normal(size=r)
        b = x.copy()
        assert la.solve_positive(M, r, 0.0, np.empty((r, r)), x) == 0.0
        np.testing.assert_allclose(x, np.linalg.solve(M, b), atol=1e-12)
    M = np.diag([1.0, -2.0, 0.5])  # a saddle: shifted until it is none, so that the step goes down
    x = b = np.ones(3)
    x = b.copy()
    shift = la.solve_positive(M, 3, 0.0, np.empty((3, 3)), x)
    assert shift > 2.0
    np.testing.assert_allclose(x, b / (np.diag(M) + shift), atol=1e-12)


def filled(q: np.ndarray):
    w = chain_work.follower_work(len(q))
    forward(CHAIN, q, w.Z, w.P, w.R, w.p, w.plate)
    jacobian(CHAIN, w.Z, w.P, w.p, w.J)
    return w


def test_curvature_against_differences() -> None:
    """Second derivatives of position and rotation vector, from differences of the pose itself."""
    rng = np.random.default_rng(3)
    q = CELL.q_home + rng.normal(0, 0.3, len(CELL))
    n, scale, step = len(q), 1.0 / CHAIN.length, 1e-4
    w = filled(q)
    w.free[:] = np.arange(n)
    first = base_T_tool(CELL, q)

    def task(dq: np.ndarray) -> np.ndarray:
        T = base_T_tool(CELL, q + dq)
        return np.concatenate([(T[:3, 3] - first[:3, 3]) * scale, rotation_log(T[:3, :3] @ first[:3, :3].T)])

    unit = np.eye(n) * step
    for multipliers in np.eye(6):
        chain_work.curvature(CHAIN, n, scale, multipliers, w)
        expected = np.empty((n, n))
        for a in range(n):
            for b in range(n):
                second = (
                    task(unit[a] + unit[b])
                    - task(unit[a] - unit[b])
                    - task(unit[b] - unit[a])
                    + task(-unit[a] - unit[b])
                )
                expected[a, b] = multipliers @ second / (4.0 * step * step)
        np.testing.assert_allclose(w.C[:n, :n], expected, atol=2e-6)


def test_pose_error_is_the_logarithm() -> None:
    rng = np.random.default_rng(4)
    error = np.empty(6)
    for angle in (0.0, 1e-12, 1e-5, 0.3, 2.0, 3.0, np.pi - 1e-6):
        axis = rng.normal(size=3)
        w = angle * axis / np.linalg.norm(axis)
        R = np.ascontiguousarray(rotation_exp(rng.normal(size=3)))
        p, p_target = rng.normal(size=3), rng.normal(size=3)
        chain_work.pose_error(R, p, np.ascontiguousarray(rotation_exp(w) @ R), p_target, error)
        np.testing.assert_allclose(error[:3], p_target - p, atol=1e-15)
        np.testing.assert_allclose(error[3:], w, atol=1e-7 if angle > 3.0 else 1e-12)


def test_pose_error_of_half_a_turn_is_a_way_there() -> None:
    for axis in np.eye(3):
        error = np.empty(6)
        chain_work.pose_error(np.eye(3), np.zeros(3), rotation_exp(np.pi * axis), np.zeros(3), error)
        assert np.linalg.norm(error[3:]) == pytest.approx(np.pi, abs=1e-5)
        np.testing.assert_allclose(rotation_exp(error[3:]), rotation_exp(np.pi * axis), atol=1e-5)


def test_weights_enter_the_criterion_with_their_slopes() -> None:
    """g = -h, and its derivative by the two axes that index the surfaces, by differences."""
    rng = np.random.default_rng(6)
    recorded = LOW + rng.normal(0, 0.05, len(CELL))
    state = state_at(LOW, recorded)

    def gradient(q: np.ndarray) -> np.ndarray:
        w = filled(q)
        newton_step.criterion(SETTINGS, q, CELL.q_reference, state, CHAIN, w)
        return w.g.copy()

    inv_kf = float(inverse_kf_many(CHAIN, LOW[None])[0])
    expected = bilinear(SETTINGS.joint_weights, LOW) * (LOW - CELL.q_reference)
    expected += bilinear(SETTINGS.condition_weights, LOW) * (LOW - recorded) / inv_kf
    np.testing.assert_allclose(gradient(LOW), expected, atol=1e-12)


def test_half_turns_are_met() -> None:
    """A pose half a turn away about the tool's own axis costs the virtual joint half a turn, and nothing else."""
    target = base_T_tool(CELL, CELL.q_home)[None].copy()
    target[0, :3, :3] = target[0, :3, :3] @ rotation_exp(np.array([0.0, 0.0, np.pi]))
    code, _, q, _ = follow(SETTINGS, target, state_at(CELL.q_home))
    assert code == FOLLOWED
    assert max(pose_errors(q, target)) < 1e-10
