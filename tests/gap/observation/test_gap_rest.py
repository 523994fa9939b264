"""Play of an axis that starts at rest: its side is unknown until it has moved, and that is no unknown effect."""

from __future__ import annotations

import numpy as np
import pytest
from gap_cases import generator, kr15, motion, simulated

from camrob.gap.diagnose import diagnose
from camrob.gap.effects.acceleration_error import EFFECT as ACCELERATION
from camrob.gap.effects.backlash import EFFECT
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog

SIGMA = 0.02
WIDTH = np.deg2rad(0.04)
STEP, REST = 0.04, 10.0


def resting(axis: int, *, same_side: bool = False) -> MeasurementLog:
    """10 s of rest, then 40 s of motion; the play of an axis lies on the side that the motion does not take up at first."""
    t, command = motion(5)
    thin = slice(None, None, 10)
    still = int(REST / STEP)
    times = STEP * np.arange(still + len(t[thin]))
    run = np.concatenate([np.repeat(command[:1], still, 0), command[thin]])

    def apply(world) -> None:
        u, half = world.command[:, axis], WIDTH / 2
        first = np.sign(u[np.flatnonzero(np.abs(u - u[0]) > half)[0]] - u[0])
        x = u[0] - half * first if same_side else u[0] + half * first
        for i in range(len(u)):
            x = min(max(x, u[i] - half), u[i] + half)
            world.link[i, axis] += x - u[i]

    return simulated(apply, sigma_mm=SIGMA, run=(times, run))


def test_until_an_axis_has_moved_by_its_play_nothing_is_known_of_its_side() -> None:
    scene = make_scene(resting(1), kr15())
    unit = next(u for u in EFFECT.units([scene], {}) if u.axis == "A2")
    (column,) = EFFECT.columns(scene, unit, {"A2_deg": WIDTH})
    assert column.doubt is not None
    u = scene.link[:, scene.index("A2")]
    known = np.flatnonzero(column.doubt == 0.0)
    assert (column.doubt[: known[0]] > 1.0).all()
    assert (column.doubt[known[0] :] == 0.0).all()
    assert known[0] > REST / STEP - 10
    assert np.ptp(u[: known[0]]) <= WIDTH < np.ptp(u[: known[0] + 1])
    # together they weigh like one sample that may lie on either side
    assert np.sum(1.0 / column.doubt[: known[0]] ** 2) == pytest.approx(0.25)


@pytest.mark.slow
@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("same_side", [False, True])
def test_a_log_that_begins_at_rest_shows_play_and_nothing_unknown(axis: int, same_side: bool) -> None:
    found = diagnose([resting(axis, same_side=same_side)], kr15())
    assert found.claimed == ("backlash",)
    entry = found.summary.to_json()["effects"][0]
    assert entry["axes"] == [f"A{axis + 1}"]
    assert entry["parameters"][f"A{axis + 1}_deg"]["value"] == pytest.approx(0.04, rel=0.05)
    assert found.summary.to_json()["status"] == "explained"
    assert found.summary.to_json()["unknown"]["probability"] < 0.2


@pytest.mark.slow
def test_what_was_withheld_leaves_the_unknown_side_out() -> None:
    found = diagnose([simulated_play()], kr15(), withheld=[resting(1)])
    assert found.summary.to_json()["together"]["shrink"] > 0.8
    assert found.summary.to_json()["unknown"]["probability"] < 0.2


def simulated_play() -> MeasurementLog:
    def apply(world) -> None:
        world.link[:, 1] += generator.play(world.command[:, 1], WIDTH)

    return simulated(apply, sigma_mm=SIGMA, seed=7)


def test_accelerations_between_samples_are_doubted_where_they_are_not_resolved_and_nowhere_else() -> None:
    """A path that turns round at once, sampled every 80 ms, and a smooth one."""
    t = 0.08 * np.arange(500)
    smooth = np.deg2rad([0, -90, 90, 0, 60, 0, 0, 0.0]) + np.zeros((500, 8))
    smooth[:, 0] += 0.3 * np.sin(0.5 * t)
    sharp = smooth.copy()
    sharp[:, 1] += 0.1 * np.abs((t % 8.0) - 4.0)
    for axis, few in ((smooth, False), (sharp, True)):
        scene = make_scene(simulated(run=(t, axis)), kr15())
        unit = next(u for u in ACCELERATION.units([scene], {}) if u.key == "arm" and not u.axis)
        (column,) = ACCELERATION.columns(scene, unit, {})
        assert column.doubt is not None
        unknown = np.flatnonzero(column.doubt >= 1.0)
        assert (len(unknown) > 0) == few
        assert len(unknown) <= 50
        assert all(np.abs((t[k] + 2.0) % 4.0 - 2.0) < 0.5 for k in unknown)


def test_a_log_that_does_not_resolve_accelerations_anywhere_leaves_nothing_aside() -> None:
    rng = np.random.default_rng(0)
    t = 0.08 * np.arange(500)
    axis = np.deg2rad([0, -90, 90, 0, 60, 0, 0, 0.0]) + rng.normal(0, 1e-4, (500, 8))
    axis[:, 0] += 0.3 * np.sin(0.05 * t)
    scene = make_scene(simulated(run=(t, axis)), kr15())
    unit = next(u for u in ACCELERATION.units([scene], {}) if u.key == "tip")
    (column,) = ACCELERATION.columns(scene, unit, {})
    assert column.doubt is not None
    assert column.doubt.max() < 1.0
    assert np.median(column.doubt) > 0.5
