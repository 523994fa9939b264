"""Heidenhain's CALL PGM of a file beside, CT, INT and FRAC, comments over several lines, and why some cycles are not read."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move
from camrob.witness.cl import read_story

HEAD = "BEGIN PGM MAIN MM\nTOOL CALL 1 Z S3000 F300\nM3\n"
END = "M30\nEND PGM MAIN MM\n"


def _file(folder: Path, text: str, **others: str) -> Path:
    for name, body in {"main": text, **others}.items():
        (folder / f"{name}.h").write_text(body, encoding="utf-8")
    return folder / "main.h"


def _cuts(file: Path, *, whole: bool = True) -> NDArray[np.float64]:
    """The cuts' ends, mm; both readings have to agree on the whole file, or `whole` is false and the witness reads no further."""
    toolpath, story = read_toolpath(file), read_story(file)
    assert story.complete == whole
    if whole:
        assert not differences(toolpath, story)
    return np.vstack([region.position[region.move == Move.CUT] for region in toolpath.regions]) * 1e3


def _refused(folder: Path, text: str, match: str, **others: str) -> None:
    with pytest.raises(ToolpathError, match=match):
        read_toolpath(_file(folder, text, **others))


SLOT = "0 BEGIN PGM SLOT MM\n1 L Z-Q1 F100\n2 L IX+10 F300\n3 L Z+5 FMAX\n4 END PGM SLOT MM\n"


def test_a_program_from_a_file_beside_runs_with_the_parameters_of_its_caller(tmp_path: Path) -> None:
    main = (
        HEAD
        + "L X+0 Y+0 Z+5 FMAX\nQ1 = 2\nCALL PGM TNC:\\parts\\SLOT.H\nL X+0 Y+20 FMAX\nQ1 = 3\nCALL PGM SLOT\n"
        + END
    )
    cuts = _cuts(_file(tmp_path, main, slot=SLOT))
    np.testing.assert_allclose(cuts, [[0, 0, -2], [10, 0, -2], [0, 20, -3], [10, 20, -3]], atol=1e-9)
    said = next(f.text for f in read_toolpath(tmp_path / "main.h").findings if f.code == "called-files")
    assert "slot.h" in said


def test_labels_and_ql_are_the_called_programs_own(tmp_path: Path) -> None:
    """LBL 1 of both, a QL1 of both: the caller's is as it was."""
    sub = (
        "BEGIN PGM SUB MM\nQL1 = 9\nCALL LBL 1\nL Z+5 FMAX\nFN 9: IF +0 EQU +0 GOTO LBL 2\n"
        "LBL 1\nL Z-QL1 F100\nLBL 0\nLBL 2\nEND PGM SUB MM\n"
    )
    main = (
        HEAD
        + "QL1 = 4\nL X+0 Y+0 Z+5 FMAX\nCALL PGM SUB\nL X+QL1 FMAX\nCALL LBL 1\nL Z+5 FMAX\n"
        + "M30\nLBL 1\nL Z-1\nLBL 0\nEND PGM MAIN MM\n"
    )
    cuts = _cuts(_file(tmp_path, main, sub=sub), whole=False)
    np.testing.assert_allclose(cuts, [[0, 0, -9], [4, 0, -1]], atol=1e-9)


@pytest.mark.parametrize(
    ("called", "match"),
    [
        ({}, "neither in this file nor beside it"),
        ({"slot": SLOT.replace(" MM", " INCH")}, "another unit"),
        ({"slot": SLOT.replace("3 L Z+5 FMAX", "3 L Z+5 FMAX M30")}, "M2 or M30 in a program that is called"),
        ({"slot": SLOT.replace("3 L Z+5 FMAX", "3 CALL PGM SLOT")}, "calls itself"),
    ],
)
def test_what_is_refused_of_programs_that_are_called(tmp_path: Path, called: dict[str, str], match: str) -> None:
    _refused(tmp_path, HEAD + "L X+0 Y+0 Z+5 FMAX\nQ1 = 2\nCALL PGM SLOT\n" + END, match, **called)


