"""What strangers' logs hold, and their cells: gross rows, clocks that were begun or run apart, frames that nobody told, rows of
the other convention; each named, or put right and said.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from strange_logs import ROWS, columns_of, poses, run, seen, write

from camrob.errors import LogError
from camrob.jobs.diagnose import diagnose

OPEN = ('measured_frame = "unknown"', 'target = "unknown"')


def said_of(folder: Path) -> dict:
    diagnose(cell=folder / "cell", log=[folder / "log.csv"], out=folder / "out")
    return json.loads((folder / "out" / "diagnosis.json").read_text())


def claims(said) -> dict:
    return {e["effect"]: e for e in said["effects"] if e["probability"] >= 0.5}


def a_run(folder: Path, late=0.0, fast=0.0, wrong_deg=(0, 0.05, 0, 0, 0, 0), seconds=40.0):
    t, q = run(seconds, 0.02, 1)
    place = seen(q, wrong_deg=wrong_deg)
    place = np.stack([np.interp(t * (1.0 + fast) - late, t, p) for p in place.T], axis=1)
    return columns_of(q, place, t)


def test_three_rows_of_an_error_code_don_t_hide_a_wrong_zero(tmp_path: Path) -> None:
    columns = a_run(tmp_path)
    columns["y"][[50, 51, 300]] = -9999.0
    write(tmp_path, columns, ())
    said = said_of(tmp_path)
    assert said["gap"]["outliers"] == 3 and said["status"] == "explained"
    assert claims(said)["joint_offset"]["parameters"]["A2_deg"]["value"] == pytest.approx(0.05, rel=0.03)
    assert "3 rows of log.csv are gross and take no part (samples 51, 52, 301)" in said["instrument"]["text"]
    assert "3 rows of log.csv are gross" in (tmp_path / "out" / "diagnosis.html").read_text()


@pytest.mark.parametrize("late", [0.37, -1.8])
def test_recordings_that_were_begun_apart_are_brought_together_and_that_is_said(tmp_path: Path, late: float) -> None:
    write(tmp_path, a_run(tmp_path, late), ())
    said = said_of(tmp_path)
    assert claims(said)["joint_offset"]["parameters"]["A2_deg"]["value"] == pytest.approx(0.05, rel=0.03)
    assert said["latency_s"]["value"] == pytest.approx(late, abs=2e-3)
    assert (
        f"{abs(late):.2f}" in said["instrument"]["text"]
        and ("after" if late > 0.0 else "before") in said["instrument"]["text"]
    )


def test_a_clock_that_runs_fast_is_a_latency_that_grows(tmp_path: Path) -> None:
    write(tmp_path, a_run(tmp_path, 0.02, 1e-4, (0,) * 6, 80.0), ())
    found = claims(said := said_of(tmp_path))
    assert set(found) == {"latency"} and said["together"]["rms_after_mm"] < 0.08
    assert found["latency"]["parameters"]["rate"]["value"] == pytest.approx(-1e-4, rel=0.03)


def test_no_zero_of_a1_is_told_under_an_instrument_that_stands_anywhere(tmp_path: Path) -> None:
    q = poses(40, 3)
    write(tmp_path, columns_of(q, seen(q, wrong_deg=(0, 2.0, 0, 0, 0, 0), open_frames=True)), ("poses = true", *OPEN))
    zeros = claims(said := said_of(tmp_path))["joint_offset"]
    assert zeros["axes"] == ["A2"] and zeros["parameters"]["A2_deg"]["value"] == pytest.approx(2.0, abs=0.002)
    assert "A1_deg" not in zeros["parameters"] and said["together"]["rms_after_mm"] < 0.06


def test_a_target_that_slips_is_told_with_the_sample(tmp_path: Path) -> None:
    q = poses(80, 4)
    place = seen(q, open_frames=True)
    place[47:] = seen(q, open_frames=True, slipped=(0.8, -0.6, 0.0))[47:]
    write(tmp_path, columns_of(q, place), ("poses = true", *OPEN))
    assert "mm behind sample 47 of log.csv" in said_of(tmp_path)["instrument"]["text"]


def refused(folder: Path) -> str:
    with pytest.raises(LogError) as error:
        said_of(folder)
    assert "\n" not in str(error.value)
    return str(error.value)


RAD = tuple((float(np.radians(al)), a, float(np.radians(th)), d) for al, a, th, d in ROWS)
METRES = tuple((al, a / 1000.0, th, d / 1000.0) for al, a, th, d in ROWS)


@pytest.mark.parametrize(
    ("rows", "convention", "words"),
    [
        (ROWS, "standard", 'of the other convention (convention = "modified" in [arm])'),
        (RAD, "modified", "alpha and theta of its cell's rows are in radians"),
        (METRES, "modified", "a and d of its cell's rows are in metres"),
    ],
)
def test_what_is_wrong_with_a_cell_s_rows_is_named(tmp_path: Path, rows, convention: str, words: str) -> None:
    q = poses(40, 5)
    write(tmp_path, columns_of(q, seen(q, open_frames=True)), ("poses = true", *OPEN), rows, convention)
    assert words in refused(tmp_path)


def test_frames_that_nobody_told_and_units_of_both_kinds_are_named(tmp_path: Path) -> None:
    q = poses(40, 6)
    columns = columns_of(q, seen(q, open_frames=True))
    write(tmp_path, columns, ("poses = true",))
    assert 'measured_frame = "unknown", target = "unknown" in its .toml' in refused(tmp_path)
    write(tmp_path, columns, ("poses = true", OPEN[0]))
    words = refused(tmp_path)
    assert 'target = "unknown" in its .toml' in words and "frame of the instrument" not in words
    known = columns_of(q, seen(q))
    si = {n: v / 1000.0 if n in "xyz" else np.radians(v) for n, v in known.items()}
    write(tmp_path, si, ("poses = true",))
    assert "its axis values are in radians and its x, y, z in metres" in refused(tmp_path)


def test_an_arm_whose_drives_may_be_in_radians_is_told_what_that_would_change(tmp_path: Path) -> None:
    t, q = run(30.0, 0.02, 7)
    late = np.stack([np.interp(t - 0.02, t, c) for c in q.T], axis=1)
    columns = {n: np.radians(v) for n, v in columns_of(late, np.zeros((len(t), 3)), None, q).items() if n not in "xyz"}
    write(tmp_path, {"t": t} | columns, ())
    assert any("were these radians" in m for m in said_of(tmp_path)["where"]["missing"])


def rested(course: np.ndarray, wide: float) -> np.ndarray:
    """A course behind a dead zone."""
    out, stands = np.empty_like(course), float(course[0])
    for k, value in enumerate(course):
        stands = min(max(stands, value - wide / 2.0), value + wide / 2.0)
        out[k] = stands
    return out


@pytest.mark.parametrize("zone", [True, False], ids=["a dead zone", "dry friction"])
def test_friction_is_not_sure_where_a_dead_zone_shows_the_same(tmp_path: Path, zone: bool) -> None:
    t, q = run(40.0, 0.02, 8)
    late = np.stack([np.interp(t - 0.02, t, c) for c in q.T], axis=1)
    for k, wide in ((1, 0.03), (3, 0.02)):
        wide = np.radians(wide)
        speed = np.gradient(late[:, k], 0.02)
        late[:, k] = rested(late[:, k], wide) if zone else late[:, k] - wide / 2.0 * np.tanh(speed / 0.01)
    late += np.random.default_rng(8).normal(0.0, 2e-6, late.shape)
    columns = {n: v for n, v in columns_of(late, np.zeros((len(t), 3)), t, q).items() if n not in "xyz"}
    write(tmp_path, columns, ())
    friction = claims(said_of(tmp_path))["friction"]
    assert set(friction["axes"]) == {"A2", "A4"}
    assert ("dead_zone" in friction["indistinguishable_from"]) == zone
    assert (friction["probability"] > 0.9) != zone
