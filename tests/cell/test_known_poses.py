"""poses.csv: a cell that misses its own known poses is not read, whatever reads it; nor is a file that says nothing clear."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from camrob.cell.read_cell import read_cell
from camrob.errors import CellError

CELLS = Path(__file__).resolve().parents[2] / "cells"
FOLDER = CELLS / "kr15_track_table"
TEXT = (FOLDER / "cell.toml").read_text(encoding="utf-8")
POSES = (FOLDER / "poses.csv").read_text(encoding="utf-8")
SAMPLE = CELLS.parent / "toolpaths" / "engraving" / "engraving.cls"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return Path(shutil.copytree(FOLDER, tmp_path / "cell"))


def changed(folder: Path, old: str, new: str) -> str:
    """What is said to a cell with one thing in cell.toml changed."""
    assert old in TEXT
    (folder / "cell.toml").write_text(TEXT.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(CellError) as caught:
        read_cell(folder)
    assert str(caught.value).startswith(f"{folder / 'poses.csv'}:")
    assert str(caught.value).isprintable()
    return str(caught.value)


def row(joint: str) -> str:
    block = TEXT[TEXT.index(f'name = "{joint}"\nrole') :]
    return f'name = "{joint}"\nrole' + block.split("role", 1)[1].split("home", 1)[0]


MISTAKES = [
    # (what is changed, the pose that shows it first, by how much it is off)
    ("a_mm = 155", "a_mm = 255", "home", "100.000 mm and 0.000 degrees off"),
    ("a_mm = 155", "a_mm = -155", "home", "310.000 mm and 0.000 degrees off"),
    ("a_mm = 155", "a_mm = 155.6", "home", "0.600 mm and 0.000 degrees off"),
    ("a_mm = 803", "a_mm = 806", "home", "3.000 mm and 0.000 degrees off"),
    ("-159.579784]", "159.579784]", "home", "0.000 mm and 40.840 degrees off"),
    ("-159.579784]", "-159.64]", "home", "0.060 degrees off"),
    (
        row("E2"),
        row("E2").replace("sign = 1, offset_deg = -180", "sign = -1, offset_deg = 180"),
        "table_90",
        "E2 is 180.000 degrees off its q",
    ),
    (row("E1"), row("E1").replace("sign = 1", "sign = -1"), "track_500", "E1 is 1000.000 mm off its q"),
    (row("A6"), row("A6").replace("sign = 1", "sign = -1"), "a6_90", "A6 is 180.000 degrees off its q"),
    (row("A3"), row("A3").replace("offset_deg = 90", "offset_deg = 89.9"), "home", "A3 is 0.100 degrees off its q"),
    (row("A2"), row("A2").replace("theta_deg = 0", "theta_deg = 45"), "home", "45.000 degrees off"),
    (row("A5"), row("A5").replace("alpha_deg = 90", "alpha_deg = -90"), "home", "degrees off"),
    ("characteristic_length_mm = 350.57", "characteristic_length_mm = 370", "home", "inv_kf is 0.5"),
]


@pytest.mark.parametrize(("old", "new", "pose", "said"), MISTAKES, ids=range(len(MISTAKES)))
def test_a_cell_that_misses_its_poses_is_refused(folder: Path, old: str, new: str, pose: str, said: str) -> None:
    message = changed(folder, old, new)
    assert f"pose {pose!r} " in message and said in message and "correct cell.toml or the row" in message


@pytest.mark.slow
def test_every_verb_refuses_it_with_one_line(folder: Path, tmp_path: Path) -> None:
    (folder / "cell.toml").write_text(TEXT.replace("a_mm = 155", "a_mm = 255"), encoding="utf-8")
    command = [
        sys.executable,
        "-m",
        "camrob.cli",
        "post",
        str(SAMPLE),
        "--cell",
        str(folder),
        "--out",
        str(tmp_path / "out"),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert f"{folder / 'poses.csv'}:2: pose 'home' " in done.stderr and "(and 12 more of the 13 poses)" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("bounds", "good"),
    [
        ("position_mm = 0.7", False),  # 1/k_F
        ("position_mm = 0.7\ninv_kf = 0.001", True),
        ("angle_deg = 0.3", False),
        ("position_mm = 0.7\nangle_deg = 0.0005", False),
        ("position_mm = 0.7\nangle_deg = 0.01\ninv_kf = 0.001", True),
    ],
)
def test_the_cell_may_set_its_own_bounds(folder: Path, bounds: str, good: bool) -> None:
    text = TEXT.replace("a_mm = 155", "a_mm = 155.6").replace("[load]", f"[poses]\n{bounds}\n\n[load]")
    (folder / "cell.toml").write_text(text, encoding="utf-8")
    if good:
        read_cell(folder)
    else:
        with pytest.raises(CellError, match="pose"):
            read_cell(folder)


@pytest.mark.parametrize(
    ("bounds", "said"),
    [
        ("position_mm = 1000", "poses.position_mm: is 1000; give a number from 1e-06 to 10"),
        ("angle_deg = 90", "poses.angle_deg: is 90; give a number from 1e-06 to 1"),
        ("angle_deg = 0", "poses.angle_deg: is 0"),
        ("angle = 1", "poses.angle: is not a key that camrob knows here"),
    ],
)
def test_bounds_that_find_nothing_are_refused(folder: Path, bounds: str, said: str) -> None:
    (folder / "cell.toml").write_text(TEXT.replace("[load]", f"[poses]\n{bounds}\n\n[load]"), encoding="utf-8")
    with pytest.raises(CellError) as caught:
        read_cell(folder)
    assert said in str(caught.value)


LINES = POSES.splitlines()
HEADER = LINES[0].split(",")


def with_cell(name: str, value: str, at: int = 1) -> str:
    """The file with one entry of the HOME row (or another) changed."""
    cells = LINES[at].split(",", len(HEADER) - 1)
    cells[HEADER.index(name)] = value
    return "\n".join([*LINES[:at], ",".join(cells), *LINES[at + 1 :]])


def without_columns(*names: str) -> str:
    """The file without some columns."""
    import csv
    import io

    rows = list(csv.reader(io.StringIO(POSES)))
    keep = [i for i, n in enumerate(rows[0]) if n not in names]
    out = io.StringIO()
    csv.writer(out).writerows([[r[i] for i in keep] for r in rows])
    return out.getvalue()


BAD_FILES = [
    ("", ": holds no pose; write a row for each, or remove the file"),
    (LINES[0], ": holds no pose"),
    (b"\xff\xfe\x00", ": is not UTF-8 text; save it as UTF-8"),
    ("pose,x_mm\n", ":1: 'pose' is not a column for this cell; use name, source, note, A1_deg"),
    (POSES.replace("E1_mm", "E3_mm", 1), ":1: 'E3_mm' is not a column for this cell"),
    (POSES.replace("E1_mm", "E1_deg", 1), ":1: 'E1_deg' is not a column for this cell"),
    (POSES.replace("tool_z_x", "inv_kf", 1), ":1: the column inv_kf appears twice; leave one"),
    (without_columns("c_deg"), ":1: the column c_deg is missing; give name, x_mm, y_mm, z_mm, a_deg, b_deg, c_deg"),
    (POSES + "more,1,2\n", ":15: has 3 columns where the first line has 32; correct that line"),
    (
        POSES + f"more{',0,5' * 20}\n",
        ":15: has 41 columns where the first line has 32; where decimals are written with commas",
    ),
    (
        POSES.replace(",", ";"),
        ":1: separates columns by semicolons; separate columns by commas, and write decimals with a point",
    ),
    (POSES.replace(",", "\t"), ":1: separates columns by tabs"),
    (with_cell("A1_deg", "zero"), ":2: pose 'home' has 'zero' as A1_deg; give a finite number, or leave it empty"),
    (with_cell("A1_deg", "nan"), ":2: pose 'home' has 'nan' as A1_deg"),
    (with_cell("x_mm", "1e999"), ":2: pose 'home' has '1e999' as x_mm"),
    (with_cell("A1_deg", ""), ":2: pose 'home' gives A2_deg without A1_deg; fill in both, or neither"),
    (with_cell("q_E1_m", ""), ":2: pose 'home' gives q_E2_rad without q_E1_m"),
    (with_cell("c_deg", ""), ":2: pose 'home' gives x_mm without c_deg"),
    (with_cell("tool_z_y", ""), ":2: pose 'home' gives tool_z_x without tool_z_y"),
    (with_cell("name", "", 3), ":4: a pose has no name; give it one"),
    (with_cell("name", "home", 3), ":4: pose 'home' appears twice"),
    (
        without_columns(*(n for n in HEADER if re.match(r"[AE]\d_|q_", n))),
        ":2: pose 'home' says nothing about the axes",
    ),
    (with_cell("source", '"spec'), ": is not CSV: "),
    ("a\0b\n" + POSES, "'a\\x00b' is not a column"),
    (with_cell("S", "0"), ":2: pose 'home' is not where cell.toml puts it: S is 2, not 0"),
    (with_cell("T", "3"), ":2: pose 'home' is not where cell.toml puts it: T is 2, not 3"),
    (with_cell("inv_kf", "0.5727"), "inv_kf is 0.5725, not 0.5727"),
    (with_cell("tool_z_y", "0.3600"), "its tool_z is 0."),
    (with_cell("tool_z_z", "-0.9372"), "its tool_z is "),
    (with_cell("tool_z_z", "0.9472"), "or no unit vector"),
    (with_cell("q_A3_rad", "0.001"), "A3 is 0.057 degrees off its q: sign or offset of the axis is not the file's"),
    (with_cell("y_mm", "-42.300", 1), "the tool is 0.536 mm and 0.000 degrees off, at X 97.000, Y -41.764, Z 619.422"),
]


@pytest.mark.parametrize(("content", "said"), BAD_FILES, ids=range(len(BAD_FILES)))
def test_bad_files_are_refused_by_line(folder: Path, content: str | bytes, said: str) -> None:
    (folder / "poses.csv").write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(CellError) as caught:
        read_cell(folder)
    message = str(caught.value)
    assert message.startswith(str(folder / "poses.csv")) and said in message
    assert message.isprintable() and "; " in message


def test_a_folder_in_its_place_is_no_file_of_poses(folder: Path) -> None:
    (folder / "poses.csv").unlink()
    (folder / "poses.csv").mkdir()
    with pytest.raises(CellError, match="can't be read"):
        read_cell(folder)


@pytest.mark.parametrize(
    "content",
    [
        POSES,
        "\ufeff" + POSES.replace("\n", "\r\n"),
        POSES + "\n\n",
        without_columns("source", "note", "inv_kf", "S", "T", "tool_z_x", "tool_z_y", "tool_z_z"),
        without_columns(*(n for n in HEADER if n.startswith("q_"))),
        without_columns(*(n for n in HEADER if re.match(r"[AE]\d_", n))),
        with_cell("note", '"over two\nlines"'),
    ],
    ids=range(7),
)
def test_good_files_are_taken(folder: Path, content: str) -> None:
    (folder / "poses.csv").write_text(content, encoding="utf-8", newline="")
    read_cell(folder)


@pytest.mark.parametrize("group", ["A", "q_"])
def test_either_group_of_axes_alone_finds_a_wrong_length(folder: Path, group: str) -> None:
    drop = [n for n in HEADER if (n.startswith("q_") if group == "A" else bool(re.match(r"[AE]\d_", n)))]
    (folder / "poses.csv").write_text(without_columns(*drop), encoding="utf-8")
    assert "100.000 mm" in changed(folder, "a_mm = 155", "a_mm = 255")


def test_axis_values_alone_find_a_wrong_sign(folder: Path) -> None:
    (folder / "poses.csv").write_text(without_columns(*(n for n in HEADER if n.startswith("q_"))), encoding="utf-8")
    wrong = row("E2").replace("sign = 1, offset_deg = -180", "sign = -1, offset_deg = 180")
    assert "pose 'table_90' " in changed(folder, row("E2"), wrong)


def test_a_cell_without_the_file_is_read(folder: Path) -> None:
    (folder / "poses.csv").unlink()
    (folder / "cell.toml").write_text(TEXT.replace("a_mm = 155", "a_mm = 255"), encoding="utf-8")
    read_cell(folder)


def test_the_rolls_column_is_its_roles(folder: Path) -> None:
    (folder / "cell.toml").write_text(TEXT.replace('name = "roll"', 'name = "spin"'), encoding="utf-8")
    assert read_cell(folder).names[-1] == "spin"
    (folder / "poses.csv").write_text(with_cell("q_roll_rad", "0.3"), encoding="utf-8")
    with pytest.raises(CellError, match=r"17\.189 degrees off"):
        read_cell(folder)


def test_s_is_nothing_without_a_spherical_wrist(folder: Path) -> None:
    text = TEXT.replace(row("A5"), row("A5").replace("d_mm = 0", "d_mm = 0.3"))
    (folder / "cell.toml").write_text(text, encoding="utf-8")
    with pytest.raises(CellError, match="pose 'home' has S, for which the wrist must be spherical; leave S empty"):
        read_cell(folder)
    (folder / "poses.csv").write_text(without_columns("S", "inv_kf"), encoding="utf-8")
    read_cell(folder)


@pytest.mark.parametrize("name", ["kr15_track_table", "kr500_afp", "rx160_tracker"])
@pytest.mark.parametrize("axis", ["A1", "A2", "A3", "A4", "A5", "A6"])
def test_shipped_poses_find_a_wrong_sense_of_every_axis(tmp_path: Path, name: str, axis: str) -> None:
    """A joint turned the other way about its own axis: its frame flipped by 180 degrees before and behind the motion."""
    folder = Path(shutil.copytree(CELLS / name, tmp_path / "cell"))
    text = (folder / "cell.toml").read_text(encoding="utf-8")
    start = text.index(f'[[joint]]\nname = "{axis}"')
    stop = text.index("\n[", start + 1)
    block = text[start:stop]
    offset = float(re.search(r"offset_deg = (-?[0-9.]+)", block)[1])
    sign = int(re.search(r"sign = (-?1)", block)[1])
    home = float(re.search(r"home_deg = (-?[0-9.]+)", block)[1])
    zero = sign * home + offset  # of the axis; q -> -q about HOME keeps HOME where it is
    block = block.replace(f"sign = {sign}", f"sign = {-sign}")
    block = re.sub(r"offset_deg = -?[0-9.]+", f"offset_deg = {zero + sign * home!r}", block)
    (folder / "cell.toml").write_text(text[:start] + block + text[stop:], encoding="utf-8")
    with pytest.raises(CellError, match="pose '"):
        read_cell(folder)


def test_random_lengths_that_are_off_are_found(folder: Path) -> None:
    """Any length of the chain, off by 1 mm, and any twist, off by 0.2 degrees, is found."""
    stop = TEXT.index('name = "roll"')
    places = [m for m in re.finditer(r"(alpha_deg|a_mm|theta_deg|d_mm) = (-?[0-9.]+)", TEXT) if m.start() < stop]
    assert len(places) == 32
    unseen = []
    for m in places:
        by = 1.0 if m[1].endswith("mm") else 0.2
        text = TEXT[: m.start(2)] + repr(float(np.round(float(m[2]) + by, 6))) + TEXT[m.end(2) :]
        (folder / "cell.toml").write_text(text, encoding="utf-8")
        try:
            read_cell(folder)
            unseen.append(m[0])
        except CellError as e:
            assert e.path == folder / "poses.csv"
    assert unseen == []
