"""Effects of instruments, tables and drives, each described in two ways, held to the physics written down here anew."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import gap_cases
import numpy as np
import pytest
from gap_cases import generator, kr15, poses, simulated
from scipy.spatial.transform import Rotation

from camrob.gap.effects.commutation_loop import Ripple
from camrob.gap.effects.registry import library
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import MeasuredFrame

DEG = np.pi / 180.0
ARM = gap_cases.EDGE


def poses_of(log: MeasurementLog) -> np.ndarray:
    T = np.tile(np.eye(4), (len(log), 1, 1))
    T[:, :3, 3] = 1e-3 * log.matrix("xyz")
    T[:, :3, :3] = Rotation.from_euler("ZYX", log.matrix("abc"), degrees=True).as_matrix()
    return T


def with_poses(log: MeasurementLog, T: np.ndarray, **facts) -> MeasurementLog:
    angles = Rotation.from_matrix(T[:, :3, :3]).as_euler("ZYX", degrees=True)
    columns = (
        dict(log.columns) | dict(zip("xyz", 1e3 * T[:, :3, 3].T, strict=True)) | dict(zip("abc", angles.T, strict=True))
    )
    return MeasurementLog(columns, replace(log.info, **facts), log.path)


def held_to(log: MeasurementLog, name: str, values: dict[str, float], state=None, share=0.02, skip=25) -> None:
    """measured - nominal is what the effect's columns say, times the planted values."""
    scene = make_scene(log, kr15())
    effect = next(e for e in library() if e.name == name)
    tcp, servo, found = np.zeros((len(scene), 6)), np.zeros((len(scene), len(scene.axes))), set()
    for unit in effect.units([scene], state or {}):
        for column, parameter in zip(effect.columns(scene, unit, state or {}), unit.parameters, strict=True):
            value = values.get(parameter.name, 0.0)
            found |= {parameter.name} & set(values)
            if column.tcp is not None:
                tcp += value * column.tcp
            for axis, signal in column.servo.items():
                servo[:, scene.index(axis)] += value * signal
    assert found == set(values)
    inner = slice(skip, -skip) if skip else slice(None)
    for gap, expected in ((scene.tcp_gap, tcp), (scene.servo_gap, servo)):
        if gap is not None and np.abs(expected).max() > 0.0:
            left = (gap - expected)[inner]
            assert np.sqrt(np.mean(left**2)) < share * np.sqrt(np.mean(gap[inner] ** 2)) + 1e-8


def test_a_scale_of_all_lengths_and_one_of_an_axis() -> None:
    log = simulated()
    T = poses_of(log)
    middle = T[:, :3, 3].mean(axis=0)
    for stretch, values in (
        ([2e-4, 2e-4, 2e-4], {"scale": 2e-4}),
        ([3e-4, 2e-4, 2e-4], {"scale": 2e-4 + 1e-4 / 3, "x_beyond": 2e-4 / 3, "y_beyond": -1e-4 / 3}),
    ):
        seen = T.copy()
        seen[:, :3, 3] = middle + (T[:, :3, 3] - middle) * (1.0 + np.array(stretch))
        held_to(with_poses(log, seen), "measurement_scale", values)


def test_an_instrument_that_drifts_and_a_target_that_slips() -> None:
    log = simulated()
    T = poses_of(log)
    share = (log.t - log.t[0]) / np.ptp(log.t)
    moved = np.stack([generator.rigid(s * np.array([2e-4, 0, -1e-4, 0, 3e-5, 0])) for s in share])
    held_to(
        with_poses(log, moved @ T),
        "measurement_drift",
        {"drift_x_mm": 2e-4, "drift_z_mm": -1e-4, "drift_ry_deg": 3e-5},
    )
    slipped = T.copy()
    slipped[400:] = T[400:] @ generator.rigid([1e-4, -2e-4, 0, 0, 0, 1e-4])
    held_to(
        with_poses(log, slipped),
        "measurement_drift",
        {"slip_x_mm": 1e-4, "slip_y_mm": -2e-4, "slip_rz_deg": 1e-4},
    )


def table_seen(moved, steps: int = 240) -> MeasurementLog:
    """Single poses, the table turned step by step to and fro by 300 degrees: measured from the table, which `moved` (N, 4, 4)
    puts elsewhere in the hall.
    """
    t, axis = poses(steps)
    axis = axis.copy()
    axis[:, 7] = 150.0 * DEG * np.sin(np.linspace(0.0, 4.0 * np.pi, steps))
    log = simulated(run=(t, axis), poses=True)
    turned = Rotation.from_euler("z", axis[:, 7:]).as_matrix()
    back = np.tile(np.eye(4), (steps, 1, 1))
    back[:, :3, :3] = turned
    return with_poses(log, back @ np.linalg.inv(moved(axis[:, 7])) @ poses_of(log), measured_frame=MeasuredFrame.BASE)


