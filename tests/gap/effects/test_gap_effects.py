"""Every effect of the library: shapes, signs of the contract, and what it predicts held to an independent simulation."""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path

import gap_cases
import numpy as np
import pytest
from gap_cases import generator, kr15, simulated

from camrob.errors import InputError
from camrob.gap.conformance import effect_faults
from camrob.gap.effects.registry import library
from camrob.gap.observation.scene import make_scene
from camrob.gap.observation.signals import derivative, first_order, pieces_of, play
from camrob.measurement.log_info import MeasuredFrame

CONTRACT = {
    "frame_base",
    "frame_tool",
    "frame_table",
    "joint_offset",
    "geometry",
    "track",
    "lean",
    "joint_compliance",
    "payload",
    "backlash",
    "servo_lag",
    "acceleration_error",
    "friction",
    "gear_ripple",
    "wrist_coupling",
    "thermal_drift",
    "corner_rounding",
    "latency",
    "early_reading",
    "cutting_force",
    "measurement_frame",
    "measurement_scale",
    "measurement_drift",
    "turntable",
    "motor_commutation",
    "hysteresis",
    "setpoint_delay",
}
DEG = np.pi / 180.0


def test_the_library_has_the_contracts_names() -> None:
    assert {e.name for e in library()} == CONTRACT
    assert {e.name for e in library(["backlash"])} == CONTRACT - {"backlash"}
    with pytest.raises(InputError, match="is not an effect; use one of"):
        library(["no_such_thing"])


def scene_for(name: str):
    if name == "early_reading":
        return make_scene(simulated(poses=True), kr15())
    if name == "motor_commutation":
        return make_scene(simulated(plant_commutation, rate=1.0 / 0.012), kr15())
    if name == "setpoint_delay":
        return make_scene(simulated(plant_late), kr15())
    if name in ("frame_table", "turntable"):
        log = simulated()
        object.__setattr__(log.info, "measured_frame", MeasuredFrame.BASE)
        return make_scene(log, kr15())
    return make_scene(simulated(), kr15())


@pytest.mark.parametrize("effect", library(), ids=lambda e: e.name)
def test_an_effect_keeps_its_promises(effect) -> None:
    scene = scene_for(effect.name)
    state = {**effect.start, **({"A1_order": 9.0} if effect.name == "gear_ripple" else {})}
    assert effect.units([scene], state) or effect.name == "corner_rounding"
    assert effect_faults(effect, [scene], state) == [] and len(effect.remedy) > 20


def test_the_conformance_suite_can_fail() -> None:
    scene = scene_for("backlash")
    good = next(e for e in library() if e.name == "backlash")
    for change, words in (
        ({"physics": "Play"}, "says no physics"),
        ({"remedy": "Mend it."}, "full stop"),
        ({"stages": ("moon",)}, "names a stage"),
        ({"accuracy": 3.0}, "accurate"),
        ({"name": "other"}, "gives a unit of backlash"),
        ({"columns": lambda s, u, st: ()}, "gives 0 columns"),
        ({"stages": ("setpoint_to_encoder",)}, "without naming that stage"),
    ):
        assert any(words in f for f in effect_faults(replace(good, **change), [scene]))


def plant_link(axis: int, value):
    def apply(world) -> None:
        world.link[:, axis] += value(world)

    return apply


def plant_play(world) -> None:
    world.link[:, 1] += generator.play(world.command[:, 1], 0.03 * DEG)


def plant_commutation(world) -> None:
    world.drive[:, 1] += 2e-5 * np.cos(120.0 * world.command[:, 1])


def plant_late(world) -> None:
    world.drive[:, 2] -= 0.008 * np.gradient(world.command[:, 2], generator.STEP)


def plant_scale(world) -> None:
    world.after[:, 1] += 2e-4 * world.command[:, 6]


def plant_lag(world) -> None:
    u, y = world.command, world.command[0] - 0.026 * np.gradient(world.command, 0.004, axis=0)[0]
    for i in range(len(u)):
        y = y + (0.004 / 0.03) * (u[i] - y)
        world.drive[i] += y - u[i]


def coupled(world):
    return 1e-3 * world.command[:, 3]


