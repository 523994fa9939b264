"""A cell's digest covers every number of cell.toml, and nothing but what the file says."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from camrob.cell.read_cell import read_cell
from camrob.errors import CellError

CELLS = Path(__file__).resolve().parents[2] / "cells"
FOLDER = CELLS / "kr15_track_table"
# optional numbers that the shipped cell leaves out
TEXT = (
    (FOLDER / "cell.toml")
    .read_text(encoding="utf-8")
    .replace(
        "act_ex_ax = 2",
        "act_ex_ax = 2\ntool_number = 3\nbase_number = 4\ntool_change_pose = [5, -80, 70, 6, 60, 7, 50, 8]",
    )
)


def numbers() -> list[tuple[int, int, str]]:
    """Where (start, stop) each number of the file stands outside of comments and texts, and its line."""
    found = []
    at = 0
    for line in TEXT.splitlines(keepends=True):
        code = re.sub(r'"[^"]*"', lambda m: "x" * len(m[0]), line.split("#")[0])
        for match in re.finditer(r"(?<![\w.])-?\d+(?:\.\d+)?(?![\w.])", code):
            found.append((at + match.start(), at + match.end(), line.strip()))
        at += len(line)
    return found


def read(folder: Path, text: str) -> str:
    (folder / "cell.toml").write_text(text, encoding="utf-8")
    return read_cell(folder).digest


@pytest.mark.slow
def test_every_number_changes_the_digest(tmp_path: Path) -> None:
    """A number that the reader refuses to see changed (a schema, a sign) is refused; no change goes unseen."""
    own = read(tmp_path, TEXT)
    places = numbers()
    assert len(places) > 300
    unseen, refused = [], []
    for start, stop, line in places:
        old = TEXT[start:stop]
        value = float(old)
        other = None
        for changed in (value + (1 if "." not in old else 0.125), value - 1, -value or 5.0):
            new = str(int(changed)) if "." not in old else repr(changed)
            try:
                other = read(tmp_path, TEXT[:start] + new + TEXT[stop:])
                break
            except CellError:
                continue
        if other is None:
            refused.append((re.findall(r"\w+", TEXT[:start])[-1], line))
        elif other == own:
            unseen.append(line)
    assert unseen == []
    roll = "dh = { alpha_deg = 0, a_mm = 0, theta_deg = 0, d_mm = 0 }"  # that of the roll has to be all zeros
    assert all(key in ("schema", "sign", "act_ex_ax") or line == roll for key, line in refused), refused
    assert len(refused) < 12


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('spindle_on = [";spindle on", ', "spindle_on = ["),
        ('"$OUT[2] = TRUE"', '"$OUT[3] = TRUE"'),
        ("{speed} / 24000.0", "{speed} / 12000.0"),
        ('ori_type = "#VAR"', 'ori_type = "#CONSTANT"'),
        ('base_template = "EK(MACHINE_DEF[2].ROOT', 'base_template = "EK( MACHINE_DEF[2].ROOT'),
        ('E1 = "w_L", A3', 'A4 = "w_L", A3'),
        ('file = "weights_jnt.fis"', 'file = "weights_cond.fis"'),
        ('name = "roll"', 'name = "spin"'),
        ('ignore = ["A5", "tool"]', 'ignore = ["A5"]'),
        ('frame = "flange"', 'frame = "tool"'),
        ('after = "A4"', 'after = "A3"'),
    ],
)
def test_settings_change_the_digest(tmp_path: Path, old: str, new: str) -> None:
    assert old in TEXT
    assert read(tmp_path, TEXT) != read(tmp_path, TEXT.replace(old, new, 1))


def test_a_base_that_stands_changes_the_digest(tmp_path: Path) -> None:
    still = re.sub(r"(?m)^base_template.*\n", "", TEXT)
    texts = [still.replace("base_follows_table = true", f"base_follows_table = {v}") for v in ("false", "false\n# x")]
    assert read(tmp_path, TEXT) != read(tmp_path, texts[0]) == read(tmp_path, texts[1])


def test_what_says_the_same_has_the_same_digest(tmp_path: Path) -> None:
    own = read_cell(FOLDER).digest
    shutil.copytree(FOLDER, tmp_path / "elsewhere")
    assert read_cell(tmp_path / "elsewhere").digest == own
    text = (FOLDER / "cell.toml").read_text(encoding="utf-8")
    same = text.replace('standing = "assumed"', 'standing = "measured"').replace(
        "schema = 1", "# a remark\nschema = 1.0"
    )
    assert read(tmp_path, same.replace('title = "KUKA', 'title = "Our KUKA')) == own
    cells = [read_cell(p).digest for p in sorted(CELLS.iterdir()) if (p / "cell.toml").is_file()]
    assert len(set(cells)) == len(cells) >= 4
