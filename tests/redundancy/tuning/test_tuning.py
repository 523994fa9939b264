"""Fitting weights: the search finds a planted optimum, a fitted engine stays an engine, the merit is what it says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from follower_twins import CELL, FOLDER

from camrob.kinematics.frames import base_T_tool
from camrob.redundancy.fuzzy.fis import read_fis
from camrob.redundancy.fuzzy.write_fis import fis_text
from camrob.redundancy.path import ToolPathInBase
from camrob.redundancy.tuning.engine_parameters import EngineParameters, as_sugeno
from camrob.redundancy.tuning.evolution import minimise
from camrob.redundancy.tuning.merit import postures_merit

SYSTEM = as_sugeno(read_fis(FOLDER / CELL.resolve.joint_engine.file))
PARAMETERS = EngineParameters(SYSTEM)


def test_the_search_finds_a_planted_optimum() -> None:
    planted = np.array([0.7, -1.2, 0.3, 2.0])
    calls: list[float] = []
    found = minimise(
        lambda x: float(np.sum((x - planted) ** 2)),
        [np.zeros(4)],
        spread=np.ones(4),
        budget=400,
        seed=3,
        progress=calls.append,
    )
    np.testing.assert_allclose(found.vector, planted, atol=1e-2)
    assert found.tried <= 400 and np.all(np.diff(found.course) <= 0.0)
    assert calls == sorted(calls) and calls[-1] <= 1.0


def test_the_same_seed_finds_the_same_and_a_start_is_never_lost() -> None:
    def rough(x: np.ndarray) -> float:
        return float(np.sum(np.abs(x)) + 0.2 * np.sin(37.0 * x).sum())

    starts = [np.full(3, 4.0), np.full(3, -1.0)]
    first, again, other = (minimise(rough, starts, spread=np.ones(3), budget=60, seed=s) for s in (1, 1, 2))
    np.testing.assert_array_equal(first.vector, again.vector)
    assert np.any(first.vector != other.vector)
    assert first.price <= min(map(rough, starts))
    assert minimise(rough, starts, spread=np.ones(3), budget=1, seed=1).tried == 1


def test_a_mamdani_term_becomes_the_weight_that_it_stands_for() -> None:
    low, medium, high = (term.parameters[0] for term in SYSTEM.outputs[0].terms)
    assert (low, medium, high) == pytest.approx((0.05 / 3, 0.32 / 3, 1.0 / 3), rel=2e-3)  # centroids of triangles
    assert as_sugeno(SYSTEM) is SYSTEM


def test_the_start_is_the_engine_itself() -> None:
    assert PARAMETERS.engine(PARAMETERS.start) == replace(SYSTEM, outputs=PARAMETERS.engine(PARAMETERS.start).outputs)
    x = np.random.default_rng(1).uniform([-120, -135], [160, 135], (50, 2))
    np.testing.assert_allclose(
        PARAMETERS.engine(PARAMETERS.start).evaluate_grid(x), SYSTEM.evaluate_grid(x), rtol=1e-12
    )


def test_terms_all_alike_are_a_constant_vector() -> None:
    weights = np.array([0.095, 0.56, 0.076, 0.126])
    x = np.random.default_rng(2).uniform([-120, -135], [160, 135], (50, 2))
    expected = PARAMETERS.engine(PARAMETERS.alike(weights)).evaluate_grid(x)
    np.testing.assert_allclose(expected, np.tile(weights, (50, 1)), rtol=1e-12)


def test_whatever_the_vector_the_file_opens_again(tmp_path) -> None:
    """Corners in their order, some rule everywhere, weights above 0: `read_fis` refuses all else."""
    rng = np.random.default_rng(3)
    for k in range(40):
        vector = PARAMETERS.start + rng.normal(0.0, 3.0, len(PARAMETERS.start))
        system = PARAMETERS.engine(vector)
        file = tmp_path / f"{k}.fis"
        file.write_text(fis_text(system))
        x = rng.uniform([-120, -135], [160, 135], (20, 2))
        np.testing.assert_allclose(read_fis(file).evaluate_grid(x), system.evaluate_grid(x), rtol=1e-3)


def cut(q: np.ndarray, feed: float) -> ToolPathInBase:
    n = len(q)
    return ToolPathInBase(
        base_T_tool(CELL, q),
        np.ones(n, np.int8),
        np.full(n, feed),
        np.arange(n),
        np.zeros(n),
        np.arange(n),
        np.zeros(n),
    )


def posture(count: int, name: str, value: float) -> np.ndarray:
    q = np.tile(CELL.q_home, (count, 1))
    q[:, CELL.index(name)] += np.linspace(0.0, value, count)
    return q


def test_the_merit_of_a_track_that_carries_a_still_arm() -> None:
    """Half a metre of track: travel at its price, conditioning that of HOME, no feed lost while the track is fast enough."""
    q = posture(51, "E1", 0.5)
    merit = postures_merit(CELL, cut(q, 0.1), q, np.full(51, 0.6))
    prices = CELL.resolve.planned
    assert merit.terms["travel"] == pytest.approx(prices["travel_prismatic"])
    assert merit.terms["conditioning"] == pytest.approx((CELL.resolve.threshold / 0.6) ** prices["power"])
    assert merit.terms["margins"] == 0.0 and merit.terms["feed"] == 0.0
    assert merit.held == 1.0 and merit.travel == {"E2": 0.0, "E1": pytest.approx(0.5)}
    assert merit.price == pytest.approx(sum(merit.terms.values()))


def test_feed_that_an_axis_cannot_follow_is_lost() -> None:
    speed = float(CELL.limits_of("speed")[CELL.index("E1")])
    q = posture(51, "E1", 0.5)
    merit = postures_merit(CELL, cut(q, 2.0 * speed), q, np.full(51, 0.6))
    assert merit.terms["feed"] == pytest.approx(1.0, rel=1e-6)  # twice the time: a metre lost for each metre cut
    assert merit.held == 0.0


def test_a_joint_near_its_limit_is_priced() -> None:
    i = CELL.index("A5")
    q = posture(21, "E1", 0.2)
    q[:, i] = CELL.q_lower[i] + np.radians(CELL.resolve.planned["margin_deg"])
    merit = postures_merit(CELL, cut(q, 0.1), q, np.full(21, 0.6))
    assert merit.terms["margins"] == pytest.approx(1.0)  # (2 - 1)^2 at the margin itself
    assert np.degrees(merit.margin) == pytest.approx(CELL.resolve.planned["margin_deg"])