def _joins(points: NDArray[np.float64], way: tuple[float, float]) -> tuple[float, float]:
    """Radius of the circle through points of an arc, and the corner (degrees) between a way and its start."""
    a, b, c = points[0], points[len(points) // 2], points[-1]
    m = np.array([b - a, c - a])
    center = a + np.linalg.solve(m, 0.5 * np.array([(b - a) @ (b - a), (c - a) @ (c - a)]))
    ray = a - center
    return float(np.linalg.norm(ray)), math.degrees(
        math.asin(abs(float(ray @ way)) / float(np.linalg.norm(ray) * np.hypot(*way)))
    )


def test_ct_goes_on_without_a_corner(tmp_path: Path) -> None:
    """The manual's own figures (TNC 640, 6.4: L X+0 Y+25, L X+25 Y+30, CT X+45 Y+20), held to the circle through its points."""
    main = HEAD + "L X+0 Y+25 Z+5 FMAX\nL Z-2\nL X+25 Y+30\nCT X+45 Y+20\nL Y+0\nL Z+5 FMAX\n" + END
    cuts = _cuts(_file(tmp_path, main))
    ends = [int(np.flatnonzero(np.all(np.isclose(cuts[:, :2], p, atol=1e-6), axis=1))[0]) for p in ([25, 30], [45, 20])]
    radius, corner = _joins(cuts[ends[0] : ends[1] + 1, :2], (25.0, 5.0))
    assert corner == pytest.approx(0.0, abs=1e-4)
    chord, turned = math.hypot(20.0, 10.0), math.atan2(-10.0, 20.0) - math.atan2(5.0, 25.0)
    assert radius == pytest.approx(chord / (2.0 * abs(math.sin(turned))), rel=1e-6)


def test_ct_behind_arcs_and_by_steps(tmp_path: Path) -> None:
    """A half circle, then CT IX+20: the same way on gives the other half of an S; two CT in a row."""
    main = HEAD + "L X+0 Y+0 Z+5 FMAX\nL Z-1\nCC X+10 Y+0\nC X+20 Y+0 DR-\nCT IX+20\nCT X+60 Y+0\nL Z+5 FMAX\n" + END
    cuts = _cuts(_file(tmp_path, main))
    assert cuts[:, 1].max() == pytest.approx(10.0, abs=0.02) and cuts[:, 1].min() == pytest.approx(-10.0, abs=0.02)
    last = cuts[(cuts[:, 0] > 41.0) & (cuts[:, 0] < 59.0), 1]
    assert last.min() > 0.0 and last.max() == pytest.approx(10.0, abs=0.02)


@pytest.mark.parametrize(
    "before",
    [
        "L X+25 Y+30 FMAX",
        "CR X+25 Y+30 R+40 DR+",
        "L X+25 Y+30\nRND R2",
        "L X+25 Y+30\nL Z-3",
        "L X+45 Y+20\nL X+45 Y+20",
    ],
)
def test_ct_where_nobody_knows_the_way(tmp_path: Path, before: str) -> None:
    _refused(tmp_path, HEAD + f"L X+0 Y+25 Z+5 FMAX\nL Z-2\n{before}\nCT X+45 Y+20\n" + END, "CT ")


def test_int_and_frac_need_no_brackets(tmp_path: Path) -> None:
    main = (
        HEAD
        + "Q4 = ( 0 - -7 ) / 2\nQ5 = INT Q4\nQ6 = FRAC Q4\nQ7 = INT -2.7\nL X+Q5 Y+Q6 Z+5 FMAX\nL Z+Q7\nL Z+5 FMAX\n"
        + END
    )
    np.testing.assert_allclose(_cuts(_file(tmp_path, main)), [[3, 0.5, -2]], atol=1e-9)
    _refused(tmp_path, HEAD + "Q4 = 0.1 * 3 * 10\nQ5 = INT Q4\nL X+Q5 Y+0 Z+5 FMAX\n" + END, "which rounding decides")


def test_a_comment_that_goes_on_is_no_statement(tmp_path: Path) -> None:
    main = (
        "0 BEGIN PGM MAIN MM\n1 ;this goes on ~\n  L X+9 Y+9 Z-9~\n to here\n2 TOOL CALL 1 Z S3000 F300\n"
        + "M3\nL X+0 Y+0 Z+5 FMAX\nL Z-1\n"
        + END
    )
    assert _cuts(_file(tmp_path, main)).tolist() == [[0, 0, -1]]


@pytest.mark.parametrize(
    ("cycle", "match"),
    [
        ("202 BORING", "held at an angle"),
        ("208 BORE MILLING", "tool's radius"),
        ("251 POCKET", "tool's radius"),
        ("209 TAPPING", "tap"),
    ],
)
def test_cycles_are_refused_by_what_they_are(tmp_path: Path, cycle: str, match: str) -> None:
    _refused(
        tmp_path, HEAD + f"L X+0 Y+0 Z+5 FMAX\nCYCL DEF {cycle}~\n Q200=2~\n Q201=-5\nL X+0 Y+0 FMAX M99\n" + END, match
    )


def test_a_piece_without_its_beginning_is_called_that(tmp_path: Path) -> None:
    _refused(tmp_path, "L X1,5 Y0.5 FMAX\nL Z2.0 FMAX\nL Z-0.2 FAUTO\nL Y9.5\n", "a piece of a Heidenhain program")


def test_squares_sides_angles_and_a_centre_where_the_tool_is(tmp_path: Path) -> None:
    """SQ 3 is 9, of sides 3 and 4 FN 8 gives 5, FN 13 of 5 across and 5 beside 45 degrees; CC alone is where the tool is."""
    sums = "Q1 = SQ 3 + 2^3\nFN 8: Q2 = +3 LEN +4\nFN 13: Q3 = +5 ANG +5\nFN 13: Q4 = -5 ANG +0\n"
    file = _file(tmp_path, HEAD + sums + "L X+Q1 Y+Q2 Z+5 FMAX\nL Z-1\nL X+Q3 Y+Q4\nL Z+5 FMAX\n" + END)
    (region,) = read_toolpath(file).regions
    cuts = region.position[region.move == Move.CUT] * 1e3
    np.testing.assert_allclose(cuts, [[17, 5, -1], [45, 270, -1]], atol=1e-9)
    text = "Q1 = SQ 3\nL X+Q1 Y+2 Z+5 FMAX\nCC\nL X+19 FMAX\nL Z-1\nC X+9 Y+12 DR+\nL Z+5 FMAX\n"
    turned = _file(tmp_path, HEAD + text + END)
    toolpath, story = read_toolpath(turned), read_story(turned)
    assert story.complete
    assert not list(differences(toolpath, story))
    (arc,) = toolpath.regions[0].arcs
    assert arc.center[:2] * 1e3 == pytest.approx([9, 2])
    assert math.degrees(arc.angle) == pytest.approx(90)


def test_a_label_behind_the_end_is_called_and_not_run_into(tmp_path: Path) -> None:
    """Some write subprograms behind END PGM; F may stand before S in TOOL CALL."""
    text = (
        HEAD.replace("S3000 F300", "F300 S3000")
        + "L X+0 Y+0 Z+5 FMAX\nCALL LBL 5\nL X+20 FMAX\nCALL LBL 5\nEND PGM MAIN MM\n"
    )
    cuts = _cuts(_file(tmp_path, text + "LBL 5\nL Z-2\nL IX+5\nL Z+5\nLBL 0\n"))
    assert cuts.round(6).tolist() == [[0, 0, -2], [5, 0, -2], [5, 0, 5], [20, 0, -2], [25, 0, -2], [25, 0, 5]]
