"""Programs that begin from wherever the machine stands: moves at a feed that name the first place bit by bit."""

from __future__ import annotations

from pathlib import Path

import pytest
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move
from camrob.witness.cl import read_story
from camrob.witness.cl.standing import UNNAMED

ISO = "G21 G90 G17 G94\nT1 M6\nS5000 M3\n"
END = "X20\nG0 Z50\nM5\nM30\n"
KLARTEXT = "BEGIN PGM A MM\nTOOL CALL 1 Z S1500\n"
BEGINNINGS = {
    "feed-down.nc": ISO + "G1 Z5 F900\nX10 Y10\nZ-1 F100\n" + END,
    "rapid-across.nc": ISO + "G1 Z5 F900\nG0 X10 Y10\nG1 Z-1 F100\n" + END,
    "one-by-one.nc": ISO + "G1 Z5 F900\nX10\nY10\nG0 Z2\nG1 Z-1 F100\n" + END,
    "at-once-above.nc": ISO + "G1 X10 Y10 Z5 F900\nZ-1 F100\n" + END,
    "height-last.nc": ISO + "G1 X10 Y10 F900\nZ5\nZ-1 F100\n" + END,
    "behind-home.nc": ISO
    + "G0 X0 Y0 Z30\nG1 Z-1 F100\nX5\nG0 Z30\nG91 G28 X0 Y0\nG90\nG1 Z5 F900\nX10 Y10\nZ-1 F100\n"
    + END,
    "klartext.h": KLARTEXT
    + "L Z+5.000 R0 F9999 M13\nL X+10 Y+10\nL Z-1 F100\nL X+20\nL Z+50 FMAX\nM30\nEND PGM A MM\n",
}
CUTS = {
    "drilled.nc": ISO + "G0 Z5\nG1 Z-5 F100\nZ5\nG0 X10 Y10\nG1 Z-1\n" + END,
    "aslant.nc": ISO + "G1 Z5 F900\nX10 Y10 Z-1\n" + END,
    "slot.nc": ISO + "G1 Z-5 F100\nX10 Y10\n" + END,
    "no-more.nc": ISO + "G0 X0 Y0 Z30\nG1 Z-1 F100\nX5\nG0 Z30\nG91 G28 X0 Y0\nG90\nG1 Z5\nM30\n",
    "up-next.nc": ISO + "G1 Z5 F900\nX10 Y10\nZ9\nX12\n" + END,
    "twice.nc": ISO + "G1 Z-5 F100\nG0 Z5\nG1 Z4\nG0 X10 Y10\nG1 Z-1\n" + END,
    "klartext.h": KLARTEXT + "L Z-3 R0 F100 M13\nL X+10 Y+10\nL X+20\nL Z+50 FMAX\nM30\nEND PGM A MM\n",
}


