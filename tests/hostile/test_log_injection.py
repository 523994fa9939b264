"""Texts of a LOG.toml stay text: no path out of the folder, nothing active in a report, one line wherever they are shown."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calibration_sample import axis_values, drawn, log_of, measure
from test_faults import PART
from test_injection import CELL, PAYLOADS, inert

from camrob import post
from camrob.cell.read_cell import read_cell
from camrob.errors import CamrobError
from camrob.jobs import diagnose as job
from camrob.jobs.calibrate import calibrate
from camrob.jobs.simulate import simulate
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo
from camrob.measurement.read_log import read_log
from camrob.measurement.write_log import write_log

MACHINE = read_cell(CELL)
SECRET = "DEF secret ( )\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0,E1 0,E2 0}\nEND\n"
TEXTS = ("script", "an image", "a style", "a template", "a newline", "right to left", "very long")


def quoted(text: str) -> str:
    return json.dumps(text.replace("\ud800", "X"))


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("log") / "poses.csv"
    write_log(log_of(MACHINE, measure(MACHINE, drawn(MACHINE), axis_values(MACHINE, 60))), file)
    return file


def beside(measured: Path, folder: Path, text: str) -> Path:
    """The same log, a text in every place that takes one."""
    folder.mkdir()
    log = folder / "poses.csv"
    log.write_bytes(measured.read_bytes())
    facts = measured.with_suffix(".toml").read_text()
    assert "note" not in facts
    log.with_suffix(".toml").write_text(
        facts + "".join(f"{k} = {quoted(text)}\n" for k in ("note", "instrument", "program"))
    )
    return log


@pytest.mark.parametrize("name", PAYLOADS)
def test_texts_are_one_line_or_refused_in_one(name: str, measured: Path, tmp_path: Path) -> None:
    log = beside(measured, tmp_path / "in", PAYLOADS[name])
    try:
        info = read_log(log).info
    except CamrobError as error:
        assert str(error).isprintable() and "poses.toml" in str(error) and len(str(error)) < 1500
        return
    assert all(text.isprintable() for text in (info.note, info.instrument, info.program))


@pytest.mark.parametrize("name", TEXTS)
def test_the_report_of_a_calibration_is_inert(name: str, measured: Path, tmp_path: Path) -> None:
    log = beside(measured, tmp_path / "in", PAYLOADS[name])
    try:
        calibrate(log, cell=CELL, out=tmp_path / "out" / "c.toml", parameters=["A2.zero", "A3.zero"])
    except CamrobError as error:
        assert str(error).isprintable() and not (tmp_path / "out").exists()
        return
    inert((tmp_path / "out" / "c.html").read_text(encoding="utf-8"))
    assert sorted(f.name for f in (tmp_path / "out").iterdir()) == ["c.html", "c.toml"]


@pytest.mark.parametrize(
    "program",
    [
        "../secret.src",
        "/etc/passwd",
        "..\\secret.src",
        "sub/secret.src",
        "C:\\secret.src",
        "..",
        ".",
        "link.src",
        "CON",
    ],
)
def test_a_log_names_no_program_outside_of_its_folder(program: str, tmp_path: Path) -> None:
    """Such a name is no program beside the log, and no error: one can be given by hand."""
    folder = tmp_path / "in"
    (folder / "sub").mkdir(parents=True)
    for place in (tmp_path, folder / "sub"):
        (place / "secret.src").write_text(SECRET)
    (folder / "link.src").symlink_to(tmp_path / "secret.src")
    columns = {"t": np.arange(3.0)} | {n: np.arange(3.0) for n in ("A1", "A2", "A3", "A4", "A5", "A6")}
    log = MeasurementLog(columns, LogInfo(program=program), folder / "log.csv")
    assert job._program(log, None, MACHINE) is None


def test_a_program_beside_the_log_is_found(tmp_path: Path) -> None:
    (tmp_path / "secret.src").write_text(SECRET)
    columns = {"t": np.arange(3.0)} | {n: np.arange(3.0) for n in ("A1", "A2", "A3", "A4", "A5", "A6")}
    found = job._program(MeasurementLog(columns, LogInfo(program="secret.src"), tmp_path / "log.csv"), None, MACHINE)
    assert found is not None and found.name == "SECRET"


@pytest.mark.slow
def test_the_report_of_a_diagnosis_is_inert(tmp_path: Path) -> None:
    """Also where the log's own name is active text."""
    (tmp_path / "setup.toml").write_text("part_in_base = [0, 0, 200, 0, 0, 0]\n")
    (tmp_path / "part.cls").write_text(PART)
    post(tmp_path / "part.cls", cell=CELL, out=tmp_path, report=False)
    log = tmp_path / 'run<script>alert(1)<-script>"onload=x.csv'
    simulate(tmp_path / "part.src", cell=CELL, out=tmp_path / "run.csv")
    facts = (tmp_path / "run.toml").read_text()
    assert 'program = "part.src"' in facts
    kept = "".join(f"{line}\n" for line in facts.splitlines() if not line.startswith(("note", "instrument")))
    texts = "".join(f"{key} = {quoted(PAYLOADS['script'] + PAYLOADS['an image'])}\n" for key in ("note", "instrument"))
    log.with_suffix(".toml").write_text(kept + texts)
    (tmp_path / "run.csv").rename(log)
    job.diagnose(cell=CELL, log=[log], out=tmp_path / "out")
    page = (tmp_path / "out" / "diagnosis.html").read_text(encoding="utf-8")
    inert(page)
    assert "<script>alert" not in page and "<img src=http" not in page
