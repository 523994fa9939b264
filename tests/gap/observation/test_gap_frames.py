"""Logs measured on the turning table, single poses, and instruments whose frame is not known."""

from __future__ import annotations

import numpy as np
import pytest
from gap_cases import generator, kr15, poses, simulated

from camrob.gap.diagnose import diagnose
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import MeasuredFrame, Target

SIGMA = 0.02
DEG = np.pi / 180.0


def turning():
    """A run on which the table turns widely, so that its axis shows."""
    t, command = generator.path(np.random.default_rng(8), 40.0, 2.0)
    return t[::10], command[::10]


def on_table(apply=None, **more):
    """A log measured in the turning base."""

    def both(world) -> None:
        world.in_base = True
        if apply is not None:
            apply(world)

    return simulated(both, sigma_mm=SIGMA, run=turning(), measured_frame=MeasuredFrame.BASE, **more)


@pytest.mark.slow
def test_a_log_measured_in_the_base_has_no_gap_where_nothing_is_wrong() -> None:
    found = diagnose([on_table()], kr15())
    assert found.claimed == ()
    assert found.summary.to_json()["status"] == "no gap"
    assert found.summary.to_json()["gap"]["rms_mm"] == pytest.approx(SIGMA * np.sqrt(3), rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("off", "wanted"),
    [
        ([4e-4, -3e-4, 0, 0, 0, 0], {"x_mm": 0.4, "y_mm": -0.3, "rx_deg": 0.0, "ry_deg": 0.0}),
        ([0, 0, 0, 3e-4, -2e-4, 0], {"rx_deg": 3e-4 / DEG, "ry_deg": -2e-4 / DEG}),
    ],
)
def test_the_table_s_axis_off_its_place_is_found_in_the_base_with_its_values(off, wanted) -> None:
    found = diagnose([on_table(lambda w: setattr(w, "table", generator.rigid(off)))], kr15())
    assert found.claimed == ("frame_table",)
    values = {n: p["value"] for n, p in found.summary.to_json()["effects"][0]["parameters"].items()}
    for name, value in wanted.items():
        assert values[name] == pytest.approx(value, rel=0.05, abs=2e-3), name


def test_the_table_s_axis_can_t_be_blamed_where_it_does_not_show() -> None:
    def apply(world) -> None:
        world.table = generator.rigid([4e-4, -3e-4, 0, 3e-4, -2e-4, 0])

    found = diagnose([simulated(apply, sigma_mm=SIGMA, run=turning())], kr15())
    assert found.claimed == ()
    assert found.summary.to_json()["status"] == "no gap"


@pytest.mark.slow
def test_an_instrument_that_is_registered_wrongly_is_told_from_the_robot_s_foot_while_the_table_turns() -> None:
    off = generator.rigid([5e-4, 2e-4, -3e-4, 2e-4, 1e-4, -2e-4])

    def instrument(world) -> None:
        world.instrument = off

    def foot(world) -> None:
        world.base = off

    assert diagnose([on_table(instrument)], kr15()).claimed == ("measurement_frame",)
    assert diagnose([on_table(foot)], kr15()).claimed == ("frame_base",)


@pytest.mark.slow
def test_in_world_the_two_can_t_be_told_apart_and_that_is_said() -> None:
    def foot(world) -> None:
        world.base = generator.rigid([5e-4, 2e-4, -3e-4, 2e-4, 1e-4, -2e-4])

    found = diagnose([simulated(foot, sigma_mm=SIGMA)], kr15())
    assert found.claimed == ("frame_base",)
    assert "measurement_frame" in found.summary.to_json()["effects"][0]["indistinguishable_from"]


@pytest.mark.slow
def test_an_instrument_s_own_frame_is_a_nuisance_and_never_a_cause() -> None:
    def apply(world) -> None:
        world.instrument = generator.rigid([1.2, -0.7, 0.4, 0.3, -0.2, 1.1])
        world.link[:, 2] += 0.06 * DEG

    log = simulated(apply, sigma_mm=SIGMA, measured_frame=MeasuredFrame.UNKNOWN)
    found = diagnose([log], kr15())
    names = {e["effect"] for e in found.summary.to_json()["effects"]}
    assert not names & {"measurement_frame", "frame_base"}
    assert found.summary.to_json()["gap"]["rms_mm"] < 2.0


@pytest.mark.slow
def test_a_reflector_somewhere_on_the_flange_is_a_nuisance_too() -> None:
    def apply(world) -> None:
        world.tool = generator.rigid([0.08, -0.05, 0.12, 0, 0, 0])
        world.link[:, 4] += 1.5e-3 * world.command[:, 3]

    log = simulated(apply, sigma_mm=SIGMA, target=Target.UNKNOWN)
    columns = {n: v for n, v in log.columns.items() if n not in "abc"}
    found = diagnose([MeasurementLog(columns, log.info, log.path)], kr15())
    assert "frame_tool" not in {e["effect"] for e in found.summary.to_json()["effects"]}
    assert "wrist_coupling" in found.claimed


@pytest.mark.slow(after=1)
@pytest.mark.parametrize(
    ("name", "apply"),
    [
        ("joint_offset", lambda w: w.link.__setitem__((slice(None), 2), w.link[:, 2] + 0.06 * DEG)),
        ("early_reading", lambda w: w.link.__iadd__(np.vstack([np.zeros((1, 8)), -4e-4 * np.diff(w.command, axis=0)]))),
        ("", lambda w: None),
    ],
)
def test_single_poses_are_diagnosed_too(name: str, apply) -> None:
    found = diagnose([simulated(apply, sigma_mm=SIGMA, run=poses(), poses=True)], kr15())
    assert found.claimed == ((name,) if name else ())
    if name == "early_reading":
        assert found.summary.to_json()["effects"][0]["parameters"]["share"]["value"] == pytest.approx(4e-4, rel=0.05)
    assert found.summary.to_json()["latency_s"]["value"] is None
    assert found.summary.to_json()["where"]["rungs"]["program_to_setpoint"] is None
