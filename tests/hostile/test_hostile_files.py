"""Files that CAM systems and hands do write: cuts without a way in, operations that begin in a cut, FROM anywhere.

Each is posted, or refused in one line that says what its author can do; never called a fault of camrob's.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from process_story import PLACED_Z, cell_with, posted, story, text_of

from camrob.errors import CamrobError
from camrob.jobs.files.inputs import program_name
from camrob.jobs.post import PostResult
from camrob.languages import language_named

HEAD = "UNITS/MM\nLOADTL/1\nSPINDL/3000,RPM,CLW\nFEDRAT/500,MMPM\n"
DOWN = "RAPID\nGOTO/0,0,50\nGOTO/0,0,-2\nGOTO/20,0,-2\n"
OUT = "RAPID\nGOTO/30,0,50\nSPINDL/OFF\nFINI\n"


def happenings(made: PostResult) -> list[str]:
    return story(text_of(made))


def refused(folder: Path, file: str, content: str, **options) -> str:
    with pytest.raises(CamrobError) as error:
        posted(folder, file, content, **options)
    message = str(error.value)
    assert "fault of camrob" not in message and "\n" not in message
    return message


def feeds(made: PostResult) -> list[float]:
    """mm/min of every motion that leads to a point at depth."""
    program = made.program
    deep = np.asarray(program.pose)[:, 2] < PLACED_Z - 1.0
    return sorted(set(np.round(np.asarray(program.speed)[deep] * 60000.0).tolist()))


# ---- a region goes on with the cut in which the one before it ends

NX = "TOOL PATH/{name},TOOL,T1\nTLDATA/MILL,10,0,50,0,0\n"
BETWEEN = {
    "another MSYS": "MSYS/10,0,0,1,0,0,0,1,0\nGOTO/10,0,-2\nGOTO/20,0,-2\nMSYS/0,0,0,1,0,0,0,1,0\n",
    "the same tool again": "LOADTL/1\nGOTO/30,0,-2\n",
    "the same tool twice": "LOADTL/1\nLOADTL/1\nGOTO/20,0,-2\nGOTO/30,0,-2\n",
    "FROM there": "FROM/20,0,-2\nGOTO/30,0,-2\n",
    "FROM there, and a dwell": "DELAY/1\nFROM/20,0,-2\nGOTO/20,0,-2\nGOTO/30,0,-2\n",
    "another operation": "END-OF-PATH\n" + NX.format(name="TWO") + "GOTO/20,0,-2\nGOTO/30,0,-2\n",
    "another operation, and coolant": "END-OF-PATH\n" + NX.format(name="TWO") + "COOLNT/ON\nGOTO/30,0,-2\n",
}


@pytest.mark.parametrize("between", BETWEEN)
def test_a_region_that_goes_on_with_a_cut_stays_in_it(tmp_path: Path, between: str) -> None:
    begin = NX.format(name="ONE") + "MSYS/0,0,0,1,0,0,0,1,0\n" + HEAD.replace("UNITS/MM\n", "") + DOWN
    made = posted(tmp_path, "part.cls", begin + BETWEEN[between] + OUT.replace("FINI", "END-OF-PATH"))
    motions = [s for s in happenings(made) if s[0] in "-0123456789"]
    assert motions[:5] == ["0 100", "0 50", "0 -2", "20 -2", "30 -2"] and motions[-2:] == ["30 50", "30 100"]
    assert feeds(made) == [500.0]


def test_an_operation_that_cuts_from_where_the_one_before_retracted_to(tmp_path: Path) -> None:
    begin = NX.format(name="ONE") + HEAD.replace("UNITS/MM\n", "") + DOWN + "RAPID\nGOTO/20,0,50\nEND-OF-PATH\n"
    made = posted(
        tmp_path,
        "part.cls",
        begin + NX.format(name="TWO") + "GOTO/20,10,-2\nGOTO/30,0,-2\n" + OUT.replace("FINI", "END-OF-PATH"),
    )
    assert happenings(made)[6:13] == ["0 -2", "20 -2", "20 50", "20 -2", "30 -2", "30 50", "30 100"]


def test_a_tool_changed_within_a_cut_is_refused(tmp_path: Path) -> None:
    message = refused(tmp_path, "part.apt", HEAD + DOWN + "LOADTL/2\nSPINDL/3000,RPM,CLW\nGOTO/30,0,-2\n" + OUT)
    assert "changed in the middle of a cut" in message and "retract" in message and "line 9" in message


# ---- a cut from nowhere, and FROM


def test_the_first_motion_is_a_cut(tmp_path: Path) -> None:
    made = posted(tmp_path, "part.apt", HEAD + "GOTO/0,0,-2\nGOTO/20,0,-2\n" + OUT)
    program = made.program
    first = int(np.flatnonzero(np.asarray(program.line) == 5)[0])
    assert not program.approximate[first], "the cut begins there: the corner is not rounded off"
    assert feeds(made) == [500.0]


FROM = {
    "cut straight": ("", "FROM/0,0,50\nGOTO/0,0,-2\nGOTO/20,0,-2\n", ["0 50", "0 -2", "20 -2"]),
    "aslant": ("", "FROM/10,0,50\nGOTO/0,0,-2\nGOTO/20,0,-2\n", ["10 50", "0 -2", "20 -2"]),
    "in a cut": (DOWN, "FROM/40,0,50\nGOTO/40,0,-2\nGOTO/50,0,-2\n", ["40 50", "40 -2", "50 -2"]),
    "in the air": (
        DOWN + "RAPID\nGOTO/20,0,50\n",
        "FROM/40,0,50\nGOTO/40,0,-2\nGOTO/50,0,-2\n",
        ["40 50", "40 -2", "50 -2"],
    ),
}


@pytest.mark.parametrize("case", FROM)
def test_a_cut_from_where_from_says_that_the_tool_stands(tmp_path: Path, case: str) -> None:
    before, way, points = FROM[case]
    made = posted(tmp_path, "part.apt", HEAD + before + way + OUT)
    motions = [s for s in happenings(made) if s[0] in "-0123456789"]
    assert any(motions[k : k + 3] == points for k in range(len(motions)))
    assert made.summary.witness.complete


# ---- the spindle's words

SPINDLE = {
    "locked": "SPINDL/LOCK\n",
    "locked at an angle": "SPINDL/LOCK,90\n",
    "oriented": "SPINDL/ORIENT,90\n",
}


@pytest.mark.parametrize("case", SPINDLE)
def test_a_spindle_that_is_locked_stands(tmp_path: Path, case: str) -> None:
    word = SPINDLE[case]
    up = "RAPID\nGOTO/20,0,50\n"
    made = posted(
        tmp_path, "part.apt", HEAD + DOWN + up + word + "DELAY/1\nSPINDL/ON\n" + up + "GOTO/20,0,-2\n" + up + OUT
    )
    way = happenings(made)
    at = way.index("off")
    assert way[at : at + 4] == ["off", "wait 1", "speed 3000", "on"]


def test_a_speed_of_zero_lets_the_spindle_stand_and_the_cut_warns(tmp_path: Path) -> None:
    made = posted(tmp_path, "part.nc", GCODE + "S0 M3\nG0 X0 Y0 Z50\nZ5\nG1 Z-2 F500\nX20\nG0 Z50\nM5\nM30\n")
    codes = [w.code for w in made.summary.warnings]
    assert "spindle-zero" in codes and "cut-without-spindle" in codes and "on" not in happenings(made)


def test_a_surface_speed_goes_by_the_setups_tool(tmp_path: Path) -> None:
    setup = "part_in_base = [0, 0, 198, 0, 0, 0]\n[tool]\ndiameter_mm = 10\n"
    content = HEAD.replace("3000,RPM", "100,SMM") + DOWN + OUT
    made = posted(tmp_path, "part.apt", content, setup=setup)
    assert "speed 3183.099" in happenings(made) and made.summary.witness.complete
    two = setup.replace("[tool]", "[[tool]]\nnumber = 1") + "[[tool]]\nnumber = 2\ndiameter_mm = 20\n"
    (tmp_path / "two").mkdir()
    made = posted(tmp_path / "two", "part.apt", content, setup=two)
    assert "speed 3183.099" in happenings(made)


def test_a_speed_that_is_no_whole_number(tmp_path: Path) -> None:
    made = posted(tmp_path, "part.apt", HEAD.replace("3000", "3183.5") + DOWN + OUT)
    assert "speed 3183.5" in happenings(made)


# ---- G-code: cycles and changes

GCODE = "G21 G90 G17\nT1 M6\n"
CYCLE = {
    "named once": "G91 G99 G81 X10 Z-7 R-8 F300\nX10 K3\n",
    "all in one": "G91 G99 G81 X10 Z-7 R-8 K4 F300\n",
    "named in G90": "G99 G81 X10 Z-5 R2 F300\nG91 X10 K3\n",
}


@pytest.mark.parametrize("case", CYCLE)
def test_r_counts_from_where_the_cycles_began(tmp_path: Path, case: str) -> None:
    start = GCODE + "S3000 M3\nG0 X0 Y0 Z50\nZ10\n"
    made = posted(tmp_path, "part.nc", start + CYCLE[case] + "G80\nG90 G0 Z50\nM5\nM30\n")
    holes = [s for s in happenings(made) if s.endswith(" -5")]
    assert holes == ["10 -5", "20 -5", "30 -5", "40 -5"] and made.summary.witness.complete


def test_a_tap_takes_no_pecks_from_the_cycle_before_it(tmp_path: Path) -> None:
    start = GCODE + "S3000 M3\nG0 X0 Y0 Z50\nZ10\nG83 Z-5 R2 Q2 F300\n"
    cell = cell_with(
        tmp_path,
        (
            r"^spindle_on = .*",
            r'spindle_on = ["$ANOUT[1] = {speed} / 24000.0", "$OUT[1] = TRUE", "WAIT SEC 3.0"]'
            '\nspindle_on_ccw = ["$ANOUT[1] = {speed} / 24000.0", "$OUT[3] = TRUE", "WAIT SEC 3.0"]',
        ),
    )
    made = posted(tmp_path, "part.nc", start + "G84 X20 Z-5 R2 F300\nG80\nG0 Z50\nM5\nM30\n", cell=cell)
    assert "on, reversed" in happenings(made)
    message = refused(tmp_path, "part.nc", start + "G84 X20 Z-5 R2 Q1 F300\nG80\nG0 Z50\nM5\nM30\n", cell=cell)
    assert "tapping (G84) by pecks" in message


@pytest.mark.parametrize("behind", ["G0 Z50\nG0 X30\n", "G0 X30 Y0 Z50\n", "S3000 M3\nG0 Z50\nX30\n"])
def test_a_tool_changed_at_depth_before_a_rapid_is_changed_in_the_clear(tmp_path: Path, behind: str) -> None:
    start = GCODE + "S3000 M3\nG0 X0 Y0 Z50\nZ5\nG1 Z-2 F500\nX20\n"
    spindle = "" if "M3" in behind else "S3000 M3\n"
    made = posted(tmp_path, "part.nc", start + "T2 M6\n" + spindle + behind + "G1 Z-2\nG0 Z50\nM5\nM30\n")
    way = happenings(made)
    at = way.index("tool 2")
    assert way[at - 4 : at] == ["20 -2", "20 100", "off", "home"]
    assert made.summary.process.tool_changes


def test_a_reserved_name_is_said_to_be_one() -> None:
    for name, reserved in (("x", True), ("Lin", True), ("a-b", False), ("", False), ("1a", False)):
        with pytest.raises(CamrobError) as error:
            program_name(Path("part.cls"), name, language_named("krl"))
        assert ("KRL uses that word itself" in str(error.value)) is reserved


# ---- what is done in the middle of a cut, as the file says, and said

INTERRUPTED = {
    "another speed": ("SPINDL/4000,RPM,CLW\n", "spindle-in-part"),
    "the spindle off": ("SPINDL/OFF\n", "spindle-in-part"),
    "a stop": ("STOP\n", "stop-in-part"),
    "mist": ("COOLNT/MIST\n", "coolant-kind"),
    "through the tool": ("COOLNT/THRU\n", "coolant-kind"),
    "flood": ("COOLNT/FLOOD\n", ""),
    "a dwell": ("DELAY/1\n", ""),
    "a message": ("PPRINT x\n", ""),
}


@pytest.mark.parametrize("case", INTERRUPTED)
def test_a_cut_that_is_interrupted_is_said(tmp_path: Path, case: str) -> None:
    word, code = INTERRUPTED[case]
    made = posted(tmp_path, "part.apt", HEAD + DOWN + word + "GOTO/30,0,-2\n" + OUT)
    said = {w.code: w.line for w in made.summary.warnings}
    coded = {"spindle-in-part", "stop-in-part", "coolant-kind"} & set(said)
    assert coded == ({code} if code else set())
    assert not code or said[code] == 9


def test_what_happens_in_the_air_is_no_interruption(tmp_path: Path) -> None:
    up = "RAPID\nGOTO/20,0,50\n"
    between = up + "STOP\nSPINDL/4000,RPM,CLW\nRAPID\nGOTO/25,0,50\nGOTO/25,0,-2\n"
    made = posted(tmp_path, "part.apt", HEAD + DOWN + between + OUT)
    assert not {"spindle-in-part", "stop-in-part"} & {w.code for w in made.summary.warnings}
