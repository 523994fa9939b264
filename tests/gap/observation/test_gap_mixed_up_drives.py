"""Logs of set-points, encoders and motors as strangers mix them up: named where a mistake mends it, and no drive is blamed for
what another stage did. Simulated by numpy alone (`strange_logs`).
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from strange_logs import columns_of, poses, run, seen, write
from test_gap_strange_logs import claims, said_of

from camrob.errors import LogError
from camrob.jobs.diagnose import diagnose

WRONG = (0, 0.15, 0, 0, 0.1, 0)


def columns(seconds: float = 20.0) -> dict[str, np.ndarray]:
    t, q = run(seconds, 0.04, 2)
    encoder = q + np.random.default_rng(2).normal(0.0, np.deg2rad(5e-4), q.shape)
    return columns_of(encoder, seen(encoder, wrong_deg=WRONG), t, q)


def test_set_points_that_are_mixed_up_are_named(tmp_path: Path) -> None:
    for words, change in {
        "its set-points are in radians, its encoder values in degrees": lambda c: {
            n: np.deg2rad(v) if n.startswith("cA") else v for n, v in c.items()
        },
        "its cA3 counts the other way than A3": lambda c: c | {"cA3": -c["cA3"]},
        "its cA4 and cA6 are exchanged": lambda c: c | {"cA4": c["cA6"], "cA6": c["cA4"]},
        "its A5 stays the same to the last digit while cA5 moves": lambda c: c | {"A5": np.full_like(c["A5"], 7.0)},
    }.items():
        write(tmp_path, change(columns()), ())
        with pytest.raises(LogError, match=words):
            said_of(tmp_path)


def test_an_axis_that_stands_beside_its_set_point_hides_no_zero_behind_the_encoders(tmp_path: Path) -> None:
    """A2 stands 0.5 degrees beside its set-point, the other way than its zero of 0.15 is off: both are in the log."""
    found = columns()
    write(tmp_path, found | {"cA2": found["cA2"] + 0.5}, ())
    said = said_of(tmp_path)
    zeros = claims(said)["joint_offset"]
    assert zeros["axes"] == ["A2", "A5"] and zeros["probability"] > 0.9
    assert zeros["parameters"]["A2_deg"]["value"] == pytest.approx(0.15, abs=0.002)
    assert said["unknown"]["probability"] > 0.5
    assert said["unknown"]["where"]["rung"] == "setpoint_to_encoder" and said["unknown"]["where"]["axes"] == ["A2"]
    assert "A2 is off its set-point by 0.5 degrees" in said["unknown"]["text"]


@pytest.mark.parametrize("apart", [0.0, 4.0])
def test_an_instrument_that_was_set_up_anew_between_two_runs_is_said_and_blames_no_arm(
    tmp_path: Path, apart: float
) -> None:
    """Both logs say world; on the second all readings are 4 mm off, or none: then the foot's frame stays the cell's."""
    logs = []
    for k, (shift, seed) in enumerate(((0.0, 20), (apart, 21))):
        t, q = run(15.0, 0.04, seed)
        place = seen(q, wrong_deg=(0, 0.1, 0, 0, 0, 0), seed=seed) + np.array([shift, -0.7 * shift, 0.2 * shift])
        folder = tmp_path / str(k)
        folder.mkdir()
        write(folder, columns_of(q, place, t), ())
        logs.append((folder / "log.csv").rename(tmp_path / f"log{k}.csv"))
        (folder / "log.toml").rename(tmp_path / f"log{k}.toml")
    diagnose(cell=tmp_path / "0" / "cell", log=logs, out=tmp_path / "out")
    said = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert list(claims(said)) == ["joint_offset"]
    assert claims(said)["joint_offset"]["parameters"]["A2_deg"]["value"] == pytest.approx(0.1, abs=0.002)
    assert said["together"]["rms_after_mm"] < 0.05 and said["unknown"]["probability"] < 0.5
    assert ("stood elsewhere from log to log" in said["instrument"]["text"]) == (apart > 0.0)
    assert (said["instrument"]["suspect"] > 0.5) == (apart > 0.0)


@pytest.mark.parametrize("turns", [1.0, 100.0])
def test_play_between_motor_and_link_is_no_friction_of_the_drive(tmp_path: Path, turns: float) -> None:
    """The motor follows; the link is pushed along by the flanks of a play of 0.04 degrees. Motors may count their own turns."""
    t, q = run(20.0, 0.008, 2)
    half, link, at = 0.5 * np.deg2rad(0.04), [], q[0, 2]
    for value in q[:, 2]:
        at = min(max(at, value - half), value + half)
        link.append(at)
    noise = np.random.default_rng(2).normal(0.0, np.deg2rad(5e-4), (2, *q.shape))
    encoder = q.copy()
    encoder[:, 2] = link
    found = {n: v for n, v in columns_of(encoder + noise[0], np.zeros((len(t), 3)), t, q).items() if n not in "xyz"}
    motor = turns * np.degrees(q + noise[1])
    write(tmp_path, found | {f"M{k + 1}": motor[:, k] for k in range(6)}, ("sigma_axis_deg = 0.0005",))
    said = said_of(tmp_path)
    found = claims(said)
    assert list(found) == ["backlash"] and found["backlash"]["axes"] == ["A3"]
    assert found["backlash"]["rungs"] == ["setpoint_to_encoder"]
    assert found["backlash"]["parameters"]["A3_deg"]["value"] == pytest.approx(0.04, rel=0.02)
    gear = said["axes_report"]["A3"]["motor_to_link"]
    # half the play, to either side
    assert gear["pattern"]["follows"] == "direction" and gear["pattern"]["coefficient"] == pytest.approx(0.02, rel=0.1)


@pytest.mark.parametrize("tracked", [False, True], ids=["drives alone", "with an instrument"])
def test_a_gear_that_winds_up_between_two_encoders_is_none_of_the_arm(tmp_path: Path, tracked: bool) -> None:
    """Dahl's friction by hand, 0.02 degrees to either side within a degree of A3; the tool is where the link's encoder says."""
    t, q = run(20.0, 0.008, 2)
    reach, z, wound = np.deg2rad(1.0), 0.0, [0.0]
    for step in np.diff(q[:, 2]):
        z += (1.0 - z * np.sign(step)) * step / reach
        wound.append(z)
    encoder = q.copy()
    encoder[:, 2] -= np.deg2rad(0.02) * np.array(wound)
    noise = np.random.default_rng(2).normal(0.0, np.deg2rad(5e-4), (2, *q.shape))
    found = columns_of(encoder + noise[0], seen(encoder), t, q)
    found = {n: v for n, v in found.items() if tracked or n not in "xyz"}
    motor = np.degrees(q + noise[1])
    write(tmp_path, found | {f"M{k + 1}": motor[:, k] for k in range(6)}, ("sigma_axis_deg = 0.0005",))
    said = said_of(tmp_path)
    (wind_up,) = claims(said).values()
    assert (wind_up["effect"], wind_up["axes"], wind_up["rungs"]) == ("hysteresis", ["A3"], ["setpoint_to_encoder"])
    assert said["together"]["shrink"] > 0.8 and said["unknown"]["probability"] < 0.5


def test_values_of_few_decimals_are_said_with_what_they_leave(tmp_path: Path) -> None:
    """0.01 degrees of six axes: by hand 0.01 / sqrt(12) of each, over its lever."""
    q = poses(30, 1)
    rounded = {n: np.round(v, 2) if n.startswith("A") else v for n, v in columns_of(q, seen(q)).items()}
    write(tmp_path, rounded, ("poses = true",))
    said = said_of(tmp_path)
    assert claims(said) == {}
    assert "its axis values stand in steps of 0.01 degrees, which alone leaves 0.17 mm" in said["instrument"]["text"]
    assert said["gap"]["rms_mm"] == pytest.approx(0.17, rel=0.15)
