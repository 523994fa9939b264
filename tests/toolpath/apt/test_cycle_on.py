"""CYCLE/ON: the cycle before it again; NX names there what is other for the holes that follow. As a shop's CLSF has it."""

from __future__ import annotations

from pathlib import Path

import pytest
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move
from camrob.witness.cl import read_story

HEAD = """TOOL PATH/HOLES,TOOL,D13
TLDATA/MILL,13.0000,0.0000,75.0000,0.0000,0.0000
MSYS/0.0000,0.0000,0.0000,1.0000000,0.0000000,0.0000000,0.0000000,1.0000000,0.0000000
LOAD/TOOL,62,ADJUST,62
SPINDL/RPM,3600,CLW
FEDRAT/MMPM,99.0
RAPID
GOTO/0.0,0.0,80.0000,0.0000000,0.0000000,1.0000000
"""
DEEP = "CYCLE/DRILL,DEEP,STEP,20.0000,CLEAR,3.0000,FEDTO,-36.0000,RTRCTO,AUTO,MMPM,250.0000\nGOTO/1.0,0.0,70.0\n"
END = "CYCLE/OFF\nEND-OF-PATH\n"


def _bottoms(tmp_path: Path, text: str) -> list[tuple[float, float, float, float]]:
    """X, Z, the feed (mm/min) of every cut, and Z behind it, by both readers."""
    (tmp_path / "a.cls").write_text(HEAD + DEEP + text + END, encoding="utf-8")
    toolpath, story = read_toolpath(tmp_path / "a.cls"), read_story(tmp_path / "a.cls")
    assert story.complete and not list(differences(toolpath, story))
    (region,) = toolpath.regions
    at = [i for i, move in enumerate(region.move) if move == Move.CUT]
    p = region.position * 1e3
    return [(round(p[i, 0], 6), round(p[i, 2], 6), round(region.feed[i] * 6e4, 6), round(p[i + 1, 2], 6)) for i in at]


FIRST = [(1, 50, 250, 73), (1, 34, 250, 80)]


@pytest.mark.parametrize(
    ("on", "then"),
    [
        ("CYCLE/ON", [(5, 50, 250, 73), (5, 34, 250, 80)]),
        ("CYCLE/OFF\nRAPID\nGOTO/1.0,0.0,90.0\nCYCLE/ON", [(5, 50, 250, 73), (5, 34, 250, 90)]),
        ("CYCLE/ON,FEDTO,-44.5000,RTRCTO,AUTO", [(5, 50, 250, 73), (5, 30, 250, 73), (5, 25.5, 250, 80)]),
        ("CYCLE/ON,STEP,18.5,RAPTO,1.5,MMPR,0.1,RTRCTO,12", [(5, 51.5, 360, 71.5), (5, 34, 360, 82)]),
    ],
)
def test_the_cycle_is_on_again(tmp_path: Path, on: str, then: list[tuple[float, float, float, float]]) -> None:
    assert _bottoms(tmp_path, on + "\nGOTO/5.0,0.0,70.0\n") == FIRST + then


def test_values_stay_for_the_next(tmp_path: Path) -> None:
    on = "CYCLE/ON,FEDTO,-10\nGOTO/5.0,0.0,70.0\nCYCLE/ON,FEDTO,-15\nGOTO/9.0,0.0,70.0\n"
    assert _bottoms(tmp_path, on) == [*FIRST, (5, 60, 250, 80), (9, 55, 250, 80)]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (HEAD + "CYCLE/ON\nGOTO/5.0,0.0,70.0\n" + END, "CYCLE/ON without a cycle"),
        (HEAD + DEEP + "CYCLE/ON,-20\nGOTO/5.0,0.0,70.0\n" + END, "CYCLE/ON with values"),
        (
            "PARTNO A\nUNITS/MM\nSPINDL/900,CLW\nFEDRAT/9,MMPM\nRAPID\nGOTO/0,0,9\nCYCLE/DRILL,FEDTO,5,MMPM,9,RAPTO,2\n"
            "GOTO/1,0,0\nCYCLE/ON,FEDTO,8\nGOTO/2,0,0\nCYCLE/OFF\nFINI\n",
            "CYCLE/ON with values",
        ),
    ],
)
def test_what_it_does_not_say_is_refused(tmp_path: Path, text: str, why: str) -> None:
    (tmp_path / "a.cls").write_text(text, encoding="utf-8")
    with pytest.raises(ToolpathError, match=why):
        read_toolpath(tmp_path / "a.cls")
    assert not read_story(tmp_path / "a.cls").complete
