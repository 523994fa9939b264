"""What one moving part explains of folds that it was not fitted to, all parts at once, is what each explains by itself."""

from __future__ import annotations

import numpy as np
import pytest

from camrob.gap.locate.single_shape import _withheld


def plainly(lever: np.ndarray, shape: np.ndarray, gap: np.ndarray, fold: np.ndarray) -> float:
    """m2, each fold's rows predicted from all others'."""
    X = np.concatenate([lever[:, :, None] * shape[:, None, :], np.tile(np.eye(3), (len(gap), 1, 1))], axis=2)
    gained = 0.0
    for k in np.unique(fold):
        own, rest = fold == k, fold != k
        fitted = np.linalg.lstsq(X[rest].reshape(-1, X.shape[2]), gap[rest].ravel(), rcond=None)[0]
        gained += float(np.sum(gap[own] ** 2) - np.sum((gap[own] - X[own] @ fitted) ** 2))
    return gained


def test_all_parts_at_once_take_what_each_takes_alone() -> None:
    rng = np.random.default_rng(4)
    levers, x = rng.normal(size=(3, 240, 3)), rng.uniform(-1.0, 1.0, 240)
    shape = np.polynomial.legendre.legvander(x, 4)
    gap = levers[1] * (x**3 - 0.2)[:, None] + 0.3 + 0.1 * rng.normal(size=(240, 3))
    fold = np.arange(240) // 40
    found = _withheld(levers, shape, gap, np.arange(0, 241, 40))
    assert found == pytest.approx([plainly(lever, shape, gap, fold) for lever in levers], rel=1e-6)
    assert np.argmax(found) == 1
