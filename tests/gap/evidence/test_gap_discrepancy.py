"""The discrepancy: integrated out as a dense Gaussian says, sized as planted, and no effect's value or name is lost to it."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from gap_cases import generator, kr15, motion, simulated
from scipy.stats import multivariate_normal
from test_gap_effects import plant_lag, plant_link, plant_play

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from gap.field import draw_field

from camrob.gap.diagnose import diagnose
from camrob.gap.effects.effect import EffectParameter, Unit
from camrob.gap.effects.registry import library
from camrob.gap.evidence.comparison import compare
from camrob.gap.evidence.design import Design
from camrob.gap.evidence.discrepancy import PARTS, FieldGram, smooth_basis
from camrob.gap.evidence.evidence import Evidence
from camrob.gap.evidence.field_size import no_sizes
from camrob.gap.observation.scene import make_scene

SIGMA = 0.02
FIELD = 5.0 * SIGMA * np.sqrt(3.0)  # mm, 3-D rms: what real arms leave, five times the instrument's noise
PLANTED = {
    "backlash": plant_play,
    "servo_lag": plant_lag,
    "joint_offset": plant_link(2, lambda w: 1.5e-3),
    "frame_tool": lambda w: setattr(w, "tool", generator.rigid([0, 0, 0, 8e-4, -6e-4, 0])),
}


def with_field(apply, seed: int = 1, size: float = FIELD):
    def both(world) -> None:
        if apply is not None:
            apply(world)
        draw_field(seed, world, size * 1e-3)(world)

    return both


@cache
def model_of(name: str, field: bool):
    """The comparison of a planted effect's log, with the smooth field beside it or not."""
    apply = PLANTED[name]
    log = simulated(with_field(apply) if field else apply, sigma_mm=SIGMA, rate=12.5)
    return compare([make_scene(log, kr15())], library())


