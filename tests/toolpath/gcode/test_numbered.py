"""Files that begin with % and a number, as NUM's (1040, 1060) and Siemens' older ones do: what the two read otherwise is refused.

NUM, "Programming Manual (milling)": I and J are the centre's place in G90, G52 programs the machine's places, G59 shifts the
zero. Siemens 810: I and J count from the arc's start. A file that begins with % alone is read as before.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move
from camrob.witness.cl import read_story

HEAD = "N10 G71 G90 G17 G94\nN20 T1 M6\nN30 S5000 M3\nN40 G0 X{} Y{} Z50\nN50 G1 Z0 F300\n"
TAIL = "N90 G0 Z50\nN91 M5\nN92 M2\n"
# from where, and an arc that both ways of counting make
TWOFOLD = {
    "full": ((50, 0), "G2 X50 Y0 I60 J0"),
    "along the bisector": ((0, 10), "G2 X20 Y10 I10 J10"),
}
ONE = {
    "from its start": ((50, 0), "G2 X60 Y10 I0 J10", (50, 10)),
    "from the zero, which both are": ((0, 0), "G2 X20 Y0 I10 J0", (10, 0)),
    "by R": ((0, 10), "G2 X20 Y10 R10", (10, 10)),
}


def written(folder: Path, first: str, at: tuple[int, int], body: str) -> Path:
    file = folder / "a.nc"
    file.write_text(f"{first}\n{HEAD.format(*at)}N60 {body}\n{TAIL}")
    return file


@pytest.mark.parametrize("at, arc", TWOFOLD.values(), ids=TWOFOLD)
def test_an_arc_of_two_circles_is_refused(tmp_path: Path, at: tuple[int, int], arc: str) -> None:
    file = written(tmp_path, "%100", at, arc)
    with pytest.raises(ToolpathError, match="two circles") as caught:
        read_toolpath(file)
    assert caught.value.line == 7
    assert not read_story(file).complete
    for first in ("%", "%100\nO100"):  # not NUM's
        file = written(tmp_path, first, at, arc)
        read_toolpath(file)
        assert read_story(file).complete


@pytest.mark.parametrize("at, arc, center", ONE.values(), ids=ONE)
def test_an_arc_of_one_circle_is_done(tmp_path: Path, at: tuple[int, int], arc: str, center: tuple[int, int]) -> None:
    file = written(tmp_path, "%100", at, arc)
    (region,) = read_toolpath(file).regions
    found = region.position[region.move == Move.CUT][1:, :2] * 1e3 - center
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 10.0, atol=1e-6)
    assert read_story(file).complete


@pytest.mark.parametrize("block", ["G52 G0 Z0", "G59 X10", "G52 X5"])
def test_places_and_shifts_that_the_machine_has(tmp_path: Path, block: str) -> None:
    file = written(tmp_path, "%100", (0, 0), block)
    with pytest.raises(ToolpathError, match=r"begins as NUM's do|several work offsets"):
        read_toolpath(file)
    assert not read_story(file).complete


@pytest.mark.parametrize(
    "block, match",
    [("G8 X30 Y10", "G8 with axes"), ("G49 X10 Y0 Z5", "G49 with X, Y and Z"), ("G90 G49 X1 Y2 Z3", "G49 with X")],
)
def test_what_fagor_means_otherwise(tmp_path: Path, block: str, match: str) -> None:
    """Fagor 8025, 8055: G8 X Y is an arc that touches the way before it, G49 X Y Z lays an inclined plane there."""
    file = written(tmp_path, "%", (0, 0), block)
    with pytest.raises(ToolpathError, match=match):
        read_toolpath(file)
    assert not read_story(file).complete


def test_g49_with_a_motion_of_its_own_is_that_motion(tmp_path: Path) -> None:
    file = written(tmp_path, "%", (0, 0), "X10\nN61 G0 G49 X1 Y2 Z60")
    (region,) = read_toolpath(file).regions
    np.testing.assert_allclose(region.position[region.move == Move.CUT] * 1e3, [[0, 0, 0], [10, 0, 0]], atol=1e-9)
    assert read_story(file).complete
