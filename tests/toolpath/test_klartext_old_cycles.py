"""Heidenhain's cycles 1, 2 and 17, M89, M140 beside other M functions, remarks in brackets; heights by the manual's rules."""

from __future__ import annotations

from pathlib import Path

import pytest
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import EventKind
from camrob.toolpath.toolpath import Toolpath
from camrob.witness.cl import read_story

HEAD = "BEGIN PGM A MM\nTOOL CALL 1 Z S500\nM3\nL X+0 Y+0 Z+60 FMAX\nL Z+2 FMAX\n"
END = "L Z+60 FMAX\nM30\nEND PGM A MM\n"
PECKING = (
    "CYCL DEF 1.0 PECKING\nCYCL DEF 1.1 SET UP +2\nCYCL DEF 1.2 DEPTH {}\n"
    "CYCL DEF 1.3 PECKG +{}\nCYCL DEF 1.4 DWELL 0.5\nCYCL DEF 1.5 F100\n"
)
TAPS = {
    "2": "CYCL DEF 2.0 GEWINDEBOHREN\nCYCL DEF 2.1 ABST 2\nCYCL DEF 2.2 TIEFE -12\nCYCL DEF 2.3 V.ZEIT 0\nCYCL DEF 2.4 F625\n",
    "17": "CYCL DEF 17.0 RIGID TAPPING\nCYCL DEF 17.1 SET UP -2\nCYCL DEF 17.2 DEPTH -12\nCYCL DEF 17.3 PITCH +1.25\n",
}


def _read(folder: Path, text: str) -> Toolpath:
    file = folder / "a.h"
    file.write_text(text, encoding="utf-8")
    toolpath, story = read_toolpath(file), read_story(file)
    assert story.complete and not differences(toolpath, story)
    return toolpath


def _rows(toolpath: Toolpath) -> list[tuple[float, float, int]]:
    """X and Z in mm and how they are gone to."""
    region = toolpath.regions[0]
    return [
        (round(x * 1e3, 6), round(z * 1e3, 6), int(m))
        for (x, _, z), m in zip(region.position, region.move, strict=True)
    ]


def _refused(folder: Path, text: str, match: str) -> None:
    (folder / "a.h").write_text(text, encoding="utf-8")
    with pytest.raises(ToolpathError, match=match):
        read_toolpath(folder / "a.h")


@pytest.mark.parametrize(
    ("depth", "bite", "stop"), [(-13.0, 5.0, 0.6), (-40.0, 25.0, 0.8), (-30.0, 12.0, 0.6), (-450.0, 250.0, 7.0)]
)
def test_cycle_1_counts_from_where_the_tool_stands(tmp_path: Path, depth: float, bite: float, stop: float) -> None:
    """The surface lies 2 below Z+2; out to Z+2 behind each bite and back to `stop` above it, a fiftieth of deep holes."""
    toolpath = _read(tmp_path, HEAD + PECKING.format(depth, bite) + "L X+9 FMAX M99\n" + END)
    expected, at = [(9.0, 2.0, 0)], 0.0
    while at > depth:
        at = max(depth, at - bite)
        expected += [(9.0, at, 1), (9.0, 2.0, 0), *([(9.0, at + stop, 0)] if at > depth else [])]
    found = _rows(toolpath)
    assert found[-len(expected) - 1 : -1] == expected
    assert [e.value for r in toolpath.regions for e in r.events if e.kind is EventKind.DWELL] == [0.5]


def test_cycle_1_in_inches_keeps_its_stop(tmp_path: Path) -> None:
    text = (
        (HEAD + PECKING.format(-0.5, 0.3) + "L X+1 FMAX M99\n" + END)
        .replace(" MM", " INCH")
        .replace("SET UP +2", "SET UP 0.1")
    )
    heights = [z for x, z, _ in _rows(_read(tmp_path, text)) if x == 25.4]
    surface = 2 * 25.4 - 2.54
    assert heights[1:4] == [pytest.approx(surface - 7.62), 50.8, pytest.approx(surface - 7.62 + 0.6)]


