"""G16 (Fanuc, B-63944EN, 8.3), Haas's G100 and G101, programs behind the tape's end: ends worked out by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move

HEAD = "G21 G90 G17 G94\nT1 M6\nS5000 M3\nG0 X0 Y0 Z50.\n"


def ends(folder: Path, body: str, head: str = HEAD) -> list[list[float]]:
    """Where each line that cuts ends, mm."""
    file = folder / "a.nc"
    file.write_text(f"{head}{body}M30\n", encoding="utf-8")
    rows = []
    for region in read_toolpath(file).regions:
        last = (region.move == Move.CUT) & np.append(region.line[1:] != region.line[:-1], True)
        rows += region.position[last].tolist()
    return [[round(1e3 * v, 6) + 0.0 for v in row] for row in rows]


def ray(radius: float, angle: float, z: float) -> list[float]:
    turn = math.radians(angle)
    return [round(radius * math.cos(turn), 6) + 0.0, round(radius * math.sin(turn), 6) + 0.0, z]


def test_radius_and_angle_stay_and_angles_add_up(tmp_path: Path) -> None:
    body = "G16 G0 X100. Y30.\nG1 Z-1. F500\nY60.\nG91 Y15.\nY-5. Z-1.\nG90 X50.\nG15\nX3. Y4.\n"
    wanted = [ray(100, 30, -1), ray(100, 60, -1), ray(100, 75, -1), ray(100, 70, -2), ray(50, 70, -2), [3, 4, -2]]
    assert ends(tmp_path, body) == wanted


def test_holes_on_a_circle(tmp_path: Path) -> None:
    body = "G16\nG81 X40. Y30. Z-5. R2. F200\nY150.\nG91 Y120.\nG90 G80 G15\nG0 X1. Y1.\nG1 Z3.\n"
    file = tmp_path / "a.nc"
    file.write_text(f"{HEAD}{body}M30\n", encoding="utf-8")
    (region,) = read_toolpath(file).regions
    cut = region.position[region.move == Move.CUT] * 1e3
    np.testing.assert_allclose(cut[:3], [ray(40, 30, -5), ray(40, 150, -5), ray(40, 270, -5)], atol=1e-6)
    np.testing.assert_allclose(cut[3], [1, 1, 3], atol=1e-9)


def test_an_arc_by_its_radius_and_the_local_zero(tmp_path: Path) -> None:
    body = "G52 X10. Y0. Z0.\nG16 G0 X20. Y0.\nG1 Z0. F500\nG3 Y90. R20.\nG15 G52 X0. Y0. Z0.\n"
    assert ends(tmp_path, body) == [[30, 0, 0], [10, 20, 0]]


@pytest.mark.parametrize(
    ("body", "match"),
    [
        ("G16\nG1 Y30. F500\n", "both radius and angle"),
        ("G16\nG91 G1 X5. F500\n", "where the tool stands"),
        ("G16\nG0 X9. Y0\nG2 X9. Y9. I-9. J0. F9\n", "I, J, K or L"),
        ("G18 G16\n", "another plane"),
        ("G68 X0 Y0 R10.\nG16\n", "frame of the program's"),
        ("G16\nG0 X9. Y0\nG91 G28 X0 Y0 Z0\n", "by way of"),
    ],
)
def test_polar_coordinates_that_are_refused(tmp_path: Path, body: str, match: str) -> None:
    with pytest.raises(ToolpathError, match=match):
        ends(tmp_path, body)


def test_haas_mirrors_at_the_work_zero(tmp_path: Path) -> None:
    """G2 from (10, 20) about (20, 20) to (20, 10) is the long way; mirrored it goes right-handedly."""
    body = "G101 Y0.\nG0 X10. Y20.\nG1 Z-1. F500\nG2 X20. Y10. I10. J0.\n"
    body += "G101 X0.\nX3. Y4.\nG100 Y0.\nG1 X3. Y4.\nG100 X0.\nX3. Y4.\n"
    body = body.replace("G101 X0.\nX3.", "G101 X0.\nG1 X3.")
    wanted = [[10, -20, -1], [20, -10, -1], [-3, -4, -1], [-3, 4, -1], [3, 4, -1]]
    assert ends(tmp_path, body) == wanted
    file = tmp_path / "a.nc"
    (region,) = read_toolpath(file).regions
    round_ = region.position[region.line == 8] * 1e3
    assert round_[:, 0].max() == pytest.approx(30, abs=0.01) and round_[:, 1].min() == pytest.approx(-30, abs=0.01)


@pytest.mark.parametrize("word", ["G101", "G101 X5.", "G101 Z0.", "G100 T3", "G100"])
def test_other_words_of_these_codes_are_refused(tmp_path: Path, word: str) -> None:
    with pytest.raises(ToolpathError, match=r"G10[01]|another axis|along Z|G51.1"):
        ends(tmp_path, f"{word}\nG0 X10. Y20.\nG1 Z-1. F500\n")


def test_a_subprogram_behind_the_end_of_the_tape(tmp_path: Path) -> None:
    text = "%\nO1\nG21 G90 G17\nS900 M3\nG0 X0. Y0. Z5.\nG1 Z0. F100.\nM98 P10 L2\nM30\n%\n\n(SUB)\nO10\nG91 X5.\nG90\nM99\n"
    file = tmp_path / "a.nc"
    file.write_text(text, encoding="utf-8")
    (region,) = read_toolpath(file).regions
    np.testing.assert_allclose(region.position[-1] * 1e3, [10, 0, 0], atol=1e-9)


def test_a_hole_behind_a_turned_table_is_refused_for_the_machine_s_coordinates(tmp_path: Path) -> None:
    with pytest.raises(ToolpathError, match="tool centre point is off") as caught:
        ends(
            tmp_path,
            "B0\nG43 H5\nG81 X5. Y0 Z-3. R2. F40\nG80\nG0 Z50.\nB180.\nG0 X0 Y0\nG43 H5 Z50.\nG81 Z-3. R2. F40\nG80\n",
        )
    assert caught.value.line == 13
