"""h_cond in its two forms: drawn back to the recorded posture as printed, or down the gradient of k_F; and off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from follower_twins import CELL, CHAIN, five_axis_path, follow, settings_of, state_at

from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.kernels import forward, inverse_kf_many, jacobian
from camrob.redundancy.following import chain_work, newton_step
from camrob.redundancy.following.follower import FOLLOWED
from camrob.redundancy.published.virtual_joint import resolve_vjm
from camrob.redundancy.published.weighting import engine_weighting
from camrob.redundancy.transfers import build_path
from camrob.toolpath.region import Move, Region
from camrob.toolpath.toolpath import Toolpath

SETTINGS = settings_of(CELL)._replace(gradient=True)
BY_QR = CHAIN._replace(spherical=False)
LOW = CELL.to_q(np.array([-20.0, -60.0, 62.0, 25.0, 24.0, -12.0, 150.0, 20.0]))
"""A posture near the wrist's singularity, 1/k_F below the threshold."""
STEP, TURN = np.array([0.002, 0.001, -0.0006]), np.array([0.01, 0.003, 0.0])


def kf(q: np.ndarray) -> float:
    return 1.0 / float(inverse_kf_many(CHAIN, q[None])[0])


def looked_at(q: np.ndarray, settings):
    w = chain_work.follower_work(len(q))
    forward(CHAIN, q, w.Z, w.P, w.R, w.p, w.plate)
    jacobian(CHAIN, w.Z, w.P, w.p, w.J)
    newton_step.criterion(settings, q, CELL.q_reference, state_at(q, q), CHAIN, w)
    return w


def test_the_term_is_the_gradient_of_half_the_square_above_the_threshold() -> None:
    """By differences of k_F itself, with weights that are all alike, so that the vector is a gradient."""
    even = newton_step.FollowerSettings(*SETTINGS)
    surface = even.condition_weights._replace(table=np.full_like(even.condition_weights.table, 0.3))
    even = even._replace(condition_weights=surface)
    off = even._replace(condition_weights=surface._replace(table=np.zeros_like(surface.table)))
    wanted = looked_at(LOW, even).g - looked_at(LOW, off).g

    def potential(q: np.ndarray) -> float:
        return 0.15 * max(0.0, kf(q) - 1.0 / CELL.resolve.threshold) ** 2

    expected = [(potential(LOW + d) - potential(LOW - d)) / 2e-6 for d in 1e-6 * np.eye(len(LOW))]
    np.testing.assert_allclose(wanted, expected, atol=1e-6)
    assert np.abs(wanted).max() > 0.1
    assert not looked_at(CELL.q_home, even).kf_bend.any()  # above the threshold there is none of it


def test_its_derivative_against_differences() -> None:
    """What Newton's method takes for the derivative of the vector, by differences of the vector."""
    beside = LOW + 0.01  # LOW itself lies on a node of the weights' table, where their slope jumps

    def vector(q: np.ndarray) -> np.ndarray:
        return looked_at(q, SETTINGS).g.copy()

    w = looked_at(beside, SETTINGS)
    whole = np.diag(w.weight) + w.kf_bend
    for surface, slopes in ((SETTINGS.joint_weights, w.slope), (SETTINGS.condition_weights, w.slope_cond)):
        for axis, slope in zip(surface.axis, slopes, strict=True):
            whole[:, axis] += slope
    expected = np.stack([(vector(beside + d) - vector(beside - d)) / 2e-6 for d in 1e-6 * np.eye(len(beside))], axis=1)
    np.testing.assert_allclose(whole, expected, atol=2e-4 * np.abs(expected).max())


def test_a_path_is_the_one_by_qr_and_stands_at_the_optimum() -> None:
    path = five_axis_path(LOW, 25, STEP, 0.5 * TURN)
    ends = []
    for chain in (CHAIN, BY_QR):
        state = state_at(LOW, LOW)
        code, _, q, _inv_kf = follow(SETTINGS, path, state, chain=chain)
        assert code == FOLLOWED
        np.testing.assert_allclose(base_T_tool(CELL, q)[:, :3, 3], path[:, :3, 3], atol=1e-9)
        ends.append(q)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-7)
    below = [q for q in ends[0][1:] if kf(q) > 1.0 / CELL.resolve.threshold]
    for q in below:
        w = looked_at(q, SETTINGS)
        null = np.linalg.svd(w.J)[2][6:]
        assert np.abs(null @ w.g).max() < 1e-7 * max(1.0, np.abs(w.g).max())


def test_it_leads_out_of_a_bad_posture_and_the_printed_form_holds_it_there() -> None:
    """One pose held: the gradient raises 1/k_F from where it was recorded, eq. 18 draws back to that posture."""
    pose = base_T_tool(CELL, LOW)[None]
    value = {}
    for name, settings in (
        ("gradient", SETTINGS),
        ("recorded", SETTINGS._replace(gradient=False)),
        ("off", SETTINGS._replace(threshold=0.0)),
    ):
        path, state = np.repeat(pose, 12, axis=0), state_at(LOW)
        code, _, _, inv_kf = follow(settings, path, state)
        assert code == FOLLOWED
        value[name] = inv_kf[-1]
    start = 1.0 / kf(LOW)
    assert value["gradient"] > value["recorded"] + 0.01 and value["gradient"] > start + 0.01
    assert abs(value["recorded"] - start) < abs(value["off"] - start)


@pytest.mark.parametrize(
    ("term", "threshold", "gradient"), [("recorded", 0.5, False), ("gradient", 0.5, True), ("off", 0.0, False)]
)
def test_the_cells_setting_is_what_the_tracker_gets(term: str, threshold: float, gradient: bool) -> None:
    cell = replace(CELL, resolve_section=replace(CELL.resolve, condition_term=term))
    weighting = engine_weighting(cell)
    assert (weighting.threshold, weighting.gradient) == (threshold, gradient)


def test_past_a_stretched_arm_the_gradient_keeps_more_than_the_printed_form() -> None:
    """An arc high over the table, the tool leaning beyond the level and back: 1/k_F falls to 0.37 where h_cond is off."""
    s = np.linspace(0.0, 1.0, 160)
    tilt, turn = np.radians(100.0) * np.sin(np.pi * s) ** 2, np.pi / 2 + np.radians(30.0) * (s - 0.5)
    axis = np.stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)], axis=1)
    position = 0.15 * axis + np.array([0.0, 0.0, 0.8]) - 0.2 * (s - 0.5)[:, None] * [1.0, 0.0, 0.0]
    n = len(s)
    arc = Region("arc", position, axis, np.full(n, 0.05), np.full(n, int(Move.CUT), np.int8), np.arange(1, n + 1))
    path = build_path(CELL, Toolpath((arc,), "arc", "", "drawn"), np.eye(4), clearance=0.05)
    own = engine_weighting(CELL)
    least = {
        name: float(resolve_vjm(CELL, path, weighting=weighting).inv_kf[path.cutting].min())
        for name, weighting in (
            ("off", replace(own, threshold=0.0)),
            ("recorded", own),
            ("gradient", replace(own, gradient=True)),
        )
    }
    assert least["off"] < 0.38 < 0.4 < least["recorded"] < 0.45 < least["gradient"]
