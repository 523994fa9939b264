"""The published calibration of the KR 500: the same figures, and what an extended model makes of the rest."""

from __future__ import annotations

import numpy as np
import pytest
from kr500_case import CELL, PUBLISHED, calibrated, means, slowest, tape_line, truth

from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_flange


@pytest.fixture(scope="module")
def case():
    errors = truth()
    plain, extended = calibrated(errors, 0), calibrated(errors, 2)
    return plain, extended, tape_line(errors, plain, extended)


def test_the_cell_is_the_maker_s_arm() -> None:
    """Arm up, forearm level: the plate at 500 + 1039.5 + 286 and 800 + 1250 + 150 mm; the closed form holds."""
    base_T_plate = base_T_flange(CELL, CELL.to_q(np.array([0.0, -90.0, 90.0, 0.0, 0.0, 0.0])))
    assert np.allclose(base_T_plate[:3, 3], [1.8255, 0.0, 2.2], atol=1e-9)
    assert np.allclose(base_T_plate[:3, 2], [1.0, 0.0, 0.0], atol=1e-9)
    assert Arm.of(CELL).closed is not None


def test_the_published_means_come_out(case) -> None:
    plain = case[0]
    assert np.allclose(means(plain, "nominal"), PUBLISHED["before"], rtol=0.06)
    assert np.allclose(means(plain, "calibrated"), PUBLISHED["after"], rtol=0.06)
    own = [n for n in plain.parameters if n[:4] not in ("base", "tool")]
    assert len(own) + len(plain.held) == 35
    assert any("something else is at work" in w for w in plain.warnings)


def test_the_extended_model_removes_the_declared_rest(case) -> None:
    assert means(case[1], "calibrated")[0] < 0.08  # three axes of 0.03 mm make 0.048 mm
    assert means(case[1], "calibrated")[1] < 0.008


def test_the_compensated_line(case) -> None:
    line = case[2]
    assert 1e3 * line.before[:, 0].mean() > 1.0
    assert line.after[:, 0].mean() < 0.5 * line.before[:, 0].mean()
    assert 1e3 * line.extended[:, 0].mean() < 0.08
    assert 2 <= line.published_iterations[0] and line.published_iterations[1] <= 5 and line.iterations <= 5
    assert line.largest_difference < 1e-8


def test_compensation_brings_no_violation(case) -> None:
    """Section III: what the axes' limits allow stays what it was."""
    before, after = (np.array(slowest(a)) for a in case[2].analysis)
    assert np.all(after > 0.97 * before)
    assert np.max(np.abs(case[2].analysis[1].q_s)) <= 1.0 + 1e-9
