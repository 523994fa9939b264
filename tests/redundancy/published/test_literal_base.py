"""A cell whose $BASE stands still: the table may move in void motions only."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from camrob import post
from camrob.controller.against import cover
from camrob.controller.judge import judge
from camrob.controller.replay import replay
from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.inputs import read_inputs
from camrob.languages.krl.reader.read_krl import read_krl

ROOT = Path(__file__).resolve().parents[3]
SAMPLE = ROOT / "toolpaths" / "engraving" / "engraving.cls"


@pytest.fixture(scope="module")
def literal_cell(tmp_path_factory):
    """The KR15 cell with a base that doesn't follow the table."""
    folder = tmp_path_factory.mktemp("cell") / "kr15_literal"
    shutil.copytree(ROOT / "cells" / "kr15_track_table", folder)
    text = (folder / "cell.toml").read_text()
    text = text.replace("base_follows_table = true", "base_follows_table = false")
    lines = [line for line in text.splitlines() if not line.startswith(("base_template", "act_ex_ax"))]
    (folder / "cell.toml").write_text("\n".join(lines) + "\n")
    return folder


def test_the_table_stands_while_cutting_and_the_base_is_literal(literal_cell, tmp_path):
    result = post(SAMPLE, cell=literal_cell, out=tmp_path / "out", report=False)
    text = (tmp_path / "out" / "engraving.src").read_text()
    assert "$BASE = {X 0" in text and "EK(" not in text
    cut = np.asarray(result.path.cutting)
    table = np.asarray(result.solution.q)[:, 0]
    assert np.all(np.diff(table)[cut[1:]] == 0.0)
    assert result.summary.external_travel["E2_deg"] == 0.0


def test_a_table_that_turns_while_cutting_is_refused(literal_cell, tmp_path):
    """The program of a following base, run on a cell whose base stands, must not pass."""
    turning = ROOT / "cells" / "kr15_track_table"
    post(SAMPLE, cell=turning, out=tmp_path / "out", report=False)
    inputs = read_inputs(SAMPLE, cell_for("post", literal_cell), None)
    program = read_krl(tmp_path / "out" / "engraving.src")
    replayed = replay(program, inputs.cell)
    own = inputs.path.of_toolpath
    coverage = cover(
        np.asarray(inputs.path.base_T_tip)[own],
        inputs.path.line[own],
        np.asarray(inputs.path.region[own], np.int64),
        np.asarray(replayed.base_T_tool),
        np.asarray(program.kind),
    )
    feed = np.where(inputs.path.cutting[own], inputs.path.feed[own], np.nan)
    judgement = judge(program, replayed, coverage, feed)
    assert not judgement.good
    codes = {f.code for f in judgement.findings}
    assert codes & {"table-in-cut", "cl-point-missed"}


def test_the_digest_tells_the_two_cells_apart(literal_cell):
    cell = read_inputs(SAMPLE, cell_for("post", literal_cell), None).cell
    assert cell.digest != replace(cell, base_follows_table=True).digest