def test_a_table_that_wobbles_runs_out_and_leans_to_the_side_it_came_from() -> None:
    def harmonic(angle):
        v = np.zeros((len(angle), 6))
        v[:, 3], v[:, 1] = 1e-4 * np.cos(angle), 5e-5 * np.sin(2.0 * angle)
        return np.stack([generator.rigid(x) for x in v])

    held_to(table_seen(harmonic), "turntable", {"E2_rx_cos1_deg": 1e-4, "E2_y_sin2_mm": 5e-5}, skip=0)

    def leaning(angle):
        side = np.sign(np.r_[angle[1] - angle[0], np.diff(angle)])
        return np.stack([generator.rigid([0, 0, 0, 0, 8e-5 * s, 0]) for s in side])

    held_to(table_seen(leaning), "turntable", {"E2_ry_direction_deg": 8e-5}, {"width": 0.01 * DEG}, skip=2)


def test_a_table_measured_from_the_hall_does_not_show() -> None:
    scene = make_scene(simulated(), kr15())
    assert next(e for e in library() if e.name == "turntable").units([scene], {}) == ()


@pytest.mark.parametrize("kind", ["offset", "gain"])
def test_a_motor_whose_torque_ripples(kind: str) -> None:
    """120 periods a turn of A2, found without being told; with a gain that is off, by the load it bears."""
    order = 120.0

    def plant(world) -> None:
        u = world.command[:, 1]
        load = 1.0 if kind == "offset" else generator.torques(world.command)[:, 1]
        world.drive[:, 1] += 2e-5 * np.cos(order * u + 0.4) * load / np.abs(np.max(np.abs(load)))

    scene = make_scene(simulated(plant, rate=1.0 / 0.012), kr15())
    effect = next(e for e in library() if e.name == "motor_commutation")
    (unit,) = effect.units([scene], {})
    assert unit.axis == "A2"
    ripple = Ripple.of(unit.key)
    assert 2.0 * np.pi * ripple.order == pytest.approx(order, rel=5e-3)
    assert ripple.parts[0] == (1.0, "even" if kind == "offset" else "loaded")
    X = np.stack([c.servo["A2"] for c in effect.columns(scene, unit, {})], axis=1)
    y = scene.servo_gap[:, 1]
    left = y - X @ np.linalg.lstsq(X, y, rcond=None)[0]
    assert np.sqrt(np.mean(left**2)) < 0.2 * np.sqrt(np.mean(y**2))


def test_no_motor_ripples_where_there_is_lag_and_friction_alone() -> None:
    def plant(world) -> None:
        v = np.gradient(world.command, generator.STEP, axis=0)
        world.drive -= 0.02 * v + 3e-5 * np.sign(v)

    scene = make_scene(simulated(plant, sigma_mm=0.02), kr15())
    assert next(e for e in library() if e.name == "motor_commutation").units([scene], {}) == ()


def dahl_by_steps(u: np.ndarray, reach: float) -> np.ndarray:
    """Dahl's equation dz/du = (1 - z sign(du)) / reach in many small steps."""
    fine = np.interp(np.arange((len(u) - 1) * 50 + 1) / 50, np.arange(len(u)), u)
    z = np.zeros(len(fine))
    for i in range(1, len(fine)):
        d = fine[i] - fine[i - 1]
        z[i] = z[i - 1] + (1.0 - z[i - 1] * np.sign(d)) * d / reach
    return z[::50]


def maxwell(u: np.ndarray, slips) -> np.ndarray:
    """The force of springs in parallel, each with a slider that gives way at its own stretch, over that stretch."""
    total, stretch = np.zeros(len(u)), np.zeros(len(slips))
    for i in range(1, len(u)):
        stretch = np.clip(stretch + u[i] - u[i - 1], [-s for s in slips], slips)
        total[i] = np.sum(stretch / slips * np.array([1.0, 2.0, 3.0]))
    return total


@pytest.mark.parametrize("kind", ["dahl", "maxwell"])
def test_an_axis_that_winds_up_before_it_slides(kind: str) -> None:
    reach, size = 1.0 * DEG, 1e-4

    def plant(world) -> None:
        u = world.command[:, 1]
        if kind == "dahl":
            world.link[:, 1] -= size * dahl_by_steps(u, reach)
        else:
            world.link[:, 1] -= size * maxwell(u, np.array([0.07, 0.4, 2.2]) * reach)

    values = {"A2_dahl_deg": size} if kind == "dahl" else {f"A2_slip{k}_deg": k * size for k in (1, 2, 3)}
    held_to(simulated(plant), "hysteresis", values, {"reach": reach}, share=0.05, skip=200)


