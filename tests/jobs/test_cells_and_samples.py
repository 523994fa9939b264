"""`camrob cell` and `camrob samples`: what comes with camrob is found, copied whole or not at all, and is in the wheel."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import camrob
from camrob.cell.joint import Role
from camrob.cell.read_cell import read_cell
from camrob.cell.urdf import cell_urdf
from camrob.cli import app as cli
from camrob.errors import CellError, InputError
from camrob.jobs.files.cells_and_samples import cell_from_urdf, list_cells, new_cell, samples
from camrob.kinematics.frames import base_T_flange

ROOT = Path(__file__).resolve().parents[2]
ARM = """<robot name="arm"><link name="foot"/><link name="one"/><link name="two"/><link name="left"/><link name="right"/>
<joint name="a" type="revolute"><parent link="foot"/><child link="one"/><origin xyz="0 0 0.3"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="1" effort="0" velocity="1"/></joint>
<joint name="b" type="revolute"><parent link="one"/><child link="two"/><origin xyz="0.5 0 0"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="0" velocity="1"/></joint>
<joint name="c" type="fixed"><parent link="two"/><child link="left"/><origin xyz="0 0.1 0"/></joint>
<joint name="d" type="fixed"><parent link="two"/><child link="right"/><origin xyz="0 -0.2 0"/></joint></robot>"""


def test_every_cell_of_the_repository_is_listed_and_can_be_read() -> None:
    listed = {cell.name: cell for cell in list_cells().summary.cells}
    assert set(listed) == {folder.name for folder in (ROOT / "cells").iterdir()}
    assert listed["kr15_track_table"].axes == ("A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2")
    assert camrob.shipped_cell("kr15_track_table") == ROOT / "cells" / "kr15_track_table"
    with pytest.raises(InputError, match=r"take one of .*kr15_track_table"):
        camrob.shipped_cell("kr16")


def test_a_copied_cell_is_the_same_machine_under_its_own_name(tmp_path: Path) -> None:
    made = new_cell("ours", source=ROOT / "cells" / "kr15_track_table", out=tmp_path)
    old = read_cell(ROOT / "cells" / "kr15_track_table")
    assert made.cell.name == "ours" == read_cell(tmp_path / "ours").name
    assert (tmp_path / "ours" / "README.md").is_file() and "poses.csv" in made.summary.files
    lines, others = (
        (folder / "cell.toml").read_text(encoding="utf-8").splitlines() for folder in (tmp_path / "ours", old.folder)
    )
    differ = [line for line, other in zip(lines, others, strict=True) if line != other]
    assert differ[:2] == ['name = "ours"', 'title = "ours, made from kr15_track_table"']
    assert all(line.lstrip().startswith("standing = ") for line in differ[2:])
    with pytest.raises(InputError, match="there already"):
        new_cell("ours", source=old.folder, out=tmp_path)


@pytest.mark.parametrize("source", ["kr15_track_table", "irb6700_table", "ta1400_weld"])
def test_a_copy_takes_over_no_number_as_known(tmp_path: Path, source: str) -> None:
    """A data sheet's or a paper's number of another machine is a guess at this one, and README tells no other's story."""
    made = new_cell("ours", source=ROOT / "cells" / source, out=tmp_path)
    assert set(made.cell.provenance.values()) == {"assumed"}
    assert made.cell.provenance.keys() == read_cell(ROOT / "cells" / source).provenance.keys()
    told = (tmp_path / "ours" / "README.md").read_text(encoding="utf-8")
    assert (
        told.startswith(f"# ours: made from {source}\n") and "## cell.toml, key by key" in told and "](../" not in told
    )


@pytest.mark.parametrize("name", ["../ours", "a/b", "", "con", ".x"])
def test_a_name_that_is_no_folder_makes_none(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError):
        new_cell(name, source=ROOT / "cells" / "kr15_track_table", out=tmp_path / "out")
    assert not (tmp_path / "out").exists() and not (tmp_path / "ours").exists()


