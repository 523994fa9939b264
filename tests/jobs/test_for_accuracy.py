"""What a plan for accuracy knows: from a calibration, a force model, or nothing at all; options that don't belong together."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "prediction"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

from calibration_sample import calibration
from gap import generator
from summary_samples import diagnosis_summary

from camrob.calibration.calibration_file import read_calibration
from camrob.calibration.error_model import ErrorModel
from camrob.calibration.terms import PARTS
from camrob.cell.read_cell import read_cell
from camrob.cli import app as cli
from camrob.errors import InputError
from camrob.gap.effects.robot_size import ordinary_compliance
from camrob.jobs.solving.chain_constants import chain_constants
from camrob.jobs.solving.machine_errors import machine_errors
from camrob.jobs.solving.sought import Sought, check_sought
from camrob.prediction.read_force import read_forces
from camrob.redundancy.accuracy.part_error import error_numbers, expected_squares
from camrob.redundancy.accuracy.posture_errors import PLACES
from camrob.summaries.fitted.diagnosis_fitted import FittedModel, FittedUnit, UnitParameter

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "cells" / "kr15_track_table"
CELL = read_cell(FOLDER)


def test_constants_of_the_arm_are_counted_and_others_named(tmp_path: Path) -> None:
    values = {
        "A2.compliance": 3e-6,
        "A5.compliance": 8e-6,
        "A5.zero": 2e-4,
        "A1.cos2": 1e-4,
        "tool.z": 1e-4,
        "E1.scale": 1e-4,
    }
    errors = machine_errors(Sought(FOLDER, calibration=calibration(tmp_path / "f.toml", values)), CELL, None)
    np.testing.assert_allclose(errors.sagging, [0, 3e-6, 0, 0, 8e-6, 0])
    first = 0.5 * (3e-6 + 8e-6 / 4.0)
    np.testing.assert_allclose(errors.compliance, [first, 3e-6, first, 4 * first, 8e-6, 4 * first])
    np.testing.assert_allclose(errors.shift, [0, 0, 0, 0, -2e-4, 0])  # A5 counts against q
    np.testing.assert_allclose(errors.swing, [1e-4 / np.sqrt(2), 0, 0, 0, 0, 0])
    assert errors.any_force > 0.0 and set(errors.left_out) == {"E1.scale"}
    assert "A2 3" in errors.counted[0] and {"A5.zero", "where tool stands"} <= set(errors.counted)


def test_the_planner_counts_a_chains_constants_as_the_calibrated_chain_has_them(tmp_path: Path) -> None:
    """Places of axes, base and tool, zeros and couplings, at postures over the whole range; to first order."""
    rng = np.random.default_rng(4)
    values = {f"A{i}.{part}": 2e-5 * rng.normal() for i in range(1, 7) for part in ("x", "y", "z", "rx", "ry")}
    values |= {f"{frame}.{part}": 2e-5 * rng.normal() for frame in ("base", "tool") for part in PARTS}
    values |= {"A5.by.A4": 3e-5, "A3.by.A2": -2e-5, "A4.scale": 1e-5, "A5.zero": 2e-5, "A1.zero": -1e-5}
    file = calibration(tmp_path / "f.toml", values)
    errors = machine_errors(Sought(FOLDER, calibration=file), CELL, None)
    model, constants = read_calibration(file, CELL).model(CELL)
    q = CELL.q_home + 0.5 * rng.normal(size=(20, len(CELL)))
    q[:, -1] = 0.0
    meant, real = (model.poses(x, q)[:, :3, 3] for x in (np.zeros(len(constants)), constants))
    free = np.setdiff1d(np.arange(len(CELL)), np.arange(CELL.arm_slice.start, CELL.arm_slice.stop))
    push = np.tile([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0], (len(q), 1))
    numbers = error_numbers(CELL, 1, replace(errors, any_force=0.0))
    u, arm = np.ascontiguousarray(q[:, free]), np.ascontiguousarray(q[:, CELL.arm_slice])
    got = np.sqrt(expected_squares(numbers, u, arm, push)[0])
    np.testing.assert_allclose(got, np.linalg.norm(real - meant, axis=1), rtol=0.01)
    # the doubt of a constant alone is what that constant does
    for name in ("A3.ry", "base.rz", "tool.x", "A5.by.A4", "A2.zero"):
        one = ErrorModel.of(CELL, (name,))
        chain = chain_constants(CELL, one.terms)
        root, _ = chain.root(np.array([[1e-4]]), np.zeros((0, 1)))
        places = np.zeros((PLACES if len(root) > 12 + len(chain.couples) else 0, 6))
        alone = replace(errors, shift=np.zeros(6), coupling=np.zeros(len(chain.couples)), couples=chain.couples)
        alone = replace(alone, places=places, root=root, any_force=0.0)
        got = np.sqrt(expected_squares(error_numbers(CELL, 1, alone), u, arm, push)[0])
        moved = one.poses(np.array([1e-4]), q)[:, :3, 3] - meant
        np.testing.assert_allclose(got, np.linalg.norm(moved, axis=1), rtol=0.01, atol=1e-9)


def test_without_a_diagnosis_stiffness_alone_counts_and_is_said_to_be_assumed(tmp_path: Path) -> None:
    errors = machine_errors(Sought(FOLDER), CELL, None)
    assert not errors.sagging.any() and errors.compliance[0] == ordinary_compliance(CELL)
    assert "nobody measured" in errors.counted[0] and "any side" in errors.counted[-2]
    force = tmp_path / "FORCE.toml"
    force.write_text("doubt = 0.1\n[mean]\nalong_n = -60\nacross_n = 30\naxial_n = 20\n")
    pushed = machine_errors(Sought(FOLDER, force=force), CELL, None, *read_forces(force).on([None], "it"))
    assert pushed.any_force == 0.0 and pushed.doubt == pytest.approx(np.hypot(0.1, np.log(2.0)))
    np.testing.assert_allclose(pushed.granted, pushed.compliance / np.sqrt(3.0))
    np.testing.assert_allclose(pushed.force.mean(np.array([0.02])), [[-60.0, 30.0, 20.0]])


def test_constants_that_no_calibration_holds_are_the_diagnosis(tmp_path: Path) -> None:
    """A zero that a diagnosis claims, without a calibration: the planner expects what another code's arm with that zero does."""
    off, said = 1e-3, diagnosis_summary()
    parameter = UnitParameter(name="A2_deg", unit="deg", usual=off, value=off)
    claimed = FittedUnit(effect="joint_offset", axis="A2", key="", parameters=(parameter,), state={})
    fitted = FittedModel(units=(claimed,), covariance=((0.0,),))
    said = replace(said, compensable=replace(said.compensable, fitted=fitted))
    (tmp_path / "diagnosis.json").write_text(json.dumps(said.to_json()), encoding="utf-8")
    errors = machine_errors(Sought(FOLDER, diagnosis=tmp_path), CELL, None)
    axis = np.array([[0.2, -1.4, 1.7, 0.1, 1.0, 0.0, 0.5, 0.0], [-0.4, -1.1, 1.4, 0.4, 0.8, 0.3, 1.5, 0.0]])
    moved = axis.copy()
    moved[:, 1] += off
    expected = np.linalg.norm((generator.pose(moved) - generator.pose(axis))[:, :3, 3], axis=1)
    q = CELL.to_q(axis * np.array([1 / generator.DEG] * 6 + [1e3, 1 / generator.DEG]))
    free = np.setdiff1d(np.arange(len(CELL)), np.arange(CELL.arm_slice.start, CELL.arm_slice.stop))
    push = np.tile([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0], (len(q), 1))
    numbers = error_numbers(CELL, 1, replace(errors, any_force=0.0, rest=0.0))
    got = np.sqrt(
        expected_squares(numbers, np.ascontiguousarray(q[:, free]), np.ascontiguousarray(q[:, CELL.arm_slice]), push)[0]
    )
    np.testing.assert_allclose(got, expected, rtol=0.01)


