"""The ripple of a motor's torque behind a drive's loop; cascades are integrated here by steps, apart from the effect's code."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from stranger_arms import ONE, text

from camrob.cell.read_cell import read_cell
from camrob.gap.effects.commutation_loop import LOOPS, Ripple
from camrob.gap.effects.commutation_search import commutation
from camrob.gap.effects.registry import library
from camrob.gap.observation.scene import Scene, make_scene
from camrob.measurement.read_log import read_log

FINE, EVERY, NOISE = 0.0005, 40, 2e-4  # s; a row is logged every so many of these; degrees
ORDER = 300.0  # cycles a turn
DEG = np.pi / 180.0


def wandering(seed: int, seconds: float = 40.0) -> np.ndarray:
    """(N,) degrees on the fine clock: slow and fast moves both ways, without corners."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, FINE)
    return sum(
        a * np.sin(w * t + p) for a, w, p in zip((12.0, 5.0, 2.0), (0.23, 0.6, 1.4), rng.uniform(0, 6, 3), strict=True)
    )


def cascade(command: np.ndarray, torque, *, band: float, hold: float, integral: float) -> np.ndarray:
    """(N,) rad by which an axis strays: J dv = torque + band (r + integral of r), r = -hold x - v; J = 1, so torque in rad/s2."""
    x = v = held = 0.0
    out = np.empty(len(command))
    for k, u in enumerate(command):
        out[k] = x
        asked = -hold * x - v
        held += FINE * integral * asked
        v += FINE * (torque(k, u * DEG + x) + band * (asked + held))
        x += FINE * v
    return out


def scene_of(folder: Path, command: np.ndarray, error: np.ndarray) -> Scene:
    """A log of one axis whose drive strays by an error (N,) in rad."""
    rng = np.random.default_rng(1)
    encoder = (command + error / DEG)[::EVERY]
    encoder = encoder + rng.normal(0.0, NOISE, len(encoder))
    (folder / "cell.toml").write_text(ONE.cell)
    columns = {"t": np.arange(len(encoder)) * FINE * EVERY, "A1": encoder, "cA1": command[::EVERY]}
    (folder / "log.csv").write_text(text(columns))
    (folder / "log.toml").write_text(f"sigma_axis_deg = {NOISE}\n")
    return make_scene(read_log(folder / "log.csv"), read_cell(folder))


def left_of(scene: Scene, ripple: Ripple) -> float:
    """Share of the error's energy that a ripple leaves."""
    waves = ripple.waves(scene, "A1", ripple.parts)
    X, y = np.concatenate([waves.real, waves.imag]).T, scene.servo_gap[:, 0]
    return float(np.sum((y - X @ np.linalg.lstsq(X, y, rcond=None)[0]) ** 2) / np.sum(y**2))


@pytest.mark.parametrize(("hold", "integral"), [(12.0, 0.0), (12.0, 25.0), (40.0, 10.0)])
def test_a_loop_answers_a_wave_as_its_equations_of_motion_do(hold: float, integral: float) -> None:
    """States x, v and the integral: (jw - A)^-1 times the torque, solved here."""
    band = 90.0
    A = np.array([[0.0, 1.0, 0.0], [-band * hold, -band, band], [-integral * hold, -integral, 0.0]])
    ripple = Ripple(1.0, band, hold / band, integral / band, 1.0, 1.0)
    for w in (3.0, 20.0, 90.0, 400.0):
        moved = np.linalg.solve(1j * w * np.eye(3) - A, [0.0, 1.0, 0.0])[0]
        assert ripple.at_once(1.0, np.array([w / (2 * np.pi)]))[0] == pytest.approx(band**2 * moved, rel=1e-9)


