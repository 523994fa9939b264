"""Logs that hold no calibration: what was mixed up, or what they can't tell, in one line; nothing is fitted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from calibration_sample import CELL, axis_values, drawn, log_of, measure
from strange_logs import columns_of, poses, seen, write

from camrob.calibration.measurements import measurements_of, postures_of, withheld_rows
from camrob.errors import LogError
from camrob.jobs.calibrate import calibrate
from camrob.measurement.log_info import LogInfo

WRONG = (0, 0.1, -0.15, 0, 0.1, 0)


def columns(count: int = 40):
    q = poses(count, 3)
    return q, columns_of(q, seen(q, wrong_deg=WRONG))


def frozen(c, q):
    return {
        n: np.where((np.arange(40) > 20) & (np.arange(40) < 29), v[20], v) if n in "xyz" else v for n, v in c.items()
    }


def moved(c, q):
    shift = {"x": 18.0, "y": -12.0, "z": 8.0}
    return {n: v + shift.get(n, 0.0) * (np.arange(40) >= 25) for n, v in c.items()}


MIXED_UP = {
    "all in SI": (
        lambda c, q: {n: v / 1000.0 if n in "xyz" else np.radians(v) for n, v in c.items()},
        "log.csv:2: its axis values are in radians and its x, y, z in metres: corrected so",
    ),
    "axes exchanged": (lambda c, q: c | {"A4": c["A5"], "A5": c["A4"]}, "its A4 and A5 are exchanged"),
    "two signs": (lambda c, q: c | {"A4": -c["A4"], "A6": -c["A6"]}, "its A4 and A6 count the other way"),
    "paired one off": (
        lambda c, q: {n: np.roll(v, 1) if n in "xyz" else v for n, v in c.items()},
        "stand one row after",
    ),
    "a part in metres": (
        lambda c, q: {n: np.where(np.arange(40) < 25, v / 1000.0, v) if n in "xyz" else v for n, v in c.items()},
        "its x, y, z are in metres in 25 rows (line 2 to 26), in mm in the others",
    ),
    "an axis that was not logged": (
        lambda c, q: c | {"A2": 0.0 * c["A2"] - 60.0},
        "its A2 stays the same to the last digit",
    ),
    "frozen": (frozen, "log.csv:23: x, y, z stay the same to the last digit in 8 rows"),
    "zeros": (
        lambda c, q: {n: np.where(np.arange(40) % 13 == 5, 0.0, v) if n in "xyz" else v for n, v in c.items()},
        "log.csv:7: x, y, z are 0 to the last digit in 3 rows",
    ),
    "one pose": (
        lambda c, q: c | {n: v[:1].repeat(40) for n, v in c.items() if n[0] == "A"},
        "while every axis stays the same to the last digit",
    ),
    "moved": (moved, "log.csv:27: from this row on its readings lie"),
}


@pytest.mark.parametrize("how", MIXED_UP)
def test_what_was_mixed_up_is_named_and_nothing_is_fitted(tmp_path: Path, how: str) -> None:
    change, said = MIXED_UP[how]
    q, plain = columns()
    write(tmp_path, change(plain, q), ("poses = true",))
    with pytest.raises(LogError) as refused:
        calibrate(tmp_path / "log.csv", cell=tmp_path / "cell", out=tmp_path / "c.toml")
    assert said in str(refused.value) and not (tmp_path / "c.toml").exists()


def test_six_postures_are_six_however_often_they_were_measured(tmp_path: Path) -> None:
    q = np.repeat(poses(6, 3), 10, axis=0)
    write(tmp_path, columns_of(q, seen(q, wrong_deg=WRONG)), ("poses = true",))
    with pytest.raises(LogError, match="holds 60 rows of 6 postures"):
        calibrate(tmp_path / "log.csv", cell=tmp_path / "cell", out=tmp_path / "c.toml")


def test_axes_that_stand_still_are_named(tmp_path: Path) -> None:
    q = np.repeat(poses(1, 3), 30, axis=0)
    q[:, 0] = np.linspace(-1.5, 1.5, 30)
    write(tmp_path, columns_of(q, seen(q, wrong_deg=WRONG)), ("poses = true",))
    found = calibrate(tmp_path / "log.csv", cell=tmp_path / "cell", out=tmp_path / "c.toml")
    assert any(w.startswith("A2, A3, A4, A5, A6 stand still in these poses") for w in found.calibration.warnings)


@pytest.mark.parametrize("how", ["turns", "drifts"])
def test_what_follows_the_order_of_the_rows_is_said(tmp_path: Path, how: str) -> None:
    _, c = columns(60)
    row = np.arange(60)
    by = 0.3 * (row % 2) if how == "turns" else 1.2 * row / 59
    write(tmp_path, c | {"x": c["x"] + by}, ("poses = true",))
    found = calibrate(tmp_path / "log.csv", cell=tmp_path / "cell", out=tmp_path / "c.toml").calibration.warnings
    words = "every second reading of log.csv lies 0." if how == "turns" else "readings of log.csv drift by 1."
    assert any(w.startswith(words) for w in found), found


def test_all_rows_of_a_posture_are_withheld_together() -> None:
    """Jitter of encoders parts no posture, and postures are numbered as they come."""
    values = np.repeat(axis_values(CELL, 20), 5, axis=0)
    values = values + np.random.default_rng(0).normal(0.0, 1e-5, values.shape)
    data = measurements_of(log_of(CELL, measure(CELL, drawn(CELL), values), LogInfo(poses=True)), CELL)
    which = postures_of(data)
    assert which.tolist() == np.repeat(np.arange(20), 5).tolist()
    (mask,) = withheld_rows([data], 0.2)
    assert mask.sum() == 20 and all(len(set(mask[which == k])) == 1 for k in range(20))
