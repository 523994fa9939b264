"""Cutter radius compensation: refused where a control would have to offset the path, gone on where there is nothing to offset."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.findings import Finding
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move
from camrob.witness.cl import read_story
from camrob.witness.cl.offsets import OFFSET

FANUC = "%\nO1\nG21 G90 G17 G94\nT1 M6\nS900 M3\nG0 X0. Y0. Z5.\n"
SIEMENS = "N10 G90 G17 G710 G94\nT1 M6\nS900 M3\nG0 X0 Y0 Z5\nCYCLE832(0.01,1)\n"
KLARTEXT = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S900\n2 L X+0 Y+0 Z+5 R0 FMAX M3\n"
CREO = "$$* Pro/CLfile Version 8.0\nPARTNO / A\n$$-> CUTCOM_GEOMETRY_TYPE / {}\nUNITS / MM\nLOADTL / 1\nFEDRAT / 60, MMPM\n"

# name of the file, its text, the line in which the control would begin to offset the path
OFFSETS = [
    ("a.nc", FANUC + "G1 Z-1. F60.\nG41 D1 X5.\nY9.\nG40 X0.\nM30\n%\n", 8),
    ("a.nc", FANUC + "G1 G42 X5. F60. D21\nM30\n%\n", 7),
    ("a.nc", FANUC + "D1\nG1 X5. F60.\nG42\nX9.\nM30\n%\n", 9),
    ("a.nc", FANUC + "G41\nG1 X5. F60.\nM30\n%\n", 7),
    ("a.nc", FANUC + "G41 D0\nG1 X5. F60.\nX7. D2\nM30\n%\n", 9),  # the radius comes later
    ("a.nc", FANUC + "D0\nT2 M6\nG41\nG1 X5. F60.\nM30\n%\n", 9),  # another tool brings its own
    ("a.nc", FANUC + "#1=1\nG41 D#1 X5.\nM30\n%\n", 8),
    ("a.ngc", "G21 G90 G17\nM428\nG0 X0 Y0 Z5\no1 sub\no1 endsub\nG41 D0\nG1 X5 F60\nM2\n", 6),
    ("a.mpf", SIEMENS + "G41 G1 X5 F60\nM30\n", 6),  # D1 holds where the program names none
    ("a.mpf", SIEMENS + "D1\nG1 X5 F60\nG42 Y5\nM30\n", 8),
    ("a.mpf", SIEMENS + "D0 G41 G1 X5 F60\nY5 D2\nM30\n", 7),
    ("a.h", KLARTEXT + "3 L X+5 RL F60\n4 END PGM A MM\n", 4),
    ("a.h", KLARTEXT + "3 CC X+5 Y+0\n4 C X+10 Y+0 DR+ RR F60\n5 END PGM A MM\n", 5),
    ("a.ncl", CREO.format("OUTPUT_ON_PROFILE") + "GOTO / 0, 0, 0\nCUTCOM / LEFT\nGOTO / 1, 0, 0\nFINI\n", 8),
]
# name, text, places that are cut to (mm)
PLAIN = [
    (
        "a.nc",
        FANUC + "G1 Z-1. F60.\nG41 D0 X5.\nY9.\nG40 X0.\nM30\n%\n",
        [[0, 0, -1], [5, 0, -1], [5, 9, -1], [0, 9, -1]],
    ),
    ("a.nc", FANUC + "G40 D7\nG1 X5. F60.\nM30\n%\n", [[5, 0, 5]]),
    ("a.mpf", SIEMENS + "D0\nG41 G1 X5 F60\nG40 Y5\nM30\n", [[5, 0, 5], [5, 5, 5]]),
    (
        "a.ncl",
        CREO.format("OUTPUT_ON_CENTER") + "GOTO / 0, 0, 0\nCUTCOM / LEFT\nGOTO / 1, 0, 0\nFINI\n",
        [[0, 0, 0], [1, 0, 0]],
    ),
]
WORN = [
    (
        "a.nc",
        FANUC + "G1 Z-1. F60.\nG41 D1 X5.\nY9.\nG40 X0.\nM30\n%\n",
        [[0, 0, -1], [5, 0, -1], [5, 9, -1], [0, 9, -1]],
    ),
    ("a.mpf", SIEMENS + "G41 G1 X5 F60\nG40 Y5\nM30\n", [[5, 0, 5], [5, 5, 5]]),
    ("a.h", KLARTEXT + "3 L X+5 RL F60\n4 L Y+5\n5 L X+0 R0\n6 END PGM A MM\n", [[5, 0, 5], [5, 5, 5], [0, 5, 5]]),
    (
        "a.ncl",
        CREO.format("OUTPUT_ON_PROFILE") + "GOTO / 0, 0, 0\nCUTCOM / LEFT\nGOTO / 1, 0, 0\nFINI\n",
        [[0, 0, 0], [1, 0, 0]],
    ),
]


def _cuts(file: Path, text: str, wear: bool) -> tuple[np.ndarray, tuple[Finding, ...]]:
    file.write_text(text, encoding="utf-8")
    path = read_toolpath(file, wear=wear)
    rows = [r.position[np.asarray(r.move) == Move.CUT] for r in path.regions]
    return np.concatenate(rows) * 1e3, path.findings


@pytest.mark.parametrize(("name", "text", "line"), OFFSETS)
def test_what_a_control_would_have_to_offset_is_refused(tmp_path: Path, name: str, text: str, line: int) -> None:
    with pytest.raises(ToolpathError, match="would offset the path") as caught:
        _cuts(tmp_path / name, text, wear=False)
    assert caught.value.line == line
    assert "cutter_compensation" in (caught.value.hint or "") and "\n" not in str(caught.value)


@pytest.mark.parametrize(("name", "text", "wanted"), PLAIN)
def test_where_no_radius_is_in_force_the_path_is_as_programmed(
    tmp_path: Path, name: str, text: str, wanted: list[list[float]]
) -> None:
    np.testing.assert_allclose(_cuts(tmp_path / name, text, wear=False)[0], wanted, atol=1e-9)


@pytest.mark.parametrize(("name", "text", "wanted"), WORN)
def test_where_the_set_up_says_wear_the_path_is_as_programmed_and_it_is_said(
    tmp_path: Path, name: str, text: str, wanted: list[list[float]]
) -> None:
    cuts, findings = _cuts(tmp_path / name, text, wear=True)
    np.testing.assert_allclose(cuts, wanted, atol=1e-9)
    assert {f.code for f in findings} & {"cutter-compensation", "cutcom"}


@pytest.mark.parametrize(
    ("body", "line", "match"),
    [
        ("3 L X+5 R+ F60\n", 4, "offset by the tool's radius"),
        ("3 L Y-5 R- F60\n", 4, "offset by the tool's radius"),
        ("3 M128\n4 L X+0 Y+0 Z+5 FMAX\n5 LN X+5 Y+0 Z+0 NX0.6 NY0 NZ0.8 F60\n", 6, "no tool axis"),
    ],
)
def test_other_offsets_of_heidenhain_are_refused(tmp_path: Path, body: str, line: int, match: str) -> None:
    with pytest.raises(ToolpathError, match=match) as caught:
        _cuts(tmp_path / "a.h", KLARTEXT + body + "9 END PGM A MM\n", wear=True)
    assert caught.value.line == line


def test_an_arc_of_heidenhain_by_a_radius_below_one_is_no_r0(tmp_path: Path) -> None:
    text = KLARTEXT + "3 CR X+1 Y+0 R0.5 DR- F60\n4 L Z+9 FMAX M30\n5 END PGM A MM\n"
    cuts, _ = _cuts(tmp_path / "a.h", text, wear=False)
    np.testing.assert_allclose(np.hypot(cuts[:, 0] - 0.5, cuts[:, 1]), 0.5, atol=1e-9)
    assert cuts[:, 1].max() > 0.4  # DR- from the left to the right goes over the top


@pytest.mark.parametrize(
    ("name", "text", "line"), [row for row in OFFSETS if row[0] in ("a.nc", "a.ncl") and "#" not in row[1]]
)
def test_the_witness_by_itself_calls_it_unread_at_the_same_line(
    tmp_path: Path, name: str, text: str, line: int
) -> None:
    (tmp_path / name).write_text(text)
    gaps = read_story(tmp_path / name).gaps
    assert [(gap.first_line, OFFSET in gap.text) for gap in gaps] == [(line, True)]
    assert not read_story(tmp_path / name, wear=True).gaps


@pytest.mark.parametrize(("name", "text", "wanted"), [row for row in PLAIN if row[0] in ("a.nc", "a.ncl")])
def test_the_witness_reads_a_path_without_a_radius(
    tmp_path: Path, name: str, text: str, wanted: list[list[float]]
) -> None:
    (tmp_path / name).write_text(text)
    story = read_story(tmp_path / name)
    assert story.complete
    np.testing.assert_allclose(story.path.tip[-len(wanted) :] * 1e3, wanted, atol=1e-9)
