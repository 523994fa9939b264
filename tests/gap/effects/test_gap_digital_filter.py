"""Digital filters against SciPy's, which take longer to load than to reckon."""

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

from camrob.gap.effects.commutation_loop import LOOPS, Ripple
from camrob.gap.effects.digital_filter import filtered, sampled


@pytest.mark.parametrize("x", [np.arange(1.0), np.sin(np.arange(50.0)), np.exp(1j * np.arange(50.0) ** 1.3)])
def test_filtered_is_the_recursion(x):
    b, a = np.array([0.3, 0.2, -0.1]), np.array([1.0, -1.1, 0.4])
    assert filtered(b, a, x) == pytest.approx(lfilter(b, a, x), abs=1e-13)


def test_filtered_column_by_column():
    X = np.random.default_rng(0).normal(size=(40, 3))
    b, a = np.array([0.3, 0.1]), np.array([2.0, -1.2])
    assert filtered(b, a, X) == pytest.approx(lfilter(b, a, X, axis=0), abs=1e-13)


@pytest.mark.parametrize("step", [0.002, 0.01])
def test_every_loop_is_sampled_as_scipy_samples_it(step):
    rng = np.random.default_rng(1)
    x = rng.normal(size=2000) + 1j * rng.normal(size=2000)
    for band, hold, integral in LOOPS[1:]:
        system = Ripple(1.0, band, hold, integral, 1.0, 1.0).loop
        b, a, _ = cont2discrete(system, step, method="zoh")
        late = lfilter(np.ravel(b), a, x)
        assert filtered(*sampled(*system, step), x) == pytest.approx(late, abs=1e-8 * np.abs(late).max())
