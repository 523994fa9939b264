"""A program that camrob posted, compensated: what it was made from is said, and its moves in air are told from its cuts."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from calibration_sample import CELL, axis_values, calibrate_cell, drawn, measure
from gap_cases import KR15, bench_accuracy

from camrob import post, verify
from camrob.calibration.calibration_file import calibration_text
from camrob.errors import InputError
from camrob.jobs.closing.diagnosed_machine import DiagnosedMachine
from camrob.jobs.compensate import compensate
from camrob.jobs.release.beside import fastest_that_cuts
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.prediction.deflection import CAUSE

FEED, RAPID = bench_accuracy.FEED, 6000.0  # mm/min; the rapids' speed is the post's own


@pytest.fixture(scope="module")
def posted(tmp_path_factory) -> Path:
    """The program of a raster with approach and retract, beside its CL file and a calibration."""
    folder = tmp_path_factory.mktemp("posted")
    post(bench_accuracy.raster_file(folder, 1), cell=KR15, out=folder / "post", report=False)
    errors = calibrate_cell(CELL, measure(CELL, drawn(CELL), axis_values(CELL, 150)))
    (folder / "CALIBRATION.toml").write_text(calibration_text(errors))
    return folder / "post" / "raster.src"


def digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def test_its_manifest_goes_back_to_the_cl_file(posted: Path, tmp_path: Path) -> None:
    fitted = posted.parents[1] / "CALIBRATION.toml"
    (tmp_path / "force.toml").write_text("[mean]\nalong_n = -60\nacross_n = 0\naxial_n = 0\n")
    compensate(posted, cell=KR15, calibration=fitted, force=tmp_path / "force.toml", out=tmp_path / "out")
    made = json.loads((tmp_path / "out" / "raster.json").read_text())["manifest"]
    before = json.loads(posted.with_suffix(".json").read_text())["manifest"]
    assert made["cl_file"] == before["cl_file"] != {}
    assert (made["cell"], made["source"]) == (before["cell"], before["program"])
    assert made["program"]["raster.src"] == digest(tmp_path / "out" / "raster.src") != before["program"]["raster.src"]
    assert made["known"] == {"CALIBRATION.toml": digest(fitted), "force.toml": digest(tmp_path / "force.toml")}
    judged = verify(tmp_path / "out" / "raster.src", cell=KR15, collisions=False)
    assert not [f for f in judged.findings if "manifest" in f.code]
    data = tmp_path / "out" / "raster.dat"
    data.write_bytes(data.read_bytes() + b"\n")
    judged = verify(tmp_path / "out" / "raster.src", cell=KR15, collisions=False)
    assert [f.code for f in judged.findings if "manifest" in f.code] == ["manifest-differs"]


def test_one_whose_source_was_changed_by_hand_names_no_cl_file(posted: Path, tmp_path: Path) -> None:
    shutil.copytree(posted.parent, tmp_path / "post")
    by_hand = tmp_path / "post" / posted.name
    by_hand.write_text(by_hand.read_text() + ";by hand\n")
    compensate(by_hand, cell=KR15, calibration=posted.parents[1] / "CALIBRATION.toml", out=tmp_path / "out")
    made = json.loads((tmp_path / "out" / "raster.json").read_text())["manifest"]
    assert made["cl_file"] == {} and made["source"]["raster.src"] == digest(by_hand)
    assert fastest_that_cuts(by_hand, None) == np.inf


def test_its_rapids_are_no_cuts(posted: Path) -> None:
    text = read_krl(posted)
    speed = np.asarray(text.speed) * 6e4
    assert set(np.round(speed[speed > 0.0])) == {FEED, RAPID}
    said = json.loads(posted.with_suffix(".json").read_text())["feed"]["fastest_cut_mm_min"]
    assert said == pytest.approx(FEED)
    fastest = fastest_that_cuts(posted, None)
    machine = DiagnosedMachine(CELL, None, None, 0.0, "", fastest=fastest)
    assert np.array_equal(machine.cuts(text), np.isclose(speed, FEED))


@pytest.mark.slow
def test_a_force_that_bends_nothing_is_said(posted: Path, tmp_path: Path) -> None:
    """The calibration has no compliance; a tool that yields 1 um a newton is 60 um off across the feed, which is taken off."""
    fitted, force = posted.parents[1] / "CALIBRATION.toml", tmp_path / "force.toml"
    stiff = re.sub(r'\[\[parameter\]\]\nname = "A\d\.compliance"\n(\w+ = .*\n)+', "", fitted.read_text())
    (tmp_path / "stiff.toml").write_text(stiff)
    force.write_text("[mean]\nalong_n = 0\nacross_n = 60\naxial_n = 0\n")
    said = compensate(
        posted, cell=KR15, calibration=tmp_path / "stiff.toml", force=force, out=tmp_path / "none"
    ).summary
    assert [w.code for w in said.warnings if "force" in w.code] == ["force-bends-nothing"]
    assert said.machine is not None and CAUSE not in said.machine.causes
    force.write_text(force.read_text() + "[tool]\nacross_um_n = 1\nalong_um_n = 0\n")
    said = compensate(
        posted, cell=KR15, calibration=tmp_path / "stiff.toml", force=force, out=tmp_path / "gives"
    ).summary
    assert not [w for w in said.warnings if "force" in w.code]
    assert said.machine is not None and CAUSE in said.machine.causes


def test_a_fastest_cut_below_every_feed_is_refused(posted: Path, tmp_path: Path) -> None:
    force = tmp_path / "force.toml"
    force.write_text(f"fastest_cut_mm_min = {FEED / 2}\n[mean]\nalong_n = -60\nacross_n = 0\naxial_n = 0\n")
    with pytest.raises(InputError, match=rf"fastest_cut_mm_min = {FEED / 2:g} is below the feed of all that cuts"):
        compensate(posted, cell=KR15, force=force, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()
