"""Where the unknown sits, though nobody knows what it is: stage, axis, what it follows, and the run that would show it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from gap_cases import generator, kr15, simulated
from test_gap_effects import DEG
from test_gap_where import panel

from camrob.gap.diagnose import diagnose
from camrob.gap.locate.periodic import TIME, periodic
from camrob.measurement.log import MeasurementLog
from camrob.report.diagnosis.bars import place_charts
from camrob.report.diagnosis.sentences import sentence

SIGMA = 0.02
NOISE = np.sqrt(3.0) * SIGMA * 1e-3  # m


def shaking(world) -> None:
    """0.15 mm at 0.8 Hz, wherever the arm is."""
    world.after[:, 1] += 0.15e-3 * np.sin(2.0 * np.pi * 0.8 * world.t)


def pitched(world) -> None:
    """A rack whose every fortieth of the track's travel here is alike."""
    track = world.command[:, 6]
    world.after[:, 0] += 0.15e-3 * np.sin(2.0 * np.pi * 6.0 * (track - track.min()) / np.ptp(track))


def bent(world) -> None:
    """A1 is off by a bump in A2's angle."""
    angle = world.command[:, 1]
    world.link[:, 0] += 0.02 * DEG * np.exp(-4.0 * ((angle - angle.mean()) / angle.std()) ** 2)


def test_what_comes_back_with_the_time_is_reported_with_its_period() -> None:
    found = periodic([panel(simulated(shaking, sigma_mm=SIGMA))], NOISE)
    assert found is not None
    assert found.quantity == TIME
    assert found.period == pytest.approx(1.25, rel=0.01)
    assert found.share > 0.9


def test_what_comes_back_with_an_axis_is_reported_with_that_axis_and_its_period() -> None:
    log = simulated(pitched, sigma_mm=SIGMA)
    found = periodic([panel(log)], NOISE)
    assert found is not None
    assert found.quantity == "E1"
    assert found.period == pytest.approx(1e-3 * np.ptp(log.columns["cE1"]) / 6.0, rel=0.05)
    assert found.share > 0.8


def test_noise_and_a_constant_come_back_with_nothing() -> None:
    for apply in (None, lambda world: world.after.__setitem__((slice(None), 0), 3e-4)):
        found = periodic([panel(simulated(apply, sigma_mm=SIGMA))], NOISE)
        assert found is None or found.share < 0.1


@pytest.mark.slow
def test_a_vibration_is_unknown_follows_the_time_and_is_to_be_seen_at_rest() -> None:
    found = diagnose([simulated(shaking, sigma_mm=SIGMA)], kr15())
    assert found.claimed == ()
    where = found.summary.to_json()["unknown"]["where"]
    assert where["rung"] == "encoder_to_tcp"
    assert where["axes"] == []
    assert where["regimes"] == ["time"]
    assert where["comes_back"].startswith("every 1.25 s")
    summary = found.summary
    assert "comes back every 1.25 s" in sentence(summary)
    # sentence, bars and the next run rest on the same
    chart = next(c for c in place_charts(summary) if c["id"] == "by-regime")
    assert chart["traces"][0]["y"][0] == "time"
    assert "hold the arm at rest" in found.summary.to_json()["next_experiment"]
    assert found.summary.to_json()["experiment"]["expected_mm"][0] == pytest.approx(0.15 / np.sqrt(2.0), rel=0.15)


@pytest.mark.slow
def test_an_axis_that_is_off_by_another_s_angle_is_named_and_another_is_to_be_moved() -> None:
    found = diagnose([simulated(bent, sigma_mm=SIGMA)], kr15())
    where = found.summary.to_json()["unknown"]["where"]
    assert where["axes"][:1] == ["A1"]
    # gravity's torque on A2 is all but a function of its angle
    assert where["regimes"][0] in ("position", "load")
    plan = found.summary.to_json()["experiment"]
    shown = {c["motion"]: c["separation_mm"] for c in plan["considered"]}
    best = max(shown, key=lambda n: shown[n])
    # moving A1 itself would show little; torque on A2, which looks like A2's angle here, moves with A3 too
    assert best in ("one axis A2", "one axis A3")
    assert shown["one axis A1"] < 0.5 * shown[best]
    assert f"run {best.removeprefix('one axis ')} alone through its range" in found.summary.to_json()["next_experiment"]
    assert plan["expected_mm"][0] == pytest.approx(shown[best])


@pytest.mark.slow
def test_each_rival_s_expected_answer_is_reported() -> None:
    def sagging(world) -> None:
        world.link[:, 1] += 2e-6 * generator.torques(world.command)[:, 1]

    found = diagnose([simulated(sagging, sigma_mm=SIGMA)], kr15())
    plan = found.summary.to_json()["experiment"]
    assert all(rms > 0.0 for rms in plan["expected_mm"])
    # the logs tell the two apart already, and no run would tell 1.5 times as much
    sigmas = {c["motion"]: c["separation_sigmas"] for c in plan["considered"]}
    assert max(sigmas.values()) < 1.5 * plan["again_sigmas"]
    first = plan["rivals"][0][0].replace("_", " ")
    assert found.summary.next_experiment.startswith(f"None needed to tell {first} from its closest rival")
    assert found.summary.next_experiment_for == tuple(plan["rivals"][0])


@pytest.mark.slow
@pytest.mark.parametrize(("shakes", "sure"), [(0.06e-3, 0.97), (0.15e-3, 0.78)])
def test_what_is_new_on_a_withheld_log_does_not_cast_doubt_on_a_cause_that_is_far_larger(
    shakes: float, sure: float
) -> None:
    """The foot is off by 0.6 mm on both; on the withheld log alone something shakes: by a fourteenth (rms), or by a sixth,
    beside which a name is likely and no more (`BELIEF.farther`).
    """

    def moved(world) -> None:
        world.after[:, 0] += 0.6e-3

    def moved_and_shaking(world) -> None:
        moved(world)
        world.after[:, 1] += shakes * np.sin(2.0 * np.pi * 0.8 * world.t)

    logs = simulated(moved, sigma_mm=SIGMA), simulated(moved_and_shaking, sigma_mm=SIGMA)
    withheld = MeasurementLog(logs[1].columns, logs[1].info, Path("other.csv"))
    found = diagnose([logs[0]], kr15(), withheld=[withheld])
    assert found.claimed == ("frame_base",)
    # of the sets, and 0.85 of the two that look alike in world
    assert found.summary.to_json()["effects"][0]["probability"] == pytest.approx(sure * 0.85, abs=0.02)
    assert found.summary.to_json()["unknown"]["probability"] > 0.5
