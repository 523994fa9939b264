"""Effects as another engineer would describe them: each is still called by its own name, and nothing else is."""

from __future__ import annotations

import numpy as np
import pytest
from gap_cases import generator, kr15, simulated

from camrob.gap.diagnose import diagnose

DEG = np.pi / 180.0


def two_ripples(world) -> None:
    for axis, order in ((0, 36.0), (1, 50.0)):
        world.link[:, axis] += 0.01 * DEG * np.sin(order * world.command[:, axis] + axis)


def eccentric_encoder(world) -> None:
    world.link[:, 1] += 0.03 * DEG * np.sin(world.command[:, 1] + 0.7)


def lag_of_each_axis(world) -> None:
    for axis in range(6):
        u, y = world.command[:, axis], world.command[:, axis].copy()
        share = generator.STEP / (generator.STEP + 0.01 * (1.0 + 0.2 * axis))
        for k in range(1, len(u)):
            y[k] = y[k - 1] + share * (u[k] - y[k - 1])
        world.drive[:, axis] += y - u


def foot_that_warms_up(world) -> None:
    world.after += np.outer(1.0 - np.exp(-world.t / 30.0), [1e-4, -5e-5, 3e-4])


def sagging_track(world) -> None:
    world.after[:, 2] += 2e-3 * (np.cos(np.pi * world.command[:, 6] / 0.8) - 1.0)


def one_soft_axis(world) -> None:
    a = np.gradient(np.gradient(world.command[:, 2], generator.STEP), generator.STEP)
    world.link[:, 2] -= 3e-3 * generator.smooth(a[:, None], 9)[:, 0]


def spring_at_the_tip(world) -> None:
    force = np.stack([60.0 + 40.0 * np.sin(0.5 * world.t + k) for k in range(3)], axis=1)
    world.after += 3e-6 * force


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "apply", "axes"),
    [
        ("gear_ripple", two_ripples, {"A1", "A2"}),
        ("servo_lag", lag_of_each_axis, None),
        ("thermal_drift", foot_that_warms_up, None),
        ("track", sagging_track, {"E1"}),
        ("acceleration_error", one_soft_axis, {"A3"}),
        ("cutting_force", spring_at_the_tip, None),
    ],
)
def test_an_effect_in_other_words_keeps_its_name(name: str, apply, axes: set[str] | None) -> None:
    found = diagnose([simulated(apply, sigma_mm=0.02)], kr15())
    assert found.claimed == (name,)
    assert found.summary.to_json()["status"] == "explained"
    assert found.summary.to_json()["together"]["shrink"] > 0.3
    if axes is not None:
        assert set(found.summary.to_json()["effects"][0]["axes"]) == axes


@pytest.mark.slow
def test_an_eccentric_encoder_of_which_a_part_of_a_turn_is_seen_is_a_course_of_its_axis() -> None:
    """It was a ripple at 78 % at the most; any smooth course of A2 looks so."""
    found = diagnose([simulated(eccentric_encoder, sigma_mm=0.02)], kr15()).summary.to_json()
    assert max((e["probability"] for e in found["effects"]), default=0.0) < 0.8
    assert found["unknown"]["probability"] > 0.9
    assert found["unknown"]["where"]["axes"][:1] == ["A2"] and found["unknown"]["where"]["regimes"][:1] == ["position"]


@pytest.mark.slow
def test_a_rough_description_of_the_drives_hides_nothing_behind_the_encoders() -> None:
    def both(world) -> None:
        v = np.gradient(world.command, generator.STEP, axis=0)
        for axis in (2, 3):
            slow = 1.0 + 0.3 * np.exp(-np.abs(v[:, axis]) / 0.01)
            world.drive[:, axis] -= 0.08 * DEG * np.tanh(v[:, axis] / 0.002) * slow
        world.base = generator.rigid(np.array([4e-5, -3e-5, 3e-5, 2e-5, 2e-5, -3e-5]))

    found = diagnose([simulated(both, sigma_mm=0.02)], kr15())
    assert set(found.claimed) == {"friction", "frame_base"}
