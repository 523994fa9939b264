"""Calibration: planted errors found, what can't be identified named, hopeless fits refused, real measurements predicted."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from calibration_sample import CELL, ROOT, SHARED, axis_values, calibrate_cell, drawn, log_of, measure

from camrob.calibration.align import align
from camrob.calibration.calibration_file import calibration_text, read_calibration
from camrob.calibration.error_model import ErrorModel
from camrob.calibration.fit import residuals
from camrob.calibration.identify import Observability, identify
from camrob.calibration.measurements import measurements_of
from camrob.calibration.parameters import ParameterSet
from camrob.calibration.sets import fit_frames
from camrob.calibration.terms import PARTS, standard_names
from camrob.cell.load import PointMass
from camrob.cell.read_cell import read_cell
from camrob.cli.app import run
from camrob.errors import JobError, LogError, SingularError, StaleInputError
from camrob.measurement.log_info import LogInfo, MeasuredFrame, Target
from camrob.measurement.read_log import read_log
from camrob.measurement.write_log import write_log
from camrob.se3 import frame_from_xyzabc


def test_planted_errors_are_found_within_their_standard_errors() -> None:
    """A set without redundancies comes back value by value; the standard errors are honest."""
    names = ["tool.x", "tool.z", "A2.zero", "A3.zero", "A4.rx", "A5.zero", "A3.compliance", "E1.scale", "A3.cos2"]
    true = dict(zip(names, [3e-4, -2e-4, 1e-3, -5e-4, 8e-4, 6e-4, 2e-6, 2e-4, 3e-4], strict=True))
    data = measure(CELL, true, axis_values(CELL, 150))
    found = calibrate_cell(CELL, data, names=names, share=0.0).parameters
    off = np.array([(found[n].value - true[n]) / found[n].std for n in names])
    assert np.all(np.abs(off) < 4.0) and 0.3 < np.sqrt(np.mean(off**2)) < 2.0
    assert all(p.std < 0.3 * p.scale for p in found.items_)


@pytest.mark.parametrize("oriented", [True, False])
def test_a_whole_calibration_predicts_withheld_poses(oriented: bool) -> None:
    data = measure(CELL, drawn(CELL), axis_values(CELL, 300))
    result = calibrate_cell(CELL, data if oriented else data.without_orientation())
    nominal, after = result.errors["nominal/withheld"], result.errors["calibrated/withheld"]
    assert nominal.mean > 1e-3
    assert after.mean < 4.5e-5  # three axes of 0.02 mm make 0.032 mm
    assert after.rows == 60 and result.rows == 240
    lost = {h.name: h.others for h in result.held}
    assert lost["A1.x"] == ("base.x",) or "base.x" in lost["A1.x"]
    assert any("base.rz" in h.others for h in result.held if h.name == "A1.zero")
    if not oriented:
        assert {"tool.rx", "tool.ry", "tool.rz"} <= set(lost)
    assert len(result.observability) == 5 and result.observability[1] == pytest.approx(1.0 / result.condition)


def test_an_unknown_instrument_and_reflector_are_fitted_as_nuisance() -> None:
    left, right = (
        frame_from_xyzabc([2.0, -3.0, 0.4, 2.5, 0.3, -1.0]),
        frame_from_xyzabc([0.05, 0.1, -0.08, 1.0, 0.5, 2.0]),
    )
    true = drawn(CELL)
    data = replace(
        measure(CELL, true, axis_values(CELL, 250), left=left, right=right), frame_known=False, target_known=False
    )
    for part in (data, data.without_orientation()):
        result = calibrate_cell(CELL, part)
        assert "nominal/withheld" not in result.errors
        assert result.errors["calibrated/withheld"].mean < 5e-5
        own = [p for p in result.parameters if p not in result.nuisance]
        assert set(result.nuisance) >= {"base.x", "tool.y"} and not any(n[:4] in ("base", "tool") for n in own)


@pytest.mark.parametrize("seed", [2, pytest.param(6, marks=pytest.mark.slow), pytest.param(7, marks=pytest.mark.slow)])
def test_what_an_unknown_frame_shares_with_the_robot_does_not_carry_the_robot_off(seed: int) -> None:
    """Sixty places of a tracker that stands anywhere: in its own base the calibrated robot is far nearer to the true one than the
    nominal is. Its first axes' places, hardly told from the frame, put it 2.7 mm off where the nominal one was 1.7."""
    values = axis_values(CELL, 60, seed)
    values[:, 6:] = 0.0
    values[:, [0, 3]] *= 0.4
    true = {
        n: v for n, v in drawn(CELL, seed).items() if not n.startswith(("A1", "E", "A2.ry")) and "compliance" not in n
    }
    left, right = (
        frame_from_xyzabc([2.0, -3.0, 0.4, 2.5, 0.3, -1.0]),
        frame_from_xyzabc([0.05, 0.1, -0.08, 0.0, 0.0, 0.0]),
    )
    seen = measure(CELL, true, values, left=left, right=right, sigma=1e-4, seed=seed).without_orientation()
    found = calibrate_cell(CELL, replace(seen, frame_known=False, target_known=False))
    own = {p.name: p.value for p in found.parameters.items_ if p.name not in found.nuisance}

    def places(errors: dict[str, float]) -> np.ndarray:
        model = ErrorModel.of(CELL, tuple(errors), in_base=True)
        return model.poses(np.array(list(errors.values())), CELL.to_q(values))[:, :3, 3]

    def off(errors: dict[str, float]) -> float:
        return float(np.linalg.norm(places(errors) - places(true), axis=1).mean())

    assert off(own) < 0.4 * off({})
    assert any("set the base up anew" in said for said in found.warnings)


