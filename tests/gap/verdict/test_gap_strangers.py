"""What strangers bring, through the command line: one clear line, a right answer or "unknown"; never a sure wrong name.

Arms and logs are made by hand (`stranger_arms`, `stranger_logs`), with nothing of camrob.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from gap_cases import KR15
from stranger_arms import KR, ONE, SEVEN, UR, Machine, placed, scattered
from stranger_kinds import GANTRY, SCARA, files, kinds
from stranger_logs import COLUMN, Brought, brought

from camrob.calibration.error_model import ErrorModel
from camrob.cell.read_cell import read_cell
from camrob.cli.app import run

SURE = 0.8
BROUGHT = brought() | kinds() | files()
# of each kind one in the common run; the rest with --slow
FIRST = (
    "ur: NaN", "ur: semicolons, commas", "ur: decimal commas between commas", "ur: metres", "ur: inches, known",
    "ur: milliseconds", "ur: duplicated time", "ur: no cA3", "ur: empty column", "ur: reading stuck",
    "ur: a header in capitals", "ur: one axis in radians", "ur: perfect poses", "ur: drives M", "bench: one axis",
    "file: blank lines", "file: comment first", "file: tabs", "file: trailing comma", "file: column twice", "file: more columns",
    "file: joint names", "file: clock times", "file: header alone", "file: empty", "file: five rows", "file: infinite",
    "file: short row", "file: rows backwards", "scara: drives",
    "lift: in metres", "ur: 10 % gross, 30 poses", "ur: targets told",
)  # fmt: skip
NAMES = [*FIRST, *(n for n in BROUGHT if n not in FIRST)]


def cell_of(machine: Machine, folder: Path) -> Path:
    if not machine.cell:
        return KR15
    assert len(machine.cell.splitlines()) < 40
    (folder / "cell").mkdir()
    (folder / "cell" / "cell.toml").write_text(machine.cell)
    return folder / "cell"


def never(word: str) -> float:
    raise AssertionError(f"{word} in diagnosis.json")


def diagnosed(case: Brought, folder: Path) -> int:
    command = ["diagnose", "--cell", str(cell_of(case.machine, folder)), "--out", str(folder / "out")]
    for name, csv, toml in case.logs:
        (folder / name).write_text(csv)
        (folder / name).with_suffix(".toml").write_text(toml)
        command += ["--log", str(folder / name)]
    return run(command)


@pytest.mark.slow(after=len(FIRST))
@pytest.mark.parametrize("name", NAMES)
def test_what_a_stranger_brings(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = BROUGHT[name]()
    status = diagnosed(case, tmp_path)
    said = capsys.readouterr()
    if case.refused:
        (line,) = said.err.strip().splitlines()
        assert status == 2
        assert re.search(case.refused, line)
        assert re.search(rf"{re.escape(case.logs[0][0])}:\d+: ", line), line
        assert "; " in line  # what is wrong; what to do
        assert not (tmp_path / "out").exists()
        return
    assert status == 0, said.err
    found = json.loads((tmp_path / "out" / "diagnosis.json").read_text(), parse_constant=never)
    claims = {e["effect"]: e for e in found["effects"] if e["probability"] >= 0.5}
    wrong = {
        n for n, e in claims.items() if e["probability"] > SURE and not {n, *e["indistinguishable_from"]} & case.truth
    }
    assert not wrong
    assert all(names & set(claims) for names in case.must), claims.keys()
    assert sum(g["rows"] for g in found["instrument"]["gross"]) == case.gross or not case.gross


@pytest.mark.parametrize(
    "machine", [UR, KR, ONE, SEVEN, COLUMN, SCARA, GANTRY], ids=["ur", "kr", "one", "seven", "lift", "scara", "gantry"]
)
def test_hand_made_arms_stand_where_their_cells_do(machine: Machine, tmp_path: Path) -> None:
    """Or a log would be a stranger's to its own cell. The KR15's cell has its tool to a nanometre."""
    cell, axis = read_cell(cell_of(machine, tmp_path)), scattered(machine, 40, 1)
    order = [machine.names.index(a) for a in cell.axis_names]
    poses = ErrorModel.of(cell, []).poses(np.zeros(0), cell.to_q((axis * machine.unit)[:, order]))
    assert np.abs(poses - placed(machine, axis)).max() < 1e-8
