"""Margins: known distances to limits, planted violations, singular postures, jumps and external travel."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from camrob.cell.read_cell import read_cell
from camrob.checks.margins import check_margins
from camrob.findings import Severity
from camrob.kinematics.kernels import chain_arrays, inverse_kf_many

CELL = read_cell(Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table")
HOME_VALUES = {"A1": 0.0, "A2": -90.0, "A3": 90.0, "A4": 0.0, "A5": 90.0, "A6": 0.0, "E1": 0.0, "E2": 0.0}


def axis_path(count=2, **series):
    """Postures whose axes hold HOME's values but for those named; degrees and mm."""
    values = np.array([[HOME_VALUES[n] for n in CELL.axis_names]] * count)
    for name, value in series.items():
        values[:, CELL.axis_names.index(name)] = value
    return CELL.to_q(values)


def run(q, *, inv_kf=None, cutting=None, line=None, cell=CELL):
    m = len(q)
    return check_margins(
        cell,
        q,
        inv_kf=inverse_kf_many(chain_arrays(cell), q) if inv_kf is None else inv_kf,
        cutting=np.ones(m, bool) if cutting is None else cutting,
        line=np.arange(10, 10 + m) if line is None else line,
        region=np.zeros(m, int),
    )


def test_margins_at_home_are_those_of_the_cells_table():
    report = run(axis_path(1))
    expected = {"A1": 185, "A2": 55, "A3": 70, "A4": 350, "A5": 45, "A6": 350, "E1": 1500, "E2": None}
    assert set(report.margin_min) == set(expected)
    for name, value in expected.items():
        assert report.margin_min[name] == (None if value is None else pytest.approx(value, abs=1e-9)), name
    assert report.violations == 0 and report.singular == 0 and not report.findings
    assert report.inv_kf_min == pytest.approx(0.5725, abs=1e-4)
    assert report.external_travel == {"E1_mm": 0.0, "E2_deg": 0.0}


def test_a_planted_violation_is_an_error_at_its_worst_point():
    report = run(axis_path(5, A2=[10, 24, 25.5, 26, 24.9]))
    finding = next(f for f in report.findings if f.code == "axis-limit")
    assert (finding.axis, finding.point, finding.line, finding.count) == ("A2", 3, 13, 2)
    assert finding.severity is Severity.ERROR and finding.unit == "degrees"
    assert finding.value == pytest.approx(26) and finding.limit == pytest.approx(25)
    assert report.violations == 2 and report.margin_min["A2"] == pytest.approx(-1.0)
    both = run(axis_path(5, A2=[10, 24, 25.5, 26, 24.9], E1=[0, 0, 1501, 0, -1502]))
    assert both.violations == 3 and both.margin_min["E1"] == pytest.approx(-2.0)


def test_close_to_a_limit_is_a_remark_and_on_the_limit_no_violation():
    report = run(axis_path(2, A5=[131, 135], E1=[-1485, 0]))
    assert report.violations == 0
    assert {f.axis: f.severity for f in report.findings if f.code == "axis-margin"} == {
        "A5": Severity.INFO,
        "E1": Severity.INFO,
    }
    near = next(f for f in report.findings if f.axis == "E1")
    assert near.limit == pytest.approx(-1500) and near.unit == "mm" and near.value == pytest.approx(-1485)
    assert not run(axis_path(2, A5=[125, 129], E1=[-1475, 0])).findings


def test_axes_with_reversed_sign_and_endless_ones():
    """A5 counts against its row's angle; the table has no margin however far it turns."""
    report = run(axis_path(2, A5=[-100, -134], E2=[0, 3600]))
    assert report.margin_min["A5"] == pytest.approx(1.0) and report.margin_at["A5"] == 1
    assert report.margin_min["E2"] is None and report.margin_at["E2"] == -1


def test_singular_postures_are_counted():
    q = axis_path(4, A5=[30, 0.0, 0.1, 30])
    report = run(q)
    assert report.singular == 2 and report.inv_kf_at == 1 and report.inv_kf_min == pytest.approx(0, abs=1e-6)
    finding = next(f for f in report.findings if f.code == "singular")
    assert finding.count == 2 and finding.point == 1 and finding.severity is Severity.ERROR
    assert report.inv_kf_mean == pytest.approx(inverse_kf_many(chain_arrays(CELL), q).mean())


def test_a_wrist_flip_is_a_jump_and_a_long_step_is_none():
    flip = run(axis_path(2, A4=[0, 180], A5=[60, -60], A6=[0, -180]))  # the same pose by the wrist's other branch
    assert flip.jumps.tolist() == [1]
    finding = next(f for f in flip.findings if f.code == "jump")
    assert finding.axis in ("A4", "A6") and finding.value == pytest.approx(180.0) and finding.line == 11
    assert flip.axis_step_deg_max == pytest.approx(180.0) and flip.midpoint_mm_max > 50.0
    assert run(axis_path(2, A4=[0, 180], A5=[60, -60], A6=[0, -180]), cutting=[False, False]).jumps.size == 0
    sweep = run(axis_path(2, A1=[0, 30]))
    assert sweep.jumps.size == 0 and sweep.axis_step_deg_max == pytest.approx(30.0)


def test_midpoint_deviation_of_a_turn_about_a1_is_the_arcs_sagitta():
    """Half-way in A1 the tip stands on the arc: r (1 - cos(step / 2)) above the chord."""
    report = run(axis_path(2, A1=[-5, 5]))
    x, y = 97.0 + 803.0, -41.764  # the tip from A1's axis at HOME, mm: the foot is at x = -803
    assert report.midpoint_mm_max == pytest.approx(np.hypot(x, y) * (1 - np.cos(np.radians(5))), rel=1e-6)


def test_external_travel_counts_cutting_moves_alone_and_both_ways():
    q = axis_path(4, E1=[0, 10, -5, 95], E2=[0, 90, 90, 0])
    report = run(q, cutting=[True, True, True, False])
    assert report.external_travel["E1_mm"] == pytest.approx(25.0)
    assert report.external_travel["E2_deg"] == pytest.approx(90.0)


def test_points_of_camrob_take_the_line_before_them():
    report = run(axis_path(3, A2=[0, 0, 26]), line=[7, 9, 0])
    assert next(f for f in report.findings if f.code == "axis-limit").line == 9


def test_what_does_not_fit_is_refused():
    with pytest.raises(ValueError):
        run(np.zeros((0, len(CELL))), inv_kf=np.zeros(0))
    with pytest.raises(ValueError):
        run(axis_path(2), inv_kf=np.ones(3))
    with pytest.raises(ValueError):
        run(axis_path(2) * np.nan, inv_kf=np.ones(2))


def test_the_report_is_locked():
    report = run(axis_path(1))
    with pytest.raises(TypeError):
        report.margin_min["A1"] = 0.0  # type: ignore[index]
    with pytest.raises(AttributeError):
        report.violations = 3  # type: ignore[misc]
    assert replace(report, violations=1).violations == 1
