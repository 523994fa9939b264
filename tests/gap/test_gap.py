"""The diagnosis: rungs that add up, planted effects found and none invented, damaged logs refused, labelled samples right."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from gap_cases import KR15, generator, kr15, simulated
from test_gap_effects import DEG, plant_link, plant_play

from camrob.errors import LogError
from camrob.gap.diagnose import diagnose
from camrob.gap.locate.by_stage import stage_gaps
from camrob.gap.observation.program_track import track_of
from camrob.gap.observation.scene import make_scene
from camrob.jobs.diagnose import diagnose as diagnose_job
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.measurement.log import MeasurementLog
from camrob.measurement.read_log import read_log

SAMPLES = Path(__file__).resolve().parents[3] / "shared" / "gap_samples"
SIGMA = 0.02


def claimed(diagnosis) -> set[str]:
    return set(diagnosis.claimed)


def test_the_rungs_add_up_to_the_whole_sample_by_sample() -> None:
    def apply(world) -> None:
        world.drive[:, 1] += 1e-4 * np.sin(world.t)
        world.link[:, 2] += 2e-4

    scene = make_scene(simulated(apply, sigma_mm=SIGMA), kr15())
    stages = stage_gaps(scene, None)
    assert stages.program_to_setpoint is None
    assert any("program" in m for m in stages.missing)
    assert stages.setpoint_to_encoder is not None
    assert np.abs(stages.setpoint_to_encoder + stages.encoder_to_tcp - stages.whole).max() < 1e-12
    assert 1e-5 < np.sqrt(np.mean(stages.setpoint_to_encoder**2)) < 1e-3


def test_no_effect_is_invented_where_there_is_none() -> None:
    found = diagnose([simulated(sigma_mm=SIGMA)], kr15())
    assert claimed(found) == set()
    assert found.summary.to_json()["status"] == "no gap"
    assert found.summary.to_json()["gap"]["rms_mm"] == pytest.approx(SIGMA * np.sqrt(3), rel=0.05)


def test_a_planted_play_is_found_on_its_axis_with_its_size() -> None:
    found = diagnose([simulated(plant_play, sigma_mm=SIGMA)], kr15())
    assert claimed(found) == {"backlash"}
    entry = found.summary.to_json()["effects"][0]
    assert entry["axes"] == ["A2"]
    assert entry["parameters"]["A2_deg"]["value"] == pytest.approx(0.03, rel=0.03)
    assert entry["probability"] > 0.9
    assert entry["rms_after_mm"] < 1.1 * SIGMA * np.sqrt(3) < entry["rms_before_mm"]
    json.dumps(found.summary.to_json(), allow_nan=False)


def test_two_planted_effects_are_found_together() -> None:
    def apply(world) -> None:
        world.link[:, 4] += 1e-3 * world.command[:, 3]
        world.tool = generator.rigid([3e-4, -2e-4, 1e-4, 2e-4, 0, 0])

    found = diagnose([simulated(apply, sigma_mm=SIGMA)], kr15())
    assert claimed(found) == {"frame_tool", "wrist_coupling"}
    assert sum(a["probability"] for a in found.summary.to_json()["alternatives"]) == pytest.approx(1.0)


def test_an_effect_taken_out_of_the_library_is_called_unknown_and_blamed_on_nobody() -> None:
    found = diagnose([simulated(plant_play, sigma_mm=SIGMA)], kr15(), without=["backlash"])
    assert found.summary.to_json()["status"] in ("unexplained", "partly explained")
    assert found.summary.to_json()["unknown"]["probability"] > 0.5
    assert all(e["probability"] <= 0.8 for e in found.summary.to_json()["effects"])


def test_an_effect_that_no_library_has_is_called_unknown() -> None:
    def bend(world):
        x = world.command[:, 1]
        return 2e-4 * ((x - x.mean()) / np.ptp(x)) ** 2 * 4.0

    found = diagnose([simulated(plant_link(2, bend), sigma_mm=SIGMA)], kr15())
    assert found.summary.to_json()["unknown"]["probability"] > 0.5
    assert all(e["probability"] <= 0.8 for e in found.summary.to_json()["effects"])


@pytest.mark.slow
def test_position_alone_and_outliers_do() -> None:
    log = simulated(plant_link(2, lambda w: 0.05 * DEG), sigma_mm=SIGMA)
    columns = {n: np.array(v) for n, v in log.columns.items() if n not in "abc"}
    columns["x"][::60] += 2.0
    found = diagnose([MeasurementLog(columns, log.info, log.path)], kr15())
    assert "joint_offset" in claimed(found)
    assert found.summary.to_json()["gap"]["outliers"] >= len(log) // 60
    assert found.summary.to_json()["gap"]["rms_deg"] is None


@pytest.mark.parametrize(
    ("drop", "words"),
    [
        (("x", "y", "z", *(f"c{a}" for a in generator.AXES)), "no measured position"),
        (("A3", "cA3"), "lacks the axis A3"),
        (("E1", "cE1"), "lacks the axis E1"),
    ],
)
def test_a_log_that_lacks_something_is_refused_in_one_line(drop, words: str) -> None:
    log = simulated(sigma_mm=SIGMA)
    columns = {n: v for n, v in log.columns.items() if n not in drop}
    with pytest.raises(LogError, match=words):
        diagnose([MeasurementLog(columns, log.info, log.path)], kr15())


CASES = {
    "a_nothing": {},
    "b_joint_offset": {"joint_offset": {"A3_deg": 0.054814, "A5_deg": -0.032698}},
    "c_backlash": {"backlash": {"A3_deg": 0.029129}},
    "d_servo_lag": {"servo_lag": {"tau_s": 0.04092}},
    "e_tool_and_compliance": {"frame_tool": {"x_mm": -0.54896}, "joint_compliance": {"A2_rad_nm": 1.0466e-6}},
}


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_the_labelled_samples_come_out_right(case: str, tmp_path: Path) -> None:
    folder = SAMPLES / "cases" / case
    if not folder.is_dir():
        pytest.skip("../shared is not here: no labelled samples")
    run = next(p for p in sorted(folder.glob("*.csv")) if not p.name.startswith("circle"))
    result = diagnose_job(cell=KR15, log=[run], withheld=[folder / "circle1.csv"], out=tmp_path)
    assert claimed(result.diagnosis) == set(CASES[case])
    for entry in result.summary.effects:
        for name, value in CASES[case].get(entry.effect, {}).items():
            assert entry.parameters[name].value == pytest.approx(value, rel=0.03)
    assert (tmp_path / "diagnosis.html").read_text().startswith("<!DOCTYPE html>")
    assert json.loads((tmp_path / "diagnosis.json").read_text())["gap"]["samples"] > 2000


def test_the_program_rung_of_a_sample_is_nothing_and_all_three_add_up() -> None:
    folder = SAMPLES / "cases" / "d_servo_lag"
    if not folder.is_dir():
        pytest.skip("../shared is not here: no labelled samples")
    scene = make_scene(read_log(folder / "circle1.csv"), kr15())
    stages = stage_gaps(scene, track_of(scene, read_krl(folder / "circle1.src")))
    assert stages.missing == ()
    assert stages.program_to_setpoint is not None
    assert stages.setpoint_to_encoder is not None
    total = stages.program_to_setpoint + stages.setpoint_to_encoder + stages.encoder_to_tcp
    assert np.abs(total - stages.whole).max() < 1e-12
    assert np.sqrt(np.mean(np.sum(stages.program_to_setpoint**2, axis=1))) < 1e-6
