"""Outputs tied to the tool's speed: what a cell may say, and that a program with them is the one meant."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest

import camrob
from camrob.errors import CellError
from camrob.languages.krl.krl_analog import check_analog

FOLDER = Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table"
ON = "ANOUT ON FEED = 0.5 * $VEL_ACT + 0.1 DELAY=-0.1 MINIMUM=0.0 MAXIMUM=1.0"
OFF = "ANOUT OFF FEED"
PART = """PARTNO/A
UNITS/MM
SPINDL/6000,RPM,CLW
FEDRAT/500,MMPM
RAPID
GOTO/0,0,40,0,0,1
GOTO/0,0,0
GOTO/30,0,0
RAPID
GOTO/30,0,40
SPINDL/OFF
FINI
"""


@pytest.mark.parametrize(
    ("hooks", "said"),
    [
        ({"spindle_on": (ON,)}, "nothing lets it go"),
        ({"spindle_on": (ON,), "coolant_off": (OFF,)}, "nothing lets it go"),
        ({"spindle_on": (ON.replace("$VEL_ACT", "$POS_ACT.X"),), "footer": (OFF,)}, "in no form"),
        ({"spindle_on": (ON.replace("0.5 *", ""),), "footer": (OFF,)}, "in no form"),
        ({"spindle_on": (ON.replace("0.5", "0.0"),), "footer": (OFF,)}, "in no form"),
        ({"spindle_on": (ON.replace("FEED", "$ANOUT[1]"),), "footer": (OFF,)}, "in no form"),
        ({"spindle_on": (ON.replace("-0.1", "-0.7"),), "footer": (OFF,)}, "in no form"),
        ({"spindle_on": (ON.replace("MINIMUM=0.0", "MINIMUM=1.0"),), "footer": (OFF,)}, "in no form"),
        ({"spindle_on": (ON.replace("MAXIMUM=1.0", "MAXIMUM=10"),), "footer": (OFF,)}, "in no form"),
        ({"spindle_on": (f"{ON} THEN",), "footer": (OFF,)}, "in no form"),
        (
            {
                "header": tuple(ON.replace("FEED", f"F{k}") for k in range(5)),
                "footer": tuple(f"ANOUT OFF F{k}" for k in range(5)),
            },
            "5 outputs are tied at once",
        ),
    ],
)
def test_what_no_controller_takes_is_refused(hooks: dict[str, tuple[str, ...]], said: str) -> None:
    with pytest.raises(CellError, match=said):
        check_analog(hooks)


@pytest.mark.parametrize(
    "line", [ON, "anout on feed=.5*$vel_act", "ANOUT ON FEED = 2 * $VEL_ACT - 0.3 ; {speed}", f"{ON} ; glue"]
)
def test_what_a_controller_takes(line: str) -> None:
    check_analog({"spindle_on": (line,), "spindle_off": ("WAIT SEC 1", OFF)})


def test_a_program_with_it_is_verified_and_faults_in_it_are_found(tmp_path: Path) -> None:
    cell = tmp_path / "cell"
    shutil.copytree(FOLDER, cell)
    text = (cell / "cell.toml").read_text(encoding="utf-8")
    for hook, lines in (
        ("spindle_on", [f"{ON} ; {{speed}}", "$OUT[1] = TRUE"]),
        ("spindle_off", ["$OUT[1] = FALSE", OFF]),
    ):
        text = re.sub(rf"(?m)^{hook} = .*$", lambda _, h=hook, w=lines: f"{h} = {json.dumps(w)}", text)
    (cell / "cell.toml").write_text(text, encoding="utf-8")
    (tmp_path / "part.apt").write_text(PART, encoding="utf-8")
    (tmp_path / "setup.toml").write_text(
        "part_in_base = [0, 0, 200, 0, 0, 0]\n[tool]\ndiameter_mm = 6\nlength_mm = 80\n", encoding="utf-8"
    )
    camrob.post(tmp_path / "part.apt", cell=cell, out=tmp_path / "out", report=False)
    source = tmp_path / "out" / "part.src"
    made = source.read_text(encoding="ascii")
    assert made.count(ON) == 1 and made.count(OFF) == 1

    def judged(text: str) -> camrob.VerifyResult:
        source.write_text(text, encoding="ascii")
        return camrob.verify(source, cell=cell, against=tmp_path / "part.apt", manifest=False)

    assert judged(made).ok is True
    for old, new in (
        ("0.5 * $VEL_ACT", "0.6 * $VEL_ACT"),
        ("DELAY=-0.1", "DELAY=0.1"),
        ("MAXIMUM=1.0", "MAXIMUM=0.5"),
        (f"{OFF}\n", ""),
        (ON, f"{ON.replace('FEED', 'OTHER')}"),
    ):
        assert old in made and judged(made.replace(old, new)).ok is not True, new
