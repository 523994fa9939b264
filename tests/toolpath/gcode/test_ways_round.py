"""Rotary words of Siemens that say which way round (DC, ACP, ACN) or by how much (IC), and tools by the set-up's names.

Which way round is worked out by hand: DC is the shorter one, ACP goes up, ACN down (840D sl, "Fundamentals", absolute dimension
for rotary axes), and the tool's axis of ISO 841 at A and C is Rz(C) Rx(A) z.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import EventKind, Move
from camrob.toolpath.toolpath import Toolpath

HEAD = "N10 G90 G17 G710 G94\nN20 T1 M6\nN30 S5000 M3\nTRAORI\nF600\nG0 X0 Y0 Z50 A=30 C={}\nG1 Z0\n"


def read(folder: Path, text: str, name: str = "a.mpf", **options: object) -> Toolpath:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return read_toolpath(file, dialect="gcode-xyzac-iso", **options)  # type: ignore[arg-type]


def bearings(folder: Path, start: str, way: str) -> list[float]:
    """The tool's bearing about Z, degrees, unwrapped from the start of the turn on, of all points of the last cut."""
    path = read(folder, HEAD.format(start) + f"G1 X10 {way}\nTRAFOOF\nM30\n")
    region = path.regions[-1]
    turn = np.flatnonzero(region.line == 8)
    rows = np.r_[turn[0] - 1, turn]
    axes = region.axis[rows]
    np.testing.assert_allclose(axes[:, 2], math.cos(math.radians(30.0)), atol=1e-12)
    return np.degrees(np.unwrap(np.arctan2(axes[:, 0], -axes[:, 1]))).tolist()


@pytest.mark.parametrize(
    ("start", "way", "turned"),
    [
        ("350", "C=DC(20)", 30.0),
        ("20", "C=DC(350)", -30.0),
        ("0", "C=DC(179)", 179.0),
        ("-170", "C=DC(170)", -20.0),
        ("350", "C=ACP(20)", 30.0),
        ("20", "C=ACP(350)", 330.0),
        ("20", "C=ACN(350)", -30.0),
        ("350", "C=ACN(20)", -330.0),
        ("20", "C=IC(-45)", -45.0),
        ("20", "A=30 C=IC(90)", 90.0),
        ("20", "C=AC(65)", 45.0),
        ("20", "C=ACP(20)", 0.0),
    ],
)
def test_a_rotary_word_goes_the_way_round_that_it_names(tmp_path: Path, start: str, way: str, turned: float) -> None:
    found = bearings(tmp_path, start, way)
    assert found[-1] - found[0] == pytest.approx(turned, abs=1e-9)
    assert np.all(np.diff(found) * turned >= -1e-9), "never back"


def test_a_plain_word_behind_one_that_went_over_the_top_counts_from_what_was_written(tmp_path: Path) -> None:
    body = "G1 X10 C=DC(5)\nG1 X20 C5.5\nTRAFOOF\nM30\n"
    region = read(tmp_path, HEAD.format("355") + body).regions[-1]
    axes = region.axis[region.line == 9]
    bearing = np.degrees(np.unwrap(np.arctan2(axes[:, 0], -axes[:, 1])))
    assert bearing.min() >= 5.0 - 1e-9 and bearing[-1] == pytest.approx(5.5, abs=1e-9)


NAMED = (
    'G90 G17 G710 G94\nT="MILL 8"\nM6\nS5000 M3\nF600\nG0 X0 Y0 Z5\nG1 Z0\nX10\nG0 Z5\nM5\n'
    'T="Drill 3"\nM6\nS4000 M3\nG0 X0 Y0 Z5\nMCALL CYCLE81(5,0,2,-9)\nX0 Y0\nMCALL\nM30\n'
)
KLARTEXT = (
    'BEGIN PGM A MM\nTOOL CALL "MILL 8" Z S5000\nL Z+5 R0 FMAX M3\nL X+0 Y+0 FMAX\nL Z+0 F600\nL X+10\nL Z+5 FMAX M5\n'
    'TOOL CALL "Drill 3" Z S4000\nL Z+5 FMAX M3\nL X+0 Y+0 FMAX\nL Z-9 F300\nL Z+5 FMAX\nM30\nEND PGM A MM\n'
)


@pytest.mark.parametrize(("text", "name"), [(NAMED, "a.mpf"), (KLARTEXT, "a.h")])
def test_tools_by_their_names_are_those_of_the_set_up(tmp_path: Path, text: str, name: str) -> None:
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    path = read_toolpath(file, numbers={"mill 8": 4, "drill 3": 11})
    changes = [event for region in path.regions for event in region.events if event.kind is EventKind.TOOL_CHANGE]
    assert [event.value for event in changes] == [4.0, 11.0]
    assert sum(int((region.move == Move.CUT).sum()) for region in path.regions) == 3
    with pytest.raises(ToolpathError, match="several tools by their names") as caught:
        read_toolpath(file, numbers={"mill 8": 4})
    assert "[[tool]]" in str(caught.value.hint)
