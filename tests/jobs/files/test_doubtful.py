"""Numbers that are of another unit by the look of them, or that can't both be true, are said before all else."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
import trimesh

from camrob import post, verify
from camrob.cell.read_cell import read_cell
from camrob.cell.read_setup import read_setup
from camrob.errors import CellError, CollisionError, JobError
from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.doubtful import doubtful_cell, doubtful_setup
from camrob.jobs.files.inputs import read_inputs
from camrob.jobs.release.release import cause_first
from camrob.toolpath.read import read_toolpath

ROOT = Path(__file__).resolve().parents[3]
KR15 = ROOT / "cells" / "kr15_track_table"
SAMPLE = ROOT / "toolpaths" / "engraving" / "engraving.cls"
SLIPS = {  # what is written in cell.toml, what instead of it, what is said
    "range in radians": (r"range_deg = \[-185, 185\]", "range_deg = [-3.23, 3.23]", "range of A1, -3.23 to 3.23"),
    "speed in radians": (r"speed_deg_s = 604", "speed_deg_s = 9.9", "speed of A6, 9.9"),
    "track in metres": (r"range_mm = \[-1500, 1500\]", "range_mm = [-1.5, 1.5]", "range of E1, -1.5 to 1.5"),
    "track's speed": (r"speed_mm_s = 1000", "speed_mm_s = 1", "speed of E1, 1, looks like metres"),
    "payload": (r"payload_kg = 15", "payload_kg = 5", "'spindle and tool' of cell.toml weighs 12 kg"),
    "a short range": (r"range_deg = \[-145, 25\]", "range_deg = [-90, -70]", ""),
    "a short track": (r"range_mm = \[-1500, 1500\]", "range_mm = [-50, 50]", ""),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_in_a_cell_is_named(tmp_path: Path, slip: str) -> None:
    old, new, said = SLIPS[slip]
    shutil.copytree(KR15, tmp_path / "cell")
    file = tmp_path / "cell" / "cell.toml"
    text, count = re.subn(old, new, file.read_text(encoding="utf-8"))
    file.write_text(text, encoding="utf-8")
    cell = read_cell(tmp_path / "cell")
    found = [f.text for f in doubtful_cell(cell, read_setup(None, cell))]
    assert count == 1 and len(found) == bool(said) and (not said or said in found[0])


@pytest.mark.parametrize("cell", sorted(p.name for p in (ROOT / "cells").iterdir() if p.is_dir()))
def test_the_cells_that_come_along_are_not_doubted(cell: str) -> None:
    machine = read_cell(ROOT / "cells" / cell)
    assert doubtful_cell(machine, read_setup(None, machine)) == ()


def test_a_tool_heavier_than_the_payload_is_named(tmp_path: Path) -> None:
    (tmp_path / "setup.toml").write_text("[tool]\nname = 'big'\nmass_kg = 16\ncenter_of_mass_mm = [0, 0, 100]\n")
    cell = read_cell(KR15)
    (found,) = doubtful_cell(cell, read_setup(tmp_path / "setup.toml", cell))
    assert "tool 'big' of setup.toml weighs 16 kg" in found.text


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("clearance_mm = 0.04", "clearance-in-metres"),
        ("clearance_mm = 0", None),
        ("clearance_mm = 2", None),
        ("rapid_feed_mm_min = 12", "slow-rapids"),
        ("rapid_feed_mm_min = 301", None),  # of its cuts the slowest has 300
    ],
)
def test_a_slip_in_a_set_up_is_named(tmp_path: Path, line: str, code: str | None) -> None:
    (tmp_path / "setup.toml").write_text(f"{line}\n", encoding="utf-8")
    found = doubtful_setup(read_setup(tmp_path / "setup.toml", read_cell(KR15)), read_toolpath(SAMPLE))
    assert [f.code for f in found] == ([code] if code else [])


def test_a_refusal_for_a_track_that_hardly_runs_names_the_slip_first_and_its_unit(tmp_path: Path) -> None:
    shutil.copytree(KR15, tmp_path / "cell")
    file = tmp_path / "cell" / "cell.toml"
    text = file.read_text(encoding="utf-8").replace(
        "range_mm = [-1500, 1500], speed_mm_s = 1000", "range_mm = [-50, 50], speed_mm_s = 1"
    )
    file.write_text(text, encoding="utf-8")
    with pytest.raises(JobError) as refused:
        post(SAMPLE, cell=tmp_path / "cell", out=tmp_path / "out", report=False)
    said = str(refused.value)
    assert re.search(
        r"E1 (would have to run at [\d.]+ mm a second|leaps by [\d.]+ mm)", said
    )  # the witness, or the gate
    assert said.removeprefix("camrob: ").startswith(
        "the speed of E1, 1, looks like metres: cell.toml gives mm a second; "
    )


def _without_table(folder: Path) -> Path:
    """The cell before its table is taken out of the rest of cell.toml, too: as somebody leaves it who takes the joint out."""
    shutil.copytree(KR15, folder)
    (folder / "poses.csv").unlink()
    text = (folder / "cell.toml").read_text(encoding="utf-8").replace('weights = { E2 = "w_M", ', "weights = { ")
    blocks = re.split(r"(?m)^(?=\[)", text)
    (folder / "cell.toml").write_text("".join(b for b in blocks if 'name = "E2"' not in b), encoding="utf-8")
    return folder


def test_a_base_that_follows_no_table_is_refused_for_that(tmp_path: Path) -> None:
    cell = _without_table(tmp_path / "cell")
    with pytest.raises(CellError, match=r"base_follows_table is true, and the cell has no table.*set it to false"):
        cell_for("post", cell)
    text = (cell / "cell.toml").read_text(encoding="utf-8")
    (cell / "cell.toml").write_text(re.sub(r"(?m)^(base_template|act_ex_ax).*\n", "", text), encoding="utf-8")
    with pytest.raises(CellError, match=r"the cell has no table"):  # nor without what writes such a base
        cell_for("post", cell)


def test_limits_of_a_program_that_could_not_be_replayed_are_not_good(tmp_path: Path) -> None:
    """It moves E2, which the cell lacks."""
    made = post(SAMPLE, cell=KR15, out=tmp_path / "out", report=False)
    cell = _without_table(tmp_path / "cell")
    text = (cell / "cell.toml").read_text(encoding="utf-8")
    still = re.sub(
        r"(?m)^(base_template|act_ex_ax).*\n",
        "",
        text.replace("base_follows_table = true", "base_follows_table = false"),
    )
    still = still.replace(
        "base_to_first = [0, 0, 0, 0, 0, 0]", "base_to_first = [-803, 0, -305, 180, 0, 90]"
    )  # E2 at HOME
    (cell / "cell.toml").write_text(still, encoding="utf-8")
    judged = verify(tmp_path / "out" / made.summary.files[0], cell=cell, manifest=False).summary
    assert judged.judged.limits is None and any("E2" in text for text in judged.not_judged)


SCALES = {  # what is written in the set-up, and the finding that says it; the plate is 160 by 120 by 10 mm or so
    "tool in metres": ("[tool]\nflange_to_tool = [0.3, 0, 0.15, 0, -90, 0]\n", "tool-frame-in-metres"),
    "tool turned round": ("[tool]\nflange_to_tool = [300, 0, 150, 0, 90, 0]\n", "tool-reversed"),
    "tool as it is": ("[tool]\nflange_to_tool = [300, 0, 150, 0, -90, 0]\n", None),
    "tool at the plate": ("[tool]\nflange_to_tool = [0, 0, 0, 0, 0, 180]\n", None),
    "an angle head": ("[tool]\nflange_to_tool = [100, 0, 300, 0, -90, 0]\n", None),
    "beside the table": ("part_in_base = [0, 1500, 200, 0, 0, 0]\n", "part-off-table"),
    "on the table": ("part_in_base = [100, 0, 200, 0, 0, 0]\n", None),
    "stock times 25.4": ("[stock]\nmesh = 'stock.stl'\nunit = 'inch'\n", "stock-too-large"),
    "stock by 25.4": ("[stock]\nmesh = 'small.stl'\n", "stock-apart"),
    "part by 25.4": ("[part]\nmesh = 'small.stl'\n", "part-apart"),
    "stock as it is": ("[stock]\nmesh = 'stock.stl'\n", None),
    "part as it is": ("[part]\nmesh = 'stock.stl'\n", None),
}


@pytest.mark.parametrize("slip", SCALES)
def test_a_scale_or_a_direction_that_is_wrong_is_named_before_anything_is_solved(tmp_path: Path, slip: str) -> None:
    """Refusals named symptoms: a spindle at the arm's shoulder for a part off the table, the foot in a stock that was scaled."""
    text, code = SCALES[slip]
    where = "" if text.startswith("part_in_base") else "part_in_base = [0, 0, 200, 0, 0, 0]\n"
    (tmp_path / "setup.toml").write_text(where + text, encoding="utf-8")
    shutil.copy(SAMPLE.parent / "stock.stl", tmp_path)
    mesh = trimesh.load(SAMPLE.parent / "stock.stl", force="mesh")
    mesh.apply_scale(1 / 25.4)
    mesh.export(tmp_path / "small.stl")
    inputs = read_inputs(SAMPLE, cell_for("post", KR15), tmp_path / "setup.toml")
    scales = {c for _, c in SCALES.values() if c}
    assert [f.code for f in inputs.urgent if f.code in scales] == ([code] if code else [])
    said = cause_first(CollisionError("at HOME robot foot touches stock; change home_deg"), inputs)
    assert said.what.endswith("at HOME robot foot touches stock; change home_deg")
    assert said.what.startswith("at HOME") is (code is None)


def test_millimetres_that_are_read_as_inches_are_said_first(tmp_path: Path) -> None:
    (tmp_path / "setup.toml").write_text("part_in_base = [0, 0, 200, 0, 0, 0]\n", encoding="utf-8")
    wide = tmp_path / "wide.cls"
    wide.write_text("UNITS/INCH\nFEDRAT/IPM,9\nRAPID\nGOTO/0,0,9,0,0,1\nGOTO/0,0,0,0,0,1\nGOTO/160,0,0,0,0,1\nFINI\n")
    inputs = read_inputs(wide, cell_for("post", KR15), tmp_path / "setup.toml")
    assert cause_first(JobError("no posture"), inputs).what.startswith("read as inches the path is 4064 mm wide")
