"""An instrument whose stand settles while it measures, on an arm of other code: within an hour, and within a minute, which no
stand does.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from stranger_arms import SEVEN, Faults, columns_of, scattered, true_poses

from camrob.cell.read_cell import read_cell
from camrob.gap.diagnose import diagnose
from camrob.gap.effects.measurement_drift import EFFECT
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo


def settling(folder: Path, seconds: float) -> MeasurementLog:
    """45 poses; the readings move by 0.23 mm, two thirds of it within a quarter of the time."""
    t, axis = np.linspace(0.0, seconds, 45), scattered(SEVEN, 45, 7)
    T = true_poses(SEVEN, axis, Faults(), 7)
    share = 1.0 - np.exp(-t / (0.25 * seconds))
    T[:, :3, 3] += share[:, None] * np.array([5e-5, -2.2e-4, 4e-5])
    columns = columns_of(SEVEN, t, axis, T, turned=False, sigma=1.5e-5, seed=7)
    return MeasurementLog(columns, LogInfo(sigma_position=1.5e-5, poses=True), folder / "poses.csv")


def test_a_stand_that_settles_is_the_instruments_and_takes_its_course(tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text(SEVEN.cell)
    said = diagnose([settling(tmp_path, 3600.0)], read_cell(tmp_path)).summary
    (drift,) = said.claimed
    assert drift.effect == "measurement_drift" and not drift.of_machine
    assert said.together.rms_after_mm < 0.05 < 0.1 < said.together.rms_before_mm
    assert "it settled" in said.instrument.text


@pytest.mark.parametrize(("seconds", "offered"), [(3600.0, True), (40.0, False)])
def test_no_stand_settles_within_a_minute(seconds: float, offered: bool, tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text(SEVEN.cell)
    scene = make_scene(settling(tmp_path, seconds), read_cell(tmp_path))
    assert any(u.key == "settling" for u in EFFECT.units([scene], {})) == offered
