"""`camrob regress`: what is the same is the same, and a planted change is reported with its size."""

from __future__ import annotations

import gzip
import json
import re
import shutil
from pathlib import Path

import pytest

from camrob.cli import app as cli
from camrob.errors import InputError
from camrob.jobs.regress import regress
from camrob.jobs.regressing.compare_program import compare_program
from camrob.jobs.regressing.compare_summary import compare_summary

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"


@pytest.fixture(scope="module")
def golden(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The engraving with golden files of its own, made now."""
    folder = tmp_path_factory.mktemp("samples")
    part = folder / "engraving"
    part.mkdir()
    for file in ("engraving.cls", "setup.toml", "stock.stl"):
        shutil.copy(ROOT / "toolpaths" / "engraving" / file, part / file)
    (folder / "making").mkdir()  # a folder without a CL file is no sample
    (folder / "making" / "engraving.py").write_text("raise SystemExit\n")
    first = regress(folder, cell=CELL)
    assert not first.ok
    assert first.summary.samples[0].differences == (
        "has no golden files; look at its program, then make them with --update",
    )
    assert not (part / "golden").exists()
    made = regress(folder, cell=CELL, update=True)
    assert made.ok and made.summary.updated
    return folder


@pytest.fixture
def samples(golden: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(golden, tmp_path / "samples"))


def test_a_second_run_is_as_before(samples: Path) -> None:
    files = {f.name: f.read_bytes() for f in (samples / "engraving" / "golden").iterdir()}
    assert set(files) == {"engraving.src", "engraving.dat", "engraving.json"}
    assert "seconds" not in json.loads(files["engraving.json"])
    result = regress(samples, cell=CELL)
    assert result.ok and [s.part for s in result.summary.samples] == ["engraving"]
    assert result.summary.samples[0].differences == ()
    regress(samples, cell=CELL, update=True)
    assert {f.name: f.read_bytes() for f in (samples / "engraving" / "golden").iterdir()} == files


def edited(samples: Path, file: str, pattern: str, replacement: str, count: int = 1) -> None:
    target = samples / "engraving" / "golden" / file
    text = target.read_bytes().decode()
    changed, times = re.subn(pattern, replacement, text, count=count)
    assert times == count and changed != text
    target.write_bytes(changed.encode())


@pytest.mark.parametrize(
    ("file", "pattern", "replacement", "message"),
    [
        ("engraving.src", r"Y 4\.027,Z 223\.000", "Y 4.127,Z 223.000", "moved most: Y by 0.1 mm"),
        ("engraving.src", r"E2 -4\.6295", "E2 355.3705", "E2 by 360"),
        ("engraving.src", r"\$VEL\.CP = 0\.025000", "$VEL.CP = 0.030000", "$VEL.CP by 0.005"),
        ("engraving.src", r" C_DIS\r\n", "\r\n", "1 changed"),
        ("engraving.src", r"LIN \{E6POS[^\n]*\n", "", "1 added"),
        ("engraving.src", r"(LIN \{E6POS[^\n]*\n)", r"\1\1", "1 removed"),
        ("engraving.src", r"; tool BALL_3", "; tool BALL_4", "1 changed"),
        ("engraving.src", r"Y 4\.027,Z 223\.000", "Y 4.0270,Z 223.000", "1 changed"),
        ("engraving.json", r'"revised": false', '"revised": true', "regions.1.revised was True, is False"),
        ("engraving.json", r'"inv_kf_mean": 0\.', '"inv_kf_mean": 0.1', "inv_kf_mean was 0.1"),
        ("engraving.json", r'"points": 899', '"points": 898', "points was 898, is 899 (+1)"),
        ("engraving.json", r'"singular": 0', '"singularities": 0', "singularities is gone (was 0)"),
        ("engraving.json", r'"code": "assumed-limits"', '"code": "assumed"', "'assumed-limits'"),
    ],
)
def test_a_planted_change_is_reported(samples: Path, file: str, pattern: str, replacement: str, message: str) -> None:
    edited(samples, file, pattern, replacement)
    result = regress(samples, cell=CELL)
    lines = result.summary.samples[0].differences
    assert not result.ok and not result.summary.samples[0].ok
    assert any(message in line and line.startswith(file) for line in lines), lines


def test_one_unit_in_the_last_decimal_is_no_difference(samples: Path) -> None:
    edited(samples, "engraving.src", r"Y 4\.027,Z 223\.000,A -138\.4634", "Y 4.028,Z 223.000,A -138.4633")
    edited(samples, "engraving.json", r'("inv_kf_mean": 0\.\d{9})\d+', r"\g<1>0")
    result = regress(samples, cell=CELL)
    assert result.ok and result.summary.samples[0].rounded == 2


def test_files_that_come_and_go(samples: Path) -> None:
    folder = samples / "engraving" / "golden"
    (folder / "engraving.dat").rename(folder / "engraving_001.src")
    lines = regress(samples, cell=CELL).summary.samples[0].differences
    assert "engraving.dat is new" in lines and "engraving_001.src is no longer made" in lines
    assert regress(samples, cell=CELL, update=True).ok
    assert not (folder / "engraving_001.src").exists()


def test_packed_programs_are_read(samples: Path) -> None:
    folder = samples / "engraving" / "golden"
    (folder / "engraving.src.gz").write_bytes(gzip.compress((folder / "engraving.src").read_bytes(), mtime=0))
    (folder / "engraving.src").unlink()
    assert regress(samples, cell=CELL).ok
    (folder / "engraving.src.gz").write_bytes(b"\x1f\x8b not packed at all")
    with pytest.raises(InputError, match="golden file; make it again"):
        regress(samples, cell=CELL)


@pytest.mark.slow
def test_a_sample_that_can_not_be_posted(samples: Path) -> None:
    setup = samples / "engraving" / "setup.toml"
    setup.write_text(setup.read_text().replace("[0, 0, 200, 0, 0, 0]", "[0, 0, 9000, 0, 0, 0]"))
    before = {f: f.read_bytes() for f in (samples / "engraving" / "golden").iterdir()}
    for update in (False, True):
        result = regress(samples, cell=CELL, update=update)
        assert not result.ok and not result.summary.updated
        assert "can no longer be posted" in result.summary.samples[0].differences[0]
    assert {f: f.read_bytes() for f in (samples / "engraving" / "golden").iterdir()} == before


def test_what_is_no_folder_of_samples(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is not a folder"):
        regress(tmp_path / "none", cell=CELL)
    with pytest.raises(InputError, match="holds no samples"):
        regress(tmp_path, cell=CELL)
    (tmp_path / "part").mkdir()
    for name in ("a.cls", "b.cls"):
        (tmp_path / "part" / name).write_text("FINI\n")
    with pytest.raises(InputError, match="several CL files"):
        regress(tmp_path, cell=CELL)


def test_the_command(samples: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["regress", str(samples), "--cell", str(CELL)]
    assert cli.run(command) == 0
    assert "all 1 samples come out as before" in " ".join(capsys.readouterr().out.split())
    edited(samples, "engraving.src", r"Y 4\.027,Z 223\.000", "Y 4.127,Z 223.000")
    assert cli.run(command) == 1
    printed = capsys.readouterr()
    assert printed.err == "" and "DIFFERS" in printed.out and "Y by 0.1 mm" in printed.out
    assert cli.run([*command, "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["samples"][0]["ok"] is False
    assert cli.run([*command, "--update", "--quiet"]) == 0
    assert cli.run(command) == 0


# ---- the comparison itself


def lines(*rows: str) -> str:
    return "".join(f"{row}\r\n" for row in rows)


def test_half_turns_of_an_angle_are_one() -> None:
    was, now = lines("LIN {E6POS: A 180.0000,E2 180.0000}"), lines("LIN {E6POS: A -180.0000,E2 180.0000}")
    assert compare_program("p", was, now).text == []
    assert compare_program("p", now, lines("LIN {E6POS: A -180.0000,E2 -180.0000}")).text  # E2 has turned, A has not


def test_numbers_within_names_are_words() -> None:
    assert compare_program("p", lines("$OUT[1] = TRUE"), lines("$OUT[2] = TRUE")).text
    assert compare_program("p", lines("P12 ( )"), lines("P13 ( )")).text
    assert compare_program("p", lines("WAIT SEC 3.0"), lines("WAIT SEC 3.5")).text


def test_dropped_points_of_a_long_program_are_found() -> None:
    rows = [f"LIN {{E6POS: X {0.1 * k:.3f},Y {k % 7}.000}}" for k in range(6000)]
    found = compare_program("p", lines(*rows), lines(*rows[:1000], *rows[1001:4000], *rows[4002:]))
    assert found.text[0] == "p: of 5998 lines 3 removed"
    assert any("X 100.000" in line for line in found.text)


def test_line_ends_count() -> None:
    assert "CR LF" in compare_program("p", "A\r\nB\r\n", "A\nB\n").text[0]


def test_summaries_by_meaning() -> None:
    was = {"a": 1.0, "b_mm": 5.0, "seconds": {"x": 1.0}, "collisions": {"sampled": "so", "count": 0}, "n": 3, "f": None}
    assert compare_summary(was, {**was, "seconds": {}, "collisions": {"sampled": "else", "count": 0}}) == []
    assert compare_summary(was, {**was, "b_mm": 5.0015, "a": 1.000005}) == []
    assert compare_summary(was, {**was, "b_mm": 5.01}) == ["b_mm was 5, is 5.01 (+0.01)"]
    assert compare_summary(was, {**was, "a": 1.001}) == ["a was 1, is 1.001 (+0.001)"]
    assert compare_summary(was, {**was, "n": 4}) == ["n was 3, is 4 (+1)"]
    assert compare_summary(was, {**was, "n": True}) == ["n was 3, is True"]
    assert compare_summary(was, {**was, "f": 0.0}) == ["f was None, is 0"]
    assert compare_summary(was, {**was, "new": "x"}) == ["new is new: 'x'"]


def test_the_shipped_samples_come_out_as_their_golden_files() -> None:
    """Whole programs and summaries of all samples; `camrob regress toolpaths --update` makes a meant change golden."""
    root = Path(__file__).resolve().parents[2]
    result = regress(root / "toolpaths", cell=root / "cells" / "kr15_track_table")
    assert result.ok, result.summary
    assert len(result.summary.samples) == 4
