"""A cell whose first axis has too little room: postures stand at its limit, and between them the arm keeps it too."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camrob import post
from camrob.errors import UnreachableError, VerificationError

ROOT = Path(__file__).resolve().parents[3]
CELL, ENGRAVING = ROOT / "cells" / "kr15_track_table", ROOT / "toolpaths" / "engraving" / "engraving.cls"


@pytest.mark.parametrize("upper", [8, 12])
def test_a_part_that_takes_the_first_axis_to_its_limit_is_posted_by_the_spare_freedoms(
    tmp_path: Path, upper: int
) -> None:
    """A1 goes to 20 degrees where it may; the file's arcs took it 1.5 degrees past a limit that all points keep."""
    narrow = tmp_path / "cell"
    shutil.copytree(CELL, narrow, ignore=shutil.ignore_patterns("golden", "poses.csv"))
    text = (narrow / "cell.toml").read_text(encoding="utf-8")
    wide = "range_deg = [-185, 185]"
    (narrow / "cell.toml").write_text(text.replace(wide, f"range_deg = [-185, {upper}]", 1), encoding="utf-8")
    result = post(ENGRAVING, cell=narrow, out=tmp_path / "out", report=False)
    first = np.degrees(np.asarray(result.solution.q)[:, 2]) - 180.0
    assert upper - 0.1 < first.max() < upper
    said = [f.text for f in result.findings if f.code == "arcs-as-lines"]
    assert len(said) == 1
    assert said[0].startswith(
        "the arcs of region ENGRAVE are written as lines: with arcs, A1 passes its limit by up to 1.5"
    )
    assert "\nCIRC " not in (tmp_path / "out" / "engraving.src").read_text(encoding="ascii")
    assert result.summary.limits.violations == 0  # along the whole text, between its points too


def test_an_axis_that_passes_its_limit_on_a_line_is_kept_further_from_it(tmp_path: Path) -> None:
    narrow = tmp_path / "cell"
    shutil.copytree(CELL, narrow, ignore=shutil.ignore_patterns("golden", "poses.csv"))
    text = (narrow / "cell.toml").read_text(encoding="utf-8")
    assert text.count("range_deg = [-120, 160]") == 1
    (narrow / "cell.toml").write_text(text.replace("[-120, 160]", "[-120, 125]"), encoding="utf-8")
    result = post(ENGRAVING, cell=narrow, out=tmp_path / "out", report=False)
    said = [f.text for f in result.findings if f.code == "kept-from-limit"]
    assert said == ["A3 was kept further from its limit, which it passed between points that keep it"]
    least = result.summary.limits.margin_min["A3"]
    assert least is not None
    assert 0.0 < least < 0.3  # degrees, along the whole text: no further than it has to be


def test_where_no_way_is_left_so_far_from_it_the_limit_is_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The job solved again may fail for a reason that nobody would have met."""
    import camrob.jobs.release.first_free as job

    real = job.resolve_job

    def narrowed(*arguments: Any, further: dict[str, float], **named: Any) -> Any:
        if further:
            raise UnreachableError("no posture of the cell reaches this point")
        return real(*arguments, further=further, **named)

    monkeypatch.setattr(job, "resolve_job", narrowed)
    narrow = tmp_path / "cell"
    shutil.copytree(CELL, narrow, ignore=shutil.ignore_patterns("golden", "poses.csv"))
    text = (narrow / "cell.toml").read_text(encoding="utf-8").replace("[-120, 160]", "[-120, 125]")
    (narrow / "cell.toml").write_text(text, encoding="utf-8")
    with pytest.raises(VerificationError, match="A3 passes its limit"):
        post(ENGRAVING, cell=narrow, out=tmp_path / "out", report=False)
