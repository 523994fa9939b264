"""RAPID as it is read: programs of other hands, whose numbers are known; what is refused; what is damage."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from rapid_sample import RAPID, bracket, read_module, written
from scipy.spatial.transform import Rotation

from camrob.controller.motion_settings import motion_settings
from camrob.errors import ProgramError
from camrob.languages.rapid.reader.tokens import canonical
from camrob.program.axis_turns import quarters_of, turn_of
from camrob.program.language import AddedTarget, NewTarget
from camrob.program.motion import Blend, Motion, Turning
from camrob.program.program_text import FrameKind

OTHER_HAND = """%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%

module cutter (sysmodule, nostepin)
  ! somebody's own hand; no CAM system
  local pers tooldata tGun := [TRUE, [[0, 0, 210.5], [0.5, 0.5, 0.5, 0.5]],
      [12.5, [1, 2, 90], [1, 0, 0, 0], 0.1, 0.2, 0.3]];   ! on three
  task pers wobjdata wFix := [FALSE, TRUE, "", [[1000, 0, 500], [0.707106781, 0, 0, 0.707106781]], [[10, 0, 0], [1, 0, 0, 0]]];
  const robtarget pStart := [[100, 200, 300], [1, 0, 0, 0], [-1, 0, -2, 0], [9E+09, 9E+09, 90.5, 9E9, 9E9, 9E9]];
  const jointtarget jHome := [[0, -10, 20, 0, 45, -30], [9E9, 9E9, 0, 9E9, 9E9, 9E9]];
  const speeddata vSlow := [5, 30, 5000, 1000];
  const num nDepth := 2 * (3 - 0.5);
  var num nUnused;

  proc main()
    MoveAbsJ jHome \\NoEOffs, v1000, fine, tGun \\WObj := wFix;
    movej pStart, v500, z10, tGun\\wobj:=wFix;
    SetDO doWater, 1;  MoveL Offs(pStart, 10, 0, -nDepth), vSlow, z1, tGun\\WObj:=wFix; WaitTime 0.25;
    TPWrite "no MoveL here; not even ! a comment";
    rest;
    MoveAbsJ jHome\\NoEOffs, vmax2, fine, tGun;
  endproc

  proc rest()
    var robtarget p10;
    p10 := pStart;
    p10.trans.z := 310;
    MoveC p10, [[110,210,300],[0.5,0.5,0.5,0.5],[0,0,0,0],[9E9,9E9,91,9E9,9E9,9E9]], v20, fine, tGun\\WObj:=wFix;
    return;
    MoveL pStart, v5, fine, tGun;
  endproc

  func num twice(num a)
    return 2 * a;
  endfunc
endmodule
""".replace("vmax2", "v7000")


def test_a_program_of_another_hand(tmp_path: Path) -> None:
    text = read_module(OTHER_HAND, tmp_path)
    P, J, L, V, E = Motion
    assert text.kind.tolist() == [P, J, L, V, E, P] and not text.findings and text.name == "CUTTER"
    assert text.axes[0].tolist() == [0, -10, 20, 0, 45, -30] and text.external_names == ("E3",)
    assert text.external[:, 0].tolist() == [0, 90.5, 90.5, 90.5, 91, 0]
    assert text.pose[1].tolist() == [100, 200, 300, 0, 0, 0] and text.pose[2, :3].tolist() == [110, 200, 295]
    assert text.pose[3, :3].tolist() == [100, 200, 310]
    turn = Rotation.from_euler("ZYX", text.pose[4, 3:], degrees=True).as_quat()
    assert np.abs(np.abs(turn) - 0.5).max() < 1e-12
    assert text.status[1] == 2 and quarters_of(text.turn[1]).tolist() == [-1, 0, -2]
    assert text.speed.tolist() == [0, 0, 0.005, 0.02, 0.02, 0] and text.wait.tolist() == [0, 0, 0, 0.25, 0, 0]
    assert text.blend.tolist() == [Blend.EXACT, Blend.DISTANCE, Blend.DISTANCE, Blend.EXACT, Blend.EXACT, Blend.EXACT]
    assert text.blend_mm[1:3].tolist() == [10.0, 1.0] and text.settings["turn_speed"].value == 30.0
    tool, base = text.tools[text.tool[1]], text.bases[text.base[1]]
    assert tool.kind is FrameKind.LITERAL and np.allclose(tool.xyzabc, [0, 0, 210.5, 90, 0, 90], atol=1e-12)
    # the user frame turns by 90 degrees, the object frame lies 10 mm along its x
    assert base.kind is FrameKind.LITERAL and np.allclose(base.xyzabc, [1000, 10, 500, 90, 0, 0], atol=1e-6)
    assert text.bases[text.base[5]].xyzabc.tolist() == [0] * 6  # without \\WObj it is wobj0
    assert text.line.tolist() == [18, 19, 20, 30, 30, 23]
    said = [a.text for a in text.actions]
    assert "SETDO DOWATER , 1.0" in said and 'TPWRITE "no MoveL here; not even ! a comment"' in said
    assert [a.motion for a in text.actions if a.text.startswith("WAITTIME")] == [3]


def test_a_work_object_on_a_unit_and_a_tool_that_stands(tmp_path: Path) -> None:
    body = """MODULE a