def test_integrating_it_out_is_what_a_dense_gaussian_says() -> None:
    rng = np.random.default_rng(0)
    N, K, M, noise = 60, 3, 5, 1e-4
    X, F, y = rng.normal(size=(N, 6, K)) * 1e-3, rng.normal(size=(N, M)), rng.normal(size=(N, 6)) * 3e-4
    w = 1.0 / rng.uniform(0.5e-4, 2e-4, (N, 6))
    part = np.array([0, 0, 0, 1, 3])
    sizes = np.zeros((2, len(PARTS)))
    sizes[:, :2] = [[2e-4, 1e-4], [3e-4, 0.0]]
    C = np.stack([(X[:, r] * w[:, r, None]).T @ (F * w[:, r, None]) for r in range(6)])
    D = np.stack([(F * w[:, r, None]).T @ (F * w[:, r, None]) for r in range(6)])
    d = np.stack([(F * w[:, r, None]).T @ (y[:, r] * w[:, r]) for r in range(6)])
    Z, z = (X * w[..., None]).reshape(-1, K), (y * w).ravel()
    units = tuple(Unit(n, "", (EffectParameter(n, "1", 0.3, -np.inf, np.inf),)) for n in "abc")
    design = Design(
        units,
        np.arange(K),
        (Z.T @ Z)[None],
        (Z.T @ z)[None],
        np.array([z @ z]),
        np.array([6.0 * N]),
        np.sqrt(np.mean(np.sum(X**2, axis=1), axis=0)),
        np.full(K, 0.3),
        np.einsum("nik,nil->kl", X, X) / N,
        FieldGram(C[None], D[None], d[None], part),
    )
    evidence = Evidence(design, noise, sizes=sizes)
    found, expected = [], []
    for members in (frozenset[int](), frozenset({0}), frozenset({1, 2})):
        widths = np.where(np.isin(np.arange(K), list(members)), 0.3, evidence._widths[0])
        fitted = evidence._solve(members, widths, np.full(len(evidence._effects), np.nan), evidence._own(members))
        found.append(fitted.score - evidence.prior(members))
        cov = np.diag((1.0 / w**2).ravel())
        cov += np.einsum("nik,k,mjk->nimj", X, widths**2, X).reshape(6 * N, 6 * N)
        for row in range(6):
            S = sizes[row // 3][part]
            cov[row::6, row::6] += F @ np.diag(S**2) @ F.T
        expected.append(multivariate_normal(np.zeros(6 * N), cov).logpdf(y.ravel()))
        mean = np.diag(widths**2) @ X.reshape(-1, K).T @ np.linalg.solve(cov, y.ravel())
        assert fitted.mean == pytest.approx(mean, rel=1e-6, abs=1e-9)
    # but for what the white noise says whatever is in
    assert np.diff(found) == pytest.approx(np.diff(expected), abs=1e-6)
    without = Evidence(design, noise).fit(frozenset({0})).score
    assert Evidence(design, noise, sizes=no_sizes()).fit(frozenset({0})).score == pytest.approx(without, abs=1e-9)


def test_its_functions_vary_as_much_as_told_and_take_in_a_field_that_they_were_not_made_from() -> None:
    log = simulated(sigma_mm=SIGMA, rate=12.5)
    scene = make_scene(log, kr15())
    basis = smooth_basis([scene])
    F = basis.columns(scene)
    posture = F[:, basis.part == 0][:, 1:]
    assert np.mean(np.sum((posture - posture.mean(axis=0)) ** 2, axis=1)) == pytest.approx(1.0, rel=0.05)
    t, command = motion()
    world = generator.World(t, command)
    draw_field(7, world, 1e-3)(world)
    field = np.stack([np.interp(scene.t, t, world.after[:, k]) for k in range(3)], axis=1)
    left = field - F[:, basis.part == 0] @ np.linalg.lstsq(F[:, basis.part == 0], field, rcond=1e-10)[0]
    assert np.sqrt(np.mean(np.sum(left**2, axis=1))) < 0.02e-3


@pytest.mark.parametrize("name", sorted(PLANTED))
def test_it_moves_no_planted_parameter_by_more_than_two_sigma(name: str) -> None:
    model = model_of(name, field=False)
    assert model.evidence.effects_of(model.best.members) == {name}
    there = no_sizes()
    there[:, 0] = 5.0 * SIGMA * 1e-3, 5.0 * np.deg2rad(1e-3)
    with_it, without = (replace(model.evidence, sizes=s).fit(model.best.members) for s in (there, no_sizes()))
    own = np.flatnonzero(np.isin(model.design.owner, list(model.best.members - model.evidence.always)))
    sigma = np.sqrt(np.diag(with_it.cov)[own])
    # but for what shows at the drives alone, where the log itself tells
    assert name == "servo_lag" or np.abs(with_it.mean[own] - without.mean[own]).max() > 0.0
    assert np.abs((with_it.mean[own] - without.mean[own]) / sigma).max() < 2.0


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("name", sorted(PLANTED))
def test_a_cause_keeps_its_name_beside_a_field_of_five_times_the_noise(name: str) -> None:
    model = model_of(name, field=True)
    assert sum(p for names, p in model.sets.items() if name in names) > 0.5
    assert model.discrepancy == pytest.approx(FIELD * 1e-3, rel=0.5)


@pytest.mark.parametrize(("size", "sure"), [(FIELD, False), (0.4 * FIELD, True)])
def test_both_statements_are_made_and_the_claim_is_sure_where_it_is_twice_the_unknown(size: float, sure: bool) -> None:
    log = simulated(with_field(PLANTED["backlash"], size=size), sigma_mm=SIGMA)
    found = diagnose([log], kr15()).summary.to_json()
    claims = {e["effect"]: e["probability"] for e in found["effects"] if e["probability"] >= 0.5}
    assert set(claims) == {"backlash"}
    assert (claims["backlash"] > 0.9) == sure
    assert claims["backlash"] > 0.75
    assert found["status"] == "partly explained"
    assert found["unknown"]["probability"] > 0.9
    assert found["unknown"]["rms_mm"] == pytest.approx(size, rel=0.3)
    assert found["unknown"]["where"]["rung"] == "encoder_to_tcp"
    assert "position" in found["unknown"]["where"]["regimes"]
    assert sum(a["probability"] for a in found["alternatives"]) == pytest.approx(1.0)
    assert all("unknown" not in a["effects"] for a in found["alternatives"])


@pytest.mark.slow
def test_more_data_never_makes_the_answer_worse() -> None:
    apply = with_field(lambda w: (plant_play(w), PLANTED["joint_offset"](w)))
    claimed = []
    for rate in (5.0, 20.0, 80.0):
        claimed.append(set(diagnose([simulated(apply, sigma_mm=SIGMA, rate=rate)], kr15()).claimed))
    assert all(c <= {"backlash", "joint_offset"} for c in claimed)
    assert claimed[0] <= claimed[1] <= claimed[2]
    assert claimed[2] == {"backlash", "joint_offset"}


def test_nothing_is_said_of_a_field_where_there_is_none() -> None:
    found = diagnose([simulated(sigma_mm=SIGMA)], kr15()).summary.to_json()
    assert found["status"] == "no gap"
    assert found["within"] == {"encoder_to_tcp": "noise", "setpoint_to_encoder": "noise"}
    assert found["unknown"]["probability"] < 0.1
    assert found["residual"]["discrepancy_mm"] < 0.3 * found["gap"]["noise_mm"]