def test_a_force_that_asks_for_the_removal_needs_stock_and_cutter(tmp_path: Path) -> None:
    force = tmp_path / "FORCE.toml"
    force.write_text(
        "[milling]\nteeth = 2\ndiameter_mm = 6\nspindle_rpm = 9000\nwidth_mm = 3\ntangential_n_mm2 = 700\n"
        "radial_n_mm2 = 300\naxial_n_mm2 = 100\n"
    )
    with pytest.raises(InputError, match="depth_mm"):
        machine_errors(Sought(FOLDER, force=force), CELL, None, *read_forces(force).on([None], "it"))


def test_options_that_do_not_fit_are_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    sample = str(ROOT / "toolpaths/engraving/engraving.cls")
    asked = ["post", sample, "--cell", str(FOLDER), "--out", str(tmp_path / "out")]
    assert cli.run([*asked, "--for-accuracy"]) == 2
    assert "--method planned" in capsys.readouterr().err
    assert cli.run([*asked, "--method", "planned", "--force", "FORCE.toml"]) == 2
    assert "--for-accuracy" in capsys.readouterr().err
    assert cli.run([*asked, "--method", "planned", "--then-compensated"]) == 2
    assert "--for-accuracy" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_cell_may_ask_for_it_by_its_weight() -> None:
    settings = replace(CELL.resolve, planned={"accuracy": 2.0})
    weighs = replace(CELL, resolve_section=settings)
    assert check_sought(Sought(FOLDER), weighs, asked=False, planned=True, tolerance=False) == Sought(FOLDER)
    assert check_sought(Sought(FOLDER), weighs, asked=False, planned=False, tolerance=False) is None
    assert check_sought(Sought(FOLDER), CELL, asked=False, planned=True, tolerance=False) is None
