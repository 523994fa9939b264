"""A gap is none only where every logged stage is within something, and what the drives leave is read off the log."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gap_cases import kr15, simulated

from camrob.gap.diagnose import diagnose
from camrob.gap.evidence.shrink import Shrinkage
from camrob.gap.observation.scene import make_scene
from camrob.gap.verdict.within import drives_on_work, stages_within
from camrob.measurement.log import MeasurementLog
from camrob.report.diagnosis.sentences import sentence
from camrob.summaries.diagnosis_summary import DiagnosisSummary

BEHIND = 2.4  # degrees that E2 stays behind, as one did in a log that was called "no gap"


def table_behind(**facts) -> MeasurementLog:
    """A log in world whose table is behind its set-point: nothing of it shows at the measured TCP."""
    log = simulated(sigma_mm=0.02)
    columns = dict(log.columns)
    columns["E2"] = columns["cE2"] - BEHIND
    return MeasurementLog(columns, replace(log.info, **facts), log.path)


@pytest.mark.slow
def test_a_table_behind_its_set_point_is_said_with_its_size_over_the_work_and_is_no_no_gap() -> None:
    log = table_behind()
    found = diagnose([log], kr15()).summary.to_json()
    # the table turns about world's z: each point over the work moves by its distance from there
    distance = 1e3 * np.hypot(log.position[:, 0], log.position[:, 1])
    on_work = 1e3 * drives_on_work([make_scene(log, kr15())])["E2"]
    assert on_work == pytest.approx(np.sqrt(np.mean(distance**2)) * np.deg2rad(BEHIND), rel=0.02)
    assert found["status"] == "unexplained"
    assert found["within"] == {"encoder_to_tcp": "noise", "setpoint_to_encoder": "beyond"}
    told = found["within_values"]["setpoint_to_encoder"]
    assert (told["axis"], told["within"], told["tolerance_mm"]) == ("E2", "beyond", None)
    assert told["rms_mm"] == pytest.approx(on_work)
    assert found["unknown"]["where"] == {"rung": "setpoint_to_encoder", "axes": ["E2"], "regimes": [], "comes_back": ""}
    assert found["unknown"]["text"].startswith("between set-point and encoder, E2 is off its set-point by 2.4 degrees")
    assert "E2" in found["next_experiment"]


@pytest.mark.slow(after=1)
@pytest.mark.parametrize(
    ("facts", "said", "value"),
    [
        ({"tolerance": 0.03}, "tolerance", "tolerance_mm = 30"),
        ({"sigma_axis": np.deg2rad(3.0)}, "noise", "as reported"),
    ],
)
def test_what_the_user_lives_with_and_what_the_encoders_scatter_by_is_no_gap_and_says_which(
    facts, said: str, value: str
) -> None:
    found = diagnose([table_behind(**facts)], kr15()).summary.to_json()
    assert found["status"] == "no gap"
    assert found["within"]["setpoint_to_encoder"] == said
    assert found["within_values"]["setpoint_to_encoder"]["axis"] == "E2"
    words = sentence(DiagnosisSummary.from_json(found | {"cell": "kr15", "without": ()}))
    drives, arm = words.split("; ")
    assert value in drives
    assert "between encoder and TCP" in arm
    assert "within the noise (" in arm


def test_a_gap_is_no_noise_because_what_is_claimed_explains_it_all() -> None:
    """It is asked of the gap, and not of what a claim leaves of it: of a zero the page said "leave zeros alone"."""
    scenes, rng = [make_scene(simulated(sigma_mm=0.02), kr15())], np.random.default_rng(3)
    noise = rng.normal(0.0, 2e-5, (600, 3))
    swings = noise + 1e-3 * np.sin(np.arange(600) / 40.0)[:, None]
    block = np.repeat(np.arange(6), 100)
    for before, said in ((swings, "beyond"), (noise, "noise")):
        stages = stages_within(scenes, Shrinkage(before, noise, block), 2e-5 * np.sqrt(3.0))
        assert stages["encoder_to_tcp"].within == said


@pytest.mark.slow
def test_a_run_out_of_three_times_the_told_noise_is_no_noise() -> None:
    log = simulated(sigma_mm=0.06)
    stated = replace(log.info, sigma_position=2e-5)
    found = diagnose([MeasurementLog(dict(log.columns), stated, log.path)], kr15()).summary.to_json()
    assert found["within"]["encoder_to_tcp"] == "beyond"
    assert found["status"] == "unexplained"


@pytest.mark.slow
@pytest.mark.parametrize(("share", "status"), [(0.25, "no gap"), (1.0, "unexplained")])
def test_what_wanders_far_below_the_noise_is_no_gap_and_asks_for_no_run(share: float, status: str) -> None:
    """An instrument that nobody told the noise of, and whose readings also wander within seconds."""
    sigma, rate = 0.02, 25.0
    log = simulated(sigma_mm=sigma, rate=rate)
    kept, rng = np.exp(-1.0 / (rate * 3.0)), np.random.default_rng(4)
    wander = np.zeros((len(log.columns["t"]), 3))
    for k in range(1, len(wander)):
        wander[k] = kept * wander[k - 1] + np.sqrt(1.0 - kept**2) * share * sigma * rng.normal(size=3)
    columns = dict(log.columns) | {n: log.columns[n] + wander[:, k] for k, n in enumerate("xyz")}
    info = replace(log.info, sigma_position=np.nan, sigma_angle=np.nan)
    found = diagnose([MeasurementLog(columns, info, log.path)], kr15()).summary.to_json()
    assert found["status"] == status
    assert (found["unknown"]["probability"] >= 0.5) == (status == "unexplained")
    assert found["next_experiment"].startswith("None needed") == (status == "no gap")