PERS tooldata tFix:=[FALSE,[[0,0,1],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
PERS wobjdata wTab:=[FALSE,FALSE,"STN1",[[7,7,7],[1,0,0,0]],[[1,2,3],[0,1,0,0]]];
PERS wobjdata wHeld:=[TRUE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
PROC go()
MoveL [[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0\\WObj:=wTab;
MoveL [[0,0,1],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tFix\\WObj:=wHeld;
MoveL [[0,0,2],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tElsewhere\\WObj:=wElsewhere;
ENDPROC
ENDMODULE
"""
    text = read_module(body, tmp_path)
    kinds = [(text.tools[t].kind, text.bases[b].kind) for t, b in zip(text.tool, text.base, strict=True)]
    unknown = FrameKind.UNKNOWN
    assert kinds == [(FrameKind.LITERAL, FrameKind.MECHANISM), (unknown, unknown), (unknown, unknown)]
    assert text.bases[text.base[0]].xyzabc.tolist() == [
        1,
        2,
        3,
        0,
        0,
        180,
    ]  # the user frame is the unit's, not the data's
    assert text.external_names == ()


def test_reading_at_one_go_and_token_by_token_is_the_same(tmp_path: Path) -> None:
    """A MoveL as camrob prints it is read by its own way; with blanks in it, statement by statement."""
    plain = written(bracket())["Bracket_7.mod"].decode()
    spaced = re.sub(r"MoveL \[", "MoveL  [", plain)
    first, second = (read_module(text, tmp_path) for text in (plain, spaced))
    for name in (
        "kind",
        "pose",
        "axes",
        "external",
        "status",
        "turn",
        "speed",
        "blend",
        "blend_mm",
        "wait",
        "line",
        "tool",
        "base",
    ):
        assert np.array_equal(getattr(first, name), getattr(second, name), equal_nan=True), name
    assert first.actions == second.actions and first.settings == second.settings


def whole(text: str) -> str:
    """A module around statements."""
    return f"MODULE m\nPROC main()\n{text}\nENDPROC\nENDMODULE\n"


TARGET = "[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("MoveL p1,v5,fine,tool0;", "P1, which is not in the program"),
        (f"MoveL {TARGET},vMine,fine,tool0;", "VMINE"),
        (f"MoveL {TARGET},v5,zMine,tool0;", "ZMINE"),
        (f"MoveL {TARGET},v5,fine;", "has not all its arguments"),
        (f"MoveL {TARGET},[0,1,1,1],fine,tool0;", "not positive"),
        (f"MoveL {TARGET},v5,v5,tool0;", "zone is none"),
        (f"MoveL {TARGET.replace('[1,0,0,0]', '[1,1,0,0]')},v5,fine,tool0;", "not of length 1"),
        (f"MoveJ {TARGET.replace('[0,0,0,0]', '[0,0,0,8]')},v5,fine,tool0;", "configuration"),
        (f"MoveJ {TARGET.replace('[0,0,0,0]', '[0.5,0,0,0]')},v5,fine,tool0;", "configuration"),
        (f"TriggL {TARGET},v5,t1,fine,tool0;", "is not read here"),
        ("SyncMoveOn sync1, tasks;", "moves several robots at once"),
        ("SearchL di1,p,p1,v5,tool0;", "is not read here"),
        (f"FOR i FROM 1 TO others DO\nMoveL {TARGET},v5,fine,tool0;\nENDFOR", "that moves"),
        (f"IF a=1 THEN\nMoveL {TARGET},v5,fine,tool0;\nENDIF", "that moves"),
        (f"IF a=1 MoveL {TARGET},v5,fine,tool0;", "that moves"),
        ("WHILE TRUE DO\nSetDO a,1;", "no end"),
        ("main;", "nested more than"),
        ("WaitTime -1;", "a time is positive"),
        ("SetDO a,#;", "is no RAPID"),
        ("SetDO a,1", "has no end|no ENDMODULE|no ENDPROC"),
        ("ENDPROC\nENDMODULE\nMODULE n\nPROC main()", "stands outside|second|no ENDPROC|is the file damaged"),
    ],
)
def test_what_is_not_in_the_text_or_damaged_is_refused(tmp_path: Path, text: str, match: str) -> None:
    with pytest.raises(ProgramError, match=match) as caught:
        read_module(whole(text), tmp_path)
    assert str(caught.value).startswith(str(tmp_path / "part.mod")) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("PDispOn p1,tool0;", "not-understood"),
        ("EOffsSet [1,0,0,0,0,0];", "not-understood"),
        ("VelSet 50,800;", "not-understood"),
        ("SingArea\\Wrist;", "not-understood"),
        ("DeactUnit STN1;", "not-understood"),
        ("IF a=1 THEN\nSetDO b,1;\nELSE\nStop;\nENDIF", "not-understood"),
        ("TEST a\nCASE 1,2:\nSetDO b,1;\nDEFAULT:\nStop;\nENDTEST", "not-understood"),
        ("here: SetDO a,1;", "not-understood"),
        (f"MoveL {TARGET},v5\\T:=3,fine,tool0;", "not-understood"),
        ("SpindleOn 3;", "call-unknown"),
        ("WaitTime nSome;", "wait-unknown"),
    ],
)
def test_what_may_do_more_than_is_known_is_a_finding(tmp_path: Path, text: str, code: str) -> None:
    after = f"MoveL {TARGET},v5,fine,tool0;"
    read = read_module(whole(f"{text}\n{after}"), tmp_path)
    assert {f.code for f in read.findings} == {code} and read.kind[-1] == Motion.LIN
    assert read.findings[0].line == 3


def test_parts_are_those_that_the_list_names(tmp_path: Path) -> None:
    for name, content in written(bracket(), max_lines=4).items():
        (tmp_path / name).write_bytes(content)
    main = tmp_path / "Bracket_7.mod"
    whole_ = RAPID.read(main)
    assert whole_.files == ("Bracket_7.mod", "Bracket_7_001.mod", "Bracket_7_002.mod") and len(whole_) == 9
    assert sorted(set(whole_.file.tolist())) == [0, 1, 2]
    (tmp_path / "Bracket_7_002.mod").unlink()
    with pytest.raises(ProgramError, match=r"lists 'Bracket_7_002\.mod'"):
        RAPID.read(main)
    (tmp_path / "Bracket_7.pgf").unlink()
    alone = RAPID.read(main)
    assert {f.code for f in alone.findings} == {"call-unknown"} and len(alone) < 9


def test_a_circle_whose_tool_turns_with_it_is_said(tmp_path: Path) -> None:
    from camrob.cell.read_cell import read_cell

    cell = read_cell(Path(__file__).resolve().parents[2] / "cells" / "irb6700_table")
    for mode, said in (("ObjectFrame", set()), ("PathFrame", {"rotation-type"}), ("", {"rotation-type"})):
        line = f"CirPathMode\\{mode};\n" if mode else ""
        arc = f"MoveC {TARGET},{TARGET},v5,fine,tool0;"
        read = read_module(whole(line + arc), tmp_path)
        assert {f.code for f in motion_settings(read, cell).findings} == said


def test_one_spelling() -> None:
    assert canonical("setdo  DoA , 1.0 ; ! on") == canonical("SetDO doA,1;") == "SETDO DOA , 1.0"
    assert canonical('TPWrite "a; B!";') == 'TPWRITE "a; B!"' and canonical("a{1}:=-.5e1;") == "A { 1.0 } := - 5.0"


def test_hostile_text_ends(tmp_path: Path) -> None:
    """Brackets and statements without end, calls in a ring: an error each, soon."""
    for text in ("x:=" + "[" * 50_000, "SetDO " + "a," * 200_000, f"MoveL {'-' * 50_000}1,v5,fine,tool0;"):
        with pytest.raises(ProgramError):
            read_module(whole(text), tmp_path)
    ring = "MODULE m\nPROC main()\n" + "a;\n" * 400 + "ENDPROC\n"
    ring += "".join(
        f"PROC {p}()\n{n};\n{n};\nENDPROC\n" for p, n in zip("abcdefghijklmnop", "bcdefghijklmnopq", strict=True)
    )
    with pytest.raises(ProgramError, match="more statements than"):
        read_module(ring + "PROC q()\nSetDO x,1;\nENDPROC\nENDMODULE\n", tmp_path)


def test_patching_keeps_all_else(tmp_path: Path) -> None:
    line = f"  MoveC {TARGET}, {TARGET.replace('9E9,9E9', '12.5,9E9', 1)},v5,fine,tool0; ! {TARGET}"
    text = f"{line}\nMoveAbsJ [[0,0,0,0,0,0],[1,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs,v5,fine,tool0;\nMoveL p1,v5,fine,tool0;"
    assert [RAPID.targets(t) for t in text.split("\n")] == [2, 1, 0]
    pose = NewTarget((1.0, 2.0, 3.0, 0.0, 0.0, 180.0), False)
    new = RAPID.patch(text, {1: [pose, pose], 2: [NewTarget((1.0, 2.0, 3.0, 4.0, 5.0, 6.0), True)]})
    assert (
        new.split("\n")[0].count("[[1.0000,2.0000,3.0000],[0.00000000,1.00000000,0.00000000,0.00000000],[0,0,0,0],[")
        == 2
    )
    assert new.split("\n")[0].endswith(f"[12.5,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0; ! {TARGET}")
    assert new.split("\n")[1].startswith("MoveAbsJ [[1.0000,2.0000,3.0000,4.0000,5.0000,6.0000],[1,9E9,")
    turned = NewTarget(pose.values, False, turn=int(turn_of(Turning.QUARTERS, [-0.1, 0.0, 0.0, 100.0, 0.0, 0.1])))
    assert "],[-1,1,0,0],[" in RAPID.patch(f"MoveJ {TARGET},v5,fine,tool0;", {1: [turned]})
    for number, targets in ((1, [pose]), (2, [pose]), (3, [pose])):
        with pytest.raises(ProgramError):
            RAPID.patch(text, {number: targets})
    added = AddedTarget((1.0, 2.0, 3.0, 0.0, 0.0, 0.0), {"E1": 7.0, "E2": 8.0})
    single = f"MoveL {TARGET.replace('9E9,9E9', '12.5,9E9', 1)},v5,z1,tool0;"
    first, second = RAPID.divide(single, {1: [added]}).split("\n")
    assert second == single and "[7.0000,9E9,9E9" in first and first.endswith("v5,z1,tool0;")
    with pytest.raises(ProgramError):
        RAPID.divide(text, {1: [added]})
