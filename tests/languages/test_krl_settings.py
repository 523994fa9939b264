"""What a cell's hooks and its base_template may not say: frames and motions are camrob's."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from camrob.cell.controller_settings import HOOK_PLACEHOLDERS
from camrob.errors import CellError
from camrob.jobs.files.cell_for import cell_for
from camrob.languages.krl.krl_hooks import check_statement

FOLDER = Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table"
TEXT = (FOLDER / "cell.toml").read_text(encoding="utf-8")
CORPUS = FOLDER.parents[2] / "shared" / "corpus" / "krl"


def with_hook(folder: Path, hook: str, line: str) -> Path:
    lines = [t for t in TEXT.splitlines() if not t.startswith(f"{hook} = ")]
    lines.insert(lines.index("[controller.hooks]") + 1, f"{hook} = {json.dumps([line])}")
    (folder / "cell.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


SETS = [
    "$BASE = $NULLFRAME",
    "$BASE={X 1,Y 2,Z 3,A 0,B 0,C 0}",
    "$BASE.Z = 10",
    "$base . z=10",
    "  $TOOL = TOOL_DATA[3]",
    "$TOOL = $NULLFRAME ; ours",
    "$ACT_EX_AX = 3",
    "$ROBROOT.X = 5",
    "$WORLD = $NULLFRAME",
    "$IPO_MODE = #TCP",
    "$ASYNC_AXIS = 'B0001'",
    "$ORI_TYPE = #JOINT",
    "$VEL.CP = 2",
    "$VEL_AXIS[1] = 100",
    "$APO.CDIS = 20",
    "BASE_DATA[1] = $NULLFRAME",
    "TOOL_DATA[ 1 ].X = 4",
    "MACHINE_DEF[2].ROOT = $NULLFRAME",
    "$ET1_TA1KR = $NULLFRAME",
    "$SOFTP_END[1] = 400",
    "TRIGGER WHEN DISTANCE = 0 DELAY = 0 DO $BASE.X = 3",
    "BAS (#TOOL,2 )",
    "BAS(#BASE, 3)",
    "BAS (#FRAMES )",
    "bas(#INITMOV,0)",
]
MOVES = [
    "PTP HOME",
    "PTP {A1 0}",
    "lin {X 1}",
    "LIN_REL {Z 100}",
    "CIRC {X 1}, {X 2}",
    "SLIN XP1",
    "SPTP_REL {A1 3}",
    "SPLINE",
    "ASYPTP {E1 100}",
    "BRAKE",
]
LEAVES = ["END", "DEF OTHER ( )", "GLOBAL DEF X ()", "RETURN", "GOTO AWAY", "RESUME", "ENDFCT"]


@pytest.mark.parametrize("line", [*SETS, *MOVES, *LEAVES])
@pytest.mark.parametrize("hook", ["header", "tool_change"])
def test_frames_motions_and_ends_are_refused(tmp_path: Path, hook: str, line: str) -> None:
    with pytest.raises(CellError) as caught:
        cell_for("post", with_hook(tmp_path, hook, line))
    message = str(caught.value)
    assert re.search(rf"cell\.toml:\d+: controller: hook {hook} ", message) and line.strip() in message
    assert "leave it to camrob, or to a subprogram that puts back what it changes" in message
    kind = "sets " if line in SETS else "moves the robot" if line in MOVES else "leaves the program's course"
    assert kind in message


@pytest.mark.parametrize("hook", sorted(HOOK_PLACEHOLDERS))
def test_no_hook_is_left_out(tmp_path: Path, hook: str) -> None:
    for line in ("$TOOL = $NULLFRAME", "LIN {X 1}"):
        with pytest.raises(CellError, match=f"hook {hook} "):
            cell_for("post", with_hook(tmp_path, hook, line))


GOOD = [
    "; $BASE = $NULLFRAME",
    ";FOLD PTP HOME",
    "$OUT[3] = TRUE",
    "$ANOUT[1] = 0.5",
    "WAIT FOR $IN[4]",
    "WAIT SEC 2",
    "HALT",
    "SPINDLE_START (3)",
    "TOOL_CHANGE ( )",
    "SETBASE ($BASE)",
    "MYFRAME = $BASE",
    "MYBASE = 3",
    "OLD.X = $TOOL.X",
    "IF $BASE.X == 3 THEN",
    "ENDIF",
    'MSG_PRG = "$BASE = 3"',
    "$OV_PRO = 50",
    "$ADVANCE = 0",
    "$LOAD.M = 5",
    "LINES = 3",
    "PTPCOUNT = PTPCOUNT + 1",
    "ENDLESS = TRUE",
    "INTERRUPT DECL 3 WHEN $STOPMESS == TRUE DO IR_STOPM ( )",
    "PULSE ($OUT[2], TRUE, 0.5)",
]


@pytest.mark.parametrize("line", GOOD)
def test_outputs_waits_and_calls_are_taken(tmp_path: Path, line: str) -> None:
    assert cell_for("post", with_hook(tmp_path, "header", line)).controller.hook_lines("header") == (line,)


def test_every_assignment_to_a_frame_in_the_corpus_is_found() -> None:
    """Lines of other posts' programs that set $BASE or $TOOL, or move: none passes as a hook."""
    if not CORPUS.is_dir():
        pytest.skip("shared/corpus is not beside the project")
    lines = set()
    for file in sorted(CORPUS.rglob("*.src")):
        for line in file.read_text(encoding="latin-1").splitlines():
            code = line.split(";")[0].strip()
            word = code.upper().replace(" ", "")
            if word.startswith(("$BASE=", "$TOOL=", "BAS(#")) or code.upper().startswith(
                ("PTP ", "LIN ", "CIRC ", "SLIN ")
            ):
                lines.add(code)
    kept = [c for c in sorted(lines) if c.isascii() and c.isprintable() and "{" not in c and len(c) < 200][:400]
    assert len(kept) > 20
    for line in kept:
        with pytest.raises(CellError):
            check_statement("header", line)