def test_an_integral_part_holds_slow_ripple_and_no_loop_follows_fast_ripple() -> None:
    pure = Ripple(1.0, 90.0, 0.2, 0.0, 1.0, 1.0)
    held = Ripple(1.0, 90.0, 0.2, 0.3, 1.0, 1.0)
    slow, middle, fast = np.array([0.05]), np.array([5.0]), np.array([200.0])
    assert abs(pure.at_once(1.0, slow)[0]) > abs(pure.at_once(1.0, middle)[0]) > 30 * abs(pure.at_once(1.0, fast)[0])
    assert abs(held.at_once(1.0, slow)[0]) < 0.1 * abs(held.at_once(1.0, middle)[0])
    # the other way round it turns the other way
    assert held.at_once(1.0, -middle)[0] == pytest.approx(np.conj(held.at_once(1.0, middle)[0]))


@pytest.mark.parametrize("loop", [(80.0, 0.2, 0.0), (40.0, 1 / 12, 1 / 3)])
def test_what_goes_through_in_time_is_the_steady_answer_at_one_speed(loop, tmp_path: Path) -> None:
    assert loop in LOOPS
    command = 4.0 * np.arange(0.0, 8.0, FINE) - 16.0
    scene = scene_of(tmp_path, command, np.zeros(len(command)))
    ripple = Ripple(ORDER / (2 * np.pi), *loop, 1.0, 1.0)
    wave = ripple.waves(scene, "A1", [(1.0, "even")])[0]
    steady = ripple.at_once(ripple.order, np.array([4.0 * DEG]))[0] * np.exp(1j * ORDER * command[::EVERY] * DEG)
    settled = slice(150, -5)
    assert np.abs(wave - steady)[settled].max() < 0.05 * np.abs(steady).max()


@pytest.mark.parametrize(
    ("band", "hold", "integral"), [(60.0, 12.0, 0.0), (250.0, 20.0, 0.0), (100.0, 10.0, 30.0), (300.0, 60.0, 40.0)]
)
def test_a_ripple_is_found_behind_any_loop(band: float, hold: float, integral: float, tmp_path: Path) -> None:
    command = wandering(3)

    def torque(k: int, u: float) -> float:
        return float(0.01 * DEG * band * 20.0 * np.sin(ORDER * u + 0.7))

    scene = scene_of(tmp_path, command, cascade(command, torque, band=band, hold=hold, integral=integral))
    ripple = commutation([scene], "A1")
    assert ripple is not None
    assert 2.0 * np.pi * ripple.order == pytest.approx(ORDER, rel=5e-4)
    assert (1.0, "even") in ripple.parts
    still = Ripple(ripple.order, 0.0, 0.0, 0.0, 1.0, 1.0, ((1.0, "even"),))
    assert left_of(scene, ripple) < min(
        0.12, 0.5 * left_of(scene, still)
    )  # half of what one phase for all speeds leaves


def test_once_and_twice_are_found_together(tmp_path: Path) -> None:
    command = wandering(5)

    def torque(k: int, u: float) -> float:
        return float(0.2 * DEG * 100.0 * (np.sin(ORDER * u) + 0.8 * np.sin(2.0 * ORDER * u + 1.0)))

    scene = scene_of(tmp_path, command, cascade(command, torque, band=100.0, hold=15.0, integral=0.0))
    ripple = commutation([scene], "A1")
    assert ripple is not None
    found = sorted(2.0 * np.pi * ripple.order * times for times, _ in ripple.parts)
    assert found == pytest.approx([ORDER, 2.0 * ORDER], rel=5e-4)
    assert left_of(scene, ripple) < 0.15


def test_lag_friction_and_a_slow_wave_of_time_are_no_ripple(tmp_path: Path) -> None:
    command = wandering(7)
    t, v = np.arange(len(command)) * FINE, np.gradient(command, FINE)
    error = DEG * (-0.02 * v - 0.01 * np.tanh(v / 0.1) + 0.004 * np.sin(2.1 * t))
    scene = scene_of(tmp_path, command, error)
    assert commutation([scene], "A1") is None
    assert next(e for e in library() if e.name == "motor_commutation").units([scene], {}) == ()


def test_a_ripple_says_itself_in_a_units_key() -> None:
    ripple = Ripple(47.75, 80.0, 0.2, 0.0, 0.5, 12.0, ((0.5, "even"), (1.0, "loaded")))
    assert Ripple.of(ripple.key) == ripple
