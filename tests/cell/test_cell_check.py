"""`camrob cell check`: each row of poses.csv against forward kinematics, by displacements planted in file and chain."""

from __future__ import annotations

import csv
import json
import re
import shutil
from pathlib import Path

import pytest

from camrob.cli.app import run

CELLS = Path(__file__).resolve().parents[2] / "cells"
HOME = "97.000,-41.764,619.422"  # of the KR15's first row


def _copied(tmp_path: Path, file: str = "cell.toml", old: str = "", new: str = "") -> Path:
    folder = tmp_path / "cell"
    shutil.copytree(CELLS / "kr15_track_table", folder)
    text = (folder / file).read_text(encoding="utf-8")
    assert not old or old in text
    (folder / file).write_text(text.replace(old, new, 1), encoding="utf-8")
    return folder


def _checked(cell: Path, capsys: pytest.CaptureFixture[str], status: int) -> dict:
    assert run(["cell", "check", str(cell), "--json"]) == status
    return json.loads(capsys.readouterr().out)


def test_a_shipped_cell_meets_each_of_its_poses_and_its_provenance_is_counted(capsys) -> None:
    folder = CELLS / "kr15_track_table"
    found = _checked(folder, capsys, 0)
    with (folder / "poses.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [pose["name"] for pose in found["poses"]] == [row["name"] for row in rows]
    assert found["ok"] is True and all(pose["ok"] and not pose["text"] for pose in found["poses"])
    assert found["position_error_mm_max"] < 0.001  # the rows are printed to a thousandth, and worked out by hand
    assert list(found["provenance"]) == ["datasheet", "paper", "measured", "assumed"]
    assert found["provenance"]["assumed"] == len(found["assumed"]) > 0 and found["provenance"]["paper"] > 0
    assert run(["cell", "check", "kr15_track_table"]) == 0
    shown = capsys.readouterr().out
    assert "allowed are 0.5 mm and 0.05 degrees" in shown  # as the contract has it
    assert f"all {len(rows)} poses met" in shown and "straight_up" in shown and " assumed" in shown


@pytest.mark.parametrize(("by", "status"), [(0.3, 0), (3.0, 1)])
def test_a_displaced_row_is_off_by_its_displacement_and_no_other_is(by: float, status: int, tmp_path, capsys) -> None:
    cell = _copied(tmp_path, "poses.csv", HOME, f"{97.0 + by:.3f},-41.764,619.422")
    first, *others = _checked(cell, capsys, status)["poses"]
    assert first["position_error_mm"] == pytest.approx(by, abs=2e-3) and first["ok"] is (status == 0)
    assert first["orientation_error_deg"] < 0.01 and all(pose["ok"] for pose in others)
    assert (f"{by:.3f} mm" in first["text"]) is (status == 1)


def test_a_longer_forearm_shows_in_the_rows_that_it_moves_with_their_own_errors(tmp_path, capsys) -> None:
    text = (CELLS / "kr15_track_table" / "cell.toml").read_text(encoding="utf-8")
    old = re.search(r"d_mm = -?600(?:\.0)?\b", text)
    assert old, "the KR15's forearm is 600 mm long"
    cell = _copied(tmp_path, old=old[0], new=old[0].replace("600", "604"))
    found = _checked(cell, capsys, 1)
    assert found["ok"] is False and found["position_error_mm_max"] == pytest.approx(4.0, abs=2e-3)
    assert all(pose["position_error_mm"] == pytest.approx(4.0, abs=2e-3) for pose in found["poses"])


def test_an_axis_turned_round_is_said_of_each_row_that_shows_it(tmp_path, capsys) -> None:
    cell = _copied(tmp_path, old="sign = 1, offset_deg = 90 }", new="sign = -1, offset_deg = 90 }")
    found = {pose["name"]: pose for pose in _checked(cell, capsys, 1)["poses"]}
    assert "A3 is 180.000 degrees off its q" in found["straight_up"]["text"] and not found["straight_up"]["ok"]
    assert found["straight_up"]["position_error_mm"] > 100.0


def test_a_cell_without_poses_is_held_by_nothing_and_a_broken_one_is_an_input_error(tmp_path, capsys) -> None:
    found = _checked(CELLS / "ta1400_weld", capsys, 1)
    assert found["ok"] is None and found["poses"] == [] and found["position_error_mm_max"] is None
    broken = _copied(tmp_path, "poses.csv", HOME, "x,-41.764,619.422")
    assert run(["cell", "check", str(broken)]) == 2
    assert "poses.csv:2: pose 'home' has 'x' as x_mm" in capsys.readouterr().err
    assert run(["cell", "check", str(tmp_path / "none")]) == 2


def test_a_length_of_another_arm_is_said_beside_the_one_that_suits(tmp_path, capsys) -> None:
    """Scaling an arm scales its length: the KR15 at about twice its size (its plate stays) has about twice its 350.6 mm."""
    cell = _copied(tmp_path)
    assert _checked(cell, capsys, 0)["length"] == ""
    text = (cell / "cell.toml").read_text(encoding="utf-8")

    def doubled(row: re.Match[str]) -> str:
        return re.sub(r"(a_mm|d_mm) = (-?[\d.]+)", lambda m: f"{m[1]} = {2.0 * float(m[2])}", row[0])

    text = re.sub(r"(?m)^dh = .*$", doubled, text)
    (cell / "cell.toml").write_text(text, encoding="utf-8")
    (cell / "poses.csv").unlink()
    said = _checked(cell, capsys, 1)["length"]
    assert said.startswith("characteristic_length_mm = 350.6 of cell.toml is another arm's")
    suits = re.search(r": ([\d.]+) suits this one", said)
    assert suits and 600.0 < float(suits[1]) < 750.0
    run(["cell", "check", str(cell)])
    assert said[:60] in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize("sign", [1, -1])
def test_an_a3_that_the_controller_counts_with_a2_is_said_and_no_program_is_written_for_it(
    sign: int, tmp_path, capsys
) -> None:
    """Rows as the pendant of a parallel-link arm shows them: its A3 is the forearm's against the floor or against HOME's."""
    cell = _copied(tmp_path)
    with (cell / "poses.csv").open(encoding="utf-8", newline="") as file:
        rows = [{k: v for k, v in row.items() if not k.startswith("q_")} for row in csv.DictReader(file)]
    for row in rows:
        row["A3_deg"] = str(float(row["A3_deg"]) + sign * float(row["A2_deg"]))
        row["S"] = row["T"] = ""
    with (cell / "poses.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    said = _checked(cell, capsys, 1)["coupled"]
    assert said.startswith(f"all poses are met with A3 {'-' if sign > 0 else '+'} A2 in A3's place")
    part = CELLS.parent / "toolpaths" / "engraving" / "engraving.cls"
    assert run(["post", str(part), "--cell", str(cell), "--out", str(tmp_path / "out")]) == 2
    assert "the controller counts A3 with A2" in capsys.readouterr().err


def test_poses_that_no_coupling_explains_are_told_of_none(tmp_path, capsys) -> None:
    assert _checked(_copied(tmp_path, "poses.csv", HOME, "100.0,-41.764,619.422"), capsys, 1)["coupled"] == ""


@pytest.mark.parametrize(
    ("file", "old", "new", "said"),
    [
        ("cell.toml", 'ori_type = "#VAR"', 'ori_type = "#VARY"', "cell.toml:330: controller: ori_type"),
        ("weights_jnt.fis", "MF1=", "MF1=x", "weights_jnt.fis"),
        ("cell.toml", 'file = "weights_cond.fis"', 'file = "none.fis"', "none.fis"),
    ],
)
def test_what_post_would_refuse_of_a_cell_the_check_refuses(
    file: str, old: str, new: str, said: str, tmp_path, capsys
) -> None:
    assert run(["cell", "check", str(_copied(tmp_path, file, old, new))]) == 2
    assert said in capsys.readouterr().err
