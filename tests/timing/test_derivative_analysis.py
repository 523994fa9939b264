"""Derivatives of machine coordinates over total displacement: laws, the paper's use case, planted violations."""

from __future__ import annotations

import json

import numpy as np
import pytest
from feed_paths import CELL, wave

from camrob.calibration.calibration import Calibration, robot_digest
from camrob.calibration.calibration_file import calibration_text
from camrob.calibration.parameters import ParameterSet
from camrob.calibration.terms import parameter_of
from camrob.cell.read_cell import read_cell
from camrob.cli.app import run
from camrob.jobs.derivatives import Coordinates, calibrated
from camrob.kinematics.frames import base_T_tool
from camrob.studies.straight_line import straight_line
from camrob.timing.derivative_analysis import Interpolation, analyse_derivatives, machine_length

SMOOTH = Interpolation.SMOOTH
KR500 = read_cell(CELL.folder.parent / "kr500_afp")


def line_postures() -> np.ndarray:
    """The paper's use case: 297 points 5 mm apart on a straight line."""
    return straight_line(CELL, CELL.q_home, np.array([0.0, 0.0, -1.0]), step=0.005, count=297)


def test_the_straight_line_is_one():
    tips = base_T_tool(CELL, line_postures())[:, :3, 3]
    assert np.linalg.norm(tips[-1] - tips[0]) == pytest.approx(1.48, abs=1e-9)
    assert np.allclose(np.linalg.norm(np.diff(tips, axis=0), axis=1), 0.005, atol=1e-9)
    assert np.allclose(tips[:, :2], tips[0, :2], atol=1e-9)


@pytest.mark.parametrize("kind", list(Interpolation))
def test_the_first_derivative_is_a_unit_vector_and_s_the_length(kind):
    analysis = analyse_derivatives(CELL, line_postures(), interpolation=kind)
    assert len(analysis.s) == 2901
    assert analysis.s[-1] == pytest.approx(machine_length(CELL, line_postures())[-1])
    scale = np.array([CELL.condition_length if a == "E1" else 1.0 for a in analysis.axes])
    norm = np.linalg.norm(analysis.q_s / scale, axis=1)
    assert norm[50:-50] == pytest.approx(1.0, abs=2e-3)


def test_smoothing_invents_no_jerk_and_linear_interpolation_does():
    q = line_postures()
    linear, smooth = analyse_derivatives(CELL, q), analyse_derivatives(CELL, q, interpolation=SMOOTH)
    assert np.abs(linear.q_sss).max() > 100.0 * np.abs(smooth.q_sss).max()
    assert linear.violations() and not smooth.violations()
    fine = analyse_derivatives(CELL, q, parts=5800)
    assert np.abs(fine.q_sss).max() > 2.0 * np.abs(linear.q_sss).max()  # it grows without end


def test_a_known_curve_is_differentiated():
    """Two axes on a circle in joint space: s is the angle times the radius."""
    t = np.linspace(0.0, 2.0, 400)
    q = np.tile(CELL.q_home, (400, 1))
    q[:, CELL.index("A1")] += 0.5 * np.cos(t)
    q[:, CELL.index("A2")] += 0.5 * np.sin(t)
    found = analyse_derivatives(CELL, q, interpolation=SMOOTH, resolution=1e-7)
    k, inner = found.axes.index("A1"), slice(100, -100)
    angle = found.s / 0.5
    assert found.q_s[inner, k] == pytest.approx(-np.sin(angle[inner]), abs=1e-3)
    assert found.q_ss[inner, k] == pytest.approx(-np.cos(angle[inner]) / 0.5, abs=2e-2)
    assert found.q_sss[inner, k] == pytest.approx(np.sin(angle[inner]) / 0.25, abs=0.3)


def test_admitted_rates_and_constraints_are_the_papers():
    found = analyse_derivatives(CELL, wave(300), interpolation=SMOOTH)
    b = found.bounds
    at = 700
    assert found.rate_speed[at] == pytest.approx(np.min(b.speed / np.abs(found.q_s[at])))
    assert found.rate_acceleration[at] == pytest.approx(np.sqrt(np.min(b.acceleration / np.abs(found.q_ss[at]))))
    assert found.rate_jerk[at] == pytest.approx(np.cbrt(np.min(b.jerk / np.abs(found.q_sss[at]))))
    assert len(found.constraints()) == 6
    assert np.abs(found.constraints(2.0)["q_ss / a (24)"]) == pytest.approx(np.abs(4.0 * found.q_ss / b.acceleration))


def test_a_planted_kink_is_found_with_its_axis_and_line():
    q = line_postures().copy()
    q[150, CELL.index("A4")] += 0.02
    found = analyse_derivatives(CELL, q, line=np.arange(297) + 1000, interpolation=SMOOTH).violations(0.5)
    worst = max(found, key=lambda v: v.worst)
    assert worst.axis == "A4" and worst.quantity == "jerk"
    assert abs(worst.line - 1150) <= 3


def test_long_travel_between_dense_points_makes_no_waves():
    """A program's travel is one long step; a spline left to itself there would swing."""
    q = np.concatenate([line_postures(), line_postures() + 0.8])
    found = analyse_derivatives(CELL, q, interpolation=SMOOTH)
    away = np.abs(np.asarray(found.s) - machine_length(CELL, q)[296]) > 0.3
    away &= np.abs(np.asarray(found.s) - machine_length(CELL, q)[297]) > 0.3
    scale = np.array([CELL.condition_length if a == "E1" else 1.0 for a in found.axes])
    assert np.linalg.norm(found.q_s / scale, axis=1)[away].max() < 1.01
    assert np.linalg.norm(found.q_s / scale, axis=1).max() < 1.25


