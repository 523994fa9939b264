"""The published calibration of the KR 500: the same figures, and what an extended model makes of the rest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from calibration_sample import calibrate_cell

from camrob.calibration.measurements import measurements_of
from camrob.cell.read_cell import read_cell
from camrob.cli.app import run
from camrob.errors import InputError
from camrob.jobs.published_case import published_case
from camrob.kinematics.arm import Arm
from camrob.kinematics.frames import base_T_flange
from camrob.measurement.read_log import read_log
from camrob.report.page.html import escape
from camrob.studies.published_file import read_published

FOLDER = Path(__file__).resolve().parents[2] / "cells" / "kr500_afp"
CASE = FOLDER / "published.toml"
CELL = read_cell(FOLDER)
PUBLISHED = {"before": (2.040, 0.147), "after": (0.580, 0.095)}  # mm and degrees, as the paper prints them


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("kr500")


@pytest.fixture(scope="module")
def case(folder: Path):
    return published_case(CASE, cell=FOLDER, out=folder / "C.toml")


def means(calibration, stage: str) -> tuple[float, float]:
    """Mean errors, mm and degrees, of the withheld poses."""
    size = calibration.errors[f"{stage}/withheld"]
    return 1e3 * size.mean, float(np.rad2deg(size.mean_angle))


def test_the_cell_is_the_maker_s_arm() -> None:
    """Arm up, forearm level: the plate at 500 + 1039.5 + 286 and 800 + 1250 + 150 mm; the closed form holds."""
    base_T_plate = base_T_flange(CELL, CELL.to_q(np.array([0.0, -90.0, 90.0, 0.0, 0.0, 0.0])))
    assert np.allclose(base_T_plate[:3, 3], [1.8255, 0.0, 2.2], atol=1e-9)
    assert np.allclose(base_T_plate[:3, 2], [1.0, 0.0, 0.0], atol=1e-9)
    assert Arm.of(CELL).closed is not None


def test_the_published_means_come_out(case) -> None:
    published = read_published(CASE, CELL)
    assert {"before": published.before, "after": published.after} == PUBLISHED and published.iterations == (3, 5)
    plain = case.plain
    assert np.allclose(means(plain, "nominal"), PUBLISHED["before"], rtol=0.06)
    assert np.allclose(means(plain, "calibrated"), PUBLISHED["after"], rtol=0.06)
    own = [n for n in plain.parameters if n[:4] not in ("base", "tool")]
    assert len(own) + len(plain.held) == 35
    assert any("something else is at work" in w for w in plain.warnings)


def test_the_extended_model_removes_the_declared_rest(case) -> None:
    mm, deg = means(case.extended, "calibrated")
    assert mm < 0.08 and deg < 0.008  # three axes of 0.03 mm make 0.048 mm


def test_the_compensated_line(case) -> None:
    line = case.line
    before, after, extended = (1e3 * e[:, 0].mean() for e in (line.before, line.after, line.extended))
    assert before > 1.0 and after < 0.5 * before and extended < 0.08
    assert 2 <= line.published_iterations[0] and line.published_iterations[1] <= 5 and line.iterations <= 5
    assert line.difference < 1e-8


def test_compensation_brings_no_violation(case) -> None:
    """Section III: what the axes' limits allow stays what it was."""
    for name in ("rate_speed", "rate_acceleration", "rate_jerk"):
        before, after = (float(np.min(getattr(a, name))) for a in case.line.analysis)
        assert after > 0.97 * before
    assert np.max(np.abs(case.line.analysis[1].q_s)) <= 1.0 + 1e-9


def test_each_published_figure_stands_beside_ours(case, folder: Path) -> None:
    rows = {row.what: row for row in case.summary.published}
    assert rows["mean error before"].published == "2.040 mm, 0.1470 deg"
    assert rows["mean error before"].ours.startswith(f"{means(case.plain, 'nominal')[0]:.3f} mm")
    assert rows["mean error after, 30 geometric and 5 stiffness"].published == "0.580 mm, 0.0950 deg"
    page = (folder / "C.html").read_text()
    assert all(f'<td class="text">{escape(what)}</td>' in page for what in rows)
    for text in ("2.040 mm, 0.1470 deg", "3-5", "no violation", "Samak, Dimovski and Dukovski"):
        assert text in page


def test_the_simulated_logs_calibrate_to_the_same(case, folder: Path) -> None:
    fitted, withheld = (measurements_of(read_log(folder / f"C_{part}.csv"), CELL) for part in ("measured", "withheld"))
    again = calibrate_cell(CELL, fitted, withheld=withheld)
    assert tuple(again.parameters) == tuple(case.plain.parameters)
    assert means(again, "calibrated") == pytest.approx(means(case.plain, "calibrated"), rel=1e-3)


def test_a_case_that_can_t_be_read_is_refused(tmp_path: Path, capsys) -> None:
    text = CASE.read_text()
    for old, new, message in [
        ("seed = 500", "seed = -1", "robot.seed: is -1"),
        ("points = 297", "points = 2", "line.points: is 2"),
        ("direction = [0.15, -1, 0.05]", "direction = [0, 0, 0]", "line.direction: has no length"),
        ("poses = 200", "poses = 200\npose = 1", "measured.pose"),
        ("upper_deg", "upper_deg = [-900, 900, 900, 900, 900, 900]\n# ", "measured.upper_deg: isn't above lower_deg"),
    ]:
        assert old in text
        (tmp_path / "case.toml").write_text(text.replace(old, new))
        with pytest.raises(InputError, match=message.replace(".", r"\.")):
            read_published(tmp_path / "case.toml", CELL)
    track = FOLDER.parent / "kr15_track_table"
    with pytest.raises(InputError, match="kr15_track_table has external axes"):
        read_published(CASE, read_cell(track))
    assert run(["calibrate", "--cell", str(FOLDER), "--out", str(tmp_path / "C.toml")]) == 2
    assert "give MEASURED.csv, or --published CASE.toml" in capsys.readouterr().err
    both = ["calibrate", "--published", str(CASE), "--harmonics", "2", "--cell", str(FOLDER)]
    assert run([*both, "--out", str(tmp_path / "C.toml")]) == 2
    assert "published.toml: says itself what is measured and fitted" in capsys.readouterr().err
    for name in ("M.csv", "P.src"):
        (tmp_path / name).touch()
    unused = ["calibrate", str(tmp_path / "M.csv"), "--for", str(tmp_path / "P.src"), "--cell", str(FOLDER)]
    assert run([*unused, "--out", str(tmp_path / "C.toml")]) == 2
    assert "give --next N with it" in capsys.readouterr().err