@pytest.mark.parametrize("number", TAPS)
def test_cycles_2_and_17_tap(tmp_path: Path, number: str) -> None:
    toolpath = _read(tmp_path, HEAD + TAPS[number] + "L X+9 FMAX M99\n" + END)
    assert _rows(toolpath)[-4:-1] == [(9.0, 2.0, 0), (9.0, -12.0, 1), (9.0, 2.0, 1)]
    region = toolpath.regions[0]
    assert {round(float(f) * 60e3, 6) for f, m in zip(region.feed, region.move, strict=True) if m == 1} == {625.0}


def test_cycle_220_places_an_old_cycle(tmp_path: Path) -> None:
    """A surface of its own, Q203 = 5; a call behind it counts from where the tool stands again."""
    again = (
        "CYCL DEF 220 MUSTER KREIS ~\nQ216=+20 ~\nQ217=+0 ~\nQ244=+20 ~\nQ245=+0 ~\nQ247=+180 ~\nQ241=+2 ~\n"
        "Q200={} ~\nQ203=+5 ~\nQ204=+10\n"
    )
    body = PECKING.format(-3, 3) + again.format("+2") + "L X+50 Z+2 FMAX\nCYCL CALL\n"
    found = [(x, z) for x, z, move in _rows(_read(tmp_path, HEAD + body + END)) if move]
    assert found == [(30.0, 2.0), (10.0, 2.0), (50.0, -3.0)]
    _refused(tmp_path, HEAD + PECKING.format(-3, 3) + again.format("+1") + END, "another set-up clearance")


def test_m89_calls_the_cycle_behind_every_motion_up_to_m99(tmp_path: Path) -> None:
    body = (
        PECKING.format(-3, 3)
        + "L X+9 FMAX M89 (first)\nL IX+9 F500\nCC X+9 Y+0\nLP PR+20 PA+0 FMAX M99 (last)\nL X+50 FMAX\n"
    )
    found = [(x, z) for x, z, move in _rows(_read(tmp_path, HEAD + body + END)) if move and z < 2.0]
    assert found == [(9.0, -3.0), (18.0, -3.0), (29.0, -3.0)]


def test_another_cycle_ends_m89(tmp_path: Path) -> None:
    body = PECKING.format(-3, 3) + "L X+9 FMAX M89\n" + PECKING.format(-4, 4) + "L X+18 FMAX\nL X+27 FMAX M99\n"
    found = [(x, z) for x, z, move in _rows(_read(tmp_path, HEAD + body + END)) if move]
    assert found == [(9.0, -3.0), (27.0, -4.0)]


@pytest.mark.parametrize(
    ("body", "match"),
    [
        (PECKING.format(-3, 3) + "M89\nL X+9 FMAX\n", "M89 in a block without a place"),
        (PECKING.format(-3, 3) + "L X+9 FMAX M89\nL Z+20 FMAX\n", "a way along Z while M89"),
        (PECKING.format(3, 3) + "L X+9 FMAX M99\n", "makes no hole"),
        (PECKING.format(-3, 3).replace("CYCL DEF 1.4 DWELL 0.5\n", "") + "L X+9 FMAX M99\n", "without its dwell"),
        (PECKING.format(-3, 3) + "CYCL CALL POS X+9 Y+0 Z+0 FMAX\n", "it names no surface"),
        (PECKING.format(-300, 0.001) + "L X+9 FMAX M99\n", "makes no hole"),
        ("CYCL DEF 1.1 SET UP 2\n", "without 1.0"),
        ("CYCL DEF 4.0 POCKET\n", "tool's radius in its table"),
        ("CYCL DEF 13.0 ORIENTATION\n", "held at an angle"),
    ],
)
def test_what_makes_no_certain_hole(tmp_path: Path, body: str, match: str) -> None:
    _refused(tmp_path, HEAD + body + END, match)


def test_m140_beside_other_functions(tmp_path: Path) -> None:
    """The tool goes away and the spindle stops; the place behind it has to be named."""
    body = "L Z-1 F100\nM140 MB MAX M5\nL X+9 Y+9 FMAX M3\nL Z+2 FMAX\nL Z-2 F100\n"
    toolpath = _read(tmp_path, HEAD + body + END)
    kinds = [e.kind for r in toolpath.regions for e in r.events]
    assert kinds.count(EventKind.SPINDLE_OFF) >= 1
    _refused(tmp_path, HEAD + "L Z-1 F100\nL M9 M140 MB 50 F200 M5\nL IZ+9 FMAX\n" + END, "IZ from a place")
