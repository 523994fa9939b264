"""How sets of effects are weighed: sizes that count, effects that cancel, constants that nobody knows, poses that scatter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gap_cases import generator, kr15, poses, simulated
from test_gap_effects import plant_link

from camrob.errors import LogError
from camrob.gap.diagnose import diagnose
from camrob.gap.effects.effect import EffectParameter, Unit
from camrob.gap.evidence.design import Design
from camrob.gap.evidence.evidence import _SHARES as SHARES
from camrob.gap.evidence.evidence import COUNTS_FROM, Evidence
from camrob.gap.evidence.scan import _gain, _peak
from camrob.gap.evidence.search import posterior

NOISE = 1e-4
ROWS = 400
MOVED = np.array([3e-4, -2e-4, 2e-4, 3e-4, 2e-4, 5e-4])  # m, rad


def two_alike(mix: float, wanted: tuple[float, float], seed: int = 0) -> Evidence:
    """Two effects of one parameter each, patterns alike but for `mix`, in a gap that is `wanted` of them."""
    rng = np.random.default_rng(seed)
    first, second = np.linalg.qr(rng.normal(size=(ROWS, 2)))[0].T * np.sqrt(ROWS)
    X = np.stack([first, first + mix * second], axis=1) * 1e-3
    y = X @ np.array(wanted)
    W = X * np.sqrt(3.0) / NOISE
    units = tuple(Unit(n, "", (EffectParameter(n, "1", 1.0, -np.inf, np.inf),)) for n in ("one", "other"))
    z = y * np.sqrt(3.0) / NOISE + rng.normal(size=ROWS)
    size = np.sqrt(np.mean(X**2, axis=0))
    design = Design(
        units,
        np.array([0, 1]),
        (W.T @ W)[None],
        (W.T @ z)[None],
        np.array([z @ z]),
        np.array([ROWS]),
        size,
        np.ones(2),
        X.T @ X / ROWS,
    )
    return Evidence(design, NOISE)


def dense(X: np.ndarray, y: np.ndarray, widths: np.ndarray) -> float:
    """Log density of unit noise and columns with Gaussian weights, but for its constant, by the covariance of all rows."""
    covariance = np.eye(len(y)) + (X * widths**2) @ X.T
    return -0.5 * float(y @ np.linalg.solve(covariance, y)) - 0.5 * float(np.linalg.slogdet(covariance)[1])


def dense_rows(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Forty rows of seven columns, and a gap that all of them made."""
    X = rng.normal(size=(40, 7)) @ (np.eye(7) + 0.4 * rng.normal(size=(7, 7)))
    return X, X @ rng.normal(0, 0.5, 7) + rng.normal(size=40)


def dense_design(rng: np.random.Generator) -> Design:
    """These rows as four units of one to three columns, an effect each."""
    counts = (1, 2, 3, 1)
    X, y = dense_rows(rng)
    owner = np.repeat(np.arange(4), counts)
    units = tuple(
        Unit(f"u{i}", "", tuple(EffectParameter(f"{i}{k}", "1", 1.0, -np.inf, np.inf) for k in range(n)))
        for i, n in enumerate(counts)
    )
    gram, one = (X.T @ X)[None], np.ones(7)
    return Design(units, owner, gram, (X.T @ y)[None], np.array([y @ y]), np.array([40]), one, one, X.T @ X / 40)


def test_one_unit_more_or_less_is_worth_what_the_covariance_of_all_rows_says() -> None:
    (X, y), design = dense_rows(np.random.default_rng(5)), dense_design(np.random.default_rng(5))
    evidence, members, owner = Evidence(design, 0.1), frozenset({1, 3}), design.owner
    fitted = evidence.fit(members)
    out, usual = evidence._widths
    for other, (score, moved) in evidence.neighbours(fitted).items():
        (unit,) = other ^ members
        own, tried = owner == unit, [out]
        if unit in other:
            shares = {max(s, evidence._least[f"u{unit}"]) for s in SHARES}
            tried = [np.maximum(share * usual, out) for share in shares]
        widths = [np.where(own, t, fitted.widths) for t in tried]
        gains = [dense(X, y, w) - dense(X, y, fitted.widths) for w in widths]
        prior = evidence.prior(other) - evidence.prior(members)
        assert score - fitted.score == pytest.approx(max(gains) + prior, abs=1e-8)
        best = widths[int(np.argmax(gains))]
        mean = np.linalg.solve(X.T @ X + np.diag(best**-2.0), X.T @ y)
        assert moved == pytest.approx(float(np.sqrt(mean[own] @ design.moves[np.ix_(own, own)] @ mean[own])), rel=1e-8)


def test_effects_far_larger_than_the_gap_that_cancel_cost_and_others_do_not() -> None:
    cancelling, ordinary = two_alike(0.01, (5.0, -4.9)), two_alike(0.9, (0.6, 0.5))
    both = frozenset({0, 1})
    for evidence, least, most in ((cancelling, 3.0, np.inf), (ordinary, 0.0, 0.0)):
        fitted = evidence.fit(both)
        pull = fitted.mean @ evidence.design.moves @ fitted.mean
        cost = -evidence._strain(fitted.energy, float(pull))
        assert least <= cost <= most
        plain = replace(evidence.design, moves=np.zeros((2, 2)))
        assert fitted.score == pytest.approx(replace(evidence, design=plain).fit(both).score - cost, abs=1e-9)


