"""Friction's error at a drive takes its own course from axis to axis; loops are integrated here, apart from the effect's code."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from stranger_arms import ONE, text

from camrob.cell.read_cell import read_cell
from camrob.gap.diagnose import diagnose
from camrob.gap.effects.friction_course import Course, friction_course
from camrob.gap.observation.scene import Scene, make_scene
from camrob.measurement.log import MeasurementLog
from camrob.measurement.read_log import read_log

FINE, EVERY, NOISE = 0.001, 20, 2e-4  # s; a row is logged every so many of these; degrees


def wandering(seed: int, seconds: float = 60.0) -> np.ndarray:
    """(N,) degrees: moves of some 5 to 30 degrees without a pause, on the fine clock."""
    rng = np.random.default_rng(seed)
    knots = rng.uniform(-30, 30, 18)
    t = np.arange(0.0, seconds, FINE)
    return np.interp(t, np.linspace(0, seconds, 18), knots) + 2.0 * np.sin(0.9 * t)


def torque(v: np.ndarray, *, stribeck: float = 0.0, at: float = 2.0) -> np.ndarray:
    """Dry friction over speed (degrees a second), Coulomb's part 1."""
    return np.tanh(v / 0.05) * (1.0 + stribeck * np.exp(-((v / at) ** 2)))


def behind(force: np.ndarray, *, opens: float, integral: float | None) -> np.ndarray:
    """What a loop leaves of a force: it gives way within `opens` s, and an integral part takes it back within `integral` s."""
    out, given, held = np.empty(len(force)), force[0], force[0]
    for k, f in enumerate(force):
        given += (f - given) * FINE / opens
        held += (given - held) * FINE / (integral or np.inf)
        out[k] = given - held if integral else given
    return out


def log_of(folder: Path, command: np.ndarray, error: np.ndarray) -> MeasurementLog:
    """A log of one axis, both ends of its drive."""
    rng = np.random.default_rng(1)
    encoder = (command + error)[::EVERY]
    encoder = encoder + rng.normal(0.0, NOISE, len(encoder))
    (folder / "cell.toml").write_text(ONE.cell)
    columns = {"t": np.arange(len(encoder)) * FINE * EVERY, "A1": encoder, "cA1": command[::EVERY]}
    (folder / "log.csv").write_text(text(columns))
    (folder / "log.toml").write_text(f"sigma_axis_deg = {NOISE}\n")
    return read_log(folder / "log.csv")


def fitted(scene: Scene, course: Course) -> tuple[dict[str, float], float]:
    """Sizes in degrees by part, and the share of the error's energy beside lag that they leave."""
    v = scene.velocity(scene.command)
    beside = np.concatenate([np.ones_like(v), v, scene.velocity(scene.command, 2)], axis=1)
    own = -course.columns(scene, "A1")
    assert scene.servo_gap is not None
    y = scene.servo_gap[:, 0]
    X = np.concatenate([own, beside], axis=1)
    values = np.linalg.lstsq(X, y, rcond=1e-10)[0]
    alone = y - beside @ np.linalg.lstsq(beside, y, rcond=1e-10)[0]
    left = float(np.sum((y - X @ values) ** 2) / np.sum(alone**2))
    return dict(zip(course.parts, np.rad2deg(values).tolist(), strict=False)), left


def scene_of(folder: Path, error, seed: int = 3) -> Scene:
    command = wandering(seed)
    v = np.gradient(command, FINE)
    return make_scene(log_of(folder, command, error(v)), read_cell(folder))


def test_what_stands_stands_and_does_not_decay(tmp_path: Path) -> None:
    scene = scene_of(tmp_path, lambda v: -0.02 * behind(torque(v), opens=0.005, integral=None))
    course = friction_course([scene], "A1")
    sizes, left = fitted(scene, course)
    assert sizes["constant"] == pytest.approx(0.02, rel=0.03)
    assert abs(sizes["peak"]) * np.exp(-0.1 / course.decay) < 5e-4  # a tenth of a second later
    assert left < 0.02


@pytest.mark.parametrize("decay", [0.06, 0.25, 0.7])
def test_a_peak_decays_in_its_own_time(decay: float, tmp_path: Path) -> None:
    scene = scene_of(tmp_path, lambda v: -0.03 * behind(torque(v), opens=0.005, integral=decay))
    course = friction_course([scene], "A1")
    sizes, left = fitted(scene, course)
    assert course.decay == pytest.approx(decay, rel=0.35)
    assert sizes["peak"] == pytest.approx(0.03, rel=0.3)
    assert abs(sizes["constant"]) < 0.003
    assert left < 0.12  # rows are 20 ms apart


def test_what_falls_with_speed_is_found_where_it_does_and_not_elsewhere(tmp_path: Path) -> None:
    falling = scene_of(tmp_path, lambda v: -0.02 * behind(torque(v, stribeck=0.8, at=4.0), opens=0.005, integral=None))
    course = friction_course([falling], "A1")
    sizes, left = fitted(falling, course)
    assert sizes["constant"] == pytest.approx(0.02, rel=0.1)
    assert sizes["stribeck"] == pytest.approx(0.016, rel=0.35)
    assert np.rad2deg(course.falls) == pytest.approx(4.0, rel=0.6)
    assert left < 0.03
    level = scene_of(tmp_path, lambda v: -0.02 * behind(torque(v), opens=0.005, integral=None))
    assert "stribeck" not in friction_course([level], "A1").parts


def test_a_drive_without_friction_has_no_course_that_explains(tmp_path: Path) -> None:
    scene = scene_of(tmp_path, lambda v: -0.02 * v)
    _, left = fitted(scene, friction_course([scene], "A1"))
    assert left > 0.95


def test_a_course_says_itself_in_a_units_key() -> None:
    course = Course(0.0, 1e-4, 0.25, 0.02, 0.03, 12.0)
    assert Course.of(course.key) == course
    assert course.parts == ("constant", "peak", "second_peak", "stribeck", "loaded")
    assert Course(1e-3, 1e-4).parts == ("constant", "peak", "held")


def test_friction_that_stands_moves_no_lag(tmp_path: Path) -> None:
    """A lag of 15 ms planted with it is found as it is where there is none, within two standard errors, and friction is named."""
    command = wandering(5)
    v = np.gradient(command, FINE)
    lag = behind(command, opens=0.015, integral=None) - command
    found = []
    for friction in (0.0, 0.02):
        error = lag - friction * behind(torque(v, stribeck=0.5), opens=0.005, integral=None)
        said = diagnose([log_of(tmp_path, command, error)], read_cell(tmp_path)).summary
        found.append({e.effect: e for e in said.claimed})
    alone, both = found
    assert set(alone) == {"servo_lag"}
    assert set(both) == {"servo_lag", "friction"}
    one, other = (f["servo_lag"].parameters["tau_s"] for f in (alone, both))
    assert abs(one.value - other.value) < 2.0 * max(one.std, other.std) + 0.02 * one.value
    assert both["friction"].parameters["A1_constant_deg"].value == pytest.approx(0.02, rel=0.15)


def test_what_turns_over_as_slowly_as_the_axis_moves_is_no_friction(tmp_path: Path) -> None:
    """A drive that falls behind with the square of its speed, less what follows the speed, is a side with the widest edge."""
    command = 0.3 * wandering(3)
    speed = np.gradient(command, FINE)
    scene = make_scene(log_of(tmp_path, command, -1e-4 * speed * np.abs(speed)), read_cell(tmp_path))
    reached = np.percentile(np.abs(scene.velocity(scene.command)), 95)
    assert friction_course([scene], "A1").rest <= 0.25 * reached
