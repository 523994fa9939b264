"""G49 behind G43: a cut there is the spindle's, not the tool's. G43.5: the tool's axis by vectors, read by the witness, too."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.witness.cl import read_story

HEAD = "G21 G90 G17 G94 G40 G49 G80\nT1 M6\nS5000 M3\nG0 X0 Y0\n"
CUT = "G1 Z-1. F300\nX10.\nG0 Z50.\n"


@pytest.mark.parametrize(
    "behind", ["X5.\nZ5.\n" + CUT, "X5. Z5.\nG81 X5. Z-2. R3. F100\nG80\n", "X5. Z5.\nG3 I-5. F100\n"]
)
def test_a_cut_behind_g49_has_no_length(tmp_path: Path, behind: str) -> None:
    file = tmp_path / "a.nc"
    file.write_text(HEAD + "G43 H1 Z20.\n" + CUT + "G49\nG0 " + behind + "M30\n", encoding="utf-8")
    with pytest.raises(ToolpathError, match=r"without the tool's length \(G49\)"):
        read_toolpath(file)
    assert any("without the tool's length (G49)" in gap.text for gap in read_story(file).gaps)


@pytest.mark.parametrize(
    "text",
    [
        "Z20.\n" + CUT,  # no length anywhere: the tools are set by their tips
        "G43 H1 Z20.\n" + CUT + "G49 Z100.\nG91 G28 Z0\nG90\nT2 M6\nS5000 M3\nG43 H2 Z20.\n" + CUT,
        "G43 H1 Z20.\n" + CUT + "G53 G49 Z0\nG0 X0 Y0\nG43 H1 Z20.\n" + CUT,
    ],
)
def test_g49_before_g43_and_behind_the_last_cut_is_as_it_was(tmp_path: Path, text: str) -> None:
    file = tmp_path / "a.nc"
    file.write_text(HEAD + text + "G49\nM30\n", encoding="utf-8")
    assert sum(len(region) for region in read_toolpath(file).regions) >= 3
    assert read_story(file).gaps == ()


@pytest.mark.parametrize("word", ["G43 H2", "G43.4 H1", "H3"])
def test_a_length_behind_cuts_of_the_same_tool_without_any(tmp_path: Path, word: str) -> None:
    """LinuxCNC's interpreter moves what follows by the table's length; the program lay 2.54 mm off, verified whole."""
    file = tmp_path / "a.nc"
    file.write_text(HEAD + "Z20.\n" + CUT + word + "\nG91\nG1 Z-51. F300\nX5.\nG90\nG0 Z50.\nM30\n", encoding="utf-8")
    with pytest.raises(ToolpathError, match="behind cuts of the same tool without any length"):
        read_toolpath(file, dialect="gcode-xyzac-iso")
    assert any("tool's lengths" in gap.text for gap in read_story(file, dialect="gcode-xyzac-iso").gaps)
    other = tmp_path / "b.nc"  # each tool has its own: the first one is set by its tip
    other.write_text(
        HEAD + "Z20.\n" + CUT + "T2 M6\nS5000 M3\nG0 X0 Y0\nG43 H2 Z20.\n" + CUT + "M30\n", encoding="utf-8"
    )
    assert read_story(other).gaps == ()
    assert len(read_toolpath(other).regions) == 2


@pytest.mark.parametrize("cut", ["X10.", "X10. Z-1.", "G2 X10. I5.", "G91\nZ-2.", "G91\nG81 X1. Z-3. R-1."])
def test_a_cut_at_a_height_that_a_length_has_changed(tmp_path: Path, cut: str) -> None:
    """Behind `G0 Z5`, `G43 H1` Z is another one by the length (LinuxCNC's interpreter: an arc 2.54 mm lower)."""
    file = tmp_path / "a.nc"
    file.write_text(HEAD + f"Z5.\nG43 H1\nG1 F300\n{cut}\nG90\nG0 Z50.\nM30\n", encoding="utf-8")
    with pytest.raises(ToolpathError, match="since which Z has not been named"):
        read_toolpath(file)
    assert any("Z has not been named" in gap.text for gap in read_story(file).gaps)


@pytest.mark.parametrize("way", ["G0 Z5.\nG1 X10.", "G1 Z-1.\nX10.", "G81 X10. Z-3. R2.", "G0 X9.\nG1 Z-1."])
def test_a_height_that_is_named_behind_a_length_is_known(tmp_path: Path, way: str) -> None:
    file = tmp_path / "a.nc"
    file.write_text(HEAD + f"Z5.\nG43 H1\nG1 F300\n{way}\nG0 Z50.\nM30\n", encoding="utf-8")
    assert read_story(file).gaps == ()
    assert not list(differences(read_toolpath(file), read_story(file)))


def test_the_witness_reads_tool_axes_by_vectors(tmp_path: Path) -> None:
    file = tmp_path / "a.nc"
    text = (
        "G43.5 H1\nG0 Z10. I0 J0 K1.\nG1 Z0 F600.\nX10. I0.3 J0 K0.4\nX20. Y5.\nI0 J0.5 K0\nG0 Z20. K2.\nG49\nM5\nM30\n"
    )
    file.write_text(HEAD + text, encoding="utf-8")
    story = read_story(file)
    assert story.gaps == ()
    axes = story.path.axis.round(12).tolist()
    assert axes[-4:] == [[0.6, 0, 0.8], [0.6, 0, 0.8], [0, 1, 0], [0, 0, 1]]
    assert (story.path.tip[-2] * 1e3).round(9).tolist() == [20, 5, 0]
    reading = read_toolpath(file).regions[-1]
    assert np.allclose(reading.axis[-1], [0, 1, 0])  # the way out is left to the cell


@pytest.mark.parametrize("block", ["X5. I0 J0 K1. Q5.", "G2 X5. I2.5", "X5. I0 J0 K0", "G91 X5. I0 J0 K1."])
def test_what_else_g43_5_may_hold_the_witness_does_not_judge(tmp_path: Path, block: str) -> None:
    file = tmp_path / "a.nc"
    file.write_text(HEAD + "G43.5 H1\nG0 Z10. K1.\nG1 Z0 F600.\n" + block + "\nX10.\nM30\n", encoding="utf-8")
    assert not read_story(file).complete
