"""The list of what goes where on the controller: held to sha256sum itself, and judged by the witness."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pytest

import camrob
from camrob.errors import CellError
from camrob.jobs.files.cell_for import cell_for

FOLDER = Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table"
PATH = "".join(f"GOTO/{x},0,0,0,0,1\nGOTO/{x},0,40,0,0,1\n" for x in range(0, 60, 10))


def cell_with(folder: Path, line: str) -> Path:
    shutil.copytree(FOLDER, folder)
    text = (folder / "cell.toml").read_text(encoding="utf-8")
    (folder / "cell.toml").write_text(text.replace("act_ex_ax = 2", f"act_ex_ax = 2\n{line}"), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> camrob.PostResult:
    folder = tmp_path_factory.mktemp("upload")
    (folder / "part.apt").write_text(f"PARTNO/A\nUNITS/MM\nSPINDL/6000,RPM,CLW\nFEDRAT/500,MMPM\n{PATH}FINI\n")
    (folder / "setup.toml").write_text("part_in_base = [0, 0, 200, 0, 0, 0]\n[tool]\ndiameter_mm = 6\nlength_mm = 80\n")
    cell = cell_with(folder / "cell", 'upload_folder = "R1/Program"')
    return camrob.post(folder / "part.apt", cell=cell, out=folder / "out", max_lines=4, report=False)


def rows(made: camrob.PostResult) -> list[str]:
    return (made.out / "part.sha256").read_text().splitlines()


def test_sha256sum_finds_all_files_in_their_places(made: camrob.PostResult, tmp_path: Path) -> None:
    places = [row.split("  ")[1] for row in rows(made)]
    assert len(places) > 3, "several files"
    assert places[-2:] == ["R1/Program/part/part.dat", "R1/Program/part/part.src"], "what is called is there before it"
    assert {Path(place).name for place in places} == {
        p.name for p in made.out.iterdir() if p.suffix in (".src", ".dat")
    }
    for place in places:
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(made.out / Path(place).name, tmp_path / place)
    checked = subprocess.run(
        ["sha256sum", "--check", "--strict", made.out / "part.sha256"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert checked.returncode == 0 and checked.stdout.count(": OK") == len(places), checked.stderr
    assert "part.sha256" in json.loads((made.out / "part.json").read_text())["files"]


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (lambda kept: kept[1:], "upload-differs"),
        (lambda kept: [kept[-1], *kept[:-1]], "upload-order"),
        (lambda kept: [kept[0].replace("Program", "System"), *kept[1:]], "upload-places"),
        (lambda kept: [kept[0], *kept], "upload-places"),
        (lambda kept: ["0" * 64 + kept[0][64:], *kept[1:]], "upload-differs"),
        (lambda kept: [kept[0].replace("001.src", "009.src"), *kept], "upload-differs"),
        (lambda kept: ["all of it", *kept], "upload-broken"),
        (lambda kept: [], "upload-broken"),
    ],
)
def test_verify_refuses_another_list(made: camrob.PostResult, tmp_path: Path, change, code: str) -> None:
    shutil.copytree(made.out, tmp_path / "out")
    listed = tmp_path / "out" / "part.sha256"
    kept = rows(made)
    cell = made.out.parent / "cell"
    assert not [
        e for e in camrob.verify(tmp_path / "out" / "part.src", cell=cell).findings if e.code.startswith("upload")
    ]
    listed.write_text("".join(f"{row}\n" for row in change(kept)))
    found = camrob.verify(tmp_path / "out" / "part.src", cell=cell)
    assert code in {f.code for f in found.findings} and not found.ok


def test_no_list_where_the_cell_asks_for_none(made: camrob.PostResult, tmp_path: Path) -> None:
    """And the one of the run before goes."""
    shutil.copytree(made.out, tmp_path / "out")
    part = made.out.parent / "part.apt"
    camrob.post(part, cell=FOLDER, setup=part.with_name("setup.toml"), out=tmp_path / "out", max_lines=4, report=False)
    assert not (tmp_path / "out" / "part.sha256").exists() and (tmp_path / "out" / "part.src").exists()


@pytest.mark.parametrize("value", ['"R1\\\\Program"', '"/R1"', '"R1/../x"', '"R1/a b"', "3"])
def test_folders_that_are_none(tmp_path: Path, value: str) -> None:
    with pytest.raises(CellError, match="upload_folder is"):
        cell_for("post", cell_with(tmp_path / "cell", f"upload_folder = {value}"))