@pytest.mark.parametrize("name", BEGINNINGS)
def test_the_way_to_the_first_place_is_left_out(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(BEGINNINGS[name], encoding="utf-8")
    toolpath, story = read_toolpath(tmp_path / name), read_story(tmp_path / name)
    assert [f.code for f in toolpath.findings if f.code == "begins-anywhere"] == ["begins-anywhere"]
    assert story.complete and any("happens to stand" in note for note in story.notes)
    assert not list(differences(toolpath, story))
    region = toolpath.regions[-1]
    at = 1e3 * region.position[region.move == int(Move.CUT)]
    assert at[-1].tolist() == pytest.approx([20, 10, -1]) and at[-2].tolist() == pytest.approx([10, 10, -1])


@pytest.mark.parametrize("name", CUTS)
def test_what_may_have_cut_somewhere_is_refused_by_both(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(CUTS[name], encoding="utf-8")
    with pytest.raises(ToolpathError, match=r"a cut while .* has no known value"):
        read_toolpath(tmp_path / name)
    assert any(UNNAMED in gap.text for gap in read_story(tmp_path / name).gaps)


def test_behind_a_tool_change_out_of_a_cut_nothing_is_left_out(tmp_path: Path) -> None:
    """How far the machine takes the tool up is its own: where it stays, as LinuxCNC's does, the next move at a feed cuts."""
    slot = ISO + "G0 X0 Y0 Z20\nG1 Z-5 F500\nY18\nT2 M6\nM3\n{}Y-19\nG0 Z8\nX30\nG1 Z-2\nX40\n" + END
    (tmp_path / "slot.nc").write_text(slot.format(""), encoding="utf-8")
    with pytest.raises(ToolpathError, match="a cut while Z has no known value"):
        read_toolpath(tmp_path / "slot.nc")
    assert not read_story(tmp_path / "slot.nc").complete
    (tmp_path / "up.nc").write_text(slot.format("G91 G28 Z0\nG90 G1 "), "utf-8")  # from there it is a way to the part
    toolpath, story = read_toolpath(tmp_path / "up.nc"), read_story(tmp_path / "up.nc")
    assert "begins-anywhere" in {f.code for f in toolpath.findings} and story.complete
    assert not list(differences(toolpath, story))


@pytest.mark.parametrize(
    ("away", "next_way", "reads"),
    [
        ("G28 X20\nG1 X30 Y3\n", "X50\n", False),  # a slot from the machine's X to 30
        ("T2 M6\nM3\nG1 X30 Y3 Z-1\n", "X50\n", False),
        ("T2 M6\nM3\nG1 X30 Y3 Z9\n", "Z-1\nX50\n", False),  # from a height that nobody knows, perhaps in the part
        ("G91 G28 Z0\nG90 G1 X30 Y3 Z-1\n", "X50\n", False),
        ("G91 G28 Z0\nG90 G1 X30 Y3 Z9\n", "Z-1\nX50\n", True),  # a way above the part
        ("G91 G28 Z0\nG90 G1 X30 Y3 Z9\n", "G0 X50\nG1 Z-1\n", True),
        ("G91 G28 Z0\nG90 G0 X30 Y3\nG1 Z-1\n", "X50\n", True),  # straight down
        ("T2 M6\nM3\nG0 X30 Y3\nG1 Z-1\n", "X50\n", True),
    ],
)
def test_a_cut_from_where_nobody_knows_is_refused_by_both(
    tmp_path: Path, away: str, next_way: str, *, reads: bool
) -> None:
    file = tmp_path / "a.nc"
    file.write_text(ISO + "G0 X0 Y0 Z20\nG1 Z-1 F100\nX20\n" + away + next_way + "G0 Z50\nM5\nM2\n", encoding="utf-8")
    story = read_story(file)
    if reads:
        assert story.complete and not list(differences(read_toolpath(file), story))
        return
    assert not story.complete
    with pytest.raises(ToolpathError, match="where the tool is not known to be"):
        read_toolpath(file)


@pytest.mark.parametrize("first", ["G1 X0 Y0 Z-1 F100\nX10\n", "G92 X0 Y0 Z5\nG1 X10 F100\n", "G1 X0 Y0 Z5 F100\nZ6\n"])
def test_a_first_cut_across_is_one_from_where_nobody_knows(tmp_path: Path, first: str) -> None:
    """Fully named, it is still a way from wherever the machine stands: LinuxCNC's rs274 cuts aslant to it."""
    file = tmp_path / "a.nc"
    file.write_text(ISO + first + END, encoding="utf-8")
    with pytest.raises(ToolpathError, match="where the tool is not known to be, as the first of the program"):
        read_toolpath(file)
    assert not read_story(file).complete


UNDER_TCP = {
    "a.mpf": (
        "gcode-siemens",
        "T1 D1\nS3000 M3\nG90 G71\n{}TRAORI\nG1 X10. Y5. Z-2. F500\nX60.\nG0 Z50\nTRAFOOF\nM30\n",
    ),
    "a.nc": (
        "gcode-xyzac-iso",
        "G21 G90\nT1 M6\nS3000 M3\n{}G43.4 H1\nG1 X10. Y5. Z-2. A10. C20. F500\nX60.\nG0 Z50.\nG49\nM30\n",
    ),
}


@pytest.mark.parametrize("name", UNDER_TCP)
def test_a_first_cut_under_tcp_begins_nowhere_too(tmp_path: Path, name: str) -> None:
    """A control's straight line begins where the machine stands, with a tip held as without."""
    dialect, text = UNDER_TCP[name]
    file = tmp_path / name
    file.write_text(text.format(""))
    with pytest.raises(ToolpathError, match="where the tool is not known to be"):
        read_toolpath(file, dialect=dialect)
    assert "not known to be" in read_story(file, dialect=dialect).gaps[0].text
    file.write_text(text.format("G0 X0. Y0.\nG43.4 H1 Z5.\n" if name == "a.nc" else "G0 X0. Y0.\nG0 Z5.\n"))
    assert not read_story(file, dialect=dialect).gaps
    assert read_toolpath(file, dialect=dialect).points > 2