def test_what_is_no_cell_is_not_copied(tmp_path: Path) -> None:
    with pytest.raises(CellError):
        new_cell("ours", source=ROOT / "toolpaths" / "engraving", out=tmp_path / "out")
    broken = tmp_path / "broken"
    shutil.copytree(ROOT / "cells" / "kr15_track_table", broken)
    (broken / "poses.csv").write_text("name\n")
    with pytest.raises(CellError):
        new_cell("ours", source=broken, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_urdf_becomes_a_cell_that_moves_as_the_urdf_says(tmp_path: Path) -> None:
    (tmp_path / "an arm.urdf").write_text(ARM)
    made = cell_from_urdf(tmp_path / "an arm.urdf", tip="right", out=tmp_path)
    cell = made.cell
    assert cell.name == "an_arm" and made.summary.files == ("cell.toml", "robot.urdf")
    assert [(j.name, j.role, j.lower, j.upper) for j in cell.joints] == [
        ("A1", Role.ARM, -2.0, 1.0),
        ("A2", Role.ARM, -1.0, 1.0),
    ]
    quarter = base_T_flange(cell, np.array([np.pi / 2, 0.0]))  # the first joint turns the arm from x to y
    assert np.allclose(quarter[:3, 3], [0.2, 0.5, 0.3], atol=1e-12)


def test_camrobs_own_urdf_of_a_cell_comes_back_as_that_chain(tmp_path: Path) -> None:
    old = read_cell(ROOT / "cells" / "kr500_afp")
    (tmp_path / "kr500.urdf").write_text(cell_urdf(old))
    cell = cell_from_urdf(tmp_path / "kr500.urdf", out=tmp_path).cell
    q = np.array([0.1, -1.2, 0.7, 0.4, -0.6, 0.3])
    long = np.zeros(len(old))
    long[list(old.indices(Role.ARM))] = q
    flange_T_tool = np.linalg.inv(base_T_flange(old, np.zeros(len(old)))) @ base_T_flange(old, long)
    got = np.linalg.inv(base_T_flange(cell, np.zeros(len(cell)))) @ base_T_flange(cell, q)
    tool = np.asarray(old.flange_T_tool)
    assert np.allclose(tool @ got @ np.linalg.inv(tool), flange_T_tool, atol=1e-9)


@pytest.mark.parametrize(
    ("text", "tip", "message"),
    [
        (ARM, None, "2 ends"),
        (ARM, "middle", "not a link"),
        ("<robot", "right", "not well-formed XML"),
        (ARM.replace('type="revolute"', 'type="floating"'), "right", "floating"),
    ],
)
def test_a_urdf_that_is_no_arm_leaves_nothing_behind(tmp_path: Path, text: str, tip: str | None, message: str) -> None:
    (tmp_path / "arm.urdf").write_text(text)
    with pytest.raises(CellError, match=message):
        cell_from_urdf(tmp_path / "arm.urdf", tip=tip, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_samples_are_listed_and_copied(tmp_path: Path) -> None:
    listed = {one.name: one for one in samples().summary.samples}
    assert set(listed) == {"carving", "engraving", "globe", "relief"}
    assert listed["engraving"].title == "a name plate in single strokes"
    copied = samples(out=tmp_path / "parts").summary
    for one in copied.samples:
        assert (Path(one.folder) / one.clfile).read_bytes() == (ROOT / "toolpaths" / one.name / one.clfile).read_bytes()
        assert (Path(one.folder) / "setup.toml").is_file()
    with pytest.raises(InputError, match="there already"):
        samples(out=tmp_path / "parts")


@pytest.mark.parametrize("verb", [["samples"], ["cell", "list"]])
def test_paths_are_printed_in_one_piece(
    verb: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """However narrow the screen is: who copies a path from it wants all of it."""
    monkeypatch.setenv("COLUMNS", "20")
    assert cli.run(verb) == 0
    lines = capsys.readouterr().out.splitlines()
    assert sum(Path(line.strip()).is_absolute() and Path(line.strip()).exists() for line in lines) >= 4
    assert all(line == line.rstrip() for line in lines)


def test_a_command_takes_a_shipped_cell_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where no folder of that name stands; one that does is meant."""
    monkeypatch.chdir(tmp_path)
    assert cli.run(["cell", "new", "ours", "--from", "ta1400_weld", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["folder"] == "ours"
    assert cli.run(["cell", "new", "theirs", "--from", "ta1500"]) == 2
    assert "ta1500" in capsys.readouterr().err
    (tmp_path / "ta1400_weld").mkdir()
    assert cli.run(["cell", "new", "theirs", "--from", "ta1400_weld"]) == 2
    assert cli.run(["cell", "list"]) == 0 and cli.run(["samples"]) == 0
    shown = capsys.readouterr().out
    assert "kr500_afp" in shown and "engraving.cls" in shown


def test_the_wheel_holds_cells_and_samples(tmp_path: Path) -> None:
    """Built as pip builds it, up to packing; nothing but what is shipped is taken from the repository."""
    for name in ("camrob", "cells", "toolpaths"):
        (tmp_path / name).symlink_to(ROOT / name)
    for name in ("setup.py", "pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, tmp_path)
    built = tmp_path / "built"
    ran = subprocess.run(
        [sys.executable, "setup.py", "-q", "build_py", "--build-lib", str(built)], cwd=tmp_path, capture_output=True
    )
    assert ran.returncode == 0, ran.stderr
    ask = "from camrob.shipped import *; print(*shipped_cells().values(), *shipped_samples().values(), sep='\\n')"
    said = subprocess.run([sys.executable, "-c", ask], cwd=built, capture_output=True, text=True, check=True).stdout
    found = [Path(line) for line in said.splitlines()]
    assert all(folder.is_relative_to(built) for folder in found)
    assert {f.name for f in found} == {f.name for f in (ROOT / "cells").iterdir()} | {
        "carving",
        "engraving",
        "globe",
        "relief",
    }
    for folder in found:
        kept = {f.name for f in folder.iterdir()}
        assert {"README.md"} < kept and not any(f.is_dir() for f in folder.iterdir())
        if (folder / "cell.toml").is_file():
            assert kept == {f.name for f in (ROOT / "cells" / folder.name).iterdir() if f.is_file()}
            read_cell(folder)


def test_masses_that_a_simulator_was_given_are_left_out_and_said(tmp_path: Path) -> None:
    """ROS packages whose makers publish no masses write 2 kg in each link's origin: calibrate took them for the arm's weight."""

    def arm(masses: tuple[float, ...], z: float) -> str:
        text = ARM
        for link, mass in zip(("one", "two", "right"), masses, strict=True):
            body = f'<link name="{link}"><inertial><origin xyz="0 0 {z}"/><mass value="{mass}"/></inertial></link>'
            text = text.replace(f'<link name="{link}"/>', body)
        return text

    for name, masses, z, kept in (
        ("made_up", (2, 2, 2), 0.0, 0),
        ("told", (2, 3, 2), 0.0, 3),
        ("centred", (2, 2, 2), 0.1, 3),
    ):
        (tmp_path / f"{name}.urdf").write_text(arm(masses, z))
        made = cell_from_urdf(tmp_path / f"{name}.urdf", tip="right", out=tmp_path)
        assert len(made.cell.masses) == kept
        assert any("made up, and left out" in line for line in made.summary.next) is (kept == 0)