def test_an_effect_counts_by_how_probable_it_is_that_it_moves_the_tool_enough() -> None:
    sizes = np.linspace(0.0, 1.0, 21)
    chances = []
    for size in sizes:
        evidence = two_alike(0.9, (5.0, size * NOISE / 1.35e-3))
        chances.append(evidence.seen(evidence.fit(frozenset({0, 1})))["other"])
    assert np.all(np.diff(chances) > -0.05)
    assert chances[0] < 0.02
    assert chances[-1] > 0.98
    # half-way where the effect is just large enough, but for the noise drawn
    assert sizes[np.argmax(np.array(chances) > 0.5)] == pytest.approx(COUNTS_FROM, abs=0.2)


def test_a_set_is_divided_over_the_names_that_count() -> None:
    one, both = frozenset({0}), frozenset({0, 1})
    found = posterior({one: 0.0, both: 0.0}, {one: {"a": 1.0}, both: {"a": 1.0, "b": 0.3}})
    assert found[frozenset({"a"})] == pytest.approx(0.85)
    assert found[frozenset({"a", "b"})] == pytest.approx(0.15)
    assert posterior({both: 0.0}, {both: {"a": 1.0, "b": 0.3}}, frozenset({"b"})) == {frozenset({"a"}): 1.0}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "apply", "place"),
    [
        ("frame_base", lambda w: setattr(w, "base", generator.rigid(MOVED)), "the robot's foot"),
        ("frame_tool", lambda w: setattr(w, "tool", generator.rigid(MOVED)), "the tool"),
        ("joint_offset", plant_link(2, lambda w: 1e-3), "A3"),
    ],
)
def test_a_constant_that_the_library_lacks_is_unknown_and_no_broad_effect_is_blamed(
    name: str, apply, place: str
) -> None:
    log = simulated(apply, sigma_mm=0.02)
    found = diagnose([log], kr15(), without=[name])
    assert found.claimed == ()
    assert found.summary.to_json()["status"] == "unexplained"
    assert f"{place} is off by a constant" in found.summary.to_json()["unknown"]["text"]
    assert diagnose([log], kr15()).claimed == (name,)


@pytest.mark.slow
def test_single_poses_that_scatter_beyond_their_noise_are_not_called_explained() -> None:
    t, axis = poses()
    early = simulated(
        lambda w: w.link.__iadd__(2e-4 * np.diff(w.command, axis=0, prepend=w.command[:1])),
        sigma_mm=0.02,
        run=(t, axis),
        poses=True,
    )
    found = diagnose([early], kr15(), without=["early_reading"])
    assert found.summary.to_json()["unknown"]["probability"] > 0.5
    assert found.summary.to_json()["status"] in ("unexplained", "partly explained")
    assert all(e["probability"] < 0.8 for e in found.summary.to_json()["effects"])
    quiet = simulated(sigma_mm=0.02, run=(t, axis), poses=True)
    assert diagnose([quiet], kr15()).summary.to_json()["status"] == "no gap"


def unstated(log):
    """A log that does not state the instrument's noise."""
    return replace(log, info=replace(log.info, sigma_position=float("nan"), sigma_angle=float("nan")))


@pytest.mark.slow
def test_the_noise_of_single_poses_that_nobody_told_is_found_from_what_nothing_explains() -> None:
    quiet = unstated(simulated(sigma_mm=0.03, run=poses(), poses=True))
    found = diagnose([quiet], kr15())
    assert found.claimed == ()
    assert found.summary.to_json()["gap"]["noise_mm"] == pytest.approx(0.03 * np.sqrt(3.0), rel=0.15)
    offset = unstated(simulated(plant_link(2, lambda w: 1e-3), sigma_mm=0.03, run=poses(), poses=True))
    assert diagnose([offset], kr15()).claimed == ("joint_offset",)
    with pytest.raises(LogError, match="too few"):
        diagnose([unstated(simulated(sigma_mm=0.03, run=poses(14), poses=True))], kr15())


def test_a_quantity_that_hardly_changes_where_anything_was_measured_explains_nothing() -> None:
    """Its functions are constants there, but for rounding: they have no products to solve for."""
    rng = np.random.default_rng(0)
    w = np.where(np.arange(400) < 200, 1e8, 0.0)
    still = np.where(np.arange(400) < 200, 0.3, rng.uniform(-1.0, 1.0, 400))
    X = np.polynomial.legendre.legvander(still, 5)[:, 1:].T
    gain, coefficients = _gain(np.ascontiguousarray(X), rng.normal(0.0, 1e-4, 400), w)
    assert np.isfinite(coefficients).all()
    assert gain < 40.0
    for angle in (np.full(400, 0.3), np.where(w > 0.0, 0.3, still)):
        assert _peak(np.linspace(20.0, 21.0, 41), rng.normal(0.0, 1e-4, 400), w, angle)[1] < 40.0