PLANTED = {
    # effect: what is planted, {parameter: SI value}, state
    "joint_offset": (plant_link(2, lambda w: 0.05 * DEG), {"A3_deg": 0.05 * DEG}, {}),
    "wrist_coupling": (plant_link(4, coupled), {"A5_by_A4": 1e-3}, {}),
    "gear_ripple": (
        plant_link(0, lambda w: 1e-4 * np.cos(9.0 * w.command[:, 0])),
        {"A1_cos9_deg": 1e-4},
        {"A1_order": 9.0},
    ),
    "backlash": (plant_play, {"A2_deg": 0.03 * DEG}, {"A2_deg": 0.03 * DEG}),
    "frame_base": (
        lambda w: setattr(w, "base", generator.rigid([1e-4, 2e-4, -1e-4, 1e-4, 0, 0])),
        {"x_mm": 1e-4, "y_mm": 2e-4, "z_mm": -1e-4, "rx_deg": 1e-4},
        {},
    ),
    "frame_tool": (
        lambda w: setattr(w, "tool", generator.rigid([1e-4, 2e-4, -1e-4, 0, 0, 1e-4])),
        {"x_mm": 1e-4, "y_mm": 2e-4, "z_mm": -1e-4, "rz_deg": 1e-4},
        {},
    ),
    "latency": (lambda w: setattr(w, "delay", 0.01), {"delay_s": 0.01}, {"delay_s": 0.01}),
    "track": (plant_scale, {"E1_scale": 2e-4}, {}),
    "servo_lag": (plant_lag, {"tau_s": 0.03}, {"lag_s": 0.026, "cycle_s": 0.004}),
    "joint_compliance": (
        lambda w: w.link.__setitem__((slice(None), 1), w.link[:, 1] + 2e-6 * generator.torques(w.command)[:, 1]),
        {"A2_rad_nm": 2e-6},
        {},
    ),
    "lean": (
        lambda w: setattr(w, "lean", 2e-7 * generator.moment(w.command) * np.array([1, 1, 0.0])),
        {"about_x_rad_nm": 2e-7, "about_y_rad_nm": 2e-7},
        {},
    ),
}


@pytest.mark.parametrize("name", PLANTED)
def test_signs_and_sizes_hold_against_an_independent_simulation(name: str) -> None:
    """measured - nominal is what the effect's columns say, times the planted values in the contract's sign and unit."""
    apply, values, state = PLANTED[name]
    scene = make_scene(simulated(apply), kr15())
    effect = next(e for e in library() if e.name == name)
    tcp, servo = np.zeros((len(scene), 6)), np.zeros((len(scene), len(scene.axes)))
    found = set()
    for unit in effect.units([scene], state):
        for column, parameter in zip(effect.columns(scene, unit, state), unit.parameters, strict=True):
            value = values.get(parameter.name, 0.0)
            found |= {parameter.name} if value else set()
            if column.tcp is not None:
                tcp += value * column.tcp
            for axis, signal in column.servo.items():
                servo[:, scene.index(axis)] += value * signal
    assert found == set(values)
    inner = slice(25, -25)
    assert np.sqrt(np.mean(scene.tcp_gap[inner] ** 2)) > 2e-6 or np.abs(servo).max() > 1e-5
    off = np.abs(scene.tcp_gap - tcp)[inner]
    size = np.abs(scene.tcp_gap).max()
    # play differs where its jumps fall between two samples
    worst = np.quantile(off, 0.95) if name == "backlash" else off.max()
    assert worst < 0.02 * size + 1e-8
    assert scene.servo_gap is not None
    assert np.abs(scene.servo_gap - servo)[inner].max() < 0.02 * np.abs(scene.servo_gap).max() + 1e-8


def test_an_axis_lags_its_encoder_by_half_the_play() -> None:
    t = np.arange(0.0, 10.0, 0.02)
    state = play(np.sin(t), t, pieces_of(t), 0.001)
    moving = np.abs(np.cos(t)) > 0.1
    assert np.allclose(state[moving & (t > 0.5)], np.sign(np.cos(t))[moving & (t > 0.5)], atol=1e-6)


def test_a_first_order_lag_follows_a_ramp_by_its_time_constant() -> None:
    t = np.arange(0.0, 4.0, 0.02)
    ramp = 0.3 * t[:, None]
    for cycle in (0.0, 0.004):
        late = first_order(ramp, t, pieces_of(t), 0.05, cycle)
        assert np.allclose(ramp - late, 0.3 * (0.05 - cycle), atol=1e-4)


def test_derivatives_do_not_reach_across_a_hole_in_time() -> None:
    t = np.r_[np.arange(0.0, 1.0, 0.02), np.arange(9.0, 10.0, 0.02)]
    values = np.where(t < 5.0, t, 7.0 - t)[:, None]
    assert len(pieces_of(t)) == 2
    assert np.allclose(derivative(values, t, pieces_of(t))[:, 0], np.where(t < 5.0, 1.0, -1.0))


def test_the_generator_shares_nothing_with_camrob() -> None:
    """The sealed cases' makers import numpy, scipy, the standard library and one another only."""
    own = ("generator", "draws", "field", "maker", "motions", "separable")
    folder = Path(generator.__file__).parent
    for maker in own:
        roots = set()
        for node in ast.walk(ast.parse((folder / f"{maker}.py").read_text())):
            if isinstance(node, ast.Import):
                roots |= {a.name.split(".")[0] for a in node.names}
            elif isinstance(node, ast.ImportFrom):
                roots.add((node.module or "").removeprefix("gap.").split(".")[0])
        assert roots <= {
            "__future__",
            "csv",
            "dataclasses",
            "itertools",
            "json",
            "pathlib",
            "tomllib",
            "numpy",
            "scipy",
            *own,
        }


def test_the_generator_and_the_cell_agree_on_where_the_tool_is() -> None:
    t, command = gap_cases.motion()
    scene = make_scene(simulated(), kr15())
    assert np.abs(scene.tcp_gap).max() < 1e-7
    assert len(t) == len(command)
