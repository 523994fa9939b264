"""ISO 9283 and ISO 230-4 figures on runs whose errors are known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from gap_cases import kr15

from camrob.gap.diagnose import diagnose
from camrob.gap.locate.path_standards import Circle, Line, path_standards, shape_of
from camrob.measurement.read_log import read_log

SAMPLES = Path(__file__).resolve().parents[4] / "shared" / "gap_samples"


def line(cycles: int = 5, n: int = 200) -> np.ndarray:
    """There and back along 300 mm, a row a sample."""
    there = np.linspace(0.0, 0.3, n)
    s = np.concatenate([np.r_[there, there[::-1]] for _ in range(cycles)])
    return np.array([0.5, 0.1, 0.2]) + s[:, None] * np.array([0.6, 0.8, 0.0])


def circle(n: int = 1200, direction: int = 1, radius: float = 0.15) -> tuple[np.ndarray, np.ndarray]:
    angle = direction * np.linspace(0.0, 2.0 * np.pi, n)
    return angle, np.stack([0.4 + radius * np.cos(angle), radius * np.sin(angle), np.full(n, 0.1)], axis=1)


def test_shapes_are_told_from_other_paths() -> None:
    assert isinstance(shape_of(line()), Line)
    found = shape_of(circle()[1])
    assert isinstance(found, Circle)
    assert found.radius == pytest.approx(0.15, abs=1e-6)
    t = np.linspace(0.0, 6.0, 900)
    assert shape_of(np.stack([0.1 * np.cos(t), 0.1 * np.sin(t), 0.01 * t], axis=1)) is None
    assert shape_of(circle()[1][:800]) is None  # no full turn
    assert shape_of(np.tile([[0.1, 0.2, 0.3]], (400, 1))) is None


def test_path_accuracy_of_a_line_is_its_mean_s_and_repeatability_its_scatter_s() -> None:
    path = line()
    cycle = np.arange(len(path)) // 400
    across = np.array([-0.8, 0.6, 0.0])
    offset = 1e-4 + 1e-5 * (cycle - 2)  # 0.1 mm off, every cycle 0.01 mm more
    error = offset[:, None] * across + 5e-4 * np.array([0.6, 0.8, 0.0])  # what is along the path does not count
    said = path_standards("run", path, error, np.zeros_like(error))
    assert said is not None
    found = said.to_json()
    assert found["standard"] == "ISO 9283"
    forward = found["before"]["forward"]
    assert forward["cycles"] == found["before"]["back"]["cycles"] == 5
    assert forward["AT_mm"] == pytest.approx(0.1, abs=1e-6)
    apart = np.abs(np.arange(5) - 2.0) * 0.01
    assert forward["RT_mm"] == pytest.approx(apart.mean() + 3.0 * apart.std(ddof=1), abs=1e-6)
    assert found["after"]["forward"]["AT_mm"] == pytest.approx(0.0, abs=1e-9)


def test_circular_deviation_of_an_oval_and_of_a_reversal() -> None:
    parts = [circle(direction=1), circle(direction=-1)]
    angle, path = (np.concatenate([p[k] for p in parts]) for k in (0, 1))
    back = np.arange(len(angle)) >= 1200
    radial = 2e-5 * np.cos(2.0 * angle) + 3e-5 + np.where(back, 1e-5, 0.0)
    error = radial[:, None] * np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    error[:, 0] += 5e-5  # a shift of the centre is no form error
    said = path_standards("run", path, error, np.zeros_like(error))
    assert said is not None
    found = said.to_json()
    before = found["before"]
    assert found["radius_mm"] == pytest.approx(150.0, abs=1e-3)
    assert before["ccw"]["G_mm"] == pytest.approx(0.04, abs=1e-3)
    assert before["cw"]["G_mm"] == pytest.approx(0.04, abs=1e-3)
    assert before["G_b_mm"] == pytest.approx(0.05, abs=1e-3)
    assert before["H_mm"] == pytest.approx(0.01, abs=1e-3)
    assert before["F_max_mm"] == pytest.approx(0.02 + 0.03 + 0.01 + 0.05, abs=2e-3)


@pytest.mark.slow
def test_a_measured_circle_of_a_sample_is_reported_by_the_standard() -> None:
    file = SAMPLES / "cases" / "c_backlash" / "circle1.csv"
    if not file.is_file():
        pytest.skip("../shared is not here: no labelled samples")
    found = diagnose([read_log(file)], kr15())
    standard = found.summary.to_json()["standards"][0]
    assert standard["standard"] == "ISO 230-4"
    assert standard["radius_mm"] == pytest.approx(150.0, abs=0.05)
    assert 0.0 < standard["before"]["ccw"]["G_mm"] < 1.0
