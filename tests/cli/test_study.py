"""`camrob study`: each paper's case runs on its own cell, and the words it went by before still do, with a hint."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from camrob.cli.app import run
from camrob.cli.study import STUDIES


def test_every_study_has_a_cell_that_comes_with_camrob_and_stands_in_the_help(capsys) -> None:
    from camrob.shipped import shipped_cells

    assert run(["study", "--help"]) == 0
    shown = capsys.readouterr().out
    for name, study in STUDIES.items():
        assert study.cell in shipped_cells()
        assert any(line.split()[:1] == [name] and study.cell in line for line in shown.splitlines())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "before"), [("weld", ["--cell", "ta1400_weld"]), ("line", ["--cell", "kr500_afp", "--axis", "all"])]
)
def test_a_study_is_what_its_old_words_made(name: str, before: list[str], tmp_path: Path, capsys) -> None:
    assert run(["study", name, "--out", str(tmp_path / "new"), "--json"]) == 0
    new = capsys.readouterr()
    assert run(["feed", *before, "--out", str(tmp_path / "old"), "--json"]) == 0
    old = capsys.readouterr()
    assert json.loads(new.out) == json.loads(old.out)
    assert "study" not in new.err and f"camrob study {name}" in old.err
    assert (tmp_path / "new" / "feed.html").is_file()


@pytest.mark.parametrize(
    ("name", "other", "file"),
    [
        ("line", "ta1400_weld", "published.toml"),
        ("calibration", "ta1400_weld", "published.toml"),
        ("weld", "kr500_afp", "seam.toml"),
        ("tracker", "kr500_afp", "tracker.toml"),
    ],
)
def test_a_study_refuses_a_cell_that_lacks_its_file(name: str, other: str, file: str, tmp_path: Path, capsys) -> None:
    assert run(["study", name, "--cell", other, "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert f"{other}" in said and file in said and said.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_an_unknown_study_is_refused_with_those_there_are(tmp_path: Path, capsys) -> None:
    assert run(["study", "carving", "--out", str(tmp_path / "out")]) == 2
    assert "take one of calibration, line, weld, tracker" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
