"""Few poses of an arm that is off by much: what is weak beside the errors of base and tool is what is lacking there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from calibration_sample import ROOT, axis_values, measure
from scipy.optimize import least_squares

from camrob.calibration import calibrate
from camrob.calibration.calibrate import fit_cell
from camrob.calibration.fit import fit_parameters, residuals
from camrob.calibration.folds import left_in_folds
from camrob.calibration.measurements import Measurements
from camrob.calibration.parameters import ParameterSet
from camrob.calibration.sets import named_parameter, prepare_sets
from camrob.calibration.terms import FRAMES
from camrob.cell.read_cell import read_cell
from camrob.se3 import frame_from_xyzabc

CELL = read_cell(ROOT / "tests" / "data" / "ur10")
SEEN = {"left": frame_from_xyzabc([2.0, -3.0, 0.4, 2.5, 0.3, -1.0])}
SEEN |= {"right": frame_from_xyzabc([0.05, 0.1, -0.08, 1.0, 0.5, 2.0])}
OFF = {f"A{k}.zero": v for k, v in zip((2, 3, 4, 5), (2e-3, -4e-3, 2e-2, -8e-3), strict=True)}  # rad
OFF |= {"A3.x": 2e-3, "A4.y": -1.5e-3, "A5.x": 1e-3, "A6.x": 2e-3, "A3.rx": 1e-3, "A5.ry": -2e-3, "A6.rx": 2e-3}


def far_off(count: int) -> Measurements:
    """Positions alone, seen from an unknown stand, of an arm whose wrist is off by a degree."""
    data = measure(CELL, OFF, axis_values(CELL, count, seed=3), seed=4, sigma=5e-5, **SEEN)
    return replace(data.without_orientation(), frame_known=False, target_known=False, name="far.csv")


def test_as_many_parameters_are_fitted_as_say_more_of_poses_left_out(monkeypatch) -> None:
    data = far_off(50)
    monkeypatch.setattr(calibrate, "_FOLDED", 0)  # nothing is held to its ordinary size
    found = fit_cell(CELL, data).calibration
    monkeypatch.setattr(calibrate, "_CLEARER", ())
    few = fit_cell(CELL, data).calibration
    many, less = (c.errors["calibrated/withheld"].mean for c in (found, few))
    assert len(found.parameters) > len(few.parameters)
    assert less > 8e-4 and many < 1.5e-4  # m; the noise is 0.09 mm in three directions


def test_folds_leave_a_posture_out_whole_and_gross_rows_do_not_choose() -> None:
    names = (*FRAMES[:3], "tool.x", "tool.y", "tool.z", "A2.zero", "A3.zero", "A4.zero", "A5.zero")
    data = far_off(40)
    twice = data.select(np.repeat(np.arange(40), 2))
    assert left_in_folds(prepare_sets(CELL, [data], names), CELL, names) == pytest.approx(
        left_in_folds(prepare_sets(CELL, [twice], names), CELL, names), rel=0.25
    )
    gross = np.array(data.frames)
    gross[7, 0, 3] += 0.05
    moved = prepare_sets(CELL, [replace(data, frames=gross)], names)
    whole = left_in_folds(prepare_sets(CELL, [data], names), CELL, names)
    assert left_in_folds(moved, CELL, names) < 2.0 * whole
    path = prepare_sets(CELL, [replace(data, single=False)], names)
    assert left_in_folds(path, CELL, names) == pytest.approx(whole, rel=0.5)


def test_ten_poses_are_fitted_with_every_parameter_held_to_its_size() -> None:
    """They were refused: 15 parameters of 8 poses."""
    off = {f"A{k}.zero": v for k, v in zip((2, 3, 4, 5), (1e-3, -1.5e-3, 2e-3, -1e-3), strict=True)}
    off |= {"A3.x": 4e-4, "A4.y": -3e-4, "A5.x": 3e-4, "A6.rx": 2e-4}
    asked = measure(CELL, off, axis_values(CELL, 200, seed=8), seed=9, sigma=2e-5, **SEEN).without_orientation()
    asked = replace(asked, frame_known=False, target_known=False, name="a", same_frame_as="f", same_target_as="f")
    for count in (8, 10):
        data = measure(CELL, off, axis_values(CELL, count, seed=3), seed=4, sigma=2e-5, **SEEN).without_orientation()
        data = replace(data, frame_known=False, target_known=False, name="f")
        found = fit_cell(CELL, data, withheld=asked).calibration
        assert found.errors["calibrated/withheld"].mean < 0.35 * found.errors["frames/withheld"].mean
        assert any("each is held to its ordinary size" in w for w in found.warnings)
    assert fit_cell(CELL, data.select(np.arange(8))).calibration.rows == 8  # and none of them is withheld


def test_what_is_held_to_its_size_is_what_scipy_finds() -> None:
    names = (*FRAMES[:3], "tool.x", "A2.zero", "A3.zero", "A3.x")
    data = measure(CELL, OFF, axis_values(CELL, 12, seed=3), seed=4, sigma=5e-5).without_orientation()
    (part,) = prepare_sets(CELL, [data], names)
    against, size = 2e-3, np.where([n.startswith("A") for n in names], 1e-3, np.inf)
    pairs = [(part.model, data)]
    ours = fit_parameters(pairs, ParameterSet.of(named_parameter(CELL, n) for n in names), against=against)

    def rows(x):
        lengths = (
            np.linalg.norm(residuals(part.model, x, data)[:, :3], axis=1) / against / 3.0
        )  # of three deviations an axis
        return np.r_[3.0 * np.sqrt(6.0 * (np.sqrt(1.0 + lengths**2 / 3.0) - 1.0)), x / size]

    by_hand = least_squares(rows, np.zeros(len(names)), x_scale=1e-3, xtol=1e-12, ftol=1e-12, gtol=1e-12).x
    assert ours.parameters.values_array == pytest.approx(by_hand, abs=2e-6)
    assert np.linalg.norm(by_hand[4:]) > 1e-3
