"""Motions shorter than the controller's block time: said with their cost, and gone where the set-up lets points be left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camrob import PostResult, post
from camrob.jobs.verify import verify

CELL = Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table"
PLACE = "part_in_base = [0, 0, 300, 0, 0, 0]\nspindle_rpm = 10000\n"
FEED, COUNT, LENGTH = 4800.0, 601, 120.0  # mm/min; 0.2 mm apart: 2.5 ms a motion


def dense_file(folder: Path) -> Path:
    """A shallow wave, as finishing programs have it: far more points than 0.01 mm needs."""
    lines = [
        "TOOL PATH/WAVE,TOOL,BALL_6",
        "TLDATA/MILL,6.0,3.0,75.0,0.0,0.0",
        "MSYS/0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0",
        "RAPID",
        "GOTO/-60.0,0.0,60.0,0.0,0.0,1.0",
        f"FEDRAT/MMPM,{FEED}",
    ]
    x = np.linspace(-0.5 * LENGTH, 0.5 * LENGTH, COUNT)
    lines += [f"GOTO/{a:.4f},{np.sin(a / 20.0):.4f},0.0,0.0,0.0,1.0" for a in x]
    file = folder / "wave.cls"
    file.write_text("\n".join([*lines, "RAPID", "GOTO/60.0,0.0,60.0,0.0,0.0,1.0", "END-OF-PATH"]) + "\n")
    return file


def posted(folder: Path, more: str) -> tuple[Path, PostResult]:
    clfile = dense_file(folder)
    (folder / "setup.toml").write_text(PLACE + more)
    return clfile, post(clfile, cell=CELL, out=folder / "out", report=False)


@pytest.mark.slow
def test_short_motions_are_said_with_what_they_cost_and_thinned_where_the_setup_says_so(tmp_path: Path) -> None:
    (tmp_path / "plain").mkdir()
    (tmp_path / "thin").mkdir()
    _file, dense = posted(tmp_path / "plain", "")
    clfile, thin = posted(tmp_path / "thin", "decimate_mm = 0.01\n")
    feed = dense.summary.feed
    assert (
        feed.blocks.block_ms == 12.0
        and feed.blocks.short > 590
        and feed.blocks.shortest_ms == pytest.approx(2.5, rel=0.01)
    )
    assert feed.lost_by_axis_s["block time"] == pytest.approx(600 * 0.012 - LENGTH / (FEED / 60.0), abs=0.3)
    assert feed.kept_percent < 5.0
    said = next(w for w in dense.summary.warnings if w.code == "block-time")
    assert "12 ms" in said.text and "decimate_mm = 0.01" in said.text and said.line > 5
    better = thin.summary.feed
    assert better.blocks is None and better.lost_s < 0.2 and better.kept_percent > 50.0
    assert not [w for w in thin.summary.warnings if w.code == "block-time"]
    assert thin.summary.time_s.program < dense.summary.time_s.program - 4.0
    assert len(thin.program) < 0.2 * len(dense.program)
    # every point of the CL file within the tolerance of the thinned program, by the witness and by the replay
    for made in (dense, thin):
        assert made.summary.witness.complete and made.summary.witness.judged_points >= COUNT
    assert verify(tmp_path / "thin" / "out" / "wave.src", cell=CELL, against=clfile).ok
    assert (
        "block" not in (tmp_path / "plain" / "out" / "wave.src").read_text()
    )  # the program's text knows nothing of it
