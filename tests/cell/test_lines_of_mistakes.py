"""A mistake in a TOML file is named by the line that it stands on, wherever the file's reader finds it."""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from camrob.cell.read_cell import read_cell
from camrob.cell.read_setup import read_setup
from camrob.errors import CamrobError, InputError
from camrob.jobs.batching.jobs_file import read_jobs
from camrob.jobs.closing.loop_file import read_loop_job
from camrob.jobs.files.cell_for import cell_for
from camrob.measurement.log_info import read_info
from camrob.measurement.table_facts import read_table_facts
from camrob.prediction.read_force import read_forces
from camrob.toml.key_line import key_line

ROOT = Path(__file__).parents[2]
KR15 = ROOT / "cells/kr15_track_table"
TEXT = (KR15 / "cell.toml").read_text(encoding="utf-8")

CELL = [
    ("base_follows_table = true", "base_follows_table = 1"),
    ("a_mm = 650", "a_mm = nan"),
    ("title = ", "titel = "),
    ("[tool]", "[tools]"),
    ('name = "E1"', 'name = "E7"'),
    ('name = "kr15_track_table"', 'name = ""'),
    ("speed_mm_s = 1000", "speed_mm_s = 0"),
    ('after = "A2"', 'after = "A7"'),
    ("center_mm = [-390, 0, 0]", "centre_mm = [-390, 0, 0]"),
    ('ignore = ["floor", "part", "stock"]', 'ignore = ["floor", "prat", "stock"]'),
    ('ignore = ["floor", "part", "stock"]', 'ignores = ["floor", "part", "stock"]'),
    ("acc_cp_m_s2 = 2", "acc_cp_m_s2 = 2000"),
    ("advance = 5", "advance = 7"),
    ("max_lines = 20000", "max_lines = 0"),
    ('ori_type = "#VAR"', 'ori_type = "VAR"'),
    ("spindle_rpm = [1000, 24000]", 'blending = "C_VEL"'),
    ("spindle_rpm = [1000, 24000]", 'entries = "yes"'),
    ("spindle_on = [", "spindle_on_cw = ["),
    ("{speed} / 24000.0", "{rpm} / 24000.0"),
    ("{speed} / 24000.0", "{ speed } / 24000.0"),
    ("{speed} / 24000.0", "{speed / 24000.0"),
    ('coolant_on = ["$OUT[2] = TRUE"]', 'coolant_on = ["$VEL.CP = 1"]'),
    ('weights = { E2 = "w_M"', 'weights = { E3 = "w_M"'),
]


def refused_at(file: Path, wrong: str, read: Callable[[], object]) -> None:
    """One line, by file and the line that `wrong` stands on, and with a cure."""
    with pytest.raises(InputError) as caught:
        read()
    line = file.read_text(encoding="utf-8").split(wrong)[0].count("\n") + 1
    message = str(caught.value)
    assert message.startswith(f"{file}:{line}: ") and "; " in message and "\n" not in message, message


@pytest.mark.parametrize(("right", "wrong"), CELL)
def test_of_a_cell(tmp_path: Path, right: str, wrong: str) -> None:
    folder = shutil.copytree(KR15, tmp_path / "cell")
    (folder / "cell.toml").write_text(TEXT.replace(right, wrong, 1), encoding="utf-8")
    refused_at(folder / "cell.toml", wrong, lambda: cell_for("post", folder))


OTHERS = {
    "setup.toml": (
        'units = "mm"\n[[tool]]\nnumber = 1\ndiameter_mm = 3\n[[tool]]\nnumber = 2\nlength_mm = 80\n',
        lambda file: read_setup(file, read_cell(KR15)),
        (('units = "mm"', 'units = "MM"'), ("length_mm = 80", "lenght_mm = 80"), ("number = 2", "number = 1 # too")),
    ),
    "FORCE.toml": (
        "[mean]\nalong_n = -5\nacross_n = 3\naxial_n = 10\n",
        read_forces,
        (("axial_n = 10", "axial_n = nan"), ("along_n = -5", "allong_n = -5")),
    ),
    "JOB.toml": (
        'toolpath = "a.cls"\ncell = "kr15_track_table"\ntolerance_mm = 0.1\n[machine]\nnoise_mm = 0.02\n',
        read_loop_job,
        (("noise_mm = 0.02", "noise_mm = -1"), ("tolerance_mm = 0.1", "tolerance = 0.1")),
    ),
    "JOBS.toml": (
        '[[job]]\nclfile = "a.cls"\ncell = "kr15_track_table"\nout = "a"\nmethod = "vjm"\n',
        read_jobs,
        (('out = "a"', 'out = "../a"'), ('method = "vjm"', 'method = "fast"')),
    ),
    "LOG.toml": (
        'target = "tool"\nsigma_mm = 0.02\n[table]\nseparator = ";"\n'
        '[table.columns]\nt = "time"\nA1 = { column = "j", unit = "rad" }\n',
        lambda file: (read_info(file), read_table_facts(file)),
        (
            ("sigma_mm = 0.02", "sigma = 0.02"),
            ("[table]", "[Table]"),
            ('separator = ";"', 'separator = ":"'),
            ('t = "time"', "t = -1"),
            ('unit = "rad"', 'unit = "grad"'),
        ),
    ),
}


@pytest.mark.parametrize("name", OTHERS)
def test_of_other_files(tmp_path: Path, name: str) -> None:
    text, read, mistakes = OTHERS[name]
    for right, wrong in mistakes:
        (tmp_path / name).write_text(text.replace(right, wrong, 1), encoding="utf-8")
        refused_at(tmp_path / name, wrong, lambda: read(tmp_path / name))


def test_lines_of_keys(tmp_path: Path) -> None:
    file = tmp_path / "any.toml"
    rows = [
        "# head",  # 1
        "top = 1",
        "list = [  # of",
        "  1, # a ] in a remark",
        "  2,",
        "]",
        'text = """',
        "[not.a.table]",
        '"""',
        "[a.b]",  # 10
        '"x y".z = { one = 1, two = [2] }',
        "[[c]]",
        "k = 1",
        "[[c]]",
        "k = 2",
        "[c.d]",
        "k = 3",
        "[[c.e]]",
        "k = 4",
    ]
    file.write_text("\r\n".join(rows), encoding="utf-8")
    tomllib.loads(file.read_text(encoding="utf-8"))
    for place, line in {
        ("top",): 2,
        ("list",): 3,
        ("text",): 7,
        ("a", "b"): 10,
        ("a", "b", "x y", "z", "two"): 11,
        ("a", "missing"): 10,
        ("c", 0, "k"): 13,
        ("c", 1, "k"): 15,
        ("c", 1, "missing"): 14,
        ("c", 1, "d", "k"): 17,
        ("c", 1, "e", 0, "k"): 19,
        ("missing",): 0,
    }.items():
        assert key_line(file, place) == line, place
    assert key_line(tmp_path / "none.toml", ("top",)) == 0


def test_a_file_that_names_no_line_is_named(tmp_path: Path) -> None:
    (tmp_path / "FORCE.toml").write_text("", encoding="utf-8")
    with pytest.raises(CamrobError, match=r"FORCE\.toml: mean: is missing"):
        read_forces(tmp_path / "FORCE.toml")
