"""Okuma's OSP by the rules of its programming manual: paths worked out by hand, in both readings, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import EventKind, Move
from camrob.witness.cl import read_story

HEAD = (
    "$PART.MIN%\nO1234\n(ROUGH)\nG15 H1\nG17 G90 G94 G40 G80 G21\nT5 M6\nG0 Z300\nG56 H5 Z50\nS8000 M3\nM8\nG0 X50 Y0\n"
)
TAIL = "G0 Z50\nM9\nM5\nG53\nG30 P1\nM2\n"


def cuts(folder: Path, body: str, name: str = "part.min", head: str = HEAD) -> np.ndarray:
    """Tips of cuts, mm, in camrob's reading; the witness reads all of the program, too (`conftest` holds it to camrob's)."""
    file = folder / name
    file.write_text(head + body + TAIL)
    path = read_toolpath(file, chord_tolerance=1e-6)
    assert read_story(file).complete
    return np.concatenate([r.position[r.move == Move.CUT] for r in path.regions]) * 1e3


@pytest.mark.parametrize("name", ["part.min", "part.nc"])
def test_a_program_of_osp(tmp_path: Path, name: str) -> None:
    """G2 from (50, 0) round (50, 10) clockwise: by (40, 10) and (50, 20) to (60, 10), three quarters of a circle."""
    found = cuts(tmp_path, "G1 Z-1 F500\nG2 X60 Y10 I0 J10\nG91 G1 X5 Z-1\nG90 G3 X65 Y20 R5\n", name)
    np.testing.assert_allclose(found[[0, -1]], [[50, 0, -1], [65, 20, -2]], atol=1e-6)
    arc = found[(found[:, 2] == -1.0)]
    angle = np.unwrap(np.arctan2(arc[:, 1] - 10.0, arc[:, 0] - 50.0))
    assert angle[-1] - angle[0] == pytest.approx(-1.5 * math.pi)
    np.testing.assert_allclose(np.hypot(arc[:, 0] - 50.0, arc[:, 1] - 10.0), 10.0, atol=1e-6)


def heights(folder: Path, body: str) -> list[list[float]]:
    """X, Y, Z in mm of all points, and whether each is cut to, in camrob's reading, which the witness shares."""
    cuts(folder, body)
    regions = read_toolpath(folder / "part.min", chord_tolerance=1e-6).regions
    return [
        [*(float(v) for v in np.round(p * 1e3, 6)), int(m)]
        for r in regions
        for p, m in zip(r.position, r.move, strict=True)
    ]


def test_drilling_returns_to_the_level_of_g71(tmp_path: Path) -> None:
    """From 50 down to R, in, and up to G71's 20 behind each hole; the second is deeper."""
    found = heights(tmp_path, "G71 Z20\nG81 X5 Y6 Z-5 R2 F100 M53\nX15\nY8 Z-7\nG80\nG0 X0\n")
    first = [[5, 6, 50, 0], [5, 6, 2, 0], [5, 6, -5, 1], [5, 6, 2, 0], [5, 6, 20, 0]]
    second = [[15, 6, 20, 0], [15, 6, 2, 0], [15, 6, -5, 1], [15, 6, 2, 0], [15, 6, 20, 0]]
    third = [[15, 8, 20, 0], [15, 8, 2, 0], [15, 8, -7, 1], [15, 8, 2, 0], [15, 8, 20, 0]]
    assert [p for p in found if p in first or p in second or p in third] == first + second + third


def test_tapping_turns_the_spindle_back_at_the_bottom(tmp_path: Path) -> None:
    """In and out at the feed, the spindle reversed between and forwards again at R; then up to G71's level."""
    found = heights(tmp_path, "G71 Z20\nG84 X5 Y6 Z-5 R2 F800 M53\nG80\nG0 X0\n")
    at = found.index([5, 6, -5, 1])
    assert found[at - 1 : at + 3] == [[5, 6, 2, 0], [5, 6, -5, 1], [5, 6, 2, 1], [5, 6, 20, 0]]
    events = [e for r in read_toolpath(tmp_path / "part.min").regions for e in r.events]
    assert [e.text for e in events if e.kind is EventKind.SPINDLE_ON] == ["CLW", "CCLW", "CLW"]


def test_boring_stops_the_spindle_before_it_comes_out(tmp_path: Path) -> None:
    """G86: in at the feed, the spindle stands, out in rapid, and turns again; G74 taps with the spindle left-handed."""
    found = heights(tmp_path, "G71 Z20\nG86 X5 Y6 Z-5 R2 F800 M53\nG80\nM4\nG74 X9 Y6 Z-5 R2 F800 M53\nG80\n")
    at = found.index([5, 6, -5, 1])
    assert found[at - 1 : at + 3] == [[5, 6, 2, 0], [5, 6, -5, 1], [5, 6, 2, 0], [5, 6, 20, 0]]
    events = [e for r in read_toolpath(tmp_path / "part.min").regions for e in r.events]
    said = [e.text or "off" for e in events if e.kind in (EventKind.SPINDLE_ON, EventKind.SPINDLE_OFF)]
    assert said[:6] == ["CLW", "off", "CLW", "CCLW", "CLW", "CCLW"]


