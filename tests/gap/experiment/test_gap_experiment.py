"""The next experiment: the motion that parts rivals best, with how far, written as a program that verify passes."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from gap_cases import KR15, generator, kr15, simulated
from test_gap_effects import DEG, plant_link

from camrob.errors import InputError, JobError, VerificationError
from camrob.gap.diagnose import diagnose
from camrob.gap.diagnosis import Diagnosis
from camrob.gap.experiment.motions import single_axis, trial_motions
from camrob.gap.observation.scene import make_scene
from camrob.jobs.diagnose import diagnose as diagnose_job
from camrob.jobs.experiment import check_experiment_name, write_experiment
from camrob.jobs.verify import verify
from camrob.kinematics.frames import base_T_tool
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.measurement.log import MeasurementLog
from camrob.measurement.write_log import write_log

SIGMA = 0.02


def sagging(world) -> None:
    world.link[:, 1] += 2e-6 * generator.torques(world.command)[:, 1]


@cache
def found(name: str) -> Diagnosis:
    apply = {"compliance": sagging, "zero": plant_link(2, lambda w: 0.05 * DEG), "nothing": None}[name]
    return diagnose([simulated(apply, sigma_mm=SIGMA)], kr15())


def test_every_motion_differs_from_the_run_as_it_says() -> None:
    scene = make_scene(simulated(), kr15())
    motions = {m.key: m for m in trial_motions(scene)}
    assert set(motions) == {"again", "reversed", "half speed", "track", "table", "payload", "air", "warm"}
    again = np.asarray(motions["again"].q)
    assert np.allclose(motions["reversed"].q, again[::-1])
    assert motions["half speed"].seconds == pytest.approx(2.0 * motions["again"].seconds)
    assert np.abs(motions["air"].scene.force).max() == 0.0
    assert motions["warm"].scene.temperature.min() > 30.0
    for key, joint in (("track", "E1"), ("table", "E2")):
        q = np.asarray(motions[key].q)
        assert np.abs(base_T_tool(kr15(), q) - base_T_tool(kr15(), again))[:, :3].max() < 1e-9
        assert np.abs(q - again)[:, kr15().index(joint)].min() > 0.1
    heavier = motions["payload"].scene.torque - motions["again"].scene.torque
    assert np.abs(heavier[:, 1]).max() == pytest.approx(5.0 * 9.81 * 1.0, rel=0.6)
    alone = np.asarray(single_axis(scene, "A2").q)
    assert np.ptp(alone[:, kr15().index("A2")]) > 0.05
    assert np.ptp(np.delete(alone, kr15().index("A2"), axis=1), axis=0).max() == 0.0


@pytest.mark.slow
def test_the_best_motion_is_the_one_that_physics_asks_for() -> None:
    plan = found("compliance").summary.to_json()["experiment"]
    assert plan["rivals"][0] == ["joint_compliance"]
    sigmas = {c["motion"]: c["separation_sigmas"] for c in plan["considered"]}
    # a load tells compliance from what does not sag; running it backwards, or warm, tells nothing new
    assert max(sigmas["payload"], sigmas["track"]) > 1.05 * max(sigmas["reversed"], sigmas["warm"])
    assert plan["separation_mm"] > 0.0
    # told apart beyond doubt, by what the two rivals hold and nothing else
    assert plan["separation_sigmas"] > 50.0
    apart = plan["separation_sigmas"]
    words = "over 100 sigmas" if apart > 100.0 else f"{apart:.0f} sigmas"
    said = found("compliance").summary
    assert said.next_experiment_for == ("joint_compliance",)
    assert words in said.next_experiment


def test_where_there_is_no_gap_no_experiment_is_written(tmp_path: Path) -> None:
    assert found("nothing").summary.experiment is None
    with pytest.raises(JobError, match="no experiment is needed"):
        write_experiment(tmp_path / "next.src", found("nothing").motions, KR15)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_program_passes_verify_and_does_what_it_says(tmp_path: Path) -> None:
    motion = next(m for m in found("zero").motions if m.key == "track")
    written = write_experiment(tmp_path / "next.src", [motion], KR15)
    assert written.motion == "track"
    assert sorted(p.name for p in tmp_path.iterdir()) == list(written.files) == ["next.dat", "next.src"]
    assert verify(tmp_path / "next.src", cell=KR15).ok
    text = read_krl(tmp_path / "next.src")
    ran = np.asarray(text.external)[2:-1, text.external_names.index("E1")]
    asked = kr15().to_axis_values(np.asarray(motion.q))[:, kr15().axis_names.index("E1")]
    assert ran.min() == pytest.approx(asked.min(), abs=1.0)
    assert ran.max() == pytest.approx(asked.max(), abs=1.0)


def test_one_axis_alone_stops_on_its_way_there_and_back(tmp_path: Path) -> None:
    write_experiment(tmp_path / "sweep.src", [single_axis(make_scene(simulated(), kr15()), "A3")], KR15)
    text = read_krl(tmp_path / "sweep.src")
    axes = np.asarray(text.axes)[1:-1]
    assert np.ptp(np.delete(axes, 2, axis=1), axis=0).max() == 0.0
    assert np.allclose(axes[:, 2], axes[::-1, 2])
    assert np.asarray(text.wait)[2:-1].min() == 1.0


def test_a_motion_that_cannot_be_run_is_refused_and_leaves_nothing(tmp_path: Path) -> None:
    motion = found("zero").motions[0]
    q = np.array(motion.q)
    q[:, kr15().index("A2")] += 2.0  # far beyond its limit
    object.__setattr__(motion, "q", q)
    try:
        with pytest.raises(VerificationError, match="no program was written"):
            write_experiment(tmp_path / "next.src", [motion], KR15)
    finally:
        found.cache_clear()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_command_writes_it_beside_the_diagnosis(tmp_path: Path) -> None:
    log = simulated(plant_link(2, lambda w: 0.05 * DEG), sigma_mm=SIGMA)
    write_log(MeasurementLog(log.columns, log.info), tmp_path / "run.csv")
    target = tmp_path / "next.src"
    result = diagnose_job(cell=KR15, log=[tmp_path / "run.csv"], out=tmp_path / "out", experiment=target)
    written = json.loads((tmp_path / "out" / "diagnosis.json").read_text())["experiment"]["written"]
    assert written["file"] == "next.src"
    assert result.summary.experiment.written.to_json() == written
    assert target.is_file()


@pytest.mark.parametrize("name", ["next.txt", "a" * 40 + ".src", "näxt.src", ".src", "1-2.src"])
def test_a_name_that_is_no_program_s_is_refused(name: str) -> None:
    with pytest.raises(InputError):
        check_experiment_name(Path(name))
