"""Drilling as real programs have it: cycles across G90 and G91, parameters on lines of their own, corners between polar cuts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.witness.cl import read_story
from camrob.witness.happenings import Way

ISO = "G21 G90 G17 G94\nT1 M6\nS5000 M3\nF200\nG0 X0. Y0. Z3.\n"
END = "G80 G90\nG0 Z30.\nM30\n"
KLARTEXT = "BEGIN PGM A MM\nTOOL CALL 1 Z S5000 F500\nL X+50 Y+50 Z+30 R0 FMAX M3\n"


def _bottoms(tmp_path: Path, name: str, text: str) -> list[float]:
    """How deep both readings drill, mm; they have to agree."""
    (tmp_path / name).write_text(text, encoding="utf-8")
    toolpath, story = read_toolpath(tmp_path / name), read_story(tmp_path / name)
    assert story.complete and not list(differences(toolpath, story))
    return [1e3 * float(tip[2]) for tip, way in zip(story.path.tip, story.way, strict=True) if way == Way.HOLE]


def test_a_row_of_holes_in_g91_keeps_the_heights_of_g90(tmp_path: Path) -> None:
    """Haas, "Mill Operator's Manual", looping canned cycles: G81 in G90, then G91 X L."""
    row = ISO + "G99 G81 X0. Y0. Z-1.1 R0.2\nG91 X10. L3\n" + END
    assert _bottoms(tmp_path, "row.nc", row) == pytest.approx([-1.1] * 4)
    assert "cycle-heights-kept" in {finding.code for finding in read_toolpath(tmp_path / "row.nc").findings}


@pytest.mark.parametrize("word", ["K3", "L3"])
def test_a_hole_that_is_repeated_in_g90_is_drilled_again_at_its_place(tmp_path: Path, word: str) -> None:
    """Fanuc B-63944EN, 13.1: in G90 drilling is repeated at the same position; LinuxCNC's rs274 does it, too."""
    row = ISO + f"G99 G81 X0. Y0. Z-1.1 R0.2 {word}\nX10.\n" + END
    assert _bottoms(tmp_path, "row.nc", row) == pytest.approx([-1.1] * 4)
    cuts = [region.position for region in read_toolpath(tmp_path / "row.nc").regions]
    assert sum(int((np.abs(tips - (0.0, 0.0, -1.1e-3)).max(axis=1) < 1e-9).sum()) for tips in cuts) == 3
    numbered = "O1\n" + ISO.replace("Z3.\n", "Z3.\nM98 P7 K3\n") + END  # K counts there, too, on some: no millimetre
    (tmp_path / "k.nc").write_text(numbered, encoding="utf-8")
    with pytest.raises(ToolpathError, match="K of a block"):
        read_toolpath(tmp_path / "k.nc")


@pytest.mark.parametrize(
    ("name", "second", "named"),
    [
        ("a.ngc", "G91 X1. L3", "G91 with R and Z of G90"),  # LinuxCNC drills these to 2.1, not to -1.1 (rs274)
        ("a.nc", "X1. Y0. R0. G91 L3", "G91 with Z of G90"),  # the NIST interpreter's own sample: to 1.9
        ("a.nc", "G91 X1. Z-1.3", "G91 with R of G90"),
    ],
)
def test_heights_that_controls_count_otherwise_are_refused(tmp_path: Path, name: str, second: str, named: str) -> None:
    (tmp_path / name).write_text(ISO + f"G81 X3. Y4. R0.2 Z-1.1\n{second}\n" + END, encoding="utf-8")
    with pytest.raises(ToolpathError, match=named):
        read_toolpath(tmp_path / name)
    if name == "a.nc":
        assert "heights" in read_story(tmp_path / name).gaps[0].text
    whole = ISO + "G81 X3. Y4. R0.2 Z-1.1\nX1. Y0. R0. Z-1. G91 L3\n" + END
    assert _bottoms(tmp_path, "b.ngc", whole) == pytest.approx([-1.1, 2.0, 2.0, 2.0])


def test_a_cycle_whose_parameters_stand_on_lines_of_their_own(tmp_path: Path) -> None:
    lines = "CYCL DEF 200 DRILLING\nQ200 = 2 ;CLEARANCE\nQ201=-15\nQ206 = 300\nQ202= 20\nQ203=+0\nQ204=+10\nQ210=0\n"
    text = KLARTEXT + lines + "Q5 = 7\nL X+Q5 FMAX M99\nL Z+50 FMAX\nM30\nEND PGM A MM\n"
    assert _bottoms(tmp_path, "a.h", text) == pytest.approx([-15.0])
    numbered = text.replace("Q200 = 2", "4 Q200 = 2")  # a block of its own: a parameter is set
    (tmp_path / "b.h").write_text(numbered, encoding="utf-8")
    with pytest.raises(ToolpathError, match="without Q200"):
        read_toolpath(tmp_path / "b.h")


def test_corners_between_polar_cuts(tmp_path: Path) -> None:
    """A hexagon of 40 about (50, 50): a corner of radius r begins r tan(30 degrees) before it."""
    sides = "RND R15\n".join(["LP IPA+60\n"] * 6)
    text = KLARTEXT + f"CC X+50 Y+50\nLP PR+40 PA+0 FMAX\nL Z-2\n{sides}L Z+10 FMAX\nM30\nEND PGM A MM\n"
    assert not _bottoms(tmp_path, "a.h", text)
    points = 1e3 * np.vstack([region.position for region in read_toolpath(tmp_path / "a.h").regions])
    corner = np.array([70.0, 50.0 + 40.0 * np.sin(np.pi / 3.0), -2.0])
    begin = corner + 15.0 * np.tan(np.pi / 6.0) * np.array([0.5, -np.sin(np.pi / 3.0), 0.0])
    assert np.linalg.norm(points - begin, axis=1).min() < 1e-6
    beyond = points[points[:, 2] < 0.0][1:-1, :2] - 50.0  # nothing is cut beyond the inscribed circle of the corners
    assert np.linalg.norm(beyond, axis=1).max() < 40.0 - 15.0 * (2.0 / np.sqrt(3.0) - 1.0) + 1e-6


def test_a_comment_within_a_comment(tmp_path: Path) -> None:
    assert _bottoms(tmp_path, "a.nc", '($Message("load [Files]") )\n' + ISO + "G81 X3. Y4. R0.2 Z-1.1\n" + END)
