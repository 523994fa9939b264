"""The benchmark's baselines select as their papers say, and its table of effects taken out counts what it says."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

from gap.baselines import METHODS, SETTINGS, Problem, entering
from gap.taken_out import table


def problem(planted: dict[int, float], seed: int = 1, count: int = 12, rows: int = 400) -> Problem:
    """Columns of unit size, each an effect of its own but the first, which is a frame's; noise of deviation 1."""
    rng = np.random.default_rng(seed)
    X = rng.normal(size=(rows, count))
    X /= np.linalg.norm(X, axis=0)
    y = rng.normal(size=rows) + sum((v * X[:, k] for k, v in planted.items()), np.zeros(rows))
    blocks = np.array_split(np.arange(rows), 10)
    units = [SimpleNamespace(effect="nuisance" if k == 0 else f"e{k}") for k in range(count)]
    return Problem(
        units,
        np.arange(count),
        np.array([X[r].T @ X[r] for r in blocks]),
        np.array([X[r].T @ y[r] for r in blocks]),
        float(y @ y),
        float(rows),
        (),
        (),
        (),
        {},
        1.0,
    )


def test_columns_at_right_angles_enter_by_size() -> None:
    b = np.array([0.5, -3.0, 1.0, 2.0, -0.1])
    assert entering(np.eye(5), b, 3) == [1, 3, 2]


@pytest.mark.slow
def test_along_the_path_active_columns_stay_equally_near_what_is_left() -> None:
    """Against the lasso's own conditions: with the penalty at which the path stands, a solver of another kind keeps the same."""
    rng = np.random.default_rng(4)
    X = rng.normal(size=(60, 8)) @ (np.eye(8) + 0.5)
    X /= np.linalg.norm(X, axis=0)
    y = X @ np.array([3.0, 0, 0, -2.0, 0, 0, 1.0, 0]) + 0.05 * rng.normal(size=60)
    A, b = X.T @ X, X.T @ y
    active = entering(A, b, 3)
    for penalty in np.geomspace(np.abs(b).max(), 1e-3 * np.abs(b).max(), 400):
        beta = np.zeros(8)
        for _ in range(3000):  # proximal steps (Beck and Teboulle 2009), as long as the largest eigenvalue allows
            beta = beta + (b - A @ beta) / np.linalg.eigvalsh(A)[-1]
            beta = np.sign(beta) * np.maximum(np.abs(beta) - penalty / np.linalg.eigvalsh(A)[-1], 0.0)
        if np.count_nonzero(beta) == 3:
            assert set(np.flatnonzero(beta)) == set(active)
            return
    pytest.fail("no penalty keeps three columns")


@pytest.mark.parametrize("name", list(METHODS))
def test_what_is_planted_is_found_and_noise_is_not(name: str) -> None:
    settings = {**SETTINGS, "first": 3, "often": 0.75}
    members, weights = METHODS[name](problem({3: 12.0, 7: -9.0}), settings)
    assert members - {0} == {3, 7}
    assert sum(w for s, w in weights.items() if {"e3", "e7"} <= s) > 0.9 * sum(weights.values())
    none, _ = METHODS[name](problem({}), settings)
    assert none <= {0}


def test_effects_taken_out_are_counted_with_intervals() -> None:
    def row(flagged: bool, alike: bool, *said: tuple[str, float]) -> SimpleNamespace:
        effects = [{"effect": n, "probability": p} for n, p in said]
        return SimpleNamespace(
            flagged=flagged, within=lambda: alike, task={"only": "lean", "seed": 7}, said={"effects": effects}
        )

    rows = [
        row(True, False, ("track", 0.97)),
        row(False, True, ("track", 0.97)),
        row(False, False),
        row(True, False, ("track", 0.7)),
    ]
    lines = table(rows)
    assert lines[2] == "| lean | 4 | 2 | 1 | 3 | 1 | track 0.97 (7) |"
    assert lines[3].startswith(
        "| all | 4 | 2 (15.0 to 85.0 %) | 1 (4.6 to 69.9 %) | 3 (30.1 to 95.4 %) | 1 (4.6 to 69.9 %)"
    )
