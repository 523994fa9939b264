"""Heidenhain's patterns: PATTERN DEF with CYCL CALL PAT, and cycles 220 and 221; places by hand (TNC 640, 2.3 and 7)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move
from camrob.witness.cl import read_story

BEGIN = (
    "BEGIN PGM A MM\nTOOL CALL 4 Z S2000 F200\nL X+0 Y+0 Z+20 R0 FMAX M3\n"
    "CYCL DEF 200 A Q200=1 Q201=-10 Q206=100 Q202=20 Q210=0 Q203=0 Q204=9\n"
)
END = "L Z+50 FMAX\nM30\nEND PGM A MM\n"
RING = "CYCL DEF 220 A ~\n Q216=+10 ~\n Q217=+ 5 ~\n Q244=20 ~\n Q245=-90 ~\n Q246=360 ~\n Q247=+90 ~\n Q241=3 ~\n"
HEIGHTS = " Q200=2 ~\n Q203=-3 ~\n Q204=20\n"
GRID = "CYCL DEF 221 A Q225=1 Q226=2 Q237=10 Q238=4 Q242=3 Q243=2 Q224=90 "


@pytest.mark.parametrize(
    ("text", "places", "depth"),
    [
        (
            "PATTERN DEF POS1 (X+25 Y+33.5 Z+0) POS2(X+50 Y-7 Z+0)\nCYCL CALL PAT FMAX\n",
            [(25, 33.5), (50, -7)],
            -10,
        ),
        (
            "PATTERN DEF ROW1 (X+20 Y+5 D+4 NUM3 ROT+90 Z+0)\nCYCL CALL PAT FMAX M8\n",
            [(20, 5), (20, 9), (20, 13)],
            -10,
        ),
        (
            "PATTERN DEF CIRC1 (X+1 Y+2 D10 START+90 NUM4 Z+0)\nCYCL CALL PAT FMAX\n",
            [(1, 7), (-4, 2), (1, -3), (6, 2)],
            -10,
        ),
        (
            "PATTERN DEF PITCHCIRC1 (X+0 Y+0 D10 START+0 STEP-90 NUM2 Z+0)\nCYCL CALL PAT FMAX\n",
            [(5, 0), (0, -5)],
            -10,
        ),
        (RING + HEIGHTS, [(10, -5), (20, 5), (10, 15)], -13),  # at once, from the surface that it names
        (GRID + "Q200=2 Q203=-3 Q204=20\n", [(1, 2), (1, 12), (1, 22), (-3, 22), (-3, 12), (-3, 2)], -13),
    ],
)
def test_the_cycle_is_done_at_each_place(
    tmp_path: Path, text: str, places: list[tuple[float, float]], depth: float
) -> None:
    (tmp_path / "a.h").write_text(BEGIN + text + END, encoding="utf-8")
    toolpath, story = read_toolpath(tmp_path / "a.h"), read_story(tmp_path / "a.h")
    assert story.complete and not list(differences(toolpath, story))
    points = np.concatenate([region.position[region.move == Move.CUT] for region in toolpath.regions]) * 1e3
    np.testing.assert_allclose(points, [(*place, depth) for place in places], atol=1e-6)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (RING.replace("247=+90", "247=0") + HEIGHTS, "by its last angle"),
        (RING + " Q365=1 ~\n" + HEIGHTS, "along the circle"),
        (RING + " Q200=2 ~\n Q203=0\n", "without Q204"),
        (GRID.replace("Q242=3", "Q242=2.5") + "Q200=2 Q203=0 Q204=20\n", "a pattern of 2.5 places"),
        ("CYCL CALL PAT FMAX\n", "without a pattern"),
        ("PATTERN DEF POS1 (X+2 Y+3 Z+0)\nCYCL CALL PAT F100\n", "at a feed"),
        ("PATTERN DEF POS1 (X+2 Y+3 Z+4)\n", "another Z"),
        ("PATTERN DEF PAT1 (X+2 Y+3 DX+8 DY+10 NUMX5 NUMY4 ROT+0 ROTX+0 ROTY+0 Z+0)\n", "is not read"),
        ("PATTERN DEF ROW1 (X+2 Y+3 D+4 NUM3 Z+0)\n", "is not read"),
        ("PATTERN DEF CIRC1 (X+2 Y+3 D10 NUM3 Z+0)\n", "is not read"),
        ("PATTERN DEF ROW1 (X+2 Y+3 D+4 NUM2.5 ROT+0 Z+0)\n", "pattern of 2.5 places"),
        ("PATTERN DEF ROW1 (X+2 Y+3 D+4 NUM10001 ROT+0 Z+0)\n", "pattern of 10001 places"),
        (GRID.replace("Q242=3 Q243=2", "Q242=1000 Q243=1000") + HEIGHTS, "pattern of 1e\\+06 places"),
    ],
)
def test_what_a_pattern_does_not_say_is_refused(tmp_path: Path, text: str, why: str) -> None:
    (tmp_path / "a.h").write_text(BEGIN + text + END, encoding="utf-8")
    with pytest.raises(ToolpathError, match=why):
        read_toolpath(tmp_path / "a.h")
    assert not read_story(tmp_path / "a.h").complete


def test_cycle_220_without_a_cycle_before_it(tmp_path: Path) -> None:
    (tmp_path / "a.h").write_text(BEGIN.split("CYCL")[0] + RING + HEIGHTS + END, encoding="utf-8")
    with pytest.raises(ToolpathError, match="220 without a cycle"):
        read_toolpath(tmp_path / "a.h")
    assert not read_story(tmp_path / "a.h").complete


@pytest.mark.parametrize(
    "call", ["CYCL CALL POS X+1 Y+2 Z+0 FMAX\n", "PATTERN DEF POS1 (X+2 Y+3 Z+0)\nCYCL CALL PAT FMAX M8\n"]
)
def test_a_call_at_places_without_a_cycle_before_it(tmp_path: Path, call: str) -> None:
    (tmp_path / "a.h").write_text(BEGIN.split("CYCL")[0] + call + END, encoding="utf-8")
    with pytest.raises(ToolpathError, match="call without a cycle"):
        read_toolpath(tmp_path / "a.h")
    assert not read_story(tmp_path / "a.h").complete


def test_a_label_s_end_that_is_not_called_is_run_through(tmp_path: Path) -> None:
    text = "L X+3 Y+4 FMAX M99\nLBL 0\nL X+8 FMAX M99\n"
    (tmp_path / "a.h").write_text(BEGIN + text + END, encoding="utf-8")
    toolpath, story = read_toolpath(tmp_path / "a.h"), read_story(tmp_path / "a.h")
    assert story.complete and not list(differences(toolpath, story))
