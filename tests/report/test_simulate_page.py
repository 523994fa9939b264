"""The page of a simulated run: what it says is what the log holds, and the postures put the tool where the log has it."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
from page_data import block_of, lines_of
from rich.console import Console

import camrob
from camrob.errors import InputError
from camrob.kinematics.frames import base_T_tool, world_T_base
from camrob.measurement.log import POSITION
from camrob.report.simulate.terminal_text import render_simulation

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells/kr15_track_table"
PROGRAM = ROOT / "toolpaths/engraving/golden/engraving.src"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, object]:
    folder = tmp_path_factory.mktemp("run")
    return folder, camrob.simulate(
        PROGRAM, cell=CELL, out=folder / "log.csv", report=folder / "run.html", cycle_ms=48.0
    )


def test_the_page_stands_beside_the_log_and_says_what_the_summary_says(made: tuple[Path, object]) -> None:
    folder, result = made
    assert result.summary.files == ("log.csv", "log.toml", "run.html")
    assert {f.name for f in folder.iterdir()} == set(result.summary.files)
    text = (folder / "run.html").read_text(encoding="utf-8")
    assert "It runs." in text and "<h1>Run of engraving</h1>" in text
    for cause, seconds in result.summary.feed.by_cause.items():
        assert cause in text and f"{seconds:.2f}" in text
    assert f"at program line {result.summary.approximation.line}" in text


def test_the_players_postures_are_the_logs(made: tuple[Path, object]) -> None:
    folder, _ = made
    run = block_of((folder / "run.html").read_text(encoding="utf-8"), "scene")["run"]
    log = camrob.read_log(folder / "log.csv")
    cell = camrob.read_cell(CELL)
    t = run["t"]
    q = run["q"].reshape(len(t), -1).astype(float)
    prismatic = [k for k, joint in enumerate(cell.joints) if joint.prismatic]
    q[:, prismatic] /= 1e3
    world_T_tip = world_T_base(cell, q) @ base_T_tool(cell, q)
    rows = np.searchsorted(log.columns["t"], t - 1e-3)
    logged = np.stack([log.columns[name][rows] for name in POSITION], axis=1)
    np.testing.assert_allclose(1e3 * world_T_tip[:, :3, 3], logged, atol=0.01)  # steps of 5e-6 rad
    line = log.columns["line"][rows].astype(int)
    assert all(
        said.startswith(f"engraving.src {k}: ") for said, k in zip(lines_of(run["said"]), line.tolist(), strict=True)
    )


def test_the_terminal_says_how_the_program_runs(made: tuple[Path, object]) -> None:
    said = io.StringIO()
    Console(file=said, width=120).print(render_simulation(made[1].summary))
    text = said.getvalue()
    assert (
        "Takes      2 min 00 s on the ideal controller, from HOME to HOME" in text
        and "97 rounded, at most 0.177 mm off (program line 234)" in text
    )
    assert "against the programmed speed (tool acceleration" in text and "acceleration: E1 100 %" in text
    assert "log.csv, log.toml, run.html; 2,492 rows, every 48 ms" in text


def test_what_is_no_page_is_refused_before_the_run(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"--report 'run.txt' is not a page's name"):
        camrob.simulate(PROGRAM, cell=CELL, out=tmp_path / "log.csv", report=tmp_path / "run.txt")
    assert not list(tmp_path.iterdir())


def test_a_cell_without_resolution_has_a_page_without_conditioning(tmp_path: Path) -> None:
    cell = tmp_path / "cell"
    cell.mkdir()
    for file in filter(Path.is_file, CELL.iterdir()):
        text = file.read_bytes()
        if file.name == "cell.toml":
            head, _, rest = text.decode().partition("[resolve]")
            after = [i for i in (rest.find("\n[controller"), rest.find("\n[[")) if i >= 0]
            text = (head + (rest[min(after) :] if after else "")).encode()
        (cell / file.name).write_bytes(text)
    result = camrob.simulate(PROGRAM, cell=cell, out=tmp_path / "log.csv", report=tmp_path / "run.html", cycle_ms=200.0)
    charts = [c["id"] for c in block_of((tmp_path / "run.html").read_text(encoding="utf-8"), "charts")]
    assert charts == ["feed", "axes", "external"] and json.dumps(result.summary.to_json())
