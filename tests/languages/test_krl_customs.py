"""The customs of shops: what a program looks like under each, that it is verified whole, and faults planted in its text."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from krl_syntax import faults

import camrob
from camrob.errors import CellError, VerificationError
from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.release.opinion import hold_to_witness
from camrob.witness.judge import judge

FOLDER = Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table"
PART = """PARTNO/A
UNITS/MM
SPINDL/6000,RPM,CLW
FEDRAT/500,MMPM
RAPID
GOTO/0,0,40,0,0,1
GOTO/0,0,0
CIRCLE/10,0,0,0,0,1,10
GOTO/20,0,0
GOTO/30,10,0
GOTO/40,0,0
GOTO/50,10,0
RAPID
GOTO/50,10,40
FINI
"""
SLIN = 'generation = "KRC4"\nmotions = "SLIN"'
CVEL = 'blending = "C_VEL"\napo_cvel_percent = 80'
CORI = 'blending = "C_ORI"\napo_cori_deg = 2'
BAS = "tool_number = 3\nbase_number = 2"
ACT = 'numbering = "act"\ntool_number = 3\nbase_number = 2'
TABLES = 'numbering = "tables"\ntool_number = 3\nbase_number = 2'
ON_PATH = "on_path = true\nstop_message = true"
HOME = 'home_point = { name = "XHOME", axes = [0, -90, 90, 0, 90, 0, 0, 0] }'
ALL = "\n".join((SLIN.replace("KRC4", "KRC5"), TABLES, ON_PATH, "folds = false", HOME))

Made = Callable[[str], Path]


def cell_with(folder: Path, lines: str) -> Path:
    shutil.copytree(FOLDER, folder)
    text = (folder / "cell.toml").read_text(encoding="utf-8")
    (folder / "cell.toml").write_text(text.replace("act_ex_ax = 2", f"act_ex_ax = 2\n{lines}"), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """The folder of a posted program under a custom, its cell beside it; each is posted once."""
    known: dict[str, Path] = {}

    def post(lines: str) -> Path:
        if lines not in known:
            folder = tmp_path_factory.mktemp("custom")
            (folder / "part.apt").write_text(PART, encoding="utf-8")
            (folder / "setup.toml").write_text(
                "part_in_base = [0, 0, 200, 0, 0, 0]\n[tool]\ndiameter_mm = 6\nlength_mm = 80\n", encoding="utf-8"
            )
            cell = cell_with(folder / "cell", lines)
            camrob.post(folder / "part.apt", cell=cell, out=folder / "out", report=False)
            known[lines] = folder
        return known[lines]

    return post


def code(folder: Path) -> list[str]:
    text = (folder / "out" / "part.src").read_text(encoding="ascii")
    return [line for line in text.splitlines() if line and not line.startswith((";", "&"))]


def judged(folder: Path, text: str, out: Path, *, cell: Path | None = None, config: str = "") -> camrob.VerifyResult:
    shutil.copytree(folder / "out", out)
    (out / "part.src").write_text(text, encoding="ascii", newline="\r\n")
    if config:
        (out / "$config.dat").write_text(config, encoding="ascii")
    return camrob.verify(out / "part.src", cell=cell or folder / "cell", against=folder / "part.apt", manifest=False)


@pytest.mark.parametrize("lines", [SLIN, CVEL, CORI, BAS, ACT, TABLES, ON_PATH, "folds = false", HOME, ALL])
def test_a_program_of_the_shop_is_verified_whole(made: Made, lines: str) -> None:
    folder = made(lines)
    result = camrob.verify(folder / "out" / "part.src", cell=folder / "cell", against=folder / "part.apt")
    assert result.ok is True and not result.summary.not_judged
    assert faults((folder / "out" / "part.src").read_bytes().decode("ascii")) == []
    assert camrob.simulate(folder / "out" / "part.src", cell=folder / "cell", out=folder / "log.csv").summary.rows > 100


def test_splines(made: Made) -> None:
    cut = [line for line in code(made(SLIN)) if line.startswith(("SLIN", "SCIRC", "LIN", "CIRC"))]
    plain = [line for line in code(made("")) if line.startswith(("LIN", "CIRC"))]
    assert cut == ["S" + line.replace("C_DIS", "C_SPL") for line in plain] and any("C_SPL" in line for line in cut)


@pytest.mark.parametrize(
    ("lines", "word", "size"), [(CVEL, "C_VEL", "$APO.CVEL = 80.000"), (CORI, "C_ORI", "$APO.CORI = 2.000")]
)
def test_other_ways_to_round_off(made: Made, lines: str, word: str, size: str) -> None:
    text, plain = code(made(lines)), code(made(""))
    assert size in text
    assert [line for line in text if line != size] == [line.replace("C_DIS", word) for line in plain]


def test_rows_of_the_controllers_tables(made: Made) -> None:
    text, plain = code(made(TABLES)), code(made(""))
    base, tool = (next(line for line in plain if line.startswith(f"${name} =")) for name in ("BASE", "TOOL"))
    frame = base[base.index("{") : base.index("}") + 1]
    assert text[text.index("$ACT_TOOL = 3") + 1] == "$ACT_BASE = 2"
    at = text.index(f"BASE_DATA[2] = {frame}")
    assert text[at + 1] == base.replace(frame, "BASE_DATA[2]")
    assert text[at + 2 : at + 4] == [tool.replace("$TOOL", "TOOL_DATA[3]"), "$TOOL = TOOL_DATA[3]"]
    assert {"BAS (#TOOL,3 )", "BAS (#BASE,2 )", base, tool} <= set(code(made(BAS)))
    assert {"$ACT_TOOL = 3", "$ACT_BASE = 2", base, tool} <= set(code(made(ACT)))


def test_folds_path_and_home(made: Made) -> None:
    assert "FOLD" not in (made("folds = false") / "out" / "part.src").read_text()
    assert code(made("folds = false")) == code(made(""))
    opening = code(made(ON_PATH))
    at = opening.index("CONTINUE")
    assert opening[at + 1] == "IF NOT $ON_PATH THEN" and opening[at + 4 : at + 6] == ["BAS (#INITMOV,0 )", "ENDIF"]
    plain = [line for line in code(made("")) if line.startswith("PTP {E6AXIS")]
    named = [line for line in code(made(HOME)) if line == "PTP XHOME"]
    assert len(plain) == len(named) == 2


REFUSED = [
    ('motions = "SLIN"', "which not every controller knows"),
    ('generation = "KRC2"\nmotions = "SLIN"', "which a KRC2 doesn't know"),
    (f"{SLIN}\n{CVEL}", "which SLIN passes over"),
    ('blending = "C_PTP"', "blending is 'C_PTP'"),
    ('blending = "C_VEL"', "without its size; add apo_cvel_percent"),
    (CVEL.replace("80", "120"), "apo_cvel_percent is 120"),
    ("apo_cori_deg = 2", "targets are not rounded off by it"),
    ('numbering = "tables"\ntool_number = 3', "without rows of the tables"),
    ('numbering = "act"\ntool_number = 0\nbase_number = 2', "without rows of the tables"),
    ('generation = "KRC3"', "generation is 'KRC3'"),
    ("on_path = 1", "on_path is 1"),
    (HOME.replace("0, 0] }", "0, 1] }"), "is not the cell's HOME"),
    (HOME.replace("0, 0] }", "0] }"), "is not the cell's HOME"),
    (HOME.replace("XHOME", "X HOME"), "home_point is"),
    ('home_point = "XHOME"', "home_point is 'XHOME'"),
]


@pytest.mark.parametrize(("lines", "said"), REFUSED)
def test_what_the_controller_does_not_take_is_refused(tmp_path: Path, lines: str, said: str) -> None:
    with pytest.raises(CellError, match=said.replace("(", r"\(")):
        cell_for("post", cell_with(tmp_path / "cell", lines))


LAST = "SLIN {E6POS: X 70"  # a cut, exact
PLANTED: list[tuple[str, str, str, str, bool | None]] = [
    # custom, text to replace (once), its replacement, code of what is found (or of what isn't judged), ok
    (SLIN, "} C_SPL", "} WITH $VEL.CP = 0.5 C_SPL", "feed-higher", False),
    (SLIN, "} C_SPL", "} C_VEL", "isn't stated by the cell", None),
    (SLIN, "$APO.CDIS = 0.500", "$APO.CDIS = 5.000", "setting-higher", False),
    (CVEL, "$APO.CVEL = 80.000", "$APO.CVEL = 100.000", "setting-higher", False),
    (CVEL, "} C_VEL", "} C_ORI", "isn't stated by the cell", None),
    (CVEL, "$APO.CVEL = 80.000", "$APO.CORI = 80.000", "isn't judged", None),
    (CORI, "$APO.CORI = 2.000", "$APO.CORI = 20.000", "setting-higher", False),
    (TABLES, "Z 415.57793", "Z 405.57793", "tool-frame", False),
    (TABLES, "$TOOL = TOOL_DATA[3]", "$TOOL = TOOL_DATA[4]", "$TOOL", False),
    (TABLES, "$TOOL = TOOL_DATA[3]", "TOOL_DATA[3].Z = 400\r\n$TOOL = TOOL_DATA[3]", "tool-frame", False),
    (TABLES, "MECH_TYPE, BASE_DATA[2])", "MECH_TYPE, BASE_DATA[3])", "$BASE", False),
    (TABLES, "BASE_DATA[2] = {X 0.00000", "BASE_DATA[2] = {X 9.00000", "", False),
    (
        TABLES,
        "= EK(MACHINE_DEF[2].ROOT, MACHINE_DEF[2].MECH_TYPE, BASE_DATA[2])",
        "= BASE_DATA[2]",
        "base-stands-still",
        False,
    ),
    (BAS, "$TOOL = {", "; $TOOL = {", "TOOL_DATA[3]", False),
    (BAS, "BAS (#TOOL,3 )\r\n", "", "", True),
    (
        BAS,
        "$ADVANCE = 5\r\n",
        "$ADVANCE = 5\r\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 90,A6 0,E1 0,E2 0}\r\n",
        "TOOL_DATA[3]",
        False,
    ),
    (ON_PATH, "IF NOT $ON_PATH THEN", "IF NOT $ON_PATH THEN\r\n$OUT[1] = TRUE", "which way it goes isn't known", None),
    (ON_PATH, "IF NOT $ON_PATH THEN", "IF $ON_PATH THEN", "which way it goes isn't known", None),
    (ON_PATH, "ENDIF\r\n", "ELSE\r\nBAS (#INITMOV,0 )\r\nENDIF\r\n", "which way it goes isn't known", None),
    (ON_PATH, "INTERRUPT ON 3\r\n", "INTERRUPT ON 4\r\n", "which way it goes isn't known", None),
    (HOME, "PTP XHOME\r\n;FOLD", "XHOME.A1 = 30\r\nPTP XHOME\r\n;FOLD", "", False),
    (HOME, "PTP XHOME\r\n;ENDFOLD", "PTP XHOME1\r\n;ENDFOLD", "", None),
]


@pytest.mark.parametrize(("lines", "old", "new", "said", "ok"), PLANTED, ids=range(len(PLANTED)))
def test_a_fault_in_the_text_is_found(
    made: Made, tmp_path: Path, lines: str, old: str, new: str, said: str, ok: bool | None
) -> None:
    folder = made(lines)
    text = (folder / "out" / "part.src").read_bytes().decode("ascii")
    assert old in text
    result = judged(folder, text.replace(old, new, 1).replace("\r\n", "\n"), tmp_path / "out")
    assert result.ok is ok, (result.summary.errors, result.summary.not_judged)
    assert said in " ".join([*(f"{e.code} {e.text}" for e in result.summary.errors), *result.summary.not_judged])


def test_another_home_on_the_controller_is_found(made: Made, tmp_path: Path) -> None:
    folder = made(HOME)
    text = (folder / "out" / "part.src").read_text(encoding="ascii")
    config = "DEFDAT $CONFIG PUBLIC\nDECL E6AXIS XHOME = {A1 %s,A2 -90,A3 90,A4 0,A5 90,A6 0,E1 0,E2 0}\nENDDAT\n"
    assert judged(folder, text, tmp_path / "same", config=config % 0).ok is True
    assert judged(folder, text, tmp_path / "other", config=config % 20).ok is False
    plain = made("") / "cell"
    assert judged(folder, text, tmp_path / "unknown", cell=plain).ok is not True


@pytest.mark.parametrize(
    ("lines", "row", "count"),
    [
        (ACT, "TOOL_DATA[3]", 1),
        (BAS, "BASE_DATA[2]", 1),
        (TABLES, "TOOL_DATA[4]", 1),
        (TABLES, "LOAD_DATA[3]", 1),
        (TABLES, "TOOL_DATA[3]", 0),
    ],
)
def test_a_row_of_the_tables_that_nobody_asked_for(
    made: Made, tmp_path: Path, lines: str, row: str, count: int
) -> None:
    """It moves nothing in this program, and may move the next: a warning in other people's, no excuse in one of camrob's."""
    folder = made(lines)
    text = (folder / "out" / "part.src").read_text(encoding="ascii")
    value = "TOOL_DATA[3]" if count == 0 else "{X 0.0,Y 0.0,Z 100.0,A 0.0,B 0.0,C 0.0}"
    text = text.replace("$TOOL = ", f"{row} = {value}\n$TOOL = ", 1)
    judged(folder, text, tmp_path / "out")
    verdict = judge(tmp_path / "out" / "part.src", folder / "cell", clfile=folder / "part.apt")
    assert [o.text.split()[0] for o in verdict.warnings if o.code == "table-row"] == [row] * count
    if count:
        with pytest.raises(VerificationError, match="written over"):
            hold_to_witness(verdict, tmp_path / "out")


def test_splines_on_a_controller_without_them(made: Made, tmp_path: Path) -> None:
    folder = made(SLIN)
    old = cell_with(tmp_path / "cell", 'generation = "KRC2"')
    text = (folder / "out" / "part.src").read_text(encoding="ascii")
    result = judged(folder, text, tmp_path / "out", cell=old)
    assert result.ok is False and "not-on-controller" in [e.code for e in result.summary.errors]


def test_a_way_on_the_path_counts_where_the_cell_says_so(made: Made, tmp_path: Path) -> None:
    folder = made(ON_PATH)
    text = (folder / "out" / "part.src").read_text(encoding="ascii")
    result = judged(folder, text, tmp_path / "out", cell=made("") / "cell")
    assert result.ok is None and any("which way it goes" in line for line in result.summary.not_judged)