def test_the_instrument_is_placed_from_poses() -> None:
    rng = np.random.default_rng(0)
    nominal = frame_from_xyzabc(rng.normal(size=(40, 6)))
    left, right = frame_from_xyzabc(rng.normal(size=6)), frame_from_xyzabc(0.2 * rng.normal(size=6))
    measured = left @ nominal @ right
    found = align(nominal, measured, oriented=True, frame_known=False, target_known=False)
    assert np.allclose(found[0], left, atol=1e-9) and np.allclose(found[1], right, atol=1e-9)
    found = align(nominal, measured, oriented=False, frame_known=False, target_known=False)
    assert np.allclose(found[0], left, atol=1e-5) and np.allclose(found[1][:3, 3], right[:3, 3], atol=1e-5)
    one = nominal.copy()
    one[:, :3, :3] = nominal[0, :3, :3]  # a single orientation: the places say where the frame is
    found = align(one, left @ one @ right, oriented=True, frame_known=False, target_known=False)
    assert np.allclose(found[0] @ one @ found[1], left @ one @ right, atol=1e-9)
    line = nominal.copy()
    line[:, 1:3, 3] = 0.0
    with pytest.raises(SingularError, match=r"found: its [0-9]+ poses are on one line; measure 4"):
        align(line, left @ line, oriented=True, frame_known=False, target_known=True)


def test_outliers_are_counted_and_don_t_pull() -> None:
    true = {"A2.zero": 1e-3, "tool.x": 2e-4}
    data = measure(CELL, true, axis_values(CELL, 200))
    frames = np.array(data.frames)
    frames[::20, :3, 3] += 0.005
    result = calibrate_cell(CELL, replace(data, frames=frames), names=list(true), share=0.0)
    assert result.outliers == 10
    assert result.parameters["A2.zero"].value == pytest.approx(1e-3, abs=2e-5)


def test_measured_from_the_turning_base_shows_the_table() -> None:
    true = {"E2.x": 4e-4, "E2.ry": 3e-4, "A2.zero": 5e-4}
    data = replace(measure(CELL, true, axis_values(CELL, 200), in_base=True), in_base=True)
    result = calibrate_cell(CELL, data, share=0.0)
    assert result.parameters["E2.x"].value == pytest.approx(4e-4, abs=2e-5)
    assert result.parameters["E2.ry"].value == pytest.approx(3e-4, abs=2e-5)
    plain = calibrate_cell(CELL, measure(CELL, {"A2.zero": 5e-4}, axis_values(CELL, 100)), share=0.0)
    assert not any(n.startswith("E2") for n in plain.parameters)


