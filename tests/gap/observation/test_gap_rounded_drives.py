"""Set-points and encoders of few decimals, and set-points that a program made of the encoder's values. Simulated."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from stranger_arms import ONE, text

from camrob.cell.read_cell import read_cell
from camrob.errors import LogError
from camrob.gap.observation.noise import noise_of
from camrob.gap.observation.scene import make_scene
from camrob.jobs.diagnose import diagnose
from camrob.measurement.read_log import read_log

STEP, TAU = 0.05, 0.04  # s


def driven(tau: float = TAU, step: float = STEP, seconds: float = 40.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, set-points of an axis that goes to and fro at many speeds, and where a drive of first order is; degrees."""
    fine = np.arange(0.0, seconds, 1e-3)
    rng = np.random.default_rng(5)
    speed = rng.uniform(-60, 60, len(fine) // 2000 + 1).repeat(2000)[: len(fine)]
    told = np.cumsum(np.convolve(speed, np.ones(200) / 200, "same"))
    told, at = 1e-3 * told, np.empty_like(told)
    at[0] = told[0]
    for k in range(1, len(told)):
        at[k] = at[k - 1] + 1e-3 / tau * (told[k] - at[k - 1])
    every = round(step / 1e-3)
    return fine[::every], told[::every], at[::every]


def written(folder: Path, t: np.ndarray, told: np.ndarray, at: np.ndarray) -> Path:
    (folder / "cell.toml").write_text(ONE.cell)
    (folder / "log.csv").write_text(text({"t": t, "A1": at, "cA1": told}))
    return folder / "log.csv"


def test_what_rounding_leaves_between_set_point_and_encoder_is_noise(tmp_path: Path) -> None:
    """Whole degrees of both leave sqrt(2 / 12) degrees, as by hand; the lag is found in it, and no more is left to explain."""
    t, told, at = driven()
    log = written(tmp_path, t, np.round(told), np.round(at))
    noise = noise_of(make_scene(read_log(log), read_cell(tmp_path))).servo
    assert np.rad2deg(noise[0]) == pytest.approx(np.sqrt(2.0 / 12.0), rel=0.25)
    diagnose(cell=tmp_path, log=[log], out=tmp_path / "out")
    said = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert [e["effect"] for e in said["effects"] if e["probability"] >= 0.5][:1] in (["servo_lag"], ["setpoint_delay"])
    assert said["unknown"]["probability"] < 0.5


def test_more_decimals_leave_the_noise_what_it_is(tmp_path: Path) -> None:
    t, told, at = driven()
    fine = noise_of(make_scene(read_log(written(tmp_path, t, told, at)), read_cell(tmp_path))).servo
    assert np.rad2deg(fine[0]) < 0.05


def test_a_cycle_far_below_the_sampling_is_none_of_the_lag(tmp_path: Path) -> None:
    """7.6 ms at 10 Hz were 20, as 12 of them were a drive's cycle: of that nothing shows in such rows."""
    t, told, at = driven(0.0076, 0.1, 7.0)
    log = written(tmp_path, t, np.round(told, 3), np.round(at, 3))
    diagnose(cell=tmp_path, log=[log], out=tmp_path / "out")
    said = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    (lag,) = (e for e in said["effects"] if e["effect"] == "servo_lag")
    assert lag["parameters"]["tau_s"]["value"] == pytest.approx(0.0076, abs=1e-3)


def test_set_points_that_a_program_made_of_the_encoders_values_are_refused(tmp_path: Path) -> None:
    """A part of the way to the goal from where the axis is: what lies between is the program's, not the drive's."""
    t, _, at = driven()
    told = np.concatenate([at[:1], 0.975 * at[:-1] + 1.0])
    log = written(tmp_path, t[1:], told[1:], at[1:])
    with pytest.raises(LogError, match=r"its cA1 is reckoned from A1 a row before \(0\.975 of it and a constant\)"):
        diagnose(cell=tmp_path, log=[log], out=tmp_path / "out")
