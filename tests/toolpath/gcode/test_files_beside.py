"""Programs in several files: what a program calls and doesn't hold lies beside it, by the name that the control looks for."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest
from two_readings import differences

from camrob.errors import ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import Move
from camrob.witness.cl import read_story

FANUC = (
    "%\nG21 G40 G54 G80\nT26\nG90 G00 X10. Y20. Z1.\nM03 S2000 F100 G91\n"
    "M98 P5001 L2\nG00 Y-3.\nM98 P12\nG00 G90 Z50.\nM30\n%\n"
)
FANUC_SUBS = {
    "5001.nc": "(W)\nN290 G01 Z-2.\nX-5. Y30.\nG00 Z2.\nG00 X25.\nM99",
    "O0012": "%\nO0012 (DOT)\nG01 Z-2.\nG00 Z2.\nM98 P5003\nM99\n%\n",
    "o5003.NC": ":5003\nG01 Z-4.\nG00 Z4.\nM99\n",
}
# where it goes by hand, mm: (10, 20), twice W from there on, then Y by -3 and two plunges
FANUC_CUTS = [
    *((10, 20, -1), (5, 50, -1), (30, 50, -1), (25, 80, -1)),
    *((50, 77, -1), (50, 77, -3)),
]
SIEMENS = "G90 G17 G71 G54\nT1 D1 M6\nS3000 M3\nG0 X0 Y0 Z20\nTASCHE\nG0 X20\nN70 L100 P2\nG0 Z50\nM30\n"
SIEMENS_SUBS = {
    "TASCHE.SPF": ";$PATH=/_N_SPF_DIR\nG1 Z-1 F200\nX10\nG0 Z20\nM17\n",
    "l100.spf": "%_N_L100_SPF\nG91\nG1 Z-21 F100\nG0 Z21\nG0 X5\nG90\nRET\n",
}
SIEMENS_CUTS = [(0, 0, -1), (10, 0, -1), (20, 0, -1), (25, 0, -1)]
LINUXCNC = "G21 G90 G17\nT1 M6\nS3000 M3\nG0 X0 Y0 Z20\no<square> call [10] [3]\no100 call\nG0 Z40\nM2\n"
LINUXCNC_SUBS = {
    "square.ngc": "%\no<square> sub\nG1 Z[-#2] F200\nX#1\nY#1\nX0\nY0\nG0 Z20\no<square> endsub\nM2\n%\n",
    "100.ngc": "o100 sub\nG1 Z1 F100\nG0 Z20\no100 endsub\n",
}
LINUXCNC_CUTS = [(0, 0, -3), (10, 0, -3), (10, 10, -3), (0, 10, -3), (0, 0, -3), (0, 0, 1)]  # as rs274 runs it
CASES = {
    "m.nc": (FANUC, FANUC_SUBS, FANUC_CUTS),
    "m.mpf": (SIEMENS, SIEMENS_SUBS, SIEMENS_CUTS),
    "m.ngc": (LINUXCNC, LINUXCNC_SUBS, LINUXCNC_CUTS),
}


def _write(folder: Path, name: str, text: str, others: dict[str, str]) -> Path:
    for file, body in {name: text, **others}.items():
        (folder / file).write_text(body, encoding="utf-8")
    return folder / name


@pytest.mark.parametrize("name", CASES)
def test_what_is_called_is_read_from_its_own_file(tmp_path: Path, name: str) -> None:
    text, others, expected = CASES[name]
    file = _write(tmp_path, name, text, others)
    toolpath, story = read_toolpath(file), read_story(file)
    cuts = np.vstack([region.position[region.move == Move.CUT] for region in toolpath.regions]) * 1e3
    np.testing.assert_allclose(cuts, expected, atol=1e-9)
    assert story.complete and not differences(toolpath, story)
    (said,) = (finding.text for finding in toolpath.findings if finding.code == "called-files")
    assert all(other in said for other in others)


def test_the_digest_is_of_all_files(tmp_path: Path) -> None:
    file = _write(tmp_path, "m.mpf", SIEMENS, SIEMENS_SUBS)
    digest = hashlib.sha256(file.read_bytes())
    for other in SIEMENS_SUBS:
        digest.update((tmp_path / other).read_bytes())
    assert read_toolpath(file).sha256 == digest.hexdigest()
    (tmp_path / "l100.spf").write_text(SIEMENS_SUBS["l100.spf"].replace("Z-21", "Z-22"))
    assert read_toolpath(file).sha256 != digest.hexdigest()


@pytest.mark.parametrize(
    ("others", "named"),
    [
        ({}, "O5001 is called"),
        ({**FANUC_SUBS, "5001.txt": "G1 X1.\nM99\n"}, "5001.nc and 5001.txt"),
        ({**FANUC_SUBS, "5001.nc": "O5002\nG1 X1.\nM99\n"}, "another program"),
        ({**FANUC_SUBS, "5001.nc": "O5001\nG1 X1.\nM99\nO5002\nM99\n"}, "another program"),
        ({**FANUC_SUBS, "5001.nc": "\x01\x02"}, "binary"),
    ],
)
def test_a_file_that_is_none_of_it_is_not_taken_for_it(tmp_path: Path, others: dict[str, str], named: str) -> None:
    file = _write(tmp_path, "m.nc", FANUC, others)
    with pytest.raises(ToolpathError, match=named):
        read_toolpath(file)
    try:
        assert not read_story(file).complete
    except ToolpathError:
        pass


def test_a_fault_is_named_with_the_file_that_it_stands_in(tmp_path: Path) -> None:
    file = _write(tmp_path, "m.nc", FANUC, {**FANUC_SUBS, "5001.nc": "(W)\nG01 Z-2.\nG12 X5.\nM99"})
    with pytest.raises(ToolpathError) as error:
        read_toolpath(file)
    assert error.value.path == tmp_path / "5001.nc" and error.value.line == 3


def test_what_the_file_holds_itself_goes_first(tmp_path: Path) -> None:
    whole = FANUC.replace("M98 P5001 L2", "M98 P7").replace("M98 P12\n", "") + "O7\nG1 X1.\nM99\n"
    file = _write(tmp_path, "m.nc", whole, {"7.nc": "G1 X500.\nM99\n"})
    toolpath = read_toolpath(file)
    assert "called-files" not in {finding.code for finding in toolpath.findings}
    assert float(max(region.position.max() for region in toolpath.regions)) < 0.06
