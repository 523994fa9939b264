"""Words in a block of their own that change what stands behind them: none is passed over as if it weren't there.

Each was tried in the middle of a program in both readers. What is refused here stands in the manuals of the control that it
names; the witness, which never sees camrob's refusal, says at least that it can't judge what stands behind it.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from camrob.errors import CamrobError, ToolpathError
from camrob.toolpath.read import read_toolpath
from camrob.witness.cl import read_story

CUT = "G0 X1. Y2. Z20.\nG1 Z-1. F300\nX10. Y5.\n"
ISO = (
    f"%\nO1\nG21 G90 G17 G94 G40 G49 G80\nG54\nT1 M6\nS5000 M3\nG0 X0 Y0\nG43 H1 Z20.\n{CUT}"
    "@\nX12. Y6.\nG0 Z20.\n"
    f"{CUT}G0 Z50.\nM5\nM30\n%\n"
)
APT = (
    "PARTNO A\nUNITS/MM\nMULTAX/ON\nLOADTL/1\nSPINDL/5000,RPM,CLW\nRAPID\nGOTO/0,0,20,0,0,1\nFEDRAT/300,MMPM\nGOTO/1,2,-1\n"
    "GOTO/10,5,-1\n@\nGOTO/12,6,-1\nRAPID\nGOTO/12,6,20\nSPINDL/OFF\nEND\nFINI\n"
)
# word: what the reason names
STRANGE = {
    "R30. Q45.": "polar",  # Fagor: a place by radius and angle, in the motion in force
    "G1 R30. Q45. F100": "polar",
    "G0 R30. Q45.": "polar",
    "Q45.": "polar",
    "I5. J5.": "polar",
    "G0 X5. I3.": "polar",
    "G1 X11. Q3.": "polar",
    "G98 R5.": "polar",
    "N10 G25 N40.60": "jump",  # Fagor: calls, jumps, repeats
    "G20 N1": "jump",
    "G21 N1.2": "jump",
    "N10 G22 N1": "jump",
    "X11. N3": "repeat",
    "E2": "fixture offset",  # Fadal
    "G50 S3000": "a limit of the spindle",
    "G26 S3000": "a limit of the spindle",
    "G74": "machine's zero",
    "G81 X3. Y3. Z-3. R2. I2. F100\nG80\nG1": "I or J",
    "G73 Q30.": "Fagor",
    "G54 P2": "work offsets",  # Fanuc: as G54.1 P2
    "G54.1 P2": "work offsets",
    "G55": "work offsets",
    "G53": "work offset",
    "G92 X0": "origin",
    "G10 L2 P1 X5.": "origin",
    "G7": "diameter",
    "G95": "",
    "G93": "",
    "M21": "mirrors",
    "M72": "modes",  # LinuxCNC: G90 or G91 again as M70 has found it
    "M73": "modes",
    "G41 D1": "",
    "G44": "",
    "MIRROR X": "",
    "TRANS X5": "",
}
TO_THE_MACHINE = ("INSERT G51.1X0", "INSERT/G68 X0 Y0 R30", "INTCOD/G52 X5", "PPWORD/MIRROR X0", "PPWORD/TRANS X5")
MODES = {
    **dict.fromkeys(TO_THE_MACHINE, "to the machine"),
    "INCR": "steps",
    "INCR/ON": "steps",
    "MODE/INCR": "incremental",
    "SET/MODE,INCR": "incremental",
    "MODE/TURN": "turns the part",
    "IF(1)A,B,C": "part program",
    "MIRROR/XYPLAN": "mirrors",
    "SCALE/2": "scales",
    "ROTATE/ZAXIS,30": "turns",
    "PREFUN/68": "G code",
}
DONE = ("G51.1 X0", "G68 R30.", "G68 X0 Y0 R30.", "G52 X5.", "G52 X5. Y6.", "G101 X0", "S6000", "F500")
NOTHING = {  # taken as nothing by both, rightly
    "a.nc": (
        "G15",
        "G50",
        "G69",
        "G64 P0.1 Q0.05",
        "G61",
        "G40 I1. J1.",
        "G91.1",
        "T2",
        "G17 G21 G90",
        "N5",
        "M11",
    ),
    "a.apt": (
        "INSERT/G54",
        "INSERT/50MM 5FL FACE MILL",
        "PPRINT G51.1 X0",
        "INSERT/G91 G28 Z0",
        "PPWORD/5",
        "MODE/MILL",
    ),
}
TEXTS = {"a.nc": ISO, "a.apt": APT}


def _file(folder: Path, name: str, word: str) -> Path:
    (folder / name).write_text(TEXTS[name].replace("@\n", f"{word}\n" if word else ""), encoding="utf-8")
    return folder / name


@pytest.mark.parametrize(
    ("name", "word", "reason"), [("a.nc", *row) for row in STRANGE.items()] + [("a.apt", *row) for row in MODES.items()]
)
def test_a_word_that_another_control_acts_on_is_refused_by_name(
    tmp_path: Path, name: str, word: str, reason: str
) -> None:
    with pytest.raises(ToolpathError) as error:
        read_toolpath(_file(tmp_path, name, word))
    assert reason in str(error.value), str(error.value)


@pytest.mark.parametrize(("name", "word"), [("a.nc", word) for word in STRANGE] + [("a.apt", word) for word in MODES])
def test_the_witness_does_not_judge_what_stands_behind_it_as_if_it_were_not_there(
    tmp_path: Path, name: str, word: str
) -> None:
    plain = read_story(_file(tmp_path, name, ""))
    assert plain.complete
    try:
        story = read_story(_file(tmp_path, name, word))
    except CamrobError:
        return
    alike = story.complete and len(story) == len(plain) and (story.path.tip == plain.path.tip).all()
    assert not alike or not (story.feed == plain.feed).all()


@pytest.mark.parametrize("word", DONE)
def test_what_is_done_is_done_alike_and_changes_the_path(tmp_path: Path, word: str) -> None:
    name = "a.nc"
    path, plain = read_toolpath(_file(tmp_path, name, word)), read_toolpath(_file(tmp_path, name, ""))
    assert read_story(_file(tmp_path, name, word)).complete
    first, second = (
        str([(r.position.tolist(), r.feed.tolist(), [(e.kind, e.value) for e in r.events]) for r in read.regions])
        for read in (path, plain)
    )
    assert first != second


@pytest.mark.parametrize(("name", "word"), [(name, word) for name, words in NOTHING.items() for word in words])
def test_a_word_that_moves_nothing_is_no_reason_against_a_program(tmp_path: Path, name: str, word: str) -> None:
    story, path = read_story(_file(tmp_path, name, word)), read_toolpath(_file(tmp_path, name, word))
    plain = read_toolpath(_file(tmp_path, name, ""))
    assert story.complete
    assert [r.position.tolist() for r in path.regions] == [r.position.tolist() for r in plain.regions]