def test_drilling_returns_to_r_with_m54(tmp_path: Path) -> None:
    found = heights(tmp_path, "G71 Z20\nG83 X5 Y6 Z-5 R2 Q4 F100 M54\nX15\nG0 Z20\n")
    assert [15, 6, 2, 0] in found and [15, 6, 20, 0] not in found[:-3]
    assert [p[2] for p in found if p[3]] == [-2, -5, -2, -5]


@pytest.mark.parametrize("length", ["G56 H5 Z50", "G56 HA Z50", "G56 HA\nZ50"])
def test_the_tools_length(tmp_path: Path, length: str) -> None:
    found = cuts(tmp_path, "G1 Z-1 F500\nX60\n", head=HEAD.replace("G56 H5 Z50", length))
    np.testing.assert_allclose(found, [[50, 0, -1], [60, 0, -1]], atol=1e-9)


def test_the_name_alone_says_whose_it_is(tmp_path: Path) -> None:
    cuts(tmp_path, "G1 Z-1 F500\nX60\n", head=HEAD.replace("G15 H1\n", ""))


@pytest.mark.parametrize(
    ("body", "match"),
    [
        ("G81 X5 Y5 Z-5 R2 F100\n", "G81, a drilling cycle of OSP, without M53"),
        ("G81 X5 Y5 Z-5 R2 F100 M53\n", "without M53 and a level by G71"),
        ("G71 Z50\nG81 X5 Y5 Z-5 R2 F100 M52\n", "the machine's upper limit"),
        ("G71 Z50\nG82 X5 Y5 Z-5 R2 P500 F100 M53\n", "G82 of OSP in G91, or with a dwell"),
        ("G71 Z50\nG83 X5 Y5 Z-5 R2 I1 J3 F100 M53\n", "G83 of OSP in G91, or with"),
        ("G71 Z50\nG91\nG81 X5 Y5 Z-5 R2 F100 M53\n", "G81 of OSP in G91"),
        ("G71 Z1\nG81 X5 Y5 Z-5 R2 F100 M53\n", "G71's level lies below R"),
        ("G0 Z10\nG71 Z20\nG81 X5 Y5 Z-5 R2 F100 M53\n", "from below G71's level"),
        ("G71 Z50 F3\n", "G71 with more than its level"),
        ("G87 X5 Y5 Z-5 R2 F100 M53\n", "G87, a drilling cycle of OSP, is not read"),
        ("G71 Z50\nG84 X5 Y5 Z-5 R2 P1 F100 M53\n", "or with a dwell P"),
        ("G54 H2\n", "a tool's length along another axis"),
        ("G1 Z-1 F500\nG15 H2\nG1 X5\n", "several work offsets"),
        ("G1 Z-1 F500\nG53\nG1 X5\n", "a cut without the tool's length"),
        ("G1 Z-1 F500\nG56 H6\nG1 X5\n", "behind cuts of the same tool with H5"),
        ("G53 Z0\n", "G53 with axes"),
        ("G15\n", "G15 without an H"),
        ("G56 Z20\n", "G56 without an H"),
        ("G56 H0\n", "G56 without an H, or with H0"),
        ("G16 H0 Z0\n", "G16 of OSP"),
        ("G11 X10 Y0 P30\n", "G11 of OSP"),
        ("G62 X1\n", "G62 of OSP"),
        ("G116 T3\n", "G116 of OSP"),
        ("G68.2 I0 J0 K0\n", "G68.2 of OSP"),
        ("G4 F2\n", "G4 of OSP"),
        ("G169 HA=1 HB=2\n", "G169 .OSP's tool centre point"),
        ("VC1=3\n", "variables, calls, jumps"),
        ("G1 X=VC1*10 F100\n", "variables, calls, jumps"),
        ("CALL OSUB\n", "variables, calls, jumps"),
        ("NAB1\n", "variables, calls, jumps"),
        ("IF [VC2 LT 20] NAB1\n", "variables, calls, jumps"),
        ("M13\n", "M13 of OSP"),
    ],
)
def test_what_is_osps_own_is_refused(tmp_path: Path, body: str, match: str) -> None:
    file = tmp_path / "part.min"
    file.write_text(HEAD + body + TAIL)
    line = HEAD.count("\n") + body.count("\n")
    with pytest.raises(ToolpathError, match=match) as caught:
        read_toolpath(file)
    assert HEAD.count("\n") < caught.value.line <= line
    assert not read_story(file).complete


def test_whole_numbers_beside_pointed_ones_are_asked_about(tmp_path: Path) -> None:
    file = tmp_path / "part.min"
    file.write_text(HEAD + "G1 X10. Y5 F100\n" + TAIL)
    with pytest.raises(ToolpathError, match=r"OSP takes it for 0\.3 where"):
        read_toolpath(file)