# --- the base


def changed(folder: Path, *pairs: tuple[str, str]) -> Path:
    text = TEXT
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    (folder / "cell.toml").write_text(text, encoding="utf-8")
    return folder


EK = 'base_template = "EK(MACHINE_DEF[2].ROOT, MACHINE_DEF[2].MECH_TYPE, {base})"'
FALSE = ("base_follows_table = true", "base_follows_table = false")


@pytest.mark.parametrize(
    ("pairs", "said"),
    [
        ([(EK + "\n", "")], "base_follows_table is true, but base_template is missing, which stands still; write EK("),
        ([(EK, 'base_template = "{base}"')], "base_follows_table is true, but base_template is '{base}'"),
        ([(EK, 'base_template = "$WORLD : {base}"')], "which stands still"),
        ([(EK, 'base_template = "TREK(A, B, {base})"')], "which stands still"),
        ([(EK, 'base_template = "EK(A, B, {base}) : C"')], "which stands still"),
        ([(EK, 'base_template = "EK({base}, A, B)"')], "which stands still"),
        ([("act_ex_ax = 2", "act_ex_ax = 1")], "base_template names MACHINE_DEF[2] where act_ex_ax is 1; name the"),
        (
            [("MACHINE_DEF[2].ROOT", "MACHINE_DEF[3].ROOT")],
            "names MACHINE_DEF[2] and MACHINE_DEF[3] where act_ex_ax is 2",
        ),
        ([("MACHINE_DEF[2]", "machine_def [ 4 ]")], "names MACHINE_DEF[4] where act_ex_ax is 2"),
        ([FALSE], "base_template writes a base that follows the table, and base_follows_table is false; take"),
        (
            [(EK + "\n", ""), FALSE],
            "act_ex_ax is 2, which couples the base to that mechanism, and base_follows_table is",
        ),
    ],
    ids=range(11),
)
def test_a_base_of_another_mechanism_is_refused(tmp_path: Path, pairs: list[tuple[str, str]], said: str) -> None:
    with pytest.raises(CellError) as caught:
        cell_for("post", changed(tmp_path, *pairs))
    assert said in str(caught.value)


@pytest.mark.parametrize(
    "pairs",
    [
        [("act_ex_ax = 2\n", "")],
        [("MACHINE_DEF[2]", "MACHINE_DEF[3]"), ("act_ex_ax = 2", "act_ex_ax = 3")],
        [(EK, 'base_template = "ek ( EX_AX_DATA[1].ROOT, EX_AX_DATA[1].EX_KIN, {base} )"')],
        [(EK + "\n", ""), ("act_ex_ax = 2\n", ""), FALSE],
        [(EK, 'base_template = "{base}"'), ("act_ex_ax = 2", "act_ex_ax = 0"), FALSE],
    ],
    ids=range(5),
)
def test_a_base_that_fits_is_taken(tmp_path: Path, pairs: list[tuple[str, str]]) -> None:
    cell_for("post", changed(tmp_path, *pairs))


@pytest.mark.parametrize("hook", ["spindle_on", "tool_change", "coolant_on", "stop"])
def test_a_hook_of_comments_alone_does_nothing_and_is_refused(tmp_path: Path, hook: str) -> None:
    """A tool change that is only named would go on cutting with the tool of before."""
    with pytest.raises(CellError, match=f"hook {hook} holds comments alone"):
        cell_for("post", with_hook(tmp_path, hook, "; by hand"))
    cell_for("post", with_hook(tmp_path, "header", "; by hand"))
