"""From a diagnosis to a better program: one error model for all, and the loop closed on a simulated cell."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from gap_cases import KR15, closed_loop, generator, kr15, simulated
from test_gap_effects import plant_play, scene_for
from test_gap_program import HEAD, HOME, start

from camrob.calibration.calibration_file import calibration_text, read_calibration
from camrob.calibration.error_model import ErrorModel
from camrob.errors import JobError
from camrob.gap.diagnose import diagnose
from camrob.gap.effects.registry import library
from camrob.jobs.diagnose import diagnose as diagnose_job
from camrob.measurement.log import MeasurementLog
from camrob.measurement.write_log import write_log

SIGMA = 0.02
STATES = {"gear_ripple": {"A1_order": 9.0}}


@pytest.mark.parametrize("effect", [e for e in library() if e.compensable], ids=lambda e: e.name)
def test_an_effect_s_columns_are_those_of_its_terms_in_the_shared_error_model(effect) -> None:
    """diagnose, calibrate and compensate share one model: each names the same derivative."""
    scene = scene_for(effect.name)
    state = {**effect.start, **STATES.get(effect.name, {})}
    count = 0
    for unit in effect.units([scene], state):
        terms = effect.terms(unit, state)
        if not terms:
            continue
        assert len(terms) == len(unit.parameters)
        in_base = effect.name == "frame_table"
        model = ErrorModel.of(kr15(), sorted(set(terms)), in_base=in_base)
        q = kr15().to_q(scene.log.axes(scene.axes))
        J = model.poses_and_jacobian(np.zeros(len(model.names)), q)[1]
        for name, column in zip(terms, effect.columns(scene, unit, state), strict=True):
            assert np.allclose(column.tcp, J[:, :, model.names.index(name)], atol=1e-9), name
            count += 1
    assert count > 0


@pytest.mark.slow
def test_what_is_handed_over_is_what_was_planted_and_reads_back(tmp_path: Path) -> None:
    def apply(world) -> None:
        world.link[:, 4] += 1e-3 * world.command[:, 3]
        world.tool = generator.rigid([3e-4, -2e-4, 1e-4, 2e-4, 0, 0])

    found = diagnose([simulated(apply, sigma_mm=SIGMA)], kr15())
    assert found.summary.to_json()["compensable"]["effects"] == ["frame_tool", "wrist_coupling"]
    assert found.summary.to_json()["compensable"]["rms_after_mm"] < 1.05 * SIGMA * np.sqrt(3)
    (tmp_path / "c.toml").write_text(calibration_text(found.calibration))
    again = read_calibration(tmp_path / "c.toml", kr15())
    values = {p.name: p.value for p in again.parameters.items_}
    assert values["A5.by.A4"] == pytest.approx(1e-3, rel=0.02)
    assert values["tool.x"] == pytest.approx(3e-4, rel=0.05)


@pytest.mark.slow
def test_play_is_no_constant_so_nothing_is_handed_over(tmp_path: Path) -> None:
    log = simulated(plant_play, sigma_mm=SIGMA)
    write_log(MeasurementLog(log.columns, log.info), tmp_path / "run.csv")
    with pytest.raises(JobError, match=r"nothing that compensate could correct \(backlash of A2\)"):
        diagnose_job(cell=KR15, log=[tmp_path / "run.csv"], out=tmp_path / "out", calibration=tmp_path / "c.toml")
    assert not (tmp_path / "c.toml").exists()
    assert (tmp_path / "out" / "diagnosis.json").exists()


def program(tmp_path: Path) -> Path:
    """A zigzag over a slope, the tool tilting and the track going along."""
    head = HEAD.replace("X 200,Y 0,Z 0,A 0,B 90,C 0", "X 0,Y -41.76366,Z 415.57793,A 0,B 0,C -159.57978")
    x, y, z, a, b, c = start(head)
    lines = []
    for k in range(36):
        u, v = 140.0 * (k // 2 % 2), 6.0 * k
        tilt, turn = 22.0 * np.sin(0.31 * k), 28.0 * np.cos(0.23 * k)
        lines.append(
            f"LIN {{X {x + u:.3f},Y {y + v - 150:.3f},Z {z - 150 + 0.6 * u:.3f},"
            f"A {a + turn:.3f},B {b + tilt:.3f},C {c + turn:.3f},E1 {3 * k},E2 0}} C_DIS"
        )
    path = tmp_path / "slope.src"
    path.write_text(head + "$APO.CDIS=0.5\n" + "\n".join([HOME, *lines]) + "\nEND\n")
    return path


@pytest.mark.slow
def test_the_closed_loop_reaches_what_was_predicted(tmp_path: Path) -> None:
    def apply(world) -> None:
        world.link[:, 2] += 0.06 * closed_loop.DEG
        world.link[:, 4] += 1.5e-3 * world.command[:, 3]

    loop = closed_loop.close_loop(program(tmp_path), tmp_path / "loop", apply)
    errors = {name: e["rms_mm"] for name, e in loop["off_path"].items()}
    assert errors["before"] > 0.4
    assert errors["predicted"] < 0.1 * errors["before"]
    assert errors["reached"] == pytest.approx(errors["predicted"], rel=0.15)
    assert "| reached |" in closed_loop.table(loop)