def test_hopeless_fits_are_refused_by_name() -> None:
    data = measure(CELL, {"A2.zero": 1e-3}, axis_values(CELL, 100))
    with pytest.raises(SingularError, match=r"A1\.x can.t be fitted.*base\.x"):
        calibrate_cell(CELL, data, names=["base.x", "A1.x"])
    still = axis_values(CELL, 100)
    still[:, 3] = 20.0  # A4 stands still
    with pytest.raises(SingularError, match="can't be fitted to these poses"):
        calibrate_cell(CELL, measure(CELL, {}, still), names=["A4.zero", "A4.cos1"])
    with pytest.raises(LogError, match="holds 5 whole poses"):
        calibrate_cell(CELL, data.select(slice(0, 5)), share=0.0)
    asked = [f"base.{p}" for p in PARTS] + ["tool.x", "tool.y", "tool.z", *(f"A{k}.zero" for k in (2, 3, 4, 5)), "A3.x"]
    with pytest.raises(LogError, match="14 parameters need at least 10"):
        calibrate_cell(CELL, data.select(slice(0, 9)).without_orientation(), names=asked, share=0.0)
    wrong = measure(CELL, {"A6.zero": 0.2}, axis_values(CELL, 60))
    with pytest.raises(JobError, match=r"A6\.zero ended at the bound of what is plausible"):
        calibrate_cell(CELL, wrong, names=["A6.zero"])
    turned = replace(data, q=-np.array(data.q))
    with pytest.raises(JobError, match=r"can't be this cell's: with base and tool fitted, \d+"):
        calibrate_cell(CELL, turned)
    with pytest.raises(LogError, match="is not an error parameter"):
        calibrate_cell(CELL, data, names=["A6.frobnicate"])


def test_what_the_data_tell() -> None:
    rng = np.random.default_rng(2)
    a, b = 100 * rng.normal(size=(2, 300))
    J = np.stack([a, b, a - 2 * b, np.zeros(300), 1e-4 * rng.normal(size=300)], axis=1)
    seen = identify(("a", "b", "ab", "none", "faint"), J, np.ones(5))
    assert seen.kept == ("a", "b")
    assert seen.merged == {"ab": ("b", "a")}
    assert seen.unseen == ("none",) and seen.weak == ("faint",)
    assert seen.left_out == ("ab", "none", "faint")
    s = np.array([4.0, 1.0])
    index = Observability.of(s, 4)
    assert (index.o1, index.o2, index.o3, index.o4, index.o5) == (1.0, 0.25, 1.0, 0.25, 0.8)
    with pytest.raises(ValueError, match="none of the parameters"):
        identify(("z",), np.zeros((5, 1)), np.ones(1))


def test_logs_are_held_to_the_cell() -> None:
    log = log_of(CELL, measure(CELL, {}, axis_values(CELL, 20)))
    assert len(measurements_of(log, CELL)) == 20
    lacking = replace(log, columns={n: v for n, v in log.columns.items() if n != "E1"})
    with pytest.raises(LogError, match="has no column E1"):
        measurements_of(lacking, CELL)
    other = read_cell(ROOT / "tests" / "data" / "ur10")
    with pytest.raises(LogError, match=r"moves E1, which cell ur10 lacks"):
        measurements_of(log, other)
    gaps = {n: np.array(v) for n, v in log.columns.items()}
    gaps["x"][:5] = np.nan
    assert measurements_of(replace(log, columns=gaps), CELL).left_out == 5
    gaps["x"][:] = np.nan
    with pytest.raises(LogError, match="holds no whole row"):
        measurements_of(replace(log, columns=gaps), CELL)