@pytest.mark.parametrize("kind", ["delay", "held"])
def test_an_axis_that_gets_its_setpoints_late_or_seldom(kind: str) -> None:
    late, cycle = 0.008, 0.016

    def plant(world) -> None:
        u = world.command[:, 2]
        when = world.t - late if kind == "delay" else np.floor(world.t / cycle + 1e-9) * cycle
        world.drive[:, 2] += np.interp(when, world.t, u) - u

    values = {"A3_delay_s": late} if kind == "delay" else {"A3_held": 1.0}
    state = {"A3_delay_s": late} if kind == "delay" else {"cycle_s": cycle}
    # a log whose rows are on the bus's grid: rows between would be the generator's own interpolation
    held_to(simulated(plant, rate=1.0 / 0.012), "setpoint_delay", values, state, share=0.05)


@pytest.mark.parametrize("late", [1e-4, 0.15])
def test_an_axis_may_be_late_by_a_tenth_of_a_millisecond_or_by_a_bridge_between_networks(late: float) -> None:
    def plant(world) -> None:
        u, t = world.command[:, 2].copy(), np.arange(len(world.command)) * generator.STEP
        world.drive[:, 2] += np.interp(t - late, t, u) - u

    scene = make_scene(simulated(plant, rate=1.0 / 0.012), kr15())
    effect = next(e for e in library() if e.name == "setpoint_delay")
    units = [u for u in effect.units([scene], {}) if u.key == "delay_s"]
    assert [u.axis for u in units] == ["A3"]
    (parameter,) = units[0].parameters
    assert parameter.upper > late
    assert (late > parameter.common) == (late > 0.1)
    state = {parameter.name: late}
    (column,) = effect.columns(scene, units[0], state)
    x, y = column.servo["A3"][25:-25], scene.servo_gap[25:-25, 2]
    assert float(x @ y / (x @ x)) == pytest.approx(late, rel=0.02)


def test_a_drive_that_lags_a_little_longer_than_the_others_is_no_late_set_point() -> None:
    def plant(world) -> None:
        lags = 0.0018 * np.ones(world.command.shape[1])
        lags[2] += 0.0007
        world.drive -= lags * np.gradient(world.command, generator.STEP, axis=0)

    effect = next(e for e in library() if e.name == "setpoint_delay")
    assert effect.units([make_scene(simulated(plant, rate=1.0 / 0.012), kr15())], {}) == ()


def test_no_axis_is_late_where_all_are_alike_or_only_noise_is_there() -> None:
    def plant(world) -> None:
        rng = np.random.default_rng(5)
        world.drive -= 0.02 * np.gradient(world.command, generator.STEP, axis=0)
        world.drive += rng.normal(0.0, 2e-6, world.drive.shape)

    effect = next(e for e in library() if e.name == "setpoint_delay")
    units = effect.units([make_scene(simulated(plant, rate=1.0 / 0.012), kr15())], {})
    assert [u for u in units if u.axis] == []  # all may be late, which is another thing


@pytest.mark.parametrize("share", [0.01, -0.006])
@pytest.mark.parametrize("stage", ["link", "drive"])
def test_one_axis_that_is_read_early_or_late_at_the_stage_where_it_happens(stage: str, share: float) -> None:
    def plant(world) -> None:
        u = world.command[:, 1]
        back = np.r_[0.0, u[:-1] - u[1:]] * share
        getattr(world, stage)[:, 1] += back

    name = "A2_beyond" if stage == "link" else "A2_drive"
    held_to(simulated(plant, run=poses(), poses=True), "early_reading", {name: share}, skip=0)


def test_a_wrist_whose_coupling_bends() -> None:
    def plant(world) -> None:
        world.link[:, 4] += 1e-3 * world.command[:, 3] + 2e-4 * world.command[:, 3] ** 2

    held_to(simulated(plant), "wrist_coupling", {"A5_by_A4": 1e-3, "A5_by_A4_squared_1_rad": 2e-4})


def test_an_arm_that_grows_by_its_lengths() -> None:
    """Every length of the arm 1.2e-4 longer, ten kelvin above the room: its rows typed in anew, the spindle's own kept."""
    grown = 1.2e-4

    def plant(world) -> None:
        for row in world.rows[:5]:
            row[1], row[2] = row[1] * (1.0 + grown), row[2] * (1.0 + grown)
        world.rows[5][2] -= 0.140 * grown  # of the last row, which ends at the spindle, what is before the plate

    log = simulated(plant)
    warm = MeasurementLog(dict(log.columns) | {"temp": np.full(len(log), 31.0)}, log.info, Path("warm.csv"))
    held_to(warm, "thermal_drift", {"expansion": grown})
