"""Rounded and chamfered corners of controls, held to tangency and to lengths worked out by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move

FANUC = "O1\nG21 G90 G17\nT1 M6\nS900 M3\nG0 X0. Y0. Z20.\nG1 Z0. F600.\n{}G0 Z20.\nM30\n"
SIEMENS = "G90 G17 G710\nT1 M6\nS900 M3\nG0 X=0 Y0 Z20\nG1 Z0 F600\n{}G0 Z20\nM30\n"
KLARTEXT = (
    "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S900\n2 L X+0 Y+0 Z+20 R0 FMAX M3\n3 L Z+0 F600\n{}90 L Z+20 FMAX\n91 M30\n"
    "99 END PGM A MM\n"
)


def cuts(folder: Path, name: str, text: str) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the cuts behind the plunge, mm, and their feeds, mm/min."""
    (folder / name).write_text(text)
    (region,) = read_toolpath(folder / name, chord_tolerance=1e-7).regions
    cut = region.move == Move.CUT
    return region.position[cut][1:] * 1e3, region.feed[cut][1:] * 6e4


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.nc", FANUC.format("G1 X30. ,R5.\nY40.\n")),
        ("a.mpf", SIEMENS.format("G1 X30 RND=5\nY40\n")),
        ("a.h", KLARTEXT.format("4 L X+30\n5 RND R5\n6 L Y+40\n")),
        ("m.nc", FANUC.format("#1=30.\nG1 X#1 ,R5.\nY40.\n")),
    ],
)
def test_a_rounded_corner_is_an_arc_that_touches_both_cuts(tmp_path: Path, name: str, text: str) -> None:
    points, feeds = cuts(tmp_path, name, text)
    np.testing.assert_allclose(points[0], [25, 0, 0], atol=1e-9)
    np.testing.assert_allclose(points[-1], [30, 40, 0], atol=1e-9)
    arc = points[(points[:, 0] >= 25 - 1e-9) & (points[:, 1] <= 5 + 1e-9)]
    np.testing.assert_allclose(np.linalg.norm(arc[:, :2] - [25, 5], axis=1), 5.0, atol=1e-6)
    np.testing.assert_allclose(arc[-1], [30, 5, 0], atol=1e-9)
    assert len(arc) > 50 and np.allclose(feeds, 600.0)


@pytest.mark.parametrize(
    ("name", "text", "leg"),
    [
        ("a.nc", FANUC.format("G1 X30. ,C4.\nX0. Y30.\n"), 4.0),
        ("a.mpf", SIEMENS.format("G1 X30 CHR=4\nX0 Y30\n"), 4.0),
        ("b.mpf", SIEMENS.format("G1 X30 CHF=4\nX0 Y30\n"), 2.0 / math.sin(math.radians(22.5))),
        ("a.h", KLARTEXT.format("4 L X+30\n5 CHF 4\n6 L X+0 Y+30\n"), 4.0),
    ],
)
def test_chamfers_at_a_sharp_corner(tmp_path: Path, name: str, text: str, leg: float) -> None:
    """45 degrees between the cuts: Siemens' CHF is the chamfer's own length, all others go along the contour."""
    points, _ = cuts(tmp_path, name, text)
    side = leg * math.sqrt(0.5)
    np.testing.assert_allclose(points, [[30 - leg, 0, 0], [30 - side, side, 0], [0, 30, 0]], atol=1e-9)


def test_corners_one_behind_the_other_in_a_turned_plane_with_their_own_feed(tmp_path: Path) -> None:
    body = "4 L X+10\n5 RND R2 F100\n6 L Y+10\n7 CHF 3 F200\n8 L X+0\n"
    points, feeds = cuts(tmp_path, "a.h", KLARTEXT.format(body))
    np.testing.assert_allclose(points[[0, -3, -2, -1]], [[8, 0, 0], [10, 7, 0], [7, 10, 0], [0, 10, 0]], atol=1e-9)
    assert feeds[0] == pytest.approx(600) and np.allclose(feeds[1:-3], 100) and feeds[-2] == pytest.approx(200)
    back, _ = cuts(tmp_path, "b.h", KLARTEXT.format("4 L X+10\n5 RND R2\n6 L Y-10\n"))
    assert back[1][1] < 0.0  # to the right


@pytest.mark.parametrize(
    "body",
    [
        "G1 X30. ,R5.\nG3 X40. Y10. J10.\n",
        "G1 X30. ,R5.\nM8\nY40.\n",
        "G1 X30. ,R5.\nG0 Y40.\n",
        "G1 X30. ,R5.\nX0.\n",
        "G1 X30. ,R45.\nY40.\n",
        "G1 X30. ,R5.\nY40. Z1.\n",
        "G1 X30. ,R5.\n",
        "G2 X10. Y10. I5. J5. ,R2.\nG1 Y20.\n",
        "G0 X30. ,R5.\nY40.\n",
        "G1 ,R5.\nY40.\n",
    ],
)
def test_corners_that_are_none_are_refused(tmp_path: Path, body: str) -> None:
    (tmp_path / "a.nc").write_text(FANUC.format(body))
    with pytest.raises(ToolpathError, match="corner"):
        read_toolpath(tmp_path / "a.nc")


def test_a_corner_at_the_end_of_a_file_loses_no_cut(tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_text("%\n" + FANUC.format("G1 X30. ,R5.\n").replace("G0 Z20.\nM30\n", "%\n"))
    with pytest.raises(ToolpathError, match="corner"):
        read_toolpath(tmp_path / "a.nc")
    (tmp_path / "a.h").write_text(KLARTEXT.format("4 C X+10 Y+0 DR+\n5 RND R2\n").replace("4 C", "3 CC X+5 Y+0\n4 C"))
    with pytest.raises(ToolpathError, match="RND or CHF"):
        read_toolpath(tmp_path / "a.h")


def test_a_corner_that_goes_straight_on_is_none(tmp_path: Path) -> None:
    points, _ = cuts(tmp_path, "a.nc", FANUC.format("G1 X30. ,R5.\nX40.\n"))
    np.testing.assert_allclose(points, [[30, 0, 0], [40, 0, 0]], atol=1e-9)