def test_the_file_says_what_was_found(tmp_path) -> None:
    result = calibrate_cell(CELL, measure(CELL, drawn(CELL), axis_values(CELL, 80)))
    path = tmp_path / "C.toml"
    path.write_text(calibration_text(result))
    back = read_calibration(path, CELL)
    assert calibration_text(back) == path.read_text()
    assert np.allclose(back.parameters.values_array, result.parameters.values_array, rtol=1e-14, atol=0)
    heavier = replace(CELL, masses=(*CELL.masses, PointMass("more", "A6", 5.0, np.zeros(3))))
    with pytest.raises(StaleInputError, match="has changed since"):
        read_calibration(path, heavier)
    assert read_calibration(path, CELL.with_tool(np.eye(4))).rows == 64
    for old, new, message in [
        ('unit = "mm"', 'unit = "m"', "base.x is in mm"),
        ("schema = 1", "schema = 2", "schema: is 2"),
        ('name = "A2.zero"', 'name = "A9.zero"', "is not an error parameter"),
        ("value = ", "value = 1e9 #", "value: lies beyond"),
        ("nuisance = false", "nuisance = 0", "nuisance: is 0"),
    ]:
        text = path.read_text()
        start = text.index("A2.zero") if "1e9" in new else 0
        (tmp_path / "bad.toml").write_text(text[:start] + text[start:].replace(old, new, 1))
        with pytest.raises(LogError, match=message):
            read_calibration(tmp_path / "bad.toml", CELL)
    (tmp_path / "setup.toml").write_text("part_in_base = [0, 0, 200, 0, 0, 0]\n")
    with pytest.raises(LogError, match="is no calibration; give"):
        read_calibration(tmp_path / "setup.toml", CELL)