def test_too_few_postures_are_refused():
    with pytest.raises(ValueError, match="8 different"):
        analyse_derivatives(CELL, np.tile(CELL.q_home, (20, 1)))


def test_the_command_compares_nominal_and_compensated(tmp_path, capsys):
    q = line_postures()
    files = []
    for name, shift in (("a", 0.0), ("b", 1e-3)):
        files.append(tmp_path / f"{name}.path.npz")
        np.savez(files[-1], q=q + shift, line=np.arange(297), axes=np.array(CELL.names))
    arguments = ["feed", "--cell", str(CELL.folder), "--solution", str(files[0]), "--compensated", str(files[1])]
    assert run([*arguments, "--out", str(tmp_path / "out"), "--axis", "A3"]) == 0
    assert "compensated" in (tmp_path / "out" / "feed.html").read_text(encoding="utf-8")
    capsys.readouterr()
    assert run([*arguments, "--out", str(tmp_path / "out"), "--axis", "Z9"]) == 2
    assert "Z9" in capsys.readouterr().err
    (tmp_path / "no.path.npz").write_bytes(b"PK\x03\x04 nothing")
    assert (
        run(["feed", "--cell", str(CELL.folder), "--solution", str(tmp_path / "no.path.npz"), "--out", str(tmp_path)])
        == 2
    )


def feed_json(tmp_path, *more):
    assert run(["feed", "--cell", str(KR500.folder), "--out", str(tmp_path / "out"), "--quiet", *more]) == 0
    return json.loads((tmp_path / "out" / "feed.json").read_text(encoding="utf-8"))


def test_the_papers_line_on_its_machine_nominal_beside_compensated(tmp_path):
    summary = feed_json(tmp_path, "--axis", "all")
    found = {(a["interpolation"], a["coordinates"]): a for a in summary["analyses"]}
    assert set(found) == {(i, c) for i in ("linear", "smooth") for c in ("nominal", "compensated")}
    smooth = [found["smooth", which] for which in ("nominal", "compensated")]
    assert smooth[1]["violations"] <= smooth[0]["violations"] <= 1  # compensation causes none, as published
    assert found["linear", "nominal"]["violations"] > 500  # the interpolation's own
    for kind, least in smooth[0]["rate_admitted"].items():
        assert smooth[1]["rate_admitted"][kind] == pytest.approx(least, rel=0.01)
    verdicts = [s["verdict"] for s in summary["statements"]]
    assert len(verdicts) == 6 and verdicts[0] == "holds" and set(verdicts) <= {"holds", "does not hold", "unclear"}
    page = (tmp_path / "out" / "feed.html").read_text(encoding="utf-8")
    assert all(f'data-choice="{axis} {kind}"' in page for axis in KR500.axis_names for kind in ("linear", "smooth"))


def test_the_terminal_shows_statements_and_the_worst_places(tmp_path, capsys):
    assert run(["feed", "--cell", str(KR500.folder), "--out", str(tmp_path / "out")]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert (
        "unclear" in printed and "compensated, smooth interpolation: stretches past a limit at 1.00 rad/s 1;" in printed
    )
    assert "A3 acceleration 1.33 times at point 1" in printed and len(printed) < 6000


def test_the_virtual_roll_is_not_put_into_the_arm(tmp_path):
    """A2 that stands 1 mrad off: the corrected arm, turned on by that, has the tool where it was meant; roll or none."""
    q = line_postures()
    rolled = np.array(q)
    rolled[:, -1] = np.linspace(-0.7, 0.4, len(q))
    one = ParameterSet.of([parameter_of(CELL, "A2.zero")]).with_values(np.array([1e-3]), np.array([1e-6]))
    figures = {"scatter_position": 0.0, "condition": 1.0, "observability": (1.0,) * 5}
    file = tmp_path / "CALIBRATION.toml"
    file.write_text(calibration_text(Calibration(CELL.name, robot_digest(CELL), one, **figures)), encoding="utf-8")
    corrected = calibrated(CELL, Coordinates(rolled, np.arange(len(q)), 1e-6, "x"), file).q
    assert np.abs(corrected - rolled).max() < 0.01 and np.array_equal(corrected[:, -1], rolled[:, -1])
    off = []
    for sign in (1.0, -1.0):
        real = np.array(corrected)
        real[:, CELL.index("A2")] += sign * 1e-3
        off.append(np.abs(base_T_tool(CELL, real) - base_T_tool(CELL, rolled)).max())
    assert min(off) < 1e-9 < 1e-4 < max(off)


def test_a_calibration_compensates_the_line(tmp_path):
    one = ParameterSet.of([parameter_of(KR500, "A2.zero")]).with_values(np.array([1e-3]), np.array([1e-6]))
    figures = {"scatter_position": 0.0, "condition": 1.0, "observability": (1.0,) * 5}
    calibration = Calibration(KR500.name, robot_digest(KR500), one, **figures)
    file = tmp_path / "CALIBRATION.toml"
    file.write_text(calibration_text(calibration), encoding="utf-8")
    summary = feed_json(tmp_path, "--calibration", str(file))
    assert summary["sources"][1] == "compensated with CALIBRATION.toml" and len(summary["analyses"]) == 4
    out = ["--cell", str(KR500.folder), "--out", str(tmp_path / "no")]
    assert run(["feed", *out, "--compensated", str(file)]) == 2
    assert run(["feed", *out, "--calibration", str(file), "--compensated", str(file)]) == 2
