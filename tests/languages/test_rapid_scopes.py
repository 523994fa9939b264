"""Names of RAPID that hide each other, as reader and witness both read them ("Technical reference manual, RAPID overview", scope
rules for data): a procedure's own data hide its module's, and what one module declares LOCAL no other module sees.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from process_story import ROOT

from camrob.errors import ProgramError
from camrob.languages.rapid.reader.read_rapid import read_rapid
from camrob.witness.machine import read_machine
from camrob.witness.rapid.run_module import run_program

IRB6700 = ROOT / "cells" / "irb6700_table"
UNIT = "[1,0,0,0]"
SPINDLE = "[TRUE,[[165,0,405.788],[0,0.2588190451,0,0.9659258263]],[40,[50,0,200],[1,0,0,0],0,0,0]]"
LONGER = SPINDLE.replace("405.788", "505.788")
DATA = f'PERS tooldata tS:={SPINDLE};\nPERS wobjdata wP:=[FALSE,FALSE,"STN1",[[0,0,0],{UNIT}],[[0,0,0],{UNIT}]];\n'
HOME = "ActUnit STN1; MoveAbsJ [[0,-15,20,0,55,0],[0,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs,v100,fine,tS\\WObj:=wP;\n"
GO = "MoveL p1,v100,fine,tS\\WObj:=wP;\n"


def at(x: float) -> str:
    """A robtarget at this X."""
    return f"[[{x},0,300],[0,1,0,0],[0,0,0,0],[0,9E9,9E9,9E9,9E9,9E9]]"


def written(folder: Path, own: str, body: str, other: str) -> Path:
    """A main module that declares `own`, and the module `other` beside it."""
    (folder / "a.mod").write_text(f"MODULE a\n{DATA}{own}PROC main()\n{HOME}{body}ENDPROC\nENDMODULE\n")
    (folder / "b.mod").write_text(f"MODULE b\n{other}ENDMODULE\n")
    (folder / "a.pgf").write_text("<Program><Module>a.mod</Module><Module>b.mod</Module></Program>")
    return folder / "a.mod"


SEEN = {
    "a procedure's own": (f"CONST robtarget p1:={at(5)};\n", f"PROC sub()\nVAR robtarget p1:={at(7)};\n{GO}ENDPROC\n"),
    "two modules' LOCAL": (
        f"LOCAL CONST robtarget p1:={at(5)};\n",
        f"LOCAL CONST robtarget p1:={at(7)};\nPROC sub()\n{GO}ENDPROC\n",
    ),
    "LOCAL over all": (
        f"CONST robtarget p1:={at(5)};\n",
        f"LOCAL CONST robtarget p1:={at(7)};\nPROC sub()\n{GO}ENDPROC\n",
    ),
}


@pytest.mark.parametrize("name", SEEN)
def test_the_nearest_name_counts(tmp_path: Path, name: str) -> None:
    own, other = SEEN[name]
    path = written(tmp_path, own, GO + "sub;\n" + GO, other)
    made = run_program(path, read_machine(IRB6700))
    assert (1000.0 * made.path.tip[1:, 0]).round(6).tolist() == [5, 7, 5] and not made.gaps
    assert read_rapid(path).pose[1:, 0].round(6).tolist() == [5, 7, 5]


def test_another_modules_local_is_not_seen(tmp_path: Path) -> None:
    path = written(tmp_path, "", GO, f"LOCAL CONST robtarget p1:={at(7)};\nPROC sub()\n{GO}ENDPROC\n")
    assert any("P1 isn't in the program" in gap.text for gap in run_program(path, read_machine(IRB6700)).gaps)
    with pytest.raises(ProgramError, match="P1"):
        read_rapid(path)


def test_another_modules_local_procedure_is_not_called(tmp_path: Path) -> None:
    path = written(tmp_path, f"CONST robtarget p1:={at(5)};\n", "sub;\n" + GO, f"LOCAL PROC sub()\n{GO}ENDPROC\n")
    made = run_program(path, read_machine(IRB6700))
    assert any("not at hand" in gap.text for gap in made.gaps) and len(made.path.tip) == 2


def test_each_module_has_its_own_local_procedures(tmp_path: Path) -> None:
    """Two LOCAL procedures of one name, and a third that all see: each module calls its own."""
    own = f"LOCAL PROC go()\nMoveL {at(5)},v100,fine,tS\\WObj:=wP;\nENDPROC\n"
    other = own.replace("[5,", "[7,") + "PROC sub()\ngo;\nENDPROC\n"
    path = written(tmp_path, "", "go;\nsub;\n", other)
    path.write_text(path.read_text().replace("ENDMODULE", f"{own}ENDMODULE"))
    made = run_program(path, read_machine(IRB6700))
    assert (1000.0 * made.path.tip[1:, 0]).round(6).tolist() == [5, 7] and not made.gaps
    assert read_rapid(path).pose[1:, 0].round(6).tolist() == [5, 7]
    for file, text in ((path, own), (tmp_path / "b.mod", own.replace("[5,", "[7,"))):
        file.write_text(file.read_text().replace(text, text.replace("LOCAL ", "")))
    with pytest.raises(ProgramError, match="second procedure"):
        read_rapid(path)
    with pytest.raises(ProgramError, match="another module"):
        run_program(path, read_machine(IRB6700))


def test_a_position_that_nothing_sets_is_zero(tmp_path: Path) -> None:
    move = f"MoveL Offs({at(5)},p.x+1,p.y,p.z),v100,fine,tS\\WObj:=wP;\n"
    path = written(tmp_path, "VAR pos p;\n", move + "p.x:=3;\n" + move, "")
    made = run_program(path, read_machine(IRB6700))
    assert (1000.0 * made.path.tip[1:, 0]).round(6).tolist() == [6, 9] and not made.gaps
    assert read_rapid(path).pose[1:, 0].round(6).tolist() == [6, 9]


def test_a_tool_is_the_modules_own(tmp_path: Path) -> None:
    """The spindle of module b is 100 mm longer, and behind its procedure the shorter one is in force again."""
    other = f"LOCAL PERS tooldata tS:={LONGER};\nPROC sub()\n{GO}ENDPROC\n"
    path = written(tmp_path, f"CONST robtarget p1:={at(5)};\n", GO + "sub;\n" + GO, other)
    made, read = run_program(path, read_machine(IRB6700)), read_rapid(path)
    lengths = [1000.0 * made.tools[k][2, 3] for k in made.tool[1:]], [read.tools[k].xyzabc[2] for k in read.tool[1:]]
    assert np.allclose(lengths, [[405.788, 505.788, 405.788]] * 2)


def test_a_word_that_begins_as_set_is_no_output(tmp_path: Path) -> None:
    path = written(tmp_path, f"CONST robtarget p1:={at(5)};\n", "ResetPPMoved;\n" + GO, "")
    assert any("not at hand" in gap.text for gap in run_program(path, read_machine(IRB6700)).gaps)


def test_a_blank_that_only_python_knows_is_none(tmp_path: Path) -> None:
    path = written(tmp_path, f"CONST robtarget p1:={at(5)};\n", GO.replace(" ", "\u00a0", 1) + GO, "")
    path.write_text(path.read_text(), encoding="latin-1")
    made = run_program(path, read_machine(IRB6700))
    assert len(made.path.tip) == 2 and [gap.first_line for gap in made.gaps] == [7]
    with pytest.raises(ProgramError):
        read_rapid(path)