def test_the_command(tmp_path, capsys) -> None:
    info = LogInfo(sigma_position=2e-5, sigma_angle=1e-5, poses=True)
    write_log(log_of(CELL, measure(CELL, drawn(CELL), axis_values(CELL, 120)), info), tmp_path / "m.csv")
    cell = str(ROOT / "cells" / "kr15_track_table")
    command = ["calibrate", str(tmp_path / "m.csv"), "--cell", cell, "--out", str(tmp_path / "o" / "C.toml")]
    assert run([*command, "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["errors"]["calibrated/withheld"]["mean_mm"] < 0.06 < summary["errors"]["nominal/withheld"]["mean_mm"]
    assert (tmp_path / "o" / "C.toml").is_file()
    assert run(command) == 0
    shown = {line.split()[0]: "may be 0" in line for line in capsys.readouterr().out.splitlines() if line.split()}
    for p in summary["parameters"]:  # a value within its doubt is marked, no other
        assert shown[p["name"]] is (abs(p["value"]) < 2 * p["std"])
    assert set(shown[p["name"]] for p in summary["parameters"]) == {True, False}
    assert run([*command, "--parameter", "A7.zero", "--quiet"]) == 2
    assert "is not an error parameter" in capsys.readouterr().err
    assert run([*command, "--parameter", "base.x", "--parameter", "A1.x"]) == 3
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


UR10 = SHARED / "real" / "ur10_tmac"
needs_ur10 = pytest.mark.skipif(not UR10.is_dir(), reason="../shared is not here: real/ur10_tmac")


def ur10(series: str):
    cell = read_cell(ROOT / "tests" / "data" / "ur10")
    log = read_log(UR10 / f"{series}.csv")
    assert (log.info.measured_frame, log.info.target) == (MeasuredFrame.UNKNOWN, Target.UNKNOWN)
    return cell, measurements_of(log, cell)


@pytest.mark.slow
@needs_ur10
@pytest.mark.parametrize(("series", "quick_fit", "with_gears"), [("A", 0.39, 0.38), ("D", 0.305, 0.297)])
def test_a_real_robot_is_fitted_as_well_as_the_quick_fit(series: str, quick_fit: float, with_gears: float) -> None:
    """Mean error in mm on a withheld 30 %, beside what stands in the data's README."""
    cell, data = ur10(series)
    plain = calibrate_cell(cell, data, share=0.3)
    assert 1e3 * plain.errors["calibrated/withheld"].mean <= quick_fit
    assert plain.errors["frames/withheld"].mean > 1.7 * plain.errors["calibrated/withheld"].mean
    gears = calibrate_cell(cell, data, share=0.3, candidates=standard_names(cell, harmonics=2))
    assert 1e3 * gears.errors["calibrated/withheld"].mean <= with_gears
    assert any("something else is at work" in w for w in gears.warnings)  # 0.01 mm of noise, 0.3 mm left


@pytest.mark.slow
@needs_ur10
@pytest.mark.parametrize(("train", "other", "reached"), [("A", "D", 0.36), ("D", "A", 0.42)])
def test_a_real_robot_s_parameters_carry_over_to_another_series(train: str, other: str, reached: float) -> None:
    """Only the robot's own parameters carry over; base and reflector are refitted on half of the other series."""
    cell, data = ur10(train)
    robot = calibrate_cell(cell, data, share=0.0, candidates=standard_names(cell, harmonics=2)).parameters
    data = ur10(other)[1]
    half = np.random.default_rng(1).permutation(len(data)) < len(data) // 2
    means = []
    for known in (ParameterSet.of(()), robot):
        model, fit = fit_frames(cell, data.select(half), known)
        left = residuals(model, fit.parameters.values_array, data.select(~half))[:, :3]
        means.append(1e3 * np.linalg.norm(left, axis=1).mean())
    assert means[0] > 0.70 and means[1] < reached


def test_frames_that_are_inverted_are_seen() -> None:
    """The signs of an error frame are not those of its inverse."""
    true = {"base.x": 1e-3, "base.rz": 2e-3}
    data = measure(CELL, true, axis_values(CELL, 60))
    found = calibrate_cell(CELL, data, names=["base.x", "base.rz"], share=0.0).parameters
    assert found["base.rz"].value == pytest.approx(2e-3, abs=1e-5)


SAMPLES = SHARED / "gap_samples"


@pytest.mark.skipif(not SAMPLES.is_dir(), reason="../shared is not here: gap_samples")
def test_errors_that_other_code_made_are_found() -> None:
    """Runs of a cell that another program simulated; its labels are the truth, a circle elsewhere is withheld."""
    truth = json.loads((SAMPLES / "labels.json").read_text())

    def calibrated(case: str, run_name: str, names: list[str]):
        fitted, other = (
            measurements_of(read_log(SAMPLES / "cases" / case / f"{name}.csv"), CELL) for name in (run_name, "circle1")
        )
        result = calibrate_cell(CELL, fitted, names=names, withheld=other)
        assert result.errors["nominal/withheld"].mean > 6e-4
        assert result.errors["calibrated/withheld"].mean < 3.5e-5  # three axes of 0.02 mm make 0.032 mm
        return result.parameters

    found = calibrated("b_joint_offset", "tour0", ["A3.zero", "A5.zero"])
    zeros = np.rad2deg([found["A3.zero"].value, found["A5.zero"].value])
    assert np.allclose(zeros, truth["b_joint_offset"]["effects"]["joint_offset"]["deg"], atol=1e-4)
    tool = [f"tool.{k}" for k in ("x", "y", "z", "rx", "ry", "rz")]
    found = calibrated("e_tool_and_compliance", "dome0", [*tool, "A2.compliance", "A3.compliance", "A5.compliance"])
    want = truth["e_tool_and_compliance"]["effects"]
    assert np.allclose([1e3 * found[n].value for n in tool[:3]], want["frame_tool"]["v"][:3], atol=2e-3)
    assert np.allclose([found[n].value for n in tool[3:]], want["frame_tool"]["v"][3:], atol=2e-6)
    for k in (2, 3, 5):  # the run itself asks for 1.5 % less of A2 and A3: see test_calibration_sets
        assert found[f"A{k}.compliance"].value == pytest.approx(want["joint_compliance"]["compl"][k - 1], rel=0.02)
