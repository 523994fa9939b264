"""The plans' small matrices against NumPy's library, and the search's shelves against looking at every pair."""

from __future__ import annotations

import numpy as np
import pytest

from camrob.compiled import kernel
from camrob.redundancy.planning.dynamic_programming import Layers, cheapest_way
from camrob.small_matrices import made_positive, solved


@kernel
def _both(H, A, X):
    made_positive(H)
    return solved(A, X)


@pytest.mark.parametrize("size", [1, 2, 3, 4, 6])
def test_small_matrices_are_the_librarys(size: int) -> None:
    rng = np.random.default_rng(size)
    for _ in range(50):
        H = rng.normal(size=(size, size)) * 10.0 ** rng.uniform(-6, 6)
        H = H + H.T
        A, X = rng.normal(size=(size, size)), rng.normal(size=(size, size))
        values, vectors = np.linalg.eigh(H)
        got, x = H.copy(), X.copy()
        used = A.copy()
        exchanged = _both(got, used, x)
        np.testing.assert_allclose(got, (vectors * np.abs(values)) @ vectors.T, atol=1e-13 * np.abs(values).max())
        np.testing.assert_allclose(A @ x, X, atol=1e-9)
        np.testing.assert_allclose(exchanged * np.prod(np.diag(used)), np.linalg.det(A), rtol=1e-9)


def test_a_matrix_of_zeros_and_a_diagonal_stay() -> None:
    H = np.zeros((3, 3))
    _both(H, np.eye(3), np.ones((3, 3)))
    assert not H.any()
    H = np.diag([1.0, -2.0, 3.0])
    _both(H, np.eye(3), np.ones((3, 3)))
    np.testing.assert_array_equal(H, np.diag([1.0, 2.0, 3.0]))


def _by_every_pair(layers: Layers) -> float:
    leave = layers.price[: layers.offset[1]]
    for t in range(1, len(layers.offset) - 1):
        before, here = (layers.x[a:b] for a, b in zip(layers.offset[t - 1 :], layers.offset[t : t + 2], strict=False))
        d = np.abs(here[:, None] - before[None])
        turn = 2.0 * np.pi
        d[..., layers.endless] = np.abs((d[..., layers.endless] + np.pi) % turn - np.pi)
        way = (layers.rate[t] * d + layers.square[t] * d * d).sum(axis=2)
        way[(d > layers.window[t]).any(axis=2)] = np.inf
        leave = (way + leave).min(axis=1) + layers.price[layers.offset[t] : layers.offset[t + 1]]
    return float(leave.min())


@pytest.mark.parametrize("endless", [(True, False, False), (False, False, True), (False, True, False)])
def test_the_search_looks_at_all_that_counts(endless: tuple[bool, ...]) -> None:
    """Windows from hardly anything to wider than all there is, first, last or no coordinate endless, several turns away."""
    rng = np.random.default_rng(8)
    for window in (1e-9, 0.02, 0.4, 1.7, 40.0):
        for _ in range(6):
            T, K = 9, 70
            x = rng.uniform(-9.0, 9.0, (T, K, 3))
            x[..., 1] = rng.integers(4, size=(T, K))
            x[:, ::3] = x[0, ::3]  # some that stand still
            layers = Layers(
                np.arange(0, T * K + 1, K),
                x.reshape(-1, 3),
                rng.uniform(0.0, 1.0, T * K),
                np.full((T, 3), window),
                np.full((T, 3), 0.3),
                np.full((T, 3), 0.1),
                np.full((T, 3), np.inf),
                np.zeros(T),
                np.array(endless),
                np.full(T, np.inf),
            )
            assert cheapest_way(layers).price == pytest.approx(_by_every_pair(layers), rel=1e-12)
