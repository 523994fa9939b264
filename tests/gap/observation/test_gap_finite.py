"""Whatever stands still in a log: the diagnosis says something of it, and never NaN."""

from __future__ import annotations

import warnings
from dataclasses import asdict

import gap_cases
import numpy as np
import pytest
from gap_cells import column, log_of, not_finite
from hypothesis import given, settings
from hypothesis import strategies as st

from camrob.gap.diagnose import diagnose
from camrob.gap.evidence.design import make_panel
from camrob.gap.locate.localise import FURTHER, REGIMES, regimes_of
from camrob.gap.observation.noise import noise_of
from camrob.gap.observation.scene import make_scene


def motion(seconds: float, axes: int) -> tuple[np.ndarray, np.ndarray]:
    t, command = gap_cases.motion()
    at = np.arange(0.3, seconds, 0.04)
    return at, np.stack([np.interp(at, t, command[:, k]) for k in range(axes)], axis=1)


def panel_of(log, cell):
    scene = make_scene(log, cell)
    return make_panel(scene, 0, (), (), {}, noise_of(scene), np.ones(len(scene), bool), 10, 0)


@pytest.mark.slow
def test_a_column_that_lifts_an_arm_with_masses_is_diagnosed() -> None:
    """Gravity's force along a vertical axis is a constant with rounding: no feature, and no NaN (a crash until 2026-11-21)."""
    t, axis = motion(12.0, 7)
    log = log_of(column(), t, axis, {"A3.zero": 1e-3})
    scene = make_scene(log, column())
    force = scene.torque[:, scene.index("E1")]
    assert abs(force[0]) > 1000.0  # N: it bears the arm
    assert np.ptp(force) < 1e-9 * abs(force[0])
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        found = diagnose([log], column())
    assert not_finite(found.summary.to_json()) == []
    assert found.claimed == ("joint_offset",)


@pytest.mark.parametrize("still", [(), (6,), (0, 1, 2), (3, 4, 5, 6), (1, 2, 3, 4, 5, 6)], ids=str)
def test_regimes_are_finite_whatever_stands(still: tuple[int, ...]) -> None:
    t, axis = motion(12.0, 7)
    axis[:, list(still)] = axis[0, list(still)]
    more = {"temp": np.full(len(t), 24.5), **{f"f{n}": np.full(len(t), 40.1) for n in "xyz"}}
    log = log_of(column(), t, axis, {"A1.zero": 1e-3}, more=more)
    found = regimes_of([panel_of(log, column())], 2e-5, (*REGIMES, *FURTHER))
    assert not_finite({name: asdict(share) for name, share in found.items()}) == []
    assert found["temperature"].share == found["force"].share == 0.0


@settings(max_examples=20, deadline=None, derandomize=True)
@given(level=st.floats(1e-9, 1e9), rounding=st.floats(0.0, 1e-11), size=st.floats(1e-3, 1e3))
def test_a_constant_with_rounding_is_no_feature_at_any_size(level: float, rounding: float, size: float) -> None:
    """A share given by temperature is the same whether it is a constant or one with the last digits turning."""
    t, axis = motion(12.0, 7)
    rng = np.random.default_rng(1)
    # a temperature below 200 degrees is what a log may hold; forces may be of any size
    constant = {f"f{n}": level * (1.0 + rounding * rng.normal(size=len(t))) for n in "xyz"}
    log = log_of(column(), t, axis, {"A1.zero": 1e-3}, more=constant)
    panel = panel_of(log, column())
    assert regimes_of([panel], 2e-5, ("force",))["force"].share == 0.0
    follows = {f"f{n}": size * (1.0 + np.sin(0.7 * t + k)) for k, n in enumerate("xyz")}
    varied = panel_of(log_of(column(), t, axis, {"A1.zero": 1e-3}, more=follows), column())
    assert not_finite(asdict(regimes_of([varied], 2e-5, ("force",))["force"])) == []
